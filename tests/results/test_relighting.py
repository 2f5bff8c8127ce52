"""Light groups of other strengths and spectra, without rendering again."""

import warnings

import numpy as np
import pytest

import photonmap as pm
from photonmap.errors import InputError

BOX = pm.scenes.cornell_box()
WALLS = [mesh for mesh in BOX.meshes if mesh.name != "light"]
MIRROR = pm.Material.polished("mirror", 0.8)
MIRRORED = [
    pm.Mesh(m.vertices, m.faces, MIRROR, m.name) if m.name == "large_box" else m for m in WALLS
]
LEFT = pm.PointLight((-0.6, 0.6, 0.4), pm.emission("D65"), "left")
RIGHT = pm.PointLight((0.6, 0.6, 0.4), pm.emission("A"), "right")
SETTINGS = {"size": 16, "passes": 2, "photons": 4000, "seed": 1, "bands": 4}
GAINS = {"left": 0.25, "right": [2.0, 1.0, 0.5, 0.0]}


@pytest.fixture(scope="module", params=[WALLS, MIRRORED], ids=["diffuse", "mirror"])
def room(request):
    return pm.render(pm.Scene(request.param, [LEFT, RIGHT], BOX.camera), per_light=True, **SETTINGS)


def test_without_gains_all_stays(room):
    same = room.relit({"left": 1.0})
    assert [*same] == [*room]
    assert all(same[name] is image for name, image in room.items())
    assert same.record == room.record


def test_twice_the_light_is_twice_as_bright(room):
    twice = room.relit({"left": 2.0, "right": 2.0})
    assert [*twice.buffers] == [*room.buffers]
    for name in ("radiance", "residual", "shading", "caustics", "covariance"):
        image = 2.0 * getattr(room, name)
        np.testing.assert_allclose(getattr(twice, name), image, rtol=0.0, atol=1e-6 * image.max())
    np.testing.assert_allclose(twice.record["white"], room.record["white"], rtol=1e-6)


def test_whole_buffers_are_sums_of_groups_times_gains(room):
    relit = room.relit(GAINS)
    left, right = np.float32(0.25), np.array(GAINS["right"], np.float32)
    for name in ("direct", "indirect", "shading"):
        parts = [room.per_light[group][name] for group in ("left", "right")]
        np.testing.assert_array_equal(relit[name], parts[0] * left + parts[1] * right)
    whole = (relit.emission + relit.direct) + relit.indirect
    np.testing.assert_array_equal(relit.radiance, whole)
    product = relit.reflectance * relit.shading + relit.residual
    atol = 1e-6 * relit.radiance.max()
    np.testing.assert_allclose(product, relit.direct + relit.indirect, rtol=0.0, atol=atol)
    assert relit.relit({"left": 4.0}).record["relit"]["left"] == [1.0] * 4
    for name in ("depth", "reflectance", "coverage", "object_id"):
        assert relit[name] is room[name]


def test_a_relit_room_is_that_of_other_lamps(room):
    lamp = pm.PointLight(LEFT.position, 3.0 * pm.emission("D65"), "left")
    meshes = MIRRORED if room.residual.any() else WALLS
    scene = pm.Scene(meshes, [lamp, RIGHT], BOX.camera)
    rendered = pm.render(scene, per_light=True, **SETTINGS)
    relit = room.relit({"left": 3.0})
    np.testing.assert_allclose(relit.record["white"], rendered.record["white"], rtol=1e-6)
    for name in ("direct", "indirect"):
        assert relit[name].mean() == pytest.approx(rendered[name].mean(), rel=0.1)


def test_errors_of_two_groups_are_those_of_passes_in_their_light(room):
    """The error of a mean of two passes is half of their difference."""
    scene = pm.Scene(MIRRORED if room.residual.any() else WALLS, [LEFT, RIGHT], BOX.camera)
    one = pm.render(scene, per_light=True, **{**SETTINGS, "passes": 1}).relit(GAINS)
    two = room.relit(GAINS)
    for name in ("direct", "indirect", "shading"):  # this is a ratio where reflectance varies
        even = room.errors["reflectance"] == 0.0 if name == "shading" else np.s_[:]
        expected = np.abs(two[name].astype(np.float64) - one[name])[even]
        atol = 1e-4 * one[name].max()
        np.testing.assert_allclose(two.errors[name][even], expected, rtol=1e-3, atol=atol)
    squares = room.relit({"left": 2.0, "right": 2.0}).errors["shading"] ** 2
    expected = 4.0 * room.errors["shading"] ** 2
    atol = (
        1e-6 * expected.max()
    )  # squares of float32 errors of both groups cancel where they differ
    np.testing.assert_allclose(squares, expected, rtol=1e-3, atol=atol)


