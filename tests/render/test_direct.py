"""Direct light against form factors."""

import numpy as np
import pytest
from helpers.comparisons import assert_within
from helpers.scenes import quad

import photonmap as pm

FLOOR = pm.Material("floor", 0.8)
DOWN = pm.Camera((0.0, 3.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), fov=20.0)


def floor(half=5.0):
    return quad((-half, 0, half), (half, 0, half), (half, 0, -half), (-half, 0, -half), FLOOR)


@pytest.mark.parametrize("method", ["photon", "path"])
def test_point_over_plane(method):
    """E = I h / (h² + x²)^1.5 under a point light at height h."""
    height, intensity = 1.5, 3.0
    scene = pm.Scene([floor()], [pm.PointLight((0.0, height, 0.0), intensity)], DOWN)
    result = pm.render(
        scene, bands=1, size=(9, 9), pixel="center", passes=2, photons=10, method=method
    )
    half = 3.0 * np.tan(np.radians(10.0))
    y, x = (np.mgrid[:9, :9] + 0.5) / 9.0 * 2.0 * half - half
    truth = 0.8 / np.pi * intensity * height / (height**2 + x**2 + y**2) ** 1.5
    np.testing.assert_allclose(result.direct[..., 0], truth, rtol=2e-5)
    assert (result.indirect == 0.0).all()


def polygon_irradiance(point, normal, corners, radiance):
    """Lambert's formula: E = L/2 Σ θ_i Γ_i · n over the polygon's edges."""
    spokes = corners - point
    spokes /= np.linalg.norm(spokes, axis=1, keepdims=True)
    total = 0.0
    for a, b in zip(spokes, np.roll(spokes, -1, axis=0), strict=True):
        axis = np.cross(a, b)
        total += np.arccos(np.clip(a @ b, -1, 1)) * (axis / np.linalg.norm(axis)) @ normal
    return 0.5 * radiance * abs(total)


@pytest.mark.parametrize("method", ["photon", "path"])
@pytest.mark.parametrize("height", [0.2, 1.0, 2.5])
def test_polygon_over_plane(height, method):
    lamp = pm.Material("lamp", 0.0, 4.0)
    corners = np.array([[-0.7, height, -0.4], [0.6, height, -0.5], [0.5, height, 0.6]])
    mesh = pm.Mesh(corners, [[0, 1, 2]], lamp, "lamp")
    camera = pm.Camera((1.8, 0.5 * min(height, 1.0), 0.3), (0.2, 0.0, 0.1), fov=4.0)
    result = pm.render(
        pm.Scene([floor(), mesh], camera=camera),
        bands=1,
        size=(6, 6),
        pixel="center",
        passes=64,
        photons=10,
        method=method,
    )
    from test_furnace import directions

    origin = np.array(camera.origin)
    points = origin + result.distance[..., None] * directions(camera, 6, 6)
    truth = np.array(
        [[polygon_irradiance(p, np.array([0.0, 1.0, 0.0]), corners, 4.0) for p in row]
         for row in points.astype(float)]
    )  # fmt: skip
    shading, error = result.shading[..., 0], result.standard_error("shading")[..., 0]
    assert (result.emission == 0.0).all()
    assert_within(shading, truth / np.pi, error, sigmas=4.5, slack=1e-4)
    assert error.mean() < 0.05 * shading.mean()


@pytest.mark.parametrize("method", ["photon", "path"])
def test_a_lamp_in_the_middle_does_not_block_its_own_light(method):
    """Not even where shadow rays start far from it, and are rounded by more than at their ends."""
    lamp, black = pm.Material("lamp", 0.0, 4.0), pm.Material("black", 0.0)
    wall = quad((-4, 0, -4), (4, 0, -4), (4, 5, -4), (-4, 5, -4), black)
    panel = quad((-1, 2.5, -1), (1, 2.5, -1), (1, 2.5, 1), (-1, 2.5, 1), lamp, "lamp")
    camera = pm.Camera((0.0, 2.0, 3.9), (0.0, 0.0, 0.0), fov=50.0)
    scene = pm.Scene([floor(4.0), wall, panel], camera=camera)
    settings = {"bands": 1, "size": (12, 12), "pixel": "center", "passes": 16, "photons": 10}
    result = pm.render(scene, **settings, method=method)
    from test_furnace import directions

    points = np.array(camera.origin) + result.distance[..., None] * directions(camera, 12, 12)
    on_floor = np.abs(points[..., 1]) < 1e-4
    truth = [
        polygon_irradiance(point, np.array([0.0, 1.0, 0.0]), panel.vertices.astype(float), 4.0)
        for point in points[on_floor].astype(float)
    ]
    shading = result.shading[..., 0][on_floor]
    error = result.standard_error("shading")[..., 0][on_floor]
    assert on_floor.sum() > 50
    assert_within(shading, np.array(truth) / np.pi, error, sigmas=5.0, slack=2e-3)


def test_an_emitter_is_dark_from_behind():
    lamp = pm.Material("lamp", 0.5, 1.0)
    up = quad((-1, 1, 1), (1, 1, 1), (1, 1, -1), (-1, 1, -1), lamp, "lamp")
    scene = pm.Scene([floor(), up], camera=pm.Camera((0.0, 0.5, 4.0), (0, 0.2, 0), fov=20.0))
    with pytest.warns(pm.SceneWarning, match="light 'lamp' sends nothing into the view"):
        result = pm.render(scene, bands=1, size=(8, 8), passes=2)
    assert (result.radiance == 0.0).all()


def test_lights_add_up(empty_cornell):
    """Two lights are the sum of one and the other, within standard errors."""
    walls = [mesh for mesh in empty_cornell.meshes if mesh.name != "light"]
    lights = [pm.PointLight((0.4, 0.5, 0.2), 1.0, "a"), pm.PointLight((-0.5, 0.0, 0.3), 0.3, "b")]

    def render(chosen, seed):
        scene = pm.Scene(walls, chosen, empty_cornell.camera)
        return pm.render(scene, bands=3, size=(16, 16), passes=16, seed=seed)

    both, one, other = render(lights, 1), render(lights[:1], 2), render(lights[1:], 3)
    error = np.sqrt(
        sum(r.standard_error("radiance").astype(float) ** 2 for r in (both, one, other))
    )
    assert_within(both.radiance, one.radiance.astype(float) + other.radiance, error, 4.5, 0.003)
