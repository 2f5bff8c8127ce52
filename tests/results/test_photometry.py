"""Photometric units against the definition of the candela and closed forms."""

from contextlib import nullcontext

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import photonmap as pm
from photonmap.results.result import Result
from photonmap.spectra import observer
from photonmap.spectra.bands import Bands
from photonmap.spectra.photometry import (
    corrected_weights,
    describe_luminance,
    luminance_weights,
)

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


def luminance_of(bands, rows, image):
    """Return the luminance of an image under lamps that a record describes."""
    image = np.broadcast_to(image, (2, 3, bands.count)).astype(np.float32)
    record = {"scene": {"spectra": True}, "light_luminance": rows}
    return Result({"radiance": image}, {}, bands, record).luminance()


@pytest.mark.parametrize("bands", [6, "box:6", 9, "400:700:5"])
@pytest.mark.parametrize("lamp", ["FL11", "HPS", "LED-RGB1", "A"])
def test_lamps_with_narrow_lines_have_their_own_luminance(lamp, bands):
    """A lamp by name has Y = 1; the record states what the bands alone would give."""
    bands, color = Bands.parse(bands), pm.emission(lamp)
    (light,) = rows = describe_luminance(bands, [("lamp", color)], "direct")
    assert light["corrected"] == pytest.approx(1.0, abs=1e-9)
    assert light["lines"] == (lamp != "A")
    if abs(light["ratio"] - 1.0) > 0.02:
        with pytest.warns(pm.SceneWarning, match=f"'lamp' {light['ratio']:.3f} "):
            luminance = luminance_of(bands, rows, bands.emission(color))
    else:
        luminance = luminance_of(bands, rows, bands.emission(color))
    np.testing.assert_allclose(luminance, UNIT, rtol=1e-5)
    if (lamp, bands.count, bands.kind) == ("FL11", 6, "gaussian"):
        assert light["ratio"] == pytest.approx(0.715, abs=5e-4)


@st.composite
def spectra(draw):
    """A black body below lines of any place, width and strength."""
    nm = np.arange(380.0, 781.0)
    values = planck(nm, draw(st.floats(1500.0, 10000.0)))
    values /= values.max()
    for _ in range(draw(st.integers(0, 4))):
        place, width = draw(st.floats(400.0, 700.0)), draw(st.floats(0.5, 15.0))
        values += draw(st.floats(0.0, 100.0)) * np.exp(-0.5 * ((nm - place) / width) ** 2)
    return pm.Spectrum(nm, values)


ANY_BANDS = st.sampled_from(["3", "6", "9", "box:4", "best:6", "400:700:20"])


@settings(max_examples=25, deadline=None)
@given(bands=ANY_BANDS, lamps=st.lists(spectra(), min_size=1, max_size=3))
def test_direct_light_of_any_spectrum_is_exact(bands, lamps):
    bands = Bands.parse(bands)
    rows = describe_luminance(bands, enumerate(lamps), "direct")
    weights = corrected_weights(luminance_weights(bands, "direct"), rows)
    values = np.array([row["bands"] for row in rows])
    if np.linalg.cond(values / np.linalg.norm(values, axis=1, keepdims=True)) < 100.0:
        exact = [observer.luminance(lamp) for lamp in lamps]
        by_bands = [weights @ bands.emission(lamp) for lamp in lamps]
        np.testing.assert_allclose(by_bands, exact, rtol=1e-8)


def test_lamps_add_their_luminances():
    bands = Bands.gaussian(6)
    lamps = [(name, pm.emission(name)) for name in ("FL11", "HPS 2", "D65")]
    rows = describe_luminance(bands, lamps, "direct")
    with pytest.warns(pm.SceneWarning, match="luminance by these bands"):
        luminance = luminance_of(bands, rows, sum(bands.emission(color) for _, color in lamps))
    np.testing.assert_allclose(luminance, 4.0 * UNIT, rtol=1e-5)


def render_under(bands, *lamps, grey=0.5):
    """Render a floor in front of a wall."""
    floor = [(-1, 0, 0), (1, 0, 0), (1, 0, 2), (-1, 0, 2)]
    wall = [(-1, 0, 0), (1, 0, 0), (1, 2, 0), (-1, 2, 0)]
    paint = pm.Material("grey", grey)
    meshes = [
        pm.Mesh(floor, [[0, 2, 1], [0, 3, 2]], paint, name="floor"),
        pm.Mesh(wall, [[0, 1, 2], [0, 2, 3]], paint, name="wall"),
    ]
    camera = pm.Camera((0, 3, 1), (0, 0, 1), up=(0, 0, -1), fov=20)
    scene = pm.Scene(meshes, list(lamps), camera)
    return pm.render(scene, bands=bands, size=(4, 4), passes=1, photons=2000, progress=False)


def sun(color, name="lamp", direction=(0, -1, -1)):
    return pm.DirectionalLight(direction, color, name=name)


def test_direct_light_and_grey_surfaces_have_the_luminance_of_their_lamp():
    """What no colour changes is that of a lamp of the constant 1, to the last photon."""
    same = render_under("rgb", sun(1.0))
    direct, indirect = (same.luminance(name) for name in ("direct", "indirect"))
    np.testing.assert_allclose(direct, 0.5 / np.pi * UNIT * 0.5**0.5, rtol=1e-5)
    assert (indirect > 0.05 * direct).all()
    for lamp in ("FL11", "D65", "LED-B5", "planck:2856"):
        is_off = lamp == "FL11"
        said = r"'lamp' 0\.715 .* rgb\(\) and xyz\(\) do not"
        with pytest.warns(pm.SceneWarning, match=said) if is_off else nullcontext():
            result = render_under(6, sun(pm.emission(lamp)))
        assert len(result.record["warnings"]) == is_off
        with pytest.warns(pm.SceneWarning, match=said) if is_off else nullcontext():
            found = [result.luminance(name) for name in ("direct", "indirect")]
        np.testing.assert_allclose(found, [direct, indirect], rtol=2e-5)


@pytest.mark.filterwarnings("ignore:luminance by these bands")
def test_lamps_together_have_the_sum_of_their_luminances():
    """Exactly, as each is sampled."""
    names = ("FL11", "D65", "LED-B5", "planck:2856")
    lamps = [sun(pm.emission(name), name, (0, -1, 0)) for name in names]
    illuminance = render_under(6, *lamps, grey=0.0).illuminance()
    assert illuminance == pytest.approx(4.0 * UNIT, rel=1e-5)
