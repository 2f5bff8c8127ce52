"""The files of a render, read back by photonmap, by OpenImageIO and by colour-science."""

import json
import os
import warnings
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

import photonmap as pm
from photonmap.errors import InputError
from photonmap.io import png
from photonmap.io.exr import channel_names, sensitivity_texts
from photonmap.results import files as output
from photonmap.results.files import check_output
from photonmap.results.result import Result, load_result
from photonmap.runtime import writing
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum

H, W = 19, 5  # more lines than the 16 that are compressed together
LIGHT = ("radiance", "emission", "direct", "indirect", "shading")
BANDED = (*LIGHT, "reflectance")
RECORD = {
    "seed": 2**63,
    "error": 0.1 + 0.2,
    "scene": {"name": 'a "box" – é\n'},
    "effects": [None, {}],
}
BANDS = {
    "rgb": Bands.rgb(),
    **{str(n): Bands.gaussian(n) for n in (1, 6, 31, 81)},
    "cut": Bands.gaussian(6, 405, 650),
    "box": Bands.box(4),
    "camera": Bands.sensors(
        [Spectrum([390, 620, 700], [1, 2, 1]), Spectrum([400, 450, 710], [1, 3, 1])], ("r", "b")
    ),
}
every = pytest.mark.parametrize("bands", BANDS.values(), ids=BANDS)


def any_floats(rng, *shape):
    """Return finite float32 of random bits: any exponent, denormals, both zeros."""
    image = rng.integers(0, 2**32, shape, np.uint32).view(np.float32)
    image = np.where(np.isfinite(image), image, -0.0).astype(np.float32)
    image.flat[:4] = 0.0, 1e-45, np.finfo(np.float32).max, -np.finfo(np.float32).tiny
    return image


def make(bands=BANDS["6"]):
    rng = np.random.default_rng(bands.count)
    buffers = {name: any_floats(rng, H, W, bands.count) for name in BANDED}
    buffers |= {name: any_floats(rng, H, W) for name in ("coverage", "depth")}
    buffers["unresolved"] = rng.random((H, W)) < 0.5
    buffers["normal"] = any_floats(rng, H, W, 3)
    for name in ("object_id", "material_id"):
        buffers[name] = rng.integers(0, 2**32, (H, W), np.uint32)
    errors = {name: any_floats(rng, H, W, bands.count) for name in BANDED}
    return Result(buffers, errors, bands, RECORD)


def read_parts(path):
    """Return what OpenImageIO says of a file: part → (spec, {channel: (H, W)})."""
    parts = {}
    file = OpenImageIO.ImageInput.open(str(path))
    while file.seek_subimage(len(parts), 0):
        spec = file.spec()
        pixels = file.read_image(len(parts), 0, 0, spec.nchannels, spec.format)
        channels = dict(zip(spec.channelnames, np.moveaxis(pixels, -1, 0), strict=True))
        parts[spec["oiio:subimagename"]] = spec, channels
    file.geterror()
    file.close()
    return parts


def assert_same(images, others):
    assert list(images) == list(others)
    for name, image in images.items():
        other = others[name]
        assert (image.shape, image.dtype) == (other.shape, other.dtype), name
        assert image.tobytes() == other.tobytes(), name


@pytest.fixture(scope="module")
def colour():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it says which optional parts are missing
        return pytest.importorskip("colour")


@every
def test_what_is_saved_is_read_back_bit_for_bit(bands, tmp_path):
    result = make(bands)
    result.save(tmp_path / "image.exr")
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "image.exr",
        "image.json",
        "image.png",
    ]
    again = load_result(tmp_path / "image.exr")
    assert_same(result.buffers, again.buffers)
    assert_same(result.errors, again.errors)
    assert (again.bands, again.record) == (bands, RECORD)


def test_an_image_of_one_pixel_in_256_bands_keeps_their_order(tmp_path):
    values = np.arange(256, dtype=np.float32)[None, None]
    Result({"shading": values}, {}, Bands.gaussian(256), {}).save(tmp_path / "image.exr")
    np.testing.assert_array_equal(load_result(tmp_path / "image.exr").shading, values)


