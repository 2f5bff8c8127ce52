"""Scenes shared by the tests: Cornell boxes and closed forms."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

import photonmap as pm

CAMERA = pm.Camera(origin=(0.0, 0.0, 3.9), target=(0.0, 0.0, 0.0), fov=39.3077)
GREY = pm.Material("grey", 0.5)


def quad(a, b, c, d, material=GREY, name="quad"):
    """A parallelogram whose front is seen counter-clockwise."""
    return pm.Mesh(np.array([a, b, c, d], float), [[0, 1, 2], [0, 2, 3]], material, name)


def closed_box(material, low=-1.0, high=1.0, name="walls"):
    """A cube whose front faces look inwards."""
    box = trimesh.creation.box(bounds=[[low] * 3, [high] * 3])
    return pm.Mesh(box.vertices, box.faces[:, ::-1], material, name)


@pytest.fixture(scope="session")
def cornell():
    """The Cornell box."""
    return pm.scenes.cornell_box()


@pytest.fixture
def empty_cornell(cornell):
    """The Cornell box without the two blocks: convex, so all that is not lamp sees the lamp."""
    meshes = [mesh for mesh in cornell.meshes if not mesh.name.endswith("_box")]
    return pm.Scene(meshes, camera=cornell.camera, name="empty Cornell box")


@pytest.fixture
def point_cornell(cornell):
    """The Cornell box with a point light for a lamp."""
    meshes = [mesh for mesh in cornell.meshes if mesh.name != "light"]
    light = pm.PointLight((0.0, 0.5, 0.0), (1.0, 0.8, 0.6))
    return pm.Scene(meshes, [light], cornell.camera, "Cornell box with a point light")


@pytest.fixture
def furnace():
    """Make a closed box that emits and reflects, seen from inside."""

    def make(reflectance, emission=1.0):
        material = pm.Material("wall", reflectance, emission)
        camera = pm.Camera((0.3, 0.2, 0.8), (-0.2, -0.1, -1.0), fov=70.0)
        return pm.Scene([closed_box(material)], camera=camera, name="furnace")

    return make


@pytest.fixture(scope="session")
def study_folder(tmp_path_factory):
    """A quick study of the Cornell box, by the real command in a real process."""
    folder = tmp_path_factory.mktemp("study") / "box"
    scene = Path(pm.scenes.FOLDER) / "cornell_box.obj"
    command = [sys.executable, "-m", "photonmap", "study", scene, "--quick", "--minutes", "0.05"]
    done = subprocess.run(
        [*command, "--output", folder], capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr
    (folder.parent / "stdout").write_text(done.stdout)
    (folder.parent / "stderr").write_text(done.stderr)
    return folder


def assert_within(values, truth, error, sigmas=4.0, slack=1e-6):
    """Assert that values lie within so many standard errors of the truth."""
    deviation = np.abs(np.asarray(values, float) - truth)
    allowed = sigmas * np.asarray(error, float) + slack * np.abs(truth)
    worst = np.unravel_index(np.argmax(deviation - allowed), deviation.shape)
    assert (deviation <= allowed).all(), (
        f"{np.asarray(values)[worst]} is not {np.broadcast_to(truth, deviation.shape)[worst]} "
        f"± {sigmas} · {np.broadcast_to(error, deviation.shape)[worst]} at {worst}"
    )
