"""The command `python -m photonmap split`: the passes of one large image, on several processes."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from photonmap.errors import InputError
from photonmap.options import add_render_options
from photonmap.scene_options import name_measured_sets

HELP = "render the passes of one large image in parts, on several processes, and merge them"
LOCAL = "local"


@dataclass(frozen=True)
class Part:
    """Some of the passes, with a seed of their own; what is sent to workers.

    Parameters
    ----------
    options : of the render, as `vars` gives them; its output is the part's
    threads : None for those that the options say
    """

    options: dict[str, Any]
    threads: int | None = None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command: those of a render, and where its parts are rendered."""
    add_render_options(parser)
    split = parser.add_argument_group("parts")
    split.add_argument(
        "--parts", type=int, required=True, metavar="N", help="seeds, from --seed on"
    )
    split.add_argument(
        "--scheduler", default=LOCAL, metavar="ADDRESS", help="local, or one of dask.distributed"
    )
    split.add_argument("--workers", type=int, default=1, metavar="N", help="local processes")


def run(options: argparse.Namespace) -> None:
    """Render the parts, merge them and write the result; parts are kept until then.

    Raises
    ------
    InputError
        if an option is none, the output cannot be written, or a part failed
    """
    from photonmap.dataset.schedule import check_scheduler, run_tasks
    from photonmap.merge import merge
    from photonmap.output import check_output
    from photonmap.result import load_result

    output = check_output(options.output or Path(options.scene).with_suffix(".exr").name)
    check_scheduler(options.scheduler, options.workers)
    folder = output.with_suffix(".parts")
    parts = plan_parts(options, folder)
    missing = _find_missing(parts, folder, options.resume)
    folder.mkdir(exist_ok=True)
    for part, reason in run_tasks(missing, options.scheduler, options.workers, render_part):
        if reason is not None:
            raise InputError(f"{reason}; mend it, and go on with --resume", part.options["output"])
        _tell(options, f"{Path(part.options['output']).name} is done")
    files = [part.options["output"] for part in parts]
    merged = merge([load_result(file) for file in files], files)
    merged.save(output, options.buffers)
    shutil.rmtree(folder)
    record = merged.record
    _tell(options, f"{record['passes']} passes, error {record['error']:.4f}: {output}")


def plan_parts(options: argparse.Namespace, folder: Path) -> list[Part]:
    """Share the passes out.

    Raises
    ------
    InputError : another budget than passes, or a number of parts out of range
    """
    passes, count = options.passes, options.parts
    if passes is None or options.seconds is not None or options.error is not None:
        raise InputError(
            "split shares passes out: give --passes, and neither --seconds nor --error"
        )
    if options.checkpoint is not None:
        raise InputError("parts have no checkpoints: leave --checkpoint out; --resume keeps parts")
    if not 2 <= count <= passes:
        raise InputError(f"parts {count} must be from 2 to the number of passes, {passes}")
    common = vars(options) | {"buffers": None, "resume": False, "quiet": True}
    return [
        Part(
            common
            | {
                "seed": options.seed + index,
                "passes": passes * (index + 1) // count - passes * index // count,
                "output": str(folder.resolve() / f"part-{index:04}.exr"),
            }
        )
        for index in range(count)
    ]


def render_part(part: Part) -> None:
    """Render a part and write its files; one that is there is left as it is.

    Raises
    ------
    InputError : input that cannot be rendered
    OSError : it cannot be written
    KeyboardInterrupt : at Ctrl-C; nothing is written
    """
    from photonmap.cli import render_options
    from photonmap.progress import Silent

    if _is_there(part):
        return
    threads = part.threads or part.options["threads"]
    options = argparse.Namespace(**{**part.options, "threads": threads})
    name_measured_sets(options)
    result = render_options(options, options.output, Silent())
    if result.record["interrupted"]:
        raise KeyboardInterrupt
    result.save(options.output)


def _is_there(part: Part) -> bool:
    """Tell whether all passes of a part were written."""
    file = Path(part.options["output"])
    try:
        record = json.loads(file.with_suffix(".json").read_text(encoding="utf-8"))
        wanted = part.options["passes"], part.options["seed"]
        return file.is_file() and (record["passes"], record["arguments"]["seed"]) == wanted
    except (OSError, ValueError, KeyError):
        return False


def _find_missing(parts: Sequence[Part], folder: Path, resume: bool) -> list[Part]:
    """Return the parts to be rendered; refuse a folder that is there unless it is to be used."""
    if folder.exists() and not resume:
        raise InputError("holds parts of an earlier run; add --resume, or remove it", folder)
    return [part for part in parts if not _is_there(part)]


def _tell(options: argparse.Namespace, line: str) -> None:
    if not options.quiet:
        print(line, file=sys.stdout, flush=True)