@pytest.mark.parametrize("names", [["depth"], ["unresolved", "direct"], ["shading", "radiance"]])
def test_chosen_buffers_are_written_with_their_errors(names, tmp_path):
    result = make()
    result.save(tmp_path / "image.exr", names)
    again = load_result(tmp_path / "image.exr")
    assert set(again.buffers) == set(names)
    assert set(again.errors) == set(names) & set(BANDED)
    assert next(iter(again.buffers)) == ("radiance" if "radiance" in names else names[0])
    assert (tmp_path / "image.png").exists()  # shows the radiance, which need not be written
    with pytest.raises(InputError, match="'glow' was not among the buffers written"):
        result.save(tmp_path / "other.exr", ["glow"])


def read_record(path):
    """Read a JSON record without the time that writing took."""
    record = json.loads(path.read_text(encoding="utf-8"))
    assert record.pop("seconds")["write"] > 0.0
    return record


def test_without_radiance_there_is_no_preview(tmp_path):
    make().select(["depth"]).save(tmp_path / "image.exr")
    assert not (tmp_path / "image.png").exists()
    assert read_record(tmp_path / "image.json") == RECORD


def test_png_and_json_stand_beside_the_image(tmp_path):
    result = make()
    result.save(str(tmp_path / "image.EXR"))
    assert read_record(tmp_path / "image.json") == {**RECORD, "exposure": result.exposure}
    preview = OpenImageIO.ImageInput.open(str(tmp_path / "image.png"))
    np.testing.assert_array_equal(preview.read_image("uint8"), result.preview())
    assert preview.spec().format == "uint8"
    preview.close()


@every
def test_the_layout_is_as_documented(bands, tmp_path):
    result = make(bands)
    result.save(tmp_path / "image.exr")
    parts = read_parts(tmp_path / "image.exr")
    assert list(parts) == [*result.buffers, *(f"{name}.error" for name in result.errors)]
    images = result.buffers | {f"{name}.error": image for name, image in result.errors.items()}
    for part, (spec, channels) in parts.items():
        names = expected_channels(part, bands)
        planes = np.moveaxis(images[part].reshape(H, W, -1), -1, 0)
        viewers = {"R", "G", "B"} if part == "radiance" else set()
        assert set(channels) == viewers | set(names)
        for name, plane in zip(names, planes, strict=True):
            np.testing.assert_array_equal(channels[name], plane)
        attributes = {a.name: a.value for a in spec.extra_attribs}
        spectral = names[0][0] in "ST"
        assert attributes.get("spectralLayoutVersion") == ("1.0" if spectral else None)
        light = names[0].startswith("S0.")
        assert attributes.get("emissiveUnits") == ("W.m^-2.sr^-1" if light else None)
        spectral_names = {name for name in attributes if name.endswith("nm")}
        assert spectral_names == set(names if spectral else [])
        assert ("photonmapRecord" in attributes) == (part == "radiance")
    viewers = np.stack([parts["radiance"][1][c] for c in "RGB"], axis=-1)
    np.testing.assert_array_equal(viewers, result.rgb())


def expected_channels(part, bands):
    flat = {"coverage": "Y", "unresolved": "Y", "depth": "Z", "normal": "XYZ"}
    if part in ("object_id", "material_id"):
        return ["id"]
    if part in flat or bands.limits is None:
        return list(flat.get(part, "RGB"))
    component = "T" if part.startswith("reflectance") else "S0"
    return [
        f"{component}.{c:.6f}nm".replace(".", ",").replace(",", ".", 1) for c in bands.centroids
    ]


def test_centroids_that_coincide_are_told_apart():
    given = [550.0, 550.0, 550.000001, 99.9, 1000.5]
    assert channel_names("S0", given) == [
        "S0.550,000000nm",
        "S0.550,000001nm",
        "S0.550,000002nm",
        "S0.99,900000nm",
        "S0.1000,500000nm",
    ]


