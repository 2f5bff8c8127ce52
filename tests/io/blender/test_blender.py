"""Scenes of Blender, exported by tools/blender_export.py, against pictures by Cycles."""

import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

import photonmap as pm

PYTHON = os.environ.get("PHOTONMAP_BPY") or (sys.executable if find_spec("bpy") else None)
WIDTH, HEIGHT, SAMPLES, BLOCK = 128, 96, 512, 16

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        PYTHON is None,
        reason="needs Blender as a module: pip install bpy, here or in another environment, whose "
        "python PHOTONMAP_BPY then names",
    ),
]


def run(*arguments):
    """Run Blender's Python; return what it prints on stderr."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    command = [PYTHON, "-W", "ignore", *map(str, arguments)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stderr


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Build, render and export both scenes; return their folder and the warnings."""
    folder = tmp_path_factory.mktemp("blender")
    script = Path(__file__).with_name("blender_scenes.py")
    return folder, {name: run(script, name, folder, SAMPLES, WIDTH) for name in ("room", "studio")}


def read_image(path):
    return OpenImageIO.ImageInput.open(str(path)).read_image("float")[..., :3]


def block_means(image):
    return image.reshape(HEIGHT // BLOCK, BLOCK, WIDTH // BLOCK, BLOCK, 3).mean(axis=(1, 3, 4))


@pytest.mark.filterwarnings("ignore:.*successive reflections")
@pytest.mark.parametrize(("name", "mean", "block"), [("room", 0.025, 0.06), ("studio", 0.02, 0.07)])
def test_pictures_match_those_of_cycles(exported, name, mean, block):
    folder, _ = exported
    wanted = read_image(folder / f"{name}_cycles.exr")
    scene = pm.load_scene(folder / f"{name}.glb")
    image = pm.render(scene, bands="rgb", size=(WIDTH, HEIGHT), error=0.04).radiance
    np.testing.assert_allclose(image.mean(axis=(0, 1)), wanted.mean(axis=(0, 1)), rtol=mean)
    np.testing.assert_allclose(block_means(image), block_means(wanted), rtol=block)


def test_what_is_lost_is_named(exported):
    _, warnings = exported
    assert "not exported" not in warnings["room"]
    assert "not exported" not in warnings["studio"]


def test_lights_and_cameras_follow_their_definitions(exported):
    folder, _ = exported
    scene = pm.load_scene(folder / "room.glb")
    (sun,), (spot,) = (
        [light for light in scene.lights if light.kind == kind] for kind in ("directional", "spot")
    )
    np.testing.assert_allclose(sun.irradiance, (8.0, 7.2, 5.6), rtol=1e-6)
    np.testing.assert_allclose(spot.intensity, 60.0 / (4.0 * np.pi), rtol=1e-6)
    assert spot.outer == pytest.approx(25.0)
    meshes = {mesh.material.name: mesh for mesh in scene.meshes}
    powers = {"panel": 40.0, "oval": 15.0, "bulb": 12.0}
    for name, power in powers.items():
        corners = meshes[name].vertices[meshes[name].faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2.0
        area = np.linalg.norm(normals, axis=1).sum()
        assert np.pi * area * meshes[name].material.emission[0] == pytest.approx(power, rel=1e-4)
    assert (normals[:, 1].sum(), meshes["panel"].vertices[0, 1]) == pytest.approx((0.0, 2.59))
    camera = scene.camera.projection
    assert camera.fx == pytest.approx(WIDTH * 22.0 / 36.0)
    assert camera.cx == pytest.approx(WIDTH * (0.5 - 0.05))
    assert camera.cy == pytest.approx(HEIGHT / 2.0 - 0.04 * WIDTH)


def test_a_sun_of_a_size_has_its_irradiance(exported):
    folder, _ = exported
    sky = read_image(folder / "studio_world.exr").astype(float)
    height = len(sky)
    edges = np.pi * np.arange(height + 1) / height
    solid = (np.cos(edges[:-1]) - np.cos(edges[1:])) * np.pi / height
    sun = sky.mean(axis=-1) > 5.0
    towards = np.array([3.0, 4.0, 2.0]) / np.linalg.norm([3.0, 4.0, 2.0])
    turned = (np.arange(2 * height) + 0.5) * np.pi / height - np.pi
    polar = np.pi * (np.arange(height) + 0.5) / height
    x = np.sin(polar)[:, None] * np.sin(turned)
    z = -np.sin(polar)[:, None] * np.cos(turned)
    cosine = towards[0] * x + towards[1] * np.cos(polar)[:, None] + towards[2] * z
    assert np.degrees(np.arccos(cosine[sun].min())) == pytest.approx(6.0, abs=0.15)
    irradiance = ((sky[..., 1] * cosine * sun).sum(axis=1) * solid).sum()
    assert irradiance == pytest.approx(2.0, rel=0.02)  # with the sky behind it


def test_layers_are_read_by_blender(tmp_path):
    """The image loader of Blender finds every buffer as a pass."""
    result = pm.render(pm.scenes.cornell_box(), bands=3, size=(16, 12), passes=2)
    result.save_layers(tmp_path / "box.exr")
    script = tmp_path / "read.py"
    script.write_text(
        "import bpy\n"
        f"image = bpy.data.images.load({str(tmp_path / 'box.exr')!r})\n"
        "tree = bpy.data.node_groups.new('tree', 'CompositorNodeTree')\n"
        "bpy.context.scene.compositing_node_group = tree\n"
        "node = tree.nodes.new('CompositorNodeImage')\n"
        "node.image = image\n"
        "import sys\n"
        "print(image.type, *(output.name for output in node.outputs), file=sys.stderr)\n"
    )
    kind, *names = re.findall(r"^MULTILAYER.*$", run(script), re.MULTILINE)[0].split()
    assert kind == "MULTILAYER"
    assert {"Combined", "Alpha", "Depth", "direct", "indirect", "shading", "normal"} <= {*names}
