"""Curves over wavelength, and the way from linear sRGB to such curves and back."""

import json
import runpy
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from photonmap.errors import InputError
from photonmap.spectra.bands import Bands
from photonmap.spectra.color_text import emission, reflectance
from photonmap.spectra.curves import Spectrum, SpectrumSet, integrate_products
from photonmap.spectra.observer import (
    observer,
    radiance_to_rgb,
    reflectance_to_rgb,
    upsample_emission,
    upsample_reflectance,
)

FILE = Path(__file__).parents[2] / "photonmap" / "data" / "observer.csv"
TOOL = Path(__file__).parents[2] / "tools" / "make_observer.py"
CUBE = np.array(np.meshgrid(*3 * [np.linspace(0.0, 1.0, 5)])).reshape(3, -1).T


@pytest.fixture(scope="module")
def colour():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it says which optional parts are missing
        return pytest.importorskip("colour")


@pytest.mark.parametrize(
    ("wavelengths", "values", "message"),
    [
        (500.0, 1.0, "one row"),
        ([[400, 500]], [[1, 1]], "one row"),
        ([400, 500, 600], [1, 1], "one value for each"),
        ([400, "red"], [1, 1], "wavelengths must be a row of numbers"),
        ([400, 500], [1, [1, 2]], "values must be a row of numbers"),
        ([400], [1], "for a constant one give a number"),
        ([400, np.nan], [1, 1], "finite"),
        ([400, 500], [1, np.inf], "finite"),
        ([400, 500, 500], [1, 2, 3], "500 follows 500; sort the samples"),
        ([700, 400], [1, 1], "400 follows 700"),
        ([4e-7, 7e-7], [1, 1], "look like metres: multiply by 1e9"),
        ([0.4, 0.7], [1, 1], "look like micrometres: multiply by 1000"),
        ([4000, 7000], [1, 1], "look like ångströms: divide by 10"),
    ],
)
def test_what_is_no_spectrum_is_refused(wavelengths, values, message):
    with pytest.raises(InputError, match=message):
        Spectrum(wavelengths, values)


def test_a_spectrum_is_a_value():
    wavelengths = np.array([400.0, 500.0])
    spectrum = Spectrum(wavelengths, [0.0, 1.0])
    wavelengths[0] = 0.0
    assert spectrum == Spectrum([400, 500], [-0.0, 1])
    assert hash(spectrum) == hash(Spectrum([400, 500], [-0.0, 1]))
    assert spectrum != Spectrum([400, 501], [0, 1])
    assert spectrum != "spectrum"
    with pytest.raises(ValueError, match="read-only"):
        spectrum.values[0] = 1.0


def test_a_spectrum_is_linear_between_and_constant_beyond_its_samples():
    at = np.array([[300.0, 400.0], [425.0, 900.0]])
    np.testing.assert_array_equal(Spectrum([400, 500], [1, 2])(at), [[1.0, 1.0], [1.25, 2.0]])


def test_functions_are_sampled_by_the_nanometre():
    spectrum = Spectrum.sample(lambda nm: nm / 1000.0, 400.0, 700.0)
    assert spectrum == Spectrum(np.arange(400, 701), np.arange(400, 701) / 1000.0)
    assert Spectrum.sample(lambda nm: 0.5).values.tolist() == [0.5] * 401


def test_spectra_are_scaled():
    spectrum = Spectrum([400, 700], [1, 2], extrapolate=True)
    assert 2 * spectrum == spectrum * 2.0 == Spectrum([400, 700], [2, 4], extrapolate=True)
    assert 2 * spectrum != Spectrum([400, 700], [2, 4])


