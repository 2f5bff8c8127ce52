"""Shapes of glTF files: colours of vertices, tangents, and poses by skins and morph targets."""

import base64

import numpy as np
import pytest
from helpers.meshes import TRIANGLE, areas
from scipy.spatial.transform import Rotation

import photonmap as pm
from photonmap.errors import InputError, SceneWarning
from photonmap.io.png import encode_png
from photonmap.io.readers.gltf.document import COPIES

COLORS = np.array([[0.25, 0.5, 1], [0, 1, 0.125], [1, 0.75, 0]])
MEAN = COLORS.mean(axis=0)
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]], "<f4")


def colored(build, colors=COLORS, material=None, normalized=True, **attributes):
    """Make a triangle with colours."""
    accessor = build.add(colors, **({"normalized": True} if normalized else {}))
    more = {} if material is None else {"material": 0}
    build.primitive(COLOR_0=accessor, more=more, **attributes)
    if material is not None:
        build.tree["materials"] = [{"name": "a", **material}]


def matte(metallic=0, **more):
    return {"pbrMetallicRoughness": {"metallicFactor": metallic, **more}}


@pytest.mark.parametrize(
    "values",
    [
        COLORS.astype("<f4"),
        np.rint(COLORS * 255).astype("u1"),
        np.rint(COLORS * 65535).astype("<u2"),
        np.c_[COLORS, np.ones(3)].astype("<f4"),
    ],
)
def test_types(read, build, values):
    values = np.c_[values, np.zeros(3, values.dtype)] if values.itemsize == 1 else values
    colored(build, values, matte(baseColorFactor=[0.5, 1, 0.25, 1]))
    (mesh,) = read("a.glb", build.glb())
    steps = 255 if values.itemsize == 1 else 65535
    np.testing.assert_allclose(mesh.colors, COLORS * [0.5, 1, 0.25], atol=0.51 / steps)


def test_without_a_material(read, build):
    colored(build)
    (mesh,) = read("a.glb", build.glb())
    np.testing.assert_array_equal(mesh.colors, COLORS)
    assert mesh.material.name == "default"
    np.testing.assert_allclose(mesh.material.reflectance, MEAN)


def test_colours_of_unused_vertices_do_not_count(read, build):
    colors = [*COLORS, [0, 0, 0]]
    colored(build, np.array(colors), POSITION=SQUARE, indices=[0, 1, 2])
    (mesh,) = read("a.glb", build.glb())
    np.testing.assert_array_equal(mesh.colors, COLORS)
    np.testing.assert_allclose(mesh.material.reflectance, MEAN)


def test_constant_colours_are_factors(read, build):
    """White, which many programs write, changes nothing."""
    colored(build, np.ones((3, 3)), matte(baseColorFactor=[0.5, 1, 0.25, 1]))
    colored(build, np.tile(COLORS[:1], (3, 1)), matte(baseColorFactor=[0.5, 1, 0.25, 1]))
    plain, tinted = read("a.glb", build.glb())
    assert plain.colors is None
    assert plain.material.reflectance == (0.5, 1.0, 0.25)
    assert tinted.colors is None
    np.testing.assert_allclose(tinted.material.reflectance, COLORS[0] * [0.5, 1, 0.25])


def test_opacity(read, build):
    rgba = np.c_[np.ones((3, 3)), [0.5] * 3]
    colored(build, rgba, matte(baseColorFactor=[1, 1, 1, 0.5]) | {"alphaMode": "BLEND"})
    (mesh,) = read("a.glb", build.glb())
    assert mesh.material.alpha == 0.25
    del build.tree["materials"][0]["alphaMode"]
    assert read("a.glb", build.glb())[0].material.alpha == 1.0


def test_opacity_that_varies(read, build):
    rgba = np.c_[COLORS, [0.25, 0.5, 0.75]]
    colored(build, rgba, matte() | {"alphaMode": "BLEND"})
    message = "not simulated: variation of opacity of vertices of 'a'$"
    with pytest.warns(SceneWarning, match=message):
        (mesh,) = read("a.glb", build.glb())
    assert mesh.material.alpha == 0.5
    np.testing.assert_array_equal(mesh.colors, COLORS)


def test_metals_have_the_mean(read, build):
    colored(build, COLORS, matte(0.25))
    with pytest.warns(SceneWarning, match="not simulated: variation of a metal's colour of 'a'$"):
        (mesh,) = read("a.glb", build.glb())
    np.testing.assert_allclose(mesh.colors, 0.75 * COLORS)
    np.testing.assert_allclose(mesh.material.glossy, 0.25 * MEAN + 0.75 * 0.04)


