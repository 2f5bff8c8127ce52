"""The page of a study in a real browser, from disk."""

import csv

import pytest
from helpers import browser

pytestmark = pytest.mark.skipif(browser.find() is None, reason="no Chromium here")

PLACES = """
(() => {
  const places = [];
  for (const group of document.querySelectorAll('#FIGURE g[id*="-point-"]')) {
    if (group.id.includes("-seen-")) continue;
    group.scrollIntoView({block: "center"});
    const box = group.getBoundingClientRect();
    const x = box.x + box.width / 2, y = box.y + box.height / 2;
    const hit = document.elementFromPoint(x, y)?.closest('g[id*="-point-"]');
    if (hit === group) places.push([Number(group.id.match(/-point-(\\d+)-/)[1]), group.id]);
  }
  return places;
})()
"""
SHOWN = """
({point: Number(viewer.dataset.point), title: title.innerText, what: what.innerText,
  picture: document.getElementById("picture").src.slice(0, 22),
  width: document.getElementById("picture").naturalWidth,
  map: document.getElementById("map").src.slice(0, 22),
  mapWidth: document.getElementById("map").naturalWidth,
  bar: document.getElementById("bar").style.background, high: high.innerText})
"""


@pytest.fixture(scope="module")
def page(study_folder):
    with browser.Page((study_folder / "study.html").as_uri()) as opened:
        yield opened


@pytest.fixture(scope="module")
def rows(study_folder):
    with (study_folder / "study.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def place(page, name):
    """Bring an element into view; return its middle."""
    script = (
        f"(() => {{ const e = document.getElementById('{name}');"
        "e.scrollIntoView({block: 'center'}); const b = e.getBoundingClientRect();"
        "return [b.x + b.width / 2, b.y + b.height / 2]; })()"
    )
    return page.run(script)


def test_no_script_fails_and_nothing_is_fetched(page):
    assert page.run("document.readyState") == "complete"
    assert page.errors == []
    assert {url.partition(":")[0] for url in page.requests} <= {"file", "data"}


@pytest.mark.parametrize("figure", ["error_time", "bands", "pareto", "choices"])
def test_plots_are_there_and_points_show_their_pictures(page, rows, figure):
    size = page.run(
        f"(() => {{ const b = document.querySelector('#{figure} svg').getBoundingClientRect();"
        "return [b.width, b.height]; })()"
    )
    assert size[0] > 500
    assert size[1] > 200
    places = page.run(PLACES.replace("FIGURE", figure))
    assert len({index for index, _ in places}) >= 2
    for index, name in (places[0], places[-1]):
        page.click(*place(page, name))
        shown = page.run(SHOWN)
        assert shown["point"] == index
        assert shown["title"] == f"{rows[index]['label']} ({rows[index]['sweep']})"
        assert shown["picture"] == shown["map"] == "data:image/webp;base64"
        assert shown["width"] == shown["mapWidth"] == int(rows[index]["width"])
        assert "linear-gradient" in shown["bar"]
        assert shown["high"]
        assert shown["what"]
    assert page.errors == []


def test_lines_of_tables_are_clicked_too(page, rows):
    choices = [i for i, row in enumerate(rows) if row["sweep"] == "choices"]
    for index in (choices[0], choices[-1]):
        page.run(f"document.querySelector('#choices-table tr[data-point=\"{index}\"]').id = 'here'")
        page.click(*place(page, "here"))
        page.run("document.getElementById('here').removeAttribute('id')")
        assert page.run(SHOWN)["point"] == index
    thumbnails = page.run("[...document.querySelectorAll('td img')].map(i => i.naturalWidth)")
    assert len(thumbnails) == 2 * len(choices)
    assert min(thumbnails) > 0
