"""The model of the sun and the sky: the paper's formulas, spectra, the sun's disc, and energy."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.errors import InputError
from photonmap.spectra import daylight as solar
from photonmap.spectra.color_text import emission
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.daylight import (
    LUMENS,
    SUN_DIAMETER,
    SUN_SOLID_ANGLE,
    ClearSky,
    daylight_basis,
)
from photonmap.spectra.observer import luminance, observer, radiance_to_rgb

SKIES = [(2.0, 20.0), (3.0, 45.0), (6.0, 70.0)]
each_sky = pytest.mark.parametrize("sky", [ClearSky(*each) for each in SKIES], ids=str)


def chromaticity(spectrum):
    xyz = observer().rgb_to_xyz @ radiance_to_rgb(spectrum)
    return xyz[:2] / xyz.sum()


def lux(irradiance):
    return luminance(irradiance) * LUMENS * observer().efficiency


def spectrum_of(weights):
    wavelengths, basis = daylight_basis()
    return Spectrum(wavelengths, weights @ basis)


@pytest.mark.parametrize(
    ("turbidity", "elevation", "wanted"),
    [
        # The appendix's formulas, worked out by hand.
        (2.0, 45.0, (4.4697, 0.24095, 0.24372)),
        (3.0, 90.0, (29.479, 0.27068, 0.28236)),
        (6.0, 30.0, (9.5853, 0.26547, 0.28182)),
    ],
)
def test_the_zenith_is_that_of_the_paper(turbidity, elevation, wanted):
    sky = ClearSky(turbidity, elevation)
    found = sky.zenith_luminance, *sky.zenith_chromaticity
    np.testing.assert_allclose(found, wanted, rtol=3e-4)


@each_sky
def test_the_formula_ends_at_the_zenith(sky):
    found = sky.appearance(0.0, sky.sun_zenith)
    np.testing.assert_allclose(found, (sky.zenith_luminance, *sky.zenith_chromaticity), rtol=1e-12)


@each_sky
@pytest.mark.parametrize(("zenith", "from_sun"), [(0.0, 0.6), (1.2, 0.4), (0.9, 1.5)])
def test_spectra_have_the_luminance_and_the_chromaticity(sky, zenith, from_sun):
    kilo, x, y = sky.appearance(zenith, from_sun)
    spectrum = spectrum_of(sky.weights(zenith, from_sun))
    assert luminance(spectrum) * LUMENS * observer().efficiency == pytest.approx(1000.0 * kilo)
    # M1 and M2 of CIE 15 have four digits.
    np.testing.assert_allclose(chromaticity(spectrum), (x, y), atol=6e-4)


@pytest.mark.parametrize("turbidity", [2.0, 4.0, 10.0])
@pytest.mark.parametrize("elevation", [5.0, 15.0, 60.0])
def test_no_spectrum_is_negative(turbidity, elevation):
    weights = pm.SkyLight(turbidity, elevation).weights().reshape(-1, 3)
    wavelengths, basis = daylight_basis()
    seen = basis[:, (wavelengths >= 380.0) & (wavelengths <= 780.0)]
    values = weights.astype(float) @ seen
    assert values.min() > -1e-6 * values.max()


def test_the_sun_is_a_disc():
    assert pytest.approx(np.pi * np.radians(SUN_DIAMETER / 2.0) ** 2, rel=1e-5) == SUN_SOLID_ANGLE
    assert pytest.approx(6.80e-5, rel=1e-3) == SUN_SOLID_ANGLE


def test_sunlight_above_the_air_is_that_of_the_sun():
    """Nearly that of a black body of 5778 K, which has no Fraunhofer lines; 128 klx in all."""
    nm = solar.WAVELENGTHS
    black = 1.1910429724e20 / nm**5 / np.expm1(1.438776877e7 / (nm * 5778.0))
    ratio = (solar.SUN_RADIANCE / black)[(nm >= 450.0) & (nm <= 700.0)]
    assert (np.abs(ratio - 1.0) < 0.2).all()
    assert ratio.mean() == pytest.approx(1.0, abs=0.06)
    whole = lux(Spectrum(nm, solar.SUN_RADIANCE * SUN_SOLID_ANGLE))
    assert whole == pytest.approx(128e3, rel=0.01)


def test_air_lets_light_pass_by_beers_law():
    once, twice = (solar.transmittance(mass, 0.1) for mass in (1.0, 2.0))
    below = solar.WAVELENGTHS < 680.0  # where no band of water or oxygen saturates
    np.testing.assert_allclose(twice[below], once[below] ** 2)
    # Rayleigh scattering and ozone alone: 1 - exp(-0.0088 · 0.55^-4.08) is 0.096, ozone 0.03.
    clean = solar.transmittance(1.0, 0.0)[solar.WAVELENGTHS == 550.0]
    np.testing.assert_allclose(clean, np.exp(-0.008735 * 0.55**-4.08 - 0.35 * 0.085))


def test_a_low_sun_is_dim_and_red():
    suns = [ClearSky(3.0, elevation).sun() for elevation in (5.0, 20.0, 60.0)]
    light = [lux(sun) for sun in suns]
    assert light == sorted(light)
    red = [chromaticity(sun)[0] for sun in suns]
    assert red == sorted(red, reverse=True)
    assert lux(ClearSky(2.0, 60.0).sun()) == pytest.approx(100e3, rel=0.05)  # a bright day


@pytest.mark.parametrize("elevation", [20.0, 45.0, 70.0])
@pytest.mark.parametrize("turbidity", [3.0, 4.0])
def test_air_makes_no_light(turbidity, elevation):
    """Sun and sky bring less than the sun would without air; most of it on clear days."""
    sky = ClearSky(turbidity, elevation)
    sine = np.sin(np.radians(elevation))
    whole = lux(Spectrum(solar.WAVELENGTHS, solar.SUN_RADIANCE * SUN_SOLID_ANGLE)) * sine
    assert 0.75 * whole < lux(sky.sun()) * sine + lux(sky.skylight()) < whole


def test_lights_have_names():
    for text, curve in (("sun:3,30", "sun"), ("sky:3, 30", "skylight")):
        found, wanted = emission(text), getattr(ClearSky(3.0, 30.0), curve)()
        assert luminance(found) == pytest.approx(1.0)
        np.testing.assert_allclose(found.values, wanted.values / luminance(wanted))
    assert luminance(emission("sun:3,30 2.5")) == pytest.approx(2.5)
    with pytest.raises(InputError, match="needs two numbers, as in sky:3,45"):
        emission("sky:3")
    with pytest.raises(InputError, match="elevation 2 is out of range; give 5 to 90"):
        emission("sun:3,2")