def test_textures_and_glass_have_the_mean(read, build, tmp_path):
    volume = {"KHR_materials_volume": {"thicknessFactor": 1}}
    glass = {"KHR_materials_transmission": {"transmissionFactor": 1}} | volume
    colored(build, COLORS, matte(roughnessFactor=0) | {"extensions": glass})
    message = "not simulated: variation of colours of vertices of 'a'$"
    with pytest.warns(SceneWarning, match=message):
        (mesh,) = read("a.glb", build.glb())
    assert mesh.colors is None
    np.testing.assert_allclose(mesh.material.tint, MEAN)
    pm.scene.images.write_image(np.ones((1, 1, 3)), tmp_path / "wood.exr")
    build.tree |= {"images": [{"uri": "wood.exr"}], "textures": [{"source": 0}]}
    build.tree["materials"] = [{"name": "a", **matte(baseColorTexture={"index": 0})}]
    with pytest.warns(SceneWarning, match=message):
        (mesh,) = read("a.glb", build.glb())
    assert mesh.colors is None
    np.testing.assert_allclose(mesh.material.reflectance.factor, MEAN)


def test_colours_of_another_shape(read, build):
    build.primitive(COLOR_0=TRIANGLE[:, :2])
    with pytest.raises(pm.InputError, match="COLOR_0 has the wrong shape"):
        read("a.glb", build.glb())


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


QUARTER = [0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)]
"""A quarter of a turn about z"""


@pytest.fixture
def bend(build):
    """A triangle on two bones: the second turns about z at (1, 0, 0), from where it was bound."""
    joints = np.array([[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]], "u1")
    weights = np.array([[1.0, 0, 0, 0], [1, 0, 0, 0], [0.5, 0.5, 0, 0]])
    normals = np.tile([0.0, 1.0, 0.0], (3, 1))
    build.primitive(JOINTS_0=joints, WEIGHTS_0=weights, NORMAL=normals, indices=[0, 1, 2])
    binds = np.tile(np.eye(4), (2, 1, 1))
    binds[1, 0, 3] = -1.0
    accessor = build.add(binds.transpose(0, 2, 1).reshape(2, 16))
    build.tree["accessors"][accessor]["type"] = "MAT4"
    build.tree["nodes"] = [
        {"mesh": 0, "skin": 0, "translation": [9.0, 9.0, 9.0]},
        {"translation": [0.0, 0.0, 5.0], "children": [2]},
        {"translation": [1.0, 0.0, 0.0], "rotation": QUARTER},
    ]
    build.tree["scenes"] = [{"nodes": [0, 1]}]
    build.tree["skins"] = [{"joints": [1, 2], "inverseBindMatrices": accessor}]
    return build


def test_skins_follow_their_bones(read, bend):
    """The node of the mesh does not move it: its bones do."""
    (mesh,) = read("a.glb", bend.glb())
    assert TRIANGLE.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    turned = np.array([0.0, -1.0, 5.0])  # (0, 1, 0) about (1, 0, 0)
    wanted = [[0, 0, 5], [1, 0, 5], (turned + [0, 1, 5]) / 2]
    np.testing.assert_allclose(mesh.vertices, wanted, atol=1e-6)
    slanted = np.array([-1.0, 1.0, 0.0]) / np.sqrt(2.0)
    np.testing.assert_allclose(mesh.normals, [[0, 1, 0], [-1, 0, 0], slanted], atol=1e-6)


def test_bones_that_mirror_leave_the_outside_outside(read, bend):
    """As nodes do; a skin is shown once, whatever instances its node asks for."""
    bend.tree["nodes"][1]["scale"] = [1.0, 1.0, -1.0]
    del bend.tree["nodes"][2]["rotation"]
    bend.tree["nodes"][0]["extensions"] = {COPIES: {"attributes": {"TRANSLATION": 0}}}
    with pytest.warns(SceneWarning, match=f"{COPIES} beside a skin of 'node'"):
        (mesh,) = read("a.glb", bend.glb())
    assert areas(mesh)[0, 2] < 0.0  # +z of the triangle is -z of the scene
    np.testing.assert_allclose(mesh.normals[0], [0, 1, 0], atol=1e-6)


def test_bones_beside_the_scene_count(read, bend):
    bend.tree["scenes"] = [{"nodes": [0]}]
    (mesh,) = read("a.glb", bend.glb())
    np.testing.assert_allclose(mesh.vertices[0], [0, 0, 5], atol=1e-6)


def test_skins_without_matrices_are_bound_at_the_origin(read, bend):
    del bend.tree["skins"][0]["inverseBindMatrices"]
    (mesh,) = read("a.glb", bend.glb())
    np.testing.assert_allclose(mesh.vertices[:2], [[0, 0, 5], [1, 1, 5]], atol=1e-6)


