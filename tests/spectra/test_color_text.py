"""Colours as text: numbers, triples, names, notations and files."""

import numpy as np
import pytest

from photonmap.errors import InputError
from photonmap.spectra import color_text
from photonmap.spectra.color_text import emission, reflectance
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.names import colour_science
from photonmap.spectra.observer import observer, radiance_to_rgb, reflectance_to_rgb

LUMINANCE = observer().rgb_to_xyz[1]


@pytest.fixture
def chip(tmp_path):
    (tmp_path / "my chip.csv").write_text("nm,r\n400,0.2\n700,0.6\n")
    return tmp_path


@pytest.mark.parametrize("read", [reflectance, emission])
@pytest.mark.parametrize(
    ("words", "color"),
    [
        ("0.5", 0.5),
        (" 0.5 0.5 ", 0.25),
        ("1e-1", 0.1),
        ("rgb:.1,.2,.4", (0.1, 0.2, 0.4)),
        ("rgb: .1 .2 .4 2", (0.2, 0.4, 0.8)),
        ("rgb:.1 .2 .4", (0.1, 0.2, 0.4)),
        ("rgb:.1, .2, .4", (0.1, 0.2, 0.4)),
        ("my chip.csv", Spectrum([400, 700], [0.2, 0.6])),
        ("my chip.csv 0.5", Spectrum([400, 700], [0.1, 0.3])),
        ("extrapolate: my chip.csv", Spectrum([400, 700], [0.2, 0.6], extrapolate=True)),
    ],
)
def test_what_reflectances_and_lights_share(read, words, color, chip):
    assert read(words, chip) == color


def test_names_of_patches():
    for words in ("dark skin", "Dark Skin", "dark skin 1"):
        np.testing.assert_allclose(
            reflectance_to_rgb(reflectance(words)), [0.17, 0.08, 0.06], atol=0.01
        )
    assert reflectance("white 9.5") == reflectance("white 9.5 (.05 D)")
    assert reflectance("white 9.5 0.5") == 0.5 * reflectance("white 9.5")


@pytest.mark.parametrize(
    ("words", "same"),
    [
        ("munsell:N 5", "munsell:N5"),
        ("munsell: n 5", "munsell:N5"),
        ("extrapolate: munsell:N 5", "extrapolate:munsell:N5"),
        ("munsell:5R 5 / 10", "munsell:5R 5/10"),
        ("munsell:5R 5/10", "munsell:5R 5/10"),
        ("xyz:.2 .3 .1", "xyz:.2,.3,.1"),
        ("xyY: .3, .3, .5", "xyY:.3,.3,.5"),
    ],
)
def test_numbers_of_notations_are_no_factors(words, same):
    assert reflectance(words) == reflectance(same)
    halved, expected = reflectance(f"{words} 0.5"), reflectance(f"{same} 0.5")
    assert halved == expected != reflectance(same)


@pytest.mark.parametrize(
    ("symbol", "wavelength", "n", "k"),
    [
        ("Au", 659.5, 0.14, 3.697),
        ("Au", 548.6, 0.43, 2.455),
        ("Cu", 659.5, 0.22, 3.747),
        ("Ag", 548.6, 0.06, 3.586),
    ],
)
def test_metals_reflect_as_their_published_index_says(symbol, wavelength, n, k):
    """Rows of Johnson and Christy, 1972; Fresnel's equations at normal incidence."""
    expected = abs((n + 1j * k - 1.0) / (n + 1j * k + 1.0)) ** 2
    found = reflectance(f"metal:{symbol}")
    assert found(np.array([wavelength])) == pytest.approx([expected], abs=0.003)
    assert reflectance(f"metal:{symbol} 0.5") == 0.5 * found


def test_metals_by_a_table_of_their_index(tmp_path):
    (tmp_path / "index.csv").write_text("nm,n,k\n380,2,0\n500,1,1\n780,0.2,3\n")
    found = reflectance("metal:index.csv", tmp_path)
    expected = Spectrum([380, 500, 780], [1.0 / 9.0, 1.0 / 5.0, 9.64 / 10.44])
    np.testing.assert_allclose(found.values, expected.values, rtol=1e-12)


@pytest.mark.parametrize("name", ["D65", "a", "FL2", "Kinoton 75P", "60 A/W (Soft White)"])
def test_named_lights_have_unit_luminance(name):
    light = emission(name)
    assert LUMINANCE @ radiance_to_rgb(light) == pytest.approx(1.0, rel=1e-12)
    with colour_science() as colour:
        table = {
            k.lower(): v for k, v in {**colour.SDS_LIGHT_SOURCES, **colour.SDS_ILLUMINANTS}.items()
        }
    wanted = table[name.lower()]
    ratio = light.values / wanted.values
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-12)
    assert LUMINANCE @ radiance_to_rgb(emission(f"{name} 15")) == pytest.approx(15.0, rel=1e-12)


