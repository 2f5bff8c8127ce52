"""Data sets that someone has changed: nothing outside them is read, and no change is believed."""

import copy
import csv
import hashlib
import json
import math
import re
import shutil
import warnings
from itertools import islice
from pathlib import Path, PurePosixPath, PureWindowsPath

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import photonmap as pm
from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.files.image_files import hash_files
from photonmap.dataset.files.inside import fault_of, inside
from photonmap.dataset.files.schema import GROWN_HEAD_KINDS, faults_of_entry, misfits
from photonmap.dataset.jobs.flows import write_flows
from photonmap.dataset.jobs.job_scene import make_scene
from photonmap.dataset.jobs.manifest_checks import (
    check_entry,
    check_files,
    check_head,
    check_scene,
)
from photonmap.dataset.jobs.plan import Job
from photonmap.dataset.jobs.render_image import ENTRY
from photonmap.dataset.jobs.verify import check_digests, verify, version_faults
from photonmap.evaluate.bench.predictions import predictions
from photonmap.report.tables import write_csv

PRESET = 'scenes = ["jug"]\nilluminations = ["white"]\n'
SIZE = ["--size", "12x8", "--bands", "3", "--error", "0.5", "--quiet"]
OUTSIDE = (
    "../out", "/etc/passwd", "a/../../b", "C:/a", "a\\b", "", ".", "..", "a//b", "a\nb",
    "nul", "COM1.exr", "a.", "a ", "\ud800", "a\u2028b", "x" * 256, 7, None, ["a"],
)  # fmt: skip


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A set of one image in every format, with a photo."""
    home = tmp_path_factory.mktemp("trust")
    (home / "one.toml").write_text(PRESET)
    more = ["--format", "exr,hdf5,png", "--sensor", "4"]
    folder = home / "set"
    assert main(["dataset", str(folder), "--preset", str(home / "one.toml"), *SIZE, *more]) == 0
    return folder


@pytest.fixture
def copied(made, tmp_path):
    return shutil.copytree(made, tmp_path / "set")


@pytest.fixture(scope="module")
def shards(made, tmp_path_factory):
    output = tmp_path_factory.mktemp("shards") / "out"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pm.SceneWarning)  # of splits without scenes
        words = ["dataset", "export", str(made), str(output), "--license", "CC0-1.0", "--quiet"]
        assert main(words) == 0
    return output


def rewrite(folder, change, file="manifest.jsonl"):
    """Change the first line of a manifest or an index, which is JSON."""
    first, *rest = (folder / file).read_text().splitlines()
    line = json.loads(first)
    change(line)
    (folder / file).write_text("\n".join([json.dumps(line), *rest]) + "\n")


@pytest.mark.parametrize("name", OUTSIDE, ids=lambda name: repr(name)[:12])
def test_names_that_leave_a_folder(tmp_path, name):
    with pytest.raises(pm.InputError, match=r"^[^\n]*is no path inside a set, as it ") as caught:
        inside(tmp_path, name)
    assert str(tmp_path) in str(caught.value)


@given(st.lists(st.sampled_from(["a", "..", ".", "", "con", "C:", "b.exr", "\\", "é", "\x00", " "]),
                min_size=1, max_size=5).map("/".join) | st.text(max_size=12))  # fmt: skip
def test_what_is_followed_stays_inside_on_every_system(name):
    """As pathlib's own rules for both systems say, which are not used to decide it."""
    if fault_of(name):
        return
    for kind in (PurePosixPath, PureWindowsPath):
        path = kind("root") / name
        assert path.parts == ("root", *name.split("/"))
        assert not kind(name).drive
        assert ".." not in path.parts
    assert not PureWindowsPath(name).is_reserved()
    assert name.isprintable() or not any(ord(each) < 32 for each in name)


@given(st.lists(st.text("abcXYZ0189-_.@ é", min_size=1, max_size=8), min_size=1, max_size=4))
def test_honest_names_are_followed(parts):
    name = "/".join(f"x{part}x" for part in parts)
    assert fault_of(name) == ""
    assert (fault_of(name, is_part=True) == "") == (len(parts) == 1)


