"""Generated rooms: seeds differ as much as kinds do, ways stay free, cameras see the main group."""

import numpy as np
import pytest
from helpers.generated import appearance, lit, unlit
from helpers.marks import slow

from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.scene_object import multi_part, overlap
from photonmap.dataset.models.shapes import box
from photonmap.dataset.report.diversity import appearance_of, correlations, nearest_neighbours
from photonmap.dataset.scenes.rooms.catalogue import FURTHER_KINDS, KINDS, ROOMS
from photonmap.dataset.scenes.rooms.room_builder import FloorPlan, Group, RoomBuilder
from photonmap.errors import InputError
from photonmap.scene.material import Material
from photonmap.scene.scene import Scene

SEEDS = range(4)
DIFFERENT = 0.58
"""Median correlation of depth between nine rooms that were laid out by hand."""
ONE_SCENE = 0.9
"""Least correlation of the maps of one layout in other colours, as seeds once had."""


def random(seed=0):
    return np.random.Generator(np.random.PCG64(seed))


def block(wide, tall, deep):
    return multi_part("block", [box(wide, tall, deep)], [Material()])


@pytest.mark.slow
@pytest.mark.parametrize("what", ["depth", "reflectance"])
def test_seeds_differ_as_much_as_kinds_of_rooms(what):
    seeds = [getattr(appearance("kitchen", seed), what) for seed in SEEDS]
    others = [getattr(appearance(kind), what) for kind in list(ROOMS)[::2]]
    assert np.median(nearest_neighbours(seeds)) < np.median(nearest_neighbours(others)) + 0.15
    pairs = correlations(seeds)[np.triu_indices(len(seeds), 1)]
    assert pairs.max() < ONE_SCENE
    assert np.median(pairs) < DIFFERENT


def test_colours_alone_are_no_diversity():
    other = appearance_of(lit("bathroom", 0, "colored")).depth
    np.testing.assert_allclose(nearest_neighbours([appearance("bathroom").depth, other]), 1.0)


def test_appearance_needs_a_camera():
    with pytest.raises(InputError, match="has no camera; give it one"):
        appearance_of(Scene(lit("castle").meshes))


def walls_of(made):
    """The extent of a room along each axis, metres."""
    return np.ptp(next(o for o in made.objects if o.name == "walls").bounds, axis=0)


@pytest.mark.parametrize("name", [*KINDS, *slow(*FURTHER_KINDS)])
def test_rooms_have_a_door_and_windows_and_vary_in_size(name):
    least, most = np.transpose((KINDS | FURTHER_KINDS)[name].size)
    assert (most > least).all()
    assert (most - least).max() > 0.5
    made = unlit(name)
    names = [obj.name for obj in made.objects]
    assert names.count("door") == 1
    assert "window" in names
    size = walls_of(made)[[0, 2, 1]]
    assert (size > least - 1e-6).all()
    assert (size < most + 1e-6).all()


def test_seeds_differ_in_size_and_camera():
    first, second = unlit("kitchen"), unlit("kitchen", 1)
    assert (np.abs(walls_of(first) - walls_of(second)) > 0.0).all()
    assert first.camera != second.camera


def test_a_floor_stays_in_one_piece():
    plan = FloorPlan(4.0, 3.0)
    wall = np.array([[[-0.1, 0.0, -1.5], [0.1, 1.0, 1.5]]])
    gap = np.array([[[-0.1, 0.0, -1.5], [0.1, 1.0, 0.5]]])
    assert not plan.leaves_ways(wall)
    assert plan.leaves_ways(gap)
    assert plan.leaves_ways(wall + (0.0, 2.0, 0.0)), "what hangs overhead is passed beneath"
    before = len(plan.standing_places())
    plan.occupy(gap)
    assert len(plan.standing_places()) < before
    assert not plan.leaves_ways(np.array([[[-0.1, 0.0, 0.0], [0.1, 1.0, 1.5]]]))


def test_standing_places_are_clear():
    plan = FloorPlan(4.0, 3.0)
    plan.occupy(np.array([[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]]))
    places = plan.standing_places()
    away = np.maximum(np.maximum(-places, places - 1.0), 0.0)
    assert np.abs(away).max(axis=1).min() > 0.15
    assert np.abs(places).max(axis=0) == pytest.approx([1.8, 1.3], abs=0.1)


def test_access_stays_free():
    room = RoomBuilder(Draw(random()), 3.0, 3.0, 2.5)
    assert room.place_at_wall(Group([block(2.9, 1.0, 0.4)], access=2.5))
    assert not room.place_free(Group([block(0.5, 0.5, 0.5)]))


def test_what_is_too_large_is_left_out():
    room = RoomBuilder(Draw(random()), 3.0, 3.0, 2.5)
    assert not room.place_at_wall(Group([block(3.5, 1.0, 0.4)]))
    assert not room.place_at_wall(Group([block(0.5, 2.6, 0.4)]))
    assert not room.hang([block(3.5, 0.2, 0.1)], (1.0, 1.2))
    assert not room.add_window("back", (0.9, 4.0, 1.0), False)
    assert room.add_window("back", (0.9, 2.6, 1.0), False)
    assert not room.add_window("back", (0.9, 2.6, 1.0), False)


@pytest.mark.parametrize(
    "places", [*slow([("corridor", 0), ("corridor", 1)]), [(name, 0) for name in KINDS]]
)
def test_nothing_hangs_in_front_of_pictures(places):
    """Such as coats on a rack: nothing is within 10 cm in front of what hangs on a wall."""
    hung = 0
    for name, seed in places:
        objects = unlit(name, seed).objects
        others = [o for o in objects if o.name not in ("walls", "picture", "ceiling", "window")]
        for picture in (obj for obj in objects if obj.name == "picture"):
            bounds = picture.bounds[None].copy()
            normal = 2 * int(np.ptp(bounds[0, :, 2]) < np.ptp(bounds[0, :, 0]))
            bounds[0, :, normal] += -0.1, 0.1
            hung += 1
            assert not [obj.name for obj in others if overlap(bounds, obj.boxes)]
    assert hung > 3
