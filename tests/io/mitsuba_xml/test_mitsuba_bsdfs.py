"""BSDFs of Mitsuba as materials."""

import math

import numpy as np
import pytest

import photonmap as pm
from photonmap.compile.surfaces.glossy import lobe_albedos, mean_albedo
from photonmap.compile.surfaces.sheens import sheen_lobe
from photonmap.errors import InputError, SceneWarning
from photonmap.io.readers.mitsuba.albedos import base_albedo, coat_albedo, plastic_albedo
from photonmap.kernels.core.metals import DIP_MEANS
from photonmap.scene.surfaces.conductors import fit_dip
from photonmap.scene.surfaces.fresnel import mean_rise, normal_reflectance
from photonmap.scene.textures import Texture
from photonmap.spectra.curves import Spectrum

RED = '<rgb name="{}" value=".8 .2 .1"/>'
SMOOTH = '<float name="alpha" value="1e-4"/>'
GGX = '<string name="distribution" value="ggx"/>'


def test_diffuse(look):
    material = look("diffuse", RED.format("reflectance"))
    assert (material.name, material.reflectance) == ("paint", (0.8, 0.2, 0.1))
    assert look("diffuse").reflectance == 0.5


def test_wrappers_show_what_they_contain(look):
    inner = f'<bsdf type="diffuse">{RED.format("reflectance")}</bsdf>'
    for kind in ("twosided", "mask"):
        assert look(kind, inner).reflectance == (0.8, 0.2, 0.1)
    with pytest.raises(InputError, match="a bumpmap has 0 textures in it; give it one"):
        look("bumpmap", inner + '<float name="scale" value="2"/>')
    with pytest.warns(SceneWarning, match="another back side"):
        assert look("twosided", inner + '<bsdf type="conductor"/>').reflectance[0] == 0.8


def test_relief(look):
    """A checkerboard as heights, times `scale`, and as directions."""
    inner = f'<bsdf type="diffuse">{RED.format("reflectance")}</bsdf>'
    checks = '<texture name="{}" type="checkerboard"/>'
    scale = '<float name="scale" value="2"/>'
    bumped = look("bumpmap", inner + scale + checks.format("any"))
    assert bumped.reflectance[0] == 0.8
    assert (type(bumped.relief), bumped.relief.height) == (pm.BumpMap, 2.0)
    turned = look("normalmap", inner + checks.format("normalmap")).relief
    assert (type(turned), turned.strength) == (pm.NormalMap, 1.0)


def test_mirrors(look):
    material = look("conductor", RED.format("specular_reflectance"))
    assert (material.reflectance, material.mirror) == (0.0, (0.8, 0.2, 0.1))
    assert look("conductor").mirror == 1.0
    gold = look("conductor", '<string name="material" value="Au"/>')
    assert gold.is_polished_metal
    assert (gold.glossy, gold.edge) == (pm.reflectance("metal:Au"), pm.reflectance("metal:Au").edge)


def test_metals_reflect_by_their_index(look):
    index = '<rgb name="eta" value="2 1 .2"/><rgb name="k" value="0 1 3"/>'
    material = look("roughconductor", index + GGX + '<float name="alpha" value="1e-4"/>')
    expected = [1.0 / 9.0, 1.0 / 5.0, (0.64 + 9.0) / (1.44 + 9.0)]
    np.testing.assert_allclose(material.glossy, expected, atol=2e-4)
    assert material.roughness == pytest.approx(0.01)


