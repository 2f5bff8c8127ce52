"""Shapes are closed and wound outwards; patterns cut them without loss."""

import numpy as np
import pytest
import trimesh

from photonmap.dataset.models import patterns, shapes, small_objects
from photonmap.dataset.models.materials import Draw, Palette, chips
from photonmap.dataset.models.shapes import Shape, joined
from photonmap.dataset.models.small_objects import ring_tower
from photonmap.errors import InputError


def random(seed=0):
    return np.random.Generator(np.random.PCG64(seed))


def welded(shape):
    """The shape with vertices at one place made one."""
    mesh = trimesh.Trimesh(np.round(shape.vertices, 9), shape.faces, process=False)
    mesh.merge_vertices(merge_norm=True)
    return mesh


CLOSED = {
    "box": lambda: shapes.box(0.4, 0.2, 0.3, 0.03),
    "sharp box": lambda: shapes.box(0.4, 0.2, 0.3, 0.2, 1),
    "cylinder": lambda: shapes.cylinder(0.1, 0.3),
    "cone": lambda: shapes.cone(0.1, 0.01, 0.3),
    "torus": lambda: shapes.torus(0.2, 0.05),
    "sphere": lambda: shapes.sphere(0.2),
    "lump": lambda: shapes.lump(random(), 0.2),
    "superquadric": lambda: shapes.superquadric((0.2, 0.3, 0.2), 0.3, 0.4),
    "star": lambda: shapes.superquadric((0.2, 0.3, 0.2), 1.6, 1.5),
    "knot": lambda: shapes.knot(0.2, 0.05),
    "tube": lambda: shapes.tube([(0, 0, 0), (0.2, 0.1, 0), (0.3, 0.4, 0)], 0.02),
    **{f"vase {k}": lambda k=k: small_objects.vase_shape(random(k), 0.3, k) for k in range(4)},
    "bowl": lambda: small_objects.bowl_shape(random(), 0.15),
    "pot": lambda: small_objects.pot_shape(random(), 0.2),
    "cup": lambda: small_objects.cup_shapes(random(), 0.1)[0],
    "handle": lambda: small_objects.cup_shapes(random(), 0.1)[1],
}


