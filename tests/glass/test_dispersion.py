"""Glass whose index depends on wavelength: Snell and Fresnel by band, and the path tracer."""

import numpy as np
import pytest
import trimesh

import photonmap as pm
from photonmap.compile.effects import EFFECTS
from photonmap.scene.surfaces.dispersion import (
    GLASSES,
    LINES,
    Cauchy,
    NamedGlass,
    Sellmeier,
    abbe_index,
    abbe_number,
)

BOX = pm.scenes.cornell_box()
FLINT = pm.Material("flint", 0.0, dispersion=NamedGlass("sf11"))
STRONG = pm.Material("strong", 0.0, ior=1.6, abbe=6.0)
APEX = np.radians(20.0)


def lamp(z, emission, low=-4.0, high=4.0):
    corners = np.array([[low, -1, z], [high, -1, z], [high, 1, z], [low, 1, z]])
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    material = pm.Material("lamp", 0.0, emission)
    return pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], material, "lamp", uv=uv)


def prism(material):
    """A wedge: its upper face is level, its lower one rises along x by APEX, through z = -2."""
    ends = [(x, z) for x in (-2.0, 2.0) for z in (0.0, -2.0 + x * np.tan(APEX))]
    mesh = trimesh.convex.convex_hull(np.array([[x, y, z] for x, z in ends for y in (-2, 2)]))
    return pm.Mesh(mesh.vertices, mesh.faces, material, "prism")


def landing(index, z=-8.0):
    """Where a ray straight down through the prism meets a plane, and what is left of it."""
    normal = np.array([-np.sin(APEX), np.cos(APEX)])  # of the lower face, upwards
    inside, cosine = np.array([0.0, -1.0]), np.cos(APEX)
    beyond = np.sqrt(1.0 - index**2 * (1.0 - cosine**2))
    out = index * inside + (index * cosine - beyond) * normal
    parallel = (cosine - index * beyond) / (cosine + index * beyond)
    perpendicular = (index * cosine - beyond) / (index * cosine + beyond)
    passed = 1.0 - 0.5 * (parallel**2 + perpendicular**2)
    return out[0] * (z + 2.0) / out[1], passed * (1.0 - ((index - 1.0) / (index + 1.0)) ** 2)


def over(curve, function):
    """Means of a function's values over a band."""
    wavelengths = np.linspace(curve.wavelengths[0], curve.wavelengths[-1], 500)
    weights = np.interp(wavelengths, curve.wavelengths, curve.values)
    return np.average([function(w) for w in wavelengths], axis=0, weights=weights)


@pytest.mark.parametrize(("bands", "method"), [("450:700:50", "path"), ("box:3", "photon")])
def test_a_beam_through_a_prism(bands, method):
    """Where it goes in each band, by the brightness of a lamp that grows along x."""
    ramp = np.repeat(np.linspace(0.0, 1.0, 256, dtype=np.float32)[None, :, None], 3, axis=2)
    ramp = pm.Texture.of(np.repeat(ramp, 2, axis=0), clamp=True)
    white = pm.Texture.of(np.ones((2, 2, 3), np.float32))
    camera = pm.Camera((0, 0, 5), (0, 0, 0), fov=0.01, up=(0, 1, 0))
    settings = {"bands": bands, "size": (8, 8), "passes": 128, "photons": 100}
    settings |= {"seed": 3, "method": method}
    glass, place = prism(FLINT), (-3.5, -1.0)
    ramped = pm.render(pm.Scene([glass, lamp(-8.0, ramp, *place)], [], camera), **settings)
    even = pm.render(pm.Scene([glass, lamp(-8.0, white, *place)], [], camera), **settings)
    share = ramped.emission.mean(axis=(0, 1)) / even.emission.mean(axis=(0, 1))
    found = 2.5 * (share * 255 + 0.5) / 256 - 3.5  # texels hold the values at their centres

    def weighted(wavelength):
        x, passed = landing(FLINT.dispersion.index(wavelength))
        return x * passed, passed

    means = [over(curve, weighted) for curve in pm.Bands.parse(bands).sensitivities]
    np.testing.assert_allclose(found, [moment / passed for moment, passed in means], atol=0.01)
    assert ramped.record["effects"]["dispersion"]["on"]