@pytest.mark.parametrize("alpha", [0.05, 0.3, 0.7])
def test_rough_metals_reflect_as_much_as_what_is_scattered_once(look, alpha):
    """Mitsuba loses the rest; its facets mask each other in both directions independently."""
    material = look(
        "roughconductor",
        f'<float name="alpha" value="{alpha}"/>{RED.format("specular_reflectance")}',
    )
    assert material.roughness == pytest.approx(math.sqrt(alpha))
    rng = np.random.default_rng(5)
    first, second, third = rng.random((3, 400_000))
    cosine = np.sqrt(first)  # light from all around
    height = 1.0 / np.sqrt(1.0 + alpha**2 * second / (1.0 - second))  # of GGX's normals
    azimuth = 2.0 * np.pi * third
    across = np.sqrt((1.0 - cosine**2) * (1.0 - height**2))
    towards = across * np.cos(azimuth) + cosine * height
    out = 2.0 * towards * height - cosine
    smith = [
        2.0 / (1.0 + np.sqrt(1.0 + alpha**2 * (1.0 / np.maximum(each, 1e-9) ** 2 - 1.0)))
        for each in (cosine, out)
    ]
    weight = smith[0] * smith[1] * towards / (cosine * height)
    reflected = np.where((towards > 0.0) & (out > 0.0), weight, 0.0)
    wanted = np.mean(reflected) * np.array([0.8, 0.2, 0.1])
    error = 4.0 * np.std(reflected) / math.sqrt(len(reflected))
    colors = np.array(material.glossy), np.array(material.glossy_edge)
    dip = fit_dip(*colors)[None]
    lobe = np.append(lobe_albedos(alpha)[None, :, -1], [[mean_rise(0.0)]], axis=1)
    ours = mean_albedo(colors[0][None], lobe, dip)[0]
    np.testing.assert_allclose(ours, wanted, atol=error)
    assert error < 0.01


def test_metals_by_name(look):
    """Gold absorbs blue, and aluminium hardly anything."""
    gold, tinted = (
        look("roughconductor", f'<string name="material" value="Au"/>{SMOOTH}{more}')
        for more in ("", '<float name="specular_reflectance" value=".5"/>')
    )
    assert isinstance(gold.glossy, Spectrum)
    np.testing.assert_allclose(gold.glossy(np.array([450.0, 700.0])), [0.39, 0.97], atol=0.02)
    colors = [(each.glossy(700.0), each.glossy_edge(700.0)) for each in (gold, tinted)]
    means = [f0 * 20.0 / 21.0 + 1.0 / 21.0 - fit_dip(f0, edge) @ DIP_MEANS for f0, edge in colors]
    assert means[1] == pytest.approx(0.5 * means[0], rel=1e-3)
    white = look("roughconductor", '<string name="material" value="Al"/>' + SMOOTH).glossy
    np.testing.assert_allclose(white(np.array([450.0, 650.0])), 0.91, atol=0.02)


def test_other_distributions(look):
    name = '<string name="distribution" value="beckmann"/>'
    with pytest.warns(SceneWarning, match="Beckmann's distribution, with GGX in its place"):
        look("roughconductor", name)


def alphas_of(material):
    """Return GGX's α across the tangent and along it."""
    across = material.roughness**2
    return across, across + (1.0 - across) * material.anisotropy**2


@pytest.mark.parametrize("index", [1.1, 1.5, 2.4])
def test_paint_below_a_coat_by_its_bare_albedo(index):
    bare = np.array([0.0, 0.2, 0.5, 0.95, 1.0])
    base = plastic_albedo(index, 0.0, True, normal_reflectance(index))(bare)
    expected = bare / (index**2 * (1.0 - bare) + bare)  # as the guide says
    np.testing.assert_allclose(base, expected, rtol=1e-6)


def test_specular_reflectance_of_plastic(look):
    """The highlight is so much of Fresnel's, and the base returns as much light below any."""
    inside = '<float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/>'
    bare, thin, whole = (
        look("plastic", f'{inside}<float name="specular_reflectance" value="{part}"/>')
        for part in (0, 0.3, 1)
    )
    assert (bare.glossy, bare.coat, thin.coat, thin.coat_ior) == (0.0, 0.0, 0.3, 1.5)
    assert (whole.glossy, whole.coat) == (pytest.approx(0.04), 0.0)
    reflected = coat_albedo(0.04, 0.0)
    returned = [
        (1.0 - reflected) ** 2 * base / (1.0 - reflected * base)
        for base in (thin.reflectance, whole.reflectance)
    ]
    assert bare.reflectance == pytest.approx(returned[1])
    assert 0.3 * returned[0] + 0.7 * thin.reflectance == pytest.approx(returned[1])
    with pytest.warns(SceneWarning, match="colour of specular_reflectance at grazing angles"):
        tinted = look("plastic", inside + RED.format("specular_reflectance"))
    np.testing.assert_allclose(tinted.glossy, [0.032, 0.008, 0.004])


