"""The files of a photo and the command that writes them: all channels, DNG, and bad input."""

import hashlib
import json
from dataclasses import replace

import numpy as np
import OpenImageIO
import pytest
from renders import flat, render_of

import photonmap as pm
from photonmap.capture.sensor import OPTIONS
from photonmap.commands.main import main

XTRANS = "GBGGRG/RGRBGB/GBGGRG/GRGGBG/BGBRGR/GRGGBG"
NIKON = "Nikon 5100 (NPL)"


@pytest.fixture(scope="module")
def box():
    """The Cornell box in few passes, with its record."""
    return pm.render(pm.scenes.cornell_box(), bands=6, size=(40, 32), passes=2, photons=2000)


@pytest.fixture
def image(box, tmp_path, monkeypatch):
    """The same in the file box.exr of the current folder."""
    monkeypatch.chdir(tmp_path)
    box.save("box.exr")
    return "box.exr"


def test_command(image, box, tmp_path, capsys):
    command = ["sensor", image, "--camera", NIKON, "--iso", "800", "--seed", "5"]
    assert main(command) == 0
    folder = tmp_path / "box-sensor"
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["demosaiced.png", "raw.dng", "raw.png", "sensor.json", "srgb.png", "truth.npz"]
    assert "ISO 800" in capsys.readouterr().out
    wanted = pm.expose(box, pm.Sensor(camera=NIKON, iso=800.0), seed=5)
    found = pm.load_photo(folder)
    for name in ("raw", "truth", "demosaiced", "srgb"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name))
    assert found.record == wanted.record
    before = {path.name: digest(path) for path in folder.iterdir()}
    assert main([*command, "--quiet"]) == 0
    assert {path.name: digest(path) for path in folder.iterdir()} == before
    assert main([*command, "--seed", "6", "-o", "other", "--quiet"]) == 0
    changed = {
        path.name for path in (tmp_path / "other").iterdir() if digest(path) != before[path.name]
    }
    assert changed == {"demosaiced.png", "raw.dng", "raw.png", "sensor.json", "srgb.png"}


def test_several_images(image, box, tmp_path):
    """Each has noise of its own, and a folder called after it, or after the folder it is in."""
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        box.save(tmp_path / name / "bands.exr")
    images = ["first/bands.exr", "second/bands.exr"]
    assert main(["sensor", *images, "-o", "all", "--seed", "7", "--quiet"]) == 0
    photos = [pm.load_photo(tmp_path / "all" / name) for name in ("first", "second")]
    assert [photo.record["seed"] for photo in photos] == [7, 8]
    assert not np.array_equal(photos[0].raw, photos[1].raw)
    assert main(["sensor", image, "first/bands.exr", "--quiet"]) == 0
    assert (tmp_path / "box-sensor" / "raw.png").is_file()
    assert (tmp_path / "first" / "bands-sensor" / "raw.png").is_file()


def test_images_of_one_name(image, capsys):
    assert main(["sensor", image, f"../{image}", image, "-o", "all"]) == 2
    assert "two images" in capsys.readouterr().err


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def read(path):
    file = OpenImageIO.ImageInput.open(str(path))
    assert file is not None, path
    pixels = file.read_image(OpenImageIO.UNKNOWN)
    file.close()
    return pixels


def test_demosaiced_file_is_between_its_levels(box, tmp_path):
    photo = pm.expose(box, pm.Sensor())
    pm.save_photo(photo, tmp_path / "photo")
    levels = json.loads((tmp_path / "photo" / "sensor.json").read_text())["demosaiced"]
    pixels = read(tmp_path / "photo" / "demosaiced.png").astype(np.float64)
    shown = (pixels - levels["black"]) / (levels["white"] - levels["black"])
    np.testing.assert_allclose(shown, np.clip(photo.demosaiced, shown.min(), 1.0), atol=1e-5)


@pytest.mark.parametrize("mosaic", ["RGGB", "BGGR", "GRBG", XTRANS])
def test_dng_by_libraw(tmp_path, mosaic):
    """LibRaw reads the numbers, the pattern, the levels and the white balance that were written."""
    rawpy = pytest.importorskip("rawpy")
    photo = pm.expose(chart(), pm.Sensor(mosaic=mosaic, full_well=1e8, percentile=100.0, level=0.3))
    pm.save_photo(photo, tmp_path)
    with rawpy.imread(str(tmp_path / "raw.dng")) as file:
        np.testing.assert_array_equal(file.raw_image_visible, photo.raw)
        letters = [[chr(file.color_desc[i]) for i in row] for row in file.raw_pattern.tolist()]
        assert "".join(map("".join, letters)) == mosaic.replace("/", "")
        assert set(file.black_level_per_channel) == {512}
        assert file.white_level == photo.record["white"]
        balance = np.array(file.camera_whitebalance[:3])
        neutral = np.array(photo.record["neutral"])
        np.testing.assert_allclose(balance / balance[1], neutral[1] / neutral, rtol=1e-4)
        if mosaic == XTRANS:  # LibRaw develops no small ones
            return
        image = file.postprocess(
            use_camera_wb=True, output_bps=16, gamma=(1, 1), no_auto_bright=True
        )
    found = np.float64(image[32, 32::64])
    wanted = photo.rgb()[32, 32::64]
    found *= wanted[-1].mean() / found[-1].mean()
    assert np.abs(found - np.maximum(wanted, 0.0)).max() < 0.002


