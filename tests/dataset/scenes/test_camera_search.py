"""Where cameras of rooms stand: what is composed well is worth more."""

import numpy as np
import pytest

from photonmap.dataset.models.garments import SPACING, garment
from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.scene_object import multi_part, overlap
from photonmap.dataset.models.shapes import box
from photonmap.dataset.scenes.rooms import camera_search
from photonmap.dataset.scenes.rooms.groups import framed, posters, row_of_pictures
from photonmap.dataset.scenes.rooms.room_builder import Group, RoomBuilder
from photonmap.scene.material import Material

ROWS, COLUMNS = 45, 60
TOP, LEFT = 15, 20
"""First row and column of the image in the field around it."""
KINDS = camera_search._Kinds(np.array([0, 1]), np.array([True, False]))


def random(seed=0):
    return np.random.Generator(np.random.PCG64(seed))


def worth(first, second, floor=0):
    """What a camera is worth that sees two objects, given as rows and columns of the image.

    The lowest rows of the image are floor.
    """
    objects = np.full((ROWS, COLUMNS), -1)
    for number, (row, column) in enumerate((first, second)):
        objects[TOP + row : TOP + row + 6, LEFT + column : LEFT + column + 7] = number
    open_floor = np.zeros((ROWS, COLUMNS), bool)
    open_floor[TOP : TOP + floor] = True
    distances = np.full((ROWS, COLUMNS), 3.0)
    return camera_search._worth(camera_search._Outlook(objects, distances, open_floor), KINDS)


def test_rays_cover_the_image_of_a_camera():
    """The angle of view is the vertical one; outermost rays are half a ray from the edges."""
    columns, rows = camera_search._RAYS
    ways = camera_search.directions(np.array([0.0, 0.0, -1.0]), 60.0).reshape(rows, columns, 3)
    across, up = np.abs(ways[0, 0, :2] / ways[0, 0, 2])
    assert up == pytest.approx(np.tan(np.radians(30.0)) * (1.0 - 1.0 / rows))
    assert across == pytest.approx(columns / rows * np.tan(np.radians(30.0)) * (1.0 - 1 / columns))
    wide = camera_search.directions(np.array([0.0, 0.0, -1.0]), 60.0, 3)
    inner = wide.reshape(3 * rows, 3 * columns, 3)[rows : 2 * rows, columns : 2 * columns]
    np.testing.assert_allclose(inner, ways, atol=1e-12)


def test_what_is_cut_is_worth_less():
    whole = worth((4, 2), (4, 12))
    other_cut, subject_cut = worth((4, 2), (4, 16)), worth((4, -3), (4, 12))
    assert whole > other_cut > subject_cut > 0.0


def test_bare_walls_are_worth_less_than_floor():
    assert worth((4, 2), (4, 12), floor=4) > worth((4, 2), (4, 12))


def test_bare_walls_are_dressed():
    room = RoomBuilder(Draw(random()), 4.0, 5.0, 2.6)
    tall = multi_part("wardrobe", [box(3.0, 2.0, 0.6)], [Material()])
    assert room.place_at_wall(Group([tall]))
    room.dress((framed, posters, row_of_pictures))
    objects = [obj for obj in room._objects if obj.name == "picture"]
    sides = {
        (axis, obj.bounds[0, axis] > 0.0)
        for obj in objects
        for axis in (0, 2)
        if np.ptp(obj.bounds[:, axis]) < 0.1
    }
    assert len(sides) >= 3, "on all walls but that of the wardrobe"
    for number, each in enumerate(objects):
        assert each.bounds[0, 1] > 0.8
        assert each.bounds[1, 1] < 2.3
        assert not any(overlap(each.boxes, other.boxes) for other in objects[:number])


@pytest.mark.parametrize("seed", range(20))
def test_garments_have_room_between_hooks_and_wall(seed):
    boxes = np.stack([p.shape.bounds for p in garment(Draw(random(seed)))])
    assert np.abs(boxes[:, :, 0]).max() < 0.5 * SPACING
    assert boxes[:, 0, 2].min() > -0.085, "the wall is as far behind"
    assert boxes[:, 1, 1].max() < 0.05
