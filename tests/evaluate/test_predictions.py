"""Predictions are read from folders by the names of images, in every format, and checked."""

import numpy as np
import OpenImageIO
import pytest

from photonmap import InputError, SceneWarning
from photonmap.evaluate.bench.predictions import predictions
from photonmap.evaluate.methods.method import View
from photonmap.io.png import write_png
from photonmap.scene.images import decode_srgb

VIEW = View("room", np.ones((4, 5, 3)), np.ones((4, 5), bool))
LINEAR = np.random.default_rng(0).uniform(0.0, 2.0, (4, 5, 3)).astype(np.float32)
BYTES = np.random.default_rng(1).integers(0, 256, (4, 5, 3)).astype(np.uint8)


def write(path, pixels, kind, channels=None):
    """Write a picture by OpenImageIO."""
    path.parent.mkdir(parents=True, exist_ok=True)
    spec = OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    spec["oiio:UnassociatedAlpha"] = 1
    if channels:
        spec.channelnames = channels
    file = OpenImageIO.ImageOutput.create(str(path))
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(pixels), file.geterror()
    file.close()


def read(folder, encoding="srgb"):
    return predictions(folder, ["room", "hall"], encoding).estimate(VIEW)


def test_png_is_srgb_unless_said_to_be_linear(tmp_path):
    (tmp_path / "room").mkdir()
    write_png(BYTES, tmp_path / "room" / "reflectance.png")
    found = read(tmp_path)
    np.testing.assert_allclose(found.reflectance, decode_srgb(BYTES / 255), atol=1e-6)
    assert found.shading is None
    assert found.illuminant is None
    np.testing.assert_allclose(read(tmp_path, "linear").reflectance, BYTES / 255, atol=1e-6)


def test_16_bit_png_and_grey_and_alpha(tmp_path):
    deep = np.random.default_rng(2).integers(0, 65536, (4, 5, 1)).astype(np.uint16)
    write(tmp_path / "room" / "shading.png", deep, "uint16")
    with_alpha = np.dstack([BYTES, np.full((4, 5), 7, np.uint8)])
    write(tmp_path / "room" / "reflectance.png", with_alpha, "uint8")
    found = read(tmp_path, "linear")
    np.testing.assert_allclose(found.shading, deep / 65535, atol=1e-6)
    np.testing.assert_allclose(found.reflectance, BYTES / 255, atol=1e-6)


def test_exr_is_linear_whatever_png_is(tmp_path):
    write(tmp_path / "room" / "shading.exr", LINEAR, "float")
    for encoding in ("srgb", "linear"):
        np.testing.assert_array_equal(read(tmp_path, encoding).shading, LINEAR)


def test_npz_holds_any_number_of_bands(tmp_path):
    bands = np.random.default_rng(3).uniform(size=(4, 5, 7))
    np.savez(tmp_path / "room.npz", reflectance=bands, illuminant=np.arange(7), other=1)
    found = read(tmp_path)
    np.testing.assert_array_equal(found.reflectance, bands)
    np.testing.assert_array_equal(found.illuminant, np.arange(7))
    assert found.shading is None


def test_the_method_has_the_name_of_the_folder(tmp_path):
    folder = tmp_path / "my network"
    (folder / "room").mkdir(parents=True)
    assert predictions(folder, ["room"]).name == "my network"


def test_strangers_are_counted(tmp_path):
    for name in ("room", "cellar", "attic"):
        (tmp_path / name).mkdir()
    (tmp_path / "notes.txt").write_text("not a prediction")
    with pytest.warns(SceneWarning, match="2 predictions belong to no image.*'attic', 'cellar'"):
        predictions(tmp_path, ["room"])


def test_wrong_folders_are_named(tmp_path):
    with pytest.raises(InputError, match="is not a folder; choose the folder of the predictions"):
        predictions(tmp_path / "nowhere", ["room"])
    with pytest.raises(InputError, match=r"such as hall/reflectance.png or hall.npz"):
        predictions(tmp_path, ["room", "hall"])
    with pytest.raises(InputError, match="no encoding 'gamma'"):
        predictions(tmp_path, ["room"], "gamma")


def test_wrong_files_are_named(tmp_path):
    (tmp_path / "hall").mkdir()
    with pytest.raises(
        InputError, match=r"there is no IMAGE/LAYER\.png, IMAGE/LAYER\.exr or IMAGE\.npz"
    ):
        read(tmp_path)
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "shading.png").write_bytes(b"not a picture")
    with pytest.raises(InputError, match=r"shading.png: cannot be read"):
        read(tmp_path)
    write(tmp_path / "room" / "shading.png", BYTES, "uint8")
    np.savez(tmp_path / "room.npz", shading=LINEAR)
    with pytest.raises(InputError, match=r"shading.png: there is more than one shading"):
        read(tmp_path)
    np.savez(tmp_path / "room.npz", albedo=LINEAR)
    with pytest.raises(
        InputError, match=r"has none of the arrays 'reflectance'.*it has 'albedo'; rename them"
    ):
        read(tmp_path)
    np.savez(tmp_path / "room.npz", reflectance=1j * LINEAR)
    with pytest.raises(InputError, match=r"room.npz: reflectance is of type complex64; give real"):
        read(tmp_path)
    (tmp_path / "room.npz").write_bytes(b"PK\3\4 damaged")
    with pytest.raises(InputError, match=r"room.npz: cannot be read"):
        read(tmp_path)