def test_links_that_leave_a_folder(tmp_path):
    (tmp_path / "secret").write_text("x")
    root = tmp_path / "set"
    (root / "image").mkdir(parents=True)
    (root / "image" / "own").write_text("x")
    (root / "alias").symlink_to("image")
    (root / "out").symlink_to(tmp_path)
    (root / "image" / "file").symlink_to(tmp_path / "secret")
    (tmp_path / "link").symlink_to(root)
    assert inside(tmp_path / "link", "alias/own").read_text() == "x"
    for name in ("out", "out/secret", "image/file", "alias/file"):
        with pytest.raises(pm.InputError, match="is a link that leaves the folder"):
            inside(root, name)


@pytest.mark.parametrize("name", ["../out", "/tmp", "a/b", "C:x", "nul", None])
def test_manifests_that_name_other_folders(copied, name):
    rewrite(copied, lambda line: line.update(name=name))
    where = r"manifest.jsonl:1: .* is no path inside a set"
    for use in (dataset.open, verify, write_flows):
        with pytest.raises(pm.InputError, match=where):
            use(copied)
    words = ["--license", "CC0-1.0", "--quiet"]
    assert main(["dataset", "publish", str(copied), *words]) == 2
    assert main(["dataset", "export", str(copied), str(copied.parent / "out"), *words]) == 2
    assert not (copied / "SHA256SUMS").exists()
    assert not (copied.parent / "out").exists()


def test_manifests_that_name_other_files(copied, capsys):
    secret = copied.parent / "secret"
    secret.write_text("x")
    digest = hashlib.sha256(b"x").hexdigest()
    rewrite(copied, lambda line: line["files"].update({"../../secret": digest}))
    assert main(["dataset", "verify", str(copied), "--sample", "0"]) == 2
    assert "'../../secret' is no path inside a set" in capsys.readouterr().err
    head = json.loads((copied / "manifest.json").read_text())
    head["images"] = ["../out"]
    (copied / "manifest.json").write_text(json.dumps(head))
    with pytest.raises(pm.InputError, match=r"manifest\.json: '\.\./out' is no path inside a set"):
        dataset.open(copied)


def test_images_that_are_links(copied):
    [image] = dataset.open(copied)
    moved = copied.parent / "moved"
    (image.folder / "bands.exr").rename(copied.parent / "bands.exr")
    (image.folder / "bands.exr").symlink_to(copied.parent / "bands.exr")
    with pytest.raises(pm.InputError, match=r"'bands\.exr' is a link that leaves the folder"):
        image["shading"]
    assert any("is a link that leaves" in fault for fault in verify(copied, sample=0))
    image.folder.rename(moved)
    image.folder.symlink_to(moved)
    with pytest.raises(pm.InputError, match="is a link that leaves the folder"):
        dataset.open(copied)[0]


def test_predictions_that_are_links(tmp_path):
    np.savez(tmp_path / "secret.npz", reflectance=np.ones((2, 2, 3)))
    root = tmp_path / "mine"
    root.mkdir()
    (root / "a.npz").symlink_to(tmp_path / "secret.npz")
    method = predictions(root, ["a"])
    view = type("View", (), {"name": "a"})()
    with pytest.raises(pm.InputError, match="is a link that leaves the folder"):
        method.estimate(view)


@pytest.mark.parametrize("shard", ["../secret", "/etc/passwd", "a/b.tar", None, "link.tar"])
def test_shards_outside_their_folder(shards, tmp_path, shard):
    folder = shutil.copytree(shards, tmp_path / "out")
    (tmp_path / "secret").write_text("secret" * 999)
    (folder / "link.tar").symlink_to(tmp_path / "secret")
    rewrite(folder, lambda line: line.update(shard=shard), "index.jsonl")
    with pytest.raises(pm.InputError, match=r"^[^\n]*(is no path inside|link that leaves|a text)"):
        next(iter(dataset.open_shards(folder).values()))["json"]


@pytest.mark.parametrize(
    "place",
    [
        [0, 1e12],
        [0, 10**12],
        [10**12, 4],
        [-1, 4],
        None,
        ["a", "b"],
        [1],
        [True, 4],
        {},
        [0, 10**30],
    ],
)
def test_damaged_places_in_shards(shards, tmp_path, place):
    folder = shutil.copytree(shards, tmp_path / "out")
    rewrite(folder, lambda line: line["members"].update(json=place), "index.jsonl")
    with pytest.raises(pm.InputError, match=r"^[^\n]*(is damaged|shorter than its index)"):
        next(iter(dataset.open_shards(folder).values()))["json"]


