"""Materials of glTF files: what their factors become, and what is named as not simulated."""

import pytest
import trimesh

from photonmap.errors import InputError
from photonmap.scene.material import Material

COAT = (0.5 / 2.5) ** 2
"""Reflectance at normal incidence of glTF's usual index."""
MATTE = {"metallicFactor": 0, "baseColorFactor": [0.5, 0.5, 0.5, 0.4]}
GLASS = {
    "pbrMetallicRoughness": {
        "metallicFactor": 0,
        "roughnessFactor": 0.4,
        "baseColorFactor": [0.9, 1, 1, 1],
    },
    "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1.0},
        "KHR_materials_volume": {"thicknessFactor": 0.1},
        "KHR_materials_ior": {"ior": 1.4},
    },
}


@pytest.mark.parametrize(
    ("item", "material", "lost"),
    [
        ({"name": "a"}, Material("a"), None),
        ({}, Material("material_0"), None),
        (
            {"name": "a", "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 1, 1]}},
            Material("a", (0.0,) * 3, glossy=(0.1, 0.2, 1.0), roughness=1.0),
            None,
        ),
        (
            {"pbrMetallicRoughness": {}},
            Material("material_0", (0.0,) * 3, glossy=(1.0,) * 3, roughness=1.0),
            None,
        ),
        (
            {
                "name": "sign",
                "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 1, 1]},
                "extensions": {"KHR_materials_unlit": {}},
            },
            Material("sign", (0.1, 0.2, 1.0)),
            "KHR_materials_unlit of 'sign'",
        ),
        (
            {
                "name": "old",
                "extensions": {
                    "KHR_materials_pbrSpecularGlossiness": {
                        "diffuseFactor": [0.1, 0.2, 0.3, 0.5],
                        "specularFactor": [0.25, 0.5, 0.125],
                        "glossinessFactor": 0.75,
                    }
                },
                "alphaMode": "BLEND",
            },
            Material("old", (0.1, 0.2, 0.3), glossy=(0.25, 0.5, 0.125), roughness=0.25, alpha=0.5),
            None,
        ),
        (
            {"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.2}},
            Material("material_0", (1.0,) * 3, glossy=COAT, roughness=0.2),
            None,
        ),
        (
            {"pbrMetallicRoughness": {"metallicFactor": 0.5, "baseColorFactor": [0.6, 0.4, 0, 1]}},
            Material(
                "material_0",
                (0.3, 0.2, 0.0),
                glossy=(0.3 + COAT / 2, 0.2 + COAT / 2, COAT / 2),
                covering=COAT,
                roughness=1.0,
            ),
            None,
        ),
        (
            {"pbrMetallicRoughness": MATTE, "alphaMode": "BLEND"},
            Material("material_0", (0.5,) * 3, glossy=COAT, roughness=1.0, alpha=0.4),
            None,
        ),
        (
            {"pbrMetallicRoughness": MATTE, "alphaMode": "MASK"},
            Material("material_0", (0.5,) * 3, glossy=COAT, roughness=1.0, alpha=0.0),
            None,
        ),
        (
            {"pbrMetallicRoughness": MATTE},
            Material("material_0", (0.5,) * 3, glossy=COAT, roughness=1.0),
            None,
        ),
        (
            {
                "pbrMetallicRoughness": MATTE,
                "extensions": {
                    "KHR_materials_ior": {"ior": 2.0},
                    "KHR_materials_specular": {"specularFactor": 0.5},
                    "KHR_materials_iridescence": {},
                },
            },
            Material("material_0", (0.5,) * 3, glossy=1 / 18, roughness=1.0),
            "KHR_materials_iridescence of 'material_0'",
        ),
        (GLASS, Material("material_0", 0.0, ior=1.4, tint=(0.9, 1.0, 1.0), roughness=0.4), None),
        (
            GLASS | {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0}}},
            Material("material_0", 0.0, ior=1.5, tint=(0.9, 1.0, 1.0), roughness=0.4, thin=True),
            None,
        ),
        (
            GLASS | {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5}}},
            Material(
                "material_0",
                (0.9, 1.0, 1.0),
                ior=1.5,
                tint=(0.9, 1.0, 1.0),
                transmission=0.5,
                glossy=COAT,
                roughness=0.4,
                thin=True,
            ),
            None,
        ),
        (
            {
                "pbrMetallicRoughness": MATTE,
                "extensions": {"KHR_materials_specular": {"specularColorFactor": [1, 0.5, 2]}},
            },
            Material("material_0", (0.5,) * 3, glossy=(COAT, COAT / 2, 2 * COAT), roughness=1.0),
            None,
        ),
        ({"name": "a", "otherTexture": {"index": 0}}, Material("a"), "otherTexture of 'a'"),
        ({"name": "a", "occlusionTexture": {"index": 0}}, Material("a"), None),
        ({"name": "a", "emissiveFactor": [0, 0, 1]}, Material("a", emission=(0, 0, 1)), None),
        (
            {
                "name": "a",
                "emissiveFactor": [0, 0, 1],
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 7}},
            },
            Material("a", emission=(0, 0, 7)),
            None,
        ),
        ({"name": "a", "emissiveFactor": [0, 0, 0]}, Material("a"), None),
        (
            {
                "name": "a",
                "pbrMetallicRoughness": {
                    "metallicFactor": 0,
                    "baseColorFactor": [0.5, 0.2, 0.1, 1],
                },
                "extensions": {
                    "KHR_materials_clearcoat": {
                        "clearcoatFactor": 1.0,
                        "clearcoatRoughnessFactor": 0.1,
                    }
                },
            },
            Material(
                "a", (0.5, 0.2, 0.1), glossy=COAT, roughness=1.0, coat=1.0, coat_roughness=0.1
            ),
            None,
        ),
        (
            {
                "name": "a",
                "pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0.5},
                "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5}},
            },
            Material("a", (0.0,) * 3, glossy=(1.0,) * 3, roughness=0.5, coat=0.5),
            None,
        ),
        (
            {"name": "a", "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1.0}}},
            Material("a"),
            "KHR_materials_clearcoat of 'a'",
        ),
        (
            {"name": "a", "extensions": {"KHR_materials_sheen": {"sheenRoughnessFactor": 1}}},
            Material("a"),
            None,
        ),
        (
            {"name": "a", "extensions": {"KHR_materials_sheen": {"sheenColorFactor": [0, 0.1, 0]}}},
            Material("a", sheen=(0.0, 0.1, 0.0), sheen_roughness=0.0),
            None,
        ),
        (
            {
                "name": "a",
                "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.5, 0.2, 0, 1]},
                "extensions": {
                    "KHR_materials_sheen": {
                        "sheenColorFactor": [0.9, 0.8, 0.7],
                        "sheenRoughnessFactor": 0.6,
                        "sheenRoughnessTexture": {"index": 7},
                    }
                },
            },
            Material(
                "a",
                (0.5, 0.2, 0.0),
                glossy=COAT,
                roughness=1.0,
                sheen=(0.9, 0.8, 0.7),
                sheen_roughness=0.6,
            ),
            "sheenRoughnessTexture of 'a'",
        ),
        (
            {
                "name": "a",
                "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.4},
                "extensions": {
                    "KHR_materials_sheen": {"sheenColorFactor": [0, 0.1, 0]},
                    "KHR_materials_clearcoat": {"clearcoatFactor": 0.5},
                },
            },
            Material("a", (1.0,) * 3, glossy=COAT, roughness=0.4, coat=0.5),
            "sheen (which brightens cloth where it is seen at grazing angles) of 'a'",
        ),
    ],
)
@pytest.mark.filterwarnings("default::photonmap.errors.SceneWarning")
def test_materials(read, build, recwarn, item, material, lost):
    build.primitive(more={"material": 0})
    build.tree["materials"] = [item, {"name": "unused", "emissiveFactor": [1, 1, 1]}]
    (mesh,) = read("a.glb", build.glb())
    assert mesh.material == material
    messages = [str(warning.message) for warning in recwarn]
    if lost is None:
        assert not messages
    else:
        (message,) = messages
        assert f"a.glb: not simulated: {lost}" in message


