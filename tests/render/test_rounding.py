"""Where nothing is sampled, standard errors are those of rounding: of closed forms in float64."""

from dataclasses import replace

import numpy as np
import pytest

import photonmap as pm

SIZE = 32, 24
UP = (0.0, 1.0, 0.0)
PLACE, TARGET = (0.3, 0.4, 0.2), (0.0, -0.7, 0.1)
LIGHTS = {
    "point": [pm.PointLight(PLACE, 1.0)],
    "point near the surface": [pm.PointLight((0.3, -0.65, 0.2), 1.0)],
    "spot": [pm.SpotLight(PLACE, TARGET, 1.0, inner=15.0, outer=50.0)],
    "spot with a narrow edge": [pm.SpotLight(PLACE, TARGET, 1.0, inner=24.0, outer=25.0)],
    "sun": [pm.DirectionalLight((0.3, -1.0, -0.4), 1.0)],
}
LIGHTS["each in turn"] = [light for lights in LIGHTS.values() for light in lights]
CORNERS = np.array([[-3.0, -0.7, -2.0], [0.1, -0.7, 3.0], [3.0, -0.7, -2.3]])
LEANING = np.array([[-0.4, 1.0, 0.2], [0.3, 1.0, -0.3], [0.1, 1.0, 0.5]])
"""Normals at the corners of a smooth surface"""


def turned(rows):
    """Turn vectors so that nothing is a round number."""
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    return np.asarray(rows) @ (turn * np.sign(np.linalg.det(turn))).T


def irradiance(light, points, normals):
    """The closed form at points, for an intensity or irradiance of 1."""
    if isinstance(light, pm.DirectionalLight):
        return normals @ -np.array(light.direction) / np.linalg.norm(light.direction)
    step = light.position - points
    distance = np.linalg.norm(step, axis=-1)
    arriving = (step * normals).sum(axis=-1) / distance**3
    if isinstance(light, pm.PointLight):
        return arriving
    axis = np.subtract(light.target, light.position)
    cosine = -(step @ axis) / distance / np.linalg.norm(axis)
    inner, outer = np.cos(np.radians([light.inner, light.outer]))
    t = np.clip((cosine - outer) / (inner - outer), 0.0, 1.0)
    return arriving * (3.0 - 2.0 * t) * t**2


@pytest.mark.parametrize("normals", [None, LEANING], ids=["flat", "smooth"])
@pytest.mark.parametrize("name", LIGHTS)
def test_errors_hold_where_nothing_is_sampled(name, normals):
    lights, corners = [], turned(CORNERS)
    for light in LIGHTS[name]:
        places = {"position", "target", "direction"} & vars(light).keys()
        there = {each: tuple(turned(getattr(light, each))) for each in places}
        lights.append(replace(light, name=str(len(lights)), **there))
    camera = pm.Camera(*map(tuple, turned([(0.5, 1.0, 2.0), TARGET, UP])), fov=20.0)
    mesh = pm.Mesh(
        corners,
        [[0, 1, 2]],
        pm.Material("grey", 0.5),
        normals=None if normals is None else turned(normals),
    )
    rays = pm.camera_rays(camera, SIZE).reshape(-1, 6)
    origins, directions = rays[:, :3], rays[:, 3:]
    advance = (corners[0] - origins) @ turned(UP) / (directions @ turned(UP))
    points = origins + advance[:, None] * directions
    sides = (corners[1:] - corners[0]).T
    u, v = np.linalg.lstsq(sides, (points - corners[0]).T, rcond=None)[0]
    normals = turned([UP] * 3 if normals is None else normals)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    along = np.stack([1.0 - u - v, u, v], axis=1) @ normals
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    truth = sum(np.maximum(irradiance(light, points, along), 0.0) for light in lights) / np.pi
    assert np.stack([u, v, 1.0 - u - v]).min() > 0.0
    result = pm.render(
        pm.Scene([mesh], lights, camera),
        bands=1, size=SIZE, passes=2, pixel="center", effects="direct",
    )  # fmt: skip
    lit = truth > 0.0
    scores = (result.shading.ravel() - truth)[lit] / result.standard_error("shading").ravel()[lit]
    assert np.sqrt(np.mean(scores**2)) <= 1.2
    assert np.abs(scores).max() <= 5.0
    assert lit.mean() > 0.3
