"""Photons aimed at spheres bring them the same light as photons sent anywhere."""

import numpy as np
import pytest
from emitter_cases import EMITTERS, PHOTONS, compiled, emit

from photonmap.integrators.photon_mapping.caustics import even_guide
from photonmap.kernels.caustics.aim import aim_photon
from photonmap.kernels.core import rng
from photonmap.kernels.core.jit import kernel

SIGMAS = 5.0
"""Allowed standard errors of a difference: one in 1.7 million is beyond."""
SPHERES = np.array(
    [
        (0.1, -0.2, 0.0, 0.08),
        (0.15, -0.18, 0.03, 0.06),  # overlaps the first
        (-0.25, 0.0, 0.2, 0.03),
        (0.05, 0.1, 0.0, 0.5),  # holds most lights
    ]
)
IMPORTANCE = np.array([1.0, 0.3, 2.0, 0.5])


@kernel
def aim_all(geometry, lights, guide, sums, origins, directions, flux):
    state = rng.stream(5, 0, 0)
    for i in range(len(flux)):
        a, state = rng.draw(state)
        b, state = rng.draw(state)
        c, state = rng.draw(state)
        d, state = rng.draw(state)
        origin, direction, _ = aim_photon(
            geometry, lights, guide, sums, (a, b), (c, d), 1.0, flux[i]
        )
        for axis in range(3):
            origins[i, axis], directions[i, axis] = origin[axis], direction[axis]


def aim(emitter, spheres):
    _, arrays, number = compiled(emitter)
    alone = (np.arange(len(arrays.lights.kind)) >= number).astype(float)
    guide = even_guide(spheres)._replace(importance=IMPORTANCE[: len(spheres)])
    origins, directions = np.empty((2, PHOTONS, 3))
    flux = np.empty((PHOTONS, 1), np.float32)
    aim_all(
        arrays.geometry, arrays.lights._replace(cdf=alone), guide, np.empty(len(spheres)),
        origins, directions, flux,
    )  # fmt: skip
    return origins, directions, flux[:, 0].astype(float)


def hits(origins, directions, sphere):
    """Return whether rays reach a sphere, or begin in it."""
    step = sphere[:3] - origins
    along = (step * directions).sum(axis=1)
    squared = (step**2).sum(axis=1)
    radius = sphere[3] ** 2
    return (squared <= radius) | ((along > 0.0) & (squared - along**2 <= radius))


@pytest.mark.parametrize("count", [1, 3, 4])
@pytest.mark.parametrize("emitter", EMITTERS)
def test_aimed_photons_bring_spheres_their_light(emitter, count):
    """The mean flux through each sphere, by photons of both sorts."""
    spheres = SPHERES[:count]
    anywhere, aimed = emit(emitter), aim(emitter, spheres)
    reached, brought = np.zeros(PHOTONS, bool), 0.0
    for sphere in spheres:
        means, variances = [], []
        for origins, directions, flux in (anywhere, aimed):
            through = flux * hits(origins, directions, sphere)
            means.append(through.mean())
            variances.append(through.var() / PHOTONS)
        assert abs(means[0] - means[1]) <= SIGMAS * np.sqrt(sum(variances)) + 1e-6 * means[0]
        reached |= hits(*aimed[:2], sphere)
        brought += means[1]
    assert brought > 0.0
    assert reached[aimed[2] > 0.0].mean() > (0.999 if count < 4 else 0.5)


@pytest.mark.parametrize("emitter", [e for e in EMITTERS if e != "triangle"])
def test_photons_aimed_at_one_sphere_are_alike(emitter):
    """Their flux hardly varies, where positions do not matter and the light's own is even."""
    flux = aim(emitter, SPHERES[:1])[2]
    assert flux.min() > 0.0
    assert flux.std() < 0.35 * flux.mean()
