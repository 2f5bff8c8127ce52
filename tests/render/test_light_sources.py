"""Every kind of light against closed forms."""

import numpy as np
import pytest
from helpers.comparisons import assert_within
from helpers.scenes import closed_box, quad, sky
from test_direct import DOWN, floor

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.kernels.lights.environment import radiance_of, texel_at
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()
BLOCK = closed_box(pm.Material("block", 0.5), -0.5, 0.5)


def look_down(light, method="photon", size=9, passes=2, bands=1, **options):
    """Render the floor, of reflectance 0.8, from above; return the result and points' x and z."""
    scene = pm.Scene([floor()], [light], DOWN)
    result = pm.render(
        scene, bands=bands, size=(size, size), pixel="center", passes=passes, photons=10,
        method=method, **options,
    )  # fmt: skip
    half = 3.0 * np.tan(np.radians(10.0))
    z, x = (np.mgrid[:size, :size] + 0.5) / size * 2.0 * half - half
    return result, x, z


@pytest.mark.parametrize("method", ["photon", "path"])
@pytest.mark.parametrize(("inner", "outer"), [(5.0, 12.0), (8.0, 8.0), (20.0, 100.0)])
def test_spot_over_plane(method, inner, outer):
    """Inverse square and cosine times the falloff, exactly 0 outside of the outer cone."""
    height, target, intensity = 1.5, np.array([0.1, 0.0, -0.05]), 3.0
    position = np.array([0.0, height, 0.0])
    light = pm.SpotLight(tuple(position), tuple(target), intensity, inner, outer)
    result, x, z = look_down(light, method)
    way = np.stack([x, np.full_like(x, -height), z], axis=-1)
    distance = np.linalg.norm(way, axis=-1)
    axis = (target - position) / np.linalg.norm(target - position)
    cosine = way @ axis / distance
    low, high = np.cos(np.radians([outer, inner]))
    t = np.clip((cosine - low) / max(high - low, 1e-12), 0.0, 1.0)
    truth = 0.8 / np.pi * intensity * height / distance**3 * (3 * t**2 - 2 * t**3)
    np.testing.assert_allclose(result.direct[..., 0], truth, rtol=2e-4, atol=3e-5)
    assert (result.direct[..., 0][cosine < low - 1e-6] == 0.0).all()
    if outer < 15.0:
        assert (cosine < low).any()
    assert (result.direct > 0.0).any()


@pytest.mark.parametrize("method", ["photon", "path"])
def test_sun_over_plane(method):
    """E cos θ everywhere, whatever the distance and the length of the direction."""
    result, _, _ = look_down(pm.DirectionalLight((3.0, -4.0, 0.0), 2.0), method)
    np.testing.assert_allclose(result.direct[..., 0], 0.8 / np.pi * 2.0 * 0.8, rtol=2e-6)
    result, _, _ = look_down(pm.DirectionalLight((0.0, -1e-6, 0.0), 2.0), method)
    np.testing.assert_allclose(result.direct[..., 0], 0.8 / np.pi * 2.0, rtol=2e-6)


@pytest.mark.filterwarnings("ignore:no photon was found for the indirect light")
def test_the_sun_casts_shadows_and_leaves_backs_dark():
    lid = quad((-9, 1, 9), (9, 1, 9), (9, 1, 0), (-9, 1, 0), pm.Material("lid", 0.0), "lid")
    camera = pm.Camera((0.0, 0.9, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), fov=60.0)
    scene = pm.Scene([floor(), lid], [pm.DirectionalLight((0.0, -1.0, 0.0))], camera)
    result = pm.render(scene, bands=1, size=(8, 8), pixel="center", passes=1, photons=10)
    np.testing.assert_allclose(result.direct[:4, :, 0], 0.8 / np.pi, rtol=1e-5)
    assert (result.direct[4:] == 0.0).all()


@pytest.mark.parametrize("method", ["photon", "path"])
def test_an_even_environment_is_a_dome(method):
    image = np.broadcast_to([2.0, 1.0, 0.5], (6, 12, 3))
    result, _, _ = look_down(pm.EnvironmentLight(image, 0.5), method, 6, 64, "rgb", seed=4)
    truth = 0.8 * 0.5 * np.array([2.0, 1.0, 0.5])
    assert_within(result.direct, truth, result.standard_error("direct"), 4.5, 1e-5)
    assert result.direct.mean() == pytest.approx(truth.mean(), rel=0.01)


@pytest.mark.parametrize("method", ["photon", "path"])
def test_an_environment_of_one_texel(method):
    """Irradiance is radiance · Σ solid angle · cosine; other texels give nothing."""
    height, row, column = 6, 1, 7
    image = np.zeros((height, 2 * height, 3))
    image[row, column] = 5.0
    result, _, _ = look_down(pm.EnvironmentLight(image), method, 6, 256, "rgb", seed=4)
    high, low = np.cos(np.pi * np.array([row, row + 1]) / height)
    irradiance = 5.0 * (2.0 * np.pi / (2 * height)) * 0.5 * (high**2 - low**2)
    truth = 0.8 / np.pi * irradiance
    assert_within(result.direct, truth, result.standard_error("direct"), 4.5, 1e-5)
    assert result.direct.mean() == pytest.approx(truth, rel=5e-3)


