"""Results in other programs' formats, read back by those programs' own readers."""

import json

import numpy as np
import pytest

import photonmap as pm
from photonmap.commands.main import main
from photonmap.dataset.files import image_files
from photonmap.results.files import WRITERS, check_output
from photonmap.results.result import Result
from photonmap.spectra.bands import Bands

H, W = 9, 5
SPLIT = {
    "direct@a/b": "direct@a%2Fb",
    "direct@a_b": "direct@a_b",
    "direct@a%2Fb": "direct@a%252Fb",
}
"""Names in files of light groups whose names are alike."""


def make(bands=None):
    bands = bands or Bands.gaussian(4)
    rng = np.random.default_rng(1)
    names = ("emission", "direct", *SPLIT, "radiance", "reflectance")
    buffers = {name: rng.random((H, W, bands.count), np.float32) for name in names}
    buffers["unresolved"] = rng.random((H, W)) < 0.5
    buffers["normal"] = rng.random((H, W, 3), np.float32)
    buffers["depth"] = rng.random((H, W), np.float32)
    buffers["object_id"] = rng.integers(0, 2**32, (H, W), np.uint32)
    errors = {"direct": rng.random((H, W, bands.count), np.float32)}
    blocks = {"direct": rng.random((2, 1, bands.count), np.float32)}
    return Result(buffers, errors, bands, {"seed": 7, "name": "é"}, blocks)


