"""Energy extremes: reflectances up to 1, lights of any power, and lights that hardly reach."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import trimesh
from cases import assert_mean, assert_same, means, rendered
from helpers.marks import slow
from helpers.scenes import GREY, closed_box, quad

import photonmap as pm

BOX = pm.scenes.cornell_box()
VIEW = pm.Camera((0.3, 0.2, 0.8), (-0.2, -0.1, -1.0), fov=70.0)


def furnace(reflectance):
    return pm.Scene([closed_box(pm.Material("wall", reflectance, 1.0))], camera=VIEW)


@pytest.mark.filterwarnings("ignore:.* truncated after 1000 bounces")
@pytest.mark.parametrize("method", ["photon", "path"])
@pytest.mark.parametrize("reflectance", slow(0.0, 0.99))
def test_furnace(reflectance, method):
    """L = Le / (1 - ρ)."""
    values = means(furnace(reflectance), method=method, passes=2)
    assert_mean(values, np.full(2, 1.0 / (1.0 - reflectance)), slack=2e-3)


@pytest.mark.parametrize("method", ["photon", "path"])
def test_furnace_that_is_cut(method):
    """After 1000 bounces: 1001 Le at ρ = 1."""
    size = (4, 4) if method == "photon" else (2, 2)
    settings = {"method": method, "photons": 500, "size": size}
    messages = "photons were truncated" if method == "photon" else "% of paths are truncated"
    with pytest.warns(pm.SceneWarning, match=f"{messages} after 1000 bounces"):
        # Paths have no noise where nothing absorbs.
        values = means(furnace(1.0), count=2 if method == "path" else 4, **settings)
    assert_mean(values, np.full(2, 1001.0), slack=0.01)


@pytest.mark.parametrize("reflectance", [0.98, 1.0])
def test_nothing_is_said_where_no_path_is_cut(reflectance):
    """White walls out of which light gets soon, and others that are not quite white."""
    walls = closed_box(pm.Material("wall", reflectance))
    faces = walls.faces if reflectance < 1.0 else walls.faces[2:]
    light = pm.PointLight((0, 0.5, 0))
    rendered(pm.Scene([replace(walls, faces=faces)], [light], VIEW), method="path")


@pytest.mark.parametrize("method", ["photon", "path"])
def test_white_things_under_a_white_sky(method):
    """Where nothing absorbs, all is as bright as the sky: in a cup and on a ball."""
    white = pm.Material("white", 1.0)
    cup = closed_box(white)
    sides = cup.vertices[cup.faces][:, :, 1].min(axis=1) < 1.0
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.3)
    meshes = [replace(cup, faces=cup.faces[sides]), pm.Mesh(ball.vertices, ball.faces, white)]
    scene = pm.Scene(meshes, [pm.DomeLight(1.0)], pm.Camera((1, 4, 2), (0, 0, 0), fov=30))
    assert_mean(means(scene, method=method), np.ones(2), slack=2e-3)


def shine_down(radiance):
    """A lamp below the box's ceiling."""
    corners = np.array([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)])
    return quad(*(0.2 * corners + [0, 0.9, 0]), pm.Material("lamp", 0.0, radiance), "lamp")


@pytest.mark.parametrize("power", [1e-28, 1e28, *slow(1e-6, 1e12)])
@pytest.mark.parametrize("kind", ["lamp", "point"])
def test_light_of_any_power_gives_the_same_picture(kind, power):
    def scene(factor):
        if kind == "lamp":
            lamp = shine_down(factor)
            return pm.Scene([*BOX.meshes[1:], lamp], camera=BOX.camera)
        return pm.Scene(BOX.meshes[1:], [pm.PointLight((0, 0.5, 0), factor)], BOX.camera)

    unit, other = rendered(scene(1.0)), rendered(scene(power))
    for name in ("radiance", "shading"):
        np.testing.assert_allclose(other.buffers[name], power * unit.buffers[name], rtol=1e-5)
        np.testing.assert_allclose(other.errors[name], power * unit.errors[name], rtol=1e-4)


@pytest.mark.parametrize("power", [1e-320, 1e-40, 1e40, 1e300, 1.7e308])
def test_light_that_images_cannot_hold_is_refused(power):
    scene = pm.Scene(BOX.meshes[1:], [pm.PointLight((0, 0.5, 0), power)], BOX.camera)
    with pytest.raises(pm.InputError, match="scale the lights"):
        rendered(scene)


def two_rooms(ratio, kind):
    """Two rooms beside each other, open towards the camera, one light each; left the brighter."""
    room = closed_box(GREY)
    faces = room.faces[room.vertices[room.faces][:, :, 2].min(axis=1) < 1.0]
    meshes, lights = [], []
    for name, x, power in (("left", -1.1, ratio), ("right", 1.1, 1.0)):
        meshes.append(pm.Mesh(room.vertices + [x, 0, 0], faces, GREY, name))
        if kind == "point":
            lights.append(pm.PointLight((x, 0.5, 0), power, name))
        else:
            corners = np.array([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)])
            lamp = pm.Material(name, 0.0, power)
            meshes.append(quad(*(0.2 * corners + [x, 0.9, 0]), lamp, f"{name} lamp"))
    return pm.Scene(meshes, lights, pm.Camera((0, 0, 6), (0, 0, 0), fov=30))