@pytest.mark.parametrize(
    "bands", [b for b in BANDS.values() if b.limits], ids=lambda b: f"{b.kind}-{b.count}"
)
def test_a_sensitivity_is_told_where_it_is_not_zero(bands):
    ends = []
    for text, curve in zip(sensitivity_texts(bands), bands.sensitivities, strict=True):
        at, values = np.array([pair.split("nm:") for pair in text.split(";")], float).T
        ends += [at[0], at[-1]]
        assert values[0] == values[-1] == 0.0
        assert np.trapezoid(values, at) == pytest.approx(1.0, abs=1e-6)
        interpolated = np.interp(curve.wavelengths, at, values)
        np.testing.assert_allclose(interpolated, curve.values, rtol=1e-5, atol=1e-8)
    assert min(ends) == bands.limits[0] - 1e-6
    assert max(ends) == bands.limits[1] + 1e-6


@pytest.mark.parametrize(("name", "component"), [("radiance", "S0"), ("reflectance", "T")])
@pytest.mark.parametrize("n", [1, 6, 31])
def test_colour_science_reads_the_first_part(colour, name, component, n, tmp_path):
    bands = Bands.gaussian(n)
    result = make(bands)
    result.save(tmp_path / "image.exr", [name])
    read = colour.read_spectral_image_Fichet2021(tmp_path / "image.exr", additional_data=True)
    components, specification = read
    assert list(components) == [component]
    wavelengths, values = components[component]
    np.testing.assert_allclose(wavelengths, bands.centroids, atol=1e-6)
    np.testing.assert_array_equal(values, result.buffers[name])
    assert specification.is_emissive == (component == "S0")
    assert not specification.is_polarised
    assert not specification.is_bispectral
    text = {a.name: a.value for a in specification.attributes}[
        channel_names(component, [wavelengths[0]])[0]
    ]
    curve = colour.io.spectrum_attribute_to_sd_Fichet2021(text)
    np.testing.assert_allclose(np.trapezoid(curve.values, curve.wavelengths), 1.0, atol=1e-6)


BREAKABLE = {
    "write_png": output, "write_json": output, "write_exr": output,
    "encode_png": png,
}  # fmt: skip


@pytest.mark.parametrize("broken", BREAKABLE)
@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_a_failure_leaves_what_was_there(broken, error, tmp_path, monkeypatch):
    def fail(*_):
        raise error("full")

    make(BANDS["rgb"]).save(tmp_path / "image.exr")
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    monkeypatch.setattr(BREAKABLE[broken], broken, fail)
    for name in ("image.exr", "new.exr"):
        with pytest.raises(error):
            make().save(tmp_path / name)
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


def test_a_failure_in_the_middle_of_the_image_leaves_nothing(tmp_path):
    result = make()
    result.errors["direct"] = np.empty((H, W, 5), np.float32)  # a band too few
    with pytest.raises(OSError, match=r"cannot write /.*/image\.exr \(.* wrong size"):
        result.save(tmp_path / "image.exr")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a disk that is always full")
def test_a_full_disk_is_an_error(tmp_path):
    (tmp_path / "image.exr").symlink_to("/dev/full")
    with pytest.raises(OSError, match=r"cannot write /.*/image\.exr \("):
        make().save_exr(tmp_path / "image.exr")


def test_places_that_cannot_be_written_are_refused(tmp_path):
    (tmp_path / "file").touch()
    (tmp_path / "taken.exr").mkdir()
    (tmp_path / "beside.json").mkdir()
    for name, message in {
        "image.png": "must end in .exr",
        "image": "must end in .exr",
        ".exr": "must end in .exr",
        "file/image.exr": "Not a directory",
        "file/deep/image.exr": "Not a directory",
        "taken.exr": "this is a folder",
        "beside.exr": "beside.json: this is a folder",
    }.items():
        with pytest.raises(InputError, match=message) as caught:
            check_output(tmp_path / name)
        assert str(caught.value).startswith(str(tmp_path))
        assert "\n" not in str(caught.value)
    assert check_output(str(tmp_path / "image.exr")) == tmp_path / "image.exr"
    assert check_output(tmp_path / "new" / "image.exr") == tmp_path / "new" / "image.exr"
    assert sorted(file.name for file in tmp_path.iterdir()) == ["beside.json", "file", "taken.exr"]