def test_netcdf_is_read_by_xarray(tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    result = make()
    result.save(tmp_path / "a.nc")
    with xarray.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as data:
        assert set(data.data_vars) == {SPLIT.get(name, name) for name in result}
        for name, image in result.arrays.items():
            np.testing.assert_array_equal(data[SPLIT.get(name, name)], image)
        np.testing.assert_allclose(data.wavelength, result.wavelengths)
        assert data.direct.attrs["units"] == "W·m⁻²·sr⁻¹"
        assert json.loads(data.attrs["record"]) == result.record
        assert Bands.from_description(json.loads(data.attrs["bands"])) == result.bands
    assert {file.name for file in tmp_path.iterdir()} == {"a.nc", "a.png", "a.json"}


def test_hdf5_is_read_by_h5py(tmp_path):
    h5py = pytest.importorskip("h5py")
    pytest.importorskip("h5netcdf")
    result = make()
    result.save(tmp_path / "new" / "a.hdf5")
    with h5py.File(tmp_path / "new" / "a.hdf5") as file:
        for name, image in result.arrays.items():
            np.testing.assert_array_equal(
                file[SPLIT.get(name, name)][...].astype(image.dtype), image
            )
        np.testing.assert_allclose(file["wavelength"], result.wavelengths)
        assert file["wavelength"].attrs["units"] == "nm"
        assert [text.decode() for text in file["band"]] == list(result.bands.names)
        assert file["direct.error"].attrs["long_name"].startswith("standard error of light")
        assert file["direct"].dims[2][0].name == "/band"
        assert file["object_id"].dtype == np.uint32


@pytest.mark.parametrize("suffix", [".hdr", ".img"])
def test_envi_is_read_by_spy(tmp_path, suffix):
    envi = pytest.importorskip("spectral.io.envi")
    result = make()
    result.save(tmp_path / f"a{suffix}")
    for name, image in result.arrays.items():
        stem = "a" if name == "radiance" else f"a-{SPLIT.get(name, name)}"
        read = envi.open(tmp_path / f"{stem}.hdr")
        array = np.asarray(read.load(dtype=image.dtype))
        np.testing.assert_array_equal(array.reshape(image.shape), image, name)
        assert "unit: " in read.metadata["description"]
    read = envi.open(tmp_path / "a-direct.hdr")
    np.testing.assert_allclose(read.bands.centers, result.wavelengths)
    assert read.bands.band_unit == "Nanometers"
    assert read.metadata["band names"] == list(result.bands.names)
    assert len([*tmp_path.iterdir()]) == 2 * len(result.arrays) + 2


def test_names_of_light_groups_are_read_back(tmp_path):
    pytest.importorskip("h5py")
    result = make()
    result.save(tmp_path / "a.exr")
    image_files._write_bands(tmp_path / "bands.hdf5", result, ["direct@a/b"])
    half = result["direct@a/b"].astype(np.float16)
    for read, wanted in (
        (pm.load_result(tmp_path / "a.exr"), result["direct@a/b"]),
        (image_files.read_hdf5(tmp_path / "bands.hdf5"), half),
    ):
        assert set(read) == set(result)
        np.testing.assert_array_equal(read["direct@a/b"], wanted)
        np.testing.assert_array_equal(read["direct@a_b"], result["direct@a_b"])
    names, halves = image_files.hdf5_halves(tmp_path / "bands.hdf5")
    assert set(names) == set(result)
    assert halves == ["direct@a/b"]


def test_rgb_has_no_wavelengths(tmp_path):
    envi = pytest.importorskip("spectral.io.envi")
    make(Bands.rgb()).save(tmp_path / "a.hdr")
    metadata = envi.open(tmp_path / "a.hdr").metadata
    assert metadata["band names"] == ["R", "G", "B"]
    assert "wavelength" not in metadata


def test_a_cluster_has_no_part_in_writing(tmp_path, monkeypatch):
    """One that is gone would leave xarray's lock taken, and the next file waiting for ever."""
    distributed = pytest.importorskip("distributed")
    pytest.importorskip("h5netcdf")

    def fail(*_):
        raise OSError("Timed out trying to connect to the scheduler")

    monkeypatch.setattr("dask.distributed.Lock", fail)
    quiet = {"n_workers": 0, "processes": False, "dashboard_address": ":0"}
    with distributed.LocalCluster(**quiet) as cluster, distributed.Client(cluster):
        make().save(tmp_path / "a.nc")
    assert (tmp_path / "a.nc").stat().st_size


def test_chosen_buffers(tmp_path):
    make().save(tmp_path / "a.hdr", ["depth", "direct"])
    names = {file.stem for file in tmp_path.glob("*.img")}
    written = ("direct", "direct.error", "direct.error8", *SPLIT.values())
    assert names == {"a", *(f"a-{name}" for name in written)}


@pytest.mark.parametrize("suffix", [".nc", ".hdr"])
def test_nothing_is_left_of_a_write_that_fails(tmp_path, monkeypatch, suffix):
    pytest.importorskip("h5netcdf")

    def fail(*_):
        raise OSError("No space left on device")

    monkeypatch.setattr("photonmap.results.files.write_json", fail)
    with pytest.raises(OSError, match="No space left"):
        make().save(tmp_path / f"a{suffix}")
    assert not [*tmp_path.iterdir()]


def test_files_of_envi_are_no_folders(tmp_path):
    (tmp_path / "a-direct.error.img").mkdir()
    with pytest.raises(pm.InputError, match=r"a-direct\.error\.img: this is a folder; remove it"):
        check_output(tmp_path / "a.hdr")
    with pytest.raises(pm.InputError, match=r"a-direct\.error\.img: this is a folder; remove it"):
        make().save(tmp_path / "a.hdr")
    assert len([*tmp_path.iterdir()]) == 1


def test_a_missing_package_is_named_before_the_render(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("photonmap.results.files.find_spec", lambda name: None)
    with pytest.raises(pm.InputError, match=r"\.nc need xarray and h5netcdf: pip install 'photonm"):
        check_output(tmp_path / "a.nc")
    box = str(pm.scenes.FOLDER / "cornell_box.obj")
    assert main([box, "--output", str(tmp_path / "a.h5")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    check_output(tmp_path / "a.hdr")
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize("suffix", sorted(WRITERS.keys() - {".exr"}))
def test_what_is_for_other_programs_is_not_read_back(suffix, tmp_path):
    path = tmp_path / f"box{suffix}"
    path.write_bytes(b"CDF")
    with pytest.raises(
        pm.InputError, match=rf"{suffix} are for other programs, .* as FILE.exr too"
    ):
        pm.load_result(path)


def test_a_number_is_no_file():
    with pytest.raises(pm.InputError, match=r"5 is not the name of a file; give the FILE.exr"):
        pm.load_result(5)
