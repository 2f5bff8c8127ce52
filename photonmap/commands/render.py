"""The command `python -m photonmap SCENE`: render a scene, and write the result."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photonmap.commands import INTERRUPTED, shared
from photonmap.io.scene_source import SceneSource
from photonmap.runtime.progress import Progress, choose_progress
from photonmap.runtime.terminal import answering_interrupts
from photonmap.scene.camera import ALL
from photonmap.version import __version__
from photonmap.viewer.live import ADDRESS, Tev

if TYPE_CHECKING:
    from photonmap.integrators.shared_work import SharedWork
    from photonmap.render import RenderPlan
    from photonmap.scene.scene import Scene

HELP = (
    "Render a scene into direct, indirect, reflectance and shading, in N spectral bands, each with "
    "its standard error."
)

PREVIEW_BUFFERS = ("radiance", "emission")
"""Buffers that the PNG is made from."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    shared.add_render_options(parser)
    text = (
        "send the image to the viewer tev while it is rendered; needs pip install "
        f"'photonmap[view]' (without HOST:PORT: {ADDRESS})"
    )
    shared.add_value(parser, "view", "HOST:PORT", text, bare=ADDRESS)
    parser.add_argument("--version", action="version", version=f"photonmap {__version__}")


def run(options: argparse.Namespace) -> int | None:
    """Render, write the files, and print what came out; after Ctrl-C, of the complete passes."""
    from photonmap.results.files import check_apart, check_output

    output, source = shared.name_output(options), shared.choose_scene(options)
    check_output(output, options.buffers)
    if options.camera != ALL:
        outputs = [(source, output)]
    else:
        views = replace(source, view=None).views(options.size)
        outputs = [(view, shared.add_name(output, view.view)) for view in views]
    checkpoints = [_name_checkpoint(options, view, file) for view, file in outputs]
    for _, file in outputs:
        check_output(file, options.buffers)
    for checkpoint, (_, file) in product(filter(None, checkpoints), outputs):
        check_apart(checkpoint, file)
    from photonmap.integrators.shared_work import SharedWork

    work = SharedWork(options.threads, options.memory) if len(outputs) > 1 else None
    with work or nullcontext():
        for done in range(len(outputs)):
            try:
                code = _render(options, outputs[done:], work)
            except KeyboardInterrupt:
                if not done:
                    raise
                text = f"interrupted; {done} of {len(outputs)} views are written"
                print(f"photonmap: {text}", file=sys.stderr)
                return INTERRUPTED
            if code:
                return code
    return None


def _render(
    options: argparse.Namespace,
    outputs: Sequence[tuple[SceneSource, str]],
    work: SharedWork | None,
) -> int | None:
    """Render the first of the views that are left, which share work, and return the exit code."""
    from photonmap.render import render_file
    from photonmap.settings import Options

    source, output = outputs[0]
    given = shared.choose_options(options) | {
        "checkpoint": _name_checkpoint(options, source, output)
    }
    if options.buffers is not None:
        given["buffers"] = {*options.buffers, *PREVIEW_BUFFERS}
    progress = choose_progress(options.quiet)
    viewer = Tev(Path(output).name, options.view) if options.view else None
    try:
        announce = partial(_announce, options, [file for _, file in outputs], progress)
        chosen = Options(**given, progress=progress, watch=viewer)
        result = render_file(source, chosen, announce, work)
        with answering_interrupts():
            progress.stage("write")
            result.save(output, options.buffers, options.white)
            if viewer is not None:
                viewer(result)
    finally:
        progress.close()
        if viewer is not None:
            viewer.close()
    if not options.quiet:
        _report(result.record, output)
    return INTERRUPTED if result.record["interrupted"] else None


def _name_checkpoint(options: argparse.Namespace, source: SceneSource, output: str) -> Path | None:
    """Return the file to save the state to, if that is asked for."""
    if options.checkpoint is None and not options.resume:
        return None
    if not options.checkpoint:
        return Path(output).with_suffix(".checkpoint")
    every = options.camera == ALL
    return Path(shared.add_name(options.checkpoint, source.view) if every else options.checkpoint)


def _announce(
    options: argparse.Namespace,
    files: Sequence[str],
    progress: Progress,
    scene: Scene,
    plan: RenderPlan,
) -> None:
    """Check that files of the light groups can be written; say what will be simulated, and why.

    Of a scene without a camera also print the view.
    """
    from photonmap.results.files import check_output

    for file in files:
        check_output(file, options.buffers, plan.columns.groups)
    if options.quiet:
        return
    progress.close()
    if scene.camera is None:
        x, y, z = plan.scene.camera.origin
        print(
            f"no camera given: seen from the front right, above, at {x:.6g},{y:.6g},{z:.6g}; "
            "if z is up, add --up z"
        )
    width = max(map(len, plan.effects.effects))
    for name, effect in plan.effects.effects.items():
        print(f"{name:<{width}} {'on ' if effect.on else 'off'}  {effect.why}", flush=True)


def _report(record: dict[str, Any], output: str) -> None:
    """Print what came out, and where it is."""
    state = "interrupted after " if record["interrupted"] else ""
    earlier = f" ({record['resumed']} of them earlier)" if record["resumed"] else ""
    passes = f"{record['passes']} pass{'es' * (record['passes'] != 1)}{earlier}"
    print(
        f"{state}{passes} in {record['seconds']['render']:.1f} s, "
        f"{_error_text(record)}: {output}, {Path(output).with_suffix('.png')}, "
        f"{Path(output).with_suffix('.json')}"
    )


def _error_text(record: dict[str, Any]) -> str:
    """Return the error that was reached, and how many pixels it does not cover."""
    goal = record["goal"] or {"buffer": "radiance", "percentile": None, "reached": record["error"]}
    error = "unknown" if goal["reached"] is None else f"{goal['reached']:.4f}"
    kind = "" if goal["buffer"] == "radiance" else f" of {goal['buffer']}"
    if goal["percentile"] is not None:
        kind += f" at {goal['percentile']:g}% of pixels and bands"
    text = f"error {error}{kind}"
    if left := record["unresolved"]:
        text += f", {left} pixel{'s' * (left > 1)} unresolved"
    return text