def test_sums_of_three_groups_have_no_errors():
    lamp = pm.PointLight((0.0, 0.6, 0.4), 1.0, "middle")
    few = {**SETTINGS, "size": 4, "photons": 100, "effects": "direct"}
    room = pm.render(pm.Scene(WALLS, [LEFT, RIGHT, lamp], BOX.camera), per_light=True, **few)
    relit = room.relit(GAINS)
    assert "direct@left" in relit.errors
    assert not {"direct", "shading", "radiance"} & relit.errors.keys()


def test_errors_are_those_that_are_known(room):
    relit = room.relit(GAINS)
    known = {"direct", "indirect", "shading", "direct@left", "shading@right", "reflectance"}
    assert known <= relit.errors.keys()
    assert not {"radiance", "residual"} & relit.errors.keys()
    assert not relit.block_errors
    np.testing.assert_array_equal(
        relit.errors["direct@left"], np.float32(0.25) * room.errors["direct@left"]
    )
    alone = room.relit({"left": 2.0, "right": 0.0})
    for name in ("direct", "shading"):
        np.testing.assert_array_equal(alone.errors[name], 2.0 * room.errors[f"{name}@left"])
    assert "radiance" not in alone.errors
    assert relit.record["error"] is None
    with pytest.raises(InputError, match="record lacks what merging needs"):
        pm.merge([relit, relit])
    with pytest.raises(InputError, match="bias of relit light is not known"):
        relit.bias("indirect")


def test_the_white_is_that_of_the_new_light(room):
    parts = room.record["group_whites"]
    np.testing.assert_allclose(np.sum([*parts.values()], axis=0), room.record["white"], rtol=1e-6)
    alone = room.relit({"left": 0.0})
    color = np.array(parts["right"])
    np.testing.assert_allclose(alone.record["white"], color / color.mean(), rtol=1e-12)
    assert room.relit({"left": 0, "right": 0}).record["white"] is None
    blue = room.sel(room.wavelengths[0]).relit({"left": 2.0})
    np.testing.assert_allclose(blue.record["white"], [1.0])


def test_relit_results_are_saved_and_loaded(room, tmp_path):
    relit = room.relit(GAINS)
    relit.save(tmp_path / "relit.exr")
    again = pm.load_result(tmp_path / "relit.exr")
    np.testing.assert_array_equal(again.radiance, relit.radiance)
    np.testing.assert_array_equal(again.rgb(), relit.rgb())


def test_lamps_in_view_keep_their_emission():
    lit = pm.render(pm.Scene(BOX.meshes, [LEFT], BOX.camera), per_light=True, **SETTINGS)
    with pytest.warns(pm.SceneWarning, match="emission is not split by light group: lamps"):
        relit = lit.relit({"light": 0.0})
    np.testing.assert_array_equal(relit.emission, lit.emission)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lit.relit({"light": 1})


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"lft": 1.0}, "no light group 'lft'; did you mean 'left'"),
        ({"left": -1.0}, "gain -1.0 of light group 'left' must be a number of at least 0, or 4"),
        ({"left": [1.0, 2.0]}, r"gain \[1.0, 2.0\] of light group 'left'"),
        ({"left": "bright"}, "gain 'bright' of light group 'left'"),
        (2.0, r"gains 2.0 go by no light groups, as in {'left': 2}"),
    ],
)
def test_wrong_gains(room, gains, message):
    with pytest.raises(InputError, match=message):
        room.relit(gains)


def test_lights_that_were_not_split_cannot_be_relit(room):
    with pytest.raises(InputError, match="no light groups to relight; render with per_light=True"):
        room.select("radiance").relit({"left": 2.0})