def chart():
    """Return patches of 64×64 pixels in a row, the last of them grey, under D65."""
    names = ["dark skin", "blue sky", "foliage", "orange", "purple", "yellow", "0.2"]
    bands = pm.Bands.parse("400:700:10")
    light = bands.emission(pm.emission("D65"))
    colors = [light * bands.reflectance(pm.reflectance(name)) for name in names]
    image = np.repeat(np.repeat(np.array(colors)[None], 64, axis=0), 64, axis=1)
    return render_of(image, bands, white=light.tolist())


def test_colors_of_the_chart(tmp_path):
    """A neutral is neutral, and the developed colours of a chart are near those of the observer."""
    result = chart()
    sensor = pm.Sensor(camera=NIKON, mosaic="none", read_noise=0.0, full_well=1e9, bits=16)
    found = pm.expose(result, replace(sensor, percentile=100.0)).rgb()[32, 32::64]
    wanted = result.rgb()[32, 32::64]
    found *= wanted[-1].mean() / found[-1].mean()
    assert np.ptp(found[-1]) < 0.01 * found[-1].mean()
    assert np.abs(found - wanted).max() < 0.06


def test_the_picture_follows_the_exposure():
    """A white at the white level is white; at half of it, sRGB of 0.5; above, it stays white."""
    bands = pm.Bands.parse("400:700:10")
    light = bands.emission(pm.emission("D65"))
    result = render_of(np.broadcast_to(light, (8, 8, 31)), bands, white=light.tolist())
    for level, shown in ((1.0, 255), (0.5, 188), (5.0, 255)):
        sensor = pm.Sensor(mosaic="none", full_well=1e9, percentile=0.0, level=level)
        first = float(pm.expose(result, sensor).truth.min(axis=(0, 1)).max())
        time = pm.expose(result, sensor).record["time_s"] * level / first
        picture = pm.expose(result, replace(sensor, time=time)).srgb
        assert np.abs(picture.astype(int) - shown).max() <= 2


def test_multispectral(box, tmp_path):
    """Nine bands in a 3×3 mosaic: what PNG cannot hold is TIFF."""
    photo = pm.expose(box, pm.Sensor(camera="400:680:35"))
    assert photo.truth.shape == (32, 40, 9)
    assert photo.raw.shape == (32, 40)
    assert photo.srgb.shape == (32, 40, 3)
    pm.save_photo(photo, tmp_path / "nine")
    names = {path.name for path in (tmp_path / "nine").iterdir()}
    assert names == {"raw.png", "demosaiced.tif", "sensor.json", "srgb.png", "truth.npz"}
    assert read(tmp_path / "nine" / "demosaiced.tif").shape == (32, 40, 9)
    whole = pm.expose(box, pm.Sensor(camera="400:680:35", mosaic="none"))
    pm.save_photo(whole, tmp_path / "nine")
    assert not (tmp_path / "nine" / "raw.png").exists()
    np.testing.assert_array_equal(pm.load_photo(tmp_path / "nine").raw, whole.raw)


def test_sensitivities_of_a_file(box, tmp_path):
    """A file with the camera's curves is the camera; heights count."""
    wavelengths = np.arange(380.0, 731.0, 5.0)
    curves = [np.exp(-0.5 * ((wavelengths - at) / 30.0) ** 2) for at in (600.0, 540.0, 450.0)]
    rows = np.stack([wavelengths, curves[0], 0.5 * curves[1], curves[2]], axis=1)
    path = tmp_path / "camera.csv"
    np.savetxt(path, rows, delimiter=",", header="nm,R,G,B", comments="")
    photo = pm.expose(box, pm.Sensor(camera=str(path)))
    assert photo.record["sensor"]["camera"] == "camera.csv"
    electrons = photo.record["electrons_per_radiance"]
    assert electrons[1] == pytest.approx(0.5 * electrons[0], rel=1e-3)


