"""Noise has the variance that is claimed; saturation, rounding and exposure are right."""

import numpy as np
import pytest
from renders import flat, ideal, render_of, scaled
from scipy import stats

import photonmap as pm
from photonmap.capture.expose import find_response

SIGNIFICANCE = 1e-4
"""Of each of the tests below, on both sides together; seeds are fixed."""


def variance_bounds(variance, samples, kurtosis=0.0):
    """Return what the sample variance lies between; χ², widened for excess kurtosis."""
    freedom = (samples - 1) / (1.0 + kurtosis / 2.0)
    tails = stats.chi2.ppf([SIGNIFICANCE / 2, 1 - SIGNIFICANCE / 2], freedom)
    return variance * tails / freedom


@pytest.mark.parametrize("read_noise", [0.0, 5.0])
@pytest.mark.parametrize("iso", [100.0, 400.0])
def test_photon_transfer_curve(read_noise, iso):
    """Variance against mean is the line K mean + K² σ² + 1/12, at levels over 1.5 decades."""
    sensor = ideal(read_noise=read_noise, iso=iso, bits=16, black_level=2000)
    for electrons in (40.0, 150.0, 500.0, 1500.0):
        raw = np.concatenate(
            [
                pm.expose(flat([1.0], size=(32, 32)), scaled(sensor, electrons), seed).raw.ravel()
                for seed in range(8)
            ]
        ).astype(np.float64)
        gain = sensor.gain
        variance = gain**2 * (electrons + read_noise**2) + 1 / 12
        error = np.sqrt(variance / raw.size)
        spread = stats.norm.ppf(1 - SIGNIFICANCE / 2) * error
        assert abs(raw.mean() - 2000 - gain * electrons) < spread
        low, high = variance_bounds(variance, raw.size, 1.0 / electrons)
        assert low < raw.var(ddof=1) < high


def test_dark_current_and_its_noise():
    sensor = ideal(dark_current=30.0, time=10.0, read_noise=4.0, bits=16)
    raw = pm.expose(flat([0.0], size=(64, 64)), sensor, 3).raw.astype(np.float64)
    photo = pm.expose(flat([0.0], size=(64, 64)), sensor, 3)
    variance = sensor.gain**2 * (300.0 + 16.0) + 1 / 12
    low, high = variance_bounds(variance, raw.size, 1 / 300.0)
    assert low < raw.var(ddof=1) < high
    mean = sensor.black + sensor.gain * 300.0
    assert abs(raw.mean() - mean) < 4.0 * np.sqrt(variance / raw.size)
    assert photo.record["black"] == pytest.approx(mean)
    assert abs(photo.demosaiced.mean()) < 4.0 * np.sqrt(variance / raw.size) / sensor.white


def test_fixed_pattern_is_the_specimens():
    """PRNU and DSNU stay from seed to seed, and differ between specimens."""
    sensor = scaled(ideal(prnu=0.02, dsnu=40.0, bits=16), 5000.0)

    def mean(specimen, levels):
        from dataclasses import replace

        chosen = replace(sensor, specimen=specimen)
        photos = [pm.expose(flat(levels, size=(48, 48)), chosen, seed).raw for seed in range(12)]
        return (np.mean(photos, axis=0) - sensor.black) / sensor.gain

    lit, dark, other = mean(0, [1.0]), mean(0, [0.0]), mean(1, [1.0])
    low, high = variance_bounds(40.0**2, dark.size)
    assert low < dark.var(ddof=1) < high
    expected = 40.0**2 + (0.02 * 5000.0) ** 2 + 5000.0 / 12
    low, high = variance_bounds(expected, lit.size)
    assert low < lit.var(ddof=1) < high
    assert np.corrcoef(lit.ravel(), other.ravel())[0, 1] < 0.1
    again = mean(0, [1.0])
    assert np.array_equal(lit, again)


def test_saturation():
    """A full well is the white level at the base ISO; at a lower one, it ends below."""
    for iso, white in ((100.0, 1.0), (400.0, 1.0), (50.0, 0.5)):
        sensor = scaled(ideal(iso=iso, read_noise=0.0), 1e6)
        photo = pm.expose(flat([1.0]), sensor)
        number = sensor.black + white * (sensor.white - sensor.black)
        assert (photo.raw == np.rint(number)).all()
        assert photo.record["saturated"] == 1.0
        assert photo.truth.min() == pytest.approx(1e6 / sensor.saturation, rel=1e-6)


@pytest.mark.parametrize("bits", [1, 8, 12, 16])
def test_numbers_are_within_their_bits(bits):
    ramp = np.linspace(0.0, 2.0, 256).reshape(16, 16, 1)
    photo = pm.expose(render_of(ramp), scaled(ideal(bits=bits), 10000.0))
    assert photo.raw.dtype == np.uint16
    assert photo.raw.min() >= 0
    assert photo.raw.max() == (1 << bits) - 1
    if bits > 1:
        assert photo.raw.min() == photo.record["sensor"]["black_level"] or photo.record["black"]


