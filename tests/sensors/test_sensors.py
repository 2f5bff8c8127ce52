"""What N bands cost after interreflection: closed forms, and the published table."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from photonmap.errors import InputError
from photonmap.sensors import interreflection
from photonmap.sensors.comparison import (
    best_bands,
    color_errors,
    differences,
    exact_colors,
    projection_matrix,
    spread_bands,
)
from photonmap.sensors.interreflection import band_values, interreflection_errors, sensitivity_nodes
from photonmap.spectra.bands import Bands
from photonmap.spectra.color_text import emission
from photonmap.spectra.curves import Spectrum, SpectrumSet
from photonmap.spectra.munsell import munsell_set, shipped_set
from photonmap.spectra.names import colour_science
from photonmap.spectra.observer import observer

MEASURED = Path(__file__).parents[3] / "shared" / "data" / "munsell_matt_1269.npz"
FLAT = Spectrum([380.0, 780.0], [1.0, 1.0])
TABLE = {  # percent: mean and max after one bounce, after two, and of Eq. 4 as written
    3: ((0.58, 2.88), (1.38, 23.84), (0.63, 5.67)),
    6: ((0.19, 1.25), (0.55, 9.06), (0.22, 2.49)),
    9: ((0.12, 0.86), (0.34, 3.77), (0.14, 1.21)),
}


def curves(*rows, wavelengths=(380.0, 780.0)):
    """A set of curves called a, b, c …"""
    names = tuple("abcdefgh"[: len(rows)])
    return SpectrumSet(np.array(wavelengths, float), np.array(rows, float), names)


@pytest.fixture(scope="module")
def light():
    """D65."""
    return Spectrum(observer().wavelengths, observer().d65)


@pytest.fixture(scope="module")
def chips():
    """Some of the shipped chips, of all hues."""
    every = shipped_set()
    return SpectrumSet(every.wavelengths, every.values[::61], every.names[::61])


measured = pytest.mark.skipif(not MEASURED.exists(), reason="no measured Munsell chips here")


@measured
@pytest.mark.parametrize("n", TABLE)
def test_the_published_table(n, light):
    chips, bands = munsell_set(str(MEASURED)), Bands.gaussian(n)
    one, two, both = TABLE[n]
    for (mean, worst), bounces, direct_too in ((one, 1, False), (two, 2, False), (both, 2, True)):
        row = interreflection_errors(chips, light, bands, bounces, direct_too=direct_too)
        assert 100 * row.mean == pytest.approx(mean, rel=0.1)
        assert 100 * row.worst == pytest.approx(worst, rel=0.1)
        assert len(row.worst_pair) == bounces
    assert row.kept == 1.0


@measured
def test_exact_integrals_miss_one_number_of_the_table(light):
    chips, bands = munsell_set(str(MEASURED)), Bands.gaussian(9)
    row = interreflection_errors(chips, light, bands, 1, step=0.5)
    assert 100 * row.worst == pytest.approx(0.757, abs=0.001)  # 0.86 there
    assert row.worst_pair == ("5P 2.5/6",)


@pytest.mark.parametrize("bands", [Bands.gaussian(1), Bands.gaussian(6), Bands.box(7)])
@pytest.mark.parametrize("bounces", [1, 2, 5])
@pytest.mark.parametrize("direct_too", [False, True])
def test_greys_have_no_error(light, bands, bounces, direct_too):
    greys = curves([0.9, 0.9], [0.7, 0.7])
    row = interreflection_errors(greys, light, bands, bounces, direct_too=direct_too)
    assert row.worst < 1e-12
    assert row.kept == 1.0


def test_two_steps_in_boxes_by_hand():
    # In the left one of two boxes each curve takes two values, half of the box each.
    a, b = (0.2, 0.8, 0.8), (0.6, 0.4, 0.4)
    grid = [400.0, 475.0 - 1e-7, 475.0 + 1e-7, 700.0]
    pair = curves(*([low, low, high, high] for low, high, _ in (a, b)), wavelengths=grid)
    row = interreflection_errors(pair, FLAT, Bands.box(2), 2, dark=0.0, step=0.01)
    errors = []
    for first in (a, b):
        for second in (a, b):
            truth = (first[0] * second[0] + first[1] * second[1]) / 2, first[2] * second[2]
            left = (first[0] + first[1]) / 2 * (second[0] + second[1]) / 2
            errors.append(abs(left - truth[0]) / np.hypot(*truth))
    assert row.mean == pytest.approx(np.mean(errors), rel=1e-3)
    assert row.worst == pytest.approx(max(errors), rel=1e-3)
    assert row.worst_pair == ("a", "a")
    assert interreflection_errors(pair, FLAT, Bands.box(4), 2, step=0.01).worst < 2e-4


@pytest.mark.parametrize("bounces", [1, 2, 3, 6])
def test_bounces_of_one_chip_against_quadrature(light, bounces):
    chip = curves([0.9, 0.5, 0.8], wavelengths=[400.0, 520.0, 700.0])
    bands = Bands.gaussian(2)

    def integral(curve, *powers):
        def product(at):
            reflectance, illuminant = chip[0](at) ** powers[0], light(at) ** powers[1]
            return curve(at) * reflectance * illuminant

        ends = np.arange(400.0, 700.0, 5.0)
        return sum(quad(product, end, end + 5.0, limit=200, epsrel=1e-5)[0] for end in ends)

    truth = np.array([integral(curve, bounces, 1) for curve in bands.sensitivities])
    estimate = [
        integral(curve, 0, 1) * integral(curve, 1, 0) ** bounces for curve in bands.sensitivities
    ]
    error = np.linalg.norm(estimate - truth) / np.linalg.norm(truth)
    row = interreflection_errors(chip, light, bands, bounces, dark=0.0, step=0.25)
    assert row.mean == row.worst == pytest.approx(error, rel=1e-3)
    assert row.worst_pair == ("a",) * min(bounces, 2)


@pytest.mark.parametrize(("step", "off"), [(5.0, 3e-2), (1.0, 2e-3), (0.5, 1e-3)])
@pytest.mark.parametrize("n", [3, 9])
def test_samples_against_exact_integrals(chips, light, n, step, off):
    bands = Bands.gaussian(n)
    few = SpectrumSet(chips.wavelengths, chips.values[::3], chips.names[::3])
    knots, weights = np.polynomial.legendre.leggauss(3)
    missed = truth = 0.0
    for curve in bands.sensitivities:
        grid = np.unique(np.concatenate([curve.wavelengths, few.wavelengths, light.wavelengths]))
        grid = grid[(grid >= curve.wavelengths[0]) & (grid <= curve.wavelengths[-1])]
        half = np.diff(grid)[:, None] / 2.0
        at = (grid[:-1, None] + half * (1.0 + knots)).ravel()
        rho = (half * weights).ravel() * curve(at)
        seen, lit = few.at(at), rho * light(at)
        exact = (seen * lit) @ seen.T
        missed = missed + (exact - lit.sum() * np.outer(seen @ rho, seen @ rho)) ** 2
        truth = truth + exact**2
    errors = np.sqrt(missed / truth)
    row = interreflection_errors(few, light, bands, 2, dark=0.0, step=step)
    assert row.mean == pytest.approx(errors.mean(), rel=off)
    assert row.worst == pytest.approx(errors.max(), rel=off)


def test_the_order_of_a_pair_says_nothing(chips, light):
    turned = SpectrumSet(chips.wavelengths, chips.values[::-1], chips.names[::-1])
    for bounces in (2, 4):
        there, back = (
            interreflection_errors(some, light, Bands.gaussian(3), bounces, dark=0.01)
            for some in (chips, turned)
        )
        assert there.mean == pytest.approx(back.mean, rel=1e-12)
        assert there.worst == pytest.approx(back.worst, rel=1e-12)
        assert set(there.worst_pair) == set(back.worst_pair)
        assert there.kept == back.kept


def test_narrow_sensors_do_not_err(chips, light):
    errors = [
        interreflection_errors(chips, light, Bands.gaussian(3, sigma=sigma), 2).worst
        for sigma in (20.0, 2.0, 0.2)
    ]
    assert errors[0] > 50.0 * errors[1] > 500.0 * errors[2]


def test_blocks_of_rows_change_nothing(chips, light, monkeypatch):
    rows = []
    for block in (1, 7, 1000):
        monkeypatch.setattr(interreflection, "BLOCK", block)
        rows.append(interreflection_errors(chips, light, Bands.gaussian(6), 3))
    for row in rows[1:]:
        assert row.mean == pytest.approx(rows[0].mean, rel=1e-12)
        assert (row.worst_pair, row.kept) == (rows[0].worst_pair, rows[0].kept)


def test_dark_pairs_do_not_count(light):
    pair = curves([0.5, 0.5], [0.1, 0.1])
    assert interreflection_errors(pair, light, Bands.gaussian(3), 2).kept == 0.75
    assert interreflection_errors(pair, light, Bands.gaussian(3), 1).kept == 1.0
    with pytest.raises(InputError, match="too dark"):
        interreflection_errors(pair, light, Bands.gaussian(3), 2, dark=0.3)
    with pytest.raises(InputError, match="too dark"):
        interreflection_errors(curves([0.0, 0.0]), light, Bands.gaussian(3), 1)


def test_curves_must_cover_the_bands(light):
    short = curves([0.5, 0.5], wavelengths=[420.0, 700.0])
    with pytest.raises(InputError, match="400-420"):
        interreflection_errors(short, light, Bands.gaussian(3), 1)
    with pytest.raises(InputError, match="400-420"):
        interreflection_errors(
            curves([0.5, 0.5]), Spectrum([420, 700], [1, 1]), Bands.gaussian(3), 1
        )
    with pytest.raises(InputError, match="rgb"):
        interreflection_errors(short, light, Bands.rgb(), 1)


@pytest.mark.parametrize("bands", [Bands.box(9), Bands.gaussian(9), Bands.gaussian(200)])
def test_nodes_stay_within_a_band_and_add_up(bands):
    for curve in bands.sensitivities:
        nodes, weights = sensitivity_nodes(curve)
        assert (np.diff(nodes) > 0).all()
        assert nodes[0] >= curve.wavelengths[0]
        assert nodes[-1] <= curve.wavelengths[-1]
        assert weights.sum() == pytest.approx(1.0)


def test_band_values_are_averages(chips, light):
    bands = Bands.gaussian(5)
    seen, lit = band_values(bands, chips, light, 0.5)
    np.testing.assert_allclose(seen[3], bands.average(chips[3]), rtol=1e-3)
    np.testing.assert_allclose(lit, bands.average(light), rtol=1e-3)


def test_curves_hold_in_the_tails_of_a_camera_as_in_a_render(light):
    camera = Bands.parse("Nikon 5100 (NPL)")
    short = curves([0.2, 0.7], [0.5, 0.1], wavelengths=(400.0, 730.0))
    seen, _ = band_values(camera, short, light, 0.5)
    rendered = [camera.reflectance(curve) for curve in short]
    np.testing.assert_allclose(seen, rendered, rtol=1e-4)
    assert interreflection_errors(short, light, camera, 2).kept == 1.0
    with pytest.raises(InputError, match=r"the curve covers 450-730 nm, but 4\d\d-"):
        band_values(camera, curves([0.2, 0.7], wavelengths=(450.0, 730.0)), light)


def test_exact_colors_are_those_of_colour_science(chips):
    exact = exact_colors(chips, Spectrum([380, 780], [2.0, 2.0]))
    white, grey = curves([1.0, 1.0], [0.5, 0.5]), observer().wavelengths
    lab = exact_colors(white, Spectrum([380, 780], [2.0, 2.0])).labs
    assert lab[0][0] == pytest.approx((76.069, 0.0, 0.0), abs=1e-3)  # L* of Y = 0.5
    assert lab[1][0] == pytest.approx((57.075, 0.0, 0.0), abs=1e-3)  # L* of Y = 0.25
    product = exact.tested[1](grey) * exact.tested[2](grey)
    with colour_science() as colour:
        shape = colour.SpectralShape(380, 780, 1)
        eye = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
        flat = colour.sd_ones(shape)
        seen = colour.sd_to_XYZ(colour.SpectralDistribution(product, grey), eye, flat) / 100.0
        chromaticity = colour.XYZ_to_xy(colour.sd_to_XYZ(flat, eye, flat))
        expected = colour.XYZ_to_Lab(seen, chromaticity)
    np.testing.assert_allclose(exact.labs[1][len(exact.tested) + 2], expected, atol=0.02)


def test_more_bands_and_regression_look_better(light):
    every = shipped_set()
    chips = SpectrumSet(every.wavelengths, every.values[::7], every.names[::7])
    rows = {
        (n, row.method, row.bounces): row
        for n in (3, 9)
        for row in color_errors(chips, light, Bands.gaussian(n))
    }
    assert len(rows) == 8
    for row in rows.values():
        assert 0.0 < row.mean < row.p95 <= row.worst
    for bounces in (1, 2):
        assert rows[9, "direct", bounces].mean < 0.3 * rows[3, "direct", bounces].mean
        assert rows[3, "regression", bounces].mean < rows[3, "direct", bounces].mean


def test_greys_look_right(light):
    greys = curves([0.9, 0.9], [0.5, 0.5], [0.1, 0.1], [0.3, 0.3])
    exact, bands = exact_colors(greys, light), Bands.gaussian(6)
    matrix = projection_matrix(exact, bands, "direct")
    for bounces, count in ((1, 2), (2, 4)):
        off = differences(exact, bands, matrix, bounces)
        assert off.shape == (count,)
        assert off.max() < 0.05


def test_best_bands_are_no_worse_than_the_usual_ones(chips, light):
    for row in best_bands(chips, light, counts=(1, 4)):
        assert row.usual >= row.width_delta >= row.spread_delta > 0.0
        assert 0.1 <= row.width <= 1.0
        assert row.two > row.one > 0.0
    assert row.spread < 1.0


def test_spread_bands_are_the_usual_ones_unspread():
    spread, usual = spread_bands(4, (400.0, 700.0), 0.25, 1.0), Bands.gaussian(4)
    np.testing.assert_allclose(spread.centroids, usual.centroids, atol=1e-2)
    wide = spread_bands(4, (400.0, 700.0), 0.1, 4 / 3)
    np.testing.assert_allclose(np.diff(wide.centroids[1:3]), 100.0, atol=0.1)


def test_best_bands_by_name():
    """Better than equal bins, where they were fitted: in sRGB after two bounces."""
    chips, light = munsell_set(), emission("D65")
    exact = exact_colors(chips, light, 20)

    def delta(text):
        bands = Bands.parse(text)
        return differences(exact, bands, projection_matrix(exact, bands, "regression"), 2).mean()

    assert delta("best:6") < 0.5 * delta(6)
    assert delta("best:6") < 0.15 * delta(3)
    bands = Bands.parse("best:6")
    assert bands.limits == (400.0, 700.0)
    assert bands.names[0] == "446.9nm"
    assert Bands.from_description(bands.describe()) == bands
    for text in ("best:2", "best:x", "best:"):
        with pytest.raises(InputError, match="the best bands are tabulated for 3 to 12 bands"):
            Bands.parse(text)
