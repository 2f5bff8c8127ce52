"""Photometric units against the definition of the candela and closed forms."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.results.result import Result
from photonmap.spectra.bands import Bands
from photonmap.spectra.photometry import describe_luminance

UNIT = 683.002 * 106.8569
"""cd·m⁻² of a light of Y = 1; ∫ȳ dλ of CIE 1931 in steps of 1 nm is 106.8569 nm."""


def planck(nm, kelvin):
    """Return the radiance of a black body, W·m⁻²·sr⁻¹·nm⁻¹."""
    h, c, k, at = 6.62607015e-34, 299792458.0, 1.380649e-23, nm * 1e-9
    return 2e-9 * h * c**2 / at**5 / np.expm1(h * c / (at * k * kelvin))


def of_light(bands, light):
    image = np.broadcast_to(bands.emission(light), (2, 3, bands.count)).astype(np.float32)
    return Result({"radiance": image, "shading": image, "reflectance": image}, {}, bands, {})


def test_black_body_at_the_freezing_point_of_platinum():
    """The candela was defined by it until 1979: 60 cd on a square centimetre."""
    nm = np.arange(370.0, 791.0)
    bands = Bands.gaussian(81, 380, 780)
    result = of_light(bands, pm.Spectrum(nm, planck(nm, 2042.15)))
    np.testing.assert_allclose(result.luminance(), 600_000.0, rtol=0.005)
    np.testing.assert_allclose(result.illuminance(), np.pi * result.luminance(), rtol=1e-6)


@pytest.mark.parametrize("bands", [Bands.rgb(), Bands.gaussian(3), Bands.box(6)], ids=repr)
def test_daylight_of_unit_luminance(bands):
    result = of_light(bands, pm.emission("D65 2"))
    luminance = result.luminance("shading")
    assert luminance.shape == (2, 3)
    assert luminance.dtype == np.float32
    np.testing.assert_allclose(luminance, 2.0 * UNIT, rtol=1e-5)


def test_what_is_no_radiance_has_no_luminance():
    result = of_light(Bands.gaussian(3), 1.0)
    with pytest.raises(ValueError, match="'reflectance' is no radiance"):
        result.luminance("reflectance")
    with pytest.raises(ValueError, match="'direct' was not among"):
        result.luminance("direct")


def test_sunlight_on_a_tilted_surface():
    """E cos θ, whatever the reflectance."""
    corners = [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]
    plane = pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], pm.Material("paint", 0.3))
    sun = pm.DirectionalLight((0.0, 3**0.5 / 2.0, -0.5), pm.emission("D65 0.25"))
    scene = pm.Scene(plane, [sun], pm.Camera((0, 0, 5), (0, 0, 0)))
    result = pm.render(scene, bands=6, size=8, passes=1)
    np.testing.assert_allclose(result.illuminance(), 0.25 * UNIT * 0.5, rtol=1e-4)


@pytest.mark.parametrize("bands", [6, "box:6", 9, "400:700:5"])
@pytest.mark.parametrize("lamp", ["FL11", "HPS", "LED-RGB1", "A"])
def test_lamps_with_narrow_lines_have_their_own_illuminance(lamp, bands):
    """A lamp by name has Y = 1; the record states what the bands alone would give."""
    result = render_under(bands, pm.DirectionalLight((0, -1, 0), pm.emission(lamp), name="lamp"))
    (light,) = result.record["light_luminance"]
    assert light["corrected"] == pytest.approx(1.0, abs=1e-9)
    if abs(light["ratio"] - 1.0) > 0.02:
        with pytest.warns(pm.SceneWarning, match=f"'lamp' {light['ratio']:.3f} "):
            illuminance = result.illuminance()
    else:
        illuminance = result.illuminance()
    np.testing.assert_allclose(illuminance, UNIT, rtol=1e-5)
    by_bands = result.luminance("shading", "direct") * np.pi
    np.testing.assert_allclose(by_bands, UNIT * light["ratio"], rtol=1e-5)
    if (lamp, bands) == ("FL11", 6):
        assert light["ratio"] == pytest.approx(0.715, abs=5e-4)


def test_lamps_add_their_luminances():
    bands = Bands.gaussian(6)
    lamps = [(name, pm.emission(name)) for name in ("FL11", "HPS 2", "D65")]
    rows = describe_luminance(bands, lamps, "direct")
    total = sum(bands.emission(color) for _, color in lamps)
    image = np.broadcast_to(total, (2, 3, 6)).astype(np.float32)
    record = {"scene": {"spectra": True}, "light_luminance": rows}
    with pytest.warns(pm.SceneWarning, match="luminance by these bands"):
        luminance = Result({"radiance": image}, {}, bands, record).luminance()
    np.testing.assert_allclose(luminance, 4.0 * UNIT, rtol=1e-5)


def render_under(bands, *lamps):
    corners = [(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)]
    floor = pm.Mesh(corners, [[0, 2, 1], [0, 3, 2]], pm.Material("grey", 0.5))
    camera = pm.Camera((0, 3, 0), (0, 0, 0), up=(0, 0, -1), fov=20)
    scene = pm.Scene([floor], list(lamps), camera)
    return pm.render(scene, bands=bands, size=(2, 2), passes=1, progress=False)
