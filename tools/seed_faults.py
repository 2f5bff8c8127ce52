"""Seed single-line faults, and count how many of them a suite of tests catches.

    python tools/seed_faults.py                    # the 60 faults, by number
    python tools/seed_faults.py --run 0:10         # which test catches each of the first ten
    python tools/seed_faults.py --run 0:60:5 --quick
    python tools/seed_faults.py --both ../before             # 60 on lines that both checkouts have
    python tools/seed_faults.py --both ../before --run 0:60
    python tools/seed_faults.py --both ../before --run 0:60 --in ../before
    python tools/seed_faults.py --run 0:60 --results out/faults.txt   # goes on where it stopped
    python tools/seed_faults.py --run 24 --tests tests/render/test_painted_meshes.py

The list is fixed by a seed: as many faults in each of five parts of the package, at random places.
A copy of the checkout gets one fault at a time, and tests run until one fails: those of the part
first, then, unless `--quick`, all. A fault may change nothing that a test could see; such a one
survives any suite. To compare two suites, each runs on its own sources, with the same faults, and
with a results file and a `NUMBA_CACHE_DIR` of its own: wrong kernels are compiled into it.
"""

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
SEED, COUNT = 20, 60
PARTS = {
    "kernels": ("tests/golden", "tests/kernels", "tests/bsdf", "tests/seams"),
    "photonmap/film": ("tests/film", "tests/golden"),
    "photonmap/compile": ("tests/compile", "tests/golden"),
    "photonmap/io/readers": ("tests/io",),
    "photonmap/results": ("tests/results",),
}
"""Folders of sources, and the tests that are tried first."""
SWAPPED = {
    ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.Lt: ">=", ast.Gt: "<=",
    ast.LtE: ">", ast.GtE: "<", ast.Eq: "!=", ast.NotEq: "==", ast.And: "or", ast.Or: "and",
}  # fmt: skip
"""What an operator becomes"""
LONGEST = 1800
"""Seconds of a run of all tests, after which a fault counts as caught."""


class Fault(NamedTuple):
    """A line that is wrong."""

    path: str
    line: int
    before: str
    after: str

    @property
    def part(self) -> str:
        """The part of the package, a key of `PARTS`."""
        return next(name for name in PARTS if self.path.startswith(f"{name}/"))


def find_faults(other: Path | None = None, seed: int = SEED, count: int = COUNT) -> list[Fault]:
    """Return the faults, as many in each part; on lines that another checkout has too."""
    choose, chosen = random.Random(seed), []
    for part in PARTS:
        paths = sorted((ROOT / part).rglob("*.py"))
        possible = [fault for path in paths for fault in _faults_of(path)]
        if other is not None:
            here, there = (_lines_of(root / part) for root in (ROOT, other))
            possible = [
                fault
                for fault in possible
                if len(here[fault.before.strip()]) == len(there[fault.before.strip()]) == 1
            ]
        chosen += choose.sample(possible, count // len(PARTS))
    return chosen


def _lines_of(folder: Path) -> defaultdict[str, list[tuple[Path, int]]]:
    """Return where each line of a folder's sources stands: (path, its number from 0)."""
    found = defaultdict(list)
    for path in sorted(folder.rglob("*.py")):
        for number, line in enumerate(path.read_text("utf-8").splitlines()):
            found[line.strip()].append((path, number))
    return found


def _faults_of(path: Path) -> Iterator[Fault]:
    """Find all faults that the operators and numbers in functions of a file allow."""
    text = path.read_text("utf-8")
    lines = text.splitlines()
    functions = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.FunctionDef)]
    for node in {id(n): n for f in functions for s in f.body for n in ast.walk(s)}.values():
        change = _change(node, lines)
        if change:
            line, first, last, new = change
            old = lines[line - 1]
            bent = (old.encode()[:first] + new.encode() + old.encode()[last:]).decode()
            yield Fault(path.relative_to(ROOT).as_posix(), line, old, bent)


def _change(node: ast.AST, lines: list[str]) -> tuple[int, int, int, str] | None:
    """Return (line, first byte, byte after the last, new text) of a fault at a node, if any."""
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        new = str(node.value + 1) if type(node.value) is int or not node.value else ""
        new = new or f"({node.value} * 0.9)"
        return node.lineno, node.col_offset, node.end_col_offset or 0, new
    if isinstance(node, ast.BinOp):
        return _between(node.left, node.right, type(node.op), lines)
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        return _between(node.left, node.comparators[0], type(node.ops[0]), lines)
    if isinstance(node, ast.BoolOp) and len(node.values) == 2:
        return _between(*node.values, type(node.op), lines)
    return None