def test_a_lamp_of_d65_is_white():
    np.testing.assert_allclose(radiance_to_rgb(emission("D65")), np.ones(3), rtol=1e-9)
    assert emission("F11") == emission("FL11")


def test_black_bodies_follow_planck():
    light = emission("planck:2856")
    assert light == emission("planck: 2856")
    nm = light.wavelengths
    planck = 1.0 / (nm**5 * np.expm1(1.438776877e7 / (nm * 2856.0)))  # c₂ = 1.4388e7 nm·K, CODATA
    ratio = light.values / planck
    np.testing.assert_allclose(ratio, ratio[0], rtol=2e-4)


def test_daylight_is_that_of_the_cie():
    """D65 is the phase of 6504 K, and the chromaticity of 5003 K is that of D50 (CIE 15)."""
    table, light = emission("D65"), emission("daylight:6504")
    at = np.arange(400.0, 701.0, 10.0)
    expected = np.interp(at, table.wavelengths, table.values)
    np.testing.assert_allclose(np.interp(at, light.wavelengths, light.values), expected, rtol=1e-3)
    x, y, z = observer().rgb_to_xyz @ radiance_to_rgb(emission("daylight:5003"))
    assert (x / (x + y + z), y / (x + y + z)) == pytest.approx((0.3457, 0.3585), abs=3e-4)


@pytest.mark.parametrize("xyz", [(0.2, 0.3, 0.1), (0.05, 0.2, 0.02), (0.4, 0.2, 0.01)])
def test_a_reflectance_has_its_xyz_under_d65(xyz):
    """The first lies within sRGB, the others beyond: those become curves."""
    color = reflectance("xyz:" + ",".join(map(str, xyz)))
    assert isinstance(color, Spectrum) == (xyz != (0.2, 0.3, 0.1))
    rgb = reflectance_to_rgb(color) if isinstance(color, Spectrum) else np.array(color)
    np.testing.assert_allclose(observer().rgb_to_xyz @ rgb, xyz, rtol=1e-3)


@pytest.mark.parametrize("xyz", [(2.0, 3.0, 1.0), (0.1, 0.9, 0.1), (40.0, 20.0, 1.0)])
def test_a_light_has_its_xyz(xyz):
    color = emission("xyz:" + ",".join(map(str, xyz)))
    rgb = radiance_to_rgb(color) if isinstance(color, Spectrum) else np.array(color)
    np.testing.assert_allclose(observer().rgb_to_xyz @ rgb, xyz, rtol=1e-3)


