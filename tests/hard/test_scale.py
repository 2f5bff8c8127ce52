"""Scale and place: what a scene measures and where it stands must not matter."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from cases import assert_same, means, means_of, rendered
from helpers.marks import slow
from helpers.scenes import quad

import photonmap as pm

BOX = pm.scenes.cornell_box()
LAMP = pm.PointLight((0.0, 0.5, 0.0), (1.0, 0.8, 0.6))


def moved(scene, scale=1.0, turn=None, shift=0.0):
    """Return a scene scaled, then turned, then shifted; points light as brightly as before."""
    turn = np.eye(3) if turn is None else turn

    def place(points):
        return scale * np.asarray(points, float) @ turn.T + shift

    meshes = [replace(mesh, vertices=place(mesh.vertices)) for mesh in scene.meshes]
    lights = [
        replace(
            light,
            position=tuple(place(light.position)),
            intensity=tuple(scale**2 * np.array(light.intensity)),
        )
        for light in scene.lights
    ]
    camera = replace(
        scene.camera,
        origin=tuple(place(scene.camera.origin)),
        target=tuple(place(scene.camera.target)),
        up=tuple(turn @ scene.camera.up),
    )
    return pm.Scene(meshes, lights, camera, scene.name)


LIT = replace(BOX, lights=[LAMP])
"""The Cornell box under its lamp and a point."""


@pytest.mark.parametrize("scale", [1e-9, 1e9, *slow(1e-3, 1e6)])
def test_scale_does_not_matter(scale):
    unit, other = rendered(LIT), rendered(moved(LIT, scale))
    for buffer in ("direct", "indirect", "shading"):
        values, wanted = (x.buffers[buffer].mean(axis=(0, 1), dtype=float) for x in (other, unit))
        np.testing.assert_allclose(values, wanted, rtol=1e-4)
    np.testing.assert_allclose(other.depth, scale * unit.depth, rtol=1e-5)


def test_a_shift_by_ten_million_sizes_does_not_matter():
    """Coordinates have 16 digits, of which 7 go to the place."""
    shift = 2e7 * np.array([1.0, -0.7, 0.3])
    unit, other = rendered(LIT), rendered(moved(LIT, shift=shift))
    for buffer in ("direct", "indirect", "shading"):
        values, wanted = (x.buffers[buffer].mean(axis=(0, 1), dtype=float) for x in (other, unit))
        np.testing.assert_allclose(values, wanted, rtol=1e-4)


def test_a_turn_does_not_matter():
    turn = trimesh.transformations.rotation_matrix(0.7, [0.2, 0.5, -0.7])[:3, :3]
    assert_same(means(moved(LIT, turn=turn)), means(LIT), slack=2e-3)


def still_life(place, far):
    """A cube of 1 mm under a lamp of 2 mm, seen from 5 mm away; `far` blocks of 1 km, 10 km apart.

    Light from the lamp that comes by the blocks is less than 1e-9 of it.
    """
    place, grey = np.array(place, float), pm.Material("grey", 0.5)
    cube = trimesh.creation.box((1e-3, 1e-3, 1e-3))
    corners = np.array([(-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)])
    meshes = [
        pm.Mesh(cube.vertices + [0, 0.5e-3, 0] + place, cube.faces, grey, "cube"),
        quad(*(0.02 * corners + place), grey, "floor"),
        quad(*(1e-3 * corners[::-1] + [0, 3e-3, 0] + place), pm.Material("lamp", 0.0, 10.0)),
    ]
    for center in ([-5e3, 0, -5e3], [5e3, 0, -5e3], [5e3, 0, 5e3], [-5e3, 0, 5e3]) if far else ():
        block = trimesh.creation.box((1e3, 1e3, 1e3))
        meshes.append(pm.Mesh(block.vertices + center, block.faces, grey, "block"))
    camera = pm.Camera(place + [0.0, 2e-3, 5e-3], place + [0, 0.3e-3, 0], fov=40.0)
    return pm.Scene(meshes, camera=camera)


@pytest.mark.parametrize("place", [(4321.0, 100.0, -1234.0), *slow((0, 0, 0))])
def test_a_millimetre_in_ten_kilometres(place):
    """Near the camera, what is seen is what would be seen without the rest."""
    large, small = still_life(place, True), still_life(place, False)
    whole, part = rendered(large, size=(24, 24)), rendered(small, size=(24, 24))
    on_cube = part.object_id == 1
    assert on_cube.sum() > 20
    assert (on_cube != (whole.object_id == 1)).sum() <= 2
    np.testing.assert_allclose(whole.depth[on_cube], part.depth[on_cube], rtol=1e-4)
    values = means_of(large, size=(24, 24))
    # Cells of the small scene are of the cube's size: paths need none.
    wanted = means_of(small, size=(24, 24), method="path", passes=10)
    for buffer in ("direct", "indirect"):
        assert_same(values[buffer], wanted[buffer], slack=5e-3)


def test_what_is_lower_than_a_digit_of_the_scene_is_no_plane():
    """A cube of 0.1 mm on 10 km: light goes between it and the floor."""
    cube, floor = trimesh.creation.box((1e-4, 1e-4, 1e-4)), 5e3 * np.array([1.0, 0.0, 1.0])
    corners = [(-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)]
    meshes = [
        quad(*(floor * np.array(corners))),
        pm.Mesh(cube.vertices + [1e3, 0.5e-4, 0], cube.faces),
    ]
    camera = pm.Camera((1e3, 1e-3, 1e-3), (1e3, 0, 0))
    result = rendered(pm.Scene(meshes, [pm.DomeLight()], camera))
    assert result.record["effects"]["indirect"]["on"]
