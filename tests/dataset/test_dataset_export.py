"""Exported data sets: read back by the packages that they are for, and over HTTP by ranges."""

import hashlib
import io
import json
import tarfile
import threading
import warnings
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest

import photonmap as pm
from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.publication.export import Samples, export, members_of

ARRAYS = "rgb.radiance,rgb.shading,shading,object_id,valid"
NAMES = ("radiance", "direct", "indirect", "reflectance", "shading")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A set of scenes of which one is for training and one for tests."""
    folder = tmp_path_factory.mktemp("exported")
    (folder / "two.toml").write_text('scenes = ["jug"]\nilluminations = ["white", "two_mixed"]')
    size = ["--size", "16x12", "--bands", "4", "--error", "0.5", "--quiet"]
    arguments = ["--preset", str(folder / "two.toml"), "--count", "2", "--seed", "10", *size]
    assert main(["dataset", str(folder / "set"), *arguments]) == 0
    return dataset.open(folder / "set")


@pytest.fixture(scope="module")
def shards(made, tmp_path_factory):
    return exported(made, tmp_path_factory.mktemp("shards") / "out", "webdataset")


def exported(made, output, layout, size="10k"):
    words = ["dataset", "export", str(made.folder), str(output), "--layout", layout, "--quiet"]
    more = ["--arrays", ARRAYS, "--shard-size", size, "--license", "CC-BY-4.0"]
    with warnings.catch_warnings():
        warnings.simplefilter("always", pm.SceneWarning)
        assert main([*words, *more]) == 0
    return output


def splits(made):
    return sorted({image.entry["split"] for image in made})


@pytest.mark.filterwarnings("ignore::ResourceWarning")  # webdataset leaves its files open
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_webdataset_reads_the_shards(made, shards):
    webdataset = pytest.importorskip("webdataset")
    found = {}
    for path in sorted(shards.glob("*.tar")):
        source = webdataset.WebDataset(str(path), shardshuffle=False, empty_check=False)
        for sample in source.decode():
            split = path.name.rpartition("-")[0]
            found[sample["json"]["name"]] = {**sample, "split": split}
    assert sorted(found) == sorted(image.name for image in made)
    for image in made:
        sample = found[image.name]
        assert sample["split"] == image.entry["split"]
        for name in ("shading", "object_id", "valid"):
            np.testing.assert_array_equal(sample[f"{name}.npy"], image[name])
            kind = np.float16 if name in image.halves else image[name].dtype
            assert sample[f"{name}.npy"].dtype == kind
        np.testing.assert_array_equal(sample["rgb.shading.npy"], image.rgb["shading"])
        assert sample["json"]["camera"] == image.entry["camera"]


def test_lean_sets_are_exported_in_half_precision(made, shards):
    """Values are those of the files, and take half the room; lengths, ids and masks stay."""
    halves = json.loads((shards / "shards.json").read_text())["halves"]
    assert halves == ["rgb.radiance", "rgb.shading", "shading"]
    for line in map(json.loads, (shards / "index.jsonl").read_text().splitlines()):
        assert line["members"]["shading.npy"][1] == 128 + 2 * 16 * 12 * 4
        assert line["members"]["object_id.npy"][1] == 128 + 4 * 16 * 12
    for image in made:
        assert image.halves >= {"radiance", "shading", "normal"}
        assert not image.halves & {"depth", "distance", "object_id", "valid", "scalar_shading"}
        for name in image.halves:
            rounded = image[name].astype(np.float16).astype(np.float32)
            np.testing.assert_array_equal(image[name], rounded)


def test_an_array_has_one_type_in_all_samples(made, monkeypatch):
    """Where one image needs single precision, so have all."""
    names = ["shading", "rgb.shading", "depth"]
    samples = Samples({"train": list(made)}, names, 0.0, print)
    assert samples.halves() == {"shading", "rgb.shading"}
    bright = made[1].name
    held = dataset.Image.halves.fget

    def without(image):
        return held(image) - ({"shading"} if image.name == bright else set())

    monkeypatch.setattr(dataset.Image, "halves", property(without))
    assert samples.halves() == {"rgb.shading"}
    [first, *_] = made
    for halves, kind in ((("shading",), np.float16), ((), np.float32)):
        data = members_of(first, ["shading"], halves)["shading.npy"]
        assert np.load(io.BytesIO(data)).dtype == kind


def test_shards_have_their_size_and_checksums(made, shards):
    listed = json.loads((shards / "shards.json").read_text())["shards"]
    assert {each["name"] for each in listed} == {path.name for path in shards.glob("*.tar")}
    assert {each["split"] for each in listed} == set(splits(made))
    assert len(listed) == len(made), "each sample is larger than a shard should be"
    for each in listed:
        data = (shards / each["name"]).read_bytes()
        assert each["bytes"] == len(data)
        assert each["sha256"] == hashlib.sha256(data).hexdigest()


def test_large_shards_hold_many_samples(made, tmp_path, capsys):
    folder = exported(made, tmp_path / "out", "webdataset", "100M")
    assert "no scene is in test; a larger --count adds some" in capsys.readouterr().err
    assert len(list(folder.glob("*.tar"))) == len(splits(made))
    again = exported(made, tmp_path / "again", "webdataset", "100M")
    for path in folder.iterdir():
        assert path.read_bytes() == (again / path.name).read_bytes(), "equal sets, equal files"
    lines = [json.loads(line) for line in (folder / "index.jsonl").read_text().splitlines()]
    assert any(line["offset"] > 0 for line in lines)
    for line in lines:
        with (folder / line["shard"]).open("rb") as file:
            file.seek(line["offset"])
            part = file.read(line["length"])
        with tarfile.open(fileobj=io.BytesIO(part), mode="r:") as tar:
            assert [each.name for each in tar] == [f"{line['key']}.{e}" for e in line["members"]]
    samples = dataset.open_shards(folder)
    for image in made:
        np.testing.assert_array_equal(samples[image.name]["shading"], image["shading"])
        assert samples[image.name]["shading"].dtype == np.float32
        assert samples[image.name]["json"]["name"] == image.name


class Ranged(SimpleHTTPRequestHandler):
    """Serves ranges of files, and counts the bytes that it sends."""

    sent: list[int]

    def do_GET(self):
        path = self.server.folder / self.path.lstrip("/")
        if not path.is_file():
            self.send_error(404)
            return
        data = path.read_bytes()
        asked = self.headers.get("Range") if self.server.knows_ranges else None
        if asked:
            first, last = map(int, asked.removeprefix("bytes=").split("-"))
            self.send_response(206)
            self.send_header("Content-Range", f"bytes {first}-{last}/{len(data)}")
            data = data[first : last + 1]
        else:
            self.send_response(200)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.server.sent.append(len(data))
        self.wfile.write(data)

    def log_message(self, *arguments):
        """Say nothing."""


@pytest.fixture
def server(shards):
    with ThreadingHTTPServer(("127.0.0.1", 0), Ranged) as server:
        server.folder, server.sent, server.knows_ranges = shards, [], True
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server
        server.shutdown()
        thread.join()


def test_a_sample_is_read_over_http(made, shards, server):
    samples = dataset.open_shards(f"http://127.0.0.1:{server.server_port}/")
    lines = (shards / "index.jsonl").read_text().splitlines()
    assert list(samples) == [json.loads(line)["name"] for line in lines]
    image = made[1]
    server.sent.clear()
    np.testing.assert_array_equal(samples[image.name]["rgb.shading"], image.rgb["shading"])
    assert server.sent == [16 * 12 * 3 * 2 + 128], "one array, and no other byte"
    picture = samples[image.name]["radiance.png"]
    assert picture == (image.folder / "radiance.png").read_bytes()
    with pytest.raises(KeyError, match="'depth' is not one of 'json'"):
        samples[image.name]["depth"]
    server.knows_ranges = False
    with pytest.raises(pm.InputError, match="use a server that knows ranges"):
        samples[image.name]["shading"]
    server.folder = shards.parent
    with pytest.raises(pm.InputError, match=r"^[^\n]*cannot be read"):
        samples[image.name]["shading"]


def test_datasets_reads_the_tables(made, tmp_path, monkeypatch):
    pytest.importorskip("pyarrow")
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    monkeypatch.setenv("HF_HOME", str(tmp_path / "home"))
    datasets = pytest.importorskip("datasets")
    folder = exported(made, tmp_path / "out", "huggingface")
    found = datasets.load_dataset(str(folder), cache_dir=str(tmp_path / "cache"))
    names = {"val": "validation"}
    assert sorted(found) == sorted(names.get(part, part) for part in splits(made))
    rows = {row["name"]: row for part in found.values() for row in part}
    assert len(rows) == len(made)
    for image in made:
        row = rows[image.name]
        for name in ("shading", "object_id", "valid"):
            array = np.load(io.BytesIO(row[f"{name}_npy"]))
            np.testing.assert_array_equal(array, image[name])
        array = np.load(io.BytesIO(row["rgb_radiance_npy"]))
        np.testing.assert_array_equal(array, image.rgb["radiance"])
        assert json.loads(row["manifest"])["lights"] == image.entry["lights"]
        assert (row["scene"], row["width"], row["height"]) == (image.geometry, 16, 12)
    part = next(iter(found.values()))
    assert all(isinstance(part.features[name], datasets.Image) for name in NAMES)


def test_the_card_goes_with_the_layout(made, shards, tmp_path):
    text = (shards / "README.md").read_text()
    assert text.startswith("---\nlicense: cc-by-4.0\n")
    assert "webdataset.WebDataset(" in text
    assert "creativecommons.org/licenses/by/4.0/" in (shards / "LICENSE").read_text()
    pytest.importorskip("pyarrow")
    folder = exported(made, tmp_path / "out", "huggingface")
    assert "configs:\n- config_name: default\n" in (folder / "README.md").read_text()


def test_what_cannot_be_exported(made, shards, tmp_path, capsys):
    words = ["dataset", "export", str(made.folder)]
    license_ = ["--license", "CC0-1.0"]
    for arguments, message in (
        ([*words, str(tmp_path / "a")], "export needs a license"),
        ([*words], "export needs the folder of a data set and a new one"),
        ([*words, str(shards), *license_], "is not empty; choose a new folder"),
        ([*words, str(tmp_path / "a"), *license_, "--arrays", "shadin"], "has no array 'shadin'"),
        ([*words, str(tmp_path / "a"), *license_, "--shard-size", "7"], "are too small"),
        (["dataset", "export", str(tmp_path), "b", *license_], "does not hold a data set"),
    ):
        assert main(arguments) == 2
        printed = capsys.readouterr().err
        assert message in printed
        assert printed.count("\n") == 1
    assert not (tmp_path / "a").exists()
    with pytest.raises(pm.InputError, match="there is no layout 'tar'"):
        export(made.folder, tmp_path / "a", "tar", "CC0-1.0")
    with pytest.raises(pm.InputError, match="cannot be read"):
        dataset.open_shards(tmp_path)
