"""Scenes are written as glTF, with TOML for what glTF cannot hold, and read back the same."""

import json
import struct
from dataclasses import replace

import numpy as np
import pytest
import trimesh

import photonmap as pm
from photonmap.compile.scene_arrays import compile_arrays
from photonmap.errors import InputError, SceneWarning
from photonmap.io.readers.registry import read_file
from photonmap.io.writers.gltf_draft import split_metal

from helpers.scenes import quad, sky  # isort: skip

UV = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
STRIPES = pm.Spectrum([380, 500, 780], [0.1, 0.7, 0.3])
SUFFIXES = pytest.mark.parametrize("suffix", [".glb", ".gltf"])


def panel(material, at=0, uv=None, name=None):
    mesh = quad((at, 0, 0), (at + 1, 0, 0), (at + 1, 1, 0), (at, 1, 0))
    return pm.Mesh(mesh.vertices, mesh.faces, material, name or material.name, uv=uv)


def panels(*materials):
    return [panel(material, at, UV) for at, material in enumerate(materials)]


def saved(scene, folder, name="room.glb"):
    first, *_ = pm.save_scene(scene, folder / name)
    return pm.load_scene(first)


def leaves(record, name=""):
    """Yield the arrays of nested records by name."""
    if hasattr(record, "_fields"):
        for field in record._fields:
            yield from leaves(getattr(record, field), f"{name}.{field}")
    else:
        yield name, record


def assert_same_arrays(first, second, bands=4, **tolerance):
    """Compare what kernels get; addresses of images differ."""
    a, b = (compile_arrays(scene, pm.Bands.parse(bands)) for scene in (first, second))
    for (name, wanted), (_, found) in zip(leaves(a.arrays), leaves(b.arrays), strict=True):
        if wanted is None or "address" in name:
            assert (wanted is None) == (found is None), name
        elif tolerance:
            np.testing.assert_allclose(found, wanted, err_msg=name, **tolerance)
        else:
            np.testing.assert_array_equal(found, wanted, err_msg=name)
    assert (a.light_names, a.light_groups) == (b.light_names, b.light_groups)
    for ids in ("object_ids", "material_ids"):
        np.testing.assert_array_equal(getattr(a, ids), getattr(b, ids))


@SUFFIXES
@pytest.mark.parametrize("name", ["furnace.obj", "two_rooms.obj"])
def test_scenes_of_float32_return_to_the_last_bit(tmp_path, name, suffix):
    scene = pm.load_scene(f"{pm.scenes.FOLDER}/{name}")
    written = pm.save_scene(scene, tmp_path / f"room{suffix}")
    assert [path.suffix for path in written] == [suffix] + [".bin"] * (suffix == ".gltf")
    again = pm.load_scene(written[0])
    assert_same_arrays(scene, again)
    assert_same_arrays(scene, again, "rgb")
    settings = {"bands": 2, "size": (8, 6), "passes": 1, "photons": 1 << 10}
    np.testing.assert_array_equal(
        pm.render(scene, **settings).radiance, pm.render(again, **settings).radiance
    )


@pytest.mark.parametrize("name", ["cornell_box.obj", "cornell_box_measured.toml"])
def test_other_coordinates_are_rounded_about_the_middle(tmp_path, name):
    scene = pm.load_scene(f"{pm.scenes.FOLDER}/{name}")
    assert_same_arrays(scene, saved(scene, tmp_path), rtol=1e-5, atol=2e-7)
    far = np.array([5e5, 5.4e6, 100.0])
    moved = [
        pm.Mesh(mesh.vertices + far, mesh.faces, mesh.material, mesh.name) for mesh in scene.meshes
    ]
    again = saved(pm.Scene(moved), tmp_path, "far.glb")
    for wanted, found in zip(moved, again.meshes, strict=True):
        np.testing.assert_allclose(found.vertices, wanted.vertices, rtol=0.0, atol=1e-7)


def test_corners_that_meet_still_do(tmp_path):
    corners = np.random.default_rng(0).random((4, 3))
    meshes = [
        pm.Mesh(corners[order], [[0, 1, 2]], pm.Material("a"), f"part {n}")
        for n, order in enumerate(([0, 1, 2], [1, 2, 3]))
    ]
    first, second = saved(pm.Scene(meshes), tmp_path).meshes
    np.testing.assert_array_equal(first.vertices[1:], second.vertices[:2])


