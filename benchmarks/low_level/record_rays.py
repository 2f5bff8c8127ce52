"""Record the rays of a camera pass: `python -m benchmarks.low_level.record_rays FILE.npy`.

Kernels find rtcIntersect1 and rtcOccluded1 by name. Here, these names are bound to functions that
store the ray and then call Embree: slow, but exact whatever the kernels do. This needs a process
of its own, because machine code stays bound to the symbols it was loaded with.
"""

from __future__ import annotations

import ctypes
import sys

import llvmlite.binding
import numpy as np

from benchmarks.low_level.one_pass import OnePass
from photonmap.kernels.geometry.embree import LIBRARY
from photonmap.runtime.workers import Workers

NEAREST, ANY = 0, 1
"""Kinds of rays: for rtcIntersect1 and rtcOccluded1."""
REALS = 9
"""Floats of an RTCRay that are stored: origin, tnear, direction, time, tfar."""
MOST = 1 << 23
FUNCTION = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)


class Recorder:
    """Stands between the kernels and Embree, and stores rays while `on`."""

    def __init__(self) -> None:
        self.on = False
        self._rays = np.empty((MOST, REALS), np.float32)
        self._kinds: list[int] = []
        self._functions = [
            self._stand_in(name, kind)
            for kind, name in ((NEAREST, "rtcIntersect1"), (ANY, "rtcOccluded1"))
        ]

    def _stand_in(self, name: str, kind: int) -> object:
        real, address = getattr(LIBRARY, name), self._rays.ctypes.data

        def cast(scene: int, ray: int, arguments: int) -> None:
            if self.on:
                place = address + 4 * REALS * len(self._kinds)
                ctypes.memmove(place, ray, 4 * REALS)
                self._kinds.append(kind)
            real(scene, ray, arguments)

        function = FUNCTION(cast)
        llvmlite.binding.add_symbol(name, ctypes.cast(function, ctypes.c_void_p).value)
        return function

    def rays(self) -> np.ndarray:
        """Return (n, 8) float32: origin, direction, tfar, kind."""
        kinds = np.array(self._kinds, np.float32)
        rays = self._rays[: len(kinds)]
        return np.concatenate([rays[:, :3], rays[:, 4:7], rays[:, 8:9], kinds[:, None]], axis=1)


def main() -> None:
    """Record the rays of the first pass on the Cornell box, on one thread."""
    recorder = Recorder()
    with Workers(1) as workers:
        one = OnePass(workers)
        recorder.on = True
        one.camera_pass()
        recorder.on = False
    np.save(sys.argv[1], recorder.rays())


if __name__ == "__main__":
    main()
