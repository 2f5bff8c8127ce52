"""Caustic photons connected to the camera, against small disks and closed forms."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from helpers.cameras import CAMERAS
from helpers.passes import setup_of
from helpers.scenes import GREY, quad
from scipy import stats

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.integrators.photon_mapping import caustics
from photonmap.integrators.photon_mapping.integrator import PhotonIntegrator
from photonmap.kernels.core.passes import CAUSTIC_IRRADIANCE, FIRST_CAUSTIC, VIA_CAUSTIC, Film, View
from photonmap.runtime.workers import Workers
from photonmap.spectra.bands import Bands

RADIUS = 0.02
"""Of disks too small to blur anything, in sizes of the scene."""
PASSES = 16
CAUSTICS_ALONE = SimpleNamespace(on=lambda effect: effect == "caustics")
"""A plan of effects in which no gather ray is traced."""
BULB = pm.PointLight((0.1, 0.9, 0.2), (1.0, 0.8, 0.6))
EYE = pm.Camera((0.2, 0.6, 2.6), (0.0, -0.5, 0.0), fov=50.0)


def sheet(height, material, half=0.9, tilt=0.0, uv=False, normals=None):
    """A horizontal square seen from above, tilted about z."""
    corners = [[-half, height, half], [half, height, half], [half, height, -half], [-half] * 3]
    corners[3][1], corners[3][2] = height, -half
    mesh = quad(*[(x, y + tilt * x, z) for x, y, z in corners], material, material.name)
    coordinates = mesh.vertices[:, [0, 2]] if uv else None
    return replace(mesh, uv=coordinates, normals=normals)


def checks(channels=3, low=0.1):
    texels = np.random.default_rng(3).uniform(low, 1.0, (6, 6, channels))
    return pm.Texture.of((255 * texels).astype(np.uint8))


def glass_ball():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.25)
    vertices = ball.vertices + (0.05, 0.1, 0.1)
    return pm.Mesh(vertices, ball.faces, pm.Material.glass(), "ball", ball.vertices / 0.25)


def leaning(mesh):
    """A flat mesh whose shading normals lean."""
    normals = np.array([(0.4, 1.0, 0.1), (-0.3, 1.0, 0.2), (0.1, 1.0, -0.5), (0.0, 1.0, 0.3)])
    return replace(mesh, normals=normals / np.linalg.norm(normals, axis=1, keepdims=True))


def room(camera=EYE):
    """A glass ball over floors of every kind, which show through the holes of the first.

    Textured with holes, rough diffuse with leaning normals, glossy, and with a mirror coat.
    """
    holes = pm.Material("holes", checks(), alpha=checks(channels=1, low=0.0))
    rough = pm.Material("rough", 0.6, diffuse_roughness=0.8)
    gloss = pm.Material.plastic("gloss", 0.4, roughness=0.4)
    coat = pm.Material("coat", (0.5, 0.3, 0.2), mirror=0.3)
    return pm.Scene(
        [
            glass_ball(),
            sheet(-0.35, holes, uv=True),
            leaning(sheet(-0.6, rough, half=0.5, tilt=0.3)),
            sheet(-0.8, gloss, half=0.7, tilt=-0.2),
            sheet(-1.1, coat, half=1.5),
        ],
        [BULB],
        camera,
    )


def passes(scene, seeds, threads=2, seed=1, photons=4000):
    """Rows of caustics that first hits reflect, their irradiance, and what BSDFs add, per pass."""
    film = Film(32, 24, True)
    compiled = compile_scene(scene, Bands.parse("rgb"))
    with Workers(threads) as workers:
        setup = setup_of(compiled, workers, film, photons, seed)
        integrator = PhotonIntegrator(replace(setup, effects=CAUSTICS_ALONE))
        images = []
        for index in range(seeds):
            estimate = integrator.estimate(index)
            rows = [FIRST_CAUSTIC, CAUSTIC_IRRADIANCE, VIA_CAUSTIC]
            images.append(estimate.via_specular[rows].astype(float))
    return np.array(images).reshape(seeds, 3, film.height, film.width, 3)


def blocks(images, side=8):
    """Means over blocks of pixels, of each pass: (passes, rows, blocks, bands)."""
    n, rows, height, width, bands = images.shape
    shape = (n, rows, height // side, side, width // side, side, bands)
    return images.reshape(shape).mean(axis=(3, 5)).reshape(n, rows, -1, bands)


def scores(images, others):
    """Differences of means in standard errors, where light came in several passes of both."""
    often = ((images != 0).sum(axis=0) > 5) & ((others != 0).sum(axis=0) > 5)
    variance = images.var(axis=0, ddof=1) / len(images) + others.var(axis=0, ddof=1) / len(others)
    return (images.mean(axis=0) - others.mean(axis=0))[often] / np.sqrt(variance[often])


def seen_by(projection):
    return replace(EYE, fov=pm.Camera.fov, projection=projection)


@pytest.mark.parametrize(
    "camera",
    [
        pytest.param(replace(EYE, fov=pm.Camera.fov, height=2.4), marks=pytest.mark.slow),
        seen_by(CAMERAS["Brown-Conrady"]["projection"]),
        seen_by(pm.Panorama()),
    ],
    ids=["orthographic", "distorted", "panorama"],
)
def test_connected_photons_bring_what_small_disks_bring(camera, monkeypatch):
    """On every kind of surface, through holes; densities of all cameras: `test_film_points`."""
    monkeypatch.setattr(caustics, "_first_radius", lambda positions, arriving: RADIUS)
    scene = room(camera)
    connected = passes(scene, PASSES)
    monkeypatch.setattr(caustics, "can_connect", lambda view: False)
    disks = passes(scene, 2 * PASSES, seed=2)
    assert (connected != disks[:PASSES]).any()
    local = scores(blocks(connected), blocks(disks))
    assert local.size >= 18
    assert np.abs(local).max() < stats.t.isf(1e-4 / local.size, PASSES - 1)
    whole = scores(connected.mean(axis=(2, 3)), disks.mean(axis=(2, 3)))
    assert whole.size == 9
    assert np.abs(whole).max() < stats.t.isf(5e-4, PASSES - 1)


def test_large_disks_are_replaced_only_where_pixels_are_larger(monkeypatch):
    """With disks larger than any pixel, nothing changes, bit for bit."""
    monkeypatch.setattr(caustics, "_first_radius", lambda positions, arriving: 0.3)
    large = passes(room(), 2, photons=300)
    monkeypatch.setattr(caustics, "can_connect", lambda view: False)
    np.testing.assert_array_equal(large, passes(room(), 2, photons=300))


def test_any_number_of_threads_gives_the_same_bits(monkeypatch):
    monkeypatch.setattr(caustics, "CONNECTED_BUNDLE", 100)
    one, three = (passes(room(), 2, threads=threads) for threads in (1, 3))
    assert one.any()
    np.testing.assert_array_equal(one, three)


def view_of(camera, jitter=True):
    compiled = compile_scene(pm.Scene([sheet(0.0, GREY)], [BULB], camera), Bands.parse("rgb"))
    return View(compiled.film_camera(8, 6), Film(8, 6, jitter))


@pytest.mark.parametrize(
    ("camera", "jitter", "wanted"),
    [
        (EYE, True, True),
        (EYE, False, False),
        (replace(EYE, lens=pm.Lens(2.0, 0.1)), True, False),
        (
            replace(EYE, fov=pm.Camera.fov, projection=pm.RayMap(pm.camera_rays(EYE, (8, 6)))),
            True,
            False,
        ),
        (seen_by(pm.Panorama()), True, True),
    ],
    ids=["pinhole", "center", "lens", "ray map", "panorama"],
)
def test_photons_are_connected_where_points_have_one_film_point(camera, jitter, wanted):
    assert caustics.can_connect(view_of(camera, jitter)) is wanted
