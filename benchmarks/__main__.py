"""Run benchmarks by name (all by default); print tables, write out/bench.json and bench.md."""

from __future__ import annotations

import argparse
import json
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Any

from benchmarks.options import Options
from benchmarks.table import markdown, show
from photonmap.study.machine import DISTURBED, Others, describe_machine

NAMES = (
    "rays",
    "cornell",
    "energy",
    "bands",
    "colors",
    "effects",
    "methods",
    "start",
    "memory",
    "checkpoint",
    "forecast",
    "scaling",
    "hard",
    "dataset",
    "scale",
    "profile",
)
ROOT = Path(__file__).parent.parent


def main() -> int:
    """Run what the command line names."""
    arguments = _parser().parse_args()
    options = Options.choose(
        arguments.reference,
        arguments.mitsuba,
        arguments.threads,
        arguments.preset,
        arguments.dataset,
    )
    report: dict[str, Any] = {"machine": describe_machine(), "benchmarks": {}}
    pages = []
    begin = time.perf_counter()
    for name in arguments.names or NAMES:
        start = time.perf_counter()
        with Others() as others:
            tables = import_module(f"benchmarks.{name}").run(options)
        seconds = time.perf_counter() - start
        for table in tables:
            show(table)
            pages.append(markdown(table))
        busy = ": too much to trust seconds" if others.share > DISTURBED else ""
        print(f"{name}: {seconds:.0f} s, other work took {others.share:.0%} of the machine{busy}\n")
        report["benchmarks"][name] = {
            "seconds": seconds,
            "others": others.share,
            "tables": [vars(table) for table in tables],
        }
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(json.dumps(report, indent=1) + "\n")
    arguments.output.with_suffix(".md").write_text("\n".join(pages))
    print(f"{time.perf_counter() - begin:.0f} s in all: {arguments.output}")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(NAMES)}")
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "bench.json")
    parser.add_argument("--reference", type=Path, help="cornell.npz; or set PHOTONMAP_REFERENCE")
    parser.add_argument(
        "--mitsuba",
        metavar="PYTHON",
        help="interpreter that has Mitsuba 3; or set PHOTONMAP_MITSUBA_PYTHON (default: this one)",
    )
    parser.add_argument("--threads", type=int, help="default: every processor")
    parser.add_argument("--preset", default="small", help="of dataset: small (default), icip2013")
    parser.add_argument(
        "--dataset",
        type=Path,
        metavar="FOLDER",
        help="dataset and scale read this one instead of rendering",
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
