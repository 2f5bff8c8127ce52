"""Metals by their complex index: reflectances at all angles, rough and nearly smooth, and files."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.passes import pass_means
from helpers.scenes import ball_room, quad
from test_microsurface import METAL, at, evaluate, scatter

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.errors import InputError
from photonmap.kernels.core.metals import DIP_MEANS, DIP_POWERS
from photonmap.kernels.core.records import MIRROR
from photonmap.scene.surfaces.conductors import fit_dip
from photonmap.scene.surfaces.fresnel import SCHLICK_MEAN
from photonmap.spectra.bands import Bands
from photonmap.spectra.metals import EDGE_COSINE, SHIPPED, conductor_reflectance, metal
from photonmap.spectra.tables import read_table

RGB = Bands.rgb()
COSINES = np.linspace(0.0, 1.0, 1001)[1:]
TABLE = read_table(SHIPPED)
SYMBOLS = [name.split()[0] for name in TABLE.names[::2]]


def born_wolf(n, k, cosine):
    """Return the reflectance by real arithmetic alone: Born and Wolf, 14.2, with 1.5.2."""
    sine2 = 1.0 - cosine**2
    difference = n**2 - k**2 - sine2
    root = np.sqrt(difference**2 + 4.0 * n**2 * k**2)
    a, b2 = np.sqrt(0.5 * (root + difference)), 0.5 * (root - difference)
    across = ((a - cosine) ** 2 + b2) / ((a + cosine) ** 2 + b2)
    tangent = np.sqrt(sine2) * np.sqrt(sine2) / cosine
    along = across * ((a - tangent) ** 2 + b2) / ((a + tangent) ** 2 + b2)
    return 0.5 * (across + along)


def approximate(f0, edge, cosines=COSINES):
    """Return what kernels take for the reflectance at each angle."""
    beyond = 1.0 - cosines
    terms = [cosines * beyond**power for power in DIP_POWERS]
    return f0 + (1.0 - f0) * beyond**5 - np.tensordot(fit_dip(f0, edge), terms, (0, 0))


def mean_over_angles(values):
    return np.trapezoid(2.0 * COSINES * values, COSINES)


@pytest.mark.parametrize("cosine", [1.0, 0.6, EDGE_COSINE, 0.01])
def test_fresnels_equations(cosine):
    for n, k in [(0.14, 3.697), (1.02, 2.577), (3.18, 3.33), (1.5, 0.0)]:
        found = conductor_reflectance(np.array([n]), np.array([k]), cosine)
        assert found == pytest.approx([born_wolf(n, k, cosine)], rel=1e-12)


def test_what_has_the_index_of_air_reflects_nothing():
    assert conductor_reflectance(np.array([1.0]), np.array([0.0])) == [0.0]


@pytest.mark.parametrize("symbol", SYMBOLS)
def test_metals_reflect_by_their_table_at_every_angle(symbol):
    """Within 0.005 at any angle, and 0.03% of all light; by Schlick's formula 0.2 and 3.2%."""
    n, k = (row.values for row in (TABLE[f"{symbol} n"], TABLE[f"{symbol} k"]))
    found = metal(symbol)
    assert found.edge is not None
    np.testing.assert_allclose(found.edge.values, born_wolf(n, k, EDGE_COSINE), rtol=1e-12)
    for column in range(0, len(n), 4):
        exact = born_wolf(n[column], k[column], COSINES)
        ours = approximate(found.values[column], found.edge.values[column])
        assert np.abs(ours - exact).max() < 0.005
        assert abs(mean_over_angles(ours - exact)) < 0.0003


def test_reflectances_stay_between_0_and_1():
    f0, edge = (values.ravel() for values in np.mgrid[0:1:7j, 0:1:7j])
    found = np.array([approximate(*pair) for pair in zip(f0, edge, strict=True)])
    assert found.min() > -1e-5
    assert found.max() < 1.0 + 1e-5
    moderate = (f0 >= 0.4) & (edge > f0 - 0.2) & (edge < f0 + 0.4 * (1.0 - f0))
    at_edge = np.array([approximate(*pair, EDGE_COSINE) for pair in zip(f0, edge, strict=True)])
    np.testing.assert_allclose(at_edge[moderate], edge[moderate], atol=1e-12)


def test_means_of_the_terms():
    beyond = 1.0 - COSINES
    assert mean_over_angles(beyond**5) == pytest.approx(SCHLICK_MEAN, abs=1e-5)
    for power, mean in zip(DIP_POWERS, DIP_MEANS, strict=True):
        assert mean_over_angles(COSINES * beyond**power) == pytest.approx(mean, abs=1e-5)


