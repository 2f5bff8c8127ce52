"""Normal maps and bump maps: against closed forms, displaced geometry and both methods."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.scenes import quad

import photonmap as pm
from photonmap.compile.effects import EFFECTS, plan_effects
from photonmap.compile.scene_arrays import compile_scene
from photonmap.errors import InputError
from photonmap.spectra.bands import Bands

UV = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
SMALL = {"bands": 1, "size": (8, 8), "threads": 2, "passes": 1}
ABOVE = pm.Camera((0.0, 5.0, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), height=1.0)
RHO = 0.6


def encoded(*normal):
    """Return a normal map that is the same direction all over."""
    return pm.Texture.of(np.full((2, 2, 3), 0.5 + 0.5 * np.array(normal), np.float32))


def plane(relief, mirror=False, turn=0.0):
    """Return a square that faces +y; u rises along x, and v along -z."""
    matter = {"mirror": 0.9} if mirror else {}
    material = pm.Material("ground", 0.0 if mirror else RHO, relief=relief, **matter)
    corners = np.array([(-2.0, 0, 2.0), (2.0, 0, 2.0), (2.0, 0, -2.0), (-2.0, 0, -2.0)])
    cosine, sine = np.cos(turn), np.sin(turn)
    corners = corners @ np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])
    return replace(quad(*corners, material, "ground"), uv=UV)


def tilted(angle, azimuth):
    """Return what a normal map holds, and the normal that it makes of +y."""
    x, y, z = np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth), np.cos(angle)
    return (x, y, z), np.array([x, z, -y])


@pytest.mark.filterwarnings("ignore:light 'directional' sends nothing")
@pytest.mark.filterwarnings("ignore:no light reaches what the camera sees")
@pytest.mark.parametrize("method", ["photon", "path"])
@pytest.mark.parametrize("azimuth", [0.0, 2.0])
@pytest.mark.parametrize("sun", [(0.2, 1.0, 0.1), (-1.0, 0.3, 0.4), (0.9, -0.2, 0.1)])
def test_the_sun_on_a_tilted_normal(sun, azimuth, method):
    """E = E0 max(0, n · l) where the sun stands above the surface, and 0 where it stands below."""
    texels, normal = tilted(0.5, azimuth)
    toward = np.array(sun) / np.linalg.norm(sun)
    light = pm.DirectionalLight(tuple(-toward), irradiance=2.0)
    scene = pm.Scene([plane(pm.NormalMap(encoded(*texels)))], [light], ABOVE)
    result = pm.render(scene, **SMALL, method=method)
    cosine = max(toward @ normal, 0.0) if toward[1] > 0.0 else 0.0
    np.testing.assert_allclose(result.direct, RHO / np.pi * 2.0 * cosine, rtol=1e-4, atol=1e-7)
    np.testing.assert_allclose(result.normal, np.broadcast_to(normal, (8, 8, 3)), atol=1e-5)


@pytest.mark.parametrize("angle", [0.3, 0.9])
def test_an_even_sky_on_a_tilted_normal(angle):
    """E = π L (1 + cos θ) / 2: the surface itself hides what is below it."""
    texels, _ = tilted(angle, 1.0)
    scene = pm.Scene([plane(pm.NormalMap(encoded(*texels)))], [pm.DomeLight(0.7)], ABOVE)
    result = pm.render(scene, **SMALL | {"passes": 32})
    wanted = RHO * 0.7 * 0.5 * (1.0 + np.cos(angle))
    error = np.sqrt((result.errors["direct"] ** 2).sum()) / result.direct.size
    assert abs(result.direct.mean() - wanted) < 4.0 * error + 1e-4


def test_strength_flattens_and_reverses():
    texels, _ = tilted(0.5, 0.0)
    light = pm.DirectionalLight((0.5, -1.0, 0.0))
    for strength in (0.0, 0.5, -1.0):
        scene = pm.Scene([plane(pm.NormalMap(encoded(*texels), strength))], [light], ABOVE)
        normal = np.array([strength * np.sin(0.5), np.cos(0.5), 0.0])
        found = pm.render(scene, **SMALL).normal
        np.testing.assert_allclose(found[4, 4], normal / np.linalg.norm(normal), atol=1e-5)


def test_the_back_is_the_front_from_behind():
    texels, normal = tilted(0.4, 0.7)
    below = pm.Camera((0.0, -5.0, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), height=1.0)
    scene = pm.Scene([plane(pm.NormalMap(encoded(*texels)))], [pm.DomeLight()], below)
    np.testing.assert_allclose(pm.render(scene, **SMALL).normal[3, 3], -normal, atol=1e-5)


def test_mirrors_reflect_about_the_tilted_normal():
    """As a mirror that is tilted itself, in a sky that depends on the direction alone."""
    rows, columns = np.mgrid[0:32, 0:64]
    sky = np.stack([1.0 + rows, 1.0 + columns, 2.0 + 0.0 * rows], axis=2).astype(np.float32)
    texels, _ = tilted(0.3, np.pi)
    pictures = [
        pm.render(
            pm.Scene([plane(relief, True, turn)], [pm.EnvironmentLight(sky)], ABOVE),
            **SMALL | {"bands": "rgb"},
        ).radiance
        for relief, turn in ((pm.NormalMap(encoded(*texels)), 0.0), (None, 0.3))
    ]
    np.testing.assert_allclose(pictures[0], pictures[1], rtol=2e-3)


WAVES, AMPLITUDE = 2, 0.004


def wave(columns=512):
    """Return heights that run along u."""
    x = (np.arange(columns) + 0.5) / columns
    return pm.Texture.of((0.5 + 0.5 * np.sin(2.0 * np.pi * WAVES * x))[None].astype(np.float32))


def displaced(columns=2048):
    """Return the same square with the waves in its geometry, and their true normals."""
    u = np.linspace(0.0, 1.0, columns + 1)
    phase = 2.0 * np.pi * WAVES * u
    height = AMPLITUDE * (0.5 + 0.5 * np.sin(phase))
    slope = AMPLITUDE * np.pi * WAVES * np.cos(phase) / 4.0
    normal = np.stack([-slope, np.ones_like(u), np.zeros_like(u)], axis=1)
    rows = [np.stack([4.0 * u - 2.0, height, np.full_like(u, z)], axis=1) for z in (2.0, -2.0)]
    near = np.arange(columns)
    far = near + columns + 1
    faces = np.concatenate(
        [np.stack([near, near + 1, far + 1], axis=1), np.stack([near, far + 1, far], axis=1)]
    )
    material = pm.Material("ground", RHO)
    return pm.Mesh(np.concatenate(rows), faces, material, "ground", np.tile(normal, (2, 1)))


def test_bumps_are_the_displaced_surface():
    """At a small amplitude, under a low sun that no wave hides."""
    light = pm.DirectionalLight((-1.0, -0.4, 0.3), irradiance=2.0)
    wide = pm.Camera((0.0, 5.0, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), height=3.5)
    settings = SMALL | {"size": (64, 2), "pixel": "center"}
    bumped = plane(pm.BumpMap(wave(), AMPLITUDE))
    found, truth = (
        pm.render(pm.Scene([mesh], [light], wide), **settings) for mesh in (bumped, displaced())
    )
    flat = 2.0 * RHO / np.pi * 0.4 / np.linalg.norm((1.0, 0.4, 0.3))
    assert np.ptp(truth.direct) > 0.02 * flat
    np.testing.assert_allclose(found.direct, truth.direct, atol=2e-4 * flat)
    np.testing.assert_allclose(found.normal, truth.normal, atol=1e-4)


def sphere(relief, columns=256, rows=128):
    """Return a ball about y whose u runs around it, from +x towards -z."""
    v, u = np.mgrid[0 : rows + 1, 0 : columns + 1].reshape(2, -1) / [[rows], [columns]]
    azimuth, polar = 2.0 * np.pi * u, np.pi * (1.0 - v)
    normals = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.cos(polar), -np.sin(polar) * np.sin(azimuth)], axis=1
    )
    row, column = np.mgrid[1 : rows - 1, 0:columns].reshape(2, -1)
    corner = row * (columns + 1) + column
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + columns + 2], axis=1),
            np.stack([corner, corner + columns + 2, corner + columns + 1], axis=1),
        ]
    )
    material = pm.Material("ball", RHO, relief=relief)
    return pm.Mesh(normals, faces, material, "ball", normals, np.stack([u, v], axis=1))


def test_tangents_of_a_ball():
    """A map of one direction turns each normal towards its own circle of latitude."""
    texels, _ = tilted(0.3, 0.5)
    camera = pm.Camera((0.0, 0.5, 5.0), (0.0, 0.0, 0.0), height=1.4)
    flat, found = (
        pm.render(pm.Scene([sphere(relief)], [pm.DomeLight()], camera), **SMALL).normal
        for relief in (None, pm.NormalMap(encoded(*texels)))
    )
    around = np.cross([0.0, 1.0, 0.0], flat)
    around /= np.linalg.norm(around, axis=2, keepdims=True)
    up = np.cross(flat, around)
    wanted = texels[0] * around + texels[1] * up + texels[2] * flat
    np.testing.assert_allclose(found, wanted, atol=2e-4)


def test_the_plan_of_effects():
    scene = pm.Scene([plane(pm.NormalMap(encoded(0.3, 0.0, 0.9)))], [pm.DomeLight()], ABOVE)
    compiled = compile_scene(scene, Bands.rgb())
    assert plan_effects(compiled, "auto", 3, 3).on("relief")
    flat = pm.Scene([plane(None)], [pm.DomeLight()], ABOVE)
    bare = compile_scene(flat, Bands.rgb())
    assert bare.geometry.relief is None
    assert not plan_effects(bare, "auto", 3, 3).on("relief")
    rest = ",".join(name for name in EFFECTS if name != "relief")
    left_out = pm.render(scene, **SMALL, effects=rest)
    np.testing.assert_array_equal(left_out.direct, pm.render(flat, **SMALL).direct)


def test_meshes_without_coordinates_stay_flat():
    mesh = replace(plane(pm.NormalMap(encoded(0.3, 0.0, 0.9))), uv=None)
    scene = pm.Scene([mesh], [pm.DomeLight()], ABOVE)
    with pytest.warns(pm.errors.SceneWarning, match="no texture coordinates"):
        assert compile_scene(scene, Bands.rgb()).geometry.relief is None


@pytest.mark.parametrize(
    ("relief", "message"),
    [
        (encoded(0.0, 0.0, 1.0), "is not a relief; give one of NormalMap, BumpMap"),
        (pm.NormalMap(0.5), "0.5 is not an image; give a Texture"),
        (
            pm.NormalMap(encoded(0.0, 0.0, 1.0), np.nan),
            "strength nan is not a strength; give a number",
        ),
        (pm.BumpMap(encoded(0.0, 0.0, 1.0), 1e7), "height .* is not a height; give scene units"),
        (pm.NormalMap(wave()), "a normal map has three channels"),
        (pm.NormalMap(encoded(0.0, 0.0, 1.5)), "the texture reaches 1.25"),
    ],
)
def test_bad_reliefs(relief, message):
    scene = pm.Scene([plane(relief)], [pm.DomeLight()], ABOVE)
    with pytest.raises(InputError, match=f"material 'ground': relief: .*{message}"):
        compile_scene(scene, Bands.rgb())
