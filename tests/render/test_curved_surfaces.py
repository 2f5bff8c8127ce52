"""Sharing keeps the minima of indirect light on curved surfaces."""

import numpy as np
import pytest
import trimesh

import photonmap as pm
from photonmap.integrators import sampling_plan
from photonmap.integrators.photon_mapping import integrator

SIDE = 64
CENTRE = np.array([0.0, -0.3, 0.0])
"""Of what stands in the box."""
ON_BALL = slice(7, 11), slice(6, 10)
"""Blocks of 4×4 pixels, the ball's middle."""


def room_with_ball():
    """The Cornell box with a faceted ball in place of its blocks."""
    box = pm.scenes.cornell_box()
    walls = [mesh for mesh in box.meshes if not mesh.name.endswith("_box")]
    return pm.Scene([*walls, ball()], [], box.camera)


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


@pytest.mark.slow
@pytest.mark.parametrize("make", [ball, cylinder, saddle])
def test_curved_things_are_as_paths_say(make):
    """No block of 4×4 pixels is off by 2% and three standard errors, against path tracing."""
    box = pm.scenes.cornell_box()
    walls = [mesh for mesh in box.meshes if not mesh.name.endswith("_box")]
    camera = pm.Camera(box.camera.origin, tuple(CENTRE), fov=13.0)
    scene = pm.Scene([*walls, make()], [], camera)
    options = {"bands": "rgb", "size": (24, 24), "threads": 2}
    photons = pm.render(scene, seed=3, passes=48, **options)
    paths = pm.render(scene, seed=4, method="path", passes=2000, **options)

    def means(image):
        return image.reshape(6, 4, 6, 4, 3).mean(axis=(1, 3, 4), dtype=float)

    truth = means(paths.indirect)
    # Neighbours' errors may be one and the same where they share.
    own = means(paths.errors["indirect"] ** 2) / 16
    variance = means(photons.errors["indirect"] ** 2) + own
    off = np.abs(means(photons.indirect) - truth)
    assert np.sqrt(own).max() < 0.02 * truth.max()
    assert (off <= 0.02 * truth + 3.0 * np.sqrt(variance)).all()
