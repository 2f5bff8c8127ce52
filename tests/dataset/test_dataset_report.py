"""The report of a data set: its sums, its contact sheet, its page in a real browser."""

import numpy as np
import OpenImageIO
import pytest
from helpers import browser

import photonmap as pm
from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.files.derived_buffers import as_rgb, with_derived
from photonmap.dataset.files.image_files import PREVIEWED
from photonmap.dataset.report import page as report
from photonmap.dataset.report.page import BINS, summarise
from photonmap.report import pages


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Two scenes, one of them in two lights."""
    folder = tmp_path_factory.mktemp("sets")
    (folder / "preset.toml").write_text(
        'scenes = ["jug", "bowl"]\nilluminations = ["white", "two_mixed"]'
    )
    arguments = ["--preset", str(folder / "preset.toml"), "--size", "32x24", "--error", "0.5"]
    assert main(["dataset", str(folder / "set"), *arguments, "--bands", "3", "--quiet"]) == 0
    return folder / "set"


def statistics_of(direct, indirect, reflectance):
    """Statistics of a white image of constant buffers, without lamps in view."""
    shape = (4, 4, 3)
    buffers = {
        "direct": np.full(shape, direct, np.float32),
        "indirect": np.full(shape, indirect, np.float32),
        "reflectance": np.full(shape, reflectance, np.float32),
        "shading": np.full(shape, (direct + indirect) / reflectance, np.float32),
        "radiance": np.full(shape, direct + indirect, np.float32),
        "emission": np.zeros(shape, np.float32),
        "object_id": np.ones(shape[:2], np.uint32),
        "coverage": np.ones(shape[:2], np.float32),
        "unresolved": np.zeros(shape[:2], bool),
    }
    result = with_derived(pm.Result(buffers, {}, pm.Bands.rgb(), {}))
    return summarise(result, as_rgb(result))


def test_statistics_of_a_constant_image():
    summary = statistics_of(3.0, 1.0, 0.52)
    assert summary["direct_share"] == 0.75
    assert summary["valid"] == 1.0
    assert summary["reflectance"][10] == sum(summary["reflectance"]) == 48
    for name in ("illuminant_red", "illuminant_blue"):
        assert summary[name][6] == sum(summary[name]) == 16
        assert len(summary[name]) == BINS
    assert statistics_of(0.0, 0.0, 0.5)["direct_share"] is None


def test_the_mean_is_over_images(made):
    images = dataset.open(made)
    shares = []
    for image in images:
        direct, indirect = (image[name].astype(float) for name in ("direct", "indirect"))
        shares.append(np.abs(direct).sum() / np.abs(direct + indirect).sum())
    assert report.mean_share(images.entries) == pytest.approx(
        np.mean(shares), rel=2**-11
    )  # half precision


def test_the_sheet_shows_every_image_in_its_place(made):
    images = dataset.open(made)
    sheet = report.draw_sheet(made, images.entries)
    file = OpenImageIO.ImageInput.open(str(made / report.SHEET))
    np.testing.assert_array_equal(file.read_image(OpenImageIO.UINT8), sheet)
    file.close()
    wide, tall = 160, 120
    for index, image in enumerate(images):
        top = 6 + index // 2 * (2 * tall + 6)
        left = 6 + index % 2 * (wide + 6)
        shown = sheet[top : top + tall, left : left + wide].astype(float)
        whole = OpenImageIO.ImageBuf(str(image.folder / "radiance.png"))
        pixels = whole.get_pixels(OpenImageIO.UINT8).astype(float)
        small = shown.reshape(24, 5, 32, 5, 3).mean(axis=(1, 3))
        np.testing.assert_allclose(small, pixels, atol=1.0)
    assert (sheet[:6] == 255).all()


def test_scenes_of_one_illumination_fill_a_square(made):
    """One below the other they would make a strip."""
    entry = dataset.open(made).entries[0]
    sheet = report.draw_sheet(made, [{**entry, "geometry": str(number)} for number in range(9)])
    one = report.draw_sheet(made, [entry])[6:-6, 6:-6]
    tall, wide = np.array(one.shape[:2]) + 6
    assert sheet.shape == (3 * tall + 6, 3 * wide + 6, 3)
    for row, column in np.ndindex(3, 3):
        place = sheet[6 + row * tall :, 6 + column * wide :]
        np.testing.assert_array_equal(place[: one.shape[0], : one.shape[1]], one)


def job(name, geometry, seed, view=""):
    described = {"seed": seed, "illumination": "white", "view": {"name": view}}
    return {"name": name, "geometry": geometry, "job": described}


def test_columns_of_one_illumination():
    """Seeds make columns where a scene has several images that differ by them alone."""
    once = [job("a", "jug-0", 0), job("b", "jug-1", 1), job("c", "room-5e", 0)]
    assert report.columns_of(once) == dict.fromkeys("abc", "white")
    assert report.columns_of([*once, job("d", "room-5e", 0, "left")])["d"] == "white, left"
    seeds = dict(zip("abcd", (0, 1, 0, 1), strict=True))
    assert report.columns_of([*once, job("d", "room-5e", 1)]) == {
        name: f"white, seed {seed}" for name, seed in seeds.items()
    }


def test_a_set_without_pictures_has_a_page(made, tmp_path):
    images = dataset.open(made)
    entries = [{**entry, "files": {}} for entry in images.entries]
    written = report.write_report(tmp_path, entries)
    assert [path.name for path in written] == [report.PAGE]
    assert "<img" not in written[0].read_text()


def test_without_jinja_the_sheet_is_made(made, tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "find_spec", lambda name: None)
    images = dataset.open(made)
    written = report.write_report(made, images.entries)
    assert [path.name for path in written] == [report.SHEET]


@pytest.mark.skipif(browser.find() is None, reason="no Chromium here")
def test_the_page_in_a_browser(made):
    with browser.Page((made / report.PAGE).as_uri()) as page:
        assert page.errors == []
        assert {url.partition(":")[0] for url in page.requests} <= {"file", "data"}
        page.run("document.querySelectorAll('img').forEach(i => i.loading = 'eager')")
        assert page.run("document.querySelectorAll('#sheet tbody tr').length") == 2
        assert page.run("document.querySelectorAll('#sheet .cell').length") == 4
        loaded = "[...document.images].map(i => i.decode().then(() => i.naturalWidth))"
        assert page.run(f"Promise.all({loaded})") == [32] * 4 * len(PREVIEWED)
        heights = page.run("[...document.querySelectorAll('.bars i')].map(b => b.offsetHeight)")
        assert len(heights) == 3 * BINS
        page.run("document.body.style.width = '1300px'")
        page.run(
            "document.querySelectorAll('#sheet tr').forEach(row => {"
            " while (row.children.length < 5)"
            " row.append(row.lastElementChild.cloneNode(true)); })"
        )
        wide = "document.querySelector('.wide')"
        assert page.run(f"{wide}.scrollWidth - {wide}.clientWidth") <= 0
        assert max(heights) > 100
