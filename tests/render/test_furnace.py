"""Closed rooms have closed forms: what a furnace, a sphere and an open sky must look like."""

import numpy as np
import pytest
import trimesh
from helpers.comparisons import assert_within

import photonmap as pm

WAVELENGTHS = np.array([400.0, 700.0])


def ramp(low, high):
    """A reflectance that differs in every band."""
    return pm.Spectrum(WAVELENGTHS, np.array([low, high]))


@pytest.mark.parametrize("method", ["photon", "path"])
@pytest.mark.parametrize("bands", [1, 6])
def test_furnace(furnace, bands, method):
    """Every point radiates L = Le + ρ L, so L = Le / (1 − ρ), of which ρ Le is direct."""
    scene = furnace(ramp(0.1, 0.8))
    result = pm.render(scene, bands=bands, size=(12, 12), passes=24, method=method, seed=3)
    rho = pm.Bands.gaussian(bands).reflectance(ramp(0.1, 0.8))

    def mean(buffer):
        return buffer.mean(axis=(0, 1), dtype=float)

    assert mean(result.emission) == pytest.approx(np.ones(bands), rel=1e-6)
    assert mean(result.direct) == pytest.approx(rho, rel=0.004)
    assert mean(result.radiance) == pytest.approx(1.0 / (1.0 - rho), rel=0.008)
    assert mean(result.shading) == pytest.approx(1.0 / (1.0 - rho), rel=0.008)
    np.testing.assert_allclose(result.reflectance, np.broadcast_to(rho, (12, 12, bands)), 1e-6)


@pytest.mark.parametrize("method", ["photon", "path"])
def test_sphere_lit_from_inside(method):
    """Indirect irradiance is Φρ / (A (1 − ρ)) everywhere; direct is I cos θ / r² of each facet."""
    sphere = trimesh.creation.icosphere(subdivisions=2)
    rho, intensity = 0.6, 2.0
    scene = pm.Scene(
        [pm.Mesh(sphere.vertices, sphere.faces[:, ::-1], pm.Material("shell", rho), "sphere")],
        [pm.PointLight((0.0, 0.0, 0.0), intensity)],
        pm.Camera((0.0, 0.0, 0.0), (0.3, 0.2, -1.0), fov=60.0),
    )
    result = pm.render(scene, bands=1, size=(16, 16), passes=16, photons=32768, method=method)
    flux = 4.0 * np.pi * intensity
    indirect = rho / np.pi * flux * rho / (sphere.area * (1.0 - rho))
    mean = result.indirect.mean(dtype=float)
    assert mean == pytest.approx(indirect, rel=0.01)
    # Each facet's own distance: E = I h / r³ with h its plane's distance from the centre.
    hits = result.distance[..., None] * 1.0
    cosine = np.abs((result.normal * directions(scene.camera, 16, 16)).sum(axis=2))
    direct = rho / np.pi * intensity * cosine / hits[..., 0] ** 2
    assert result.direct[..., 0].mean() == pytest.approx(direct.mean(), rel=2e-3)


def directions(camera, width, height):
    """Unit directions through the pixels' centres, (height, width, 3)."""
    view = np.subtract(camera.target, camera.origin)
    view = view / np.linalg.norm(view)
    right = np.cross(view, camera.up)
    right = right / np.linalg.norm(right)
    up = np.cross(right, view)
    half = np.tan(np.radians(camera.fov) / 2.0)
    y, x = np.mgrid[:height, :width] + 0.5
    rays = (
        view
        + ((2.0 * x - width) / height * half)[..., None] * right
        + ((height - 2.0 * y) / height * half)[..., None] * up
    )
    return rays / np.linalg.norm(rays, axis=2, keepdims=True)


def test_open_sky_lights_a_convex_body_evenly():
    """Nothing blocks the dome over the top of a block: E = π L there, and no light is indirect."""
    block = trimesh.creation.box(extents=(1.0, 1.0, 1.0))
    scene = pm.Scene(
        [pm.Mesh(block.vertices, block.faces, pm.Material("block", 0.4))],
        [pm.DomeLight(2.0)],
        pm.Camera((0.0, 3.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), fov=10.0),
    )
    result = pm.render(scene, bands=2, size=(8, 8), passes=16, photons=1000)
    assert_within(result.radiance, 0.8, result.standard_error("radiance"))
    assert (result.indirect == 0.0).all()
    assert (result.shading > 0.0).all()