@pytest.mark.parametrize("cosine", [0.8, 0.3, 0.1])
def test_walks_lose_what_the_metal_absorbs(cosine):
    """On nearly smooth chromium F, and nothing else; the densities of directions add up to it."""
    f0, edge = np.array([0.56, 0.7, 0.9], np.float32), np.array([0.55, 0.6, 0.8], np.float32)
    dip = fit_dip(f0, edge)[None].astype(np.float32)
    expected = [approximate(*pair, cosine) for pair in zip(f0, edge, strict=True)]
    wo, weights = scatter(1e-3, METAL, at(cosine), 20_000, f0, dip)
    np.testing.assert_allclose(weights.mean(axis=0), expected, atol=2e-3)
    walked = scatter(0.3, METAL, at(cosine), 100_000, f0, dip)[1]
    z, phi = np.random.default_rng(3).random((2, 100_000)) * [[1.0], [2.0 * np.pi]]
    r = np.sqrt(1.0 - z * z)
    wo = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)
    values = 2.0 * np.pi * evaluate(0.3, METAL, at(cosine), wo, f0, dip)
    error = np.hypot(values.std(axis=0), walked.std(axis=0)) / np.sqrt(len(wo))
    assert (np.abs(values.mean(axis=0) - walked.mean(axis=0)) < 5.0 * error).all()


def plate(symbol, roughness, degrees):
    """Return a plate of metal below an even sky, seen from an angle to its normal."""
    look = pm.Material.metal("plate", pm.reflectance(f"metal:{symbol}"), roughness)
    corners = (-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)
    angle = np.radians(degrees)
    camera = pm.Camera(
        (0.0, 20.0 * np.cos(angle), 20.0 * np.sin(angle)), (0, 0, 0), (0.0, 1.0, -1.0), 0.05
    )
    return pm.Scene([quad(*corners, look, "plate")], [pm.DomeLight(1.0)], camera)


@pytest.mark.parametrize(("symbol", "degrees"), [("Cr", 0), ("Cr", 60), ("Cr", 82), ("Al", 82)])
def test_polished_metals_under_a_sky(symbol, degrees):
    """Radiance is Fresnel's reflectance, to 0.002; at 82° Schlick's is 0.19 and 0.09 above."""
    scene = plate(symbol, 0.0, degrees)
    result = pm.render(scene, bands="box:3", size=(4, 4), passes=8, threads=2)
    n, k = (TABLE[f"{symbol} {part}"] for part in "nk")
    for band, middle in enumerate((450.0, 550.0, 650.0)):
        nm = np.linspace(middle - 50.0, middle + 50.0, 21)
        expected = born_wolf(n(nm), k(nm), np.cos(np.radians(degrees))).mean()
        assert abs(result.radiance[..., band].mean() - expected) < 0.002


@pytest.mark.parametrize("degrees", [0, 60, 82])
def test_polished_metals_are_mirrors(degrees):
    """By name as `mirror`, and as `glossy` of roughness 0: by the formula at every angle."""
    scene = plate("Cr", 0.0, degrees)
    look = pm.Material("plate", 0.0, mirror=pm.reflectance("metal:Cr"))
    cosine = np.cos(np.radians(degrees))
    f0, edge = (RGB.reflectance(color) for color in (metal("Cr"), metal("Cr").edge))
    for each in (scene, _with(scene, look)):
        compiled = compile_scene(each, RGB)
        assert compiled.specular.kind.tolist() == [MIRROR]
        assert len(compiled.specular.alpha) == 0
        assert compiled.scattering is None
        names = ("radiance", "roughness", "specular_reflectance")
        result = pm.render(each, bands="rgb", size=(2, 2), passes=2, threads=2, buffers=names)
        found = result.radiance.mean(axis=(0, 1))
        np.testing.assert_allclose(found, approximate(f0, edge, cosine), rtol=1e-3)
        assert (result["roughness"] == 0.0).all()
        np.testing.assert_allclose(result["specular_reflectance"][0, 0], f0, rtol=1e-6)


def test_other_mirrors_reflect_alike_at_all_angles():
    scene = plate("Cr", 0.0, 60)
    chromium = pm.reflectance("metal:Cr")
    for look in (
        pm.Material("plate", 0.0, mirror=0.5),
        pm.Material("plate", 0.2, mirror=chromium),
        pm.Material("plate", 0.0, glossy=chromium, roughness=0.1),
    ):
        assert compile_scene(_with(scene, look), RGB).specular.grazing.size == 0


def test_light_groups_keep_polished_metal():
    scene = plate("Cr", 0.0, 60)
    settings = {"bands": "rgb", "size": (2, 2), "passes": 1, "threads": 2}
    whole = pm.render(scene, **settings)
    lamp = pm.PointLight((0.0, 1.0, 0.0), 1.0, "lamp")
    split = pm.render(replace(scene, lights=[*scene.lights, lamp]), per_light=True, **settings)
    assert len(split.per_light) == 2
    np.testing.assert_allclose(split.radiance, whole.radiance, rtol=1e-5)


def test_rough_metals_go_over_into_polished_ones():
    """At α 0.09, where walks follow it, and just above, where its lobe is sampled."""
    means = []
    for roughness in (0.31, 0.32):
        scene = plate("Cr", roughness, 70)
        result = pm.render(scene, bands="rgb", size=(8, 8), passes=32, threads=2)
        means.append(result.radiance.mean(axis=(0, 1), dtype=float))
    np.testing.assert_allclose(*means, rtol=0.01)