def test_meshes_share_materials(read, build):
    for index in (0, 1, 0, None, None):
        build.primitive(more={} if index is None else {"material": index})
    build.tree["materials"] = [{"name": "a"}, {"name": "b"}]
    meshes = read("a.glb", build.glb())
    assert [mesh.material.name for mesh in meshes] == ["a", "b", "a", "default", "default"]
    assert meshes[0].material is meshes[2].material
    assert meshes[3].material is meshes[4].material
    assert meshes[3].material == Material("default", 0.5)


def test_material_of_trimesh(read):
    box = trimesh.creation.box()
    box.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(
            name="red", baseColorFactor=[255, 0, 0, 255], metallicFactor=0.0, roughnessFactor=1.0
        )
    )
    (mesh,) = read("a.glb", box.export(file_type="glb"))
    assert mesh.material == Material("red", (1.0, 0.0, 0.0), glossy=COAT, roughness=1.0)


@pytest.mark.parametrize(
    ("key", "value", "wanted"),
    [
        ("baseColorFactor", [2, 0, 0, 1], "three numbers within"),
        ("baseColorFactor", [-1, 0, 0, 1], "three numbers within"),
        ("baseColorFactor", [0.5], "three numbers within"),
        ("baseColorFactor", ["x", 0, 0, 1], "three numbers within"),
        ("metallicFactor", 1.5, "a number from 0 to 1"),
        ("roughnessFactor", "rough", "a number from 0 to 1"),
    ],
)
def test_factors_out_of_range(read, build, key, value, wanted):
    build.primitive(more={"material": 0})
    surface = {"metallicFactor": 0, key: value}
    build.tree["materials"] = [{"name": "a", "pbrMetallicRoughness": surface}]
    with pytest.raises(InputError, match=rf"material 'a': {key} .* is not {wanted}.*; correct"):
        read("a.glb", build.glb())
