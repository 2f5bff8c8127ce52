"""Images: one pixel, one line, one pass, black, and all lamp."""

import numpy as np
import pytest
from cases import check, rendered
from helpers.scenes import GREY, balls_in_box, closed_box

import photonmap as pm

BOX = pm.scenes.cornell_box()
BALLS = balls_in_box()
VIEW = pm.Camera((0.3, 0.2, 0.8), (-0.2, -0.1, -1.0), fov=70.0)


@pytest.mark.filterwarnings("ignore:[0-9]* of [0-9]* photons were truncated")
@pytest.mark.filterwarnings("ignore:the camera sees nothing")  # 4096 times as wide as high
@pytest.mark.parametrize(
    ("size", "pixel"),
    [
        ((1, 1), "box"),
        ((1, 1), "center"),
        ((1, 4096), "center"),
        ((4096, 1), "box"),
        ((2, 3), "center"),
    ],
)
@pytest.mark.parametrize("scene", [BOX, BALLS], ids=["box", "balls"])
def test_any_size(size, scene, pixel):
    result = rendered(scene, size=size, pixel=pixel, passes=2)
    assert result.size == size


@pytest.mark.parametrize("size", [(1, 1), (1, 4096)])
def test_any_size_is_written_and_read(size, tmp_path):
    result = rendered(BOX, size=size, passes=2)
    result.save(tmp_path / "image.exr")
    again = pm.load_result(tmp_path / "image.exr")
    check(again)
    np.testing.assert_array_equal(again.radiance, result.radiance)


@pytest.mark.parametrize("method", ["photon", "path"])
def test_one_pass_has_no_errors(method):
    result = rendered(BOX, passes=1, method=method)
    assert not result.errors
    assert result.record["error"] is None
    with pytest.raises(ValueError, match="single pass"):
        result.standard_error("radiance")


def test_a_black_image(tmp_path):
    """Black walls around a lamp that is out of view."""
    lamp = pm.PointLight((0, 0.5, 0), 1.0)
    result = rendered(pm.Scene([closed_box(pm.Material("black", 0.0))], [lamp], VIEW))
    assert not result.radiance.any()
    assert result.shading.any()
    assert result.record["error"] == 0.0
    result.save(tmp_path / "black.exr")
    assert not result.preview().any()


@pytest.mark.parametrize("reflectance", [0.0, 0.5])
def test_an_image_of_lamps_alone(reflectance, tmp_path):
    result = rendered(pm.Scene([closed_box(pm.Material("w", reflectance, 2.0))], camera=VIEW))
    np.testing.assert_allclose(result.emission, 2.0, rtol=1e-6)
    result.save(tmp_path / "lamps.exr")


def test_an_empty_view():
    """Nothing but the sky, and nothing at all."""
    away = pm.Camera((0, 0, 5), (0, 0, 9))
    result = rendered(pm.Scene([closed_box(GREY)], [pm.DomeLight(2.0)], away))
    np.testing.assert_allclose(result.radiance, 2.0, rtol=1e-6)
    with pytest.warns(pm.SceneWarning, match="the camera sees nothing"):
        nothing = rendered(pm.Scene([closed_box(GREY)], [pm.PointLight((0, 0, 3))], away))
    assert not nothing.radiance.any()
