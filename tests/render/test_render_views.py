"""Views of one scene, which share all that does not depend on the camera."""

from dataclasses import replace

import numpy as np
import pytest

import photonmap as pm
from photonmap.integrators import shared_work
from photonmap.runtime.progress import Silent

BOX = pm.scenes.cornell_box()
FRONT = BOX.camera
LEFT = pm.Camera((-0.8, 0.3, 2.0), (0.1, -0.2, 0.0), name="left")
NEAR = pm.Camera((-0.9995, -0.9995, -0.9995), (0.0, 0.0, 0.5), fov=60.0)
FEW = {"bands": 1, "size": (8, 6), "passes": 2, "photons": 512, "threads": 1}


def assert_same(one, other):
    assert one.buffers.keys() == other.buffers.keys()
    for name, values in one.buffers.items():
        np.testing.assert_array_equal(values, other.buffers[name])
    for name, values in one.errors.items():
        np.testing.assert_array_equal(values, other.errors[name])
    assert one.record["rays_by_kind"] == other.record["rays_by_kind"]
    assert one.record["fingerprint"] == other.record["fingerprint"]


@pytest.mark.parametrize(
    "scene", [BOX, pytest.param(pm.scenes.cornell_balls(), marks=pytest.mark.slow)]
)
def test_views_are_the_renders_of_their_cameras_to_the_bit(scene):
    """Also one in a corner, which is the origin of its own kernels' units."""
    views = list(pm.render_views(scene, [FRONT, LEFT, NEAR], **FEW))
    for camera, view in zip((FRONT, LEFT, NEAR), views, strict=True):
        assert_same(view, pm.render(replace(scene, camera=camera), **FEW))
    photons = views[0].record["photons"]
    assert photons > 0
    assert [view.record["photons_reused"] for view in views] == [0, photons, 0]


def test_photons_for_which_there_is_no_room_are_traced_again(monkeypatch):
    monkeypatch.setattr(shared_work, "MOST_BYTES", 0)
    first, second = pm.render_views(BOX, [FRONT, LEFT], **FEW)
    assert first.record["photons_reused"] == second.record["photons_reused"] == 0
    assert_same(second, pm.render(replace(BOX, camera=LEFT), **FEW))


def test_room_is_taken_once_by_arrays_that_records_share():
    cells, other = np.zeros(10, np.uint8), np.zeros(10, np.uint8)
    room = shared_work.Room(25)
    assert room.take((cells, None, 1.0, (other,)))
    assert room.take((cells, np.zeros(5, np.uint8)))
    assert room.take((cells, other))
    assert not room.take((cells, np.zeros(1, np.uint8)))


def test_work_of_the_last_kinds_of_views_is_kept():
    work, made = shared_work.SharedWork(), []
    for key in "ababcaca":
        work.once(key, lambda key=key: made.append(key))
    assert made == [*"abca"]


def test_lights_that_are_hidden_from_one_view_do_not_dim_another():
    """They emit few photons where they seem to send nothing into the view."""
    outside = pm.PointLight((0.0, 0.0, 5.0), 1.0, name="outside")
    front = pm.Mesh([(-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)], [(0, 1, 2), (0, 2, 3)])
    closed = pm.Scene([*BOX.meshes, front], [outside])
    cameras = [
        pm.Camera((0.0, 0.0, 0.5), (0.0, 0.0, -1.0)),
        pm.Camera((0.0, 0.0, 4.0), (0.0, 0.0, 0.0)),
    ]
    with pytest.warns(pm.SceneWarning, match="nothing into the view"):
        inner, outer = pm.render_views(closed, cameras, **FEW)
    assert outer.record["photons_reused"] == 0
    with pytest.warns(pm.SceneWarning, match="nothing into the view"):
        assert_same(outer, pm.render(replace(closed, camera=cameras[1]), **FEW))
    assert inner.record["warnings"] != outer.record["warnings"]


def test_warnings_of_the_scene_are_in_the_record_of_each_view_and_issued_once():
    dark = replace(BOX, lights=[pm.PointLight((0.0, 0.0, 0.0), 0.0, name="off")])
    glass = pm.Material.glass(name="glass")
    nested = pm.Scene([*dark.meshes, replace(dark.meshes[0], material=glass)], camera=FRONT)
    with pytest.warns(pm.SceneWarning) as issued:
        views = list(pm.render_views(nested, [FRONT, LEFT], **FEW))
    texts = [str(each.message) for each in issued]
    assert views[0].record["warnings"] == views[1].record["warnings"] != []
    assert len(texts) == len(set(texts))


def test_cameras_by_name_and_all_of_the_scene():
    scene = replace(BOX, camera=None, cameras=[replace(FRONT, name="front"), LEFT])
    options = {**FEW, "effects": "direct", "passes": 1}
    both = list(pm.render_views(scene, **options))
    [named] = pm.render_views(scene, ["left"], **options)
    assert_same(both[1], named)
    assert [each.record["camera"]["name"] for each in both] == ["front", "left"]


@pytest.mark.parametrize(
    ("cameras", "said"),
    [
        ([], "there are no cameras to render by; give some"),
        (None, "there are no cameras to render by; give some"),
        (["right"], "there is no camera 'right'"),
        ([FRONT, 3], "3 is not a camera; give a photonmap.Camera"),
    ],
)
def test_cameras_that_are_refused_before_anything_is_rendered(cameras, said):
    with pytest.raises(pm.InputError, match=said):
        pm.render_views(replace(BOX, camera=None), cameras, **FEW)


def test_each_view_has_a_checkpoint_of_its_own(tmp_path):
    few = FEW | {"checkpoint": tmp_path / "run.checkpoint"}
    list(pm.render_views(BOX, [FRONT, LEFT], **{**few, "passes": 1}))
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["run-0.checkpoint", "run-1.checkpoint"]
    views = list(pm.render_views(BOX, [FRONT, LEFT], **few, resume=True))
    assert [view.record["resumed"] for view in views] == [1, 1]
    assert_same(views[1], pm.render(replace(BOX, camera=LEFT), **FEW))


def test_a_view_that_is_interrupted_is_the_last():
    class Interrupting(Silent):
        def update(self, *state):
            raise KeyboardInterrupt

    views = list(pm.render_views(BOX, [FRONT, LEFT], **FEW, progress=Interrupting()))
    assert [view.record["interrupted"] for view in views] == [True]
    assert views[0].record["passes"] == 1