@pytest.mark.parametrize(
    "break_it",
    [
        lambda tree: tree["skins"][0].update(joints=[1]),
        lambda tree: tree["skins"][0].update(joints=[1, 7]),
        lambda tree: tree["nodes"][0].update(skin=3),
        lambda tree: tree["skins"][0].update(inverseBindMatrices=0),
    ],
)
def test_broken_skins(read, bend, break_it):
    break_it(bend.tree)
    with pytest.raises(InputError, match=r"a\.glb: (is damaged|names (nodes|skins))"):
        read("a.glb", bend.glb())


def test_morph_targets_have_the_weights_of_the_node_or_the_mesh(read, build):
    up, aside = (build.add(np.tile([row], (3, 1))) for row in ([0.0, 0, 1], [2.0, 0, 0]))
    build.primitive(more={"targets": [{"POSITION": up}, {"POSITION": aside}]}, indices=[0, 1, 2])
    build.tree["meshes"][0]["weights"] = [0.5, 0.0]
    build.tree["nodes"] = [{"mesh": 0}, {"mesh": 0, "weights": [0.0, 1.0]}]
    build.tree["scenes"] = [{"nodes": [0, 1]}]
    one, other = read("a.glb", build.glb())
    np.testing.assert_allclose(one.vertices, TRIANGLE + [0, 0, 0.5])
    np.testing.assert_allclose(other.vertices, TRIANGLE + [2, 0, 0])


def test_what_else_morph_targets_move_is_named(read, build):
    along = build.add(np.tile([1.0, 0.0], (3, 1)))
    build.primitive(TEXCOORD_0=np.ones((3, 2)), more={"targets": [{"TEXCOORD_0": along}]})
    build.tree["meshes"][0]["weights"] = [0.5]
    with pytest.warns(SceneWarning, match="morphing of 'TEXCOORD_0' of 'part'"):
        read("a.glb", build.glb())


def test_morph_targets_that_hold_only_what_moves(read, build):
    """A sparse accessor without a buffer view differs from zeros."""
    build.primitive(indices=[0, 1, 2])
    view = build.add(np.array([1], "<u2")), build.add(np.array([[0.0, 3.0, 0.0]]))
    build.tree["accessors"].append(
        {
            "count": 3,
            "type": "VEC3",
            "componentType": 5126,
            "sparse": {
                "count": 1,
                "indices": {"bufferView": view[0], "componentType": 5123},
                "values": {"bufferView": view[1]},
            },
        }
    )
    target = len(build.tree["accessors"]) - 1
    build.tree["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": target}]
    build.tree["meshes"][0]["weights"] = [1.0]
    (mesh,) = read("a.glb", build.glb())
    np.testing.assert_allclose(mesh.vertices, TRIANGLE + [[0, 0, 0], [0, 3, 0], [0, 0, 0]])
    build.tree["accessors"][target]["count"] = 10**12
    with pytest.raises(InputError, match="announces 1000000000000 rows without data"):
        read("a.glb", build.glb())


def test_incomplete_triangles_are_left_out(read, build):
    build.primitive(indices=[0, 1, 2, 0, 1])
    with pytest.warns(SceneWarning, match="not simulated: corners of incomplete triangles"):
        (mesh,) = read("a.glb", build.glb())
    assert len(mesh.faces) == 1


def test_emission_from_the_back_is_named(read, build):
    item = {"name": "lamp", "doubleSided": True, "emissiveFactor": [1, 1, 1]}
    build.primitive(indices=[0, 1, 2], more={"material": 0})
    build.tree["materials"] = [item]
    with pytest.warns(SceneWarning, match=r"emission from the back \(doubleSided\) of 'lamp'"):
        read("a.glb", build.glb())


@pytest.mark.filterwarnings("error")
def test_closed_surfaces_have_no_back(read, build):
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    build.primitive(POSITION=corners[np.ravel(faces)], more={"material": 0})  # no shared vertices
    build.tree["materials"] = [{"doubleSided": True, "emissiveFactor": [1, 1, 1]}]
    (mesh,) = read("a.glb", build.glb())
    assert len(mesh.faces) == 4


def test_nodes_share_the_triangles_of_a_mesh(read, build):
    build.primitive(TEXCOORD_0=TRIANGLE[:, :2], indices=[0, 1, 2])
    build.tree["nodes"] = [{"mesh": 0}, {"mesh": 0, "translation": [1.0, 0.0, 0.0]}]
    build.tree["scenes"] = [{"nodes": [0, 1]}]
    one, other = read("a.glb", build.glb())
    assert np.shares_memory(one.faces, other.faces)
    assert np.shares_memory(one.uv, other.uv)
    np.testing.assert_array_equal(other.vertices, one.vertices + [1.0, 0.0, 0.0])