@pytest.mark.parametrize(
    ("view", "rotation", "column"),
    [
        ((0, 0, -1), 0.0, 0.5),
        ((1, 0, 0), 0.0, 0.75),
        ((-1, 0, 0), 0.0, 0.25),
        ((-1, 0, 0), 90.0, 0.5),
        ((0, 0, -1), 90.0, 0.75),
        ((0, 0, -1), -90.0, 0.25),
        ((0, 0, -1), 450.0, 0.75),
    ],
)
def test_the_background_shows_the_map(view, rotation, column):
    """At a rotation of 90° the centre column looks along -x."""
    image = np.zeros((8, 16, 3))
    image[...] = np.arange(16)[None, :, None] + 1.0
    image += 100.0 * np.arange(8)[:, None, None]
    view = np.array(view, float)
    up = np.array([0.0, 1.0, 0.0])
    camera = pm.Camera(tuple(view), tuple(2 * view), fov=1.0)
    scene = pm.Scene([BLOCK], [pm.EnvironmentLight(image, 2.0, rotation)], camera)
    lights = compile_scene(scene, RGB).lights
    for turn in (-0.05, 0.05):
        right = np.cross(view, up)
        for tilt, row in ((0.05, 3), (-0.05, 4)):
            towards = tuple(view + turn * right + tilt * up)
            seen = radiance_of(lights.environment, texel_at(lights.environment, towards))
            expected = 2 * (100 * row + int(16 * (column + turn / 7)) + 1)
            power = lights.environment.basis[0, 0]
            assert seen[0] * power == pytest.approx(expected * power / 2)


def test_background_pixels_are_emission():
    image = np.ones((4, 8, 3)) * [1.0, 2.0, 3.0]
    camera = pm.Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), fov=60.0)
    scene = pm.Scene([BLOCK], [pm.EnvironmentLight(image, 0.5)], camera)
    result = pm.render(scene, bands=6, size=(9, 9), passes=1, photons=100)
    truth = np.array([0.5, 1.0, 1.5]) @ Bands.gaussian(6).emission_basis
    np.testing.assert_allclose(result.emission[0, 0], truth, rtol=1e-5)
    assert (result.emission[4, 4] == 0.0).all()


def test_an_environment_in_the_furnace():
    """Walls of 0.5 around an opening: the even map lights a room as the dome of its radiance."""
    open_box = closed_box(pm.Material("wall", 0.5))
    room = pm.Mesh(open_box.vertices, open_box.faces[2:], open_box.material, "room")
    camera = pm.Camera((0.0, 0.0, 0.0), (0.3, 0.2, -1.0), fov=60.0)
    means = []
    for light in (pm.DomeLight(2.0), pm.EnvironmentLight(np.full((4, 8, 3), 1.0), 2.0)):
        scene = pm.Scene([room], [light], camera)
        result = pm.render(scene, bands="rgb", size=(12, 12), passes=16, seed=len(means))
        error = np.sqrt((result.standard_error("radiance").astype(float) ** 2).mean() / 144)
        means.append((result.radiance.mean(dtype=float), error))
    (a, first), (b, second) = means
    assert abs(a - b) < 5.0 * np.hypot(first, second) + 0.004 * a


LIGHTS = {
    "point": pm.PointLight((0.3, 0.5, 1.4), 2.0),
    "spot": pm.SpotLight((0.5, 0.6, 1.5), (-0.2, -1.0, 0.0), (5.0, 4.0, 3.0)),
    "directional": pm.DirectionalLight((0.3, -0.5, -1.0), (3.0, 2.0, 1.0)),
    "dome": pm.DomeLight(1.0),
    "environment": pm.EnvironmentLight(sky(), 2.0, 20.0),
}


@pytest.mark.parametrize("kind", LIGHTS)
def test_methods_agree_in_an_open_box(cornell, kind):
    """The Cornell box is open towards +z; z-scores of block means, and of the whole."""
    walls = [mesh for mesh in cornell.meshes if mesh.name != "light"]
    scene = pm.Scene(walls, [LIGHTS[kind]], cornell.camera)
    photon = pm.render(scene, bands="rgb", size=(16, 16), passes=16, seed=1)
    path = pm.render(scene, bands="rgb", size=(16, 16), passes=96, seed=2, method="path")
    for part in ("emission", "direct", "indirect"):
        blocks, variances = [], []
        for result in (photon, path):
            image = getattr(result, part).astype(float)
            noise = result.standard_error(part).astype(float) ** 2
            blocks.append(image.reshape(4, 4, 4, 4, 3).mean(axis=(1, 3)))
            variances.append(noise.reshape(4, 4, 4, 4, 3).sum(axis=(1, 3)) / 256)
        # Neighbours share indirect light, so the noise of a block is that of few pixels.
        error = np.sqrt((16.0 if part == "indirect" else 1.0) * variances[0] + variances[1])
        assert_within(blocks[0], blocks[1], error, 4.5, 0.01)
        whole = np.sqrt((error**2).sum()) / error.size
        assert_within(blocks[0].mean(), blocks[1].mean(), whole, 5.0, 0.005)
