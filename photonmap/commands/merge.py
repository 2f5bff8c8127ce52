"""The command `python -m photonmap merge`: several runs of one scene become one."""

from __future__ import annotations

import argparse

from photonmap.commands import shared

HELP = "Merge renders of one scene with different seeds into the result of one longer run."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    text = "a render that was written with all buffers"
    parser.add_argument("files", nargs="+", metavar="FILE.exr", help=text)
    text = "where to write the result"
    given = shared.reader(shared.file_name)
    parser.add_argument("-o", "--output", type=given, required=True, metavar="FILE.exr", help=text)
    shared.add_quiet(parser)


def run(options: argparse.Namespace) -> None:
    """Merge the files and write the result."""
    from photonmap.results.files import check_output
    from photonmap.results.merge import merge
    from photonmap.results.result import load_result

    check_output(options.output)
    merged = merge([load_result(file) for file in options.files], options.files)
    merged.save(options.output)
    if not options.quiet:
        record = merged.record
        error = "unknown" if record["error"] is None else f"{record['error']:.4f}"
        seeds = ", ".join(str(run["seed"]) for run in record["merged"])
        print(f"{record['passes']} passes of seeds {seeds}, error {error}: {options.output}")