def test_rounding_is_to_the_nearest_number():
    """With many electrons a number, what is left is rounding: within half a number, and uniform."""
    sensor = ideal(full_well=1e9, bits=8, black_level=10)
    image = np.linspace(0.1, 0.9, 4096).reshape(64, 64, 1)
    photo = pm.expose(render_of(image), scaled(sensor, 1e9))
    exact = 10 + photo.truth[..., 0].astype(np.float64) * 245
    wrong = photo.raw[..., 0].astype(np.float64) - exact
    assert np.abs(wrong).max() < 0.54  # with shot noise of 0.008
    assert wrong.var() == pytest.approx(1 / 12, rel=0.1)


def test_electrons_by_the_camera_equation():
    """One wavelength, by hand: photons are E A t λ / (h c), of which η become electrons."""
    sensor = ideal(camera="550:550:1", aperture=2.0, pixel_pitch=3.0, quantum_efficiency=0.6)
    nm = pm.Bands.parse("550:550:1").sensitivities[0]
    radiance = 2.0
    curve = nm.values / nm.values.max()
    power = np.pi * radiance / 16.0 * 9e-12 * np.trapezoid(curve, nm.wavelengths)
    photons = power * 550e-9 / (6.62607015e-34 * 299792458.0)
    found = float(find_response(sensor).electrons[0]) * radiance
    assert found == pytest.approx(0.6 * photons, rel=2e-3)


def test_automatic_exposure():
    """The percentile of what the pixels see becomes the level, whatever the units of the scene."""
    image = np.linspace(0.0, 1.0, 10000).reshape(100, 100, 1)
    for unit in (1e-6, 1.0, 1e6):
        photo = pm.expose(render_of(image * unit), ideal(time=None, percentile=90.0, level=0.7))
        assert np.percentile(photo.truth[photo.truth > 0.0], 90.0) == pytest.approx(0.7, rel=1e-5)
    assert photo.record["time_s"] > 0.0


def test_lamps_are_not_metered():
    """A window may be half of the image: the room is exposed, unless there is nothing else."""
    image = np.where(np.arange(400) < 200, 50.0, np.linspace(0.5, 1.0, 400)).reshape(20, 20, 1)
    emission = np.where(image == 50.0, image, 0.0).astype(np.float32)
    sensor = ideal(time=None, percentile=100.0, level=0.5)
    result = render_of(image)
    result.buffers["emission"] = emission
    assert pm.expose(result, sensor).truth[10:].max() == pytest.approx(0.5, rel=1e-5)
    result.buffers["emission"] = np.float32(image)
    assert pm.expose(result, sensor).truth.max() == pytest.approx(0.5, rel=1e-5)


def test_seeds():
    result, sensor = flat([1.0, 0.5, 0.2], "Nikon 5100 (NPL)"), pm.Sensor()
    first, again, other = (pm.expose(result, sensor, seed) for seed in (1, 1, 2))
    assert np.array_equal(first.raw, again.raw)
    assert not np.array_equal(first.raw, other.raw)
    assert np.array_equal(first.truth, other.truth)


def test_relative_sensitivities_count():
    """Channels see what ∫ L s dλ gives them: curves of half the height, half the electrons."""
    a = find_response(pm.Sensor(camera="Nikon 5100 (NPL)")).electrons
    with colour_curves() as areas:
        assert a / a[1] == pytest.approx(areas / areas[1], rel=1e-3)


def test_heights_of_extrapolated_cameras_count_too():
    """Those of the observer peak at 1.06, 1 and 1.78; one camera's curves end at 680 nm."""
    name = "CIE 1931 2 Degree Standard Observer"
    found = [find_response(pm.Sensor(camera=c)).electrons for c in (name, f"extrapolate:{name}")]
    np.testing.assert_allclose(found[1], found[0], rtol=1e-6)
    with pytest.raises(pm.InputError, match="covers 400-680 nm"):
        find_response(pm.Sensor(camera="Sigma SDMerill (NPL)"))
    whole = find_response(pm.Sensor(camera="extrapolate:Sigma SDMerill (NPL)"))
    assert whole.bands.names == ("red", "green", "blue")


def test_dark_current_that_fills_the_pixels():
    with pytest.raises(pm.InputError, match="the dark current alone fills the pixels"):
        pm.expose(flat([1.0]), ideal(dark_current=10.0, time=1000.0))


class colour_curves:  # noqa: N801
    """The areas below the curves of the camera, as colour-science has them."""

    def __enter__(self):
        from photonmap.spectra.names import colour_science

        with colour_science() as colour:
            curves = colour.MSDS_CAMERA_SENSITIVITIES["Nikon 5100 (NPL)"]
        return np.array([np.trapezoid(v, curves.wavelengths) for v in curves.values.T])

    def __exit__(self, *_):
        pass
