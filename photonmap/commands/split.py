"""The command `python -m photonmap split`: the passes of one large image, on several processes."""

from __future__ import annotations

import argparse

from photonmap.commands import shared

HELP = "Render the passes of one large image in parts, on several processes, and merge them."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command: those of a render, and where its parts are rendered."""
    shared.add_render_options(parser)
    text = "number of parts; their seeds count up from --seed"
    parts = shared.add_group(parser, "parts", shared.scheduler_rows())
    parts.add_argument("--parts", type=shared.reader(int), required=True, metavar="N", help=text)


def run(options: argparse.Namespace) -> None:
    """Render the parts, merge them and write the result; parts are kept until then."""
    from photonmap.dataset.jobs.parts import find_missing, merge_parts, plan_parts, render_parts
    from photonmap.dataset.jobs.schedule import check_scheduler
    from photonmap.dataset.scenes.recolor import light_groups
    from photonmap.results.files import check_output
    from photonmap.settings import Options

    output = check_output(shared.name_output(options), options.buffers)
    check_scheduler(options.scheduler, options.workers)
    folder = output.with_suffix(".parts")
    chosen = Options(**shared.choose_options(options))
    parts = plan_parts(shared.choose_scene(options), chosen, options.parts, folder)
    if options.per_light:
        check_output(output, options.buffers, light_groups(parts[0].source.load()))
    missing = find_missing(parts, folder, options.resume)
    folder.mkdir(parents=True, exist_ok=True)
    for part in render_parts(missing, options.scheduler, options.workers):
        shared.say(options, f"{part.output.name} is done")
    record = merge_parts(parts, folder, output, options.buffers, options.white).record
    shared.say(options, f"{record['passes']} passes, error {record['error']:.4f}: {output}")
