"""The bench on a data set of known layers: what methods see, how they are scored and summed up."""

import json
import shutil

import numpy as np
import pytest
from helpers.layered_sets import write_set
from threadpoolctl import threadpool_info, threadpool_limits

from photonmap import InputError, dataset, evaluate
from photonmap.commands.main import main
from photonmap.evaluate.bench.images import load_truth, open_finished, shots
from photonmap.evaluate.bench.measure import METRICS, Column, checked, choose_metrics, measure
from photonmap.evaluate.bench.run import evaluate_dataset

MEAN = Column("lmse", "mean")


def perfect(layers):
    """A method that knows the layers, up to factors."""

    def estimate(view):
        found = layers[view.name]
        return evaluate.Estimate(
            0.3 * found.reflectance, 7.0 * found.shading, found.shading[3, 3] / 2.0
        )

    return evaluate.Method("perfect", estimate)


def run(folder, *methods, **options):
    return evaluate_dataset(folder, methods, space="bands", **options)


def test_views_are_what_a_camera_sees(known):
    folder, layers = known
    seen = list(shots(open_finished(folder), "bands"))
    assert [shot.truth.name for shot in seen] == list(layers)
    for shot in seen:
        truth = layers[shot.truth.name]
        assert not shot.view.mask[0, 0]  # the lamp
        assert shot.view.mask.sum() == shot.view.mask.size - 1
        product = truth.reflectance * truth.shading
        ratio = (shot.view.image / product)[shot.view.mask]
        np.testing.assert_allclose(ratio, ratio.flat[0], rtol=1e-5)
        grey = shot.view.image.mean(axis=-1)[shot.view.mask]
        assert np.percentile(grey, 99.0) == pytest.approx(1.0)
        assert len(shot.view.relit) == 2
        assert all(np.isnan(image[0, 0]).all() for image in shot.view.relit)


def test_perfect_estimates_have_no_error(known):
    folder, layers = known
    found = run(folder, perfect(layers))
    assert not found.failed
    assert repr(found) == f"<Evaluation of {found.dataset}, 6 images in bands: perfect>"
    summaries = found.summaries()
    assert {summary.column.metric for summary in summaries} == {
        name for name, metric in METRICS.items() if not metric.needs_rgb
    }
    for summary in summaries:
        assert summary.value == pytest.approx(0.0, abs=1e-5), summary
        assert (summary.scored, summary.failed) == (6, 0)
        assert summary.over_truth is None  # the truth has no errors


def test_scores_are_those_of_the_metrics(known):
    folder, layers = known
    found = run(folder, "constant-reflectance", "grey-world")
    names = list(layers)
    for name, scene in zip(found.images, found.scenes, strict=True):
        assert scene == name.rpartition("-")[0]
    shot = next(iter(shots(open_finished(folder), "bands")))
    truth, product = layers[names[0]], layers[names[0]].reflectance * layers[names[0]].shading
    grey = [image.mean(axis=-1) for image in (truth.reflectance, truth.shading, product)]
    mask = shot.view.mask
    reflectance = evaluate.lmse(grey[0], np.ones_like(grey[0]), mask)
    shading = evaluate.lmse(grey[1], grey[2], mask)
    scores = found.methods[0].measured[names[0]].scores
    assert scores[Column("lmse", "reflectance")] == pytest.approx(reflectance, rel=1e-4)
    assert scores[Column("lmse", "shading")] == pytest.approx(shading, rel=1e-4)
    assert scores[MEAN] == pytest.approx((reflectance + shading) / 2, rel=1e-4)
    light, seen = truth.shading[mask].sum(axis=0), product[mask].mean(axis=0)
    angles = found.methods[1].measured[names[0]].scores
    assert angles[Column("angle", "illuminant")] == pytest.approx(
        evaluate.angular_error(light, seen), rel=1e-4
    )
    assert set(angles) == {Column("angle", "illuminant"), Column("angle-map", "illuminant")}


