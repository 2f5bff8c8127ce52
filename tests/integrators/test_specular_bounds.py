"""Spheres around specular surfaces: that they hold all, and follow what lies apart."""

import numpy as np
import pytest
import trimesh

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.integrators.photon_mapping import specular_bounds
from photonmap.integrators.photon_mapping.specular_bounds import bound_specular_surfaces

GLASS, PAPER = pm.Material.glass(), pm.Material("paper", 0.5)


def ball(centre, radius, material=GLASS, name="ball", subdivisions=3):
    sphere = trimesh.creation.icosphere(subdivisions, radius)
    sphere.apply_translation(centre)
    return pm.Mesh.from_trimesh(sphere, material, name)


def bounds_of(*meshes):
    """Return spheres in scene units, and the corners of all specular triangles."""
    scene = pm.Scene(
        list(meshes), [pm.PointLight((0.0, 9.0, 0.0))], pm.Camera((0, 0, 9), (0, 0, 0))
    )
    arrays = compile_scene(scene, pm.Bands.rgb())
    geometry = arrays.geometry
    of_material = arrays.specular.probability > 0.0
    corners = geometry.vertices[geometry.triangles[of_material[geometry.material]]]
    return bound_specular_surfaces(arrays), corners.reshape(-1, 3)


def assert_held(spheres, corners):
    distances = np.linalg.norm(corners[:, None] - spheres[:, :3], axis=2)
    assert (distances <= spheres[:, 3]).any(axis=1).all()


def test_one_ball_has_one_sphere():
    spheres, corners = bounds_of(ball((0, 1, 0), 1.0), ball((4, 1, 0), 1.0, PAPER, "paper"))
    assert len(spheres) == 1
    assert_held(spheres, corners)
    reach = np.linalg.norm(corners - spheres[0, :3], axis=1).max()
    assert spheres[0, 3] == pytest.approx(reach, rel=1e-3)


def test_balls_apart_have_a_sphere_each():
    centres = [(x, 0.3, z) for x in (-4, 0, 4) for z in (-4, 0, 3)]
    spheres, corners = bounds_of(*(ball(c, 0.3, name=f"ball {i}") for i, c in enumerate(centres)))
    assert len(spheres) == 9
    assert np.ptp(spheres[:, 3]) < 1e-3 * spheres[0, 3]
    assert_held(spheres, corners)


def test_many_things_share_the_spheres_there_are(monkeypatch):
    rng = np.random.default_rng(3)
    centres = rng.uniform(-3, 3, (40, 3))
    things = [ball(c, 0.05, name=f"{i}", subdivisions=1) for i, c in enumerate(centres)]
    spheres, corners = bounds_of(*things)
    assert len(spheres) == 40
    assert_held(spheres, corners)
    monkeypatch.setattr(specular_bounds, "MOST", 3)
    spheres, corners = bounds_of(*things)
    assert len(spheres) <= 3
    assert_held(spheres, corners)


def test_fine_meshes_are_bounded_by_boxes(monkeypatch):
    things = [ball((x, 0, 0), 0.5, name=f"{x}") for x in (-2, 2)]
    tight, _ = bounds_of(*things)
    monkeypatch.setattr(specular_bounds, "MANY", 100)
    spheres, corners = bounds_of(*things)
    assert len(spheres) == len(tight) == 2
    assert_held(spheres, corners)
    assert spheres[:, 3].max() < 1.2 * tight[:, 3].max()


def test_a_large_mirror_stays_whole():
    corners = [(-2, 0, 0), (2, 0, 0), (2, 3, 0), (-2, 3, 0)]
    mirror = pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], pm.Material.polished(mirror=0.9), "mirror")
    spheres, corners = bounds_of(mirror, ball((0, 1, 4), 1.0, PAPER, "paper"))
    assert len(spheres) == 1
    assert_held(spheres, corners)
