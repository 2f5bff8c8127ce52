"""Where LMSE and DSSIM rank estimates differently: made-up scores, and estimates of known order."""

import numpy as np
import pytest
from helpers import browser

from photonmap.commands.main import main
from photonmap.evaluate.bench.images import Truth
from photonmap.evaluate.bench.measure import choose_metrics
from photonmap.evaluate.experiments.degradations import OrderTest
from photonmap.evaluate.report.gallery import DSSIM, LMSE, Disagreements, Rated

SIZE = 96, 128


def truth_of(name="image", seed=0):
    """Patches of 32 pixels under a light that falls off downwards, with the shadow of a bar."""
    rng = np.random.default_rng(seed)
    colors = rng.uniform(0.1, 0.9, (3, 4, 3))
    rows, columns = np.indices(SIZE)
    regions = rows // 32 * 4 + columns // 32 + 1
    reflectance = colors[rows // 32, columns // 32]
    shading = np.linspace(0.3, 1.0, SIZE[0])[:, None, None] * np.ones((*SIZE, 3))
    shading[:, 48:72] *= 0.3
    return Truth(
        name, name, reflectance * shading, reflectance, shading, regions, np.ones(SIZE, bool), {}
    )


def rated(name, lmse, dssim, truth):
    layers = {"reflectance": truth.reflectance, "shading": truth.shading}
    return Rated(name, layers, {LMSE: lmse, DSSIM: dssim})


def test_methods_are_compared_in_every_image():
    found = Disagreements()
    for place in range(6):
        truth = truth_of(f"image-{place}")
        for scores in (("a", 0.1, 0.4), ("b", 0.2, 0.4 / (2 + place)), ("c", 0.3, 0.5)):
            found.keep(truth, rated(*scores, truth))
    cases = found.methods
    assert (cases.pairs, cases.differing, cases.opposite) == (18, 6, 0)
    assert cases.percent(cases.differing) == "33.3%"
    assert [case.image for case in cases.shown] == [f"image-{place}" for place in (5, 4, 3, 2)]
    strongest = cases.shown[0]
    assert strongest.strength == pytest.approx(np.log(2) * np.log(7))
    assert (strongest.by_lmse.name, strongest.by_dssim.name) == ("a", "b")
    assert (strongest.by_dssim.lmse, strongest.by_dssim.dssim) == (0.2, 0.4 / 7)
    assert found.known.pairs == 0


def test_an_image_is_shown_once_with_its_strongest_case():
    found, truth = Disagreements(), truth_of()
    for scores in (("a", 0.1, 0.4), ("b", 0.2, 0.3), ("c", 0.4, 0.1)):
        found.keep(truth, rated(*scores, truth))
    assert found.methods.differing == 3
    [case] = found.methods.shown
    assert (case.by_lmse.name, case.by_dssim.name) == ("a", "c")


def test_known_order_tells_which_metric_is_wrong():
    found, truth = Disagreements(), truth_of()
    steps = (("1", 0.3, 0.1), ("2", 0.2, 0.2), ("3", 0.25, 0.15), ("4", 0.4, 0.4))
    found.keep_known(truth, [rated(*scores, truth) for scores in steps])
    cases = found.known
    assert (cases.pairs, cases.differing, cases.opposite) == (3, 1, 1)
    [case] = cases.shown
    assert (case.by_lmse.name, case.by_dssim.name) == ("2", "1")


def test_scores_of_one_layer_do_not_count():
    found, truth = Disagreements(), truth_of()
    found.keep(truth, rated("a", 0.1, 0.2, truth))
    found.keep(truth, Rated("b", {"reflectance": truth.reflectance}, {}))
    assert found.methods.pairs == 0


def test_dssim_orders_degradations_that_lmse_does_not():
    """Steps to a worse estimate: LMSE takes some for better, and DSSIM fewer."""
    found = Disagreements()
    test = OrderTest(choose_metrics(["lmse-color", "dssim"], "rgb"), found.keep_known)
    test.add(truth_of("image", seed=1))
    shares = {name: dict(zip(test.table().heads[1:], cells, strict=True))
              for name, cells in test.table().rows}  # fmt: skip
    for name in ("blur", "bleed", "tint", "wrong scale", "combined"):
        assert shares["dssim"][name].value == 1.0
    assert shares["lmse-color"]["combined"].value < 1.0
    assert (found.known.differing, found.known.opposite) == (1, 0)
    [case] = found.known.shown
    assert (case.by_lmse.name, case.by_dssim.name) == ("wrong scale 4, blur 2", "wrong scale 4")
    assert case.by_lmse.lmse < case.by_dssim.lmse
    assert case.by_lmse.dssim > case.by_dssim.dssim


@pytest.mark.skipif(browser.find() is None, reason="no Chromium here")
def test_cases_are_on_the_page(known, tmp_path):
    arguments = ["--method", "constant-shading,constant-reflectance,weiss", "--draws", "0"]
    metrics = ["--metrics", "lmse-color,dssim", "--quiet", "--output", str(tmp_path / "r")]
    assert main(["evaluate", str(known[0]), *arguments, *metrics]) == 0
    with browser.Page((tmp_path / "r" / "report.html").as_uri()) as shown:
        assert shown.errors == []
        cases = shown.run(
            "[...document.querySelectorAll('#disagreements .methods')]"
            ".map(c => [...c.querySelectorAll('img')].every(i => i.complete && i.naturalWidth > 0)"
            " && c.querySelectorAll('img').length)"
        )
        assert cases
        assert set(cases) == {7}  # the image, both layers of the truth and of each estimate
