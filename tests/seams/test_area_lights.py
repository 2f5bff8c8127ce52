"""Area lights in scene files and in code."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.errors import InputError
from photonmap.spectra.names import light as named_light

TRIANGLE = pm.Mesh(np.eye(3), [[0, 1, 2]], name="floor")
PANEL = """
[[light]]
type = "area"
position = [1, 2, 3]
target = [1, 0, 3]
width = 0.5
height = 0.25
power = "D65 2"
name = "panel"
"""
DISK = """
[[light]]
type = "area"
position = [0, 0, 5]
target = [0, 3, 1]
radius = 0.5
radiance = [1, 2, 3]
"""


@pytest.fixture
def lit(tmp_path):
    """Load a triangle with lights, without those that the TOML replaces."""

    def lit(toml, suffix=".obj"):
        pm.save_scene(pm.Scene([TRIANGLE]), tmp_path / f"a{suffix}")
        (tmp_path / "a.toml").write_text(f'mesh = "a{suffix}"' + toml)
        return pm.load_scene(tmp_path / "a.toml")

    return lit


def _areas(mesh):
    """Half of the cross products of each triangle's edges."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a) / 2.0


def _flux(mesh, radiance):
    """W, of a Lambertian emitter, whose radiant exitance is π L."""
    return np.pi * radiance * np.linalg.norm(_areas(mesh), axis=1).sum()


def test_a_toml_adds_rectangles_and_disks(lit):
    scene = lit(PANEL + DISK)
    _, panel, disk = scene.meshes
    assert scene.lights == []
    assert (panel.name, panel.material.name, disk.name) == ("panel", "panel", "area")
    assert panel.material.reflectance == disk.material.reflectance == 0.0
    assert disk.material.emission == (1, 2, 3)
    d65 = named_light("D65")
    radiance = panel.material.emission.values / d65.values
    np.testing.assert_allclose(_flux(panel, radiance), 2.0, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(_areas(disk), axis=1).sum(), np.pi / 4.0, rtol=1e-12)


@pytest.mark.parametrize("up", [(0, 1, 0), (0, 0, 2), (1, 1, 0)])
@pytest.mark.parametrize("target", [(1, -5, 3), (1, 5, 3), (4, 2, 3), (2, 3, -4)])
@pytest.mark.parametrize("size", [{"width": 2, "height": 3}, {"radius": 2}])
def test_the_front_faces_the_target(target, up, size):
    light = pm.AreaLight((1, 2, 3), target, **size, up=up)
    mesh = pm.Scene([], light).meshes[0]
    ahead = np.subtract(target, (1, 2, 3)) / np.linalg.norm(np.subtract(target, (1, 2, 3)))
    np.testing.assert_allclose(_areas(mesh).sum(axis=0), light.area * ahead, atol=1e-12)
    np.testing.assert_allclose(mesh.vertices.mean(axis=0), (1, 2, 3), atol=1e-12)


def test_the_height_is_along_up():
    mesh = pm.AreaLight((0, 0, 0), (0, 0, 1), width=4, height=2, up=(0, 1, 7)).mesh()
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), (4, 2, 0), atol=1e-12)
    ceiling = pm.AreaLight((0, 1, 0), (0, 0, 0), width=4, height=2).mesh()
    np.testing.assert_allclose(np.ptp(ceiling.vertices, axis=0), (4, 0, 2), atol=1e-12)


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_area_lights_are_saved_as_meshes(lit, tmp_path, suffix):
    scene = lit(PANEL + DISK, suffix)
    path = tmp_path / "again" / f"b{suffix}"
    pm.save_scene(scene, path)
    again = {mesh.name: mesh for mesh in pm.load_scene(path).meshes}
    for mesh in scene.meshes[1:]:
        assert again[mesh.name].material.emission == mesh.material.emission
        np.testing.assert_allclose(
            _areas(again[mesh.name]).sum(axis=0), _areas(mesh).sum(axis=0), rtol=1e-5, atol=1e-7
        )


def test_in_code_names_are_made_and_amounts_default_to_one():
    lights = [pm.AreaLight((0, 1, 0), (0, 0, 0), radius=1, power=[np.pi, 2, 3]), pm.DomeLight()]
    lights.append(pm.AreaLight((0, 2, 0), (0, 0, 0), 1, 1))
    scene = pm.Scene([TRIANGLE], lights)
    assert scene.lights == [pm.DomeLight()]
    assert len(lights) == 3
    _, disk, square = scene.meshes
    assert (disk.material.name, square.material.name) == ("area", "area 2")
    np.testing.assert_allclose(disk.material.emission, np.array([np.pi, 2, 3]) / np.pi**2)
    assert square.material.emission == 1.0
    with pytest.raises(InputError, match="'grey'"):
        pm.Scene([TRIANGLE], pm.AreaLight((0, 1, 0), (0, 0, 0), 1, 1, name="grey"))


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        (DISK.replace("[0, 3, 1]", "[0, 0, 5]"), r":5: .*target .* is at the light's position"),
        (DISK.replace("radius = 0.5\n", ""), r":2: .*width is missing or 0; give width and height"),
        (DISK.replace("0.5", "0"), r":2: .*width is missing or 0; .*, or radius, above 0"),
        (DISK.replace("0.5", "-1"), r":6: .*radius: -1 is not a length; give scene units from 0"),
        (DISK + "width = 1\n", r":6: .*radius 0.5 is given beside width or height; leave out"),
        (DISK + "power = 1\n", r":8: .*power 1.0 is given beside radiance; leave out one"),
        (PANEL.replace("width = 0.5\n", ""), r":2: .*width is missing or 0"),
        (PANEL.replace("width", "breadth"), r":6: area light key 'breadth' is not known"),
        (PANEL.replace("target = [1, 0, 3]\n", ""), r":2: the area light lacks target; add"),
        (PANEL + PANEL, r"two lights are named 'panel'; give each its own name"),
    ],
)
def test_errors_name_their_line(lit, toml, message):
    with pytest.raises(InputError, match=r"a\.toml" + r".*" + message):
        lit(toml)
