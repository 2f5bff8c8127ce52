"""What data sets are published with."""

import json
import re
import shutil
import subprocess
import warnings

import mlcroissant
import numpy as np
import pytest

from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.files.splits import part_of
from photonmap.dataset.jobs.verify import verify
from photonmap.dataset.publication.metadata import (
    CATEGORIES,
    FIRST_OWN,
    categories_of,
    encode_mask,
    kind_of,
)
from photonmap.errors import SceneWarning

FILES = ["LICENSE", "README.md", "SHA256SUMS", "annotations.json", "cameras.json", "croissant.json"]


@pytest.fixture(scope="module")
def published(tmp_path_factory):
    folder = tmp_path_factory.mktemp("published")
    (folder / "two.toml").write_text('scenes = ["jug"]\nilluminations = ["white", "two_mixed"]')
    arguments = ["--preset", str(folder / "two.toml"), "--size", "16x12", "--bands", "3"]
    made = folder / "set"
    assert main(["dataset", str(made), *arguments, "--error", "0.5", "--quiet"]) == 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)  # of splits without scenes
        assert main(["dataset", "publish", str(made), "--license", "CC-BY-4.0", "--quiet"]) == 0
    return made


def load(folder, name):
    return json.loads((folder / name).read_text())


def test_all_files_are_there_and_the_set_is_still_whole(published):
    assert all((published / name).is_file() for name in FILES)
    assert verify(published, sample=0) == []
    assert not list(published.glob(".photonmap-*"))
    assert "creativecommons.org/licenses/by/4.0/" in (published / "LICENSE").read_text()


@pytest.mark.skipif(shutil.which("sha256sum") is None, reason="there is no sha256sum")
def test_checksums_hold(published):
    command = ["sha256sum", "--check", "--strict", "--quiet", "SHA256SUMS"]
    subprocess.run(command, cwd=published, check=True)
    listed = {line.split("  ")[1] for line in (published / "SHA256SUMS").read_text().splitlines()}
    [first, _] = dataset.open(published)
    assert {"manifest.jsonl", "README.md", f"{first.name}/bands.exr"} <= listed


def decode(segmentation):
    """Return a mask from its runs, by the rules of COCO."""
    runs = segmentation["counts"]
    flat = np.repeat(np.arange(len(runs)) % 2 == 1, runs)
    return flat.reshape(segmentation["size"], order="F")


def test_masks_are_those_of_the_ids(published):
    coco = load(published, "annotations.json")
    kinds = {each["id"]: each["name"] for each in coco["categories"]}
    for number, image in enumerate(dataset.open(published), 1):
        assert coco["images"][number - 1]["file_name"] == f"{image.name}/radiance.png"
        found = [each for each in coco["annotations"] if each["image_id"] == number]
        seen = {image.entry["objects"][i - 1] for i in np.unique(image["object_id"]) if i}
        assert {each["object"] for each in found} == seen
        for each in found:
            mask = image["object_id"] == image.entry["objects"].index(each["object"]) + 1
            np.testing.assert_array_equal(decode(each["segmentation"]), mask)
            left, top, wide, high = each["bbox"]
            box = mask[top : top + high, left : left + wide]
            assert box.sum() == mask.sum() == each["area"]
            assert box[0].any()
            assert box[-1].any()
            assert box[:, 0].any()
            assert box[:, -1].any()
            assert kind_of(each["object"]) == kinds[each["category_id"]]


def test_categories_have_the_labels_that_vision_knows(published):
    coco = {each["name"]: each for each in load(published, "annotations.json")["categories"]}
    assert len({each["id"] for each in coco.values()}) == len(coco)
    for name, each in coco.items():
        assert each == CATEGORIES[name].describe(), "as in any other set"
    chair, walls = CATEGORIES["armchair"].describe(), CATEGORIES["walls"].describe()
    assert (chair["supercategory"], chair["nyu40"]["id"], chair["coco"]["id"]) == ("seat", 5, 62)
    assert (walls["nyu40"], walls["coco"]) == ({"id": 1, "name": "wall"}, None)
    found = categories_of(["chair 2", "my rocket", "my rocket 2", "an engine"])
    assert [(each.name, each.number) for each in found.values()] == [
        ("chair", CATEGORIES["chair"].number),
        ("an engine", FIRST_OWN),
        ("my rocket", FIRST_OWN + 1),
    ]


def test_numbers_of_categories_stay():
    """They are published: new kinds come after these, and none changes."""
    names = ("walls", "chair", "table", "book", "parasol")
    assert [CATEGORIES[name].number for name in names] == [1, 22, 29, 67, 85]


