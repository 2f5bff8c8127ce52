"""Arrays of a result by name and wavelength, as labelled arrays and as plots."""

import json
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

import photonmap as pm
from photonmap.results.files import no_cluster

SIZE = (10, 9)


@pytest.fixture(scope="module")
def result():
    box = pm.scenes.cornell_box()
    return pm.render(box, bands="420:660:80", size=SIZE, passes=4, photons=2000, per_light=True)


def test_arrays_by_name(result):
    assert result["direct"] is result.direct
    assert result["direct.error"] is result.errors["direct"]
    assert result["indirect.error8"].shape == (2, 2, 4)
    assert "direct@light" in result
    assert "caustics" not in result
    assert dict(result).keys() == {*result} == result.arrays.keys()
    with pytest.raises(KeyError, match="no array 'drect'; did you mean 'direct'"):
        result["drect"]


def test_a_result_is_a_mapping(result):
    assert len(result) == len(result.arrays) == len([*result])
    assert [*result.items()] == [(name, result[name]) for name in result]
    assert result.get("direct.error") is result["direct.error"]
    assert result.get("glow") is None
    assert isinstance(result, Mapping)
    assert result == result != replace(result)
    assert {result: 1}[result] == 1


def test_one_band(result):
    np.testing.assert_allclose(result.wavelengths, [420, 500, 580, 660], rtol=1e-14)
    one = result.sel(wavelength=520)
    assert one.bands.names == ("500nm",)
    np.testing.assert_array_equal(one.direct[..., 0], result.direct[..., 1])
    np.testing.assert_array_equal(one["shading.error"][..., 0], result["shading.error"][..., 1])
    assert one["indirect.error8"].shape == (2, 2, 1)
    np.testing.assert_array_equal(one.normal, result.normal)
    assert one.bands.average(pm.Spectrum([400, 700], [4, 7])) == pytest.approx([5.0])
    assert one.record["white"] == [result.record["white"][1]]
    with pytest.raises(pm.InputError, match="900 nm is outside of the bands, 380 to 700 nm"):
        result.sel(900)


def test_a_selected_band_is_saved_and_loaded(result, tmp_path):
    result.sel(600).save(tmp_path / "one.exr")
    again = pm.load_result(tmp_path / "one.exr")
    np.testing.assert_array_equal(again.radiance[..., 0], result.radiance[..., 2])
    assert again.wavelengths == pytest.approx([580])


def test_rgb_has_no_wavelengths():
    rgb = pm.render(pm.scenes.cornell_box(), bands="rgb", size=4, passes=1, photons=100)
    with pytest.raises(pm.InputError, match="RGB has no wavelengths"):
        rgb.sel(550)
    figure = pytest.importorskip("matplotlib.figure").Figure()
    labels = rgb.plot_spectrum(1, 1, axes=figure.subplots()).get_xticklabels()
    assert [label.get_text() for label in labels] == ["R", "G", "B"]


def test_labelled_arrays(result, tmp_path):
    xarray = pytest.importorskip("xarray")
    data = result.to_xarray()
    assert set(data.data_vars) == set(result)
    for name, image in result.arrays.items():
        np.testing.assert_array_equal(data[name], image)
    assert data["direct.error"].dims == data.direct.dims == ("y", "x", "band")
    assert data["indirect.error8"].dims == ("block_y", "block_x", "band")
    assert data.depth.dims == ("y", "x")
    assert data.normal.dims == ("y", "x", "axis")
    assert data.direct.attrs["units"] == "W·m⁻²·sr⁻¹"
    assert data.reflectance.attrs["units"] == "1"
    assert data["direct.error"].attrs["long_name"].startswith("standard error of light reflected")
    assert list(data.band.values) == list(result.bands.names)
    at_600 = data.swap_dims(band="wavelength").sel(wavelength=610, method="nearest")
    np.testing.assert_array_equal(at_600.direct, result.direct[..., 2])
    np.testing.assert_array_equal(data.sel(y=2.5, x=0.5).direct, result.direct[2, 0])
    assert json.loads(data.attrs["record"])["passes"] == 4
    pytest.importorskip("h5netcdf")
    with no_cluster():  # of other tests
        data.to_netcdf(tmp_path / "box.nc")
    with xarray.open_dataset(tmp_path / "box.nc") as again:
        np.testing.assert_array_equal(again["direct"], result.direct)


def test_what_is_missing_is_named(result, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "xarray", None)
    with pytest.raises(pm.InputError, match=r"need xarray: pip install 'photonmap\[xarray\]'"):
        result.to_xarray()
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    with pytest.raises(pm.InputError, match=r"need matplotlib: pip install 'photonmap\[plot\]'"):
        result.plot()


def test_plots(result):
    figure = pytest.importorskip("matplotlib.figure").Figure()
    axes = result.plot(axes=figure.subplots())
    np.testing.assert_array_equal(axes.get_images()[0].get_array(), result.preview())
    for name in ("shading", "reflectance", "depth", "normal", "object_id"):
        drawn = result.plot(name, axes=pytest.importorskip("matplotlib.figure").Figure().subplots())
        assert drawn.get_title() == name
    spectrum = result.plot_spectrum(4, 7, "direct", axes=figure.subplots())
    [bars] = spectrum.containers
    line, _, [ranges] = bars.lines
    np.testing.assert_allclose(line.get_xdata(), result.wavelengths)
    np.testing.assert_array_equal(line.get_ydata(), result.direct[7, 4])
    spread = [segment[1, 1] - segment[0, 1] for segment in ranges.get_segments()]
    np.testing.assert_allclose(spread, 2.0 * result.standard_error("direct")[7, 4], rtol=1e-4)
    [[line, *_]] = result.plot_spectrum(0, 0, "direct", axes=figure.subplots()).containers
    np.testing.assert_array_equal(line.get_ydata(), result.direct[0, 0])
    for pixel, name, message in (
        ((10, 0), "direct", r"no pixel \(10, 0\) in an image of 10x9"),
        ((0, 0), "depth", "'depth' has no bands"),
        ((0, 0), "dirct", "'dirct' was not among"),
    ):
        with pytest.raises(pm.InputError, match=message):
            result.plot_spectrum(*pixel, name)