@pytest.mark.parametrize("kind", ["roughconductor", "roughdielectric"])
def test_anisotropic_metals_and_glass(look, kind):
    alphas = '<float name="alpha_u" value=".1"/><float name="alpha_v" value=".4"/>'
    material = look(kind, f"{GGX}{alphas}")
    assert material.is_anisotropic
    assert alphas_of(material) == pytest.approx((0.1, 0.4))
    assert material.anisotropy_rotation == 0.25  # wider along v
    wide = alphas.replace(".4", "1.6")
    with pytest.warns(SceneWarning, match="anisotropy with an alpha above 1 of 'paint'"):
        material = look(kind, f"{GGX}{wide}")
    assert (material.anisotropy, material.roughness) == (0.0, pytest.approx(0.16**0.25))


@pytest.mark.parametrize("kind", ["metallic", "spec_trans"])
def test_anisotropic_principled(look, kind):
    stretch = '<float name="anisotropic" value="0.5"/>'
    material = look("principled", f'<float name="{kind}" value="1"/>{stretch}')
    aspect = math.sqrt(0.55)
    assert alphas_of(material) == pytest.approx((0.25 * aspect, 0.25 / aspect))
    assert material.anisotropy_rotation == 0.0
    assert (material.ior is None) == (kind == "metallic")
    rough = '<texture name="roughness" type="checkerboard"><rgb name="color0" value="0.3"/>'
    rough += '<rgb name="color1" value="0.7"/></texture>'
    with pytest.warns(SceneWarning, match="texture of roughness beside anisotropic of 'paint'"):
        varied = look("principled", f'<float name="{kind}" value="1"/>{stretch}{rough}')
    assert alphas_of(varied) == pytest.approx(alphas_of(material), rel=1e-3)


@pytest.mark.parametrize(
    ("inside", "index"),
    [
        ("", 1.5046 / 1.000277),
        ('<float name="int_ior" value="1.6"/><float name="ext_ior" value="1.2"/>', 1.6),
        ('<string name="int_ior" value="Diamond"/><float name="ext_ior" value="1"/>', 2.419),
    ],
)
def test_glass(look, inside, index):
    material = look("dielectric", inside + '<float name="specular_transmittance" value=".9"/>')
    assert material.ior == pytest.approx(index)
    assert (material.reflectance, material.tint) == (0.0, 0.9)


def test_rough_glass(look):
    ggx = '<string name="distribution" value="ggx"/>'
    material = look("roughdielectric", ggx + '<float name="alpha" value=".25"/>')
    assert material.ior > 1.5
    assert material.roughness == pytest.approx(0.5)


def test_a_pane_is_thin_glass(look):
    indices = '<float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/>'
    material = look("thindielectric", indices)
    assert (material.thin, material.ior, material.tint, material.mirror) == (True, 1.5, 1.0, 0.0)


OUTSIDE = 0.04 + 0.96 * mean_rise(1.5)
"""What smooth plastic of index 1.5 reflects of light from all around."""


def light_out(albedo, outside):
    """Return what a base below a coat of an albedo reflects of the light from all around."""
    return albedo * (1.0 - outside) ** 2 / (1.0 - albedo * outside)


def test_a_base_below_a_coat_reflects_as_much_as_was_asked_for():
    for reflected in (0.0, 0.3, 0.6):
        assert light_out(base_albedo(reflected, 0.08), 0.08) == pytest.approx(reflected)
    assert base_albedo(0.99, 0.08) == 1.0


