"""N bands: averages over sensitivities, colours, and the way back to linear sRGB."""

import json

import numpy as np
import pytest
from scipy.integrate import quad

from photonmap.errors import InputError, SceneWarning
from photonmap.spectra.bands import Bands
from photonmap.spectra.color_text import emission
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.observer import (
    observer,
    radiance_to_rgb,
    upsample_emission,
    upsample_reflectance,
)
from photonmap.spectra.projection import primaries_projection

COUNTS = [1, 2, 3, 6, 31, 81, 256]
RED = Spectrum([380, 520, 610, 700], [0.0, 0.1, 3.0, 0.2])
BLUE = Spectrum([390, 440, 500, 720], [0.1, 2.0, 0.1, 0.0])
CAMERA = Bands.sensors([RED, Spectrum([400, 530, 700], [0, 1, 0]), BLUE, BLUE], "rgbb")
EVERY = [
    Bands.rgb(),
    *map(Bands.gaussian, COUNTS),
    Bands.gaussian(6, 380, 780),
    Bands.gaussian(4, sigma=60.0),
    *map(Bands.box, [1, 4, 40]),
    CAMERA,
]
CUBE = np.array(np.meshgrid(*3 * [np.linspace(0.0, 1.0, 5)])).reshape(3, -1).T
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def matrix(bands):
    return primaries_projection(bands, "rgb").matrix


every = pytest.mark.parametrize("bands", EVERY, ids=lambda b: f"{b.kind}-{b.count}")
counts = pytest.mark.parametrize("n", COUNTS)


@pytest.mark.parametrize(
    ("text", "bands"),
    [
        ("rgb", Bands.rgb()),
        (" RGB", Bands.rgb()),
        ("6", Bands.gaussian(6)),
        (6, Bands.gaussian(6, 400, 700)),
        (np.int64(6), Bands.gaussian(6)),
        ("box:6", Bands.box(6)),
        (Bands.gaussian(4, 450, 650), Bands.gaussian(4, 450, 650)),
    ],
)
def test_bands_are_named_by_a_word_or_a_number(text, bands):
    assert Bands.parse(text) == bands
    assert hash(Bands.parse(text)) == hash(bands)


@pytest.mark.parametrize("text", ["0", "-3", 0, 257, "257", "six", "", "6.5", None])
def test_other_bands_are_refused(text):
    with pytest.raises(
        InputError,
        match=r"bands must be 'rgb', a number from 1 to 256|number of bands must be from 1 to",
    ):
        Bands.parse(text)


def test_a_range_without_a_step_is_told_so():
    with pytest.raises(InputError, match="bands 400:700 lack a step; write 400:700:10 for"):
        Bands.parse("400:700")


@pytest.mark.parametrize("make", [Bands.gaussian, Bands.box])
@pytest.mark.parametrize(
    ("count", "low", "high", "message"),
    [
        (6, 700, 400, "the lower end first; got 700 to 400"),
        (6, 270, 700, "within 280 to 800 nm"),
        (6, 400, np.nan, "within 280 to 800 nm"),
        (60, 500, 550, "narrower than 1 nm; use fewer bands or a wider range"),
    ],
)
def test_impossible_ranges_are_refused(make, count, low, high, message):
    with pytest.raises(InputError, match=message):
        make(count, low, high)


@pytest.mark.parametrize("sigma", [0.0, -1.0, 301.0, np.nan])
def test_impossible_widths_are_refused(sigma):
    with pytest.raises(InputError, match="keep it between"):
        Bands.gaussian(3, sigma=sigma)


def test_the_range_may_be_chosen():
    assert Bands.parse("6", (380.0, 780.0)) == Bands.gaussian(6, 380, 780)
    assert Bands.parse("box:6", (450.0, 650.0)) == Bands.box(6, 450, 650)
    with pytest.raises(InputError, match="rgb takes no range"):
        Bands.parse("rgb", (380.0, 780.0))


def test_boxes_share_the_range():
    bands = Bands.box(3)
    assert bands.names == ("450.0nm", "550.0nm", "650.0nm")
    step = Spectrum([400, 499, 501, 700], [0, 0, 1, 1])
    np.testing.assert_allclose(bands.average(step), [0.0025, 0.9975, 1.0], rtol=0, atol=1e-14)


