"""Sharing keeps the minima of indirect light on curved surfaces."""

import numpy as np
import pytest
import trimesh

import photonmap as pm
from photonmap.integrators import sampling_plan
from photonmap.integrators.photon_mapping import integrator

CENTRE = np.array([0.0, -0.3, 0.0])
"""Of what stands in the box."""


def saddle():
    """Return z = 0.8 (x² - y²) over a square, one sheet seen from its front."""
    x, y = np.meshgrid(np.linspace(-0.45, 0.45, 49), np.linspace(-0.45, 0.45, 49))
    vertices = np.stack([x, y, 0.8 * (x * x - y * y)], axis=-1).reshape(-1, 3)
    corner = (np.arange(48)[:, None] * 49 + np.arange(48)).reshape(-1, 1)
    faces = np.concatenate([corner + [0, 1, 50], corner + [0, 50, 49]])
    return pm.Mesh(vertices + CENTRE, faces)


def cylinder():
    """Return one that stands on its end."""
    shape = trimesh.creation.cylinder(radius=0.4, height=0.9, sections=96)
    shape.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    return pm.Mesh(shape.vertices + CENTRE, shape.faces)


def ball():
    """Return a faceted ball."""
    shape = trimesh.creation.uv_sphere(radius=0.42, count=[48, 96])
    return pm.Mesh(shape.vertices + CENTRE, shape.faces)


def room_with(mesh):
    """The Cornell box with a mesh in place of its blocks, of which no more is seen."""
    box = pm.scenes.cornell_box()
    walls = [mesh for mesh in box.meshes if not mesh.name.endswith("_box")]
    return pm.Scene([*walls, mesh], [], pm.Camera(box.camera.origin, tuple(CENTRE), fov=13.0))


OPTIONS = {"bands": "rgb", "size": (24, 24), "threads": 2}


def blocks(image):
    """Means over blocks of 4×4 pixels."""
    return image.reshape(6, 4, 6, 4, 3).mean(axis=(1, 3), dtype=float)


def assert_as(result, truth):
    """Assert that no block is off by 2% and three standard errors; return how far blocks are."""
    wanted, own = blocks(truth.indirect), blocks(truth.errors["indirect"] ** 2) / 16
    # Neighbours' errors may be one and the same where they share.
    variance = blocks(result.errors["indirect"] ** 2) + own
    off = np.abs(blocks(result.indirect) - wanted)
    assert np.sqrt(own).max() < 0.02 * wanted.max()
    assert (off <= 0.02 * wanted + 3.0 * np.sqrt(variance)).all()
    return off / wanted


def test_a_ball_is_as_without_sharing(monkeypatch):
    scene = room_with(ball())
    shared = pm.render(scene, seed=3, passes=18, **OPTIONS)
    for module in sampling_plan, integrator:
        monkeypatch.setattr(module, "FOOTPRINT_PIXELS", 0.5)
    plain = pm.render(scene, seed=4, passes=40, **OPTIONS)
    assert assert_as(shared, plain).mean() < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("make", [ball, cylinder, saddle])
def test_curved_things_are_as_paths_say(make):
    scene = room_with(make())
    shared = pm.render(scene, seed=3, passes=48, **OPTIONS)
    assert_as(shared, pm.render(scene, seed=4, method="path", passes=2000, **OPTIONS))