def test_normals_uv_objects_and_strays(tmp_path):
    ball = trimesh.creation.icosphere(2)
    uv = np.random.default_rng(1).random((len(ball.vertices), 2)).astype(np.float32)
    smooth = pm.Mesh(ball.vertices, ball.faces, pm.Material("a"), "ball", ball.vertices, uv)
    stray = pm.Mesh([(9, 9, 9), (0, 0, 0), (1, 0, 0), (0, 1, 0)], [[1, 2, 3]], name="flat")
    other = pm.Mesh(ball.vertices[:, ::-1], ball.faces, pm.Material("b"), "ball")
    again = saved(pm.Scene([smooth, stray, other]), tmp_path).meshes
    assert [(m.name, m.material.name) for m in again] == [
        ("ball", "a"), ("ball", "b"), ("flat", "grey"),
    ]  # fmt: skip
    np.testing.assert_allclose(again[0].normals, smooth.normals, atol=1e-7)
    np.testing.assert_allclose(again[0].uv, uv, atol=1e-7)
    assert again[1].normals is again[1].uv is None
    assert len(again[2].vertices) == 3


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".obj"])
def test_odd_normals_return_as_they_are_used(tmp_path, suffix):
    normals = np.array([(0, 0, 1e-200), (np.nan, 0, 1), (0, 0, 0), (3, 4, 0)])
    mesh = quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
    scene = pm.Scene([pm.Mesh(mesh.vertices, mesh.faces, normals=normals)])
    again = saved(scene, tmp_path, f"room{suffix}")
    found = again.meshes[0].unit_normals
    np.testing.assert_allclose(found, [(0, 0, 1), (0, 0, 0), (0, 0, 0), (0.6, 0.8, 0)], atol=1e-7)


MATERIALS = [
    pm.Material("number", 0.25),
    pm.Material("triple", (0.2, 0.4, 0.6)),
    pm.Material("spectrum", STRIPES),
    pm.Material("lamp", 0.1, emission=(17.0, 12.3, 4.1)),
    pm.Material("even lamp", 0.0, emission=15.0),
    pm.Material("spectral lamp", 0.0, emission=STRIPES * 3.0),
    pm.Material.polished("mirror", 0.9),
    pm.Material.polished("tinted mirror", (0.9, 0.5, 0.3)),
    pm.Material("coated", (0.2, 0.3, 0.4), mirror=0.05),
    pm.Material.glass("glass", 1.45, (0.5, 0.9, 0.5)),
    pm.Material.glass("spectral glass", 1.6, STRIPES),
    pm.Material("pane", 0.0, ior=1.5, alpha=0.5, emission=(0.1, 0.2, 0.3)),
    pm.Material.metal("gold", (0.9, 0.7, 0.2), 0.2),
    pm.Material.metal("spectral metal", STRIPES, 0.4),
    pm.Material.plastic("plastic", (0.1, 0.5, 0.3)),
    pm.Material("half metal", (0.1, 0.2, 0.3), glossy=(0.13, 0.23, 0.33), roughness=0.5),
    pm.Material("odd gloss", (0.1, 0.2, 0.3), glossy=(0.5, 0.1, 0.3), roughness=0.7),
    pm.Material("bright coat", (0.2, 0.1, 0.0), glossy=0.999, roughness=0.1),
    pm.Material("clay", 0.4, diffuse_roughness=0.8),
    pm.Material("gauze", (0.5, 0.4, 0.3), alpha=0.25),
    pm.Material("black", 0.0),
    pm.Material("wall", 0.3),
    pm.Material("wall", 0.6),
    pm.Material('the "odd" [name] = é\\', (0.1, 0.1, 0.2), mirror=0.1),
]


