"""N bands: averages over sensitivities, colours, and the way back to linear sRGB."""

import json

import numpy as np
import pytest
from scipy.integrate import quad

from photonmap.bands import Bands
from photonmap.errors import InputError
from photonmap.spectra import (
    Spectrum,
    observer,
    radiance_to_rgb,
    upsample_emission,
    upsample_reflectance,
)

COUNTS = [1, 2, 3, 6, 31, 81, 256]
EVERY = [Bands.rgb(), *map(Bands.gaussian, COUNTS), Bands.gaussian(6, 380, 780)]
CUBE = np.array(np.meshgrid(*3 * [np.linspace(0.0, 1.0, 5)])).reshape(3, -1).T
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

every = pytest.mark.parametrize("bands", EVERY, ids=lambda b: f"{b.count}-{b.limits}")
counts = pytest.mark.parametrize("n", COUNTS)


@pytest.mark.parametrize(
    ("text", "bands"),
    [
        ("rgb", Bands.rgb()),
        (" RGB", Bands.rgb()),
        ("6", Bands.gaussian(6)),
        (6, Bands.gaussian(6, 400, 700)),
        (np.int64(6), Bands(6, (400.0, 700.0))),
        (Bands.gaussian(4, 450, 650), Bands.gaussian(4, 450, 650)),
    ],
)
def test_bands_are_named_by_a_word_or_a_number(text, bands):
    assert Bands.parse(text) == bands
    assert hash(Bands.parse(text)) == hash(bands)


@pytest.mark.parametrize("text", ["0", "-3", 0, 257, "257", "six", "", "6.5", None])
def test_other_bands_are_refused(text):
    with pytest.raises(InputError, match=r"must be 'rgb' or a number from 1 to 256; got"):
        Bands.parse(text)


@pytest.mark.parametrize(
    ("count", "limits", "message"),
    [
        (6, (700, 400), "the lower end first; got 700 to 400"),
        (6, (300, 700), "within 380 to 780 nm"),
        (6, (400, np.nan), "within 380 to 780 nm"),
        (60, (500, 550), "narrower than 1 nm; use fewer bands or a wider range"),
        (4, None, "RGB has 3 bands, not 4"),
    ],
)
def test_impossible_ranges_are_refused(count, limits, message):
    with pytest.raises(InputError, match=message):
        Bands(count, limits)


@every
def test_a_record_rebuilds_the_bands_bit_for_bit(bands):
    again = Bands.from_description(json.loads(json.dumps(bands.describe())))
    assert again == bands
    assert again.describe() == bands.describe()
    np.testing.assert_array_equal(again.rgb_matrix, bands.rgb_matrix)
    if bands.limits:
        np.testing.assert_array_equal(again.sensitivities, bands.sensitivities)


def test_descriptions_name_what_there_is():
    rgb = Bands.rgb().describe()
    assert rgb["names"] == ["R", "G", "B"]
    assert rgb["centroids_nm"] is rgb["sigma_nm"] is rgb["range_nm"] is None
    six = Bands.gaussian(6).describe()
    assert six["names"] == ["425.7nm", "475.0nm", "525.0nm", "575.0nm", "625.0nm", "674.3nm"]
    assert six["sigma_nm"] == 12.5
    assert six["range_nm"] == [400.0, 700.0]


@pytest.mark.parametrize(
    "record", [{}, {"kind": "gaussian"}, {"kind": "gaussian", "names": [], "range_nm": [1, 2]}, 6]
)
def test_records_without_bands_are_refused(record):
    with pytest.raises(InputError, match="does not describe bands"):
        Bands.from_description(record)


@every
def test_ones_are_one_in_every_band(bands):
    ones = np.ones(bands.count)
    np.testing.assert_array_equal(bands.reflectance(1.0), ones)
    np.testing.assert_array_equal(bands.emission(1.0), ones)
    np.testing.assert_allclose(bands.reflectance((1.0, 1.0, 1.0)), ones, rtol=0, atol=1e-12)
    if bands.limits:
        flat = Spectrum([399.7, 500.0, 523.1, 650.0], np.ones(4))
        np.testing.assert_allclose(bands.average(flat), ones, rtol=0, atol=1e-12)


