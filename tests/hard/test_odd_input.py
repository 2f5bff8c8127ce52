"""Odd input: normals, texture coordinates, lamps and cameras that are legal, or nearly."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from cases import assert_same, means, means_of, rendered
from helpers.marks import slow
from helpers.scenes import GREY, closed_box

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.scene.images import Image

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*successive reflections",
    "ignore:[0-9]* of [0-9]* photons were truncated",
    "ignore:method path finds no caustics",
)
"""Some light stays in glass for ever."""
ROOM = closed_box(GREY)
LAMP = pm.PointLight((0.0, 0.5, 0.0), 1.0)
VIEW = pm.Camera((0.3, 0.2, 0.8), (-0.2, -0.1, -1.0), fov=70.0)
BALL = trimesh.creation.icosphere(subdivisions=2, radius=0.4)
SMOOTH = BALL.vertices / 0.4
KINDS = {"grey": GREY, "mirror": pm.Material.polished(), "glass": pm.Material.glass()}


def with_ball(normals=None, material=GREY, uv=None):
    ball = pm.Mesh(BALL.vertices, BALL.faces, material, "ball", normals, uv)
    return pm.Scene([ROOM, ball], [LAMP], VIEW)


def compiled_normals(normals):
    return compile_scene(with_ball(normals), pm.Bands.rgb()).geometry.shading_normals


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_normals_that_are_none_mean_flat(value):
    """They are compiled as zeros, of which pictures are sound."""
    flat = compiled_normals(np.zeros_like(SMOOTH))
    np.testing.assert_array_equal(compiled_normals(np.full_like(SMOOTH, value)), flat)
    assert not flat.any()


@pytest.mark.parametrize("kind", KINDS)
def test_normals_of_zero_are_those_of_facets(kind):
    zeros, none = np.zeros_like(SMOOTH), None
    result, flat = (rendered(with_ball(each, KINDS[kind])) for each in (zeros, none))
    np.testing.assert_array_equal(result.radiance, flat.radiance)


@pytest.mark.parametrize("length", [2.0**-1000, 2.0**-60, 2.0**60, 2.0**1000])
def test_normals_of_any_length(length):
    np.testing.assert_array_equal(compiled_normals(length * SMOOTH), compiled_normals(SMOOTH))


@pytest.mark.parametrize(
    ("kind", "turn"),
    [
        ("grey", "inverse"),
        ("grey", "sideways"),
        ("grey", "every other one flat"),
        ("glass", "inverse"),
        ("glass", "sideways"),
        ("mirror", "every other one flat"),
    ],
)
def test_normals_that_are_wrong(kind, turn):
    """Sound, and by both methods the same where surfaces are diffuse."""
    normals = {
        "inverse": -SMOOTH,
        "sideways": np.cross(SMOOTH, [0.0, 1.0, 0.3]),
        "every other one flat": SMOOTH * (np.arange(len(SMOOTH)) % 2)[:, None],
    }[turn]
    scene = with_ball(normals, KINDS[kind])
    if kind == "grey":
        values, wanted = (means(scene, method=m, photons=4000) for m in ("photon", "path"))
        assert_same(values, wanted, slack=0.02)
    else:
        rendered(scene)
        rendered(scene, method="path")


def checks(shape):
    image = np.random.default_rng(0).random((*shape, 3))
    return pm.Texture(Image(np.ascontiguousarray(image, np.float32), srgb=False))


@pytest.mark.parametrize(
    ("shape", "factor"), [((5, 3), 0.0), ((1, 1), -1e5), ((1, 7), 1e9), ((5, 3), 1e9)]
)
def test_texture_coordinates_of_any_size(shape, factor):
    material = pm.Material("paint", checks(shape))
    rendered(with_ball(None, material, factor * BALL.vertices[:, :2]))


@pytest.mark.parametrize("factor", [1e10, 1e300, np.inf, np.nan])
def test_texture_coordinates_beyond(factor):
    material = pm.Material("paint", checks((5, 3)))
    with pytest.raises(pm.InputError, match="give finite numbers up to 1e"):
        rendered(with_ball(None, material, factor * (1.0 + BALL.vertices[:, :2])))


@pytest.mark.parametrize("place", [{"scale": (1.0, 1e10)}, {"offset": (-1e10, 0.0)}])
def test_textures_out_of_reach(place):
    with pytest.raises(pm.InputError, match="give two numbers within"):
        replace(checks((5, 3)), **place)


@pytest.mark.parametrize("count", [7, 8, 1000])
def test_lights_at_one_place(count):
    """As one light with the power of all, whether they hang in a tree or not."""
    lights = [replace(LAMP, intensity=1.0 / count, name=f"{i}") for i in range(count)]
    wanted = rendered(pm.Scene([ROOM], [LAMP], VIEW)).direct
    found = rendered(pm.Scene([ROOM], lights, VIEW)).direct
    np.testing.assert_allclose(found, wanted, rtol=1e-5)


def test_black_lights_among_others():
    black = [pm.PointLight((0.1 * i, 0.0, 0.0), 0.0, f"black {i}") for i in range(10)]
    wanted, found = (rendered(pm.Scene([ROOM], [*more, LAMP], VIEW)) for more in ([], black))
    np.testing.assert_array_equal(found.direct, wanted.direct)


def strips(edges):
    """A lamp of 0.6 in strips, that shines down."""
    vertices = [(x, 0.9, z) for x in edges for z in (-0.3, 0.3)]
    first = np.arange(0, 2 * len(edges) - 2, 2)[:, None]
    faces = np.concatenate([first + [0, 2, 3], first + [0, 3, 1]])
    return pm.Mesh(np.array(vertices), faces, pm.Material("lamp", 0.0, 1.0), "lamp")


@pytest.mark.parametrize("width", [1e-7, *slow(1e-3)])
def test_a_lamp_of_slivers(width):
    """It shines as it does in one piece: each sliver by its area."""
    edges = np.linspace(-0.3, 0.3, 9)
    slivers = strips(np.sort(np.concatenate([edges, edges[1:-1] + width])))
    values, wanted = (
        means_of(pm.Scene([ROOM, lamp], camera=VIEW)) for lamp in (slivers, strips(edges[[0, -1]]))
    )
    for buffer in ("direct", "indirect"):
        assert_same(values[buffer], wanted[buffer], slack=5e-3)


@pytest.mark.parametrize("fov", [1e-9, 179.999])
def test_any_angle_of_view(fov):
    rendered(pm.Scene([ROOM], [LAMP], replace(VIEW, fov=fov)))


@pytest.mark.parametrize("length", [1e-200, 1e29])
def test_up_of_any_length(length):
    wanted = rendered(pm.Scene([ROOM], [LAMP], VIEW)).radiance
    found = rendered(pm.Scene([ROOM], [LAMP], replace(VIEW, up=(0.0, length, 0.0)))).radiance
    np.testing.assert_array_equal(found, wanted)


@pytest.mark.parametrize("distance", [1e-200, 1e29])
def test_a_target_at_any_distance(distance):
    views = [replace(VIEW, origin=(0, 0, 0), target=(0, 0, -d)) for d in (1.0, distance)]
    wanted, found = (rendered(pm.Scene([ROOM], [LAMP], view)).radiance for view in views)
    np.testing.assert_array_equal(found, wanted)


@pytest.mark.parametrize("angles", [(0.0, 0.001), (10.0, 10.0), (90.0, 90.0), (0.0, 179.999)])
def test_any_angle_of_a_spot(angles):
    rendered(pm.Scene([ROOM], [pm.SpotLight((0, 0.5, 0), (0, -1, 0), 1.0, *angles)], VIEW))
