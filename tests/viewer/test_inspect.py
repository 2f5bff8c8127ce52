"""The page on which a render is looked at, in a real browser, from disk."""

import json
import time

import numpy as np
import pytest
from helpers import browser

from photonmap.commands.main import main
from photonmap.results.result import Result
from photonmap.spectra.bands import Bands

in_browser = pytest.mark.skipif(browser.find() is None, reason="no Chromium here")
W, H = 40, 30
BANDS = Bands.gaussian(5)


def make(seed, bands=BANDS, size=(W, H)):
    rng, (width, height) = np.random.default_rng(seed), size
    shape = (height, width, bands.count)
    parts = {name: rng.random(shape, np.float32) for name in ("emission", "direct", "indirect")}
    radiance = (parts["emission"] + parts["direct"]) + parts["indirect"]
    buffers = {"radiance": radiance, **parts, "reflectance": rng.random(shape, np.float32)}
    buffers["direct@lamp.1"] = buffers["direct"]
    buffers["normal"] = rng.random((height, width, 3), np.float32)
    buffers["depth"] = rng.random((height, width), np.float32)
    buffers["object_id"] = rng.integers(0, 3, (height, width), np.uint32)
    errors = {name: rng.random(shape, np.float32) * 0.01 for name in ("direct", "radiance")}
    record = {"passes": 16, "objects": ["<ball>", "floor & wall"], "scene": {"spectra": True}}
    return Result(buffers, errors, bands, record)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inspect")
    for seed in (0, 1):
        make(seed).save(folder / f"{seed}.exr")
    assert main(["inspect", str(folder / "0.exr")]) == 0
    both = [str(folder / "0.exr"), str(folder / "1.exr"), "-o", str(folder / "both.html")]
    assert main(["inspect", *both]) == 0
    return folder


def opened(file):
    page = browser.Page(file.as_uri())
    end = time.monotonic() + browser.PATIENCE
    while page.run("document.body.dataset.ready") is None and time.monotonic() < end:
        time.sleep(0.02)
    return page


@pytest.fixture(scope="module")
def page(folder):
    with opened(folder / "0.html") as one:
        yield one


@pytest.fixture(scope="module")
def both(folder):
    with opened(folder / "both.html") as two:
        yield two


def drawn(page, script=""):
    """Run a script, and wait until the page was drawn; return nothing."""
    page.run(f"{script}; window.done = false; draw(); requestAnimationFrame(() => done = true)")
    while not page.run("window.done"):
        time.sleep(0.01)


def choose(page, name, value):
    drawn(
        page, f"byId('{name}').value = '{value}'; byId('{name}').dispatchEvent(new Event('input'))"
    )


def seen(page, name, x, y):
    """Return the colour of the middle of a pixel of the image."""
    script = f"""(() => {{ const c = named.get('{name}').canvas, s = scaleOf(c);
        const x = ({x} + 0.5 - view.x) * s + c.width / 2;
        const y = ({y} + 0.5 - view.y) * s + c.height / 2;
        return [...c.getContext('2d').getImageData(x, y, 1, 1).data].slice(0, 3); }})()"""
    return page.run(script)


@in_browser
def test_no_script_fails_and_nothing_is_fetched(page, both):
    for one in (page, both):
        assert one.errors == []
        assert {url.partition(":")[0] for url in one.requests} <= {"file", "data"}
        assert one.run("document.documentElement.scrollWidth <= innerWidth")


@in_browser
def test_values_and_errors(page):
    result = make(0)
    for name in ("radiance", "direct", "direct@lamp.1", "reflectance", "normal", "depth"):
        image = result.buffers[name].reshape(H, W, -1)
        for x, y in ((0, 0), (W - 1, H - 1), (7, 19)):
            shown = json.loads(page.run(f"JSON.stringify(pixel('{name}', {x}, {y}))"))
            near = 0.5 * result.errors["direct"][y, x].max() if name != "depth" else 1e-3
            np.testing.assert_allclose(shown["values"], image[y, x], atol=near + 2e-3)
            if name in result.errors:
                np.testing.assert_allclose(shown["errors"], result.errors[name][y, x], rtol=0.13)
            else:
                assert set(shown["errors"]) == {None}


@in_browser
def test_colours_are_those_of_the_preview(page):
    result = make(0)
    drawn(page, "hold(null); whole()")
    choose(page, "colour", "0")
    preview, reflectance = result.preview(), result.rgb("reflectance")
    for x, y in ((3, 4), (30, 20), (W - 1, 0)):
        np.testing.assert_allclose(seen(page, "radiance", x, y), preview[y, x], atol=3)
        linear = reflectance[y, x].clip(0, 1)
        coded = 255 * np.where(
            linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055
        )
        np.testing.assert_allclose(seen(page, "reflectance", x, y), coded, atol=3)


