"""What every kind of emitter must do: its samples, its photons and its importance agree."""

import numpy as np
import pytest
from emitter_cases import EMITTERS, PHOTONS, SKY, SUN, Samples, compiled, emit, floor_of
from helpers.comparisons import assert_within

from photonmap.kernels.lights import kinds
from photonmap.kernels.lights.triangle import BEFORE_LAMP

SIGMAS = 5.0
"""Allowed standard errors of a mean: one in 1.7 million is beyond."""
CELLS = 4
"""Cells of the floor along each side."""

AREAS = [name for name, kind in kinds.KINDS.items() if kind.has_area]

each_emitter = pytest.mark.parametrize("emitter", EMITTERS)
each_area = pytest.mark.parametrize("emitter", [e for e in EMITTERS if e in (SKY, *AREAS)])


def points_on_floor(emitter, count, seed=5):
    """Return points on the middle of the floor, where all lights shine, (n, 3)."""
    height, half = floor_of(emitter)
    x, z = np.random.default_rng(seed).uniform(-0.5 * half, 0.5 * half, (2, count))
    return np.stack([x, np.full(count, height), z], axis=1)


def watts(emitter):
    """Return the power of an emitter over that of all, from closed forms."""
    scene, arrays, number = compiled(emitter)
    lights = arrays.lights
    radius = lights.radius * arrays.size
    given = {light.kind: light for light in scene.lights}
    spot, sky = given["spot"], scene.lights[-1]
    inner, outer = np.cos(np.radians([spot.inner, spot.outer]))
    mean_sky = sky.radiance if hasattr(sky, "radiance") else None
    if mean_sky is None:
        edges = np.cos(np.linspace(0.0, np.pi, len(sky.image) + 1))
        rows = sky.image.mean(axis=1) @ pixel_weights(arrays)
        mean_sky = (rows * -np.diff(edges)).sum() / 2.0
    power = {
        "triangle": np.pi * lights.area[0] * arrays.size**2 * 2.0,
        "point": 4.0 * np.pi * given["point"].intensity,
        "spot": np.pi * spot.intensity * (2.0 - inner - outer),
        "directional": np.pi * radius**2 * given["directional"].irradiance,
        "photometric": 4.0 * np.pi * given["photometric"].intensity,
        "dome": (2.0 * np.pi * radius) ** 2 * mean_sky,
    }
    total = sum(closed_form(power, kind) for kind in kinds.KINDS)
    return power[list(kinds.KINDS)[lights.kind[number]]] / total


def closed_form(power, kind):
    """Return the power of a kind of emitter; that of each must be known."""
    assert kind in power, f"{__file__} has no closed form for emitters of kind {kind!r}; add it"
    return power[kind]


def pixel_weights(arrays):
    """Return what the single band makes of linear RGB."""
    return arrays.lights.environment.basis[:, 0].astype(float) * arrays.power


@each_emitter
def test_photons_carry_the_power_of_the_light(emitter):
    """Their mean flux is the light's share of all power; a table's mean is good to 1e-3."""
    _, directions, flux = emit(emitter)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-6)
    assert (flux >= 0.0).all()
    assert_within(flux.mean(), watts(emitter), flux.std() / np.sqrt(PHOTONS), SIGMAS, 1e-3)


@each_emitter
def test_photons_bring_the_irradiance_of_direct_light(emitter):
    """In each cell of the floor: flux through it over its area, and the mean of light samples."""
    height, half = floor_of(emitter)
    origins, directions, flux = emit(emitter)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (height - origins[:, 1]) / directions[:, 1]
    down = (t > 0.0) & (directions[:, 1] < 0.0)
    place = origins[down] + t[down, None] * directions[down]
    edges = np.linspace(-half, half, CELLS + 1)
    area = (2.0 * half / CELLS) ** 2
    sums, squares = (
        np.histogram2d(place[:, 0], place[:, 2], (edges, edges), weights=flux[down] ** power)[0]
        for power in (1, 2)
    )
    mean = sums / PHOTONS
    error = np.sqrt(np.maximum(squares / PHOTONS - mean**2, 0.0) / PHOTONS) / area
    truth, spread = direct_light(emitter, edges, height)
    assert (truth > 0.0).any()
    assert_within(mean / area, truth, np.hypot(error, spread), SIGMAS, 1e-3)


