"""Photon maps: hardly any photons, all of them in one place, and none where one looks."""

from dataclasses import replace

import pytest
import trimesh
from cases import assert_same, means, rendered
from helpers.marks import slow
from helpers.scenes import GREY, balls_in_box, quad

import photonmap as pm
from photonmap.integrators.photon_mapping import cache_tracer, caustics

BOX = pm.scenes.cornell_box()
BALLS = balls_in_box()
FLOOR = quad((-2, 0, -2), (-2, 0, 2), (2, 0, 2), (2, 0, -2), GREY, "floor")
CUT = pytest.mark.filterwarnings("ignore:[0-9]* of [0-9]* photons were truncated")


@pytest.fixture(scope="module")
def truth():
    """Indirect light of the Cornell box by plain paths."""
    return means(BOX, "indirect", method="path", passes=8)


@pytest.mark.parametrize("photons", [10, *slow(1, 20_000)])
def test_any_number_of_photons(photons, truth):
    """Where they are few, cells are so large that paths answer in their place."""
    values = means(BOX, "indirect", photons=photons, passes=2)
    assert_same(values, truth, slack=0.02)


@CUT
@pytest.mark.parametrize("photons", [1, 10])
def test_any_number_of_photons_for_caustics(photons):
    rendered(BALLS, photons=photons)


def spot(position, target, angle):
    return pm.SpotLight(position, target, 10.0, angle, angle)


@pytest.mark.slow
def test_all_photons_in_one_point():
    """A spot of a thousandth of a degree lights one point of the floor, and that the room.

    As much as one of a tenth does, for its power. The path tracer never finds the point.
    """
    lit = {}
    for angle in (1e-3, 0.1):
        narrow = pm.Scene(
            [mesh for mesh in BOX.meshes if mesh.name != "light"],
            [spot((0, 0.9, 0.6), (0, -1, 0.6), angle)],
            BOX.camera,
        )
        lit[angle] = means(narrow, "indirect", passes=2) / angle**2
    assert_same(lit[1e-3], lit[0.1], slack=0.01)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:lights? .* sends? nothing into the view")
def test_all_photons_on_one_line():
    """A sun through a slit."""
    lids = [quad((-2, 1, a), (-2, 1, b), (2, 1, b), (2, 1, a), GREY, "lid")
            for a, b in ((-2, -0.002), (0.002, 2))]  # fmt: skip
    scene = pm.Scene([FLOOR, *lids], [pm.DirectionalLight((0, -1, 0), 100.0)],
                     pm.Camera((0, 0.5, 1.9), (0, 0, 0), fov=70))  # fmt: skip
    values, wanted = (
        means(scene, "indirect", method=m, photons=50_000) for m in ("photon", "path")
    )
    assert_same(values, wanted, slack=0.02)


@pytest.mark.slow
def test_all_photons_on_one_triangle():
    """A panel of one triangle catches a spot's light: what else is lit, by way of the ceiling."""
    panel = pm.Mesh([[-0.5, 1, -0.5], [0, 1, 0.5], [0.5, 1, -0.5]], [[0, 1, 2]], GREY, "panel")
    ceiling = replace(FLOOR, vertices=FLOOR.vertices + [0, 2, 0])
    scene = pm.Scene([FLOOR, panel, ceiling], [spot((0, 1.5, 0), (0, 0, 0), 10.0)],
                     pm.Camera((0, 0.5, 3), (0, 0.4, 0), fov=60))  # fmt: skip
    settings = {"photons": 16384, "size": (16, 16)}
    values, wanted = (means(scene, method=m, **settings) for m in ("photon", "path"))
    assert values.all()
    assert_same(values, wanted, slack=0.02)


@CUT
@pytest.mark.parametrize("radius", [1e-9, *slow(0.5, 100.0)])
def test_disks_of_caustics_far_too_small_or_too_large(radius, monkeypatch):
    """Sound, and where they are too small on average right: but hardly one pixel meets a photon."""
    monkeypatch.setattr(caustics, "_first_radius", lambda positions, arriving: radius)
    rendered(BALLS)


@pytest.mark.slow
@pytest.mark.parametrize("share", [1e-6, 1e6])
def test_cells_far_too_large_or_too_small(share, monkeypatch, truth):
    """Large ones never answer; small ones answer with noise that their errors tell of."""
    monkeypatch.setattr(cache_tracer, "STORES_PER_CELL", max(1.0 / share, 1e-3))
    monkeypatch.setattr(cache_tracer, "MOST_CELLS_PER_PHOTON", 50.0)
    values = means(BOX, "indirect", passes=4)
    assert_same(values, truth, slack=0.02)


def test_a_view_that_photons_hardly_reach():
    """Behind a pinhole, a sky's light is too rare for photons, and the warning says so."""
    room = trimesh.creation.box(bounds=[[-1, -1, -1], [1, 1, 1]])
    ticks = [-1.0, -0.001, 0.001, 1.0]
    lid = [quad((-1, 1, a), (-1, 1, b), (1, 1, b), (1, 1, a), GREY, "lid")
           for a, b in ((ticks[0], ticks[1]), (ticks[2], ticks[3]))]  # fmt: skip
    lid += [quad((a, 1, -1e-3), (a, 1, 1e-3), (b, 1, 1e-3), (b, 1, -1e-3), GREY, "lid")
            for a, b in ((ticks[0], ticks[1]), (ticks[2], ticks[3]))]  # fmt: skip
    walls = room.faces[room.face_normals[:, 1] < 0.5][:, ::-1]
    scene = pm.Scene([pm.Mesh(room.vertices, walls, GREY, "room"), *lid],
                     [pm.DomeLight(1.0)], pm.Camera((0, 0, 0.9), (0, -1, 0), fov=60))  # fmt: skip
    with pytest.warns(pm.SceneWarning, match="no photon was found for|sends nothing into the view"):
        result = rendered(scene)
    assert result.coverage.all()
