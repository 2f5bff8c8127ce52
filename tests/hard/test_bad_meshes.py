"""Bad meshes: what exporters write must not change the light."""

import os
import warnings
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from cases import assert_mean, assert_same, means, means_of, rendered
from helpers.scenes import GREY, quad

import photonmap as pm

BOX = pm.scenes.cornell_box()
TRIANGLES = int(os.environ.get("PHOTONMAP_TRIANGLES", "20000"))
"""Of the largest mesh; 5 million in long runs."""


def with_floor(*meshes):
    """The Cornell box on another floor."""
    others = [mesh for mesh in BOX.meshes if mesh.name != "floor"]
    return replace(BOX, meshes=[*others, *meshes])


def floor_of(vertices, faces, name="floor"):
    """A floor of the Cornell box's material, in its plane: vertices (x, z)."""
    points = np.array(vertices, float)
    points = np.stack([points[:, 0], np.full(len(points), -1.0), points[:, 1]], axis=1)
    white = next(mesh.material for mesh in BOX.meshes if mesh.name == "floor")
    return pm.Mesh(points, faces, white, name)


def strips(edges):
    """A floor in strips along z between the given x."""
    vertices = [(x, z) for x in edges for z in (-1.0, 1.0)]
    faces = []
    for i in range(0, 2 * len(edges) - 2, 2):
        faces += [[i, i + 1, i + 3], [i, i + 3, i + 2]]
    return floor_of(vertices, faces)


