"""The command line: `python -m photonmap SCENE [options]`, or the name of another command."""

from __future__ import annotations

import argparse
import signal
import sys
import time
import warnings
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from photonmap.errors import InputError, SceneWarning, listening
from photonmap.options import add_render_options
from photonmap.progress import Progress, choose_progress
from photonmap.scene_options import load_chosen_scene, name_measured_sets

if TYPE_CHECKING:
    from photonmap.result import Result

BAD_INPUT, INTERRUPTED = 2, 130

_COMMANDS = {
    "dataset": "photonmap.dataset.command",
    "merge": "photonmap.merge_command",
    "sensors": "photonmap.sensors.command",
    "split": "photonmap.split_command",
    "study": "photonmap.study.command",
}
"""Modules with HELP, add_arguments and run, which may return an exit code."""


_PASSED_ON = (
    "size", "pixel", "passes", "seconds", "error", "photons", "seed", "threads", "method",
    "effects", "per_light", "adaptive", "memory", "resume",
)  # fmt: skip
"""Options that `photonmap.render` takes by the same name."""


class _Parser(argparse.ArgumentParser):
    """A parser that tells an error in one line."""

    def error(self, message: str) -> Any:
        raise InputError(f"{message} (see python -m photonmap --help)")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Returns
    -------
    0; 1 where part of a data set failed; 2 for bad input; 130 for Ctrl-C before the first pass
    """
    warnings.showwarning = _show_warning
    try:
        return _dispatch(sys.argv[1:] if arguments is None else arguments)
    except InputError as error:
        print(f"photonmap: error: {error}", file=sys.stderr)
        return BAD_INPUT
    except (OSError, MemoryError) as error:
        print(f"photonmap: error: {error or 'out of memory'}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("photonmap: interrupted; nothing written", file=sys.stderr)
        return INTERRUPTED


def _dispatch(arguments: list[str]) -> int:
    """Run the command that the first argument names, a render if it names none; return 0 or 1."""
    name = arguments[0] if arguments else ""
    if name not in _COMMANDS:
        _run(_parser().parse_args(arguments))
        return 0
    command = import_module(_COMMANDS[name])
    parser = _Parser(prog=f"photonmap {name}", description=command.HELP, allow_abbrev=False)
    command.add_arguments(parser)
    return command.run(parser.parse_args(arguments[1:])) or 0


OF_PREVIEW = ("radiance", "emission")
"""Buffers that the PNG is made of."""


def _run(options: argparse.Namespace) -> None:
    from photonmap.output import check_output

    output = options.output or Path(options.scene).with_suffix(".exr").name
    check_output(output, options.buffers)
    name_measured_sets(options)
    progress = choose_progress(options.quiet)
    try:
        result = render_options(options, output, progress)
        # What is done is kept, however often Ctrl-C is pressed.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        progress.stage("write")
        result.save(output, buffers=options.buffers)
    finally:
        progress.close()
    if not options.quiet:
        _report(result.record, output)


def render_options(options: argparse.Namespace, output: str, progress: Progress) -> Result:
    """Load the scene and render it, as the options of `photonmap.options` say."""
    from photonmap.bands import Bands

    bands = Bands.parse(options.bands, options.range)
    with listening() as told:
        start = time.perf_counter()
        progress.stage("load")
        scene = load_chosen_scene(options)
        loading = time.perf_counter() - start
        from photonmap.render import render

        result = render(
            scene,
            bands=bands,
            buffers=None if options.buffers is None else {*options.buffers, *OF_PREVIEW},
            checkpoint=_checkpoint(options, output),
            progress=progress,
            **{name: getattr(options, name) for name in _PASSED_ON},
        )
    result.record["warnings"] = told
    result.record["seconds"]["load"] += loading
    return result


def _checkpoint(options: argparse.Namespace, output: str) -> Path | None:
    """Return the file to save the state to, if that is asked for."""
    if options.checkpoint is None and not options.resume:
        return None
    return Path(options.checkpoint or Path(output).with_suffix(".checkpoint"))


def _report(record: dict[str, Any], output: str) -> None:
    """Print what came out and where it is."""
    if record["camera"]["framed"]:
        x, y, z = record["camera"]["origin"]
        print(f"no camera given: framed from +z, at {x:.6g},{y:.6g},{z:.6g}")
    print(_effect_table(record["effects"]))
    state = "interrupted after " if record["interrupted"] else ""
    earlier = f" ({record['resumed']} of them earlier)" if record["resumed"] else ""
    print(
        f"{state}{record['passes']} passes{earlier} in {record['seconds']['render']:.1f} s, "
        f"{_reached(record)}: {output}, {Path(output).with_suffix('.png')}, "
        f"{Path(output).with_suffix('.json')}"
    )


def _reached(record: dict[str, Any]) -> str:
    """Tell the error that was judged, and of how many pixels it says nothing."""
    goal = record["goal"] or {"buffer": "radiance", "percentile": None, "reached": record["error"]}
    error = "unknown" if goal["reached"] is None else f"{goal['reached']:.4f}"
    kind = "" if goal["buffer"] == "radiance" else f" of {goal['buffer']}"
    if goal["percentile"] is not None:
        kind += f" at {goal['percentile']:g}% of pixels and bands"
    left = f", {record['unresolved']} pixels unresolved" if record["unresolved"] else ""
    return f"error {error}{kind}{left}"


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
        f"Other commands: {', '.join(f'photonmap {name} --help' for name in _COMMANDS)}.",
        allow_abbrev=False,
    )
    add_render_options(parser)
    return parser
