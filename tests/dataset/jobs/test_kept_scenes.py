"""Scenes that are built once for all of their lights: the same images as when built anew."""

import dataclasses

import numpy as np
import pytest

from photonmap.compile import scene_arrays
from photonmap.dataset.files.derived_buffers import one_piece
from photonmap.dataset.jobs import job_scene
from photonmap.dataset.jobs.plan import CommonSettings, plan_jobs
from photonmap.dataset.jobs.presets import Preset
from photonmap.dataset.jobs.render_image import Task, render_image
from photonmap.dataset.scenes.build import build_unlit_scene
from photonmap.dataset.scenes.views import View
from photonmap.integrators import shared_work

COMMON = CommonSettings((24, 18), "3", "0.5", inputs="0")
LIGHTS = ("white", "colored", "two_mixed")
ROOM = "corridor"
OWN = View()


@pytest.fixture(autouse=True)
def _forget():
    forget()
    yield
    forget()


def forget():
    job_scene._build.cache_clear()
    job_scene._light.cache_clear()
    job_scene._pieces.clear()


def jobs_of(*scenes, lights=LIGHTS, common=COMMON, count=1, views=(OWN,)):
    preset = Preset("own", scenes, illuminations=lights, views=views)
    return plan_jobs(preset, [], common, count=count)


def test_images_are_the_same_and_scenes_are_built_once(tmp_path, monkeypatch):
    built = []

    def build(name, seed, *looks):
        built.append((name, seed))
        return build_unlit_scene(name, seed, *looks)

    monkeypatch.setattr(job_scene, "build_unlit_scene", build)
    for folder in ("kept", "anew"):
        (tmp_path / folder).mkdir()
    jobs = jobs_of("jug", lights=("white", "two_mixed"))
    kept = [render_image(Task(job, str(tmp_path / "kept"), ("exr",))) for job in jobs]
    assert built == [("jug", 0)]
    forget()
    anew = render_image(Task(jobs[1], str(tmp_path / "anew"), ("exr",)))
    assert anew["arrays"] == kept[1]["arrays"]
    assert len(built) == 2


@pytest.mark.slow
def test_views_in_one_light_are_the_same_and_compiled_once(tmp_path, monkeypatch):
    compiled = []

    def compile_scene(*given):
        compiled.append(given)
        return scene_arrays.compile_scene(*given)

    monkeypatch.setattr(shared_work, "compile_scene", compile_scene)
    for folder in ("kept", "anew"):
        (tmp_path / folder).mkdir()
    jobs = jobs_of("jug", lights=("white",), views=(OWN, View("side", yaw=20.0)))
    kept = [render_image(Task(job, str(tmp_path / "kept"), ("exr",))) for job in jobs]
    assert len(compiled) == 1
    forget()
    anew = render_image(Task(jobs[1], str(tmp_path / "anew"), ("exr",)))
    assert anew["arrays"] == kept[1]["arrays"]
    assert len(compiled) == 2


def test_a_room_in_one_light_is_that_in_another():
    jobs = jobs_of(ROOM)
    kept = [job_scene.make_scene(job) for job in jobs]
    forget()
    for job, scene in zip(jobs[::-1], kept[::-1], strict=True):
        again = job_scene.make_scene(job)
        assert again.camera == scene.camera
        assert [m.material for m in again.meshes] == [m.material for m in scene.meshes]
        assert [light.color for light in again.lights] == [light.color for light in scene.lights]


def test_pieces_of_surface_are_those_of_the_scene():
    """Also where windows are dark, and where they show the sky."""
    for job in jobs_of(ROOM):
        scene = job_scene.make_scene(job)
        found = job_scene.pieces_in(job, scene)
        np.testing.assert_array_equal(found, one_piece(scene, COMMON.size))
    assert len(job_scene._pieces) < len(LIGHTS)


def test_looks_sizes_and_seeds_are_kept_apart():
    first = jobs_of("jug")[0]
    others = [
        jobs_of("jug", common=dataclasses.replace(COMMON, materials="mixed"))[0],
        jobs_of("jug", common=dataclasses.replace(COMMON, lightness=0.2))[0],
        jobs_of("jug", common=dataclasses.replace(COMMON, size=(16, 12)))[0],
        jobs_of("jug", count=2)[-1],
    ]
    job_scene.pieces_in(first, job_scene.make_scene(first))
    for job in others:
        scene = job_scene.make_scene(job)
        found = job_scene.pieces_in(job, scene)
        np.testing.assert_array_equal(found, one_piece(scene, job.common.size))
    assert len(job_scene._pieces) == 1 + len(others)
