"""Every kind of light against closed forms, and what describes them."""

import numpy as np
import pytest
from conftest import assert_within, closed_box, quad
from scipy import stats
from test_direct import DOWN, floor
from test_warp import chi_squared

import photonmap as pm
from photonmap.bands import Bands
from photonmap.chances import EVEN
from photonmap.hidden_lights import _only
from photonmap.kernels import rng, vec, warp
from photonmap.kernels.environment import (
    environment_pdf,
    radiance_at,
    sample_environment,
    texel_at,
)
from photonmap.kernels.jit import kernel
from photonmap.kernels.light import emit, start_flux
from photonmap.prepare import prepare
from photonmap.readers.panorama import read_panorama

RGB = Bands.rgb()
BLOCK = closed_box(pm.Material("block", 0.5), -0.5, 0.5)


def sky(height=8, seed=0):
    """Return a map whose texels differ, some of them black, one bright."""
    texels = np.random.default_rng(seed).random((height, 2 * height, 3)) ** 4
    texels[1:3, 2:5] = 0.0
    texels[2, 6] = 30.0
    return texels


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
@pytest.mark.parametrize(("inner", "outer"), [(5.0, 12.0), (8.0, 8.0), (0.0, 15.0), (20.0, 100.0)])
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


@pytest.mark.filterwarnings("ignore:no photon tells of the indirect light")
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
    lights = prepare(scene, RGB).lights
    for turn in (-0.05, 0.05):
        right = np.cross(view, up)
        for tilt, row in ((0.05, 3), (-0.05, 4)):
            seen = radiance_at(lights.environment, tuple(view + turn * right + tilt * up))
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
        result = pm.render(scene, bands="rgb", size=(12, 12), passes=32, seed=len(means))
        error = np.sqrt((result.standard_error("radiance").astype(float) ** 2).mean() / 144)
        means.append((result.radiance.mean(dtype=float), error))
    (a, first), (b, second) = means
    assert abs(a - b) < 5.0 * np.hypot(first, second) + 0.004 * a


@kernel
def sample_sky(environment, n, out, pdf):
    state = rng.stream(8, 0, 0)
    for i in range(n):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        (x, y, z), density = sample_environment(environment, u, v)
        out[i, 0], out[i, 1], out[i, 2], pdf[i] = x, y, z, density


@kernel
def sample_cone(cosine, n, out):
    state = rng.stream(9, 0, 0)
    for i in range(n):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        x, y, z = warp.uniform_cone(u, v, cosine)
        out[i, 0], out[i, 1], out[i, 2] = x, y, z


def test_environment_sampler():
    """χ² of directions against the density, which is the light's, and exact texel by texel."""
    n, height = 200_000, 8
    texels = sky(height)
    environment = prepare(
        pm.Scene([BLOCK], [pm.EnvironmentLight(texels, 3.0, 33.0)]), RGB
    ).lights.environment
    out, pdf = np.zeros((n, 3)), np.zeros(n)
    sample_sky(environment, n, out, pdf)
    np.testing.assert_allclose(np.linalg.norm(out, axis=1), 1.0, atol=1e-12)
    some = [tuple(map(float, d)) for d in out[:2000]]
    np.testing.assert_allclose([environment_pdf(environment, d) for d in some], pdf[:2000])
    assert environment_pdf(environment, _towards(1.5 / 8, 3.5 / 16, 33.0)) == 0.0

    solid = -np.diff(np.cos(np.linspace(0.0, np.pi, height + 1)))[:, None] * np.pi / height
    power = texels.astype(np.float32).mean(axis=2) * solid
    density = power / power.sum() / solid
    middles = [
        [environment_pdf(environment, _towards((r + 0.5) / 8, (c + 0.5) / 16, 33.0))
         for c in range(16)]
        for r in range(8)
    ]  # fmt: skip
    np.testing.assert_allclose(middles, density, rtol=1e-6, atol=1e-12)
    assert (np.array(middles) * solid).sum() == pytest.approx(1.0)
    # Half texels each way, so that places within texels are tested as well.
    theta = np.arccos(np.clip(out[:, 1], -1, 1))
    turn = (0.5 + np.arctan2(out[:, 0], -out[:, 2]) / (2 * np.pi) + 33.0 / 360.0) % 1.0
    counts = np.histogram2d(
        theta / np.pi, turn, (np.linspace(0, 1, 17), np.linspace(0, 1, 33))
    )[0]  # fmt: skip
    halves = -np.diff(np.cos(np.linspace(0.0, np.pi, 17)))[:, None] * np.pi / 16
    expected = n * np.repeat(np.repeat(density, 2, 0), 2, 1) * halves
    assert chi_squared(counts.ravel(), expected.ravel()) > 1e-4


