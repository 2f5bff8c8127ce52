"""The site is built without a warning, and its pages do what they say."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest
from helpers.source import ROOT
from test_docs import blocks, docs, run_page

import photonmap as pm
from photonmap.results.result import Result
from photonmap.spectra.bands import Bands

sys.path.insert(0, str(ROOT / "tools"))


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, as `make docs` builds it."""
    pytest.importorskip("material")
    pytest.importorskip("mkdocstrings")
    from make_site import make_site

    folder = tmp_path_factory.mktemp("site")
    make_site(folder / "source")
    settings = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    settings = settings.replace("out/site-source", str(folder / "source"))
    settings = settings.replace("paths: [.]", f"paths: [{ROOT}]")
    settings = settings.replace("tools/docstrings.py", str(ROOT / "tools" / "docstrings.py"))
    (folder / "mkdocs.yml").write_text(settings.replace("out/site", str(folder / "html")))
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet"],
        cwd=folder,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert not done.stdout + done.stderr
    return folder / "html"


def test_every_public_name_is_documented():
    from make_site import api_page

    lines = api_page().splitlines()
    for name in set(pm.__all__) - {"__version__", *pm._PARTS} - {"Light"}:
        assert f"::: photonmap.{pm._HOMES[name]}.{name}" in lines, name


@pytest.mark.slow
def test_public_names_have_their_pages(site):
    page = (site / "docs" / "api.html").read_text(encoding="utf-8")
    for name in set(pm.__all__) - {"__version__", *pm._PARTS} - {"Light"}:
        assert f"{pm._HOMES[name]}.{name}" in page, name
    text = re.sub(r"<[^>]+>", "", page)
    assert "(H, W) float32, cd·m⁻²" in text, "shapes and units"
    assert "----" not in text, "sections are lists"


@pytest.mark.slow
def test_links_of_all_pages_lead_somewhere(site):
    """mkdocs checks links in Markdown; these are those of the pages, to files as well."""
    pages = [site / "index.html", *site.glob("docs/*.html"), site / "CHANGELOG.html"]
    for page in pages:
        for link in re.findall(r'(?:href|src)="([^"#]+)', page.read_text(encoding="utf-8")):
            if not re.match(r"\w+:", link):
                assert (page.parent / link).exists(), f"{page.name}: {link}"


def test_version_is_stated_everywhere():
    from check_release import VERSIONED, check_versions

    check_versions(pm.__version__)
    with pytest.raises(SystemExit, match=next(iter(VERSIONED))):
        check_versions("99.0.0")


def test_reading_without_photonmap(tmp_path, monkeypatch):
    pytest.importorskip("OpenEXR")
    rng = np.random.default_rng(0)
    names = ("emission", "direct", "indirect", "reflectance")
    images = {name: rng.random((6, 9, 6), np.float32) for name in names}
    images["shading"] = (images["direct"] + images["indirect"]) / images["reflectance"]
    images["radiance"] = (images["emission"] + images["direct"]) + images["indirect"]
    images["normal"] = rng.random((6, 9, 3), np.float32)
    whole = {name: rng.integers(1, 9, (6, 9), np.uint32) for name in ("object_id", "passes")}
    images |= {"valid": whole["passes"] > 4, **whole}
    result = Result(images, {"shading": images["shading"]}, Bands.gaussian(6), {"passes": 3})
    monkeypatch.chdir(tmp_path)
    result.save("box.exr")
    found = run_page(docs("reading.md"))
    np.testing.assert_array_equal(found["parts"]["radiance"], result.radiance)
    np.testing.assert_array_equal(found["image"], result.direct)
    for name in ("valid", *whole):
        np.testing.assert_array_equal(found["parts"][name][..., 0], images[name])
    np.testing.assert_allclose(found["wavelengths"]["direct"], result.wavelengths, atol=1e-6)
    assert found["record"]["passes"] == 3


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::photonmap.SceneWarning")
def test_gallery_in_small(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    from make_gallery import gallery_code, run

    code = re.sub(r"\bsize=(\d+|\(.*?\))", "size=(16, 12)", gallery_code())
    code = re.sub(r"passes=\d+", "passes=2", code).replace("600_000", "600")
    code = re.sub(r"in \(45, 128, 205\)", "in (4, 8, 15)", code)
    monkeypatch.chdir(tmp_path)
    run(code.replace("(x, 150,", "(x, 6,"), tmp_path)
    text = docs("gallery.md").read_text(encoding="utf-8")
    pictures = re.findall(r"\]\(gallery/(.*?)\)", text)
    assert len(pictures) == len([*blocks(docs("gallery.md"))])
    for name in pictures:
        assert (tmp_path / name).is_file()
        assert (ROOT / "docs" / "gallery" / name).is_file()