@pytest.mark.parametrize("make", CLOSED.values(), ids=CLOSED)
def test_closed_and_outward(make):
    shape = make()
    mesh = welded(shape)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0
    np.testing.assert_allclose(np.linalg.norm(shape.normals, axis=1), 1.0, atol=1e-12)
    corners = shape.vertices[shape.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.linalg.norm(across, axis=1).min() > 0
    assert (np.einsum("fi,fki->fk", across, shape.normals[shape.faces]) > 0).all()


@pytest.mark.parametrize(
    "make",
    [make for name, make in CLOSED.items() if name not in ("tube", "handle")],
)
def test_rests_on_the_ground(make):
    assert make().bounds[0, 1] == pytest.approx(0.0, abs=1e-12)


def test_known_volumes():
    segments = 256
    flat = np.sin(2 * np.pi / segments) * segments / (2 * np.pi)
    cylinder = welded(shapes.cylinder(0.1, 0.3, 1e-4, segments))
    assert cylinder.volume == pytest.approx(np.pi * 0.1**2 * 0.3 * flat, rel=1e-3)
    ball = welded(shapes.sphere(0.2, 5))
    assert ball.volume == pytest.approx(4 / 3 * np.pi * 0.2**3, rel=2e-3)
    ring = welded(shapes.torus(0.2, 0.05, segments))
    assert ring.volume == pytest.approx(2 * np.pi**2 * 0.2 * 0.05**2, rel=2e-3)


def test_quarter_turns_are_exact():
    shape = shapes.box(0.4, 0.2, 0.3)
    np.testing.assert_array_equal(shape.turned(90).turned(-90).vertices, shape.vertices)
    np.testing.assert_array_equal(shape.turned(90).bounds[:, 0], shape.bounds[:, 2])


def test_curve_passes_through_its_ends():
    points = [(0.1, 0.0), (0.3, 0.2), (0.2, 0.5)]
    line = shapes.smooth_curve(points, 20)
    np.testing.assert_array_equal(line[[0, -1]], [points[0], points[-1]])
    middle = np.linalg.norm(shapes.smooth_curve(points, 2001) - points[1], axis=1).min()
    assert middle < 1e-3


PATTERNS = {
    "stripes": lambda s: list(patterns.split(s, patterns.waves(5, 40.0))),
    "rings": lambda s: list(patterns.split(s, patterns.rings(0.07))),
    "zigzag": lambda s: list(patterns.split(s, patterns.zigzag(0.15, 8, 0.02))),
    "checks": lambda s: patterns.checkerboard(s, patterns.waves(4), patterns.rings(0.1)),
    "levels": lambda s: patterns.split_at_levels(s, patterns.height, [0.1, 0.2]),
    "dots": lambda s: list(patterns.split(s, patterns.dots(random(), s, 0.03, 20))),
    "patches": lambda s: patterns.patches(random(), s, 4, 0.1),
}


@pytest.mark.parametrize("paint", PATTERNS.values(), ids=PATTERNS)
def test_patterns_keep_the_surface(paint):
    shape = shapes.lump(random(1), 0.15)
    parts = paint(shape)
    assert all(len(part.faces) for part in parts)
    assert sum(part.area for part in parts) == pytest.approx(shape.area, rel=1e-9)
    whole = welded(joined(parts))
    assert whole.is_watertight
    assert whole.volume == pytest.approx(welded(shape).volume, rel=1e-6)


def test_patches_are_shared_out_alike():
    shape = shapes.sphere(0.2)
    shares = np.array([part.area for part in patterns.patches(random(), shape, 4, 0.1)])
    np.testing.assert_allclose(shares / shares.sum(), 0.25, atol=0.05)


def test_division_follows_the_field():
    shape = shapes.sphere(0.2)
    low, high = patterns.split(shape, lambda points: points[:, 1] - 0.2)
    edge = 0.002  # what a cut keeps from vertices may move it by a fraction of a triangle
    assert low.bounds[1, 1] < 0.2 + edge
    assert high.bounds[0, 1] > 0.2 - edge
    none, all_of_it = patterns.split(shape, lambda points: points[:, 1] + 1.0)
    assert (len(none.faces), len(all_of_it.faces)) == (0, len(shape.faces))


def test_mondrian_fills_its_rectangle():
    parts = patterns.mondrian(random(3), 1.2, 0.8, 0.15)
    assert sum(w * h for _, _, w, h in parts) == pytest.approx(1.2 * 0.8)
    assert min(min(w, h) for _, _, w, h in parts) >= 0.15
    assert len(parts) > 5


def test_noise_has_its_variance():
    points = random(1).uniform(-50.0, 50.0, (20000, 3))
    values = shapes.Noise(random(2), 0.7)(points)
    assert abs(values.mean()) < 0.05
    assert values.var() == pytest.approx(1.0, abs=0.1)


def test_chips_are_within_gamut():
    names, rows = chips()
    assert len(names) > 1000
    assert rows[:, 0].min() > 0
    assert rows[:, 0].max() <= 100
    palette = Palette(random())
    drawn = [palette.wood(), palette.accent(), palette.pale(), palette.fabric(), palette.grey(5)]
    drawn += palette.colors(12)
    for material in drawn:
        assert material.reflectance.values.min() >= 0.0
        assert material.reflectance.values.max() <= 1.0


def test_hues_wrap_around():
    palette = Palette(random())
    hues = {palette.chip(0.0, (4, 6), (4, 8), 6.0).name.split()[0] for _ in range(60)}
    assert {name.lstrip("0123456789.") for name in hues} == {"R", "RP"}


def test_one_chip_is_one_material():
    palette = Palette(random())
    assert palette.grey(5) is palette.grey(5)
    assert palette.glazed(palette.grey(5)) is palette.grey(5)
    mixed = Palette(random(), "mixed")
    coated = mixed.glazed(mixed.grey(8))
    assert coated is mixed.glazed(mixed.grey(8))
    assert coated.mirror > 0
    assert coated.mirror + coated.reflectance.values.max() <= 1.0
    assert mixed.metal().reflectance == 0.0
    assert mixed.glass(mixed.grey(5)).ior == 1.5


def test_unknown_materials_are_refused():
    with pytest.raises(InputError, match="materials 'shiny' must be one of 'lambertian', 'mixed'"):
        Palette(random(), "shiny")


def test_rings_lie_on_each_other():
    tower = ring_tower(Draw(random()), 0.1, 5)
    boxes = np.array([part.shape.bounds for part in tower.parts[:6]])
    gaps = boxes[1:, 0, 1] - boxes[:-1, 1, 1]
    np.testing.assert_allclose(gaps, 0.0, atol=1e-12)


def test_shapes_share_nothing_that_changes():
    first, second = shapes.box(1.0, 1.0, 1.0), shapes.box(2.0, 1.0, 1.0)
    assert isinstance(first, Shape)
    assert first.vertices is not second.vertices
    assert np.ptp(second.vertices[:, 0]) == pytest.approx(2.0)