def _towards(height, column, rotation):
    theta, phi = np.pi * height, 2 * np.pi * (column - 0.5) - np.radians(rotation)
    return (
        float(np.sin(theta) * np.sin(phi)),
        float(np.cos(theta)),
        float(-np.sin(theta) * np.cos(phi)),
    )


def test_poles_and_seams_are_texels():
    environment = prepare(pm.Scene([BLOCK], [pm.EnvironmentLight(sky())]), RGB).lights.environment
    for direction in ((0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (-0.0, 0.0, 1.0)):
        row, column = texel_at(environment, direction)
        assert 0 <= row < 8
        assert 0 <= column < 16


@pytest.mark.parametrize("degrees", [1.0, 30.0, 120.0])
def test_cone_sampler(degrees):
    n, cosine = 100_000, float(np.cos(np.radians(degrees)))
    out = np.zeros((n, 3))
    sample_cone(cosine, n, out)
    np.testing.assert_allclose(np.linalg.norm(out, axis=1), 1.0, atol=1e-12)
    z, phi = np.linspace(cosine, 1.0, 11), np.linspace(-np.pi, np.pi, 17)
    counts = np.histogram2d(out[:, 2], np.arctan2(out[:, 1], out[:, 0]), (z, phi))[0]
    assert counts.sum() == n
    expected = n * warp.uniform_cone_pdf(cosine) * (z[1] - z[0]) * (phi[1] - phi[0])
    assert stats.chisquare(counts.ravel(), np.full(160, expected)).pvalue > 1e-4


@kernel
def sum_power(geometry, lights, n, flux, total, worst):
    for index in range(n):
        key = rng.stream(3, 0, 0)
        place = rng.sobol_2d(index, key)
        aim = rng.sobol_2d(index, rng.stream(3, 1, 0))
        emitter, weight, spot, _, direction = emit(geometry, lights, place, aim)
        start_flux(flux, lights, emitter, spot, direction, weight / n)
        worst[0] = max(worst[0], abs(vec.dot(direction, direction) - 1.0))
        for band in range(len(flux)):
            total[emitter, band] += flux[band]


SCALE = 3.0
"""Of the block that the power's test lights, so that units matter."""


def sky_power(texels, radius):
    """∫ L dω times the disk."""
    solid = -np.diff(np.cos(np.linspace(0.0, np.pi, len(texels) + 1))) * np.pi / len(texels)
    return (texels * solid[:, None, None]).sum(axis=(0, 1)) * np.pi * radius**2


RADIUS = 1.001 * np.sqrt(3.0) / 2.0 * SCALE
POWERS = [
    (pm.PointLight((0, 0, 2), (1.0, 2.0, 3.0)), 4.0 * np.pi * np.array([1, 2, 3])),
    (
        pm.SpotLight((0, 0, 2), (0, 0, 0), (1.0, 2.0, 3.0), 25.0, 40.0),
        np.pi * (2.0 - np.cos(np.radians(25)) - np.cos(np.radians(40))) * np.array([1, 2, 3]),
    ),
    (
        pm.SpotLight((0, 0, 2), (0, 1, 0), 1.0, 90.0, 90.0),
        2.0 * np.pi * np.ones(3),
    ),
    (
        pm.DirectionalLight((1, -2, 0.5), (1.0, 2.0, 3.0)),
        np.pi * RADIUS**2 * np.array([1, 2, 3]),
    ),
    (pm.DomeLight(2.0), np.full(3, 2.0 * (2.0 * np.pi * RADIUS) ** 2)),
    (pm.EnvironmentLight(sky(), 2.0, 10.0), 2.0 * sky_power(sky(), RADIUS)),
]


@pytest.mark.parametrize(("light", "power"), POWERS)
def test_photons_carry_the_power(light, power):
    block = closed_box(pm.Material("block", 0.5), -SCALE / 2, SCALE / 2)
    prepared = prepare(pm.Scene([block], [light, pm.PointLight((1, 1, 1), 0.7)]), RGB)
    n, flux, total, worst = 1 << 18, np.zeros(3, np.float32), np.zeros((2, 3)), np.zeros(1)
    sum_power(prepared.geometry, prepared.lights, n, flux, total, worst)
    # Radiance scales with power, power with area as well.
    factor = prepared.power * prepared.size**2
    np.testing.assert_allclose(total[0] * factor, power, rtol=4e-3)
    np.testing.assert_allclose(total[1] * factor, 4.0 * np.pi * 0.7, rtol=4e-3)
    assert worst[0] < 1e-12
    assert total.mean(axis=1).sum() == pytest.approx(1.0, rel=1e-3)
    chances = np.diff(prepared.lights.cumulative, prepend=0.0)
    share = 4.0 * np.pi * 0.7 / factor
    assert chances[1] == pytest.approx((1.0 - EVEN) * share + EVEN / 2, rel=1e-6)

    for member in range(2):
        alone = _only(prepared.lights, np.array([member]))
        total[:] = 0.0
        sum_power(prepared.geometry, alone, 1 << 16, flux, total, worst)
        truth = power if member == 0 else 4.0 * np.pi * 0.7
        np.testing.assert_allclose(total[0] * factor, truth, rtol=4e-3)


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
    photon = pm.render(scene, bands="rgb", size=(16, 16), passes=48, seed=1)
    path = pm.render(scene, bands="rgb", size=(16, 16), passes=192, seed=2, method="path")
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


def test_names_and_groups():
    lamp = pm.Material("spot", 0.5, 1.0)
    lights = [
        pm.PointLight((0, 0, 2)),
        pm.PointLight((0, 0, 3), name="point 2"),
        pm.PointLight((0, 0, 4), group="warm"),
        pm.SpotLight((0, 0, 2), (0, 0, 0)),
        pm.DirectionalLight((0, -1, 0), 0.0, "off"),
        pm.DirectionalLight((0, -1, 0), name="sun", group="warm"),
        pm.EnvironmentLight(np.ones((1, 2, 3))),
    ]
    prepared = prepare(
        pm.Scene([quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), lamp)], lights), RGB
    )
    assert prepared.light_names == [
        "spot", "spot", "point", "point 2", "point 3", "spot 2", "sun", "environment",
    ]  # fmt: skip
    assert prepared.light_groups == [
        "spot", "spot", "point", "point 2", "warm", "spot 2", "warm", "environment",
    ]  # fmt: skip
    assert prepared.counts["lights"] == 7
    assert prepared.counts["spectra"] is False


