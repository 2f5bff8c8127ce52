"""Colours and textures of Mitsuba."""

import numpy as np
import pytest

from photonmap.errors import InputError, SceneWarning
from photonmap.scene.textures import Texture
from photonmap.spectra.curves import Spectrum

AT = np.array([450.0, 550.0, 650.0])


@pytest.fixture
def reflectance(look):
    """Return the reflectance of a diffuse ball; `@` stands for its name."""

    def reflectance(value, **options):
        return look("diffuse", value.replace("@", 'name="reflectance"'), **options).reflectance

    return reflectance


@pytest.fixture
def radiance(load):
    """Return the radiance of a dome; `@` stands for its name."""

    def radiance(value, **options):
        dome = value.replace("@", 'name="radiance"')
        scene = load(f'<shape type="sphere"/><emitter type="constant">{dome}</emitter>', **options)
        return scene.lights[0].radiance

    return radiance


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ('<rgb @ value=".1, .2 .3"/>', (0.1, 0.2, 0.3)),
        ('<rgb @ value=".4"/>', (0.4, 0.4, 0.4)),
        ('<float @ value=".4"/>', 0.4),
        ('<spectrum @ value=".4"/>', 0.4),
        ('<spectrum @ value=".1, .2, .3"/>', (0.1, 0.2, 0.3)),
        ('<rgb @ value="1.0005"/>', (1.0, 1.0, 1.0)),
        ('<spectrum type="srgb" @><rgb name="color" value=".1"/></spectrum>', (0.1, 0.1, 0.1)),
    ],
)  # fmt: skip
def test_reflectances(reflectance, value, expected):
    assert reflectance(value) == expected


def test_colours_encoded_in_srgb(reflectance):
    """188 of 255 is half of the light; as the scenes of Mitsuba 0.x have it."""
    for value in ('<srgb @ value="#bc00ff"/>', '<srgb @ value=".7372549 0 1"/>'):
        np.testing.assert_allclose(reflectance(value), [0.5029, 0.0, 1.0], atol=1e-4)
    old = reflectance('<rgb @ value="#bc00ff"/>', version="0.6.0")  # which is linear
    np.testing.assert_allclose(old, [0.7372549, 0.0, 1.0])


@pytest.mark.parametrize(
    "value",
    [
        '<spectrum @ value="450:.2, 550:.4, 650:.3"/>',
        '<spectrum @ value="450:0.2 550:0.4 650:0.3"/>',
        '<spectrum @ filename="a.spd"/>',
        """<spectrum @ type="irregular"><string name="wavelengths" value="450, 550, 650"/>
<string name="values" value=".2, .4, .3"/></spectrum>""",
        """<spectrum @ type="regular"><float name="wavelength_min" value="450"/>
<float name="wavelength_max" value="650"/><string name="values" value=".2 .4 .3"/></spectrum>""",
    ],
)
def test_curves_are_0_beyond_their_ends(reflectance, value):
    curve = reflectance(value, files={"a.spd": "# gold\n450 .2\n550 .4\n\n650 .3\n"})
    np.testing.assert_allclose(curve(AT), [0.2, 0.4, 0.3])
    np.testing.assert_allclose(curve(np.array([500.0, 600.0])), [0.3, 0.35])
    np.testing.assert_allclose(curve(np.array([350.0, 449.9, 650.1, 900.0])), 0.0)
    curve.check_covers(300.0, 1000.0)


def test_plain_numbers_are_d65_and_plain_spectra_are_flat(radiance):
    assert radiance('<float @ value="2"/>') == (2.0, 2.0, 2.0)
    assert radiance('<rgb @ value="1 2 30"/>') == (1.0, 2.0, 30.0)
    scaled = '<spectrum type="d65" @><float name="scale" value="3"/></spectrum>'
    assert radiance(scaled) == (3.0, 3.0, 3.0)
    for value in (
        '<spectrum @ value="2"/>',
        '<spectrum type="uniform" @><float name="value" value="2"/></spectrum>',
    ):
        flat = radiance(value)
        assert isinstance(flat, Spectrum)
        np.testing.assert_allclose(flat(AT), 2.0)


def test_a_black_body(radiance):
    """Planck's law, W·m⁻²·sr⁻¹·nm⁻¹; its integral over all wavelengths is σ T⁴ / π."""
    curve = radiance(
        '<spectrum type="blackbody" @><float name="temperature" value="9000"/></spectrum>'
    )
    grid = np.linspace(300.0, 1000.0, 7001)
    c2 = 1.438777e7 / 9000.0  # nm
    x = c2 / np.array([300.0, 1000.0])

    def above(x):  # of the integral of x³ / (eˣ - 1) from x to infinity
        n = np.arange(1, 60)
        return (np.exp(-n * x) * (x**3 / n + 3 * x**2 / n**2 + 6 * x / n**3 + 6 / n**4)).sum()

    part = (above(x[1]) - above(x[0])) * 15.0 / np.pi**4
    total = 5.670374e-8 * 9000.0**4 / np.pi
    assert np.trapezoid(curve(grid), grid) == pytest.approx(part * total, rel=1e-4)


TEXTURE = '<texture @ type="bitmap"><string name="filename" value="a.png"/>{}</texture>'


def texel_at(texture, u, v):
    """Return linear RGB at u and v, which count as Mitsuba's do: v downwards."""
    place = np.array(texture.scale) * [u, 1.0 - v] + np.array(texture.offset)
    height, width = texture.image.texels.shape[:2]
    column, row = int(place[0] % 1.0 * width), int((1.0 - place[1] % 1.0) * height)
    return texture.image.linear(row % height, column).tolist()


