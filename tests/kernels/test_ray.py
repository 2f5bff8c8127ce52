"""Rays cast from kernels against geometry worked out by hand, and offsets against self-hits."""

import numpy as np
import pytest
import trimesh
from helpers.scenes import GREY

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.geometry import ray
from photonmap.kernels.geometry.embree import EmbreeScene
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.spectra.bands import Bands


@pytest.fixture
def triangle():
    return EmbreeScene(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), [[0, 1, 2]])


def test_a_hit_has_its_barycentrics(triangle):
    hit = ray.closest_hit(triangle.address, (0.25, 0.5, 2.0), (0.0, 0.0, -4.0))
    assert hit.triangle == 0
    assert hit[1:] == pytest.approx((0.25, 0.5, 0.5), rel=1e-6)


def test_a_miss(triangle):
    assert ray.closest_hit(triangle.address, (0.8, 0.8, 2.0), (0.0, 0.0, -1.0))[0] == -1
    assert ray.closest_hit(triangle.address, (0.2, 0.2, 2.0), (0.0, 0.0, 1.0))[0] == -1


@pytest.mark.parametrize(("length", "blocked"), [(1.9, False), (2.1, True), (np.inf, True)])
def test_occlusion_ends_with_the_ray(triangle, length, blocked):
    assert ray.any_hit(triangle.address, (0.2, 0.2, 2.0), (0.0, 0.0, -1.0), length) is blocked


def test_a_scene_without_triangles_is_empty():
    scene = EmbreeScene(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32))
    assert ray.closest_hit(scene.address, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))[0] == -1


@kernel
def count_self_hits(geometry, directions):
    """Leave each hit at a grazing angle; count rays that meet the triangle they leave."""
    count = 0
    for i in range(len(directions)):
        direction = vec.row(directions, i)
        hit = ray.closest_hit(geometry.scene, (0.0, 0.0, 0.0), direction)
        surface = surface_interaction(geometry, hit, direction)
        ng = surface.ng
        along = vec.normalize(vec.sub(direction, vec.scale(ng, vec.dot(direction, ng))))
        for angle in (1e-4, 1e-2, 1.0):
            away = vec.add(along, vec.scale(ng, angle))
            again = ray.closest_hit(geometry.scene, surface.point, away)
            count += again.triangle == hit.triangle
    return count


@pytest.mark.parametrize("shift", [0.0, 1000.0])
def test_no_ray_meets_the_triangle_that_it_leaves(shift):
    ball = trimesh.creation.icosphere(subdivisions=2)
    mesh = pm.Mesh(ball.vertices + shift, ball.faces, GREY)
    compiled = compile_scene(pm.Scene([mesh], [pm.DomeLight()]), Bands.rgb())
    directions = np.random.default_rng(4).normal(size=(50_000, 3))
    assert count_self_hits(compiled.geometry, directions) == 0


@kernel
def count_misses(scene, origins, targets):
    """Count rays that meet nothing on their way through points of a closed mesh."""
    count = 0
    for i in range(len(targets)):
        origin = vec.row(origins, i)
        hit = ray.closest_hit(scene, origin, vec.sub(vec.row(targets, i), origin))
        count += hit.triangle < 0
    return count


def test_no_ray_leaves_a_closed_mesh():
    """Robust traversal lets nothing through faces, and next to nothing aimed at edges."""
    ball = trimesh.creation.icosphere(subdivisions=5)
    scene = EmbreeScene(ball.vertices.astype(np.float32), ball.faces)
    rng = np.random.default_rng(5)
    n = 500_000
    corners = ball.vertices.astype(np.float32).astype(float)[rng.choice(ball.faces, n)]
    origins = 0.3 * rng.normal(size=(n, 3)).clip(-1.5, 1.5)
    anywhere = (corners * rng.dirichlet((1, 1, 1), n)[..., None]).sum(axis=1)
    assert count_misses(scene.address, origins, anywhere) == 0
    share = rng.random((n, 1))
    on_edges = corners[:, 0] * share + corners[:, 1] * (1 - share)
    assert count_misses(scene.address, origins, on_edges) < 1e-4 * n