@SUFFIXES
@pytest.mark.filterwarnings("ignore:glass is no closed mesh")
@pytest.mark.parametrize("bands", [5, "rgb"])
def test_materials_return(tmp_path, suffix, bands):
    scene = pm.Scene(panels(*MATERIALS))
    again = saved(scene, tmp_path, f"room{suffix}")
    names = [mesh.material.name for mesh in again.meshes]
    assert names[-3:] == ["wall", "wall 2", MATERIALS[-1].name]
    renamed = [pm.Mesh(m.vertices, m.faces, m.material, m.name, uv=UV) for m in scene.meshes]
    renamed[-2] = panel(pm.Material("wall 2", 0.6), len(MATERIALS) - 2, UV, "wall")
    assert_same_arrays(pm.Scene(renamed), again, bands, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize(
    "plain",
    ["number", "triple", "lamp", "glass", "gold", "plastic", "half metal", "gauze", "black"],
)
def test_what_gltf_holds_needs_no_toml(tmp_path, plain):
    material = next(each for each in MATERIALS if each.name == plain)
    (written,) = pm.save_scene(pm.Scene([panel(material)]), tmp_path / "a.glb")
    (found,) = read_file(written).meshes
    for name in ("reflectance", "emission", "glossy", "covering", "ior", "tint", "alpha"):
        wanted = np.ones(3) * getattr(material, name) if getattr(material, name) else 0.0
        np.testing.assert_allclose(
            np.ones(3) * getattr(found.material, name) if getattr(found.material, name) else 0.0,
            wanted * np.ones_like(wanted), rtol=1e-12, atol=1e-12,
        )  # fmt: skip


def test_a_metal_in_part_is_split():
    rng = np.random.default_rng(5)
    for _ in range(100):
        color, (metallic, coat) = rng.random(3), rng.random(2)
        base, gloss = (1 - metallic) * color, metallic * color + (1 - metallic) * coat
        found = split_metal(base, gloss, coat)
        np.testing.assert_allclose(found[0], color, rtol=1e-9)
        np.testing.assert_allclose(found[1:2], metallic, rtol=1e-7, atol=1e-9)
        np.testing.assert_array_equal(found[2], [coat] * 3)


def test_textures_return(tmp_path):
    rng = np.random.default_rng(0)
    texels = rng.integers(0, 256, (4, 5, 3), dtype=np.uint8)
    cut = pm.Texture.of(rng.integers(0, 2, (4, 5)).astype(np.float32))
    mask = pm.Texture.of(rng.integers(0, 256, (4, 5), dtype=np.uint8), srgb=False)
    wood = pm.Texture.of(texels)
    placed = replace(wood, scale=(2.0, 3.0), offset=(0.25, -0.5), clamp=True)
    materials = [
        pm.Material("wall", replace(placed, factor=(0.5, 1.0, 0.75))),
        pm.Material("leaf", wood, alpha=cut),
        pm.Material("veil", wood, alpha=mask),
        pm.Material("grey veil", (0.2, 0.3, 0.4), alpha=mask),
        pm.Material("screen", 0.0, emission=replace(wood, factor=(20.0, 10.0, 5.0))),
        pm.Material("varnish", wood, glossy=0.04, roughness=0.2),
    ]
    scene = pm.Scene(panels(*materials))
    written = pm.save_scene(scene, tmp_path / "room.glb")
    assert len(written) == 1
    again = [mesh.material for mesh in pm.load_scene(written[0]).meshes]
    for wanted, found in zip(materials, again, strict=True):
        for name in ("reflectance", "emission", "alpha"):
            a, b = getattr(wanted, name), getattr(found, name)
            if isinstance(a, pm.Texture):
                whole = slice(None), slice(None)
                np.testing.assert_allclose(
                    b.image.linear(*whole) * np.array(b.factor)[: b.image.texels.shape[2]],
                    a.image.linear(*whole) * np.array(a.factor)[: a.image.texels.shape[2]],
                    rtol=1e-6,
                )
                np.testing.assert_allclose([b.scale, b.offset], [a.scale, a.offset], atol=1e-12)
                assert b.clamp == a.clamp
    assert again[3].reflectance.mean == pytest.approx((0.2, 0.3, 0.4))
    tree = json_of(written[0])
    assert len(tree["images"]) == 4
    assert [material.get("alphaMode") for material in tree["materials"]][1:4] == ["BLEND"] * 3


@pytest.mark.parametrize("clamp", [False, True, (True, False), (False, True)])
@pytest.mark.parametrize("nearest", [False, True])
def test_how_textures_are_looked_up_returns(tmp_path, clamp, nearest):
    wood = pm.Texture.of(np.eye(4, dtype=np.uint8)[..., None] * 200, clamp=clamp, nearest=nearest)
    cut = replace(wood, clamp=False, nearest=not nearest)
    again = saved(pm.Scene(panels(pm.Material("a", wood), pm.Material("b", cut))), tmp_path)
    for wanted, mesh in zip((wood, cut), again.meshes, strict=True):
        found = mesh.material.reflectance
        assert (found.clamp, found.nearest) == (wanted.clamp, wanted.nearest)


def json_of(path):
    data = path.read_bytes()
    (size,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + size])