def test_white_is_white_in_every_notation():
    white = observer().rgb_to_xyz.sum(axis=1)
    x, y, _ = white / white.sum()
    for read in (reflectance, emission):
        assert read("xyz:" + ",".join(map(repr, white.tolist()))) == (1.0, 1.0, 1.0)
        np.testing.assert_allclose(read(f"xyY:{x!s},{y!s},1"), np.ones(3), rtol=1e-12)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "'' is not a colour; write a number, a name or a file"),
        ("extrapolate:", "is not a colour"),
        ("1.2", "'1.2' is not a reflectance; keep it between 0 and 1"),
        ("-0.1", "not a reflectance"),
        (
            "my chip.csv 2",
            r"reflectance is 1.00\d+ at 5\d\d nm; it must lie between 0 and 1|is 1.2 at 700",
        ),
        ("rgb:1,2", "'rgb:1,2' needs three numbers, as in rgb:.2,.3,.4"),
        ("rgb:1,2,x", "needs three numbers"),
        ("rgb:0,0,1.1", "not a reflectance"),
        ("xyz:20,30,10", "divide values of 0 to 100 by 100"),
        ("xyz:-1,0,0", "give three values of 0 or more"),
        ("xyY:.3,0,.5", "y must be above 0"),
        ("dark skim", "did you mean 'dark skin'"),
        ("metal:Ay", r"metal:Ay: there is no metal 'Ay'; "),
        ("metal:white.csv 2", "must lie between 0 and 1"),
        ("metal:one.csv", "one.csv: has 1 column.s. after the wavelength; a metal's index has two"),
        ("metal:negative.csv", r"negative.csv:2: n or k of the index is -3 at 700 nm"),
        ("metal:none.csv", "none.csv: cannot be read"),
        ("munsel:5R 5/8", "there is no notation 'munsel:'; did you mean 'munsell:'"),
        ("RGB:.1,.2,.3", "there is no notation 'RGB:'; did you mean 'rgb:'"),
        ("qq:5", r"'qq:5' is not a reflectance: there is no notation 'qq:'; choose from 'rgb:'"),
        ("munsell:red", "write it as '5R 5/10' or 'N 5'"),
        ("planck:2856", "is a light, not a reflectance"),
        ("daylight:6500", "is a light, not a reflectance"),
        ("sfu:1", "is a light, not a reflectance"),
        ("none.csv", r"none.csv: cannot be read"),
        ("nan", "there is no reflectance 'nan'"),
        ("two.csv", "two.csv: has 2 curves"),
        (
            "short.csv",
            r"covers 450-650 nm, but 400-700 nm is needed: 400-450 and 650-700 nm is missing",
        ),
    ],
)
def test_what_is_no_reflectance_is_told(words, message, chip):
    (chip / "two.csv").write_text("400,0.2,0.3\n700,0.6,0.3\n")
    (chip / "white.csv").write_text("400,0,5\n700,0,5\n")
    (chip / "one.csv").write_text("400,0.2\n700,0.6\n")
    (chip / "negative.csv").write_text("400,0.2,3\n700,0.6,-3\n")
    (chip / "short.csv").write_text("450,0.2\n650,0.6\n")
    with pytest.raises(InputError, match=message):
        reflectance(words, chip)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("-1", "'-1' is not a light; write finite values of 0 or more"),
        ("D65 -1", "not a light"),
        ("D66", "did you mean 'D65'"),
        ("D65 nan", "'nan' in 'D65 nan' is not a factor; write one finite number, as in 'D65 0.5'"),
        ("D65  3 W", "'3 W' in 'D65 3 W' is not a factor"),
        ("planck:2856 1e400", "'1e400' in .* is not a factor"),
        ("D65 W", "there is no light 'D65 W'; did you mean 'D65'"),
        ("sun:3 bright", "needs two numbers, as in sun:3,45"),
        ("ISO 7589", "there is no light 'ISO 7589'; did you mean 'ISO 7589"),
        ("munsell:5R 5/10", "is a reflectance, not a light"),
        ("metal:Au", "'metal:Au' is a reflectance, not a light"),
        ("plank:2856", "there is no notation 'plank:'; did you mean 'planck:'"),
        ("planck:hot", "needs a temperature in K"),
        ("daylight:noon", "needs a temperature in K, as in daylight:5000"),
        ("daylight:3000", "daylight of 3000 K is out of range; write 4000 to 25000 K"),
        ("planck:20", "write 300 to 1e"),
        ("xyz:.01,0,.9", "no light has the XYZ"),
        ("sfu:1", "--illuminants PATH, or set PHOTONMAP_ILLUMINANTS"),
    ],
)
def test_what_is_no_light_is_told(words, message, monkeypatch):
    monkeypatch.delenv(color_text.ILLUMINANTS, raising=False)
    with pytest.raises(InputError, match=message):
        emission(words)


def test_measured_lights_have_the_names_of_their_file(tmp_path, monkeypatch):
    np.savez(tmp_path / "lights.npz", wavelength=[380.0, 780.0], lab=[[1.0, 2.0], [3.0, 3.0]])
    monkeypatch.setenv(color_text.ILLUMINANTS, str(tmp_path / "lights.npz"))
    assert emission("sfu:lab/2 2") == Spectrum([380, 780], [6, 6])
    with pytest.raises(InputError, match=r"no curve 'lab/3'; did you mean 'lab/"):
        emission("sfu:lab/3")


def test_leds_have_a_peak_a_width_and_the_power_of_a_constant():
    led, lamp = emission("led:405,15 2"), emission("black light")
    assert led.wavelengths[led.values.argmax()] == 405.0
    half = led.wavelengths[led.values >= 0.5 * led.values.max()]
    assert half[[0, -1]] == pytest.approx([405.0 - 7.5, 405.0 + 7.5], abs=0.5)
    for light, power in ((led, 600.0), (lamp, 300.0)):
        assert np.trapezoid(light.values, light.wavelengths) == pytest.approx(power)
    with pytest.raises(InputError, match="led:100,15: give a peak from 280 to 800 nm"):
        emission("led:100,15")
    with pytest.raises(InputError, match="'led:405' needs two numbers, as in led:405,15"):
        emission("led:405")