@pytest.mark.parametrize("alpha", [1e-3, 0.1, 0.5, 1.0])
def test_coats_reflect_as_much_as_they_are_rendered_to(alpha):
    row = lobe_albedos(alpha, 1.5)[None, :, -1]
    rendered = mean_albedo(np.array([[0.04]]), np.append(row, [[mean_rise(1.5)]], axis=1))
    assert coat_albedo(0.04, alpha) == pytest.approx(float(rendered[0, 0]), abs=5e-4)


def test_smooth_coats_reflect_by_fresnels_equations():
    assert coat_albedo(0.04, 0.0) == pytest.approx(OUTSIDE)


@pytest.mark.parametrize("nonlinear", [False, True])
def test_plastic(look, nonlinear):
    """Of the light that passes the coat, ρ / (1 - F) passes it again, or ρ / (1 - F ρ)."""
    more = f'<boolean name="nonlinear" value="{str(nonlinear).lower()}"/>'
    indices = '<float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/>'
    material = look("plastic", RED.format("diffuse_reflectance") + indices + more)
    assert material.glossy == pytest.approx(0.04)
    assert material.roughness == 0.0
    inside = 1.0 - (1.0 - OUTSIDE) / 1.5**2
    rho = np.array([0.8, 0.2, 0.1])
    expected = (1.0 - OUTSIDE) ** 2 / 1.5**2 * rho / (1.0 - inside * (rho if nonlinear else 1.0))
    np.testing.assert_allclose(light_out(np.array(material.reflectance), OUTSIDE), expected)


def test_white_plastic_is_white(look):
    assert look("plastic", '<float name="diffuse_reflectance" value="1"/>').reflectance == (
        pytest.approx(1.0)
    )


def test_hardly_rough_plastic_is_like_smooth_plastic():
    """The quadrature over facets is off by 0.003 where total reflection begins."""
    smooth, rough = (plastic_albedo(1.49, alpha, False, 0.0387)(0.5) for alpha in (0.0, 1e-3))
    assert rough == pytest.approx(smooth, abs=0.005)
    assert plastic_albedo(1.49, 0.4, False, 0.0387)(0.5) < 0.8 * smooth


def test_rough_plastic(look):
    material = look("roughplastic", '<float name="alpha" value=".09"/>')
    assert material.roughness == pytest.approx(0.3)
    assert 0.3 < material.reflectance < 0.5


def test_textures_below_a_coat(look, png):
    texture = (
        '<texture name="diffuse_reflectance" type="bitmap">'
        '<string name="filename" value="a.png"/></texture>'
    )
    material = look("plastic", texture, files={"a.png": png})
    plain = look("plastic", '<rgb name="diffuse_reflectance" value="1 0 1"/>')
    assert isinstance(material.reflectance, Texture)
    np.testing.assert_allclose(
        material.reflectance.image.texels[0, 0], plain.reflectance, atol=1e-6
    )


def test_principled(look):
    color = RED.format("base_color")
    half = look("principled", color + '<float name="metallic" value=".5"/>')
    np.testing.assert_allclose(half.glossy, 0.5 * np.array([0.8, 0.2, 0.1]) + 0.02)
    assert half.roughness == 0.5
    metal = look("principled", color + '<float name="metallic" value="1"/>')
    assert (metal.reflectance, metal.glossy) == ((0.0, 0.0, 0.0), (0.8, 0.2, 0.1))
    plain = look("principled", color)
    leaving = light_out(np.array(plain.reflectance), coat_albedo(0.04, 0.25))
    np.testing.assert_allclose(leaving, [0.8, 0.2, 0.1], rtol=1e-3)
    coated = look(
        "principled",
        color + '<float name="clearcoat" value=".8"/><float name="clearcoat_gloss" value="1"/>',
    )
    assert (coated.coat, coated.coat_roughness) == pytest.approx((0.2, math.sqrt(0.001)))
    clear = look(
        "principled",
        color + '<float name="spec_trans" value="1"/><float name="roughness" value="0.3"/>'
        '<float name="eta" value="1.4"/>',
    )
    assert clear.ior == pytest.approx(1.4)
    assert clear.roughness == 0.3
    np.testing.assert_allclose(clear.tint, np.sqrt([0.8, 0.2, 0.1]))
    clear = '<float name="spec_trans" value="1"/><float name="clearcoat" value="{}"/>'
    look("principled", clear.format(0))
    with pytest.warns(SceneWarning, match="not simulated: clearcoat of 'paint'$"):
        look("principled", clear.format(1))


