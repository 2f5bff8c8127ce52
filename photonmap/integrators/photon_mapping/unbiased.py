"""Photon mapping whose mean is exact: look-ups corrected by paths, sharing by differences."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from photonmap.integrators.base import PassSetup
from photonmap.integrators.photon_mapping.integrator import PhotonIntegrator
from photonmap.kernels.core.passes import Estimate, PhotonMaps, Pixels
from photonmap.kernels.film.linked_pixels import (
    average_linked,
    fill_centre_reflectance,
    replace_linked,
)

FOLLOWED = 0.6
"""Probability with which paths go on past a look-up. Time · variance hardly depends on it: at 1,
which is path tracing, it is 5 to 20% larger (Cornell box, under a sky, `living_room`)."""
ROUNDS = 16
"""How often pixels are averaged with their neighbours in a pass: 6 or 32 rounds have more noise."""


class UnbiasedIntegrator(PhotonIntegrator):
    """Estimates pixels without bias, by photon mapping and paths; see `Integrator`."""

    has_supports = False

    def __init__(self, setup: PassSetup) -> None:
        super().__init__(replace(setup, unbiased=True))

    def run_camera_pass(self, index: int, photon_maps: PhotonMaps) -> Estimate:
        """Run the camera pass; what it looks up in the cache is corrected by paths."""
        return super().run_camera_pass(
            index, photon_maps._replace(cache=photon_maps.cache._replace(followed=FOLLOWED))
        )

    def share(self, index: int, estimate: Estimate, wider: int = 0) -> Estimate:
        """Share indirect irradiance between pixels, by their differences if these are known."""
        if estimate.differences is not None:
            shared = self._sharing.share(self.plan.links, estimate.pixels, estimate.differences)
            self.share_fluorescence(estimate.differences[0], shared, estimate)
        return estimate

    @cached_property
    def _sharing(self) -> SharingByDifferences:
        with self._setting_up():
            return SharingByDifferences(self._setup)


class SharingByDifferences:
    """Shares indirect irradiance between pixels, without bias."""

    def __init__(self, setup: PassSetup) -> None:
        self._setup = setup
        shape = setup.pixels, setup.bands
        self._rounds = setup.storage.zeros((2, *shape))
        self._reflectance = setup.storage.zeros(shape)
        scene, view = setup.compiled.arrays, setup.view
        setup.over_pixels(
            lambda span: fill_centre_reflectance(scene, view, span, self._reflectance)
        )

    def share(
        self, links: NDArray[np.uint8] | None, pixels: Pixels, differences: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """Replace indirect light by what pixels and their neighbours, with `links`, say of it.

        Returns the indirect irradiance in place of `differences[0]`, (P, N).
        """
        setup, own = self._setup, differences[0]
        source = own
        for number in range(ROUNDS):
            source = self._average(links, differences, source, self._rounds[number % 2])
        setup.over_pixels(lambda span: replace_linked(span, self._reflectance, own, source, pixels))
        return source

    def _average(
        self,
        links: NDArray[np.uint8] | None,
        differences: NDArray[np.float32],
        source: NDArray[np.float32],
        target: NDArray[np.float32],
    ) -> NDArray[np.float32]:
        """Fill and return target with one round of averages."""
        film = self._setup.film
        self._setup.over_pixels(
            lambda span: average_linked(film, links, span, differences, source, target)
        )
        return target