@pytest.mark.parametrize("kind", ["point", "lamp"])
@pytest.mark.parametrize("ratio", [1e10, *slow(1e4, 1e20)])
def test_a_dim_room_beside_a_bright_one(kind, ratio):
    """Each is lit by its own light alone, as if the other were as bright."""
    settings = {"size": (24, 12), "photons": 8000}

    def images(scene):
        return [rendered(scene, seed=seed, **settings) for seed in range(6)]

    def halves(results, buffer):
        sides = [np.split(result.buffers[buffer], [10, 14], axis=1) for result in results]
        return (np.array([side[i].mean(axis=(0, 1), dtype=float) for side in sides])
                for i in (0, 2))  # fmt: skip

    results, even = images(two_rooms(ratio, kind)), images(two_rooms(1.0, kind))
    for buffer in ("direct", "indirect"):
        bright, dim = halves(results, buffer)
        wanted, also = halves(even, buffer)
        assert_same(bright / ratio, wanted, slack=0.01)
        assert_same(dim, also, slack=0.01)


@pytest.mark.slow
def test_a_thousand_lights_of_which_one_matters():
    """999 lie in a closed room elsewhere."""
    places = np.random.default_rng(0).uniform(5, 6, (999, 3))
    lamp = pm.PointLight((0, 0.5, 0), 1.0, "bulb")
    others = [pm.PointLight(tuple(place)) for place in places]
    meshes = [closed_box(GREY), closed_box(GREY, 4, 7, "elsewhere")]
    crowded = pm.Scene(meshes, [*others, lamp], VIEW)
    with pytest.warns(pm.SceneWarning, match="and 991 more send nothing into the view"):
        values = means(crowded, "direct")
    wanted = means(pm.Scene(meshes[:1], [lamp], VIEW), "direct")
    assert_same(values, wanted, slack=1e-3)


def test_light_through_a_keyhole():
    """A dark room, and a hole of 1/200 of the wall to a lit one: photons and paths agree."""
    wall = [quad((-1, -1, 0), (x, -1, 0), (x, 1, 0), (-1, 1, 0), GREY, "wall") for x in (-0.07,)]
    wall += [quad((0.07, -1, 0), (1, -1, 0), (1, 1, 0), (0.07, 1, 0), GREY, "wall")]
    wall += [quad((-0.07, low, 0), (0.07, low, 0), (0.07, high, 0), (-0.07, high, 0), GREY, "wall")
             for low, high in ((-1, -0.07), (0.07, 1))]  # fmt: skip
    light = pm.PointLight((0.3, 0.4, -0.9), 10.0)
    scene = pm.Scene([closed_box(GREY), *wall], [light], pm.Camera((0.5, 0.5, 0.9), (0, -1, 0.3)))
    values, wanted = (means(scene, photons=16384, method=method) for method in ("photon", "path"))
    assert_same(values, wanted, slack=0.02)


@pytest.mark.parametrize(
    "light",
    [
        pm.SpotLight((0, 0, 3), (0, 0, 9), 1.0, 5.0, 6.0),
        pm.PointLight((0.0, 0.0, 1e9), 1e-3),
    ],
)
def test_a_light_that_sends_no_photon_into_the_scene(light):
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.5)
    floor = quad((-2, -0.5, -2), (-2, -0.5, 2), (2, -0.5, 2), (2, -0.5, -2), GREY, "floor")
    scene = pm.Scene([pm.Mesh(ball.vertices, ball.faces), floor], [light],
                     pm.Camera((0, 0, 2), (0, 0, 0)))  # fmt: skip
    if isinstance(light, pm.SpotLight):
        with pytest.warns(pm.SceneWarning, match="'spot' sends nothing into the view"):
            result = rendered(scene)
        assert not result.radiance.any()
    else:
        wanted = 1e-3 / 1e18 / np.pi
        facing = rendered(scene, pixel="center", size=(13, 13))
        np.testing.assert_allclose(facing.direct.max(), 0.5 * wanted, rtol=0.05)


@pytest.mark.parametrize("pixel", ["box", "center"])
def test_dark_patches_are_lit_like_their_surroundings(pixel):
    """A floor of black and grey stripes in a lit room: shading goes on where reflectance is 0."""
    black = pm.Material("black", 0.0)
    edges = np.linspace(-1.0, 1.0, 9)
    stripes = [
        quad((a, -1, -1), (a, -1, 1), (b, -1, 1), (b, -1, -1), (black, GREY)[i % 2], f"stripe {i}")
        for i, (a, b) in enumerate(pairwise(edges))
    ]
    meshes = [mesh for mesh in BOX.meshes if mesh.name in ("light", "ceiling", "back")]
    camera = pm.Camera((0, 0.2, 3), (0, -1, 0), fov=25)
    scene = replace(BOX, meshes=[*meshes, *stripes], camera=camera)
    result = rendered(scene, pixel=pixel, size=(32, 24), passes=16, photons=8000)
    dark = (result.reflectance == 0.0).all(axis=-1) & (result.coverage == 1.0)
    lit = (result.reflectance == 0.5).all(axis=-1) & (result.coverage == 1.0)
    assert min(dark.sum(), lit.sum()) > 40
    assert not result.direct[dark].any()
    assert not result.indirect[dark].any()
    for row in range(4, 20):
        if dark[row].sum() > 3 and lit[row].sum() > 3:
            columns = np.arange(32)
            smooth = np.polyfit(columns[lit[row]], result.shading[row, lit[row], 0], 2)
            other = np.polyval(smooth, columns[dark[row]])
            inner = (columns[dark[row]] > 4) & (columns[dark[row]] < 28)
            np.testing.assert_allclose(result.shading[row, dark[row], 0][inner], other[inner],
                                       rtol=0.1)  # fmt: skip