def test_parameters_that_are_not_simulated_are_named(look):
    with pytest.warns(SceneWarning, match="not simulated: bsdf parameter gloss of 'paint'$"):
        look("diffuse", '<float name="gloss" value=".3"/>')


SHEEN = '<float name="sheen" value="{}"/><float name="sheen_tint" value="{}"/>'


def test_sheen_is_charlie_s_that_reflects_as_much(look):
    assert not look("principled", SHEEN.format(0, 0.5)).has_sheen
    plain = look("principled", SHEEN.format(0.5, 0))
    np.testing.assert_allclose(plain.sheen, 0.055)
    red = look("principled", RED.format("base_color") + SHEEN.format(0.5, 1))
    assert np.dot(red.sheen, [0.2126, 0.7152, 0.0722]) == pytest.approx(0.055, rel=1e-3)
    assert red.sheen[0] / red.sheen[1] == pytest.approx(4.0)
    metal = look("principled", SHEEN.format(0.5, 0) + '<float name="metallic" value="0.6"/>')
    np.testing.assert_allclose(metal.sheen, 0.022)
    nodes, weights = np.polynomial.legendre.leggauss(64)
    cosines, weights = 0.5 * (nodes + 1.0), weights * 0.25 * (nodes + 1.0)
    out, into, turn = np.ix_(cosines, cosines, np.pi * (np.arange(64) + 0.5) / 64)
    between = np.sqrt((1 - out**2) * (1 - into**2)) * np.cos(turn) + out * into
    lobe = ((1.0 - np.sqrt(0.5 * (1.0 + between))) ** 5).mean(axis=2)
    ours = sheen_lobe(plain.sheen_roughness**2).albedo[-1] * 0.11
    assert 4.0 * np.pi * (weights @ lobe @ weights) == pytest.approx(ours, rel=0.01)


@pytest.mark.parametrize("other", ["spec_trans", "clearcoat"])
def test_sheen_that_is_left_out_is_named(look, other):
    with pytest.warns(SceneWarning, match="not simulated: sheen .which .* of 'paint'$"):
        found = look("principled", SHEEN.format(0.3, 0) + f'<float name="{other}" value="0.4"/>')
    assert not found.has_sheen


def test_masks(look, png):
    inner = '<bsdf type="diffuse"/>'
    assert look("mask", '<float name="opacity" value=".3"/>' + inner).alpha == pytest.approx(0.3)
    texture = (
        '<texture name="opacity" type="bitmap"><string name="filename" value="a.png"/></texture>'
    )
    assert isinstance(look("mask", texture + inner, files={"a.png": png}).alpha, Texture)
    assert look("null").alpha == 0.0


def blend(one, other, weight=0.25):
    return f'<float name="weight" value="{weight}"/>{one}{other}'


RED_PAINT = f'<bsdf type="diffuse">{RED.format("reflectance")}</bsdf>'
MIRROR = '<bsdf type="conductor"/>'
HALF = '<bsdf type="plastic"><float name="specular_reflectance" value=".5"/></bsdf>'
ROUGH = HALF.replace('"plastic">', '"roughplastic">' + GGX)
GLOSSY = f'<bsdf type="roughconductor"><float name="alpha" value=".{{}}"/>{GGX}</bsdf>'
BRUSHED = GLOSSY.format("1").replace("/>", '/><float name="alpha_v" value=".4"/>', 1)