@pytest.mark.parametrize(
    ("wavelengths", "missing"),
    [
        ([450, 700], "400-450 nm is missing"),
        ([400, 650], "650-700 nm is missing"),
        ([450, 650], "400-450 and 650-700 nm is missing"),
        ([800, 900], "400-700 nm is missing"),
        ([200, 300], "400-700 nm is missing"),
    ],
)
def test_what_a_curve_must_cover(wavelengths, missing):
    for convert in (Bands.gaussian(6), Bands.rgb()):
        for kind in (convert.reflectance, convert.emission):
            with pytest.raises(InputError, match=f"{missing}; extend the outer .*extrapolate"):
                kind(Spectrum(wavelengths, [1, 1]))
            assert kind(Spectrum(wavelengths, [0.5, 0.5], extrapolate=True)).shape[0] > 2
    with pytest.raises(InputError, match="380-400 and 700-780 nm is missing; choose bands"):
        Bands.gaussian(6, 380, 780).reflectance(Spectrum([400, 700], [1, 1]))
    with pytest.raises(InputError, match="400-450 and 650-700 nm is missing"):
        Bands.gaussian(6, 450, 650).reflectance(Spectrum([450, 650], [1, 1]))


@pytest.mark.parametrize("bands", [Bands.gaussian(6), Bands.rgb()])
def test_curves_beyond_their_bounds_are_refused(bands):
    for values, message in (
        ([0.5, 1.2], "reflectance is 1.2 at 700 nm; it must lie between 0 and 1$"),
        ([-0.1, 0.5], "reflectance is -0.1 at 400 nm"),
        ([12.0, 90.0], "divide percent by 100"),
    ):
        with pytest.raises(InputError, match=message):
            bands.reflectance(Spectrum([400, 700], values))
    with pytest.raises(InputError, match="emission is -1 at 700 nm; light cannot be negative"):
        bands.emission(Spectrum([400, 700], [1, -1]))


@pytest.mark.parametrize(
    ("values", "names", "message"),
    [
        ([[1, 2]], ("a", "b"), "2 curves over 2 wavelengths need values of shape"),
        ([1, 2], ("a",), "at least one curve"),
        (np.empty((0, 2)), (), "at least one curve"),
        ([[1, 2], [1, np.nan]], ("a", "b"), "finite"),
    ],
)
def test_unsound_sets_are_refused(values, names, message):
    with pytest.raises(InputError, match=message):
        SpectrumSet([400, 700], values, names)


def test_sets_give_their_curves_by_name_and_place():
    chips = SpectrumSet([400, 700], [[0, 1], [1, 0]], ("up", "down"))
    assert chips["down"] == chips[1] == list(chips)[1] == Spectrum([400, 700], [1, 0])
    assert len(chips) == 2
    np.testing.assert_array_equal(chips.at(np.array([400.0, 550.0])), [[0, 0.5], [1, 0.5]])
    with pytest.raises(InputError, match="no curve 'uq'; did you mean 'up'"):
        chips["uq"]
    with pytest.raises(InputError, match="390-400 nm is missing"):
        chips.at(np.array([390.0, 500.0]))


def test_products_of_curves_are_integrated_exactly():
    weights = Spectrum([400, 430, 500], [0.0, 2.0, 1.0])
    curve = Spectrum([410, 411, 480, 600], [1.0, 3.0, -1.0, 5.0])
    ours = integrate_products(
        weights.wavelengths, weights.values[None], curve.wavelengths, curve.values[None]
    )
    truth, error = quad(
        lambda x: weights(x) * curve(x), 400, 500, points=[410, 411, 430, 480], epsabs=1e-11
    )
    assert ours.item() == pytest.approx(truth, abs=10 * error)


def test_the_basis_is_smooth_and_keeps_energy():
    basis = observer().basis
    assert basis.min() == 0.0
    assert basis.max() == 1.0
    np.testing.assert_allclose(basis.sum(axis=0), 1.0, rtol=0, atol=1e-15)
    nodes = basis[:, ::5]
    assert np.abs(np.diff(nodes)).max() < 0.14  # per 5 nm: sRGB's primaries are steep
    assert np.abs(np.diff(nodes, 2)).max() < 0.035
    assert np.abs(np.diff(nodes)[:, [0, -1]]).max() < 0.002  # level at both ends


@pytest.mark.parametrize("scale", [1.0, 7.5])
def test_emission_returns_to_its_rgb(scale):
    for rgb in scale * CUBE:
        spectrum = upsample_emission(rgb)
        assert spectrum.values.min() >= 0.0
        np.testing.assert_allclose(radiance_to_rgb(spectrum), rgb, rtol=0, atol=1e-8 * scale)


