"""Damaged files: one clear line, exit code 2, nothing written, in bounded time and memory."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = 10 * int(os.environ.get("PHOTONMAP_EXAMPLES", "6"))
SEED = os.environ.get("PHOTONMAP_SEED", "0")
KINDS = ("obj", "mtl", "toml", "ply", "ascii ply", "stl", "ascii stl", "glb")


@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_file_is_told_in_one_line(kind, tmp_path):
    program = Path(__file__).with_name("damage.py")
    done = subprocess.run(
        [sys.executable, str(program), str(tmp_path), kind, SEED, str(EXAMPLES)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    findings = json.loads(done.stdout)
    assert not findings, "\n\n".join(f"{n}: {wrong}: {told}" for n, wrong, told, _ in findings)
