"""A folder in the layout of MIT's data set, of which the decomposition is known."""

import csv
import os
import shutil
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from photonmap import InputError, evaluate
from photonmap.commands.main import main
from photonmap.evaluate.bench.mit import MitSet

SIZE = 32, 40
REAL = "PHOTONMAP_MIT"
"""Environment variable with the path of MIT's data set, its folder `data`."""
EVALUATED = (
    "box", "cup1", "cup2", "deer", "dinosaur", "frog1", "frog2", "panther", "paper1", "paper2",
    "raccoon", "squirrel", "sun", "teabag1", "teabag2", "turtle",
)  # fmt: skip
"""The objects that Grosse et al. score methods on; they left out apple, pear, phone and potato."""


def write_png16(path, values):
    """Write linear values in [0, 1] as a PNG file of 16 bits."""
    pixels = np.round(values * 65535).astype(np.uint16)
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    spec = OpenImageIO.ImageSpec(SIZE[1], SIZE[0], channels, OpenImageIO.UINT16)
    file = OpenImageIO.ImageOutput.create(str(path))
    assert file.open(str(path), spec)
    assert file.write_image(np.ascontiguousarray(pixels).reshape(*SIZE, channels))
    file.close()


@pytest.fixture(scope="module")
def mit(tmp_path_factory):
    """Two objects: stripes in light that falls off downwards, and to the side in other lights."""
    folder = tmp_path_factory.mktemp("mit") / "data"
    for seed, name in enumerate(("cup", "frog")):
        (folder / name).mkdir(parents=True)
        colors = np.random.default_rng(seed).uniform(0.2, 0.9, (5, 3))
        reflectance = np.broadcast_to(colors[np.arange(SIZE[1]) // 8], (*SIZE, 3))
        shading = np.linspace(0.95, 0.6, SIZE[0])[:, None] * np.ones(SIZE)
        mask = np.ones(SIZE)
        mask[:3] = 0.0
        write_png16(folder / name / "diffuse.png", reflectance * shading[..., None])
        write_png16(folder / name / "shading.png", shading)
        write_png16(folder / name / "reflectance.png", reflectance)
        write_png16(folder / name / "mask.png", mask)
        for light in (1, 2):
            side = np.linspace(1.0, 1.0 - 0.3 * light, SIZE[1])[:, None]
            write_png16(folder / name / f"light0{light}.png", reflectance * side)
    return folder


def test_objects_are_read_as_linear(mit):
    shots = list(MitSet(mit).shots())
    assert [shot.truth.name for shot in shots] == ["cup", "frog"]
    for shot in shots:
        assert not shot.truth.mask[:3].any()
        assert shot.truth.mask[3:].all()
        product = shot.truth.reflectance * shot.truth.shading
        ratio = (shot.view.image / product)[shot.truth.mask]
        np.testing.assert_allclose(ratio, ratio.flat[0], rtol=1e-3)
        assert len(shot.view.relit) == 2
        assert np.isnan(shot.view.relit[0][0, 0]).all()


@pytest.mark.parametrize("name", ["cup", "cup/shading.png", "cup/light01.png"])
def test_links_stay_inside(mit, tmp_path, name):
    """Within the folder they are followed, as unpacked archives may have them."""
    folder = shutil.copytree(mit, tmp_path / "data")
    (folder / "kept").mkdir()
    (folder / name).rename(folder / "kept" / "it")
    (folder / name).symlink_to(folder / "kept" / "it")
    assert len(list(MitSet(folder).shots())) == 2
    (folder / "kept" / "it").rename(tmp_path / "outside")
    (folder / name).unlink()
    (folder / name).symlink_to(tmp_path / "outside")
    with pytest.raises(InputError, match=rf"'{name}\S*' is a link that leaves"):
        list(MitSet(folder).shots())


def test_retinex_solves_them(mit, tmp_path):
    """Its own assumptions hold: edges of reflectance, and shading without any."""
    arguments = ["--method", "color-retinex,constant-shading,weiss", "--metrics", "lmse"]
    folder = tmp_path / "report"
    assert main(["evaluate", "--mit", str(mit), *arguments, "--output", str(folder)]) == 0
    with (folder / "summary.csv").open(newline="") as file:
        rows = {row["method"]: row for row in csv.DictReader(file) if row["layer"] == "mean"}
    assert float(rows["color-retinex"]["value"]) < 1e-4
    assert float(rows["constant-shading"]["value"]) > 1e-3
    assert float(rows["weiss"]["scored"]) == 2


def test_what_is_missing_is_named(mit, tmp_path, capsys):
    with pytest.raises(InputError, match=r"has no OBJECT/diffuse\.png"):
        MitSet(tmp_path)
    (tmp_path / "cup").mkdir()
    (tmp_path / "cup" / "diffuse.png").write_bytes((mit / "cup" / "diffuse.png").read_bytes())
    with pytest.raises(InputError, match=r"cup: has no 'shading\.png'.*unpack the data set again"):
        MitSet(tmp_path)
    with pytest.raises(InputError, match="photographs have no direct light"):
        evaluate.evaluate_dataset(mit, ["retinex"], light="direct")
    for arguments, message in (
        (["evaluate"], "give either the folder of a data set or --mit PATH"),
        (["evaluate", str(mit), "--mit", str(mit)], "give either"),
        (
            ["evaluate", "--mit", str(mit), "--experiments"],
            "need known light, which --mit does not have",
        ),
    ):
        assert main(arguments) == 2
        assert message in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.skipif(REAL not in os.environ, reason=f"MIT's data set is not here: set {REAL}")
def test_retinex_ranks_as_in_print(tmp_path):
    """Grosse et al. 2009: colour Retinex is ahead of grey Retinex, and both of the baselines."""
    for name in EVALUATED:
        (tmp_path / name).symlink_to(Path(os.environ[REAL]).resolve() / name)
    methods = ["constant-shading", "constant-reflectance", "retinex", "color-retinex"]
    found = evaluate.evaluate_dataset(tmp_path, methods, metrics=["lmse-mit"])
    means = {s.method: s.value for s in found.summaries() if s.column.layer == "mean"}
    assert means["color-retinex"] < means["retinex"]
    assert means["retinex"] < min(means["constant-shading"], means["constant-reflectance"])
