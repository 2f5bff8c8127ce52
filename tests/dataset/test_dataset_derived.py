"""What data sets add to a render, and the identities that hold."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.commands.main import main
from photonmap.dataset.files.derived_buffers import as_rgb, rgb_residual, with_derived
from photonmap.dataset.jobs.verify import check_identities, verify

SIZE = ["--size", "16x12", "--bands", "3", "--error", "0.5"]


def command(folder, preset, *more):
    formats = ["--format", "exr,hdf5,png"]
    return main(["dataset", str(folder), "--preset", preset, *SIZE, *formats, *more])


def test_what_is_derived():
    scene = pm.scenes.cornell_box()
    result = with_derived(pm.render(scene, bands=3, size=(24, 24), passes=4, pixel="center"))
    assert list(check_identities(result)) == []
    masks = [result.buffers[name] for name in ("valid", "light_source", "background")]
    assert masks[0].any()
    assert masks[1].any()
    assert not (masks[0] & masks[1]).any()
    direct = result.buffers["illuminant_direct"]
    lit = direct.any(axis=-1)
    np.testing.assert_allclose(direct[lit].mean(axis=-1), 1.0, rtol=1e-5)
    lamp = next(m.material.emission for m in scene.meshes if m.name == "light")
    color = result.bands.emission(lamp)
    np.testing.assert_allclose(
        direct[lit], np.tile(color / color.mean(), (lit.sum(), 1)), rtol=1e-4
    )


def test_a_render_of_ones_own_gets_masks(tmp_path):
    scene = pm.scenes.cornell_box()
    result = pm.render(scene, bands=3, size=(32, 24), passes=2)
    pm.dataset.with_derived(result, scene).save(tmp_path / "box.exr")
    pure = pm.load_result(tmp_path / "box.exr").buffers["pure"]
    assert 0.2 < pure.mean() < 1.0
    np.testing.assert_array_equal(pure[result.object_id == 0], False)
    scene.camera = None
    with pytest.raises(pm.InputError, match="the scene has no camera; give it one, and render"):
        pm.dataset.with_derived(result, scene)


def test_identities_that_do_not_hold_are_told():
    result = with_derived(pm.render(pm.scenes.cornell_box(), bands=3, size=(8, 8), passes=2))
    result.buffers["indirect"] = result.indirect * np.float32(1.001)
    problems = list(check_identities(result))
    assert "radiance is not (emission + direct) + indirect" in problems
    assert "direct + indirect is not reflectance × shading + fluorescence + residual" in problems


def test_rgb_stands_as_it_is():
    result = with_derived(pm.render(pm.scenes.cornell_box(), bands="rgb", size=(8, 8), passes=2))
    rgb = as_rgb(result)
    np.testing.assert_array_equal(rgb.radiance, result.radiance)
    assert rgb_residual(rgb) < 1e-6


@pytest.mark.parametrize("bands", ["1", "rgb"])
def test_few_bands(tmp_path, bands):
    folder = tmp_path / "set"
    more = ["--size", "16x12", "--bands", bands, "--error", "0.5", "--quiet"]
    path = tmp_path / "one.toml"
    path.write_text('scenes = ["jug"]\nilluminations = ["two_mixed"]')
    assert main(["dataset", str(folder), "--preset", str(path), *more]) == 0
    [image] = pm.dataset.open(folder)
    count = 3 if bands == "rgb" else 1
    assert image["shading"].shape == image["illuminant"].shape == (12, 16, count)
    assert image["scalar_shading"].shape == (12, 16)
    assert verify(folder) == []
