"""Spectra: lines, bands that share nothing, metamers, and any number of bands."""

from dataclasses import replace

import numpy as np
import pytest
from cases import rendered
from helpers.scenes import closed_box, quad

import photonmap as pm

VIEW = pm.Camera((0.3, 0.2, 0.8), (-0.2, -0.1, -1.0), fov=70.0)
NM = np.linspace(400.0, 700.0, 301)


def room(reflectance, emission):
    """A closed room of one reflectance under a lamp."""
    corners = np.array([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)])
    lamp = quad(*(0.3 * corners + [0, 0.95, 0]), pm.Material("lamp", 0.0, emission), "lamp")
    return pm.Scene([closed_box(pm.Material("wall", reflectance)), lamp], camera=VIEW)


def line(nm, width=0.5):
    """All power within a line."""
    return pm.Spectrum(NM, 100.0 * np.exp(-0.5 * ((NM - nm) / width) ** 2))


def ramp(low, high):
    return pm.Spectrum(np.array([400.0, 700.0]), np.array([low, high]))


@pytest.mark.filterwarnings("ignore:luminance by these bands")
@pytest.mark.parametrize("bands", [1, 6, 31])
def test_a_line_lights_the_bands_that_see_it(bands):
    """Each band of the picture is as bright as the line is in it."""
    sensors = pm.Bands.gaussian(bands)
    result = rendered(room(0.5, line(550.0)), bands=bands)
    white = rendered(room(0.5, 1.0), bands=bands)
    wanted = sensors.emission(line(550.0)) * white.radiance
    np.testing.assert_allclose(result.radiance, wanted, rtol=1e-4, atol=1e-6 * wanted.max())


def test_one_band_of_81_is_lit():
    """The others stay exactly black, and their errors 0."""
    bands = pm.Bands.parse("box:81")
    edges = np.linspace(400.0, 700.0, 82)
    spectrum = np.where((edges[40] < NM) & (edges[41] > NM), 1.0, 0.0)
    result = rendered(room(0.5, pm.Spectrum(NM, spectrum)), bands=bands)
    lit = bands.emission(pm.Spectrum(NM, spectrum)) > 0.0
    assert 1 <= lit.sum() <= 3
    assert result.radiance[..., lit].any(axis=(0, 1)).all()
    assert not result.radiance[..., ~lit].any()
    assert not result.standard_error("radiance")[..., ~lit].any()


def test_sensors_that_share_no_wavelength_with_the_light(tmp_path):
    """A lamp of the blue and sensors of the red: black, whatever the surfaces."""
    sensors = tmp_path / "sensors.csv"
    sensors.write_text("nm,a,b\n400,1,0\n500,1,0\n501,0,0\n599,0,0\n600,0,1\n700,0,1\n")
    blue = pm.Spectrum(np.array([400.0, 480.0, 481.0, 700.0]), np.array([1.0, 1.0, 0.0, 0.0]))
    result = rendered(room(ramp(0.2, 0.8), blue), bands=pm.Bands.parse(str(sensors)))
    assert result.radiance[..., 0].any()
    assert not result.radiance[..., 1].any()


def test_metamers_look_alike_to_sensors_for_which_they_are():
    """Two reflectances with the same band values give the same picture; in other bands they do not.

    After one bounce, not after many: but here bands are all that is known of spectra.
    """
    bands = pm.Bands.gaussian(3)
    curves = np.array([np.interp(NM, s.wavelengths, s.values, 0, 0) for s in bands.sensitivities])
    null = np.linalg.svd(curves)[2][-40:]
    ripple = null[0] / np.abs(null[0]).max()
    flat, rippled = pm.Spectrum(NM, np.full(301, 0.5)), pm.Spectrum(NM, 0.5 + 0.3 * ripple)
    np.testing.assert_allclose(bands.reflectance(flat), bands.reflectance(rippled), atol=2e-3)
    one, other = (rendered(room(s, 1.0), bands=bands) for s in (flat, rippled))
    np.testing.assert_allclose(one.radiance, other.radiance, rtol=0.02)


@pytest.mark.parametrize("bands", [1, 2, 81, 256])
def test_any_number_of_bands(bands):
    """Of a grey room all bands are the same to the last bit; of a coloured one none is unsound."""
    grey = rendered(room(0.5, 1.0), bands=bands, size=(8, 8))
    assert grey.radiance.shape == (8, 8, bands)
    np.testing.assert_array_equal(grey.radiance, np.repeat(grey.radiance[..., :1], bands, axis=-1))
    rendered(room(ramp(0.1, 0.9), ramp(1.0, 3.0)), bands=bands, size=(8, 8))


@pytest.mark.parametrize("method", ["photon", "path"])
def test_a_reflectance_of_0_in_some_bands(method):
    """Where walls reflect nothing, only direct light is left, and shading of it alone."""
    step = pm.Spectrum(np.array([400.0, 550.0, 551.0, 700.0]), np.array([0.0, 0.0, 0.9, 0.9]))
    bands = pm.Bands.parse("box:6")
    result = rendered(room(step, 1.0), bands=bands, method=method)
    black = bands.reflectance(step) == 0.0
    assert black.any()
    assert not black.all()
    wall = (result.emission == 0.0).all(axis=-1)
    assert not result.radiance[wall][:, black].any()
    direct_alone, all_light = (result.shading[wall][:, b].mean() for b in (black, ~black))
    assert 0.0 < direct_alone < all_light


def test_a_dark_line_between_bright_bands_keeps_its_digits():
    """Light of 1 beside light of 1e-12 in the next band: both to 1e-4."""
    bands = pm.Bands.parse("box:2")
    steps = np.array([400.0, 549.0, 551.0, 700.0])
    dim = pm.Spectrum(steps, np.array([1.0, 1.0, 1e-12, 1e-12]))
    ends = replace(dim, values=np.array([1.0, 1.0, 1.0, 1.0]))
    found = rendered(room(0.5, dim), bands=bands)
    even = rendered(room(0.5, ends), bands=bands)
    share = bands.emission(dim)
    np.testing.assert_allclose(found.radiance, share * even.radiance, rtol=1e-4)
