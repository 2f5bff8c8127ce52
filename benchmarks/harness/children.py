"""Commands run as a user runs them, with their time and peak memory."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any, NamedTuple

# The peak memory of a process includes that of its parent at the fork, so a small one starts it.
STARTER = """
import json, resource, subprocess, sys, time
start = time.perf_counter()
done = subprocess.run(sys.argv[1:], capture_output=True, text=True)
seconds = time.perf_counter() - start
peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
unit = 1 if sys.platform == "darwin" else 1024
print(json.dumps([seconds, peak * unit, done.returncode, done.stderr]))
"""


class Run(NamedTuple):
    """What a command took."""

    seconds: float
    peak: int
    """peak resident memory, bytes"""


def run_photonmap(arguments: list[str], environment: dict[str, str] | None = None) -> Run:
    """Run `python -m photonmap` with arguments; raise RuntimeError if it fails."""
    return run_python(["-m", "photonmap", *arguments], environment)


def run_python(arguments: list[str], environment: dict[str, str] | None = None) -> Run:
    """Run this interpreter with arguments; raise RuntimeError if it fails."""
    command = [sys.executable, *arguments]
    done = subprocess.run(
        [sys.executable, "-c", STARTER, *command],
        env={**os.environ, **(environment or {})},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    answer: list[Any] = json.loads(done.stdout)
    if answer[2] != 0:
        raise RuntimeError(f"{' '.join(command)}: {answer[3]}")
    return Run(answer[0], answer[1])