def test_figures_are_over_images_and_intervals_over_scenes(known):
    found = run(known[0], "constant-reflectance", "grey-world", metrics=["lmse", "angle"])
    one = found.methods[0].values(MEAN, found.images)
    mean = next(summary for summary in found.summaries() if summary.column == MEAN)
    assert mean.value == pytest.approx(one.mean())
    scenes = one.reshape(3, 2).mean(axis=1)
    assert scenes.min() - 1e-12 <= mean.over_scenes.low < mean.over_scenes.high
    assert mean.over_scenes.high <= scenes.max() + 1e-12
    angles = found.methods[1].values(Column("angle", "illuminant"), found.images)
    wanted = evaluate.summarise_angles(angles)
    for summary in found.summaries():
        if summary.column.metric == "angle":
            assert summary.value == pytest.approx(getattr(wanted, summary.figure))


def test_settings_come_from_other_scenes(known):
    """The method's error is its setting's distance from the scene's number."""
    folder, layers = known
    best = {"scene-0": 1.0, "scene-1": 2.0, "scene-2": 2.0}

    def estimate(view, setting):
        scene = view.name.rpartition("-")[0]
        truth = layers[view.name]
        wrong = abs(setting - best[scene]) * np.arange(truth.shading.shape[1])[None, :, None]
        return evaluate.Estimate(truth.reflectance, truth.shading + 0.1 * wrong)

    grid = tuple({"setting": setting} for setting in (1.0, 2.0, 3.0))
    tuned = evaluate.Method("tuned", estimate, {"setting": 9.0}, grid)
    found = run(folder, tuned, metrics=["lmse"]).methods[0]
    assert found.settings["scene-0"] == {"setting": 2.0}
    assert found.settings["scene-1"] in ({"setting": 1.0}, {"setting": 2.0})
    values = found.values(MEAN, list(layers)).reshape(3, 2)
    assert (values[0] > 1e-3).all()


def test_a_single_scene_has_the_defaults(tmp_path):
    write_set(tmp_path, scenes=(0,))
    found = run(tmp_path, "retinex", metrics=["lmse"]).methods[0]
    assert dict(found.settings["scene-0"]) == {"threshold": 0.1}


def test_weiss_needs_several_lights(tmp_path):
    write_set(tmp_path, lights=("white",))
    with pytest.raises(InputError, match="no method has an estimate for any image: weiss: weiss"):
        run(tmp_path, "weiss")


def test_failures_are_counted(known):
    folder, _ = known

    def estimate(view):
        if view.name == "scene-0-white":
            raise RuntimeError("out of\nmemory")
        if view.name == "scene-1-white":
            return evaluate.Estimate(shading=np.full(view.mask.shape, np.nan))
        if view.name == "scene-1-colored":
            return evaluate.Estimate(reflectance=view.image[1:])
        if view.name == "scene-2-white":
            return evaluate.Estimate()
        return evaluate.Estimate(view.image, np.ones(view.mask.shape))

    found = run(folder, evaluate.Method("frail", estimate), "constant-shading", metrics=["lmse"])
    frail, whole = found.methods
    assert found.failed
    assert frail.failures == {
        "scene-0-white": "RuntimeError: out of memory",
        "scene-1-white": "shading: the estimate has NaN or infinity in 767 valid pixels; mask them",
        "scene-1-colored": "reflectance: the estimate is 32×23 in 4 bands, the truth 32×24 in 4 "
        "bands; make them equal",
        "scene-2-white": "the estimate has neither reflectance nor shading nor illuminant",
    }
    assert [(each.method, each.image, each.reason) for each in found.failures] == [
        ("frail", *failure) for failure in frail.failures.items()
    ]
    summary = next(s for s in found.summaries() if s.column == MEAN and s.method == "frail")
    assert (summary.scored, summary.failed) == (2, 4)
    both = ["scene-0-colored", "scene-2-colored"]
    assert summary.value == pytest.approx(whole.values(MEAN, both).mean())
    comparison = found.comparisons()[0]
    assert comparison.difference == pytest.approx(0.0, abs=1e-9)


