"""The first pass on the Cornell box, in stages that can be run again and again."""

from __future__ import annotations

from typing import Any

import photonmap as pm
from photonmap.accumulate import Accumulator
from photonmap.bands import Bands
from photonmap.kernels.records import Film, Pixels
from photonmap.passes import Passes
from photonmap.prepare import prepare
from photonmap.workers import Workers

FILM = Film(256, 256, True)
BANDS = Bands.parse("rgb")


class OnePass:
    """The stages of `Passes`, each a call without arguments.

    Parameters
    ----------
    workers : that share the work
    """

    store: Any
    """cells and their radiosity"""
    pixels: Pixels

    def __init__(self, workers: Workers) -> None:
        self.prepared = prepare(pm.scenes.cornell_box(), BANDS)
        pixels = FILM.width * FILM.height
        self._passes = Passes(self.prepared, FILM, BANDS.count, pixels, 0, workers)
        self._moments = Accumulator(pixels, BANDS.count, workers)
        # Compile, and let the survey be done once and for all.
        for stage in (self.photons, self.camera_pass, self.sharing, self.averaging):
            stage()

    def photons(self) -> None:
        """Trace photons into the store."""
        self.store = self._passes._trace_photons(0, 0)

    def camera_pass(self) -> None:
        """Render all pixels."""
        self.pixels = self._passes._render(0, self.store, None)

    def sharing(self) -> None:
        """Share indirect light between neighbours."""
        self._passes._share(0, self.pixels, 0)

    def averaging(self) -> None:
        """Take the pass into the moments, and work out the error."""
        self._moments.add(self.pixels)
        self._moments.error()