@pytest.mark.parametrize(
    "lights",
    [
        [pm.PointLight((0, 0, 2), name="sun"), pm.DirectionalLight((0, -1, 0), name="sun")],
        [pm.DirectionalLight((0, -1, 0), name="lamp")],
    ],
)
def test_two_lights_of_one_name(lights):
    block = closed_box(pm.Material("lamp", 0.5, 1.0))
    name = lights[0].name
    with pytest.raises(pm.InputError, match=f"^two lights are named '{name}'; give each its own"):
        prepare(pm.Scene([block], lights), RGB)


def test_a_black_environment_is_no_light():
    scene = pm.Scene([BLOCK], [pm.EnvironmentLight(np.zeros((2, 4, 3)))])
    with pytest.warns(pm.SceneWarning, match="no light"):
        lights = prepare(scene, RGB).lights
    assert lights.environment is None


SPOT = pm.SpotLight((0, 0, 2), (0, 0, 0))


@pytest.mark.parametrize(
    ("light", "message"),
    [
        (pm.SpotLight((0, 0, 2), (0, 0, 2)), r"'spot': target \(0, 0, 2\) is where the position"),
        (pm.SpotLight((0, 0, 2), (0, np.nan, 2)), r"target .* is no point"),
        (pm.SpotLight((0, 0, 2), (0, 0, 0), inner=40), "inner 40 is no half-angle from 0 .*30 deg"),
        (pm.SpotLight((0, 0, 2), (0, 0, 0), inner=-1), "inner -1 is no half-angle"),
        (pm.SpotLight((0, 0, 2), (0, 0, 0), inner=0, outer=0), "outer 0 is no half-angle"),
        (pm.SpotLight((0, 0, 2), (0, 0, 0), outer=180), "outer 180 is no half-angle"),
        (pm.SpotLight((0, 0, 2), (0, 0, 0), outer=np.inf), "outer inf is no angle"),
        (pm.SpotLight((0, 0, 2), (0, 0, 0), -1.0), "'spot' emits -1"),
        (pm.DirectionalLight((0, 0, 0)), r"direction \(0, 0, 0\) has no length"),
        (pm.DirectionalLight((0, 0)), r"direction \(0, 0\) is no direction"),
        (pm.DirectionalLight((0, 0, 1), -2.0, "sun"), "'sun' emits -2"),
        (pm.DomeLight(1.0, 3), "name 3 is no text"),
        (pm.EnvironmentLight(np.ones((4, 8, 3)), -1.0), "scale -1.0 is negative"),
        (pm.EnvironmentLight(np.ones((4, 8, 3)), np.nan), "scale nan is no factor"),
        (pm.EnvironmentLight(np.ones((4, 8, 3)), 1.0, "x"), "rotation 'x' is no angle"),
        (pm.EnvironmentLight(np.ones((4, 7, 3))), "is 7x4; a map all around is twice as wide"),
        (pm.EnvironmentLight(np.ones((4, 8))), "is no map of radiance"),
        (pm.EnvironmentLight("nowhere.exr"), "'environment': nowhere.exr: cannot be read"),
    ],
)
def test_bad_lights(light, message):
    with pytest.raises(pm.InputError, match=message):
        prepare(pm.Scene([BLOCK], [light]), RGB)


