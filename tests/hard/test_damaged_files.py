"""Damaged files: one clear line, exit code 2, nothing written, in bounded time and memory."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.marks import slow

EXAMPLES = os.environ.get("PHOTONMAP_EXAMPLES")
"""Ten times as many files of each kind; without it, a few, and 60 where there is time."""
COUNTS = [10 * int(EXAMPLES)] if EXAMPLES else [3, *slow(40)]
SEED = os.environ.get("PHOTONMAP_SEED", "0")
KINDS = ("obj", "mtl", "toml", "ply", "ascii ply", "stl", "ascii stl", "glb", "xml", "serialized")


@pytest.mark.parametrize("count", COUNTS)
def test_a_damaged_file_is_told_in_one_line(count, tmp_path):
    program = Path(__file__).parents[1] / "helpers" / "damage.py"
    done = subprocess.run(
        [sys.executable, str(program), str(tmp_path), SEED, str(count), *KINDS],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    findings = json.loads(done.stdout)
    assert not findings, "\n\n".join(
        f"{place}: {wrong}: {message}" for place, wrong, message, _ in findings
    )
