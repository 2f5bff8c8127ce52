"""Score methods on a data set, with settings that all other scenes choose."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.dataset.files.reader import Dataset
from photonmap.errors import InputError
from photonmap.evaluate.bench.images import LIGHTS, SPACES, Shot, Truth, open_finished, shots
from photonmap.evaluate.bench.measure import (
    MEAN_LAYER,
    METRICS,
    Column,
    Measured,
    Metric,
    checked,
    choose_metrics,
    measure,
)
from photonmap.evaluate.bench.mit import MitSet, is_mit
from photonmap.evaluate.bench.scores import Evaluation, MethodScores
from photonmap.evaluate.methods.method import Method, find_method, method_names
from photonmap.evaluate.metrics.arrays import Floats
from photonmap.runtime.options import read_list
from photonmap.runtime.wording import suggest


def one_thread() -> AbstractContextManager[Any]:
    """Return a context in which NumPy's and SciPy's linear algebra runs in one thread.

    Without threadpoolctl, which limits them, it raises `InputError`.
    """
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        message = "evaluate needs threadpoolctl: pip install 'photonmap[evaluate]'"
        raise InputError(message) from None
    import_module("scipy.linalg")  # limits reach only libraries that are loaded
    return threadpool_limits(1)


Settings = Mapping[str, float]
_Scored = Sequence[tuple[Method, MethodScores]]
_BY = METRICS["lmse"]  # The metric that settings are chosen by


def tune(
    methods: Sequence[Method],
    names: Sequence[str],
    shots: Callable[[], Iterator[Shot]],
    log: Callable[[str], None],
) -> dict[str, dict[str, Settings]]:
    """Return the settings of each method for each scene: by name of the method, then of the scene.

    For a scene, those are chosen that have the least mean LMSE of reflectance and shading over the
    images of all other scenes. Images on which a method fails with any setting do not count. Where
    there is one scene only, or a method has no grid, these are its defaults. `names` are those of
    the scenes; `shots` returns the images of the data set; `log` is called with a line for each.
    """
    chosen = {method.name: dict.fromkeys(names, method.defaults) for method in methods}
    tuned = [method for method in methods if method.grid]
    if not tuned or len(names) < 2:
        return chosen
    scenes: list[str] = []
    rows: dict[str, list[list[float]]] = {method.name: [] for method in tuned}
    for shot in shots():
        scenes.append(shot.truth.scene)
        for method in tuned:
            rows[method.name].append([_score(method, each, shot) for each in method.grid])
        log(f"settings tried on {shot.truth.name}")
    for method in tuned:
        scores = np.array(rows[method.name])
        usable = np.isfinite(scores).all(axis=1)
        for name in names:
            others = usable & (np.array(scenes) != name)
            if others.any():
                best = int(np.argmin(scores[others].mean(axis=0)))
                chosen[method.name][name] = method.grid[best]
    return chosen


def _score(method: Method, settings: Settings, shot: Shot) -> float:
    """Return the LMSE of a method with some settings; nan where it fails."""
    try:
        layers = checked(method.estimate(shot.view.copy(), **settings), shot.truth)
    except Exception:  # whatever a method raises; it is reported when images are scored
        return float("nan")
    return measure(layers, shot.truth, [_BY]).scores.get(Column(_BY.name, MEAN_LAYER), float("nan"))


DRAWS = 4  # Default number of times that noise is added to the truth

Log = Callable[[str], None]
Watch = Callable[[Truth, str, Mapping[str, Floats], Measured], None]
"""Is given a truth, a method's name, the layers it found, scaled to the truth, and their scores."""