def test_one_sky_at_most():
    lights = [pm.DomeLight(), pm.EnvironmentLight(np.ones((2, 4, 3)), name="sky")]
    with pytest.raises(pm.InputError, match=r"one dome or environment at most.*'dome' and 'sky'"):
        prepare(pm.Scene([BLOCK], lights), RGB)


def write_image(path, pixels, kind="float"):
    import OpenImageIO

    file = OpenImageIO.ImageOutput.create(str(path))
    spec = OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    assert file.open(str(path), spec)
    assert file.write_image(pixels)
    file.close()
    return path


def test_images_of_many_kinds(tmp_path):
    texels = sky(4).astype(np.float32)
    np.testing.assert_array_equal(read_panorama(write_image(tmp_path / "a.exr", texels)), texels)
    hdr = read_panorama(write_image(tmp_path / "a.hdr", texels))
    np.testing.assert_allclose(hdr, texels, rtol=0.02, atol=0.02 * texels.max(axis=2).max())
    coded = np.full((2, 4, 3), 188, np.uint8)
    coded[0, 0] = [0, 10, 255]
    linear = read_panorama(write_image(tmp_path / "a.png", coded, "uint8"))
    np.testing.assert_allclose(linear[1, 1], ((188 / 255 + 0.055) / 1.055) ** 2.4, rtol=1e-6)
    np.testing.assert_allclose(linear[0, 0], [0.0, 10 / 255 / 12.92, 1.0], rtol=1e-6)
    with_alpha = np.concatenate([texels, np.ones((4, 8, 1), np.float32)], axis=2)
    np.testing.assert_array_equal(
        read_panorama(write_image(tmp_path / "b.exr", with_alpha)), texels
    )


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
def test_bad_pixels_are_named(tmp_path, value):
    texels = sky(4).astype(np.float32)
    texels[2, 5, 1] = value
    path = write_image(tmp_path / "bad.exr", texels)
    message = rf"bad\.exr: pixel \(row 2, column 5\) is {value:g}; radiance is finite"
    with pytest.raises(pm.InputError, match=message):
        read_panorama(path)
    with pytest.raises(pm.InputError, match=r"'environment': pixel \(row 2, column 5\)"):
        prepare(pm.Scene([BLOCK], [pm.EnvironmentLight(texels)]), RGB)


def test_bad_images(tmp_path):
    with pytest.raises(pm.InputError, match=r"a\.exr: is 6x4; .*twice"):
        read_panorama(write_image(tmp_path / "a.exr", np.ones((4, 6, 3), np.float32)))
    with pytest.raises(pm.InputError, match=r"b\.exr: has no channel R"):
        read_panorama(write_image(tmp_path / "b.exr", np.ones((4, 8, 1), np.float32)))
    (tmp_path / "c.exr").write_text("no image")
    with pytest.raises(pm.InputError, match=r"c\.exr: cannot be read \("):
        read_panorama(tmp_path / "c.exr")