def direct_light(emitter, edges, height, count=20_000):
    """Return the mean irradiance of each cell by light samples, and its standard error."""
    low = np.stack(np.meshgrid(edges[:-1], edges[:-1], indexing="ij"), axis=-1).reshape(-1, 2)
    offset = np.random.default_rng(6).uniform(0.0, edges[1] - edges[0], (len(low), count, 2))
    x, z = np.moveaxis(low[:, None] + offset, -1, 0)
    points = np.stack([x, np.full_like(x, height), z], axis=-1).reshape(-1, 3)
    irradiance = Samples(emitter, points).irradiance.reshape(len(low), count)
    shape = len(edges) - 1, len(edges) - 1
    error = irradiance.std(axis=1) / np.sqrt(count)
    return irradiance.mean(axis=1).reshape(shape), error.reshape(shape)


@each_area
def test_samples_state_their_density(emitter):
    """By which they are weighed against rays that hit the emitter."""
    samples = Samples(emitter, points_on_floor(emitter, 2000))
    used = samples.weight > 0.0
    assert used.mean() > 0.9
    assert (samples.pdf[used] > 0.0).all()
    np.testing.assert_allclose(samples.pdf[used], samples.true_pdf[used], rtol=1e-6)
    if emitter == "triangle":
        np.testing.assert_allclose(samples.ray_pdf[used], samples.true_pdf[used], rtol=1e-6)


@each_area
def test_densities_integrate_to_1(emitter):
    """The mean of density over that of the sampler, over all that is seen of an emitter."""
    samples = Samples(emitter, points_on_floor(emitter, 50_000))
    ratio = samples.weight * samples.pdf
    assert_within(ratio.mean(), 1.0, ratio.std() / np.sqrt(len(ratio)), SIGMAS, 1e-9)


@each_emitter
def test_only_rays_that_may_hit_an_emitter_have_a_density(emitter):
    samples = Samples(emitter, points_on_floor(emitter, 100))
    is_area = emitter in (SKY, *AREAS)
    assert (samples.pdf > 0.0).any() == is_area
    far = emitter in (SKY, SUN) or not kinds.KINDS[emitter].has_place
    np.testing.assert_array_equal(samples.length, np.inf if far else BEFORE_LAMP if is_area else 1)


@pytest.mark.parametrize("emitter", [name for name in kinds.KINDS if name != "triangle"])
def test_importance_is_the_irradiance_of_a_power_of_1(emitter):
    """Exactly so where one sample tells all, on average for the dome."""
    _, arrays, number = compiled(emitter)
    samples = Samples(emitter, points_on_floor(emitter, 2000))
    radius, cosines = arrays.lights.radius, arrays.lights.parameters[number]
    power = {
        "point": 4.0 * np.pi,
        "spot": np.pi * (2.0 - cosines.sum()),
        "directional": np.pi * radius**2,
        "photometric": 4.0 * np.pi,
        "dome": (2.0 * np.pi * radius) ** 2,
    }
    irradiance = samples.weight * samples.cosine / closed_form(power, emitter)
    np.testing.assert_allclose(samples.importance, irradiance, rtol=1e-6)
    assert arrays.lights.kind[number] == kinds.NUMBERS[emitter]


@each_emitter
def test_what_lights_a_point_has_an_importance(emitter):
    """Nothing that sends light to a surface is left out of the choice, however it is turned."""
    points = points_on_floor(emitter, 500)
    for ns in ((0.0, 1.0, 0.0), (0.6, 0.0, -0.8), (0.0, -1.0, 0.0), (-0.48, 0.64, 0.6)):
        samples = Samples(emitter, points, ns)
        assert (samples.importance >= 0.0).all()
        assert (samples.importance[samples.irradiance > 0.0] > 0.0).all()


def test_importance_of_a_triangle_is_within_a_factor_of_2():
    _, arrays, _ = compiled("triangle")
    samples = Samples("triangle", np.repeat(points_on_floor("triangle", 100), 400, axis=0))
    irradiance = (samples.weight * samples.cosine).reshape(100, 400).mean(axis=1)
    importance = samples.importance.reshape(100, 400)[:, 0]
    ratio = importance * np.pi * arrays.lights.area[0] / irradiance
    assert ((ratio > 0.5) & (ratio < 2.0)).all()