def floors():
    """The same floor, tiled badly."""
    edges = np.linspace(-1.0, 1.0, 9)
    slivers = np.sort(np.concatenate([edges, edges[1:-1] + 1e-6]))
    needles = np.array([[-1.0 + 2e-6 * i, -1.0] for i in range(40)] + [[-1, 1.0], [1, -1], [1, 1]])
    faces = [[i, 40, i + 1] for i in range(39)] + [[39, 40, 42], [39, 42, 41]]
    return {
        "slivers": strips(slivers),
        "needles": floor_of(needles, faces),
        "T-junctions": floor_of(
            [(-1, -1), (-1, 1), (1, 1), (1, -1), (1, 0.1), (1, -0.3)],
            [[0, 1, 2], [0, 2, 4], [0, 4, 5], [0, 5, 3]],
        ),
        "cracks": floor_of(
            [(-1, -1), (-1, 1), (1e-7, 1), (1e-7, -1), (2e-7, -1), (2e-7, 1), (1, 1), (1, -1)],
            [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
        ),
        "wound both ways, with stray vertices": floor_of(
            [(-1, -1), (-1, 1), (1, 1), (1, -1), (1e9, 1e9), (-1e9, 3e8)], [[0, 2, 1], [0, 2, 3]]
        ),
    }


@pytest.fixture(scope="module")
def good():
    """Means of the box as it is."""
    return means_of(BOX)


@pytest.mark.parametrize("name", floors())
def test_how_a_floor_is_tiled_does_not_matter(name, good):
    found = means_of(with_floor(floors()[name]))
    for buffer in ("direct", "indirect"):
        assert_same(found[buffer], good[buffer], slack=5e-3)


def test_triangles_without_area_are_left_out(good):
    floor = next(mesh for mesh in BOX.meshes if mesh.name == "floor")
    faces = np.concatenate([floor.faces, [[0, 0, 1], [2, 2, 2], [0, 1, 1]]])
    scene = with_floor(replace(floor, faces=faces))
    with pytest.warns(pm.SceneWarning, match="3 degenerate triangles"):
        values = means(scene, "indirect")
    assert_same(values, good["indirect"])


@pytest.mark.parametrize("size", [1e-16, 1e-19, 1e-22, 1e-30])
def test_triangles_too_small_to_be_met_are_left_out(size):
    """A speck at the scene's centre that also shines, and a light that touches it."""
    corners = size * np.array([[-1.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    speck = pm.Mesh(corners, [[0, 1, 2]], pm.Material("speck", 0.5, 1.0), "speck")
    lights = [pm.PointLight((0.0, size / 3, size), 1.0)]
    scene = replace(BOX, meshes=[*BOX.meshes, speck], lights=lights)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pm.SceneWarning)
        rendered(scene)


@pytest.mark.parametrize("turned", [False, True])
def test_surfaces_that_are_there_twice_count_once(turned, good):
    """A room whose every mesh is doubled, the copies wound like the originals or inversely."""
    copies = [
        replace(mesh, faces=np.roll(mesh.faces, 1, axis=1)[:, :: -1 if turned else 1])
        for mesh in BOX.meshes
        if not turned or mesh.name != "light"
    ]
    scene = replace(BOX, meshes=[*BOX.meshes, *copies])
    with pytest.warns(pm.SceneWarning, match="triangles that coincide with others"):
        found = means_of(scene)
    for buffer in ("direct", "indirect"):
        assert_same(found[buffer], good[buffer])


def test_coplanar_overlapping_floors(good):
    """Two floors in one plane, tiled differently, of one material: light goes to either."""
    floor = next(mesh for mesh in BOX.meshes if mesh.name == "floor")
    other = floor_of([(-0.9, -1), (-1, 1), (0.8, 1)], [[0, 1, 2]], "rug")
    found = means_of(with_floor(floor, other))
    assert_same(found["direct"], good["direct"], slack=5e-3)
    assert_same(found["indirect"], good["indirect"], slack=0.05)


def test_a_fan_of_walls_on_one_edge():
    """Eleven half-planes meet in one edge."""
    turns = np.linspace(0.0, 2.0 * np.pi, 11, endpoint=False)
    rim = np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
    vertices = np.concatenate([[[0, 0, -1.0], [0, 0, 1.0]], rim - [0, 0, 1], rim + [0, 0, 1]])
    faces = [[0, 1, 13 + i] for i in range(11)] + [[0, 13 + i, 2 + i] for i in range(11)]
    scene = pm.Scene(
        [pm.Mesh(vertices, faces)], [pm.DomeLight()], pm.Camera((0.4, 0.6, 4), (0, 0, 0), fov=40)
    )
    values, wanted = (means(scene, "indirect", method=method) for method in ("photon", "path"))
    assert_same(values, wanted, slack=5e-3)


def test_bodies_that_cut_each_other():
    body = trimesh.creation.box((1.0, 1.0, 1.0))
    turn = trimesh.transformations.rotation_matrix(0.6, [1, 2, 3])[:3, :3]
    meshes = [
        pm.Mesh(body.vertices, body.faces, GREY, "one"),
        pm.Mesh(body.vertices @ turn.T + 0.3, body.faces, GREY, "other"),
        quad((-2, -0.4, -2), (-2, -0.4, 2), (2, -0.4, 2), (2, -0.4, -2), GREY, "floor"),
    ]
    light = pm.PointLight((1.0, 3.0, 2.0), 5.0)
    scene = pm.Scene(meshes, [light], pm.Camera((1, 2, 4), (0, 0, 0)))
    values, wanted = (means(scene, "indirect", method=method) for method in ("photon", "path"))
    assert_same(values, wanted, slack=0.01)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_one_triangle(side):
    """Under a sky of 1 it reflects its albedo, on both sides."""
    mesh = pm.Mesh([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], [[0, 1, 2]], pm.Material("t", 0.3))
    scene = pm.Scene([mesh], [pm.DomeLight()], pm.Camera((0, 0, 3 * side), (0, 0, 0), fov=10))
    found = means_of(scene)
    assert not found["indirect"].any()
    assert_mean(found["direct"], 0.3 * np.ones(2))


def test_many_triangles():
    """A grid of many small triangles is the plane it lies in."""
    count = int(np.sqrt(TRIANGLES / 2))
    ticks = np.linspace(-1.0, 1.0, count + 1)
    x, z = np.meshgrid(ticks, ticks, indexing="ij")
    index = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, 1:],
                                            index[1:, :-1]))  # fmt: skip
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    scene = with_floor(floor_of(np.stack([x.ravel(), z.ravel()], axis=1), faces))
    values, wanted = (means(s, "indirect") for s in (scene, BOX))
    assert_same(values, wanted, slack=5e-3)
