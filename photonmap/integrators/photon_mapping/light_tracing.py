"""Light tracing: caustic photons of a pass, connected to the camera and sorted by pixel."""

from __future__ import annotations

import math

import numpy as np

from photonmap.integrators.base import PassSetup
from photonmap.kernels.camera.cameras import WITHOUT_FILM_POINTS, has_open_lens
from photonmap.kernels.caustics.light_tracing import add_connected, connect_photons
from photonmap.kernels.caustics.photon_map import sort_by_key
from photonmap.kernels.core.passes import CameraPass, Connections, Estimate, Span, View

BUNDLE = 4096
"""Photons that are connected at a time."""
LARGER_DISKS = 4.0
"""How many times the variance of disks photons may have where they are connected: disks so much
larger than a pixel have a bias that weighs more."""


def can_connect(view: View) -> bool:
    """Return whether each point in view has one film point, and pixels have an area."""
    camera = view.camera
    is_sharp = not has_open_lens(camera.optics)
    return view.film.jitter and is_sharp and camera.kind not in WITHOUT_FILM_POINTS


def densest_connected(radius: float) -> float:
    """Return how many pixels see a unit of area, at most, where photons are connected.

    There, of pixels with one camera sample. A parabolic disk has the variance of 3/4 of its area.
    """
    return LARGER_DISKS / (0.75 * math.pi * radius * radius)


def connect(setup: PassSetup, job: CameraPass, estimate: Estimate) -> int:
    """Add the photons that the camera sees to the estimate of a pass; return the rays cast."""
    caustics = job.maps.caustics
    assert caustics is not None
    photons = len(caustics.positions)
    pixels, order = np.empty((2, photons), np.int32)
    weights = np.empty(photons, np.float32)
    bundles = max(-(-photons // BUNDLE), 1)

    def look_back(bundle: int) -> int:
        span = Span(bundle * photons // bundles, (bundle + 1) * photons // bundles)
        rays: int = connect_photons(job, caustics, span, pixels, weights)
        return rays

    rays = sum(setup.workers.map(look_back, bundles))
    starts = np.zeros(setup.pixels + 2, np.int32)
    sort_by_key(pixels, starts, order)
    connections = Connections(starts, order, weights)
    setup.render_pixels(
        lambda span, own: add_connected(job, caustics, connections, span, own, estimate)
    )
    return rays
