"""The command line: `python -m photonmap SCENE [options]`, or the name of another command."""

from __future__ import annotations

import argparse
import signal
import sys
import time
import warnings
from importlib import import_module
from pathlib import Path
from typing import Any, TextIO

from photonmap.arguments import limits, size
from photonmap.budget import CEILING, DEFAULT_ERROR
from photonmap.errors import InputError, SceneWarning, listening
from photonmap.progress import choose_progress
from photonmap.scene_options import add_scene_options, load_chosen_scene, name_measured_sets

BAD_INPUT, INTERRUPTED = 2, 130

_COMMANDS = {"sensors": "photonmap.sensors.command", "study": "photonmap.study.command"}
"""Modules with HELP, add_arguments and run."""


class _Parser(argparse.ArgumentParser):
    """A parser that tells an error in one line."""

    def error(self, message: str) -> Any:
        raise InputError(f"{message} (see python -m photonmap --help)")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return 0, 2 for bad input, or 130 for Ctrl-C before the first pass."""
    warnings.showwarning = _show_warning
    try:
        _dispatch(sys.argv[1:] if arguments is None else arguments)
    except InputError as error:
        print(f"photonmap: error: {error}", file=sys.stderr)
        return BAD_INPUT
    except (OSError, MemoryError) as error:
        print(f"photonmap: error: {error or 'out of memory'}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("photonmap: interrupted; nothing written", file=sys.stderr)
        return INTERRUPTED
    return 0


def _dispatch(arguments: list[str]) -> None:
    """Run the command that the first argument names; a render if it names none."""
    name = arguments[0] if arguments else ""
    if name not in _COMMANDS:
        _run(_parser().parse_args(arguments))
        return
    command = import_module(_COMMANDS[name])
    parser = _Parser(prog=f"photonmap {name}", description=command.HELP, allow_abbrev=False)
    command.add_arguments(parser)
    command.run(parser.parse_args(arguments[1:]))


def _run(options: argparse.Namespace) -> None:
    from photonmap.bands import Bands
    from photonmap.output import check_output

    output = options.output or Path(options.scene).with_suffix(".exr").name
    check_output(output, options.buffers)
    bands = Bands.parse(options.bands, options.range)
    name_measured_sets(options)
    progress = choose_progress(options.quiet)
    try:
        with listening() as told:
            start = time.perf_counter()
            progress.stage("load")
            scene = load_chosen_scene(options)
            loading = time.perf_counter() - start
            from photonmap.render import render

            result = render(
                scene,
                bands=bands,
                size=options.size,
                pixel=options.pixel,
                passes=options.passes,
                seconds=options.seconds,
                error=options.error,
                photons=options.photons,
                seed=options.seed,
                threads=options.threads,
                method=options.method,
                effects=options.effects,
                per_light=options.per_light,
                progress=progress,
            )
        # What is done is kept, however often Ctrl-C is pressed.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        result.record["warnings"] = told
        result.record["seconds"]["load"] += loading
        progress.stage("write")
        result.save(output, buffers=options.buffers)
    finally:
        progress.close()
    if not options.quiet:
        _report(result.record, output)


def _report(record: dict[str, Any], output: str) -> None:
    """Print what came out and where it is."""
    if record["camera"]["framed"]:
        x, y, z = record["camera"]["origin"]
        print(f"no camera given: framed from +z, at {x:.6g},{y:.6g},{z:.6g}")
    print(_effect_table(record["effects"]))
    error = "unknown" if record["error"] is None else f"{record['error']:.4f}"
    state = "interrupted after " if record["interrupted"] else ""
    print(
        f"{state}{record['passes']} passes in {record['seconds']['render']:.1f} s, "
        f"error {error}: {output}, {Path(output).with_suffix('.png')}, "
        f"{Path(output).with_suffix('.json')}"
    )


def _effect_table(effects: dict[str, Any]) -> str:
    """Lay out what was simulated, and why."""
    lines = []
    for name, effect in effects.items():
        spent = "" if effect["seconds"] is None else f" ({effect['seconds']:.1f} s)"
        lines.append(f"{name:<13} {'on ' if effect['on'] else 'off'}  {effect['why']}{spent}")
    return "\n".join(lines)


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    prefix = "warning" if issubclass(category, SceneWarning) else category.__name__
    print(f"photonmap: {prefix}: {message}", file=sys.stderr)


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="photonmap",
        description="Render a scene into direct, indirect, reflectance and shading, in N bands, "
        "with a standard error on each.",
        epilog="Writes FILE.exr (all buffers), FILE.png (preview) and FILE.json (run record). "
        "Other commands: photonmap sensors --help, photonmap study --help.",
        allow_abbrev=False,
    )
    add_scene_options(parser)
    parser.add_argument("--version", action="version", version=_version())
    parser.add_argument("--quiet", action="store_true", help="print errors and warnings alone")
    image = parser.add_argument_group("image")
    image.add_argument(
        "--bands",
        default="6",
        metavar="BANDS",
        help="N Gaussian bands (default 6), box:N, FILE.csv of sensitivities, the name of a camera "
        "or observer; or rgb: the scene's R, G, B as they stand",
    )
    image.add_argument(
        "--range", type=limits, metavar="LOW:HIGH", help="of the bands, nm (default 400:700)"
    )
    image.add_argument("--size", type=size, default=(512, 512), metavar="WxH", help="512x512")
    image.add_argument(
        "--pixel",
        choices=("box", "center"),
        default="box",
        help="samples cover the pixel (default), or all pass through its centre",
    )
    budget = parser.add_argument_group("budget", f"one of these; --error {DEFAULT_ERROR} if none")
    budget.add_argument("--passes", type=int, metavar="N")
    budget.add_argument("--seconds", type=float, metavar="S", help="of rendering")
    budget.add_argument(
        "--error",
        type=float,
        metavar="E",
        help=f"relative standard error of radiance; gives up after {CEILING / 3600:g} hour",
    )
    work = parser.add_argument_group("work")
    work.add_argument(
        "--photons", type=int, metavar="N", help="emitted in each pass (default: one a pixel)"
    )
    work.add_argument("--seed", type=int, default=0, metavar="N", help="default 0")
    work.add_argument("--threads", type=int, metavar="N", help="default: every processor")
    work.add_argument(
        "--method",
        choices=("photon", "path"),
        default="photon",
        help="photon mapping, or the plain path tracer that checks it",
    )
    work.add_argument(
        "--effects",
        default="auto",
        metavar="LIST",
        help="auto: what the scene calls for (default); all; or names, separated by commas",
    )
    work.add_argument(
        "--per-light",
        action="store_true",
        help="split direct, indirect, caustics and shading by groups of lights",
    )
    files = parser.add_argument_group("files")
    files.add_argument("--output", metavar="FILE.exr", help="default: SCENE's name, here")
    files.add_argument(
        "--buffers",
        type=lambda text: text.split(","),
        metavar="LIST",
        help="write these alone, separated by commas (default: all)",
    )
    return parser


def _version() -> str:
    from photonmap import __version__

    return f"photonmap {__version__}"
