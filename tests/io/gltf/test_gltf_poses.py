"""Skins and morph targets of glTF files are read in the pose that the file states."""

import numpy as np
import pytest
from helpers.meshes import TRIANGLE

from photonmap.errors import InputError, SceneWarning

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
