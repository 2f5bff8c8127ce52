"""From bands to RGB, XYZ and cameras."""

import numpy as np
import pytest

from photonmap.errors import InputError
from photonmap.results.result import Result
from photonmap.spectra.bands import Bands
from photonmap.spectra.color_text import emission, reflectance
from photonmap.spectra.curves import Spectrum, resample
from photonmap.spectra.munsell import shipped_set
from photonmap.spectra.names import colour_science
from photonmap.spectra.observer import emission_spectrum, observer, radiance_to_rgb
from photonmap.spectra.projection import (
    choose_projection,
    direct_projection,
    fit_projection,
    primaries_projection,
)

CAMERA = Bands.sensors(
    [
        Spectrum([380, 440, 500, 780], [0, 1, 0, 0]),
        Spectrum([380, 520, 620, 700, 780], [0, 0, 1, 0, 0]),
    ]
)
LIGHTS = [emission("D65"), emission("A"), 1.0]
FLAT = Spectrum([380, 780], [0.4, 0.4])
RAMP = Spectrum([380, 480, 650, 780], [0.1, 0.1, 0.9, 0.9])


def chips(step=40):
    chips = shipped_set()
    return type(chips)(chips.wavelengths, chips.values[::step], chips.names[::step])


@pytest.mark.parametrize("bands", [Bands.gaussian(6), Bands.box(9), Bands.gaussian(31)])
@pytest.mark.parametrize("target", [CAMERA, Bands.gaussian(3), Bands.box(12, 380, 780)])
def test_constant_light_is_seen_as_it_is_by_every_sensor(bands, target):
    matrix = direct_projection(bands, target).matrix
    assert matrix.shape == (target.count, bands.count)
    np.testing.assert_allclose(matrix @ bands.average(FLAT), 0.4, rtol=1e-10)


def test_the_smoothest_spectrum_of_sharp_bands_is_linear_between_them():
    """Lines at 450, 550, 650 nm: the interpolant is piecewise linear, and constant beyond."""
    lines = [
        Spectrum([380, at - 0.5, at, at + 0.5, 780], [0, 0, 1, 0, 0]) for at in (450, 550, 650)
    ]
    nodes = Spectrum([380, 450, 550, 650, 780], [1, 1, 4, 2, 2])
    target = Bands.box(40, 380, 780)
    seen = direct_projection(Bands.sensors(lines), target).matrix @ [1, 4, 2]
    np.testing.assert_allclose(seen, target.average(nodes), atol=0.02)


@pytest.mark.parametrize(("n", "limit"), [(3, 0.2), (6, 0.05), (31, 2e-3), (81, 3e-4)])
def test_more_bands_tell_a_camera_more(n, limit):
    bands = Bands.gaussian(n, 380, 780)
    seen = direct_projection(bands, CAMERA).matrix @ bands.average(RAMP)
    np.testing.assert_allclose(seen, CAMERA.average(RAMP), rtol=0, atol=limit)


def test_bands_in_any_order_and_twice_are_the_same():
    curves = [Spectrum([380, at, 780], [0.01, 1, 0.01]) for at in (430, 480, 530, 580, 630)]
    plain, shuffled = (
        Bands.sensors([curves[k] for k in order])
        for order in ([0, 1, 2, 3, 4], [3, 0, 1, 4, 4, 2, 2])
    )
    for target in (CAMERA, Bands.box(5)):
        ours, theirs = (
            direct_projection(bands, target).matrix @ bands.average(RAMP)
            for bands in (shuffled, plain)
        )
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9)


@pytest.mark.parametrize("bands", [Bands.rgb(), Bands.gaussian(6)])
def test_xyz_is_rgb_in_other_primaries(bands):
    rgb, xyz = (direct_projection(bands, target).matrix for target in ("rgb", "xyz"))
    np.testing.assert_allclose(xyz, observer().rgb_to_xyz @ rgb, rtol=1e-12, atol=1e-15)


def test_rgb_stands_for_spectra_of_its_own():
    matrix = direct_projection(Bands.rgb(), CAMERA).matrix
    np.testing.assert_allclose(matrix.sum(axis=1), CAMERA.average(emission("D65")), rtol=1e-9)


@pytest.mark.parametrize("n", [3, 6, 9])
def test_a_fit_is_the_least_squares_solution(n):
    """Any other matrix, such as the direct one, is farther from the same truths."""
    bands, eye, training = Bands.gaussian(n), observer(), chips()
    fit, direct = fit_projection(bands, "rgb", training, LIGHTS), direct_projection(bands, "rgb")
    assert direct.residual is None
    curves = np.array(
        [np.interp(eye.wavelengths, training.wavelengths, c) for c in training.values]
    )
    squares = dict.fromkeys((fit, direct), 0.0)
    truths = 0.0
    for light in map(emission_spectrum, LIGHTS):
        averages = bands.average_all(training.wavelengths, training.values)
        seen = bands.average(light) * averages
        truth = (curves * light(eye.wavelengths)) @ eye.matching.T
        truths += (truth**2).sum()
        for projection in squares:
            squares[projection] += ((seen @ projection.matrix.T - truth) ** 2).sum()
    assert fit.residual[0] == pytest.approx(np.sqrt(squares[fit] / truths), rel=1e-6)
    assert squares[fit] < 0.9 * squares[direct]


