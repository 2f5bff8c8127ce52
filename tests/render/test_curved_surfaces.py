"""Sharing keeps the minima of indirect light on curved surfaces."""

import numpy as np
import trimesh

import photonmap as pm
from photonmap.integrators import sampling_plan
from photonmap.integrators.photon_mapping import integrator

SIDE = 64
ON_BALL = slice(7, 11), slice(6, 10)
"""Blocks of 4×4 pixels, the ball's middle."""


def room_with_ball():
    """The Cornell box with a faceted ball in place of its blocks."""
    box = pm.scenes.cornell_box()
    walls = [mesh for mesh in box.meshes if not mesh.name.endswith("_box")]
    sphere = trimesh.creation.uv_sphere(radius=0.42, count=[48, 96])
    vertices = sphere.vertices + np.array([0.0, -0.3, 0.0])
    return pm.Scene([*walls, pm.Mesh(vertices, sphere.faces)], [], box.camera)


def blocks(image):
    """Means over blocks of 4×4 pixels and over bands, on the ball."""
    return image.reshape(SIDE // 4, 4, SIDE // 4, 4, -1).mean(axis=(1, 3, 4))[ON_BALL]


def test_a_ball_is_as_without_sharing(monkeypatch):
    options = {"bands": "rgb", "size": (SIDE, SIDE), "passes": 48, "threads": 2}
    shared = pm.render(room_with_ball(), seed=3, **options)
    for module in sampling_plan, integrator:
        monkeypatch.setattr(module, "FOOTPRINT_PIXELS", 0.5)
    plain = pm.render(room_with_ball(), seed=4, **options)
    truth = blocks(plain.buffers["indirect"])
    # Neighbours' errors may be one and the same where they share.
    variance = blocks(shared.errors["indirect"] ** 2) + blocks(plain.errors["indirect"] ** 2) / 16
    off = np.abs(blocks(shared.buffers["indirect"]) - truth)
    assert (off <= 0.02 * truth + 3.0 * np.sqrt(variance)).all()
    assert np.abs(off / truth).mean() < 0.01
