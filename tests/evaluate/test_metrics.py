"""Metrics against loops over windows, values worked out by hand, and what must not change them."""

import math

import numpy as np
import pytest

from photonmap import InputError, evaluate
from photonmap.evaluate.metrics.scaled import WINDOW_FRACTION
from photonmap.spectra.color_difference import delta_e_2000
from photonmap.spectra.observer import observer

SCALE_INVARIANT = ("lmse", "lmse_mit", "si_mse", "si_lmse", "dssim", "whdr", "delta_e")


def noisy(shape, noise=0.2):
    """A truth in [0, 1], an estimate of another scale, and a mask."""
    rng = np.random.default_rng(7)
    truth = rng.uniform(0.1, 1.0, shape)
    estimate = 0.7 * truth + noise * rng.uniform(0.0, 1.0, shape)
    return truth, estimate, rng.uniform(size=shape[:2]) < 0.997


def windowed(truth, estimate, mask, side):
    """LMSE as loops: the errors and energies of rows of windows."""
    height, width = mask.shape
    errors, energies = [], []
    for top in range(0, height - side + 1, side // 2):
        errors.append([])
        energies.append([])
        for left in range(0, width - side + 1, side // 2):
            part = slice(top, top + side), slice(left, left + side)
            c, e = truth[part][mask[part]], estimate[part][mask[part]]
            energy = (e * e).sum()
            a = (c * e).sum() / energy if energy > 1e-5 else 0.0
            errors[-1].append(((c - a * e) ** 2).sum())
            energies[-1].append((c * c).sum())
    return np.array(errors), np.array(energies)


@pytest.mark.parametrize("shape", [(47, 53), (47, 53, 3), (30, 64, 6)])
@pytest.mark.parametrize("side", [20, 7])
def test_lmse_is_that_of_loops(shape, side):
    truth, estimate, mask = noisy(shape)
    estimate[:20, :20] = 0.0  # black: its factor is 0
    errors, energies = windowed(truth, estimate, mask, side)
    assert evaluate.lmse(truth, estimate, mask, side) == pytest.approx(
        errors.sum() / energies.sum(), rel=1e-12
    )
    assert evaluate.lmse_mit(truth, estimate, mask, side) == pytest.approx(
        errors.sum() / energies[:, -1].sum(), rel=1e-12
    )


def test_lmse_of_one_window_by_hand():
    """c = (1, 2), e = (1, 1): a = 3/2, error (1/4 + 1/4) / (1 + 4)."""
    truth, estimate = np.tile([1.0, 2.0], (20, 10)), np.ones((20, 20))
    assert evaluate.lmse(truth, estimate) == pytest.approx(0.1)
    assert evaluate.lmse(truth, np.zeros((20, 20))) == 1.0
    assert evaluate.lmse(truth, 1e-4 * estimate) == 1.0  # Σ e² is 4e-6


def test_lmse_counts_full_windows_alone():
    """29 pixels have room for one window of 20, 10 apart."""
    truth, estimate = np.ones((20, 29)), np.ones((20, 29))
    truth[:, 20:] = np.arange(9.0)
    assert evaluate.lmse(truth, estimate) == pytest.approx(0.0, abs=1e-15)


def test_sintel_windows_are_those_of_the_protocol():
    """In the protocol's own terms: pixels count from 1, and 2.5 is rounded to 3."""
    for shape in ((47, 53, 3), (25, 30), (12, 9, 3)):
        truth, estimate, mask = noisy(shape)
        height, width = shape[:2]
        side = math.floor(WINDOW_FRACTION * max(shape) + 0.5)
        step = math.floor(side / 2 + 0.5)
        errors = []
        for i in range(1, height - step + 1, step):
            for j in range(1, width - step + 1, step):
                part = (
                    slice(i - 1, min(height, i + side - 1)),
                    slice(j - 1, min(width, j + side - 1)),
                )
                c, e = truth[part][mask[part]], estimate[part][mask[part]]
                if c.size:
                    errors.append((((c * e).sum() / (e * e).sum() * e - c) ** 2).mean())
        assert evaluate.si_lmse(truth, estimate, mask) == pytest.approx(np.mean(errors), rel=1e-12)


def test_si_mse_by_hand():
    truth, estimate = np.array([[1.0, 2.0]]), np.array([[1.0, 1.0]])
    assert evaluate.si_mse(truth, estimate) == pytest.approx(0.25)
    mask = np.array([[True, False]])
    assert evaluate.si_mse(truth, estimate, mask) == 0.0


def ssim(truth, estimate, mask, peak):
    """Mean SSIM of valid windows, written out."""
    line = np.exp(-0.5 * (np.arange(-5, 6) / 1.5) ** 2)
    weights = np.outer(line, line) / line.sum() ** 2
    c1, c2 = (0.01 * peak) ** 2, (0.03 * peak) ** 2
    values = []
    for top in range(mask.shape[0] - 10):
        for left in range(mask.shape[1] - 10):
            part = slice(top, top + 11), slice(left, left + 11)
            if not mask[part].all():
                continue
            for x, y in zip(truth[part].T, estimate[part].T, strict=True):
                x, y = x.T, y.T
                mx, my = (weights * x).sum(), (weights * y).sum()
                vx, vy = (weights * (x - mx) ** 2).sum(), (weights * (y - my) ** 2).sum()
                both = (weights * (x - mx) * (y - my)).sum()
                values.append(
                    (2 * mx * my + c1) * (2 * both + c2) / (mx**2 + my**2 + c1) / (vx + vy + c2)
                )
    return np.mean(values)


@pytest.mark.parametrize("peak", [1.0, 4.0])
def test_dssim_is_that_of_loops(peak):
    """For the protocol's search, of which every step is evaluated here."""
    truth, estimate, mask = noisy((17, 19, 2))
    mask[:] = True
    mask[0, 0] = mask[16, 10] = False
    factor = (truth * estimate)[mask].sum() / (estimate**2)[mask].sum()

    def score(k):
        return ssim(truth, k * estimate, mask, peak)

    for power in range(2, 11):
        for step in (-(2.0**-power), 2.0**-power):
            while 0 < factor + step < 5 and score(factor + step) > score(factor):
                factor += step
    assert evaluate.dssim(truth, estimate, mask, peak) == pytest.approx(
        (1 - score(factor)) / 2, rel=1e-9
    )


@pytest.mark.parametrize("name", SCALE_INVARIANT)
def test_scale_does_not_count(name):
    """DSSIM searches in steps that do not scale, so that it is as good, but not the same."""
    truth, estimate, mask = noisy((40, 44, 3))
    metric = getattr(evaluate, name)
    value = metric(truth, estimate, mask)
    assert value > 0.0
    assert metric(truth, 1.7 * estimate, mask) == pytest.approx(
        value, rel=1e-3 if name == "dssim" else 1e-9
    )


@pytest.mark.parametrize("name", SCALE_INVARIANT)
def test_the_truth_has_no_error(name):
    truth, _, mask = noisy((40, 44, 3))
    assert getattr(evaluate, name)(truth, 0.5 * truth, mask) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("name", SCALE_INVARIANT)
def test_masked_values_do_not_count(name):
    truth, estimate, mask = noisy((40, 44, 3))
    metric = getattr(evaluate, name)
    value = metric(truth, estimate, mask)
    spoilt_truth, spoilt = truth.copy(), estimate.copy()
    spoilt_truth[~mask], spoilt[~mask] = 99.0, np.nan
    assert metric(spoilt_truth, spoilt, mask) == pytest.approx(value, rel=1e-12)


def test_grey_estimates_stand_for_equal_bands():
    truth, estimate, mask = noisy((25, 25, 3))
    grey = estimate[..., 0]
    same = np.repeat(grey[..., None], 3, axis=-1)
    for name in ("lmse", "si_mse", "si_lmse", "whdr"):
        metric = getattr(evaluate, name)
        assert metric(truth, grey, mask) == metric(truth, same, mask)


def test_whdr_by_hand():
    """Reflectances 1, 1.05, 1.2: equal, darker, darker; the estimate has the first pair wrong."""
    truth = np.array([[1.0, 1.05, 1.2]])
    estimate = np.array([[1.0, 1.2, 1.5]])
    pairs = evaluate.OrdinalPairs(
        np.array([[0, 0], [0, 1], [0, 2]]), np.array([[0, 1], [0, 2], [0, 0]])
    )
    assert evaluate.whdr(truth, estimate, pairs=pairs) == pytest.approx(1 / 3)
    assert evaluate.whdr(truth, estimate, pairs=pairs, weights=[2, 1, 1]) == pytest.approx(0.5)
    assert evaluate.whdr(truth, estimate, pairs=pairs, delta=0.25) == pytest.approx(1 / 3)
    assert evaluate.whdr(truth, 2.0 - 0.5 * truth, pairs=pairs) == pytest.approx(2 / 3)
    assert evaluate.whdr(truth, np.zeros((1, 3)), pairs=pairs) == pytest.approx(2 / 3)


def test_ordinal_pairs_keep_their_distance():
    mask = np.random.default_rng(0).uniform(size=(40, 60)) < 0.8
    pairs = evaluate.ordinal_pairs(mask, seed=3)
    points = np.unique(np.concatenate(pairs), axis=0)
    assert mask[points[:, 0], points[:, 1]].all()
    apart = np.linalg.norm(points[:, None] - points[None], axis=-1)
    assert apart[~np.eye(len(points), dtype=bool)].min() >= 0.07 * 60
    # no valid pixel is left that keeps the distance
    left = np.linalg.norm(np.argwhere(mask)[:, None] - points[None], axis=-1).min(axis=1)
    assert left.max() < 0.07 * 60
    again = evaluate.ordinal_pairs(mask, seed=3)
    np.testing.assert_array_equal(pairs.first, again.first)
    assert len(evaluate.ordinal_pairs(mask, seed=4).first) != len(pairs.first)


def test_albedo_errors_by_hand():
    """Two regions of 1 and 3 pixels, and one that belongs to none."""
    regions = np.array([[5, 9, 9, 9, 0]])
    truth = np.array([[0.2, 0.4, 0.4, 0.4, 7.0]])
    estimate = np.array([[0.2, 0.1, 0.2, 0.3, 9.0]])
    factor = (0.04 + 3 * 0.08) / (0.04 + 3 * 0.04)
    expected = ((0.2 - factor * 0.2) ** 2 + 3 * (0.4 - factor * 0.2) ** 2) / 4
    assert evaluate.albedo_intensity(truth, estimate, regions) == pytest.approx(expected)
    assert evaluate.albedo_texture(truth, estimate, regions) == pytest.approx(math.sqrt(0.5 / 4))


def test_chromaticity_is_that_of_regions_alone():
    """A factor for each region does not change it; a colour cast does, as its ΔE2000."""
    regions = np.array([[1, 1, 2, 2]])
    truth = np.array([[[0.2, 0.3, 0.4]] * 2 + [[0.5, 0.5, 0.5]] * 2])
    estimate = truth * np.array([0.5, 0.5, 3.0, 3.0])[None, :, None]
    assert evaluate.albedo_chromaticity(truth, estimate, regions) == pytest.approx(0.0, abs=1e-6)
    cast = truth * (1.2, 1.0, 1.0)
    same_grey = cast[0, ::2] * (truth / cast.mean(-1, keepdims=True)).mean(-1)[0, ::2, None]
    deltas = delta_e_2000(same_grey, truth[0, ::2], white=1.0)
    assert evaluate.albedo_chromaticity(truth, cast, regions) == pytest.approx(deltas.mean())


SHARMA = """
50 2.6772 -79.7751 50 0 -82.7485 2.0425
50 3.1571 -77.2803 50 0 -82.7485 2.8615
50 2.8361 -74.0200 50 0 -82.7485 3.4412
50 -1.3802 -84.2814 50 0 -82.7485 1.0000
50 -1.1848 -84.8006 50 0 -82.7485 1.0000
50 -0.9009 -85.5211 50 0 -82.7485 1.0000
50 0 0 50 -1 2 2.3669
50 -1 2 50 0 0 2.3669
50 2.4900 -0.0010 50 -2.4900 0.0009 7.1792
50 2.4900 -0.0010 50 -2.4900 0.0010 7.1792
50 2.4900 -0.0010 50 -2.4900 0.0011 7.2195
50 2.4900 -0.0010 50 -2.4900 0.0012 7.2195
50 -0.0010 2.4900 50 0.0009 -2.4900 4.8045
50 -0.0010 2.4900 50 0.0010 -2.4900 4.8045
50 -0.0010 2.4900 50 0.0011 -2.4900 4.7461
50 2.5 0 50 0 -2.5 4.3065
50 2.5 0 73 25 -18 27.1492
50 2.5 0 61 -5 29 22.8977
50 2.5 0 56 -27 -3 31.9030
50 2.5 0 58 24 15 19.4535
50 2.5 0 50 3.1736 0.5854 1.0000
50 2.5 0 50 3.2972 0 1.0000
50 2.5 0 50 1.8634 0.5757 1.0000
50 2.5 0 50 3.2592 0.3350 1.0000
60.2574 -34.0099 36.2677 60.4626 -34.1751 39.4387 1.2644
63.0109 -31.0961 -5.8663 62.8187 -29.7946 -4.0864 1.2630
61.2901 3.7196 -5.3901 61.4292 2.2480 -4.9620 1.8731
35.0831 -44.1164 3.7933 35.0232 -40.0716 1.5901 1.8645
22.7233 20.0904 -46.6940 23.0331 14.9730 -42.5619 2.0373
36.4612 47.8580 18.3852 36.2715 50.5065 21.2231 1.4146
90.8027 -2.0831 1.4410 91.1528 -1.6435 0.0447 1.4441
90.9257 -0.5406 -0.9208 88.6381 -0.8985 -0.7239 1.5381
6.7747 -0.2908 -2.4247 5.8714 -0.0985 -2.2286 0.6377
2.0776 0.0795 -1.1350 0.9033 -0.0636 -0.5514 0.9082
"""
"""L*, a*, b* of pairs and their ΔE2000: Sharma, Wu and Dalal 2005, table 1."""


def to_rgb(lab):
    """Linear sRGB of L*a*b* under D65, by the inverse of CIE 15."""
    y = (lab[:, 0] + 16) / 116
    f = np.stack([y + lab[:, 1] / 500, y, y - lab[:, 2] / 200], axis=1)
    white = np.array([0.3127, 0.3290, 1 - 0.3127 - 0.3290]) / 0.3290
    xyz = np.where(f > 6 / 29, f**3, 3 * (6 / 29) ** 2 * (f - 4 / 29)) * white
    return np.linalg.solve(observer().rgb_to_xyz, xyz.T).T


def test_color_differences_are_the_published_ones():
    table = np.array([line.split() for line in SHARMA.split("\n") if line], float)
    deltas = delta_e_2000(to_rgb(table[:, 3:6]), to_rgb(table[:, :3]), white=1.0)
    np.testing.assert_allclose(deltas, table[:, 6], atol=6e-5)


def test_delta_e_is_a_mean_after_one_factor():
    truth, estimate, mask = noisy((8, 9, 3))
    factor = (truth * estimate)[mask].sum() / (estimate**2)[mask].sum()
    deltas = delta_e_2000(factor * estimate, truth, white=1.0)
    assert evaluate.delta_e(truth, estimate, mask) == pytest.approx(deltas[mask].mean())


def test_angles_by_hand():
    assert evaluate.angular_error([1, 0, 0], [0, 2, 0]) == pytest.approx(90.0)
    assert evaluate.angular_error([1, 1, 1, 1], [3, 3, 3, 3]) == 0.0
    assert evaluate.angular_error([1, 1], [1, 0]) == pytest.approx(45.0)
    assert evaluate.angular_error([1, 0], [1, 1e-9]) == pytest.approx(math.degrees(1e-9))
    truth = np.array([[[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0, 1.0]]])
    np.testing.assert_allclose(evaluate.angular_error_map(truth, [1.0, 1.0]), [45.0, 45.0, 0.0])
    per_pixel = np.array([[[2.0, 0.0], [5.0, 0.0], [1.0, 1.0], [0.0, 0.0]]])
    np.testing.assert_allclose(evaluate.angular_error_map(truth, per_pixel), [0.0, 90.0, 90.0])
    mask = np.array([[True, True, True, False]])
    assert len(evaluate.angular_error_map(truth, per_pixel, mask)) == 2


def test_summary_by_hand():
    summary = evaluate.summarise_angles([5.0, 1.0, 2.0, 3.0, 4.0])
    assert (summary.mean, summary.median) == (3.0, 3.0)
    assert summary.trimean == (2.0 + 2 * 3.0 + 4.0) / 4
    assert (summary.best, summary.worst) == (1.5, 4.5)  # of 5, a quarter is 2
    assert evaluate.summarise_angles([7.0]).worst == 7.0


@pytest.mark.parametrize(
    ("truth", "estimate", "mask", "message"),
    [
        (np.ones((30, 30)), np.ones((30, 31)), None, "the estimate is 31×30 in 1 band, the truth"),
        (np.ones((30, 30, 3)), np.ones((30, 30, 2)), None, "in 2 bands, the truth 30×30 in 3"),
        (np.ones((30, 30)), np.ones((30, 30)), np.ones((3, 3)), "the mask is"),
        (np.ones((30, 30)), np.ones((30, 30)), np.zeros((30, 30)), "no pixel is valid"),
        (np.ones((30, 30)), np.full((30, 30), np.nan), None, "the estimate has NaN or infinity"),
        (np.ones(30), np.ones(30), None, "must be"),
        (
            np.ones((30, 30)),
            np.full((30, 30), 1j),
            None,
            "the estimate is of type complex128; give",
        ),
        (np.ones((30, 30)), [["a"]], None, "the estimate is of type <U1; give real numbers"),
        (np.ones((19, 30)), np.ones((19, 30)), None, "20×20 pixels does not fit into 30×19"),
        (np.zeros((30, 30)), np.ones((30, 30)), None, "the truth is black"),
    ],
)
def test_bad_input_is_named(truth, estimate, mask, message):
    with pytest.raises(InputError, match=message):
        evaluate.lmse(truth, estimate, mask)


def test_undefined_values_are_errors():
    image = np.ones((8, 8, 3))
    with pytest.raises(InputError, match="no window of 11×11 pixels is entirely valid"):
        evaluate.dssim(image, image)
    with pytest.raises(InputError, match="too small for windows of a tenth"):
        evaluate.si_lmse(np.ones((4, 4)), np.ones((4, 4)))
    with pytest.raises(InputError, match="do not form a triangle"):
        evaluate.whdr(image[:1], image[:1])
    with pytest.raises(InputError, match="no valid pixel belongs to a region"):
        evaluate.albedo_intensity(image, image, np.zeros((8, 8)))
    with pytest.raises(InputError, match="black or not finite"):
        evaluate.angular_error([1.0, 1.0], [0.0, 0.0])
    with pytest.raises(InputError, match="the colour is of type complex128; give real numbers"):
        evaluate.angular_error([1.0, 1.0], [1.0, 1j])
    with pytest.raises(InputError, match=r"must both have shape \(C,\); got \(2,\) and \(3,\)"):
        evaluate.angular_error([1.0, 1.0], [1.0, 1.0, 1.0])
    with pytest.raises(InputError, match="no light reaches"):
        evaluate.angular_error_map(np.zeros((2, 2, 3)), [1.0, 1.0, 1.0])
    with pytest.raises(InputError, match="no angular errors"):
        evaluate.summarise_angles([])