def test_sensors_come_from_a_file(tmp_path):
    file = tmp_path / "camera.csv"
    file.write_text("nm,red,green\n390,0,0\n500,0,2\n600,4,0\n710,0,0\n")
    bands = Bands.parse(str(file))
    assert (bands.kind, bands.names, bands.limits) == ("sensors", ("red", "green"), (390.0, 710.0))
    np.testing.assert_allclose(bands.centroids, [603 + 1 / 3, 496 + 2 / 3], rtol=1e-12)
    cut = Bands.parse(file, (450.0, 550.0))
    assert cut.limits == (450.0, 550.0)
    assert cut.sensitivities[0] == Spectrum([500, 550], [0, 0.04])
    wide = tmp_path / "short.csv"
    wide.write_text("450,1\n650,1\n")
    with pytest.raises(InputError, match=r"short.csv: the curve covers 450-650 nm, but 400-700"):
        Bands.parse(wide)
    assert Bands.parse(wide, (450.0, 600.0)).count == 1


def test_cameras_and_observers_have_names():
    bands = Bands.parse("CIE 1931 2 Degree Standard Observer")
    assert bands.names == ("x_bar", "y_bar", "z_bar")
    np.testing.assert_allclose(bands.centroids[1], 560.2, atol=0.5)
    assert Bands.parse("extrapolate: sigma SDMerill (NPL)").names == ("red", "green", "blue")
    with pytest.raises(InputError, match=r"r_bar: sensitivity is -0\.09356 at 515 nm"):
        Bands.parse("Wright & Guild 1931 2 Degree RGB CMFs")
    with pytest.raises(InputError, match="covers 400-680 nm, but 400-700 nm is needed"):
        Bands.parse("Sigma SDMerill (NPL)")
    with pytest.raises(InputError, match=r"did you mean 'Nikon 5100 \(NPL\)'"):
        Bands.parse("Nikon 5100")


def test_noise_below_zero_is_cut():
    noisy = Spectrum([400, 410, 550, 700], [0.0, -0.01, 1.0, 0.0])
    with pytest.warns(SceneWarning, match="sensor 1: sensitivity dips to -0.01, 1.00% of its peak"):
        (curve,) = Bands.sensors([noisy]).sensitivities
    assert curve.values.min() == 0.0


@pytest.mark.parametrize(
    ("curves", "names", "message"),
    [
        ([], None, "1 to 256 sensors; got 0"),
        ([RED], ["a", "b"], "1 sensors need as many names; got 2"),
        ([Spectrum([400, 500, 700], [-0.1, 1, 0])], None, "sensor 1: sensitivity is -0.1 at 400"),
        ([Spectrum([400, 700], [0, 0])], ["dead"], "dead: is 0 from 400 to 700 nm; widen"),
        ([Spectrum([450, 700], [1, 1])], None, "covers 450-700 nm, but 400-700 nm is needed"),
    ],
)
def test_unsound_sensors_are_refused(curves, names, message):
    with pytest.raises(InputError, match=message):
        Bands.sensors(curves, names)


@every
def test_a_record_rebuilds_the_bands_bit_for_bit(bands):
    again = Bands.from_description(json.loads(json.dumps(bands.describe())))
    assert again == bands
    assert again.describe() == bands.describe()
    np.testing.assert_array_equal(matrix(again), matrix(bands))


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
        flat = Spectrum([379.7, 500.0, 523.1, 780.0], np.ones(4))
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
    steps = np.concatenate([np.diff(curve.wavelengths) for curve in bands.sensitivities])
    np.testing.assert_allclose(steps, steps[0], rtol=1e-9)
    assert steps[0] <= min(1.0, bands.sigma / 4.0) * (1 + 1e-9)
    assert len(bands.sensitivities) == bands.count == n
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
    np.testing.assert_allclose(shown @ matrix(bands).T, wanted, rtol=0, atol=1e-12)


def test_one_band_is_neutral():
    bands = Bands.gaussian(1)
    red, green, blue = matrix(bands)[:, 0]
    assert red == pytest.approx(green, rel=1e-14)
    assert red == pytest.approx(blue, rel=1e-14)
    constant = Spectrum([380, 780], [1, 1])
    luminance = LUMINANCE @ matrix(bands) @ bands.average(constant)
    assert luminance == pytest.approx(LUMINANCE @ radiance_to_rgb(constant), rel=0.01)


