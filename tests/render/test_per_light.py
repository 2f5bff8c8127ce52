"""Light split by groups of lamps."""

import numpy as np
import pytest

import photonmap as pm

BOX = pm.scenes.cornell_box()
MIRROR = pm.Material.polished("mirror", 0.8)


def lit(*lights, mirror=False):
    meshes = [
        pm.Mesh(m.vertices, m.faces, MIRROR, m.name) if mirror and m.name == "large_box" else m
        for m in BOX.meshes
    ]
    return pm.Scene(meshes, list(lights), BOX.camera)


BLUE = pm.PointLight((0.5, 0.2, 0.6), (0.0, 0.1, 0.9), name="blue")
RED = pm.PointLight((-0.5, 0.5, 0.5), (0.9, 0.1, 0.0), name="red", group="warm")
SKY = pm.EnvironmentLight(np.full((4, 8, 3), [0.1, 0.2, 0.3]), name="sky", group="warm")


@pytest.fixture(scope="module", params=["diffuse", "mirror"])
def split(request):
    scene = lit(BLUE, RED, SKY, mirror=request.param == "mirror")
    # Many photons: pixels of a block share what photons bring, which their errors do not tell.
    settings = {"bands": 5, "size": (24, 24), "passes": 5, "photons": 32768, "seed": 2}
    return scene, settings, pm.render(scene, per_light=True, **settings)


def test_groups_are_those_of_the_file(split):
    _, _, result = split
    assert list(result.per_light) == result.record["light_groups"] == ["light", "blue", "warm"]


def test_the_whole_is_the_sum_of_its_groups_to_the_last_bit(split):
    _, _, result = split
    names = {"direct", "indirect", "shading"} | ({"caustics"} & set(result.buffers))
    for name in names:
        total = np.zeros_like(result.direct)
        for index, part in enumerate(result.per_light.values()):
            total = part[name] if index == 0 else total + part[name]
        np.testing.assert_array_equal(result.buffers[name], total)
    np.testing.assert_array_equal(
        result.radiance, (result.emission + result.direct) + result.indirect
    )


def test_the_whole_agrees_with_a_render_that_is_not_split(split):
    scene, settings, result = split
    plain = pm.render(scene, **{**settings, "seed": 3})
    for name in ("direct", "indirect", "shading"):
        error = np.hypot(result.standard_error(name), plain.standard_error(name))
        varies = (error > 0.0) & (result.reflectance > 0.1)
        z = (result.buffers[name] - plain.buffers[name])[varies] / error[varies]
        assert abs(z.mean()) < 0.5
        assert result.standard_error(name).mean() == pytest.approx(
            plain.standard_error(name).mean(), rel=0.2
        )


@pytest.mark.parametrize("group", ["light", "blue", "warm"])
def test_nothing_leaks_between_groups(split, group):
    """A group is what its lights alone would give."""
    scene, settings, result = split
    lights = [light for light in scene.lights if (light.group or light.name) == group]
    dark = pm.Material("light", (0.885809, 0.698859, 0.666422))
    meshes = [
        m if group == "light" or m.name != "light" else pm.Mesh(m.vertices, m.faces, dark, m.name)
        for m in scene.meshes
    ]
    alone = pm.render(pm.Scene(meshes, lights, scene.camera), **{**settings, "seed": 4})
    for name in ("direct", "indirect"):
        part = result.per_light[group][name]
        error = np.hypot(result.standard_error(f"{name}@{group}"), alone.standard_error(name))
        blocks = (part - alone.buffers[name]).reshape(4, 6, 4, 6, 5).mean(axis=(1, 3))
        spread = np.sqrt((error**2).reshape(4, 6, 4, 6, 5).sum(axis=(1, 3))) / 36
        assert (np.abs(blocks) < 6.0 * spread + 0.02 * alone.buffers[name].mean()).all()
        assert part.mean() == pytest.approx(alone.buffers[name].mean(), rel=0.05)


def test_split_buffers_are_written_and_read(split, tmp_path):
    _, _, result = split
    result.save(tmp_path / "split.exr")
    again = pm.load_result(tmp_path / "split.exr")
    for group, parts in result.per_light.items():
        for name, image in parts.items():
            np.testing.assert_array_equal(again.per_light[group][name], image)
            np.testing.assert_array_equal(
                again.standard_error(f"{name}@{group}"), result.standard_error(f"{name}@{group}")
            )
    np.testing.assert_array_equal(again.rgb("shading@blue"), result.rgb("shading@blue"))
    result.save(tmp_path / "some.exr", "direct")
    some = pm.load_result(tmp_path / "some.exr")
    assert {*some.buffers} == {"direct", *(f"direct@{group}" for group in result.per_light)}
    assert some.record["arguments"]["buffers"] == ["direct"]


def test_lights_that_are_off_have_no_group():
    off = pm.PointLight((-0.5, 0.5, 0.5), 0.0, name="off")
    result = pm.render(lit(BLUE, off), size=8, passes=1, per_light=True)
    assert list(result.per_light) == ["light", "blue"]
    message = "no light group 'off'; choose from 'light', 'blue'; lights that are off have none"
    with pytest.raises(KeyError, match=message):
        result.per_light["off"]
    with pytest.raises(KeyError, match="no light group 'sun'; render with per_light=True"):
        result.select("depth").per_light["sun"]


def test_one_group_is_the_whole():
    result = pm.render(BOX, bands="rgb", size=(8, 8), passes=2, per_light=True)
    assert list(result.per_light) == ["light"]
    np.testing.assert_array_equal(result.per_light["light"]["direct"], result.direct)


def test_as_many_columns_as_bands_are_still_split_and_merged():
    """Two equal bands and two groups: two columns, neither of which is a band."""
    lamps = [pm.PointLight((x, 0.2, 0.6), name=name) for x, name in ((-0.5, "a"), (0.5, "b"))]
    walls = [
        pm.Mesh(mesh.vertices, mesh.faces, pm.Material("grey", 0.5), mesh.name)
        for mesh in BOX.meshes
        if mesh.name != "light"
    ]
    scene, settings = pm.Scene(walls, lamps, BOX.camera), {"bands": 2, "size": 16, "passes": 4}
    split, whole = (pm.render(scene, per_light=each, **settings) for each in (True, False))
    assert split.record["effects"]["band_merging"]["why"] == "2 bands have 1 different spectra"
    assert (split.direct[..., 0] == split.direct[..., 1]).all()
    assert split.direct.mean((0, 1)) == pytest.approx(whole.direct.mean((0, 1)), rel=0.01)
