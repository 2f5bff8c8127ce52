"""Data sets whose files hold chosen buffers alone: what is in them, and who can read them."""

import json

import numpy as np
import pytest

from photonmap import dataset
from photonmap.buffers import split_name
from photonmap.commands.main import main
from photonmap.dataset.files.lean import ALWAYS, check_chosen
from photonmap.dataset.jobs.verify import check_identities, verify
from photonmap.dataset.publication.export import usual_names
from photonmap.errors import InputError
from photonmap.evaluate.bench.images import load_truth
from photonmap.io.exr import list_parts

CHOSEN = (*ALWAYS, "distance", "normal", "object_id", "specular_reflectance")
SIZE = ["--size", "24x18", "--bands", "4", "--error", "0.5", "--format", "exr,hdf5", "--quiet"]


def make(folder, *more):
    preset = folder.parent / "one.toml"
    preset.write_text('scenes = ["jug"]\nilluminations = ["two_mixed"]')
    return main(["dataset", str(folder), "--preset", str(preset), *SIZE, *more])


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """The same image with all buffers, and with chosen ones."""
    place = tmp_path_factory.mktemp("chosen")
    assert make(place / "all") == 0
    assert make(place / "some", "--buffers", ",".join(CHOSEN)) == 0
    return dataset.open(place / "all")[0], dataset.open(place / "some")[0]


def test_files_hold_what_was_chosen(pair):
    _, some = pair
    for name in ("bands.exr", "rgb.exr"):
        held = {split_name(part.partition(".")[0])[0] for part in list_parts(some.folder / name)}
        assert held <= {*CHOSEN, "pure"}
        assert {*ALWAYS} - held <= {"valid"}
    assert {split_name(name)[0] for name in some} >= {*CHOSEN, "pure"}
    assert any(name.startswith("shading@") for name in some)
    assert "radiance.error" in some
    sizes = [sum(p.stat().st_size for p in image.folder.glob("*.exr")) for image in pair]
    assert sizes[1] < sizes[0]


def test_they_are_those_of_all_buffers(pair):
    whole, some = pair
    for name in set(some) - {"specular_reflectance"}:
        np.testing.assert_array_equal(some[name], whole[name])
    assert some["specular_reflectance"].shape == some["radiance"].shape
    for name in ("radiance", "reflectance", "shading"):
        np.testing.assert_array_equal(some.rgb[name], whole.rgb[name])
        np.testing.assert_array_equal(some.srgb[name], whole.srgb[name])
    shares = some.light_shares()
    assert len(shares) == 2


def test_what_is_not_held_is_not_taken_for_nothing(pair):
    _, some = pair
    for name in ("direct", "residual", "emission"):
        with pytest.raises(KeyError, match=name):
            some[name]
        with pytest.raises(AttributeError, match=name):
            getattr(some.result, name)


def test_verify_renders_them_again(pair):
    lines = []
    for image in pair:
        assert verify(image.folder.parent, 1, lines.append) == []
    assert sum("identical bit for bit" in line for line in lines) == 2


def test_verify_checks_the_identities_of_what_is_held(pair):
    _, some = pair
    result = dataset.Image(some.folder.parent, some.entry).result
    assert list(check_identities(result, False, some.chosen)) == []
    first = next(name for name in result.buffers if name.startswith("shading@"))
    result.buffers[first] = result.buffers[first] * 1.5
    [fault] = check_identities(result, False, some.chosen)
    assert fault == "shading is not the sum of its light groups"


@pytest.mark.filterwarnings("always::photonmap.SceneWarning")
def test_such_sets_are_published_and_exported(pair, tmp_path, capsys):
    folder = pair[1].folder.parent
    bare = tmp_path / "bare"
    assert make(bare, "--buffers", ",".join(ALWAYS), "--format", "exr,png") == 0
    assert main(["dataset", "publish", str(bare), "--license", "CC0-1.0", "--quiet"]) == 0
    assert "no object_id, see --buffers, so there is no annotations.json" in capsys.readouterr().err
    assert "annotations" not in (bare / "README.md").read_text()
    assert not (bare / "annotations.json").exists()
    assert (bare / "cameras.json").exists()
    assert main(["dataset", "publish", str(folder), "--license", "CC0-1.0", "--quiet"]) == 0
    assert json.loads((folder / "annotations.json").read_text())["annotations"]
    for source, name in ((folder, "normal"), (bare, "rgb.shading")):
        out = tmp_path / f"shards-{source.name}"
        words = ["dataset", "export", str(source), str(out), "--license", "CC0-1.0", "--quiet"]
        assert main(words) == 0
        [sample] = dataset.open_shards(out).values()
        assert f"{name}.npy" in sample
        assert "rgb.direct.npy" not in sample


def test_what_needs_other_buffers_says_so(pair):
    _, some = pair
    assert load_truth(pair[0], "rgb").regions.any()
    with pytest.raises(InputError, match=r"material_id, which metrics need; add it to --buffers"):
        load_truth(some, "rgb")
    bare = dataset.Image(some.folder.parent, some.entry | {"buffers": list(ALWAYS)})
    assert usual_names(bare) == ["rgb.radiance", "rgb.reflectance", "rgb.shading", "valid"]


def test_sets_of_other_buffers_are_not_mixed(pair, capsys):
    assert make(pair[0].folder.parent, "--resume", "--buffers", ",".join(CHOSEN)) == 2
    assert "it was begun without --buffers" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("names", "more", "fault"),
    [
        ("radiance,depth", (), "buffers lack reflectance, shading, valid"),
        (",".join((*ALWAYS, "depht")), (), "there is no buffer 'depht'; did you mean 'depth'"),
        (",".join(ALWAYS), (), "distance, normal, object_id, which Hypersim's files"),
        (
            ",".join(CHOSEN),
            ("--sensor", "Nikon 5100 (NPL)"),
            "buffers lack emission, which a photo",
        ),
    ],
)
def test_what_is_needed_is_asked_for(tmp_path, capsys, names, more, fault):
    assert make(tmp_path / "set", "--buffers", names, *more) == 2
    assert fault in capsys.readouterr().err
    assert not (tmp_path / "set").exists()


def test_the_choice_has_the_usual_order():
    assert check_chosen([*reversed(CHOSEN)], ["exr"]) == tuple(
        name for name in ("radiance", "reflectance", "shading", "distance", "normal", "object_id",
                          "specular_reflectance", "valid", "pure")
    )  # fmt: skip
    assert check_chosen(None, ["exr"]) is None