def test_sensor_files(image, box, tmp_path):
    (tmp_path / "night.toml").write_text(
        'iso = 3200\nread_noise = 2.5\nmosaic = "BGGR"\nbits = 12\n'
    )
    assert main(["sensor", image, "--sensor", "night.toml", "--bits", "10", "--quiet"]) == 0
    found = pm.load_photo(tmp_path / "box-sensor").record["sensor"]
    assert (found["iso"], found["read_noise"], found["mosaic"], found["bits"]) == (
        3200,
        2.5,
        "BGGR",
        10,
    )
    assert pm.load_sensor("night.toml") == pm.Sensor(
        iso=3200.0, read_noise=2.5, mosaic="BGGR", bits=12
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["--camera", "Nikkon"],
            "camera 'Nikkon' is not known; did you mean 'Nikon 5100 (NPL)'? Known are",
        ),
        (["--camera", "none.csv"], "error: none.csv: cannot be read"),
        (["--sensor", "nikon.toml"], "nikon.toml:1: camera: 'nikkon' is not known; did you mean"),
        (["--camera", "rgb"], "rgb has no sensitivities"),
        (["--bits", "0"], "bits 0 must be a whole number from 1 to 16"),
        (["--bits", "8", "--black-level", "255"], "black_level 255 must be below"),
        (["--time", "0"], "time 0.0 is not a number above 0"),
        (["--time", "nan"], "time nan is not a number"),
        (["--iso", "fast"], "'fast' is not a number"),
        (["--read-noise", "-1"], "read_noise -1.0 is not a number from 0"),
        (["--mosaic", "RGGX"], "names X, but the camera has"),
        (["--mosaic", "RGGBR"], "not a square"),
        (["--vignetting", "dark"], "'dark' is not none, cos4, or numbers"),
        (["--psf", "gaussian"], "'gaussian' is not none, gaussian:S"),
        (["--psf", "defocus:0"], "is not none, gaussian:S"),
        (["--demosaic", "ahd"], "invalid choice: 'ahd'"),
        (["--percentile", "101"], "percentile 101.0 is not a number from 0 to 100"),
        (["--seed", "-1"], "is not a whole number"),
        (["--sensor", "missing.toml"], "missing.toml: cannot be read"),
        (["--sensor", NIKON], "is not a FILE.toml"),
        (["--sensor", "bad.toml"], "bad.toml:2: key 'isso' is not known"),
        (["--sensor", "wrong.toml"], "wrong.toml:1: iso: "),
        (["-o", "box.exr"], "this is a file"),
    ],
)
def test_bad_options(image, tmp_path, capsys, arguments, message):
    (tmp_path / "bad.toml").write_text("bits = 12\nisso = 3\n")
    (tmp_path / "wrong.toml").write_text('iso = "fast"\n')
    (tmp_path / "nikon.toml").write_text('camera = "nikkon"\n')
    before = sorted(tmp_path.rglob("*"))
    assert main(["sensor", image, *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_bad_images(tmp_path, monkeypatch, capsys, box):
    monkeypatch.chdir(tmp_path)
    box.select(["direct"]).save("direct.exr")
    black = flat([0.0, 0.0, 0.0], NIKON)
    black.save("black.exr")
    (tmp_path / "note.exr").write_text("no image")
    for name, message in (
        ("missing.exr", "there is no such file"),
        ("note.exr", "not an OpenEXR file"),
        ("direct.exr", "has no radiance"),
        ("black.exr", "is black, and no exposure can be chosen"),
    ):
        assert main(["sensor", name]) == 2
        error = capsys.readouterr().err
        assert message in error
        assert name in error
        assert error.count("\n") == 1
    assert not list(tmp_path.glob("*-sensor"))
    with pytest.raises(pm.InputError, match="not finite"):
        pm.expose(render_of(np.full((4, 4, 3), np.nan), NIKON))
    with pytest.raises(pm.InputError, match="smaller than the mosaic"):
        pm.expose(flat([1.0, 1.0, 1.0], NIKON, size=(1, 5)))
    with pytest.raises(pm.InputError, match="holds a photo"):
        pm.load_photo(tmp_path)


def test_a_damaged_photo(box, tmp_path):
    pm.save_photo(pm.expose(box), tmp_path)
    (tmp_path / "truth.npz").write_bytes(b"")
    with pytest.raises(pm.InputError, match="is damaged"):
        pm.load_photo(tmp_path)


def test_options_are_documented():
    """Every keyword of a sensor is a flag, with its help."""
    assert all(option.help and option.group for option in OPTIONS.values())


@pytest.mark.parametrize("camera", [6, pm.Bands.gaussian(3)])
def test_cameras_are_texts(camera):
    with pytest.raises(pm.InputError, match=r"camera .* is not a text; write .*, as in '6'"):
        pm.Sensor(camera=camera)
