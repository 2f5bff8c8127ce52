"""The run record: all that is needed to assess a render and to repeat it."""

from __future__ import annotations

import os
import platform
import time
from functools import cache
from importlib.metadata import PackageNotFoundError, version

from photonmap.spectra.color_text import ILLUMINANTS
from photonmap.spectra.munsell import VARIABLE as MUNSELL

PACKAGES = ("photonmap", "numpy", "numba", "embreex", "OpenImageIO", "colour-science")


def describe_versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that results depend on."""
    return {"python": platform.python_version(), **{name: _version(name) for name in PACKAGES}}


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def describe_code() -> dict[str, str]:
    """Return what the same renders give the same arrays with: versions, and a hash of kernels."""
    from photonmap.kernels.core.jit import CACHE_FOLDER

    return {**describe_versions(), "kernels": CACHE_FOLDER.name.removeprefix("kernels-")}


def describe_measured_sets() -> dict[str, str | None]:
    """Return the files of measured spectra that colours may be named from; None without one."""
    return {"munsell": os.environ.get(MUNSELL), "illuminants": os.environ.get(ILLUMINANTS)}


class Clock:
    """Seconds of the stages of a render, by name."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        """End a stage, which began where the one before ended."""
        now = time.perf_counter()
        self.seconds[stage], self._last = now - self._last, now


def describe_seconds(
    seconds: dict[str, float], earlier: float, photons: float, saving: float | None
) -> dict[str, float]:
    """Return the seconds of each stage; those of rendering include earlier runs.

    Given are those of loading, compiling and rendering, of rendering earlier, of tracing photons,
    and of saving checkpoints, None without them.
    """
    rendering = earlier + seconds["render"]
    return {
        "load": seconds["load"],
        "compile": seconds["compile"],
        "photons": photons,
        "camera": rendering - photons - (saving or 0.0),
        **({} if saving is None else {"checkpoint": saving}),
        "render": rendering,
    }