@counts
def test_averages_are_those_of_gaussians_cut_to_the_range(n):
    bands, width = Bands.gaussian(n), 300.0 / n
    spectrum = upsample_reflectance((0.8, 0.3, 0.1))
    for band in {0, n // 3, n - 1}:
        centre = 400.0 + (band + 0.5) * width
        low, high = max(400.0, centre - 2.0 * width), min(700.0, centre + 2.0 * width)

        def gauss(x, centre=centre):
            return np.exp(-0.5 * ((x - centre) / (width / 4.0)) ** 2)

        split = np.arange(np.ceil(low / 5) * 5 + 5, high, 5.0)
        whole = quad(gauss, low, high, points=[centre], limit=200)[0]
        product = quad(lambda x: gauss(x) * spectrum(x), low, high, points=split, limit=200)[0]
        assert bands.average(spectrum)[band] == pytest.approx(product / whole, abs=5e-5)


@counts
def test_sensitivities_are_sampled_finely(n):
    bands = Bands.gaussian(n)
    step = np.diff(bands.wavelengths)
    np.testing.assert_allclose(step, step[0], rtol=1e-9)
    assert step[0] <= min(1.0, bands.sigma / 4.0) * (1 + 1e-9)
    assert bands.sensitivities.shape == (n, len(bands.wavelengths))
    assert (np.diff(bands.centroids) > 0).all()
    inner = bands.centroids[1:-1]
    np.testing.assert_allclose(inner, 400.0 + (np.arange(1, n - 1) + 0.5) * 300.0 / n, atol=1e-6)


@every
def test_rgb_returns_to_itself(bands):
    """RGB emission, and RGB surfaces under D65 as a render multiplies them."""
    emission = CUBE @ bands.emission_basis
    surfaces = CUBE @ bands.reflectance_basis * bands.emission((1.0, 1.0, 1.0))
    np.testing.assert_allclose(emission, [bands.emission(tuple(rgb)) for rgb in CUBE], atol=1e-14)
    if bands.limits:
        np.testing.assert_allclose(surfaces, emission, rtol=1e-13)
    white = CUBE[:, :1] * np.ones(3)
    wanted = CUBE if bands.count >= 3 else white
    shown = emission if bands.count >= 3 else white @ bands.emission_basis
    np.testing.assert_allclose(shown @ bands.rgb_matrix.T, wanted, rtol=0, atol=1e-12)


def test_one_band_is_neutral():
    bands = Bands.gaussian(1)
    red, green, blue = bands.rgb_matrix[:, 0]
    assert red == pytest.approx(green, rel=1e-14)
    assert red == pytest.approx(blue, rel=1e-14)
    constant = Spectrum([380, 780], [1, 1])
    luminance = LUMINANCE @ bands.rgb_matrix @ bands.average(constant)
    assert luminance == pytest.approx(LUMINANCE @ radiance_to_rgb(constant), rel=0.01)


@pytest.mark.parametrize(("n", "limit"), [(3, 0.13), (6, 0.08), (9, 0.03), (31, 3e-3), (81, 5e-4)])
def test_second_bounces_near_their_colour_with_more_bands(n, limit):
    """D65 off two saturated surfaces, multiplied band by band, against the curves' product."""
    eye, bands = observer(), Bands.gaussian(n)
    first, second = np.triu_indices(3)
    curves = eye.d65 * eye.basis[first] * eye.basis[second]
    truth = [radiance_to_rgb(Spectrum(eye.wavelengths, curve)) for curve in curves]
    ours = bands.emission_basis[first] * bands.reflectance_basis[second]
    assert np.abs(ours @ bands.rgb_matrix.T - truth).max() < limit


@pytest.mark.parametrize(("n", "limit"), [(3, 0.02), (6, 0.01), (31, 1e-3), (256, 1e-4)])
def test_rgb_emission_nears_the_average_of_its_curve(n, limit):
    bands = Bands.gaussian(n)
    averages = [bands.average(upsample_emission(rgb)) for rgb in np.eye(3)]
    np.testing.assert_allclose(bands.emission_basis, averages, rtol=0, atol=limit)


def test_rgb_takes_triples_as_they_stand_and_projects_spectra():
    bands, wide = Bands.rgb(), upsample_reflectance((0.2, 0.5, 0.9))
    np.testing.assert_array_equal(bands.reflectance((0.1, 0.2, 0.3)), [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(bands.emission((4.0, 2.0, 0.0)), [4.0, 2.0, 0.0])
    np.testing.assert_allclose(bands.reflectance(wide), [0.2, 0.5, 0.9], atol=1e-8)
    laser = Spectrum([518, 520, 522], [0, 1, 0])
    assert bands.reflectance(laser)[0] == 0.0
    np.testing.assert_array_equal(bands.emission(laser), np.maximum(radiance_to_rgb(laser), 0.0))
    assert bands.wavelengths is bands.sensitivities is bands.centroids is bands.sigma is None
    with pytest.raises(InputError, match="RGB has no sensitivities"):
        bands.average(wide)


@every
@pytest.mark.parametrize("color", ["red", None, (1.0, 2.0), np.nan, [[1, 2, 3]], (1, "a", 2)])
def test_what_is_no_colour_is_refused(bands, color):
    for convert in (bands.reflectance, bands.emission):
        with pytest.raises(InputError, match="a colour is a number, three for linear RGB, or"):
            convert(color)


def test_arrays_cannot_be_changed():
    bands = Bands.gaussian(3)
    for array in (bands.sensitivities, bands.centroids, bands.rgb_matrix, bands.reflectance_basis):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