def test_bitmaps(reflectance, png):
    """Its upper left texel lies at u and v of 0."""
    texture = reflectance(TEXTURE.format(""), files={"a.png": png})
    assert isinstance(texture, Texture)
    assert texel_at(texture, 0.1, 0.1) == [1.0, 0.0, 1.0]
    assert texel_at(texture, 0.1, 0.9) == texel_at(texture, 0.9, 0.1) == [0.0, 0.0, 0.0]
    assert not texture.clamp
    clamped = TEXTURE.format('<string name="wrap_mode" value="clamp"/>')
    assert reflectance(clamped, files={"a.png": png}).clamp is True
    both = '<string name="wrap_mode_v" value="clamp"/><string name="wrap_mode" value="mirror"/>'
    filtered = '<string name="filter_type" value="nearest"/>'
    texture = reflectance(TEXTURE.format(both + filtered), files={"a.png": png})
    assert (texture.clamp, texture.nearest) == ((False, True), True)
    assert texture.image.texels.shape[:2] == (2, 8)


@pytest.mark.parametrize(
    "placed",
    [
        '<transform name="to_uv"><scale x="2" y="4"/><translate x=".5" y="-.25"/></transform>',
        """<float name="uscale" value="2"/><float name="vscale" value="4"/>
<float name="uoffset" value=".25"/><float name="voffset" value="-.0625"/>""",
    ],
)
def test_placed_bitmaps(reflectance, png, placed):
    """The upper left texel begins where 2 u + 0.5 and 4 v - 0.25 are whole."""
    texture = reflectance(TEXTURE.format(placed), files={"a.png": png})
    for u, v, inside in (
        (0.26, 0.07, True),
        (0.24, 0.07, False),
        (0.26, 0.06, False),
        (0.37, 0.18, True),
        (0.38, 0.18, False),
        (0.37, 0.19, False),
    ):
        assert (texel_at(texture, u, v) == [1.0, 0.0, 1.0]) == inside


def test_raw_bitmaps_are_linear(reflectance, png):
    raw = TEXTURE.format('<boolean name="raw" value="true"/>')
    assert not reflectance(raw, files={"a.png": png}).image.srgb
    assert reflectance(TEXTURE.format(""), files={"a.png": png}).image.srgb


def test_what_is_not_simulated_of_bitmaps(reflectance, png):
    more = """<string name="wrap_mode" value="zero"/>
<transform name="to_uv"><rotate z="1" angle="30"/></transform>"""
    message = r"wrap mode 'zero' of .*; rotation of textures of"
    with pytest.warns(SceneWarning, match=message):
        reflectance(TEXTURE.format(more), files={"a.png": png})


def test_missing_bitmaps(reflectance):
    with pytest.raises(InputError, match=r"scene.xml:1: file 'a.png' does not exist"):
        reflectance(TEXTURE.format(""))
    with pytest.warns(SceneWarning, match=r"unreadable textures, with grey in .* of 'a.png'"):
        assert reflectance(TEXTURE.format(""), missing_textures="grey") == 0.5


def test_checkerboards(reflectance):
    texture = reflectance(
        '<texture @ type="checkerboard"><rgb name="color0" value="1 0 0"/></texture>'
    )
    for u, v, first in ((0.2, 0.2, True), (0.7, 0.2, False), (0.2, 0.7, False), (0.7, 0.7, True)):
        expected = [1.0, 0.0, 0.0] if first else [0.2, 0.2, 0.2]
        np.testing.assert_allclose(texel_at(texture, u, v), expected)
    np.testing.assert_allclose(texture.mean, [0.6, 0.1, 0.1])


def test_textures_where_only_colours_are_simulated(radiance, png):
    with pytest.warns(SceneWarning, match="texture of radiance"):
        mean = radiance(TEXTURE.format(""), files={"a.png": png})
    assert mean == (0.125, 0.0, 0.125)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ('<rgb @ value="1 2"/>', "value '1 2' is not one number or three"),
        ('<srgb @ value="#12"/>', "'#12' is not a colour; write six digits"),
        ('<rgb @ value="#bc00ff"/>', "'#bc00ff' is no <rgb>.*; if it is sRGB, write 0.5029 0 1$"),
        ('<rgb @ value="-1"/>', "radiance is -1; keep it at least 0"),
        ('<spectrum @ value="1 2"/>', "'1 2' is not a spectrum"),
        ('<spectrum @ value="500:1 400:2"/>', "wavelengths must increase"),
        ('<spectrum @ value="500:1 600"/>', "one value for each"),
        ('<spectrum @ filename="none.spd"/>', "file 'none.spd' does not exist"),
        ('<spectrum @ type="d66"/>', "of type 'd66' is not simulated; give one of 'd65'"),
        ('<spectrum @ type="irregular"/>', "lacks wavelengths"),
        ('<spectrum @ type="regular"><string name="values" value="1"/></spectrum>', "2 samples"),
        (
            '<spectrum @ type="blackbody"><float name="temperature" value="0"/></spectrum>',
            "a black body has 0 K",
        ),
        ('<texture @ type="noise"/>', "a texture of type 'noise' is not simulated; .* 'bitmap'"),
    ],
)
def test_values_that_are_not_valid(radiance, value, message):
    with pytest.raises(InputError, match=f"scene.xml:1: .*{message}"):
        radiance(value)