def test_narrow_metals_go_over_into_mirrors():
    """At the least α, 0.001, which all roughness up to 0.0316 has."""
    mirrors, narrow, least = (
        ball_room(pm.Material.metal(glossy=(0.9, 0.8, 0.5), roughness=roughness))
        for roughness in (0.0, 0.03, 0.001)
    )
    settings = {"bands": "rgb", "size": (8, 8), "passes": 1, "threads": 2}
    results = [pm.render(room, **settings) for room in (mirrors, narrow, least)]
    assert [each.record["effects"]["glossy"]["on"] for each in results] == [False, True, True]
    np.testing.assert_array_equal(results[1].radiance, results[2].radiance)
    one, other = (pass_means(room, "photon", 24).sum(axis=1) for room in (mirrors, narrow))
    apart, value = (one - other).mean(axis=(1, 2, 3)), other.mean()
    error = apart.std(ddof=1) / np.sqrt(len(apart))  # of pairs, which share random numbers
    assert error < 0.002 * value
    assert abs(apart.mean()) < 4.0 * error + 1e-4 * value
    assert np.abs((one - other).mean(axis=0)).max() < 0.005 * value


def test_a_textured_or_painted_metal_stays_glossy():
    for reflectance in (0.1, pm.Texture.of(np.full((1, 1), 0.4))):
        painted = pm.Material("paint", reflectance, glossy=0.5, roughness=0.1)
        assert not painted.is_narrow_metal
    assert pm.Material.metal(roughness=0.31).is_narrow_metal
    assert not pm.Material.metal(roughness=0.32).is_narrow_metal


def test_only_metals_with_an_edge_have_dips():
    plain = compile_scene(plate("Cr", 0.5, 0), RGB)
    assert plain.specular is None
    assert plain.scattering.dip.shape == (1, 4, 3)
    narrow = compile_scene(plate("Cr", 0.1, 0), RGB)
    assert narrow.scattering is None
    assert narrow.specular.dip.shape == (1, 4, 3)
    assert narrow.specular.dip.any()
    scene = plate("Cr", 0.5, 0)
    look = replace(scene.meshes[0].material, glossy=0.5)
    assert compile_scene(scene.with_materials({"plate": look}), RGB).scattering.dip.size == 0


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_polished_metals(suffix, tmp_path):
    scene = plate("Cr", 0.0, 0)
    mirror = _with(scene, pm.Material("plate", 0.0, mirror=pm.reflectance("metal:Cr")))
    for each in (scene, mirror):
        pm.save_scene(each, tmp_path / f"plate{suffix}")
        read = pm.load_scene(tmp_path / f"plate{suffix}").meshes[0].material
        own, other = (compile_scene(one, RGB).specular for one in (each, _with(scene, read)))
        for name in ("kind", "mirror", "grazing", "dip"):
            np.testing.assert_array_equal(getattr(own, name), getattr(other, name))


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_what_metals_reflect(suffix, tmp_path):
    scene = plate("Cr", 0.4, 0)
    pm.save_scene(scene, tmp_path / f"plate{suffix}")
    read = pm.load_scene(tmp_path / f"plate{suffix}").meshes[0].material
    own, other = (compile_scene(each, RGB).scattering for each in (scene, _with(scene, read)))
    np.testing.assert_array_equal(own.dip, other.dip)
    np.testing.assert_array_equal(own.specular, other.specular)


def _with(scene, material):
    return scene.with_materials({"plate": material})


def test_another_metal_in_toml_has_its_own_edge(tmp_path):
    pm.save_scene(plate("Cr", 0.4, 0), tmp_path / "plate.obj")
    words = 'mesh = "plate.obj"\n[material.plate]\nglossy = {}\n'
    for glossy, edge in [('"metal:Al 0.5"', 0.5 * metal("Al").edge), ("0.7", None)]:
        (tmp_path / "other.toml").write_text(words.format(glossy))
        assert pm.load_scene(tmp_path / "other.toml").meshes[0].material.edge == edge
    more = "glossy_edge = [0.5, 0.6, 0.7]\n"
    (tmp_path / "other.toml").write_text(words.format("0.7") + more)
    look = pm.load_scene(tmp_path / "other.toml").meshes[0].material
    found = compile_scene(_with(plate("Cr", 0.4, 0), look), RGB).scattering.dip[0]
    expected = fit_dip(np.full(3, 0.7), np.array([0.5, 0.6, 0.7]))
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"glossy_edge": 1.5}, "glossy_edge is 1.5 in band R; it must lie between 0 and 1"),
        (
            {"glossy": pm.Texture.of(np.full((2, 2, 3), 0.5, np.float32)), "glossy_edge": 0.5},
            "has a glossy_edge; give it one glossy, not a texture",
        ),
    ],
)
def test_bad_edges(values, message):
    scene = plate("Cr", 0.4, 0)
    look = replace(scene.meshes[0].material, **values)
    scene = replace(scene, meshes=[replace(scene.meshes[0], uv=scene.meshes[0].vertices[:, ::2])])
    with pytest.raises(InputError, match=message):
        compile_scene(_with(scene, look), RGB)
