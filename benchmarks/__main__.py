"""Run benchmarks by name; print their tables, write out/bench.json and bench.md."""

from __future__ import annotations

import argparse
import json
import sys
import time
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from benchmarks.accuracy.mitsuba_client import start_mitsuba
from benchmarks.harness.options import ROOT, Options
from benchmarks.harness.table import markdown, show
from photonmap.runtime.options import read_size
from photonmap.study.measure import MAX_BACKGROUND_LOAD, BackgroundLoad, describe_machine

BENCHMARKS = {
    "rays": "low_level",
    "cornell": "accuracy",
    "energy": "accuracy",
    "bands": "speed",
    "colors": "accuracy",
    "effects": "speed",
    "methods": "accuracy",
    "start": "speed",
    "memory": "speed",
    "checkpoint": "speed",
    "forecast": "speed",
    "scaling": "speed",
    "hard": "speed",
    "dataset": "datasets",
    "scale": "datasets",
    "profile": "low_level",
}
"""Names of the benchmarks, in the order in which they run, and their folders."""
ON_REQUEST = {"gloss": "accuracy", "matter": "accuracy", "rooms": "accuracy", "views": "speed"}
"""Benchmarks that run only when they are named."""


def main() -> int:
    """Run the benchmarks named on the command line."""
    arguments = _parser().parse_args()
    options = Options.choose(
        arguments.reference,
        arguments.mitsuba,
        arguments.threads,
        arguments.preset,
        arguments.dataset,
        tuple(arguments.scenes.split(",")) if arguments.scenes else (),
        arguments.size,
        arguments.kept,
    )
    if arguments.mitsuba:
        _check_mitsuba(options)
    report: dict[str, Any] = {"machine": describe_machine(), "benchmarks": {}}
    pages = []
    begin = time.perf_counter()
    for name, module in [(name, _load(name)) for name in arguments.names or BENCHMARKS]:
        start = time.perf_counter()
        with BackgroundLoad() as others:
            tables = module.run(options)
        seconds = time.perf_counter() - start
        for table in tables:
            show(table)
            pages.append(markdown(table))
        busy = ": too much to trust the times" if others.share > MAX_BACKGROUND_LOAD else ""
        load = f"other programs took {others.share:.0%} of the machine{busy}"
        print(f"{name}: {seconds:.0f} s, {load}\n")
        report["benchmarks"][name] = {
            "seconds": seconds,
            "others": others.share,
            "tables": [vars(table) for table in tables],
        }
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(json.dumps(report, indent=1) + "\n")
    arguments.output.with_suffix(".md").write_text("\n".join(pages))
    print(f"{time.perf_counter() - begin:.0f} s in total: {arguments.output}")
    return 0


def _check_mitsuba(options: Options) -> None:
    """End before anything is measured if the Mitsuba that was asked for does not run."""
    other = start_mitsuba(options)
    if isinstance(other, str):
        raise SystemExit(other)
    with other:
        pass


def _load(name: str) -> ModuleType:
    """Import a benchmark by its name."""
    folders = BENCHMARKS | ON_REQUEST
    if name not in folders:
        raise SystemExit(f"there is no benchmark {name!r}; choose from {', '.join(folders)}")
    return import_module(f"benchmarks.{folders[name]}.{name}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    names = f"any of {', '.join(BENCHMARKS)}; only if named: {', '.join(ON_REQUEST)}"
    parser.add_argument("names", nargs="*", metavar="NAME", help=names)
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "bench.json")
    parser.add_argument("--reference", type=Path, help="cornell.npz (or set PHOTONMAP_REFERENCE)")
    parser.add_argument(
        "--mitsuba",
        metavar="PYTHON",
        help="interpreter with Mitsuba 3 (or set PHOTONMAP_MITSUBA_PYTHON; default: this one)",
    )
    parser.add_argument("--threads", type=int, help="default: all processors")
    parser.add_argument(
        "--preset", default="small", help="for dataset: small (default) or icip2013"
    )
    parser.add_argument(
        "--dataset",
        type=Path,
        metavar="FOLDER",
        help="existing data set that dataset and scale read instead of rendering one",
    )
    parser.add_argument("--scenes", metavar="NAME,…", help="for rooms, gloss and matter: which")
    parser.add_argument(
        "--size",
        type=read_size,
        metavar="WxH",
        help="for rooms, gloss and matter: of images, pixels",
    )
    parser.add_argument(
        "--kept",
        type=Path,
        metavar="FOLDER",
        help="for rooms: where Mitsuba's images are kept, and read if they are of the same scenes",
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