def test_reflectance_returns_to_its_rgb_under_d65():
    for rgb in CUBE:
        spectrum = upsample_reflectance(rgb)
        assert 0.0 <= spectrum.values.min() <= spectrum.values.max() <= 1.0 + 1e-15
        np.testing.assert_allclose(reflectance_to_rgb(spectrum), rgb, rtol=0, atol=1e-8)


def test_white_is_d65_and_grey_is_flat():
    eye = observer()
    np.testing.assert_allclose(upsample_emission([1, 1, 1]).values, eye.d65, rtol=1e-15)
    np.testing.assert_allclose(upsample_reflectance([0.3] * 3).values, 0.3, rtol=1e-15)
    luminance = np.array([0.2126, 0.7152, 0.0722]) @ eye.matching  # the standard's rounded ȳ/∫ȳ
    assert np.trapezoid(luminance, eye.wavelengths) == pytest.approx(1.0, abs=2e-4)


def test_the_standards_matrix_agrees(colour):
    xyz = np.loadtxt(FILE, delimiter=",")[:, 1:4].T
    theirs = colour.RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB @ xyz / (5.0 * xyz[1].sum())
    ours = observer().matching[:, ::5]
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=3e-3 * theirs.max())


def test_the_table_is_colour_sciences_and_can_be_made_again(colour):
    table = np.loadtxt(FILE, delimiter=",")
    tool = runpy.run_path(str(TOOL))
    np.testing.assert_array_equal(table[:, :5], tool["tabulated"]())
    np.testing.assert_allclose(table[:, 5:], tool["basis"](table[:, :5]), rtol=0, atol=2e-8)


def test_colours_look_right_to_another_observer(colour):
    """ΔE2000 over the sRGB cube, integrated at 1 nm from 360 to 830 nm by colour-science."""
    eye = observer()
    coded = np.array(np.meshgrid(*3 * [np.linspace(0.0, 1.0, 9)])).reshape(3, -1).T
    rgb = colour.cctf_decoding(coded, "sRGB")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        basis = [
            colour.sd_to_XYZ(
                colour.SpectralDistribution(curve, eye.wavelengths),
                illuminant=colour.SDS_ILLUMINANTS["D65"],
            )
            for curve in eye.basis
        ]
        ours = colour.XYZ_to_Lab(rgb @ basis / 100.0)
        wanted = colour.XYZ_to_Lab(colour.RGB_to_XYZ(rgb, "sRGB"))
    assert colour.delta_E(ours, wanted, method="CIE 2000").max() < 0.5


def test_colour_science_is_not_needed_at_run_time():
    """But for what no process has looked up before."""
    for name in ("D65", "planck:2700", "daylight:5000", "sky:3,45"):
        emission(name)
    reflectance("dark skin")
    code = (
        "import json, sys; from photonmap.spectra.bands import Bands;"
        "import photonmap.spectra.projection as p;"
        "p.direct_projection(Bands.gaussian(6), 'rgb'); import photonmap as pm;"
        "pm.reflectance('munsell:5R 5/10'); pm.emission('rgb:1,2,3'); pm.emission('D65');"
        "pm.emission('planck:2700'); pm.emission('daylight:5000'); pm.reflectance('dark skin');"
        "pm.emission('sky:3,45');"
        "print(json.dumps([m for m in ('colour', 'scipy', 'matplotlib') if m in sys.modules]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == []


def test_what_a_camera_hardly_sees_need_not_be_known():
    """Chips end at 730 nm; of what it sees, a camera has less than a ten-thousandth beyond."""
    camera = Bands.parse("Nikon 5100 (NPL)")
    chip = Spectrum([380, 730], [0.2, 0.7])
    held = camera.reflectance(Spectrum([380, 730], [0.2, 0.7], extrapolate=True))
    np.testing.assert_array_equal(camera.reflectance(chip), held)
    beyond = camera.reflectance(Spectrum([380, 730, 731, 780], [0.2, 0.7, 0.0, 0.0]))
    assert np.abs(beyond - held).max() < 1e-4
    with pytest.raises(InputError, match="380-450 and 730-780 nm is missing"):
        camera.reflectance(Spectrum([450, 730], [0.2, 0.7]))
