"""The passes of one large image, rendered in parts with seeds of their own and merged."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from photonmap.buffers import with_defaults
from photonmap.dataset.jobs.schedule import run_tasks
from photonmap.errors import InputError
from photonmap.io.scene_source import SceneSource
from photonmap.render import render_file
from photonmap.results.merge import merge
from photonmap.results.result import Result, load_result
from photonmap.settings import Options, Settings


@dataclass(frozen=True)
class Part:
    """Some of the passes; what is sent to workers."""

    source: SceneSource  # the scene
    options: Options  # of the render, with the part's seed and number of passes
    output: Path  # file to write the result to
    threads: int | None = None  # None for those that the options say

    @property
    def is_complete(self) -> bool:
        """Whether all passes of the part were written."""
        try:
            record = json.loads(self.output.with_suffix(".json").read_text(encoding="utf-8"))
            found = record["passes"], record["arguments"]["seed"]
            return self.output.is_file() and found == (self.options.passes, self.options.seed)
        except (OSError, ValueError, KeyError):
            return False


def plan_parts(source: SceneSource, options: Options, count: int, folder: Path) -> list[Part]:
    """Divide the passes of a render among `count` parts with successive seeds."""
    passes = options.passes
    if passes is None or options.seconds is not None or options.error is not None:
        raise InputError("split divides passes: give --passes, and neither --seconds nor --error")
    if options.checkpoint is not None:
        raise InputError("parts have no checkpoints: remove --checkpoint; --resume keeps parts")
    if not 2 <= count <= passes:
        raise InputError(f"parts {count} must be from 2 to the number of passes, {passes}")
    common = replace(options, buffers=with_defaults(options.buffers), resume=False)
    Settings.of(common)
    shares = [passes * (part + 1) // count - passes * part // count for part in range(count)]
    return [
        Part(
            source,
            replace(common, seed=options.seed + part, passes=share),
            folder.resolve() / f"part-{part:04}.exr",
        )
        for part, share in enumerate(shares)
    ]


def find_missing(parts: Sequence[Part], folder: Path, resume: bool) -> list[Part]:
    """Return the parts that are not complete."""
    if folder.exists() and not resume:
        raise InputError("holds parts of an earlier run; add --resume, or remove it", folder)
    return [part for part in parts if not part.is_complete]


def render_parts(parts: Sequence[Part], scheduler: str, workers: int) -> Iterator[Part]:
    """Render parts, and yield each as soon as it is complete."""
    for part, reason in run_tasks(parts, scheduler, workers, render_part):
        if reason is not None:
            raise InputError(f"{reason}; fix it, and continue with --resume", part.output)
        yield part


def render_part(part: Part) -> None:
    """Render a part and write its files, unless it is complete.

    Raises
    ------
    InputError : it cannot be rendered
    OSError : it cannot be written
    KeyboardInterrupt : at Ctrl-C; nothing is written
    """
    if part.is_complete:  # a worker wrote it, and died before it said so
        return
    threads = part.threads or part.options.threads
    result = render_file(part.source, replace(part.options, threads=threads))
    if result.record["interrupted"]:
        raise KeyboardInterrupt
    result.save(part.output)


def merge_parts(
    parts: Sequence[Part], folder: Path, output: Path, buffers: list[str] | None, white: str
) -> Result:
    """Merge complete parts, write some buffers of the result, or all, and remove their folder."""
    files = [str(part.output) for part in parts]
    merged = merge([load_result(file) for file in files], files)
    merged.save(output, buffers, white)
    shutil.rmtree(folder)
    return merged
