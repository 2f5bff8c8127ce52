"""Tables over the columns that a render carries."""

import dataclasses

import numpy as np
import pytest

import photonmap as pm
from benchmarks.speed.all_matter import all_matter
from photonmap.compile.scene_arrays import compile_scene
from photonmap.compile.spectral_columns import SpectralColumns, carry, choose_columns
from photonmap.kernels.core.records import SceneArrays
from photonmap.spectra.bands import Bands


def arrays_in(record, name="scene"):
    """Yield the arrays of a record and of those in it, with their names."""
    if isinstance(record, np.ndarray):
        yield name, record
    elif isinstance(record, tuple):
        for field, value in zip(
            getattr(record, "_fields", range(len(record))), record, strict=True
        ):
            yield from arrays_in(value, f"{name}.{field}")


@pytest.fixture(scope="module")
def everything():
    """A scene of all matter and light, compiled for six bands that all differ."""
    scene = all_matter()
    groups = [
        dataclasses.replace(light, name=f"light {number}", group=f"group {number}")
        for number, light in enumerate(scene.lights)
    ]
    return compile_scene(pm.Scene(scene.meshes, groups, scene.camera), Bands.gaussian(6))


@pytest.mark.parametrize(
    "of_band", [[0, 0, 1, 1, 2, 2], [0, 1, 2, 3, 4, 5], [0] * 6], ids=["merged", "all", "one"]
)
@pytest.mark.parametrize("groups", [("",), ("group 0", "group 3")], ids=["whole", "split"])
def test_tables_keep_the_one_order_that_kernels_are_compiled_for(everything, of_band, groups):
    carried = carry(everything, SpectralColumns(np.array(of_band), groups))
    before, after = (dict(arrays_in(each.arrays)) for each in (everything, carried))
    assert before.keys() == after.keys()
    assert isinstance(carried.arrays, SceneArrays)
    for name, array in after.items():
        assert array.flags.c_contiguous, name
        assert array.dtype == before[name].dtype, name


def test_bands_that_are_alike_are_carried_once():
    grey = pm.scenes.cornell_box().meshes[0]
    mesh = dataclasses.replace(grey, material=pm.Material("grey", 0.5))
    scene = pm.Scene([mesh], [pm.DomeLight(1.0)])
    compiled = compile_scene(scene, Bands.gaussian(6))
    columns = choose_columns(compiled, merge=True, split=False)
    assert columns.distinct == 1
    assert carry(compiled, columns).materials.reflectance.shape[1] == 1


@pytest.mark.parametrize("name", ["a.error", "a.error8"])
def test_groups_that_would_pass_for_standard_errors_are_refused(name):
    box = pm.scenes.cornell_box()
    scene = pm.Scene(box.meshes, [pm.PointLight((0.0, 0.0, 0.0), 1.0, name)], box.camera)
    compiled = compile_scene(scene, Bands.rgb())
    assert choose_columns(compiled, merge=True, split=False).count
    with pytest.raises(pm.InputError, match=f"light group '{name}' ends as standard errors do"):
        choose_columns(compiled, merge=True, split=True)