def test_an_array_is_no_estimate(known):
    method = evaluate.Method("bare", lambda view: view.image)
    with pytest.raises(
        InputError, match=r"bare: the method returns .*; return a photonmap.evaluate.Estimate"
    ):
        run(known[0], method, metrics=["lmse"])


def test_wrong_illuminants_are_failures(known):
    folder, _ = known
    for light in (np.zeros(4), np.ones(3), np.full(4, np.nan)):
        method = evaluate.Method(
            "dark", lambda view, light=light: evaluate.Estimate(None, None, light)
        )
        with pytest.raises(InputError, match="no method has an estimate"):
            run(folder, method)


def test_undefined_metrics_are_not_failures(known):
    folder, layers = known
    truth = load_truth(dataset.open(folder)[0], "bands")
    layers = checked(evaluate.Estimate(truth.reflectance), truth)
    small = np.zeros_like(truth.mask)
    small[5:9, 5:9] = True
    few = type(truth)(**{**vars(truth), "mask": small})
    found = measure(layers, few, choose_metrics(["dssim", "lmse"], "bands"))
    assert list(found.scores) == [Column("lmse", "reflectance")]
    assert "entirely valid" in found.undefined[Column("dssim", "reflectance")]


def test_the_noise_of_the_truth_is_taken_out(tmp_path):
    """Shading was measured with 5% noise; the estimate is exact."""
    noisy, error = tmp_path / "noisy", 0.05
    noisy.mkdir()
    write_set(noisy, error=error, noise=error)
    (tmp_path / "exact").mkdir()
    exact = write_set(tmp_path / "exact")
    found = run(noisy, perfect(exact), metrics=["si-mse"], draws=6)
    shading = next(s for s in found.summaries() if s.column.layer == "shading")
    assert shading.value > 1e-4
    assert shading.over_truth.high < 0.5 * shading.value
    assert abs(sum(shading.over_truth)) / 2 < 0.25 * shading.value
    reflectance = next(s for s in found.summaries() if s.column.layer == "reflectance")
    assert reflectance.over_truth == pytest.approx((0.0, 0.0), abs=1e-9)


def test_draws_have_the_stated_errors(tmp_path):
    write_set(tmp_path, scenes=(0,), lights=("colored",), error=0.1)
    image = dataset.open(tmp_path)[0]
    for space in ("rgb", "bands"):
        truth = load_truth(image, space)
        rng = np.random.default_rng(0)
        draws = np.array([truth.drawn(rng).shading - truth.shading for _ in range(200)])
        mask = truth.mask
        spread = draws.std(axis=0)[mask].mean(axis=0) / truth.shading[mask].mean(axis=0)
        np.testing.assert_allclose(spread, 0.1, rtol=0.25)
        assert abs(draws.mean()) < 0.01
        ratio = draws[0][mask] / truth.errors["shading"][mask]
        np.testing.assert_allclose(ratio, ratio[:, :1] * np.ones(ratio.shape), rtol=1e-4)


def test_unfinished_sets_are_rejected(known, tmp_path):
    folder = shutil.copytree(known[0], tmp_path / "part")
    lines = (folder / "manifest.jsonl").read_text().splitlines()
    (folder / "manifest.jsonl").write_text("\n".join(lines[:4]) + "\n")
    with pytest.raises(InputError, match="not finished, 2 of 6 images are missing"):
        run(folder, "constant-shading")
    head = json.loads((folder / "manifest.json").read_text())
    (folder / "manifest.json").write_text(json.dumps({**head, "images": []}))
    (folder / "manifest.jsonl").write_text("")
    with pytest.raises(InputError, match="has no images"):
        run(folder, "constant-shading")
    with pytest.raises(InputError, match="does not hold a data set"):
        run(tmp_path, "constant-shading")


