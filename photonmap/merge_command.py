"""The command `python -m photonmap merge`: several runs of one scene become one."""

from __future__ import annotations

import argparse

HELP = "merge renders of one scene with different seeds, as if they had been one run"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("files", nargs="+", metavar="FILE.exr", help="written with all buffers")
    parser.add_argument("-o", "--output", required=True, metavar="FILE.exr")
    parser.add_argument("--quiet", action="store_true", help="print errors and warnings alone")


def run(options: argparse.Namespace) -> None:
    """Merge the files and write the result.

    Raises
    ------
    InputError
        if a file is no such render, they cannot be merged, or the output cannot be written
    """
    from photonmap.merge import merge
    from photonmap.output import check_output
    from photonmap.result import load_result

    check_output(options.output)
    merged = merge([load_result(file) for file in options.files], options.files)
    merged.save(options.output)
    if not options.quiet:
        record = merged.record
        error = "unknown" if record["error"] is None else f"{record['error']:.4f}"
        seeds = ", ".join(str(run["seed"]) for run in record["merged"])
        print(f"{record['passes']} passes of seeds {seeds}, error {error}: {options.output}")
