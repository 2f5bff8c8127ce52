"""Passes over a scene, without a render around them, and whether both methods bring one light."""

from functools import partial

import numpy as np
import pytest
from scipy import stats

from photonmap.compile.scene_arrays import compile_scene
from photonmap.film.blocks import block_means
from photonmap.film.light_groups import LightGroups
from photonmap.film.replicates import SIZES
from photonmap.integrators.base import PassSetup
from photonmap.integrators.choice import make_integrator
from photonmap.kernels.core.passes import (
    FIRST_CAUSTIC,
    VIA_CAUSTIC,
    VIA_DIRECT,
    VIA_INDIRECT,
    Film,
)
from photonmap.runtime.workers import Workers
from photonmap.spectra.bands import Bands

SIGNIFICANCE = 1e-4
"""Of all comparisons of one test together (Bonferroni): how probably it fails where all is well."""
BIAS = 0.01
"""Of what photons bring to a part of the image, relative: they are averaged over cells."""
SIDE = 12
"""Pixels across an image."""


def setup_of(compiled, workers, film=None, photons=4096, seed=1):
    """What passes over a compiled scene are made of; a film of one pixel by default."""
    bands = compiled.materials.reflectance.shape[1]
    return PassSetup(compiled, film or Film(1, 1, True), bands, photons, seed, workers)


def pass_means(scene, method, count, bands="rgb", photons=3000, seed=1):
    """Emission, direct and indirect light of quarters of the image in each pass, (n, 3, 2, 2, N).

    Passes are independent, so that their spread gives the error of a mean; those of a replicate are
    not, and make it hardly too large. Errors of pixels do not: pixels share photons and point sets,
    and errors of their mean are up to 2.4 times as large.
    """
    compiled = compile_scene(scene, Bands.parse(bands))
    found = []
    with Workers(2) as workers:
        setup = setup_of(compiled, workers, Film(SIDE, SIDE, True), photons, seed)
        integrator = make_integrator(method, setup)
        for index in range(count):
            pixels, via, _ = integrator.estimate(index)
            parts = np.array([pixels.emission, pixels.direct, pixels.indirect], float)
            if via is not None:
                parts[1] += via[VIA_DIRECT]
                parts[2] += via[[FIRST_CAUSTIC, VIA_INDIRECT, VIA_CAUSTIC]].sum(axis=0)
            images = parts.reshape(3, SIDE, SIDE, setup.bands).transpose(1, 2, 0, 3)
            found.append(compiled.power * block_means(images, SIDE // 2).transpose(2, 0, 1, 3))
    return np.array(found)


def independent_means(render, names, reduce, count, passes=1, seed=0, method="photon", **settings):
    """Return what `reduce` makes of means over some passes of a render, (count, names, …).

    It takes images, (P, N), and has to be linear. Passes are independent until they form
    replicates: then the next ones are those of another seed. Setting up is paid for once by many.
    """
    most = count if method == "path" else max(SIZES[-1][0] // passes, 1)
    found = []
    for first in range(0, count, most):
        number = min(most, count - first)
        some = {**settings, "passes": number * passes, "seed": seed + first, "method": method}
        means = _running_means(partial(render, **some), names, reduce, passes)
        assert len(means) == number
        sums = np.arange(1, number + 1).reshape(-1, *[1] * (means.ndim - 1)) * means
        found.append(np.diff(sums, axis=0, prepend=0.0))
    return np.concatenate(found)


def _running_means(render, names, reduce, passes):
    """Return what `reduce` makes of the means over all passes so far, after each few passes."""
    seen, scales, add, finish = {}, [], LightGroups.add, LightGroups.finish

    def add_and_look(self, *arguments):
        add(self, *arguments)
        images = seen.setdefault(self, [])
        if self.whole.count % passes == 0:
            images.append(finish(self, 1.0, names)[0])

    def finish_and_note(self, scale, *arguments):
        scales.append(scale)
        return finish(self, scale, *arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LightGroups, "add", add_and_look)
        patch.setattr(LightGroups, "finish", finish_and_note)
        render()
    *_, after = seen.values()  # before it, kernels may have been compiled by passes of their own
    return scales[-1] * np.array([[reduce(images[name]) for name in names] for images in after])


def _error(values):
    return values.std(axis=0, ddof=1) / np.sqrt(len(values))


def excess(values, others, bias=BIAS):
    """Return by how much means over passes differ by more than noise and bias, at most: 0 or less.

    Welch's t at the significance, shared by direct light and all light of all parts and bands.
    """
    one, other = (np.stack([each[:, 1], each.sum(axis=1)], axis=1) for each in (values, others))
    squares = np.stack([_error(one) ** 2, _error(other) ** 2])
    error = np.sqrt(squares.sum(axis=0))
    freedom = np.array([len(one), len(other)]).reshape(2, *[1] * error.ndim) - 1
    degrees = error**4 / np.maximum((squares**2 / freedom).sum(axis=0), 1e-300)
    allowed = stats.t.isf(SIGNIFICANCE / 2 / error.size, degrees) * error
    truth = other.mean(axis=0)
    return (np.abs(one.mean(axis=0) - truth) - allowed - bias * truth).max()


def assert_methods_agree(scene, photon=20, path=200, **settings):
    """Assert that photons and paths bring the same light: to the whole image, and to its parts.

    The error of the whole is below 1%.
    """
    one = pass_means(scene, "photon", photon, **settings)
    other = pass_means(scene, "path", path, **settings)
    whole = [each.mean(axis=(2, 3, 4)) for each in (one, other)]
    light = [each.sum(axis=1) for each in whole]
    assert np.hypot(*map(_error, light)) < 0.01 * light[1].mean()
    assert excess(*whole, bias=0.0) <= 0.0
    assert excess(one, other) <= 0.0