@pytest.mark.parametrize("text", ["null", "[]", '"a"', "[" * 10**5, "7", '["name"]', "{}", "{"])
def test_damaged_indices(shards, tmp_path, text):
    folder = shutil.copytree(shards, tmp_path / "out")
    (folder / "index.jsonl").write_text(text + "\n")
    with pytest.raises(pm.InputError, match=r"^[^\n]*(is damaged|is not an index)[^\n]*export"):
        dataset.open_shards(folder)
    manifest = folder / "manifest.jsonl"
    (folder / "manifest.json").write_text("[" * 10**5)
    with pytest.raises(pm.InputError, match=r"is damaged and cannot be read"):
        dataset.open(folder)
    assert not manifest.exists()


def test_arrays_of_shards_that_claim_another_size(shards, tmp_path):
    folder = shutil.copytree(shards, tmp_path / "out")
    [line] = map(json.loads, (folder / "index.jsonl").read_text().splitlines())
    offset, _ = line["members"]["depth.npy"]
    path = Path(folder / line["shard"])
    data = path.read_bytes()
    head = data[offset : offset + 128]
    huge = head.replace(b"(8, 12), }" + b" " * 18, b"(1000000000, 1000000000), }").ljust(128)
    assert len(huge) == 128
    for changed in (huge[:127] + b"\n", b"x" * 128):
        path.write_bytes(data[:offset] + changed + data[offset + 128 :])
        [sample] = dataset.open_shards(folder).values()
        with pytest.raises(pm.InputError, match=r"depth.npy is damaged"):
            sample["depth"]
        assert sample["valid"].any()