def evaluate_dataset(
    folder: str | PathLike[str],
    methods: str | Method | Sequence[str | Method] | None = None,
    metrics: str | Sequence[str] | None = None,
    space: str = "rgb",
    draws: int = DRAWS,
    light: str = LIGHTS[0],
    log: Log = lambda line: None,
    watch: Watch = lambda truth, method, layers, measured: None,
) -> Evaluation:
    """Score methods on all images of a data set, in one thread so that bits do not depend on more.

    Parameters
    ----------
    folder : of the data set, or of MIT's objects
    methods : their names, or `Method`s, one or several; None for all there are
    metrics : their names, see `photonmap.evaluate.bench.measure`; None for all that apply
    space : "rgb", linear sRGB, or "bands"
    draws : number of times that the standard errors of the truth are added to it, to see what they
        do to scores; 0 to save this time
    light : "all", or "direct" for images without interreflection, whose truth has no errors
    log : called with a line for each image
    watch : called with each estimate

    Raises
    ------
    InputError : the data set is not finished or damaged; there is no such method, metric,
        space or light;
        two methods have the same name; `draws` is negative; no method has an estimate for any
        image; or threadpoolctl is not installed
    """
    if space not in SPACES:
        raise InputError(f"there is no space {space!r}; {suggest(space, SPACES)}")
    if light not in LIGHTS:
        raise InputError(f"there is no light {light!r}; {suggest(light, LIGHTS)}")
    if draws < 0:
        raise InputError(f"draws must be 0 or more; got {draws}")
    chosen = _choose_methods(methods)
    measured_by = choose_metrics(metrics, space)
    images = _open(Path(folder), light)

    def look() -> Iterator[Shot]:
        return images.shots() if isinstance(images, MitSet) else shots(images, space, light)

    with one_thread():
        settings = tune(chosen, images.geometries, look, log)
        found = [MethodScores(method.name, settings=settings[method.name]) for method in chosen]
        scored = list(zip(chosen, found, strict=True))
        names, scenes, kinds = [], [], []
        for index, shot in enumerate(look()):
            began = time.perf_counter()
            noise = _draw(shot.truth, draws, index)
            _score_image(shot, scored, measured_by, noise, watch)
            names.append(shot.truth.name)
            scenes.append(shot.truth.scene)
            kinds.append(shot.kind)
            seconds = time.perf_counter() - began
            log(f"{index + 1}/{len(images)} {shot.truth.name}: {seconds:.1f} s")
    if not any(method.measured for method in found):
        reason = next(iter(found[0].failures.values()))
        raise InputError(f"no method has an estimate for any image: {found[0].name}: {reason}")
    return Evaluation(Path(folder).resolve().name, space, names, scenes, kinds, found)


def _open(folder: Path, light: str) -> Dataset | MitSet:
    """Open a data set of photonmap or MIT's."""
    if not is_mit(folder):
        return open_finished(folder)
    if light != LIGHTS[0]:
        raise InputError("photographs have no direct light of their own; use the light all", folder)
    return MitSet(folder)


def _choose_methods(methods: str | Method | Sequence[str | Method] | None) -> list[Method]:
    """Return methods, each with a name of its own."""
    if methods is None:
        methods = method_names()
    wanted = read_list(methods) if isinstance(methods, Iterable) else [methods]
    if bare := [each for each in wanted if callable(each)]:
        name = getattr(bare[0], "__name__", "mine")
        raise InputError(f"give the function a name: Method({name!r}, {name})")
    chosen = [each if isinstance(each, Method) else find_method(each) for each in wanted]
    names = [method.name for method in chosen]
    if twice := [name for name in names if names.count(name) > 1]:
        raise InputError(f"{twice[0]!r} is given twice; name methods and folders differently")
    if not chosen:
        raise InputError("no method was chosen; name one or more")
    return chosen


def _score_image(
    shot: Shot, methods: _Scored, metrics: Sequence[Metric], noise: Iterable[Truth], watch: Watch
) -> None:
    """Score an image by all methods, and the same estimates against the truth with noise added."""
    truth, layers = shot.truth, {}
    for method, scores in methods:
        began = time.perf_counter()
        try:
            estimate = method.estimate(shot.view.copy(), **scores.settings[truth.scene])
            layers[method.name] = checked(estimate, truth)
        except Exception as error:  # whatever a method raises is its failure, not the bench's
            kind = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
            scores.failures[truth.name] = " ".join(f"{kind}{error}".split())
            continue
        scores.seconds[truth.name] = time.perf_counter() - began
        found = measure(layers[method.name], truth, metrics)
        scores.measured[truth.name] = found
        watch(truth, method.name, layers[method.name], found)
    for noisy in noise:
        for method, scores in methods:
            if method.name in layers:
                drawn = measure(layers[method.name], noisy, metrics).scores
                scores.draws.setdefault(truth.name, []).append(drawn)


def _draw(truth: Truth, draws: int, seed: int) -> Iterator[Truth]:
    """Yield the truth with the noise of its standard errors added; nothing if it has none."""
    rng = np.random.Generator(np.random.PCG64(seed))
    for _ in range(draws if truth.errors else 0):
        yield truth.drawn(rng)