def test_a_slab_reflects_by_band():
    """T² / (1 - R²) with R of each band, and n² of what leaves the glass."""
    mesh = trimesh.creation.box((4, 4, 0.5))
    glass = pm.Mesh(mesh.vertices, mesh.faces, STRONG, "slab")
    camera = pm.Camera((0.1, 0.2, 5), (0.1, 0.2, 0), fov=0.5)
    scene = pm.Scene([glass, lamp(-1.0, 1.0)], [], camera)
    settings = {"bands": "box:4", "size": (16, 16), "passes": 128, "seed": 2}
    result = pm.render(scene, **settings, method="path")

    def passed(wavelength):
        index = abbe_index(wavelength, 1.6, 6.0)
        once = ((index - 1.0) / (index + 1.0)) ** 2
        return (1.0 - once) ** 2 / (1.0 - once**2)

    wanted = [over(curve, passed) for curve in pm.Bands.box(4).sensitivities]
    np.testing.assert_allclose(result.emission.mean(axis=(0, 1)), wanted, rtol=0.015)


def test_auto_equals_all_and_grey_glass_costs_nothing():
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=0.4)

    def render(material, **settings):
        ball = pm.Mesh(mesh.vertices, mesh.faces, material, "ball")
        scene = pm.Scene([*BOX.meshes, ball], [], BOX.camera)
        return pm.render(scene, bands="box:3", size=(8, 8), passes=3, seed=6, **settings)

    auto, everything = render(FLINT), render(FLINT, effects="all")
    np.testing.assert_array_equal(auto.radiance, everything.radiance)
    left = [name for name in EFFECTS if name not in ("dispersion", "band_merging")]
    plain = render(pm.Material.glass("plain", FLINT.ior))
    np.testing.assert_array_equal(render(FLINT, effects=left).radiance, plain.radiance)
    assert not plain.record["effects"]["dispersion"]["on"]


def test_runs_are_resumed_with_the_same_wavelengths(tmp_path):
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=0.4)
    ball = pm.Mesh(mesh.vertices, mesh.faces, FLINT, "ball")
    scene = pm.Scene([*BOX.meshes, ball], [], BOX.camera)
    settings = {"bands": "box:3", "size": (12, 12), "seed": 6}
    whole = pm.render(scene, passes=4, **settings)
    kept = tmp_path / "kept.npz"
    pm.render(scene, passes=2, checkpoint=kept, **settings)
    resumed = pm.render(scene, passes=4, checkpoint=kept, resume=True, **settings)
    np.testing.assert_array_equal(whole.radiance, resumed.radiance)


CATALOGUE = {
    "bk7": (1.5168, 64.17),
    "sf10": (1.72828, 28.53),
    "sf11": (1.78472, 25.68),
    "fused quartz": (1.45846, 67.82),
    "water": (1.3334, 55.8),
    "diamond": (2.4175, 55.3),
    "sapphire": (1.76817, 72.2),
}


@pytest.mark.parametrize("name", GLASSES)
def test_named_glasses(name):
    index, abbe = CATALOGUE[name]
    assert NamedGlass(name).index(LINES[0]) == pytest.approx(index, abs=2e-4)
    assert abbe_number(NamedGlass(name).index) == pytest.approx(abbe, rel=5e-3)


def test_abbe_numbers_and_equations():
    assert abbe_number(lambda line: abbe_index(line, 1.5, 40.0)) == pytest.approx(40.0)
    assert abbe_index(LINES[0], 1.5, 40.0) == pytest.approx(1.5)
    curve = Cauchy(1.5046, 0.0042)
    assert curve.index(500.0) == pytest.approx(1.5046 + 0.0042 / 0.25)
    assert pm.Material("m", 0.0, dispersion=curve).ior == pytest.approx(curve.index(LINES[0]))
    assert Sellmeier(*GLASSES["bk7"]).index(500.0) == NamedGlass("BK7").index(500.0)