def test_blends(look):
    paint = look("blendbsdf", blend(RED_PAINT, '<bsdf type="diffuse"/>'))
    np.testing.assert_allclose(paint.reflectance, [0.725, 0.275, 0.2])
    coat = look("blendbsdf", blend(RED_PAINT, MIRROR))
    np.testing.assert_allclose(coat.reflectance, [0.6, 0.15, 0.075])
    assert coat.mirror == 0.25
    assert look("blendbsdf", blend(RED_PAINT, MIRROR, 1)).mirror == 1.0
    assert look("blendbsdf", blend(RED_PAINT, MIRROR, 0)).reflectance == (0.8, 0.2, 0.1)
    varnish = look("blendbsdf", blend(GLOSSY.format("09"), RED_PAINT))
    metal = look("roughconductor", '<float name="alpha" value=".09"/>')
    assert (varnish.glossy, varnish.roughness) == (0.75 * metal.glossy, pytest.approx(0.3))
    bottle = look("blendbsdf", blend(RED_PAINT, '<bsdf type="dielectric"/>'))
    assert (bottle.reflectance, bottle.transmission) == ((0.8, 0.2, 0.1), pytest.approx(0.25))
    varnish = look("blendbsdf", blend(RED_PAINT, HALF))
    assert (varnish.coat, varnish.coat_roughness) == (0.25 * 0.5, 0.0)
    holes = look("blendbsdf", blend(RED_PAINT, '<bsdf type="null"/>'))
    assert holes.alpha == pytest.approx(0.75)


@pytest.mark.parametrize(
    ("parts", "lost"),
    [
        ((MIRROR, '<bsdf type="dielectric"/>'), "lesser part of a blend with glass"),
        ((MIRROR, GLOSSY.format("1")), "blend of a mirror and a glossy surface"),
        ((MIRROR, HALF), "blend of a mirror and a glossy surface"),
        ((HALF, ROUGH), "two degrees of roughness of a coat"),
        ((GLOSSY.format("1"), GLOSSY.format("3")), "two degrees of roughness"),
        ((BRUSHED, GLOSSY.format("1")), "anisotropy of a blend"),
        ((BRUSHED, '<bsdf type="dielectric"/>'), "two degrees of anisotropy"),
    ],
)
def test_blends_that_are_not_simulated(look, parts, lost):
    with pytest.warns(SceneWarning, match=f"{lost} of 'paint'"):
        look("blendbsdf", blend(*parts))


@pytest.mark.parametrize(
    ("kind", "inside", "message"),
    [
        ("phong", "", "a bsdf of type 'phong' is not simulated"),
        ("diffuse", '<rgb name="reflectance" value="1 1 1.2"/>', "reflectance is 1.2; keep it"),
        ("diffuse", '<string name="reflectance" value="red"/>', "reflectance is a <string>"),
        ("conductor", '<string name="material" value="Gold"/>', "material 'Gold': there is no"),
        ("dielectric", '<string name="int_ior" value="watr"/>', "did you mean 'water'"),
        ("dielectric", '<float name="int_ior" value="0"/>', "int_ior 0 is not above 0"),
        ("roughplastic", '<float name="alpha" value="2"/>', "alpha 2.0 is not a roughness"),
        ("principled", '<float name="metallic" value="2"/>', r"metallic 2 is not within \[0, 1\]"),
        ("twosided", "", "a twosided has 0 bsdfs in it; give it one"),
        ("blendbsdf", RED_PAINT, "a blendbsdf has 1 bsdfs in it; give it 2 bsdfs"),
    ],
)
def test_values_that_are_not_valid(look, kind, inside, message):
    with pytest.raises(InputError, match=f"scene.xml:1: .*{message}"):
        look(kind, inside)
