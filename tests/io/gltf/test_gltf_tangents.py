"""Tangents of glTF files where nodes put them, and images of anisotropy."""

import base64

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import photonmap as pm
from photonmap.errors import SceneWarning
from photonmap.io.png import encode_png

UP = [[0.0, 0.0, 1.0]] * 3
ALONG = np.array([[1.0, 0.0, 0.0, 1.0]] * 3)
UV = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
TURN = Rotation.from_euler("xyz", [0.3, -0.8, 1.1])


def part(read, build, node=(), **attributes):
    build.primitive(**({"NORMAL": UP, "TANGENT": ALONG, "TEXCOORD_0": UV} | attributes))
    build.tree["nodes"][0] |= dict(node)
    (mesh,) = read("a.glb", build.glb())
    return mesh


def test_they_are_read_as_they_are(read, build):
    given = np.array([[0.6, 0.8, 0, -1], [0, 1, 0, -1], [2, 0, 0, -1]], float)
    np.testing.assert_allclose(part(read, build, TANGENT=given).tangents, given, atol=1e-7)


def test_they_need_normals(read, build):
    build.primitive(TANGENT=ALONG, TEXCOORD_0=UV)
    (mesh,) = read("a.glb", build.glb())
    assert mesh.tangents is None


def test_nodes_turn_and_stretch_them(read, build):
    node = {"rotation": TURN.as_quat().tolist(), "scale": [2.0, 3.0, 0.5]}
    mesh = part(read, build, node, TANGENT=np.array([[0.6, 0.8, 0, 1]] * 3))
    wanted = TURN.apply([1.2, 2.4, 0.0])
    wanted /= np.linalg.norm(wanted)
    np.testing.assert_allclose(mesh.unit_tangents, [[*wanted, 1.0]] * 3, atol=1e-6)


def test_mirrored_nodes_swap_the_sign(read, build):
    """The bitangent is mirrored like all else: normal × tangent · sign, from (0, 1, 0)."""
    mesh = part(read, build, {"scale": [-1.0, 1.0, 1.0]})
    tangent, normal = mesh.unit_tangents[0], mesh.unit_normals[0]
    np.testing.assert_allclose(tangent, [-1, 0, 0, -1], atol=1e-6)
    np.testing.assert_allclose(tangent[3] * np.cross(normal, tangent[:3]), [0, 1, 0], atol=1e-6)


def test_morph_targets_move_them(read, build):
    build.tree["meshes"][0]["weights"] = [0.5]
    target = {"TANGENT": build.add(np.array([[0.0, 2.0, 0.0]] * 3))}
    mesh = part(read, build, more={"targets": [target]})
    np.testing.assert_allclose(mesh.tangents, [[1, 1, 0, 1]] * 3, atol=1e-6)


def test_tangents_of_another_shape_are_left_out(read, build):
    with pytest.warns(SceneWarning, match=r"tangents of another shape than \(x, y, z, w\)"):
        assert part(read, build, TANGENT=ALONG[:, :3].copy()).tangents is None


def test_images_of_anisotropy(read, build):
    texels = np.array([[[255, 128, 51], [128, 255, 255]]], np.uint8)
    data = base64.b64encode(encode_png(texels)).decode()
    stretch = {"anisotropyStrength": 0.6, "anisotropyTexture": {"index": 0}}
    build.tree |= {
        "images": [{"uri": f"data:image/png;base64,{data}"}],
        "textures": [{"source": 0}],
        "materials": [
            {
                "pbrMetallicRoughness": {"roughnessFactor": 0.4},
                "extensions": {"KHR_materials_anisotropy": stretch},
            }
        ],
    }
    material = part(read, build, more={"material": 0}).material
    assert material.anisotropy == 0.6
    image = material.anisotropy_map.texture.image
    np.testing.assert_array_equal(image.texels, texels)
    assert not image.srgb


def test_anisotropy_keeps_an_image_of_roughness(read, build, recwarn):
    data = base64.b64encode(encode_png(np.array([[[0, 51, 0], [0, 204, 0]]], np.uint8))).decode()
    build.tree |= {
        "images": [{"uri": f"data:image/png;base64,{data}"}],
        "textures": [{"source": 0}],
        "materials": [
            {
                "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}},
                "extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 0.6}},
            }
        ],
    }
    material = part(read, build, more={"material": 0}).material
    assert not recwarn.list
    assert material.roughness.mean == pytest.approx((0.5,) * 3)


@pytest.mark.parametrize("thickness", [0.0, 0.1])
def test_anisotropy_of_what_transmits(read, build, recwarn, thickness):
    build.tree["materials"] = [
        {
            "pbrMetallicRoughness": {"roughnessFactor": 0.4, "metallicFactor": 0.0},
            "extensions": {
                "KHR_materials_anisotropy": {"anisotropyStrength": 0.6, "anisotropyRotation": 0.5},
                "KHR_materials_transmission": {"transmissionFactor": 1.0},
                "KHR_materials_volume": {"thicknessFactor": thickness},
            },
        }
    ]
    material = part(read, build, more={"material": 0}).material
    assert not recwarn.list
    assert (material.thin, material.is_anisotropic) == (thickness == 0.0, True)
    assert (material.roughness, material.anisotropy) == (0.4, 0.6)
    assert material.anisotropy_rotation == pytest.approx(0.25 / np.pi)


def test_obj_keeps_images_and_names_what_it_lacks(tmp_path):
    image = pm.Texture.of(np.full((2, 2, 3), [1.0, 0.5, 0.25], np.float32))
    look = {"roughness": 0.4, "anisotropy": 0.5, "anisotropy_map": pm.AnisotropyMap(image)}
    material = pm.Material("metal", 0.0, glossy=0.8, **look)
    mesh = pm.Mesh(np.eye(3), [[0, 1, 2]], material, "a", UP, UV, tangents=ALONG)
    with pytest.warns(SceneWarning, match="OBJ holds no tangents: those of 'a' will follow"):
        pm.save_scene(pm.Scene([mesh]), tmp_path / "a.obj")
    found = pm.load_scene(tmp_path / "a.obj").meshes[0]
    assert found.tangents is None
    kept = found.material.anisotropy_map.texture.image.texels
    np.testing.assert_allclose(kept, image.image.texels)
