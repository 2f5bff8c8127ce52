"""Flow and disparity against closed forms, and against rays."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.dataset.files.flow import Eye, compare_surfaces, find_targets, flow_of
from photonmap.dataset.jobs import flows
from photonmap.integrators.look import Onlooker

SIZE = (64, 48)
BUFFERS = ("distance", "object_id", "normal")
GREY = pm.Material("grey")


def quad(name, half, z=0.0):
    """Return a square about the z axis that faces +z."""
    corners = [(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)]
    return pm.Mesh(np.array(corners, float), np.array([[0, 1, 2], [0, 2, 3]]), GREY, name=name)


def between(meshes, first, second):
    """Return the flow between cameras by rays and by comparing surfaces, and what both see."""
    scene = pm.Scene(meshes, [pm.PointLight((0.0, 0.0, 9.0), 1.0)], first)
    onlooker = Onlooker(scene)
    here, there = (Eye.of(camera.describe(*SIZE), SIZE) for camera in (first, second))
    seen = [onlooker.see(camera, SIZE, BUFFERS) for camera in (first, second)]
    target = find_targets(here, there, seen[0]["distance"])
    by_rays = flow_of(here, there, target, flows.find_visible(target, here, there, onlooker))
    compared = compare_surfaces(target, seen[0]["object_id"], there, seen[1])
    return by_rays, flow_of(here, there, target, compared), seen, onlooker


def test_disparity_of_a_plane():
    """Focal length × baseline / depth, everywhere."""
    left, right = pm.Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), fov=45.0).stereo(0.2)
    found, compared, _, _ = between([quad("wall", 50.0)], left, right)
    focal = 0.5 * SIZE[1] / np.tan(np.radians(22.5))
    np.testing.assert_allclose(found.disparity, focal * 0.2 / 3.0, rtol=1e-5)
    np.testing.assert_allclose(found.flow[..., 1], 0.0, atol=1e-5)
    assert found.valid.all()
    x = np.arange(SIZE[0]) + 0.5 - focal * 0.2 / 3.0
    np.testing.assert_array_equal(found.inside, np.broadcast_to(x >= 0.0, found.inside.shape))
    np.testing.assert_array_equal(found.visible, found.inside)
    np.testing.assert_array_equal(compared.visible, found.inside)
    back = between([quad("wall", 50.0)], right, left)[0]
    np.testing.assert_allclose(back.disparity, focal * 0.2 / 3.0, rtol=1e-5)


def test_flow_of_a_plane_is_its_homography():
    """H = K' (R − t nᵀ / d) K⁻¹, between cameras that look at a plane at angles."""
    first = pm.Camera((0.3, -0.2, 3.0), (0.1, 0.2, 0.0), fov=40.0)
    second = pm.Camera((-0.9, 0.6, 2.2), (0.0, 0.0, 0.0), up=(0.2, 1.0, 0.0), fov=55.0)
    found, compared, _, _ = between([quad("wall", 50.0)], first, second)
    here, there = found.first, found.second
    rotation = there.axes @ here.axes.T
    shift = there.axes @ (here.origin - there.origin)
    normal, away = here.axes @ np.array([0.0, 0.0, 1.0]), -here.origin[2]
    plane = rotation + np.outer(shift, normal) / away
    matrix = there.matrix @ plane @ np.linalg.inv(here.matrix)
    at = np.concatenate([here.centers, np.ones((*here.centers.shape[:2], 1))], axis=-1) @ matrix.T
    expected = at[..., :2] / at[..., 2:] - here.centers
    np.testing.assert_allclose(found.flow, expected, atol=1e-3)
    np.testing.assert_array_equal(found.visible, found.inside)
    assert (compared.visible == found.visible).mean() > 0.999
    with pytest.raises(pm.InputError, match="parallel cameras"):
        _ = found.disparity


def test_what_a_square_hides():
    """Behind a square, the right camera misses a band as wide as the disparities differ."""
    left, right = pm.Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), fov=45.0).stereo(0.2)
    found, compared, _, _ = between([quad("wall", 50.0), quad("card", 0.4, z=1.0)], left, right)
    focal = 0.5 * SIZE[1] / np.tan(np.radians(22.5))
    band = focal * 0.2 * (1 / 2.0 - 1 / 3.0)
    row = found.occluded[SIZE[1] // 2]
    assert abs(row.sum() - band) <= 1.0
    edge = SIZE[0] / 2 + focal * (-0.4 + 0.1) / 2.0
    columns = np.flatnonzero(row)
    assert columns.max() < edge <= columns.max() + 1.51
    assert (compared.occluded[SIZE[1] // 2] == row).mean() > 0.98


@pytest.mark.parametrize("moved", [(0.3, 0.1, 3.7), (-0.8, 0.5, 3.0), (0.0, 0.0, 2.2)])
def test_points_are_found_again(moved):
    """Rays towards what is visible meet the same object, at the same point, and what is hidden is
    hidden by something nearer."""
    box = pm.scenes.cornell_box()
    first = pm.Camera((0.017, 0.009, 3.9), (0.0, 0.0, 0.0))  # no ray meets an edge
    second = pm.Camera(moved, (0.0, 0.0, 0.0), fov=50.0)
    found, compared, seen, onlooker = between(box.meshes, first, second)
    target = find_targets(found.first, found.second, seen[0]["distance"])
    ways = np.where(found.valid[..., None], target.points - found.second.origin, [0.0, 0.0, 1.0])
    origins = np.broadcast_to(found.second.origin, ways.shape)
    rays = pm.RayMap(np.concatenate([origins, ways], axis=-1))
    again = onlooker.see(pm.Camera(moved, (0.0, 0.0, 0.0), projection=rays), SIZE, BUFFERS)
    shown, length = found.visible, np.linalg.norm(ways, axis=-1)
    assert shown.mean() > 0.3
    same = again["object_id"] == seen[0]["object_id"]
    assert same[shown].mean() > 0.999
    np.testing.assert_allclose(again["distance"][shown], length[shown], rtol=2e-4)
    assert (again["distance"] < length)[found.occluded].all()
    assert (compared.visible == shown)[found.inside].mean() > 0.97


def test_flow_needs_pinholes():
    camera = pm.Camera((0, 0, 1), (0, 0, 0), projection=pm.Panorama()).describe(*SIZE)
    with pytest.raises(pm.InputError, match="of the kind panorama"):
        Eye.of(camera, SIZE)
    bent = pm.Intrinsics(fx=50.0, size=SIZE, distortion=(0.1,))
    with pytest.raises(pm.InputError, match="without distortion"):
        Eye.of(pm.Camera((0, 0, 1), (0, 0, 0), projection=bent).describe(*SIZE), SIZE)