def test_wrong_options_are_named(known):
    folder, _ = known
    with pytest.raises(InputError, match="no metric 'lsme'; did you mean 'lmse'"):
        run(folder, "retinex", metrics=["lsme"])
    with pytest.raises(
        InputError, match="delta-e is defined in RGB only; leave it out or use the space rgb"
    ):
        run(folder, "retinex", metrics=["delta-e"])
    with pytest.raises(InputError, match="no method 'rettinex'"):
        run(folder, "rettinex")
    with pytest.raises(InputError, match="no space 'xyz'"):
        evaluate_dataset(folder, space="xyz")
    with pytest.raises(InputError, match="'retinex' is given twice"):
        run(folder, "retinex", "retinex")
    with pytest.raises(InputError, match="no method was chosen"):
        run(folder)
    with pytest.raises(InputError, match="draws must be 0 or more; got -1"):
        run(folder, "retinex", draws=-1)


@pytest.mark.parametrize("left_out", ["sirfs", pytest.param("", marks=pytest.mark.slow)])
def test_rendered_sets_can_be_scored(tmp_path, left_out):
    """All methods and metrics, in RGB."""
    methods = [name for name in evaluate.method_names() if name != left_out]
    (tmp_path / "two.toml").write_text('scenes = ["jug"]\nilluminations = ["white", "two_mixed"]')
    size = ["--size", "24x20", "--bands", "3", "--error", "0.5", "--quiet"]
    preset = ["--preset", str(tmp_path / "two.toml")]
    assert main(["dataset", str(tmp_path / "set"), *preset, *size]) == 0
    found = evaluate_dataset(tmp_path / "set", methods if left_out else None, draws=2)
    assert not found.failed
    summaries = found.summaries()
    assert {summary.method for summary in summaries} == set(methods)
    assert {summary.column.metric for summary in summaries} == set(METRICS)
    for summary in summaries:
        assert np.isfinite(summary.value)
        assert summary.over_scenes is None  # one scene
        assert summary.over_truth is not None
    direct = evaluate_dataset(tmp_path / "set", ["retinex"], ["lmse"], draws=0, light="direct")
    assert not direct.failed
    retinex = next(method for method in found.methods if method.name == "retinex")
    changed = direct.methods[0].values(MEAN, found.images) / retinex.values(MEAN, found.images)
    assert (abs(changed - 1.0) > 1e-3).all()


def test_methods_run_in_one_thread(known):
    """Also where a method is the first to load SciPy's linear algebra; afterwards as before."""
    seen = []

    def estimate(view):
        import scipy.linalg

        scipy.linalg.solve(np.eye(3), np.ones(3))
        seen.extend(pool["num_threads"] for pool in threadpool_info())
        return evaluate.Estimate(view.image, view.image)

    with threadpool_limits(2):
        run(known[0], evaluate.Method("watched", estimate), metrics=["lmse"], draws=0)
        assert seen
        assert set(seen) == {1}
        assert 2 in {pool["num_threads"] for pool in threadpool_info()}


@pytest.mark.parametrize("name", ["gehler", pytest.param("sirfs", marks=pytest.mark.slow)])
def test_scores_do_not_depend_on_threads(tmp_path, name):
    write_set(tmp_path, scenes=(0,), lights=("white",))
    scores = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            found = run(tmp_path, name, metrics=["lmse-color"], draws=0)
        scores.append([measured.scores for measured in found.methods[0].measured.values()])
    assert scores[0] == scores[1]


def test_methods_may_change_what_they_see(known):
    folder, _ = known

    def careless(view):
        view.image[...] = 0.3
        view.mask[...] = False
        for image in view.relit:
            image[...] = 1.0
        return evaluate.Estimate(illuminant=np.ones(view.image.shape[-1]))

    alone = run(folder, "grey-world", metrics=["angle"]).summaries()
    found = run(folder, evaluate.Method("careless", careless), "grey-world", metrics=["angle"])
    assert [each for each in found.summaries() if each.method == "grey-world"] == alone


def test_functions_without_a_name_are_refused(known):
    def mine(view):
        return evaluate.Estimate()

    with pytest.raises(InputError, match=r"Method\('mine', mine\)"):
        run(known[0], mine)
    with pytest.raises(InputError, match="method 'x' needs a function of a View; got 3"):
        evaluate.Method("x", 3)
