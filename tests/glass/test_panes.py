"""Thin glass against Fresnel's equations, a sun through a window, and the path tracer."""

import math

import numpy as np
import pytest

import photonmap as pm
from photonmap.kernels.geometry.pane import pane_reflectance

COLOR = (0.8, 0.5, 0.2)
BOX = pm.scenes.cornell_box()


def once(cosine, index):
    """Return what one surface reflects, by Fresnel's equations as they stand in books."""
    inside = math.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    parallel = (index * cosine - inside) / (index * cosine + inside)
    perpendicular = (cosine - index * inside) / (cosine + index * inside)
    return 0.5 * (parallel**2 + perpendicular**2)


def square(height, half, material, name, tilt=0.0):
    x, z = half * math.cos(tilt), half * math.sin(tilt)
    corners = [[-x, height - z, half], [x, height + z, half], [x, height + z, -half]]
    corners.append([-x, height - z, -half])
    return pm.Mesh(np.array(corners), [[0, 1, 2], [0, 2, 3]], material, name)


def over_floor(pane, light, camera=None):
    floor = square(0.0, 1.0, pm.Material("floor", 0.5), "floor")
    window = square(1.0, 4.5, pane, "window")
    camera = camera or pm.Camera((0, 0.5, 0), (0, 0, 0), up=(0, 0, 1), fov=40)
    return pm.Scene([floor, window], [light], camera)


@pytest.mark.parametrize("degrees", [0.0, 40.0, 75.0, 89.0])
def test_a_pane_reflects_a_geometric_series(degrees):
    """R + T² R + T² R³ + …, where T = 1 - R."""
    cosine = math.cos(math.radians(degrees))
    r = once(cosine, 1.5)
    series = r + sum((1.0 - r) ** 2 * r ** (2 * k + 1) for k in range(2000))
    assert pane_reflectance(1.5, cosine) == pytest.approx(series, rel=1e-9)
    assert pane_reflectance(1.5, -cosine) == pane_reflectance(1.5, cosine)


def test_the_sun_through_a_window():
    """What all bands have in common is direct light with a sharp shadow, the rest a caustic."""
    angle = math.radians(70.0)
    sun = pm.DirectionalLight((-math.sin(angle), -math.cos(angle), 0.0), 2.0)
    scene = over_floor(pm.Material.pane("window", 1.5, COLOR), sun)
    settings = {"bands": "rgb", "size": 96, "passes": 28, "photons": 9000, "seed": 4}
    # Without indirect light, these buffers have the same bits in two thirds of the time.
    result = pm.render(scene, effects="direct,specular,transmission,caustics", **settings)
    passed = 2.0 * math.cos(angle) * (1.0 - pane_reflectance(1.5, math.cos(angle)))
    direct, caustics = (result[name].mean(axis=(0, 1)) * math.pi for name in ("direct", "caustics"))
    np.testing.assert_allclose(
        direct, 0.5 * passed * min(COLOR), rtol=0.015
    )  # four standard deviations
    np.testing.assert_allclose(direct + caustics, 0.5 * passed * np.array(COLOR), rtol=0.015)


@pytest.mark.parametrize("tint", [1.0, COLOR])
@pytest.mark.parametrize("method", ["photon", "path"])
def test_a_window_before_the_sky(method, tint):
    """A camera sees the sky through it, dimmed, and the sky of its own side in it."""
    camera = pm.Camera((0, 3.0, 0), (0, 0, 0), up=(0, 0, 1), fov=1)
    window = square(0.0, 5.0, pm.Material.pane("window", 1.5, tint), "window", 0.9)
    scene = pm.Scene([window], [pm.DomeLight(1.0)], camera)
    settings = {"bands": "rgb", "size": (32, 32), "photons": 100, "seed": 5}
    result = pm.render(scene, **settings, passes=64, method=method)
    reflected = pane_reflectance(1.5, math.cos(0.9))
    wanted = reflected + (1.0 - reflected) * np.ones(3) * tint
    np.testing.assert_allclose(
        result.emission.mean(axis=(0, 1)), wanted, rtol=0.012
    )  # four standard deviations


def test_what_is_left_out():
    """Without transmission a pane is black, and without cut-outs it stays a pane."""
    sun = pm.DirectionalLight((0.0, -1.0, 0.0), 2.0)
    scene = over_floor(pm.Material.pane("window"), sun)
    settings = {"bands": "rgb", "size": (8, 8), "passes": 4}
    whole = pm.render(scene, **settings)
    with pytest.warns(pm.SceneWarning, match="sends nothing into the view"):
        no_glass = pm.render(scene, effects=["direct"], **settings)
    no_holes = pm.render(scene, effects=["direct", "specular", "transmission"], **settings)
    assert whole.record["effects"]["transmission"]["on"]
    assert not whole.record["effects"]["alpha"]["on"]
    assert not no_glass.radiance.any()
    assert no_holes.direct.mean() == pytest.approx(whole.direct.mean(), rel=0.02)


def test_buffers_of_the_first_hit():
    window = square(0.0, 5.0, pm.Material.pane("window", 2.0, 0.0), "window")
    camera = pm.Camera((0, 3.0, 0), (0, 0, 0), up=(0, 0, 1), fov=10)
    scene = pm.Scene([window], [pm.DomeLight(1.0)], camera)
    names = ["radiance", "specular_reflectance", "roughness", "metallic", "diffuse_fraction"]
    result = pm.render(scene, bands="rgb", size=(4, 4), passes=2, buffers=names)
    np.testing.assert_allclose(result.specular_reflectance, 2 / 9 / (1 + 1 / 9), rtol=1e-6)
    for name in names[2:]:
        assert not result[name].any()


@pytest.mark.parametrize(
    ("material", "message"),
    [
        (pm.Material("m", 0.5, thin=True), "'m' is thin but no glass; give it an ior"),
        (pm.Material("m", 0.0, ior=1.5, thin=2), "thin: 2 is not a flag; give true or false"),
    ],
)
def test_bad_panes(material, message):
    scene = over_floor(material, pm.DomeLight(1.0))
    with pytest.raises(pm.InputError, match=message):
        pm.render(scene, bands="rgb", size=(4, 4), passes=1)


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_panes(tmp_path, suffix):
    scene = over_floor(pm.Material.pane("window", 1.4, COLOR), pm.PointLight((0, 3, 0), 1.0))
    pm.save_scene(scene, tmp_path / f"scene{suffix}")
    written = tmp_path / f"scene{suffix}"
    window = next(m for m in pm.load_scene(written).meshes if m.name == "window").material
    assert (window.thin, window.ior) == (True, pytest.approx(1.4))
    found = pm.Bands.rgb().reflectance(window.tint)
    np.testing.assert_allclose(found, COLOR, rtol=1e-6)