@pytest.mark.parametrize(("n", "limit"), [(3, 0.12), (6, 0.09), (9, 0.02), (31, 3e-3), (81, 5e-4)])
def test_second_bounces_near_their_colour_with_more_bands(n, limit):
    """D65 off two saturated surfaces, multiplied band by band, against the curves' product."""
    eye, bands = observer(), Bands.gaussian(n)
    first, second = np.triu_indices(3)
    curves = eye.d65 * eye.basis[first] * eye.basis[second]
    truth = [radiance_to_rgb(Spectrum(eye.wavelengths, curve)) for curve in curves]
    ours = bands.emission_basis[first] * bands.reflectance_basis[second]
    assert np.abs(ours @ matrix(bands).T - truth).max() < limit


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
    laser = Spectrum([400, 518, 520, 522, 700], [0, 0, 1, 0, 0])
    assert bands.reflectance(laser)[0] == 0.0
    np.testing.assert_array_equal(bands.emission(laser), np.maximum(radiance_to_rgb(laser), 0.0))
    assert bands.sensitivities == ()
    assert bands.centroids is bands.sigma is bands.limits is None
    with pytest.raises(InputError, match="RGB has no sensitivities"):
        bands.average(wide)


@every
@pytest.mark.parametrize("color", ["red", None, (1.0, 2.0), np.nan, [[1, 2, 3]], (1, "a", 2)])
def test_what_is_no_colour_is_refused(bands, color):
    for convert in (bands.reflectance, bands.emission):
        with pytest.raises(
            InputError, match="a colour is a number, three numbers of linear RGB, or"
        ):
            convert(color)


def test_arrays_cannot_be_changed():
    bands = Bands.gaussian(3)
    for array in (
        bands.sensitivities[0].values,
        bands.centroids,
        matrix(bands),
        bands.reflectance_basis,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@pytest.mark.parametrize(
    ("text", "count", "first", "last"),
    [
        ("400:700:10", 31, 400, 700),
        ("400:700:5", 61, 400, 700),
        ("450.5:650.5:50", 5, 450.5, 650.5),
    ],
)
def test_bands_at_round_wavelengths(text, count, first, last):
    bands = Bands.parse(text)
    wanted = np.linspace(first, last, count)
    np.testing.assert_allclose(bands.centroids, wanted, rtol=1e-14)
    assert bands.names[0] == f"{first:g}nm"
    step = wanted[1] - wanted[0]
    for curve, center in zip(bands.sensitivities, wanted, strict=True):
        np.testing.assert_allclose(
            curve.wavelengths[[0, -1]], [center - step / 2, center + step / 2]
        )
        np.testing.assert_allclose(curve.values, curve.values[::-1], rtol=1e-12)
    assert bands == Bands.from_description(bands.describe())
    assert bands == Bands.steps(first, last, step)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("400:700:7", "steps must lead from the first wavelength to the last"),
        ("400:700:0", "steps must lead"),
        ("700:400:10", "steps must lead"),
        ("280:800:10", "half a step .* within 280 to 800 nm, as 285:795:10 do"),
        ("280:800:5", "reach from 277.5 to 802.5 nm, .* 800 nm, as 282.5:797.5:5 do"),
        ("200:400:10", ", as 285:395:10 do"),
        ("400:400:900", "within 280 to 800 nm$"),
        ("400:700:.5", "from 1 to 256"),
    ],
)
def test_steps_that_do_not_fit(text, message):
    with pytest.raises(InputError, match=message):
        Bands.parse(text)
    with pytest.raises(InputError, match="takes no range"):
        Bands.parse("400:700:10", (400.0, 700.0))


def test_ultraviolet_bands_see_lights_whose_tables_end_there():
    bands = Bands.parse("300:780:20")
    assert bands.count == 25
    assert bands.limits == (290.0, 790.0)
    light = bands.emission(emission("D65"))
    assert 0.0 < light[0] < 0.02
    assert light[3] == pytest.approx(0.45, abs=0.05)
    with pytest.raises(InputError, match="covers 380-780 nm, but 300-780 nm is needed: 300-380"):
        bands.emission(emission("LED-B1"))
