"""Photos in a data set: written, read, checked, and reproduced from the files of the image."""

import json

import numpy as np
import pytest

import photonmap as pm
from photonmap import dataset
from photonmap.commands.main import main

PRESET = """scenes = ["jug"]
illuminations = ["white"]
[[view]]
name = "own"
[[view]]
name = "left"
yaw = 9
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Two images of a jug with photos of a camera at ISO 800."""
    folder = tmp_path_factory.mktemp("photos")
    (folder / "preset.toml").write_text(PRESET)
    (folder / "night.toml").write_text("iso = 800\nbits = 12\n")
    assert make(folder) == 0
    return folder


def make(folder, *more, sensor="night.toml"):
    arguments = ["--preset", str(folder / "preset.toml"), "--sensor", str(folder / sensor)]
    arguments += ["--size", "24x18", "--error", "0.5", "--bands", "3", "--format", "exr", "--quiet"]
    return main(["dataset", str(folder / "OUT"), *arguments, *more])


def test_every_image_has_its_photo(made):
    images = dataset.open_dataset(made / "OUT")
    assert images.head["sensor"]["iso"] == 800.0
    seeds = set()
    for image in images:
        photo = image.photo
        assert photo.raw.shape == (18, 24)
        assert photo.record["sensor"]["bits"] == 12
        assert "photo/raw.dng" in image.entry["files"]
        assert image.entry["photo"]["time_s"] == photo.record["time_s"] > 0.0
        seeds.add(photo.record["seed"])
    assert len(seeds) == 2


def test_the_command_gives_the_same_photo(made, tmp_path):
    """Of the file of an image, byte for byte."""
    image = dataset.open_dataset(made / "OUT")[0]
    seed = str(image.photo.record["seed"])
    command = ["sensor", str(image.folder / "bands.exr"), "--sensor", str(made / "night.toml")]
    assert main([*command, "--seed", seed, "-o", str(tmp_path), "--quiet"]) == 0
    for path in (image.folder / "photo").iterdir():
        assert (tmp_path / path.name).read_bytes() == path.read_bytes(), path.name


def test_verify(made, capsys):
    assert main(["dataset", "verify", str(made / "OUT"), "--sample", "0", "--quiet"]) == 0
    image = dataset.open_dataset(made / "OUT")[0]
    from photonmap.dataset.jobs.verify import check_photo

    assert not [*check_photo(image)]
    image.photo.raw[3, 3] += 1
    assert [*check_photo(image)] == ["the photo is not that of the radiance"]


def test_a_set_has_one_sensor(made, capsys):
    (made / "day.toml").write_text("iso = 100\n")
    assert make(made, "--resume", sensor="day.toml") == 2
    error = capsys.readouterr().err
    assert "it was begun with another --sensor; choose" in error
    assert error.count("\n") == 1
    assert make(made, "--resume") == 0


@pytest.mark.parametrize(
    ("sensor", "message"),
    [("none.toml", "cannot be read"), ("../Nikonn", "is not known")],
)
def test_sensors_that_there_are_not(made, capsys, sensor, message):
    assert make(made, "--resume", sensor=sensor) == 2
    assert message in capsys.readouterr().err


def test_sensitivities_are_part_of_the_set(tmp_path):
    """A file of the same name with other curves makes another set."""
    from photonmap.dataset.files.image_files import choose_sensor

    heads = []
    for shift in (0.0, 10.0):
        nm = np.arange(380.0, 731.0, 10.0)
        curves = [np.exp(-0.5 * ((nm - at - shift) / 40) ** 2) for at in (600, 540, 450)]
        np.savetxt(tmp_path / "c.csv", np.stack([nm, *curves], axis=1), delimiter=",")
        heads.append(choose_sensor(str(tmp_path / "c.csv"))[1])
    assert heads[0]["camera"] == heads[1]["camera"] == "c.csv"
    assert heads[0]["sensitivities"] != heads[1]["sensitivities"]
    assert json.dumps(heads[0])
    assert choose_sensor(None) == (None, None)
    assert isinstance(choose_sensor("Nikon 5100 (NPL)")[0], pm.Sensor)


@pytest.mark.filterwarnings("always::photonmap.SceneWarning")
def test_warnings_name_the_image_but_records_do_not(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("photonmap.capture.expose._MOST_NEGATIVE", -1.0)
    (tmp_path / "preset.toml").write_text(PRESET.partition('[[view]]\nname = "left"')[0])
    (tmp_path / "night.toml").write_text("bits = 12\n")
    assert make(tmp_path) == 0
    told = capsys.readouterr().err
    for image in dataset.open_dataset(tmp_path / "OUT"):
        assert f"warning: {image.name}: 0.0% of the camera's values are below 0" in told
        assert not any(image.name in line for line in image.entry["warnings"])
