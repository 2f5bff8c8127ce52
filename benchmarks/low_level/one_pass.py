"""The first pass on the Cornell box, in stages that can be repeated."""

from __future__ import annotations

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.film.moments import Accumulator
from photonmap.integrators.base import PassSetup
from photonmap.integrators.photon_mapping.integrator import PhotonIntegrator
from photonmap.kernels.core.passes import Estimate, Film, PhotonMaps
from photonmap.runtime.workers import Workers
from photonmap.spectra.bands import Bands

FILM = Film(256, 256, True)
BANDS = Bands.parse("rgb")


class OnePass:
    """The stages of `PhotonIntegrator`, each a call without arguments.

    Parameters
    ----------
    workers : that share the work
    """

    maps: PhotonMaps
    estimate: Estimate

    def __init__(self, workers: Workers) -> None:
        self.compiled = compile_scene(pm.scenes.cornell_box(), BANDS)
        pixels = FILM.width * FILM.height
        setup = PassSetup(self.compiled, FILM, BANDS.count, pixels, 0, workers)
        self._integrator = PhotonIntegrator(setup)
        self._moments = Accumulator(pixels, BANDS.count, workers)
        # Compile, and run the sampling pre-pass once.
        for stage in (self.photons, self.camera_pass, self.sharing, self.averaging):
            stage()

    def photons(self) -> None:
        """Trace photons into the radiosity cache."""
        self.maps = self._integrator.trace_photons(0)

    def camera_pass(self) -> None:
        """Render all pixels."""
        self.estimate = self._integrator.run_camera_pass(0, self.maps)

    def rays_by_kind(self) -> dict[str, int]:
        """Return how many rays photons and pixels of a pass cast."""
        before = dict(self._integrator.counters.rays_by_kind)
        self.photons()
        self.camera_pass()
        after = self._integrator.counters.rays_by_kind
        return {kind: count - before.get(kind, 0) for kind, count in after.items()}

    def sharing(self) -> None:
        """Share irradiance between neighbours."""
        self._integrator.share(0, self.estimate)

    def averaging(self) -> None:
        """Add the pass to the moments, and compute the error."""
        self._moments.add(self.estimate.pixels)
        self._moments.error()