@pytest.mark.parametrize("seed", range(4))
def test_runs_of_any_mask(seed):
    mask = np.random.default_rng(seed).random((5, 7)) < 0.5
    np.testing.assert_array_equal(decode(encode_mask(mask)), mask)
    for whole in (np.zeros((2, 3), bool), np.ones((2, 3), bool)):
        np.testing.assert_array_equal(decode(encode_mask(whole)), whole)


def test_cameras_project_what_is_seen(published):
    """Points at the depth of their pixels come back to the centres of these pixels."""
    cameras = load(published, "cameras.json")["images"]
    for image in dataset.open(published):
        camera = cameras[image.name]
        matrix, pose = (np.array(camera[k]) for k in ("intrinsics", "camera_to_world_opencv"))
        row, column = 6, 8
        pixel = np.array([column + 0.5, row + 0.5, 1.0])
        ray = np.linalg.solve(matrix, pixel)
        world = pose[:3, :3] @ (ray * image["depth"][row, column]) + pose[:3, 3]
        length = np.linalg.norm(world - camera["origin"])
        assert length == pytest.approx(image["distance"][row, column], rel=1e-5)


def test_the_card_says_what_is_there(published):
    text = (published / "README.md").read_text()
    assert text.startswith("---\nlicense: cc-by-4.0\n")
    assert "2 renders of 1 scenes" in text
    assert "| jug | 2 |" in text
    assert "| two_mixed | 1 |" in text
    assert "| white | `D65` |" in text
    assert re.search(r"\| two_mixed \| `[^`]+` \+ `[^`]+` \|", text)
    assert "| view | images |" not in text
    assert "Seeds of scenes: 0 to 0." in text
    assert f"| {part_of('jug-0')} | 2 |" in text


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_croissant_reads_the_metadata(published):
    found = mlcroissant.Dataset(jsonld=str(published / "croissant.json"))
    records = [record["images/name"] for record in found.records("images")]
    names = [name.decode() if isinstance(name, bytes) else name for name in records]
    assert names == [image.name for image in dataset.open(published)]


def test_licences_are_named(published):
    """The set's for each image in COCO's JSON; in the card, those of what it is made from."""
    described = load(published, "annotations.json")
    [license_] = described["licenses"]
    assert license_["name"].startswith("CC-BY-4.0")
    assert license_["url"] == "https://creativecommons.org/licenses/by/4.0/"
    assert {image["license"] for image in described["images"]} == {license_["id"]}
    card = (published / "README.md").read_text()
    assert "renotation of Newhall, Nickerson and Judd" in card
    assert "colour-science (BSD-3-Clause)" in card
    assert "not part of this set" not in card


@pytest.mark.filterwarnings("always::photonmap.SceneWarning")
def test_splits_without_scenes_are_warned_of(published, capsys):
    assert main(["dataset", "publish", str(published), "--license", "CC-BY-4.0"]) == 0
    assert "no scene is in val and test; a larger --count adds some" in capsys.readouterr().err


def test_croissant_describes_fields_that_exist(published):
    described = load(published, "croissant.json")
    [records] = described["recordSet"]
    entry = dataset.open(published)[0].entry
    for field in records["field"]:
        value = entry[field["source"]["extract"]["column"]]
        assert isinstance(value, float if field["dataType"] == "sc:Float" else str)
    assert described["license"] == "https://creativecommons.org/licenses/by/4.0/"


@pytest.mark.filterwarnings("ignore::photonmap.SceneWarning")
def test_what_cannot_be_published(published, tmp_path, capsys):
    assert main(["dataset", "publish", str(published)]) == 2
    assert "add --license CC-BY-4.0" in capsys.readouterr().err
    assert main(["dataset", "publish", str(published), "--license", "CC-BY"]) == 2
    assert "there is no license 'CC-BY'; did you mean" in capsys.readouterr().err
    copied = shutil.copytree(published, tmp_path / "copied")
    lines = (copied / "manifest.jsonl").read_text().splitlines()
    (copied / "manifest.jsonl").write_text(lines[0] + "\n")
    (copied / "README.md").unlink()
    (tmp_path / "mine.txt").write_text("as I like")
    assert main(["dataset", "publish", str(copied), "--license", str(tmp_path / "mine.txt")]) == 2
    assert "1 images are missing" in capsys.readouterr().err
    assert not (copied / "README.md").exists()
    (copied / "manifest.jsonl").write_text("\n".join(lines) + "\n")
    mine = ["--license", str(tmp_path / "mine.txt"), "--quiet"]
    assert main(["dataset", "publish", str(copied), *mine]) == 0
    assert (copied / "LICENSE").read_text() == "as I like"
    assert (copied / "README.md").read_text().startswith("---\nlicense: other\n")
