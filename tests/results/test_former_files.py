"""Files that earlier versions wrote: buffers that had other names, or were not there yet."""

from contextlib import closing
from types import SimpleNamespace

import numpy as np
import OpenImageIO
import pytest

import photonmap as pm
from photonmap.buffers import BUFFERS, check_buffers
from photonmap.dataset.files import image_files
from photonmap.dataset.files.lean import Parts
from photonmap.dataset.files.reader import Image
from photonmap.dataset.jobs.verify import check_digests
from photonmap.io.exr import FORMER_NAMES, current_name, list_parts
from photonmap.viewer.page import load_for_page

SETTINGS = {"bands": 3, "size": (16, 12), "passes": 2, "photons": 500}
BEFORE = {new: old for old, new in FORMER_NAMES.items()}


def rewrite(path, names=BEFORE, without=()):
    """Write a file's parts anew: some by other names, and some not at all."""
    parts = []
    with closing(OpenImageIO.ImageInput.open(str(path))) as file:
        for index in range(file.spec().get_int_attribute("oiio:subimages", 1)):
            spec = file.spec(index).copy()
            name = spec.get_string_attribute("oiio:subimagename")
            spec.attribute("oiio:subimagename", names.get(name, name))
            if name not in without:
                parts.append((spec, file.read_image(index, 0, 0, spec.nchannels, spec.format)))
    specs = [spec for spec, _ in parts]
    with closing(OpenImageIO.ImageOutput.create("exr")) as file:
        assert file.open(str(path), specs)
        for index, (spec, pixels) in enumerate(parts):
            assert index == 0 or file.open(str(path), spec, "AppendSubimage")
            assert file.write_image(pixels)


@pytest.fixture(scope="module")
def result():
    return pm.render(pm.scenes.cornell_balls(), buffers=BUFFERS, **SETTINGS)


@pytest.fixture
def file(result, tmp_path):
    result.save_exr(tmp_path / "image.exr")
    return tmp_path / "image.exr"


def test_renamed_buffers_are_read_by_their_new_names(result, file):
    wanted = list_parts(file)
    rewrite(file)
    assert b"specular_albedo" in file.read_bytes()
    assert list_parts(file) == wanted
    loaded = pm.load_result(file)
    assert list(loaded.buffers) == list(result.buffers)
    np.testing.assert_array_equal(loaded.specular_reflectance, result.specular_reflectance)
    shown = load_for_page(str(file), ["specular_reflectance"])
    assert "specular_reflectance" in shown.buffers


def test_so_are_those_of_data_sets(result, file, tmp_path):
    h5py = pytest.importorskip("h5py")
    rewrite(file)
    assert "specular_reflectance" in Parts(file)
    np.testing.assert_array_equal(Parts(file)["specular_reflectance"], result.specular_reflectance)
    bands = tmp_path / "bands.hdf5"
    image_files._write_bands(bands, result, ["specular_reflectance"])
    with h5py.File(bands, "a") as data:
        data.move("specular_reflectance", "specular_albedo")
    read = image_files.read_hdf5(bands).specular_reflectance
    np.testing.assert_allclose(read, result.specular_reflectance, rtol=1e-3)
    names, halves = image_files.hdf5_halves(bands)
    assert "specular_reflectance" in names
    assert halves == ["specular_reflectance"]
    entry = {"name": "jug", "buffers": ["radiance", "specular_albedo"]}
    assert Image(tmp_path, entry).chosen == ("radiance", "specular_reflectance")


@pytest.mark.parametrize(("times", "faults"), [(1.0, 0), (0.5, 1)])
def test_digests_by_former_names_are_checked(result, times, faults):
    seen = result.select(["specular_reflectance"])
    seen.buffers["specular_reflectance"] = times * seen.specular_reflectance
    digest = image_files.digests(result)["specular_reflectance"]
    image = SimpleNamespace(entry={"arrays": {"specular_albedo": digest}}, result=seen)
    assert len([*check_digests(image)]) == faults


@pytest.mark.parametrize("name", FORMER_NAMES)
def test_former_names_lead_to_the_new_ones(name):
    with pytest.raises(pm.InputError, match=f"did you mean '{current_name(name)}'"):
        check_buffers([name])


def test_depth_was_the_distance_before_it_had_a_buffer_of_its_own(result, file):
    rewrite(file, without=["distance"])
    loaded = pm.load_result(file)
    assert "distance" not in loaded.buffers
    for name in ("radiance", "depth", "normal"):
        np.testing.assert_array_equal(loaded[name], result[name])
    reason = "^'distance' is not here: this was written before .* from 'depth', which holds the dis"
    with pytest.raises(AttributeError, match=reason) as raised:
        _ = loaded.distance
    assert "\n" not in str(raised.value)
    with pytest.raises(pm.InputError, match=reason):
        loaded.select(["distance"])
    with pytest.raises(AttributeError, match="'distance' was not among the buffers written"):
        _ = loaded.select(["radiance", "depth"]).distance
    frame = "images/scene_cam_00_geometry_hdf5/frame.0000.depth_meters.hdf5"
    images = image_files.hypersim_images(loaded, loaded.buffers)
    np.testing.assert_array_equal(images[frame], loaded.depth)
    assert "distance" not in Parts(file)
