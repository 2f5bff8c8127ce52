"""What every hard case shares: small renders, what must hold of each, and comparisons of means."""

from functools import partial

import numpy as np
from scipy import stats

import photonmap as pm

SIGNED = ("covariance", "normal", "residual")
"""Buffers that may be negative by nature."""
ULP = 2.0**-23
SMALLEST = 1e-36
"""Below, float32 has fewer digits."""
SIGNIFICANCE = 1e-3
"""Of one comparison of means: the probability that it fails where nothing is wrong."""
LIGHT = ("radiance", "emission", "direct", "indirect", "shading")


def rendered(scene, **settings):
    """Render small images, and check all that holds of any."""
    few = {"bands": 2, "size": (12, 12), "passes": 4, "photons": 2000, "threads": 2}
    result = pm.render(scene, **{**few, **settings})
    check(result)
    return result


def check(result):
    """Assert what holds of every result: sound numbers, and buffers that add up.

    Light that a negative residual takes away again may be less than 0 by 8 ulp of it.
    """
    rounding = 8 * ULP * np.abs(result.residual).max(initial=0.0)
    for kind, images in (("buffer", result.buffers), ("error", result.errors)):
        for name, image in images.items():
            assert np.isfinite(image).all(), f"{kind} {name} is not finite"
            if name.partition("@")[0] not in SIGNED or kind == "error":
                least = -rounding if name in ("radiance", "indirect") else 0.0
                assert (image >= least).all(), f"{kind} {name} is negative"
    assert (result.reflectance <= 1.0).all()
    assert (result.coverage <= 1.0).all()
    check_sums(result)
    check_geometry(result)


def check_sums(result):
    """radiance = (emission + direct) + indirect; direct + indirect = reflectance × shading + rest.

    The former to the last bit. The latter to 8 ulp of the larger side, of numbers rounded apart.
    """
    light = (result.emission + result.direct) + result.indirect
    np.testing.assert_array_equal(result.radiance, light)
    left = result.direct.astype(float) + result.indirect
    lambertian = result.reflectance.astype(float) * result.shading
    most = np.maximum(left, np.maximum(lambertian, np.abs(result.residual)))
    assert (np.abs(left - lambertian - result.residual) <= 8 * ULP * most + SMALLEST).all()
    if "caustics" in result.buffers:
        rounding = 8 * ULP * (result.indirect + np.abs(result.residual)) + SMALLEST
        assert (result.caustics <= result.indirect + rounding).all()


def check_geometry(result):
    """Normals are of length 1 where there is a surface, and all is 0 where there is none."""
    seen = result.object_id > 0
    length = np.linalg.norm(result.normal, axis=-1)
    np.testing.assert_allclose(length[seen], 1.0, atol=1e-5)
    assert not length[~seen].any()
    assert not result.depth[~seen].any()
    empty = result.coverage == 0.0
    for name in ("direct", "indirect", "reflectance", "shading"):
        assert not result.buffers[name][empty].any(), f"{name} without a surface"


def means(scene, buffer="radiance", count=12, passes=1, **settings):
    """Return so many means over pixels, each of some passes of a render, (count, bands)."""
    return means_of(scene, count, passes, **settings)[buffer]


def means_of(scene, count=12, passes=1, **settings):
    """Return the means of all light's buffers, by name, as `means`."""
    from helpers.passes import independent_means  # `checked.py` runs without the path to it

    found = independent_means(
        partial(rendered, scene),
        LIGHT,
        lambda image: image.mean(axis=0, dtype=float),
        count,
        passes,
        **settings,
    )
    return dict(zip(LIGHT, found.swapaxes(0, 1), strict=True))


def assert_mean(values, truth, slack=1e-3):
    """Assert that independent means, (count, bands), agree with the truth, (bands,).

    Within so many standard errors as t at the significance has, shared by all bands; and a bias of
    `slack` of the truth, that of a finite number of photons.
    """
    values, truth = np.atleast_2d(values), np.atleast_1d(truth)
    error = stats.sem(values, axis=0)
    sigmas = stats.t.isf(SIGNIFICANCE / 2 / values.shape[1], len(values) - 1)
    deviation = np.abs(values.mean(axis=0) - truth)
    assert (deviation <= sigmas * error + slack * np.abs(truth)).all(), (
        f"{values.mean(axis=0)} is not {truth} ± {sigmas:.3g} · {error}"
    )


def assert_same(values, others, slack=1e-3):
    """Assert that two sets of means, in pairs, do not differ; as `assert_mean`."""
    truth = np.abs(others).mean(axis=0)
    error = stats.sem(values - others, axis=0)
    sigmas = stats.t.isf(SIGNIFICANCE / 2 / values.shape[1], len(values) - 1)
    deviation = np.abs((values - others).mean(axis=0))
    assert (deviation <= sigmas * error + slack * truth).all(), (
        f"{values.mean(axis=0)} and {others.mean(axis=0)} differ by more than "
        f"{sigmas:.3g} · {error}"
    )
