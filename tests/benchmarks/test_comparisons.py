"""The scenes that benches hand to Mitsuba are those that photonmap renders."""

import json
from pathlib import Path

import numpy as np
import pytest

import photonmap as pm
from benchmarks.accuracy import gloss
from benchmarks.accuracy.gloss_scenes import MATTER, SCENES, write_scene
from benchmarks.accuracy.mitsuba_export import export_scene
from benchmarks.accuracy.room_scenes import scenes

SIZE = (16, 12)


@pytest.mark.parametrize("name", sorted(scenes().keys() - {"living_room", "library", "pottery"}))
def test_scenes_go_over_whole(tmp_path, name):
    """All triangles, and all light: portals, for one, have no counterpart in Mitsuba.

    Of the rooms, which one function makes, the smallest stands for all.
    """
    scene = scenes()[name][0]()
    file, power = export_scene(scene, SIZE, tmp_path)
    nodes = [node for node in json.loads(file.read_text()).values() if isinstance(node, dict)]
    meshes = [node for node in nodes if node.get("type") == "ply"]
    assert sum(map(_triangles, meshes)) == sum(len(mesh.faces) for mesh in scene.meshes)
    others = [node for node in nodes if node["type"] in ("point", "directional", "constant")]
    skies = [node for node in nodes if node["type"] == "envmap"]
    assert len(others) + len(skies) == len(scene.lights)
    shining = {
        mesh["emitter"]["radiance"]["value"][0] * power for mesh in meshes if "emitter" in mesh
    }
    given = {
        float(pm.Bands.parse("rgb").emission(mesh.material.emission)[0]) for mesh in scene.meshes
    }
    np.testing.assert_allclose(sorted(shining), sorted(given - {0.0}), rtol=1e-5)


@pytest.mark.parametrize("name", SCENES | MATTER)
def test_files_are_read_without_loss(tmp_path, name):
    """What photonmap warns of would not be compared."""
    assert pm.load_scene(write_scene(name, SIZE, tmp_path)).meshes


def test_scenes_of_gloss_are_chosen_one_by_one():
    for name in SCENES:
        assert gloss._choose((name,)) == (name,)
        assert "," not in name
    assert gloss._choose(()) == tuple(SCENES)
    assert gloss._choose(("floor", "metal-0.2")) == ("metal-0.2", "floor-0.1")
    with pytest.raises(SystemExit, match="there is no scene 'flor'; choose from"):
        gloss._choose(("metal", "flor"))


def _triangles(node):
    with Path(node["filename"]).open("rb") as file:
        for line in file:
            if line.startswith(b"element face"):
                return int(line.split()[-1])
    return 0
