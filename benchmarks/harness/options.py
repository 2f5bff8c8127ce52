"""Options that all benchmarks share."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path

from photonmap.runtime.workers import default_threads

ROOT = Path(__file__).parents[2]
MADE_REFERENCE = ROOT / "out" / "cornell.npz"


@dataclass(frozen=True)
class Options:
    """Paths, and the number of threads for the renderers."""

    reference: Path
    """cornell.npz: see `truth`"""
    mitsuba: str
    """interpreter with Mitsuba 3"""
    threads: int
    preset: str
    """of the data set to render"""
    dataset: Path | None
    """an existing data set to read instead of rendering one"""
    scenes: tuple[str, ...] = ()
    """of `benchmarks.accuracy.rooms`; all of them if none is named"""
    size: tuple[int, int] | None = None
    """of its images; None for what each scene usually has"""
    kept: Path | None = None
    """folder of what Mitsuba rendered of them in earlier runs"""

    @classmethod
    def choose(
        cls,
        reference: Path | None,
        mitsuba: str | None,
        threads: int | None,
        preset: str = "small",
        dataset: Path | None = None,
        scenes: tuple[str, ...] = (),
        size: tuple[int, int] | None = None,
        kept: Path | None = None,
    ) -> Options:
        """Take flags first, then the environment, then defaults."""
        environment = os.environ
        place = environment.get("PHOTONMAP_REFERENCE", "")
        return cls(
            reference or (Path(place) if place else default_reference()),
            mitsuba or environment.get("PHOTONMAP_MITSUBA_PYTHON") or sys.executable,
            threads or default_threads(),
            preset,
            dataset,
            scenes,
            size,
            kept,
        )


def default_reference() -> Path:
    """Return what `benchmarks.accuracy.make_reference` made, or else a file beside the checkout."""
    shared = ROOT.parent / "shared" / "reference" / "cornell.npz"
    return shared if shared.exists() and not MADE_REFERENCE.exists() else MADE_REFERENCE
