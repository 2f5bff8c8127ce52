"""The command `python -m photonmap evaluate`: score methods or predictions on a data set."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from photonmap.commands import FAILED, shared
from photonmap.errors import InputError
from photonmap.runtime.options import read_list
from photonmap.runtime.wording import suggest

if TYPE_CHECKING:
    from photonmap.evaluate.bench.scores import Evaluation
    from photonmap.evaluate.methods.method import Method

HELP = "Score intrinsic-image methods, or predictions made elsewhere, on a data set of photonmap."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    text = "folder of a finished data set"
    parser.add_argument("dataset", metavar="DATASET", nargs="?", help=text)
    scored, how = _list_options()
    text = (
        "folder with IMAGE/reflectance.png, IMAGE/shading.exr and so on, or IMAGE.npz; may be "
        "given again"
    )
    shared.add_group(parser, "what is scored", scored).add_argument(
        "--predictions", action="append", default=[], metavar="FOLDER", help=text
    )
    shared.add_group(parser, "how", how)
    usual = "NAME-evaluation in the current folder, not beside the data set NAME"
    more = {"default_text": usual, "short": "o", "read": shared.file_name}
    shared.add_group(parser, "files", [("output", "FOLDER", "where to write the report", more)])
    shared.add_quiet(parser)


def _list_options() -> tuple[list[shared.Row], list[shared.Row]]:
    """Return the options that name what is scored, and those that decide how."""
    from photonmap.evaluate.bench.images import LIGHTS, SPACES
    from photonmap.evaluate.bench.measure import METRICS
    from photonmap.evaluate.bench.predictions import ENCODINGS
    from photonmap.evaluate.bench.run import DRAWS
    from photonmap.evaluate.methods.method import BUILT_IN

    scored: list[shared.Row] = [
        ("mit", "PATH",
         "score on the data set of Grosse et al. 2009 instead: a folder for each object", {}),
        ("method", "NAMES",
         f"methods, separated by commas: {', '.join(BUILT_IN)}, and those that installed packages "
         "add", {"read": read_list, "default_text": "all, or with --predictions none"}),
        ("png", None, "encoding of PNG predictions",
         {"choices": ENCODINGS, "default": ENCODINGS[0]}),
    ]  # fmt: skip
    how: list[shared.Row] = [
        ("metrics", "NAMES", f"metrics, separated by commas: {', '.join(METRICS)}",
         {"read": read_list, "default_text": "all that apply"}),
        ("space", None, "compare in linear sRGB, or in the bands of the data set",
         {"choices": SPACES, "default": SPACES[0]}),
        ("light", None, "light of the images and of their truth: all, or direct light alone",
         {"choices": LIGHTS, "default": LIGHTS[0]}),
        ("draws", "N",
         "number of random draws of the truth's own noise for intervals; 0 for none",
         {"read": int, "default": DRAWS}),
        ("experiments", None,
         "also measure what interreflection, coloured light, bands and noise cost each method, "
         "how many scenes tell methods apart, and which metrics order degradations rightly",
         {"default": False}),
        ("costs_of", "NAMES",
         "methods that --experiments also run in direct light and in bands, so that slow ones can "
         "be left out", {"read": read_list, "default_text": "all that are scored"}),
    ]  # fmt: skip
    return scored, how


def run(options: argparse.Namespace) -> int:
    """Score, print tables and write the report; return 1 if a method failed on an image, else 0."""
    from photonmap.evaluate.bench.run import evaluate_dataset
    from photonmap.evaluate.experiments.paper_table import paper_tables
    from photonmap.evaluate.experiments.run_experiments import run_experiments
    from photonmap.evaluate.report.gallery import Gallery
    from photonmap.evaluate.report.page import check_jinja, write_report
    from photonmap.evaluate.report.tables import as_text
    from photonmap.runtime.writing import check_output_folder

    check_jinja()
    _choose_images(options)
    name = Path(options.dataset).resolve().name
    folder = check_output_folder(options.output or f"{name}-evaluation", "the report")
    if folder.resolve() == Path(options.dataset).resolve():
        raise InputError("the data set has a report of its own; choose another --output", folder)
    _check_experiments(options)
    gallery, methods = Gallery(), _methods(options)
    costed = _costed(options, methods)
    log = shared.progress_log(options)
    how = (options.metrics, options.space, options.draws, options.light)
    evaluation = evaluate_dataset(options.dataset, methods, *how, log, gallery.keep)
    tables = paper_tables(evaluation)
    if options.experiments:
        tables += run_experiments(
            Path(options.dataset), evaluation, costed, gallery.disagreements, log
        )
    summaries, notes = evaluation.summaries(), _notes(options, evaluation)
    write_report(folder, evaluation, summaries, gallery, notes, tables)
    for method in evaluation.methods:
        shared.print_failures(method.failures, method.name)
    found = [line for table in tables for line in table.findings]
    text = as_text(evaluation, summaries)
    shared.say(options, text, *notes, *found, folder / "report.html")
    return FAILED if evaluation.failed else 0


def _choose_images(options: argparse.Namespace) -> None:
    """Make `dataset` the folder of the images, be they of photonmap or MIT."""
    from photonmap.evaluate.bench.mit import MitSet

    if (options.dataset is None) == (options.mit is None):
        raise InputError("give either the folder of a data set or --mit PATH")
    if options.mit is not None:
        MitSet(Path(options.mit))
        if options.experiments:
            raise InputError(
                "--experiments need known light, which --mit does not have; leave one of them out"
            )
        options.dataset = options.mit


def _check_experiments(options: argparse.Namespace) -> None:
    """Check that experiments are asked for with what they compare against."""
    from photonmap.evaluate.bench.images import LIGHTS, SPACES
    from photonmap.evaluate.experiments.paper_table import METRIC

    if not options.experiments:
        return
    if (options.space, options.light) != (SPACES[0], LIGHTS[0]):
        raise InputError(
            "--experiments compare with RGB and all light; leave out --space and --light"
        )
    if options.metrics and METRIC not in options.metrics:
        raise InputError(f"--experiments need the metric {METRIC}; add it to --metrics")


def _costed(options: argparse.Namespace, methods: Sequence[str | Method]) -> Sequence[str | Method]:
    """Return the methods of which costs are measured."""
    wanted = options.costs_of
    if wanted is None:
        return methods
    if not options.experiments:
        raise InputError("--costs-of needs --experiments; add it")
    names = [_name(method) for method in methods]
    for name in wanted:
        if name not in names:
            raise InputError(f"--costs-of {name} is not scored; {suggest(name, names)}")
    return [method for method in methods if _name(method) in wanted]


def _name(method: str | Method) -> str:
    return method if isinstance(method, str) else method.name


def _notes(options: argparse.Namespace, evaluation: Evaluation) -> list[str]:
    """Return how estimates and images came about, and where there are few scenes for intervals."""
    from photonmap.evaluate.intervals import ENOUGH_SCENES

    notes = [_PNG_NOTES[options.png]] if options.predictions else []
    if options.light == "direct":
        notes.append("Images and shading are those of direct light alone.")
    count = len(set(evaluation.scenes))
    if count == 1:
        notes.append("There are no intervals over scenes, as there is one scene.")
    elif count < ENOUGH_SCENES:
        notes.append(
            f"Intervals in brackets are too narrow: they are over {count} scenes, fewer than "
            f"{ENOUGH_SCENES}."
        )
    return notes


_PNG_NOTES = {
    "srgb": "Predictions: PNG was read as sRGB (--png linear reads it as linear), EXR and NPZ as "
    "linear, whatever their type.",
    "linear": "Predictions: PNG was read as linear (--png srgb reads it as sRGB), and so were EXR "
    "and NPZ, whatever their type.",
}


def _methods(options: argparse.Namespace) -> list[str | Method]:
    """Return the methods and predictions that were asked for."""
    from photonmap.dataset.files.manifest import read_head
    from photonmap.evaluate.bench.mit import MitSet
    from photonmap.evaluate.bench.predictions import predictions
    from photonmap.evaluate.methods.method import method_names

    if not options.predictions:
        return list(options.method or method_names())
    images = (
        MitSet(Path(options.mit)).geometries
        if options.mit is not None
        else read_head(options.dataset)["images"]
    )
    read = [predictions(folder, images, options.png) for folder in options.predictions]
    return [*(options.method or ()), *read]