def changes(value, place=()):
    """Yield each change of one value within JSON: its place, and what is put there, or GONE."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from changes(inner, (*place, name))
            if place or name not in READERS_KEYS:
                yield (*place, name), GONE
    elif isinstance(value, list):
        for index, inner in enumerate(value[:3]):
            yield from changes(inner, (*place, index))
        yield place, [*value, 1e9]
        yield place, value[:-1] if value else None
    elif isinstance(value, bool):
        yield from ((place, other) for other in (not value, "yes", None))
    elif isinstance(value, str):
        yield from ((place, other) for other in (value + "x", "../" + value, 7, None))
    elif value is None:
        yield from ((place, other) for other in (7, "x", [1], math.nan))
    else:
        near = value + 1 if isinstance(value, int) else 1.25 * value + 0.125
        yield from ((place, other) for other in (near, math.nan, math.inf, -1e9, "7", [value]))


GONE = object()
READERS_KEYS = {"name", "geometry", "job", "files"}
"""Keys of entries without which a set is not even opened."""
BELIEVED = {"seconds", "cpu_seconds", "preset"}
"""Whose values can be checked for their kind and range alone: nothing else knows them."""


COMMON = [("common", name) for name in ("lightness", "scale")]
LATER = {
    *COMMON, *(("job", *place) for place in COMMON), ("job", "shares"), ("job", "spectra"),
    ("split",), ("together",), ("rgb", "negative"), ("buffers",), ("choices",), ("left_out",),
}  # fmt: skip
"""Keys that earlier sets lack; here, their defaults are the values."""


def with_change(described, place, value):
    changed = copy.deepcopy(described)
    holder = changed
    for name in place[:-1]:
        holder = holder[name]
    if value is GONE:
        del holder[place[-1]]
    else:
        holder[place[-1]] = value
    return changed


def is_believed(place, there, value):
    """Whether a change is of one finite number or text into another that is legal."""
    holder = there
    for name in place:
        holder = holder[name]
    is_text = isinstance(holder, str) and isinstance(value, str)
    is_number = isinstance(value, int | float) and 0.0 <= value < math.inf
    return place[0] in BELIEVED and (is_text or is_number)


def faults_in(images, image, scene):
    """Return what is found first, without rendering and without reading all files again."""
    entry, head = image.entry, images.head

    def found():
        yield from faults_of_entry(entry, False)
        yield from misfits(head, GROWN_HEAD_KINDS)
        yield from check_head(images, {image.name})
        yield from check_files(image, head)
        yield from check_entry(image, head)
        yield from version_faults(entry, head["versions"])
        yield from check_scene(image, scene)
        yield from check_digests(image)
        hashes = hash_files(image.folder, entry["files"])
        yield from (name for name in hashes if hashes[name] != entry["files"][name])

    try:
        return list(islice(found(), 1))
    except pm.InputError as error:
        return [str(error)]


@pytest.fixture
def opened(copied):
    """A set, its image and scene; its images have no entries of their own."""
    images = dataset.open(copied)
    image = images[0]
    (image.folder / ENTRY).unlink()
    scene = make_scene(Job.from_description(image.entry["job"]))
    assert faults_in(images, image, scene) == []
    return images, image, scene


def test_every_change_of_an_entry_is_found(opened):
    """Of each value, by other values, other kinds, and none."""
    images, image, _ = opened
    there, missed = image.entry, []
    for place, value in changes(there):
        image.entry = images.entries[0] = with_change(there, place, value)
        if not faults_in(*opened) and not is_believed(place, there, value):
            missed.append((place, value))
    assert {place for place, value in missed if value is GONE} <= LATER
    assert not [each for each in missed if each[1] is not GONE]


def test_every_change_of_a_head_is_found(opened):
    images, _, _ = opened
    there, missed = images.head, []
    for place, value in changes(there):
        images.head = with_change(there, place, value)
        if not faults_in(*opened) and not is_believed(place, there, value):
            missed.append((place, value))
    assert {place for place, value in missed if value is GONE} <= LATER
    assert not [each for each in missed if each[1] is not GONE]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"size": [10**9, 10**9]}, r"size\[0\] 1000000000 must be a whole number from 1 to"),
        ({"size": [12, 9]}, r"size\[1\] is 9 in the manifest, but 8 by its job and its files"),
        ({"geometry": "jug-1"}, "geometry is 'jug-1' in the manifest, but 'jug-0' by its job"),
        ({"split": "../out"}, r"split '\.\./out' must be one of 'train', 'val', 'test'"),
        ({"error": 1e-9}, "error is 1e-09 in the manifest, but"),
        ({"objects": ["wall"]}, "objects is"),
    ],
)
def test_a_manifest_that_is_not_so_is_a_fault(copied, capsys, change, message):
    rewrite(copied, lambda line: line.update(change))
    (copied / dataset.open(copied)[0].name / ENTRY).unlink()
    assert main(["dataset", "verify", str(copied), "--sample", "0"]) == 1
    assert re.search(rf"jug-0-white-\w+: {message}", capsys.readouterr().err)


def test_sets_of_hdf5_alone_are_sound(copied):
    """Their RGB is projected from bands that were rounded, and Hypersim's before that."""
    [image] = dataset.open(copied)
    for name in ("bands.exr", "rgb.exr"):
        (image.folder / name).unlink()
        rewrite(copied, lambda line, name=name: line["files"].pop(name))
    (image.folder / ENTRY).unlink()
    head = json.loads((copied / "manifest.json").read_text())
    (copied / "manifest.json").write_text(json.dumps(head | {"formats": ["hdf5", "png"]}))
    assert verify(copied, sample=0) == []


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999"])
def test_numbers_that_are_not_finite(copied, number):
    path = copied / "manifest.jsonl"
    path.write_text(re.sub(r'"error": [0-9.e-]+', f'"error": {number}', path.read_text(), count=1))
    if number == "1e999":
        assert any("error inf must be a finite number" in f for f in verify(copied, sample=0))
        words = ["--license", "CC0-1.0", "--quiet"]
        assert main(["dataset", "publish", str(copied), *words]) == 2
    else:
        with pytest.raises(pm.InputError, match=f"{number} is no number of JSON"):
            verify(copied)


def test_spreadsheets_compute_no_cell(tmp_path):
    texts = ("=1+1", "+x", "-x", "@x", "\tx", "-2.5e3", "a=b", "'x")
    write_csv(tmp_path / "a.csv", ["=head", "-1"], [[text, 1.5] for text in texts])
    with (tmp_path / "a.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    assert head == ["'=head", "-1"]
    cells = ["'=1+1", "'+x", "'-x", "'@x", "'\tx", "-2.5e3", "a=b", "'x"]
    assert rows == [[cell, "1.5"] for cell in cells]