def test_what_is_rounded_is_said(tmp_path):
    rng = np.random.default_rng(2)
    floats = pm.Texture.of(rng.random((3, 4, 3)) * 50.0)
    small = pm.Texture.of(rng.integers(0, 256, (2, 2), dtype=np.uint8), srgb=False)
    turned = pm.Texture.of(rng.random((3, 4)), scale=(2.0, 1.0))
    wood = pm.Texture.of(rng.integers(0, 256, (4, 4, 3), dtype=np.uint8))
    materials = [
        pm.Material("screen", 0.0, emission=floats),
        pm.Material("small", wood, alpha=small),
        pm.Material("turned", wood, alpha=turned),
        pm.Material("pane", 0.0, ior=1.5, alpha=small),
        pm.Material("veil", wood, alpha=pm.Texture.of(np.full((4, 4), 0.3) + np.eye(4) / 3)),
        pm.Material("exact", wood, alpha=pm.Texture.of(np.eye(4) * 12345 / 65535)),
    ]
    with pytest.warns(SceneWarning) as record:
        again = saved(pm.Scene(panels(*materials)), tmp_path)
    assert [str(warning.message) for warning in record] == [
        "textures of floating-point numbers are rounded to 16 bits in sRGB, in 1 material: "
        "'screen'",
        "textures are enlarged to the size of another one in the same image, in 1 material: "
        "'small'",
        "opacities that lie otherwise than the colour become their mean, in 1 material: 'turned'",
        "textures of opacity, roughness, normals and the like are rounded to 16 bits, in 1 "
        "material: 'veil'",
    ]
    screen, enlarged, mean, pane, *_ = (mesh.material for mesh in again.meshes)
    texels = screen.emission.image.texels * np.array(screen.emission.factor)
    np.testing.assert_allclose(texels, floats.image.texels, rtol=1e-3, atol=2e-3)
    np.testing.assert_array_equal(
        enlarged.alpha.image.texels[::2, ::2, 0] * 255, small.image.texels[..., 0]
    )
    assert mean.alpha == pytest.approx(np.mean(turned.mean))
    np.testing.assert_allclose(pane.alpha.image.texels[..., 0] * 255, small.image.texels[..., 0])


LIGHTS = [
    pm.PointLight((1, 2, 3), (3.0, 2.0, 1.0), "lamp"),
    pm.PointLight((1, 2, 3), 2.0, "even lamp"),
    pm.PointLight((1, 2, 0), (3.0, 2.0, 1.0), "grouped", "theatre"),
    pm.SpotLight((0, 1, 0), (0.3, 0, 0.2), (1.0, 0.5, 0.25), 10.0, 25.5, "stage"),
    pm.SpotLight((0, 1, 0), (0, 0, 0), (1.0, 0.5, 0.25), 10.0, 120.0, "wide"),
    pm.DirectionalLight((0, -3, 0.1), (1.0, 0.9, 0.8)),
    pm.DirectionalLight((1, -3, 0.1), STRIPES, "spectral sun"),
    pm.PointLight((0, 2, 0), (1.0, 1.0, 1.0), 'a "name" that glTF changes'),
    pm.PhotometricLight((0, 2, 1), np.eye(4) + 0.1, 3.0, name="measured"),
    pm.EnvironmentLight(sky(), 0.5, 90.0, "sky"),
]


@pytest.mark.parametrize("index", range(len(LIGHTS)), ids=lambda i: LIGHTS[i].name or "sun")
def test_lights_return(tmp_path, index):
    scene = pm.Scene([panel(pm.Material("a"))], [LIGHTS[index]])
    assert_same_arrays(scene, saved(scene, tmp_path), rtol=1e-6, atol=1e-7)


def test_lights_return_together(tmp_path):
    scene = pm.Scene([panel(pm.Material("a"))], LIGHTS)
    again = {light.name: light for light in saved(scene, tmp_path).lights}
    assert set(again) == {light.name or "directional" for light in LIGHTS}
    known = {light.name for light in read_file(tmp_path / "room.glb").lights}
    assert known == set(again) - {"wide", "sky", 'a "name" that glTF changes'}