def test_names_of_buffers_are_checked_before_a_render(tmp_path):
    check_output(tmp_path / "image.exr", make().buffers)
    with pytest.raises(InputError, match=r"no buffer 'shadow'; did you mean 'shading'\?"):
        check_output(tmp_path / "image.exr", ["depth", "shadow"])


def test_a_folder_that_takes_no_files_is_refused(tmp_path, monkeypatch):
    def refuse(**_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(writing.tempfile, "TemporaryFile", refuse)
    with pytest.raises(InputError, match=r"cannot write to the folder .* \(Permission denied\)"):
        check_output(tmp_path / "image.exr")


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a folder that takes no files")
def test_the_system_is_asked_whether_a_folder_takes_files():
    with pytest.raises(InputError, match="cannot write to the folder /proc/self"):
        check_output("/proc/self/image.exr")


def test_only_whole_files_of_photonmap_are_read(tmp_path):
    make().save(tmp_path / "image.exr")
    data = (tmp_path / "image.exr").read_bytes()
    (tmp_path / "text.exr").write_text("no image", encoding="utf-8")
    for cut in (0, 4, 1000, len(data) // 2, len(data) - 3):
        (tmp_path / f"cut{cut}.exr").write_bytes(data[:cut])
    renamed = data.replace(b"S0.475,", b"S0.474,")
    (tmp_path / "channels.exr").write_bytes(renamed)
    (tmp_path / "bands.exr").write_bytes(data.replace(b'"kind"', b'"kinb"'))
    (tmp_path / "json.exr").write_bytes(data.replace(b'{"seed"', b' "seed"'))
    other = OpenImageIO.ImageBuf(np.zeros((2, 2, 3), np.float32))
    assert other.write(str(tmp_path / "other.exr"))
    with pytest.raises(InputError, match=r"missing\.exr: there is no such file; check its name"):
        load_result(tmp_path / "missing.exr")
    with pytest.raises(InputError, match="this is a folder"):
        load_result(tmp_path)
    with pytest.raises(InputError, match=f"^{os.devnull}: this is a device or a pipe; give the"):
        load_result(os.devnull)
    for file in sorted(set(tmp_path.iterdir()) - {tmp_path / "image.exr", tmp_path / "image.json"}):
        with pytest.raises(InputError, match=r"OpenEXR|damaged|not written by photonmap") as caught:
            load_result(file)
        assert str(caught.value).startswith(f"{file}: this ")
        assert "\n" not in str(caught.value)


def test_ids_have_names(tmp_path):
    """Of objects in order of appearance, two meshes of one name being one; of materials too."""
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    red, blue = pm.Material("red", 0.5), pm.Material("bläu", 0.4)
    meshes = [
        pm.Mesh(np.array(corners) + (2 * k, 0, 0), [[0, 1, 2]], material, name)
        for k, (name, material) in enumerate([("a", red), ("b", blue), ("a", blue)])
    ]
    camera = pm.Camera((2.5, 0.3, 8.0), (2.5, 0.3, 0.0))
    scene = pm.Scene(meshes, [pm.DomeLight()], camera)
    pm.render(scene, size=(48, 16), bands=1, passes=1).save(tmp_path / "ids.exr")
    result = pm.load_result(tmp_path / "ids.exr")
    for part, names, row in (
        ("object_id", ["a", "b"], ["a", "b", "a"]),
        ("material_id", ["red", "bläu"], ["red", "bläu", "bläu"]),
    ):
        spec, _ = read_parts(tmp_path / "ids.exr")[part]
        assert json.loads(spec["photonmapNames"]) == names
        ids = result.buffers[part][7]
        seen = [ids[first] for first in range(len(ids)) if ids[first] and not ids[first - 1]]
        listed = result.record["objects" if part == "object_id" else "materials"]
        assert [listed[number - 1] for number in seen] == row
