"""Score methods on a data set."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from photonmap.dataset.files.reader import Dataset
from photonmap.errors import InputError
from photonmap.evaluate.bench.measure import Measured, checked, measure
from photonmap.evaluate.bench.metric_list import Metric, choose_metrics
from photonmap.evaluate.bench.mit import MitSet, is_mit
from photonmap.evaluate.bench.one_thread import one_thread
from photonmap.evaluate.bench.scores import Evaluation, MethodScores
from photonmap.evaluate.bench.truth import SPACES, Truth
from photonmap.evaluate.bench.tuning import tune
from photonmap.evaluate.bench.views import LIGHTS, Shot, open_finished, shots
from photonmap.evaluate.methods.method import Method
from photonmap.evaluate.methods.registry import find_method, method_names
from photonmap.evaluate.metrics.arrays import Floats
from photonmap.runtime.options import read_list
from photonmap.runtime.wording import suggest

DRAWS = 4
"""Default number of times that noise is added to the truth."""

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
    metrics : their names, see `photonmap.evaluate.bench.metric_list`; None for all that apply
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
        raise InputError(f"draws {draws} must be a number of draws, 0 or more")
    chosen = _choose_methods(methods)
    measured_by = choose_metrics(metrics, space)
    images = _open(Path(folder), light)

    def look() -> Iterator[Shot]:
        return images.shots() if isinstance(images, MitSet) else shots(images, space, light)

    with one_thread():
        settings = tune(chosen, images.geometries, look, log)
        found = [MethodScores(method.name, settings=settings[method.name]) for method in chosen]
        bench = _Bench(list(zip(chosen, found, strict=True)), measured_by, draws, watch)
        names, scenes, kinds = [], [], []
        for index, shot in enumerate(look()):
            began = time.perf_counter()
            bench.score(shot, index)
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
    """Open a data set of photonmap or MIT's.

    Raises
    ------
    InputError : it is neither, not finished, or MIT's is to be seen in direct light alone
    """
    if not is_mit(folder):
        return open_finished(folder)
    if light != LIGHTS[0]:
        raise InputError(
            "photographs have no direct light of their own; choose the light all", folder
        )
    return MitSet(folder)


def _choose_methods(methods: str | Method | Sequence[str | Method] | None) -> list[Method]:
    """Return methods, each with a name of its own.

    Raises
    ------
    InputError : there is none, none of such a name, or two have the same
    """
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


class _Bench:
    """Scores one image after another by all methods."""

    def __init__(
        self,
        methods: Sequence[tuple[Method, MethodScores]],
        metrics: Sequence[Metric],
        draws: int,
        watch: Watch,
    ) -> None:
        self._methods, self._metrics, self._draws = methods, metrics, draws
        self._watch = watch

    def score(self, shot: Shot, index: int) -> None:
        """Score an image by all methods; `index` decides the noise that is drawn."""
        truth = shot.truth
        layers = {}
        for method, scores in self._methods:
            began = time.perf_counter()
            try:
                estimate = method.estimate(shot.view.copy(), **scores.settings[truth.scene])
                layers[method.name] = checked(estimate, truth)
            except Exception as error:  # whatever a method raises is its failure, not the bench's
                scores.failures[truth.name] = _reason(error)
                continue
            scores.seconds[truth.name] = time.perf_counter() - began
            found = measure(layers[method.name], truth, self._metrics)
            scores.measured[truth.name] = found
            self._watch(truth, method.name, layers[method.name], found)
        if truth.errors:
            self._score_draws(truth, layers, index)

    def _score_draws(
        self, truth: Truth, layers: Mapping[str, dict[str, Floats]], index: int
    ) -> None:
        """Score the same estimates against the truth with noise added: the same for all methods."""
        rng = np.random.Generator(np.random.PCG64(index))
        for _ in range(self._draws):
            noisy = truth.drawn(rng)
            for method, scores in self._methods:
                if method.name in layers:
                    found = measure(layers[method.name], noisy, self._metrics).scores
                    scores.draws.setdefault(truth.name, []).append(found)


def _reason(error: Exception) -> str:
    """Describe an error in one line."""
    if isinstance(error, InputError):
        return str(error)
    return " ".join(f"{type(error).__name__}: {error}".split())