CAMERAS = [
    pm.Camera((0, 1, 3), (0, 0.1, 0), (0, 1, 0.1), 33.3, name="first"),
    pm.Camera((0, 1, 30), (0, 0.1, 0), height=2.5, name="flat"),
    pm.Camera((0, 1, 3), (0.2, 0, 0), lens=pm.Lens(2.0, radius=0.1), name="lens"),
    pm.Camera((0, 1, 3), (0.2, 0, 0), projection=pm.Panorama(), name="all around"),
]


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_cameras_return(tmp_path, count):
    scene = pm.Scene([panel(pm.Material("a"))], cameras=CAMERAS[:count])
    again = saved(scene, tmp_path)
    assert (tmp_path / "room.toml").exists() == (count > 2)
    for wanted, found in zip(CAMERAS, again.every_camera, strict=False):
        a, b = wanted.describe(30, 20), found.describe(30, 20)
        for key in ("camera_to_world", "intrinsics"):
            if a[key] is not None:
                np.testing.assert_allclose(a[key], b[key], rtol=1e-12, atol=1e-12)
        assert (a["name"], a["kind"], a["lens"]) == (b["name"], b["kind"], b["lens"])
    assert len(again.every_camera) == count


def test_saving_again_replaces_what_toml_said(tmp_path):
    saved(pm.Scene([panel(MATERIALS[2])], [LIGHTS[-1]]), tmp_path)
    again = saved(pm.Scene([panel(MATERIALS[1])]), tmp_path)
    assert again.lights == []
    assert again.meshes[0].material.reflectance == MATERIALS[1].reflectance


def test_nothing_is_left_of_a_failure(tmp_path):
    for scene in (pm.Scene(), pm.Scene([panel(pm.Material("a"))], [pm.PointLight((0, 0, np.nan))])):
        with pytest.raises(InputError):
            pm.save_scene(scene, tmp_path / "room.glb")
    assert not list(tmp_path.iterdir())


def test_others_read_it(tmp_path):
    """trimesh, an independent reader, finds the same triangles in the same places."""
    box = pm.scenes.cornell_box()
    (path,) = pm.save_scene(pm.Scene(box.meshes), tmp_path / "box.glb")
    read = trimesh.load(path).to_geometry()
    wanted = np.concatenate([mesh.vertices[mesh.faces] for mesh in box.meshes])
    np.testing.assert_allclose(read.bounds, [wanted.min((0, 1)), wanted.max((0, 1))], atol=1e-6)
    areas = np.linalg.norm(
        np.cross(wanted[:, 1] - wanted[:, 0], wanted[:, 2] - wanted[:, 0]), axis=1
    )
    assert read.area == pytest.approx(0.5 * areas.sum(), rel=1e-6)
    assert len(read.faces) == len(wanted)


def linear(texture):
    return texture.image.linear(slice(None), slice(None)) * np.array(texture.factor)


def test_textures_of_roughness_return_to_the_last_bit(tmp_path):
    rough = pm.Texture.of(np.array([[[51], [204]]], np.uint8), srgb=False)
    gold = pm.Material.metal("gold", (0.9, 0.7, 0.3), roughness=rough)
    board = pm.Texture.of(np.array([[[90, 60, 30], [250, 240, 230]]], np.uint8))
    coated = pm.Material("coated", board, glossy=0.04, roughness=rough)
    again = saved(pm.Scene(panels(gold, coated)), tmp_path)
    first, second = (mesh.material for mesh in again.meshes)
    for material in (first, second):
        np.testing.assert_array_equal(material.roughness.image.texels, rough.image.texels)
    np.testing.assert_allclose(first.glossy, gold.glossy, rtol=1e-6)
    assert not np.any(first.reflectance)
    np.testing.assert_allclose(linear(second.reflectance), linear(board), rtol=1e-6)
    assert second.glossy == pytest.approx(0.04)


def test_textured_metals_return(tmp_path):
    """Base, lobe and roughness of each texel, to 16 bits in sRGB."""
    base = pm.Texture.of(np.float32([[[0.5, 0.4, 0.3], [0.0, 0.0, 0.0]]]))
    lobe = pm.Texture.of(np.float32([[[0.04, 0.04, 0.04], [0.9, 0.6, 0.2]]]))
    rough = pm.Texture.of(np.float32([[[0.123]], [[0.6]]]))
    material = pm.Material("mixed", base, glossy=lobe, roughness=rough)
    with pytest.warns(SceneWarning):
        (mesh,) = saved(pm.Scene(panels(material)), tmp_path).meshes
    found = mesh.material
    for texture, wanted in ((found.reflectance, base), (found.glossy, lobe)):
        texels = linear(wanted) * np.ones((2, 1, 1))
        np.testing.assert_allclose(linear(texture), texels, atol=1e-4)
    np.testing.assert_allclose(
        linear(found.roughness)[..., :1], linear(rough)[..., :1] * np.ones((1, 2, 1)), atol=1e-5
    )
