"""Render the reference of the Cornell box with Mitsuba 3 into out/cornell.npz, in about 10 min.

Usage: `python -m benchmarks.accuracy.make_reference [--mitsuba PYTHON] [--samples 16384]`.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.mitsuba_client import ONE_BOUNCE, ONLY_LAMPS, UNLIMITED, Mitsuba
from benchmarks.harness.options import MADE_REFERENCE, Options

CHUNK = 256


def main() -> int:
    """Render two halves, direct light and the mask; write them in the form that `truth` reads."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.accuracy.make_reference")
    parser.add_argument("--mitsuba", metavar="PYTHON")
    parser.add_argument(
        "--samples", type=int, default=16384, help="per pixel, both halves together"
    )
    arguments = parser.parse_args()
    options = Options.choose(None, arguments.mitsuba, None)
    with Mitsuba(options.mitsuba, options.threads) as mitsuba:
        if mitsuba.reason:
            print(mitsuba.reason, file=sys.stderr)
            return 1
        chunks = max(arguments.samples // (2 * CHUNK), 1)
        halves = [_mean(mitsuba, UNLIMITED, range(h, 2 * chunks, 2)) for h in (0, 1)]
        seen = _mean(mitsuba, ONE_BOUNCE, range(1000, 1000 + chunks))
        lamp = _mean(mitsuba, ONLY_LAMPS, range(2000, 2004))
    full = 0.5 * (halves[0] + halves[1])
    MADE_REFERENCE.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(
        MADE_REFERENCE,
        full=full,
        half0=halves[0],
        half1=halves[1],
        direct=seen - lamp,
        indirect=full - seen,
        mask=~lamp.any(axis=-1),
    )
    print(MADE_REFERENCE)
    return 0


def _mean(mitsuba: Mitsuba, depth: int, seeds: range) -> NDArray[np.float32]:
    """Return the mean of renders with `CHUNK` samples per pixel each."""
    total = np.zeros((256, 256, 3))
    for count, seed in enumerate(seeds, start=1):
        total += mitsuba.render(CHUNK, seed, depth)[0]
        print(f"\rdepth {depth}: {count} of {len(seeds)}", end="", file=sys.stderr)
    print(file=sys.stderr)
    return (total / len(seeds)).astype(np.float32)


if __name__ == "__main__":
    sys.exit(main())