def test_residuals_fall_with_the_number_of_bands():
    fits = [fit_projection(Bands.gaussian(n), "rgb", chips(), LIGHTS) for n in (3, 6, 9, 31, 81)]
    once, twice = np.array([fit.residual for fit in fits]).T
    assert (np.diff(once) < 0).all()
    assert (np.diff(twice) < 0).all()
    assert once[-1] < 1e-3


def test_results_are_projected_by_either_method():
    bands = Bands.gaussian(6)
    chip, light = reflectance("munsell:5R 5/10"), emission("A")
    values = np.float32(bands.average(light) * bands.average(chip))
    buffers = {"radiance": values[None, None], "reflectance": np.ones((1, 1, 6), np.float32)}
    result = Result(buffers, {}, bands, {})
    eye = observer()
    grid = eye.wavelengths
    truth = radiance_to_rgb(Spectrum(grid, light(grid) * chip(grid)))
    for method in ("direct", "primaries", "regression"):
        np.testing.assert_allclose(result.rgb(method=method)[0, 0], truth, atol=0.03)
        assert result.projection("rgb", method).residual is None or method == "regression"
        np.testing.assert_allclose(result.rgb("reflectance", method)[0, 0], 1.0, rtol=1e-6)
        np.testing.assert_allclose(result.to_sensor(CAMERA, "reflectance", method), 1.0, rtol=1e-6)
    np.testing.assert_allclose(result.xyz()[0, 0], eye.rgb_to_xyz @ result.rgb()[0, 0], rtol=1e-5)
    assert result.to_sensor("box:4").shape == (1, 1, 4)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: choose_projection(Bands.gaussian(3), "lab", "direct"), "no target 'lab'"),
        (lambda: choose_projection(Bands.gaussian(3), "rgb", "magic"), "'magic'; choose from"),
        (lambda: fit_projection(Bands.rgb(), "rgb", chips(), LIGHTS), "no sensitivities to fit"),
        (lambda: fit_projection(Bands.gaussian(3), "rgb", chips(), []), "at least one illuminant"),
        (lambda: fit_projection(Bands.gaussian(3), Bands.rgb(), chips(), LIGHTS), "has no sens"),
        (lambda: direct_projection(Bands.gaussian(3), Bands.rgb()), "RGB has no sensitivities"),
    ],
)  # fmt: skip
def test_what_cannot_be_projected_is_told(call, message):
    with pytest.raises(InputError, match=message):
        call()


@pytest.mark.parametrize(("n", "least", "most"), [(3, 3.0, 6.0), (6, 0.0, 1.2), (9, 0.0, 0.4)])
def test_six_bands_show_munsell_chips_truly(n, least, most):
    """Mean ΔE2000 of chips under D65, not those of the fit: three bands fall short by far."""
    bands, eye, light = Bands.gaussian(n), observer(), emission("D65")
    tested = chips(31)
    curves = resample(eye.wavelengths, tested.wavelengths, tested.values)
    truth = (curves * eye.d65) @ (eye.rgb_to_xyz @ eye.matching).T
    bands_seen = bands.average(light) * bands.average_all(tested.wavelengths, tested.values)
    white = eye.rgb_to_xyz.sum(axis=1)
    for matrix in (
        direct_projection(bands, "xyz").matrix,
        fit_projection(bands, "xyz", chips(), LIGHTS).matrix,
    ):
        with colour_science() as colour:
            labs = [
                colour.XYZ_to_Lab(xyz, colour.XYZ_to_xy(white))
                for xyz in (truth, bands_seen @ matrix.T)
            ]
            off = colour.delta_E(*labs, method="CIE 2000").mean()
        assert least < off < most


@pytest.mark.parametrize(
    "bands", [Bands.gaussian(3), Bands.gaussian(6), Bands.box(6), Bands.gaussian(5, sigma=40.0)]
)
def test_rgb_returns_by_its_primaries_and_white_always(bands):
    color = (0.9, 0.2, 0.4)
    white = bands.emission((1.0, 1.0, 1.0))
    seen = bands.reflectance(color) * white
    exact = primaries_projection(bands, "rgb").matrix
    np.testing.assert_allclose(exact @ seen, color, atol=1e-9)
    np.testing.assert_allclose(direct_projection(bands, "rgb").matrix @ white, 1.0, rtol=1e-9)
    xyz = observer().rgb_to_xyz
    np.testing.assert_allclose(primaries_projection(bands, "xyz").matrix, xyz @ exact, rtol=1e-9)
    to_camera = primaries_projection(bands, CAMERA).matrix
    np.testing.assert_array_equal(to_camera, direct_projection(bands, CAMERA).matrix)


def test_scenes_of_rgb_return_to_it_and_scenes_of_spectra_do_not():
    bands = Bands.gaussian(6)
    buffers = {"radiance": np.ones((1, 1, 6), np.float32)}
    for spectra, method in ((False, "primaries"), (True, "direct")):
        result = Result(buffers, {}, bands, {"scene": {"spectra": spectra}})
        wanted = choose_projection(bands, "rgb", method).matrix
        np.testing.assert_array_equal(result.projection().matrix, wanted)
