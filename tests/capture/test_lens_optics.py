"""Vignetting against its closed form; point spread conserves energy, and has its width."""

import numpy as np
import pytest
from renders import flat, ideal, render_of, scaled

import photonmap as pm
from photonmap.capture.optics import disk_weights, gaussian_weights, spread, vignette


@pytest.mark.parametrize(
    "projection", [None, pm.Intrinsics(fx=40.0, fy=50.0, cx=20.0, cy=9.0, size=(48, 32))]
)
def test_cos4_is_of_the_rays(projection):
    """cos⁴ of the angle between each pixel's ray, as the camera casts it, and the axis."""
    kind = {"fov": 70.0} if projection is None else {"projection": projection}
    camera = pm.Camera((1.0, 2.0, 3.0), (0.0, 2.5, 0.0), **kind)
    rays = pm.camera_rays(camera, (48, 32))[..., 3:]
    view = np.subtract(camera.target, camera.origin)
    cosine = rays @ view / np.linalg.norm(view) / np.linalg.norm(rays, axis=-1)
    found = vignette("cos4", (48, 32), camera.describe(48, 32))
    np.testing.assert_allclose(found, cosine**4, rtol=1e-9)


def test_vignetting_of_a_photo():
    record = {"camera": pm.Camera((0, 0, 1), (0, 0, 0), fov=60.0).describe(33, 33)}
    result = render_of(np.ones((33, 33, 1)), **record)
    photo = pm.expose(result, scaled(ideal(vignetting="cos4"), 5000.0))
    centre, corner = photo.truth[16, 16, 0], photo.truth[0, 0, 0]
    tangent = 2 * (16 / 16.5 * np.tan(np.radians(30.0))) ** 2
    assert centre == pytest.approx(0.5, rel=1e-6)
    assert corner / centre == pytest.approx(1 / (1 + tangent) ** 2, rel=1e-6)


def test_vignetting_by_a_polynomial():
    found = vignette("-0.5,0.25", (4, 4), {})
    squared = np.array([[4.5, 2.5], [2.5, 0.5]]) / 8.0
    np.testing.assert_allclose(found[:2, :2], 1 - 0.5 * squared + 0.25 * squared**2)
    with pytest.raises(pm.InputError, match="falls to -"):
        vignette("-2", (4, 4), {})


@pytest.mark.parametrize(
    "psf", ["gaussian:0.3", "gaussian:2", "defocus:0.8", "defocus:3.3", "gaussian:1+defocus:2"]
)
def test_point_spread_conserves_energy(psf):
    rng = np.random.Generator(np.random.PCG64(5))
    image = rng.random((23, 31, 2)) ** 8
    blurred = spread(image, psf)
    np.testing.assert_allclose(blurred.sum(axis=(0, 1)), image.sum(axis=(0, 1)), rtol=1e-12)
    assert blurred.min() >= 0.0
    assert blurred.var() < image.var()
    np.testing.assert_allclose(spread(np.full((9, 9, 1), 3.0), psf), 3.0, rtol=1e-12)


@pytest.mark.parametrize("sigma", [0.2, 0.8, 3.0])
def test_gaussian_has_its_width(sigma):
    """The variance of a Gaussian integrated over pixels is σ² + 1/12, where pixels resolve it."""
    weights = gaussian_weights(sigma)
    at = np.arange(len(weights)) - len(weights) // 2
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)
    if sigma > 0.5:
        assert weights @ at**2 == pytest.approx(sigma**2 + 1 / 12, rel=2e-3)


@pytest.mark.parametrize("radius", [0.3, 0.5, 1.0, 2.7, 6.0])
def test_disk_has_its_width(radius):
    """The second moment of a disk is R²/4 along an axis, and pixels add about 1/12."""
    weights = disk_weights(radius)
    np.testing.assert_array_equal(weights, weights.T)
    np.testing.assert_array_equal(weights, weights[::-1])
    at = np.arange(len(weights)) - len(weights) // 2
    if radius >= 2:
        assert (weights.sum(axis=0) @ at**2) == pytest.approx(radius**2 / 4 + 1 / 12, rel=0.02)


def test_spread_comes_before_the_mosaic():
    """A point between filters of one colour reaches them through the blur."""
    image = np.zeros((16, 16, 3))
    image[8, 8] = 1.0  # below a red filter of RGGB
    camera = "Nikon 5100 (NPL)"
    sharp, soft = (
        pm.expose(
            render_of(image, camera),
            pm.Sensor(camera=camera, time=1.0, read_noise=0.0, psf=psf, scale=1e-6, full_well=1e9),
        )
        for psf in ("none", "gaussian:1")
    )
    lit = soft.truth[..., 1] > 0
    assert lit.sum() > 40
    assert (sharp.truth[..., 1] > 0).sum() == 1
    np.testing.assert_allclose(soft.truth.sum(axis=(0, 1)), sharp.truth.sum(axis=(0, 1)), rtol=1e-5)


@pytest.mark.parametrize("kind", ["panorama", "fisheye"])
def test_cos4_needs_a_plane(kind):
    result = flat([1.0])
    result.record["camera"] = {"kind": kind, "intrinsics": None}
    with pytest.raises(pm.InputError, match=f"of the kind {kind}; choose none"):
        pm.expose(result, ideal(vignetting="cos4"))