def _between(
    left: ast.expr, right: ast.expr, operator: type, lines: list[str]
) -> tuple[int, int, int, str] | None:
    """Return the change of an operator that stands between two operands on one line."""
    if operator not in SWAPPED or left.end_lineno != right.lineno:
        return None
    first, last = left.end_col_offset or 0, right.col_offset
    there = lines[right.lineno - 1].encode()[first:last].decode()
    if "(" in there or ")" in there:
        return None
    return right.lineno, first, last, f" {SWAPPED[operator]} "


def try_fault(fault: Fault, folder: Path, turns: list[list[str]], workers: int) -> str:
    """Return the first test that fails with a fault in a copy of a checkout; "" for none.

    `turns` are the tests of each run: one follows if the one before catches nothing.
    """
    places = _lines_of(folder / fault.part)[fault.before.strip()]
    path, number = next(
        (place for place in places if place == (folder / fault.path, fault.line - 1)), places[0]
    )
    right = path.read_text("utf-8")
    lines = right.splitlines(keepends=True)
    indent = lines[number][: len(lines[number]) - len(lines[number].lstrip())]
    lines[number] = f"{indent}{fault.after.strip()}\n"
    path.write_text("".join(lines), "utf-8")
    try:
        return next(filter(None, (_first_failure(folder, tests, workers) for tests in turns)), "")
    finally:
        path.write_text(right, "utf-8")


def _first_failure(folder: Path, tests: list[str], workers: int) -> str:
    """Run tests until one fails; return its name, or "" if none does."""
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-m", "not slow", *tests]
    command += ["-n", str(workers)] if workers > 1 else []
    environment = os.environ | {"PYTHONPATH": str(folder)}
    try:
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, timeout=LONGEST
        )
    except subprocess.TimeoutExpired:
        return "out of time"
    if done.returncode == 0:
        return ""
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0].split(" - ")[0] if failed else f"exit code {done.returncode}"


def read_results(path: Path | None) -> dict[str, str]:
    """Return what caught each fault, "" for nothing yet, by the lines of a file, if it is there."""
    if path is None or not path.exists():
        return {}
    return dict(line.split("\t") for line in path.read_text("utf-8").splitlines())


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", metavar="FIRST:LAST:STEP", help="try these, by number")
    parser.add_argument("--quick", action="store_true", help="run the tests of the part alone")
    parser.add_argument("--tests", nargs="+", help="run these instead of those of the part")
    parser.add_argument("--workers", type=int, default=2, help="processes of tests, 2 by default")
    parser.add_argument("--both", type=Path, help="only lines that this checkout has too")
    parser.add_argument(
        "--in", type=Path, help="the checkout that gets them", default=ROOT, dest="root"
    )
    parser.add_argument(
        "--results", type=Path, help="a file to add to; what it says is caught is not tried again"
    )
    return parser.parse_args()


def main() -> None:
    """List the faults, or try some of them."""
    options = _parse()
    faults = find_faults(options.both)
    if options.run is None:
        for number, fault in enumerate(faults):
            print(f"{number:2} {fault.path}:{fault.line}\n   {fault.before}\n   {fault.after}")
        return
    first, *rest = map(int, options.run.split(":"))
    caught, tried = 0, range(first, *(rest or [first + 1]))
    known = read_results(options.results)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "checkout"
        shutil.copytree(options.root, folder, ignore=shutil.ignore_patterns(".git", ".venv", "out"))
        for number in tried:
            fault = faults[number]
            name = f"{fault.path}:{fault.line}: {fault.after.strip()}"
            if not known.get(name):
                turns = [options.tests or list(PARTS[fault.part])]
                turns += [] if options.quick or options.tests else [["tests"]]
                known[name] = try_fault(fault, folder, turns, options.workers)
                if options.results is not None:
                    with options.results.open("a", encoding="utf-8") as file:
                        file.write(f"{name}\t{known[name]}\n")
            caught += bool(known[name])
            print(f"{number:2} {name}: {known[name] or 'SURVIVED'}", flush=True)
    print(f"{caught} of {len(tried)} caught")


if __name__ == "__main__":
    main()
