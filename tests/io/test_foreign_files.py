"""Files that other programs wrote: each is read, or refused in one line."""

import os
import sys
import warnings
from pathlib import Path

import pytest
from helpers.source import ROOT

import photonmap as pm

sys.path.insert(0, str(ROOT / "tools"))
from foreign_files import PACKAGES, find_files, read_all

FOLDER = os.environ.get("PHOTONMAP_FOREIGN", "")
REFUSED = {
    "assimp-testmodels": 43, "pybullet": 3, "genesis-world": 4, "sionna-rt": 15, "pyvista": 0,
}  # fmt: skip
"""Files that are refused, at most: damaged ones, clouds of points, glTF 1, radio materials"""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not FOLDER,
        reason="needs files: python tools/foreign_files.py fetch FOLDER; PHOTONMAP_FOREIGN=FOLDER",
    ),
]


@pytest.mark.parametrize("package", [package.name for package in PACKAGES])
def test_all_files_are_read_or_refused_in_one_line(package):
    outcomes = list(read_all(Path(FOLDER).resolve() / package))
    assert outcomes
    refused = [outcome for outcome in outcomes if outcome.kind == "refused"]
    assert all("\n" not in outcome.text for outcome in refused)
    assert len(refused) <= REFUSED[package], [outcome.text for outcome in refused]


def test_cities_in_the_xml_of_mitsuba_are_read(tmp_path):
    """Their materials, for radio waves, become diffuse ones; the terrain of one has 4735 shapes."""
    folder = Path(FOLDER).resolve() / "sionna-rt"
    cities = [path for path in find_files(folder) if path.suffix == ".xml"]
    assert len(cities) == 15
    counts = {}
    for path in cities:
        text = path.read_text().replace("itu-radio-material", "diffuse")
        (path.parent / "visible.xml").write_text(text)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                counts[path.stem] = len(pm.load_scene(path.parent / "visible.xml").meshes)
        finally:
            (path.parent / "visible.xml").unlink()
    assert counts["san_francisco"] == 4735
    assert counts["box"] == 1