@in_browser
def test_bands_are_chosen(page):
    choose(page, "colour", "band2")
    r, g, b = seen(page, "reflectance", 5, 6)
    assert r == g == b
    choose(page, "colour", "pick")
    assert page.run("!byId('picks').hidden")
    values = make(0).reflectance[6, 5, [4, 2, 0]]
    coded = 255 * (1.055 * values ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(seen(page, "reflectance", 5, 6), coded, atol=3)
    before = seen(page, "direct", 5, 6)
    choose(page, "exposure", "-2")
    assert sum(seen(page, "direct", 5, 6)) < sum(before)
    np.testing.assert_allclose(seen(page, "reflectance", 5, 6), coded, atol=3)
    choose(page, "exposure", "0")


@in_browser
def test_a_click_holds_a_pixel_and_shows_its_spectra(page):
    drawn(page, "whole()")
    script = """(() => { const b = named.get('direct').canvas.getBoundingClientRect();
        return [b.x + b.width * (12.5 / 40), b.y + b.height * (8.5 / 30)]; })()"""
    page.click(*page.run(script))
    assert page.run("[pinned.x, pinned.y]") == [12, 8]
    number = make(0).buffers["object_id"][8, 12]
    known = ("background", "<ball>", "floor & wall")[number]
    assert known in page.run("byId('what').textContent")
    assert page.run("document.querySelectorAll('svg.radiance g[data-buffer]').length") == 5
    assert page.run("document.querySelectorAll('g[data-buffer=direct] .bar').length") == 5
    cells = page.run("[...byId('numbers').rows].map(r => r.innerText)")
    assert any(cell.startswith("direct\t") and "±" in cell for cell in cells)
    page.run(
        "document.body.dispatchEvent("
        "new KeyboardEvent('keydown', {key: 'ArrowRight', bubbles: true}))"
    )
    assert page.run("byId('where').textContent") == "Pixel 13, 8 (held)"


@in_browser
def test_zoom_is_one_for_all(page):
    page.run("""named.get('direct').canvas.dispatchEvent(new WheelEvent('wheel',
        {deltaY: -900, clientX: 100, clientY: 300, cancelable: true}))""")
    assert page.run("view.zoom") == pytest.approx(8.0)
    drawn(page)
    x, y = page.run("[Math.floor(view.x), Math.floor(view.y)]")
    choose(page, "colour", "band0")
    for name in ("reflectance", "emission"):
        assert len(set(seen(page, name, x, y))) == 1
    drawn(page, "hold(null); whole()")
    assert page.run("view.zoom") == 1


@in_browser
def test_difference_of_two_files(both):
    one, other = make(0), make(1)
    choose(both, "colour", "band1")
    choose(both, "show", "difference")
    for x, y in ((4, 5), (20, 11)):
        difference = one.reflectance[y, x, 1] - other.reflectance[y, x, 1]
        red, _, blue = seen(both, "reflectance", x, y)
        assert (red > blue) == (difference > 0)
    choose(both, "show", "b")
    values = other.reflectance[5, 4, 1]
    coded = 255 * (1.055 * values ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(seen(both, "reflectance", 4, 5), [coded] * 3, atol=3)
    choose(both, "show", "sigma")
    assert max(seen(both, "direct", 4, 5)) == 255, "far apart in terms of their errors"
    assert seen(both, "reflectance", 4, 5) == [0, 0, 0], "has no errors"


def test_pages_of_chosen_buffers_are_small(folder, capsys):
    some = folder / "some.html"
    assert main(["inspect", str(folder / "0.exr"), "--buffers", "depth", "-o", str(some)]) == 0
    assert some.stat().st_size < (folder / "0.html").stat().st_size / 2
    assert "open it in a browser" in capsys.readouterr().out
    assert not [*folder.glob("*.part")]


@pytest.mark.parametrize(
    ("other", "options", "message"),
    [
        (make(0, size=(8, 8)), [], "differ in size, 40x30 and 8x8"),
        (make(0, Bands.gaussian(3)), [], "differ in bands"),
        (make(0), ["--buffers", "dept"], "no buffer 'dept'"),
        (make(0), ["-o", "page.htm"], "must end in .html"),
    ],
    ids=["size", "bands", "buffer", "suffix"],
)
def test_what_cannot_be_shown(folder, tmp_path, capsys, other, options, message):
    other.save(tmp_path / "other.exr")
    page = ["-o", str(tmp_path / "page.html")]
    files = [str(folder / "0.exr"), str(tmp_path / "other.exr")]
    assert main(["inspect", *files, *page, *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "page.html").exists()


def test_rgb_has_no_wavelengths(tmp_path):
    make(0, Bands.rgb()).save(tmp_path / "rgb.exr")
    assert main(["inspect", str(tmp_path / "rgb.exr"), "--quiet"]) == 0
    assert '"wavelengths": null' in (tmp_path / "rgb.html").read_text("utf-8")


def test_no_such_file(tmp_path, capsys):
    assert main(["inspect", str(tmp_path / "none.exr")]) == 2
    error = capsys.readouterr().err
    assert "none.exr: there is no such file" in error
    assert error.count("\n") == 1
    assert not [*tmp_path.iterdir()]