@pytest.mark.parametrize(
    ("look", "message"),
    [
        ({"ior": 1.5, "abbe": 0.0}, "abbe: 0.0 is not an Abbe number"),
        ({"ior": 1.5, "abbe": 60.0, "dispersion": Cauchy(1.5, 0.0)}, "an abbe number and a disp"),
        ({"ior": 1.4, "dispersion": Cauchy(1.5, 0.0)}, "ior 1.4 is not that of its disp"),
        ({"dispersion": NamedGlass("bk8")}, "no glass 'bk8'; did you mean 'bk7'"),
        ({"ior": 1.5, "dispersion": Sellmeier((1.0,), (1.0, 2.0))}, "as many of both"),
        ({"ior": 1.5, "dispersion": Sellmeier((1.0,), (0.3,))}, "for wavelengths in µm"),
        ({"ior": 1.5, "dispersion": Cauchy(-1.0, 0.0)}, "above 0"),
    ],
)  # fmt: skip
def test_bad_dispersion(look, message):
    material = pm.Material("m", 0.0, **look)
    scene = pm.Scene([prism(material), lamp(-8.0, 1.0)], [], pm.Camera((0, 0, 5), (0, 0, 0)))
    with pytest.raises(pm.InputError, match=f"'m'.*{message}"):
        pm.render(scene, bands="box:2", size=(4, 4), passes=1)


LOOKS = {
    "abbe": {"ior": 1.6, "abbe": 30.0},
    "cauchy": {"dispersion": Cauchy(1.5, 0.004)},
    "sellmeier": {"dispersion": Sellmeier(*GLASSES["bk7"])},
    "named": {"dispersion": NamedGlass("water")},
}


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
@pytest.mark.parametrize("look", LOOKS)
def test_files_keep_dispersion(tmp_path, look, suffix):
    """MTL and glTF have the Abbe number alone; a TOML file beside glTF has the rest."""
    wanted = pm.Material("m", 0.0, **LOOKS[look])
    scene = pm.Scene([prism(wanted)], [], pm.Camera((0, 0, 5), (0, 0, 0)))
    pm.save_scene(scene, tmp_path / f"scene{suffix}")
    found = pm.load_scene(tmp_path / f"scene{suffix}").meshes[0].material
    assert found.ior == pytest.approx(wanted.ior)
    assert found.nearest_abbe == pytest.approx(wanted.nearest_abbe)
    beside = tmp_path / "scene.toml"
    if beside.exists() and suffix == ".glb":
        assert pm.load_scene(beside).meshes[0].material.dispersion == wanted.dispersion


@pytest.mark.parametrize(
    ("text", "curve"),
    [
        ('dispersion = { type = "named", name = "BK7" }', NamedGlass("BK7")),
        ('dispersion = { type = "cauchy", a = 1.5, b = 0.004 }', Cauchy(1.5, 0.004)),
        ('dispersion = { type = "sellmeier", b = [1.2], c = [0.01] }', Sellmeier((1.2,), (0.01,))),
        ("ior = 1.5\nabbe = 55", None),
    ],
)
def test_scene_files(tmp_path, text, curve):
    scene = pm.Scene([prism(pm.Material("m", 0.3))], [], pm.Camera((0, 0, 5), (0, 0, 0)))
    pm.save_scene(scene, tmp_path / "mesh.obj")
    path = tmp_path / "new.toml"
    path.write_text(f'mesh = "mesh.obj"\n[material.m]\n{text}\n')
    material = pm.load_scene(path).meshes[0].material
    assert material.dispersion == curve
    assert material.reflectance == 0.0
    assert material.ior == pytest.approx(1.5 if curve is None else curve.index(LINES[0]))
    assert material.abbe == (55.0 if curve is None else None)
