"""Light for scenes without any: a dome, and a soft key light that shows shapes."""

from __future__ import annotations

import numpy as np

from photonmap.compile.lights.environment import Sky
from photonmap.scene.camera import Camera, frame_of
from photonmap.spectra.bands import Bands

AMBIENT = 0.2
"""Radiance of the dome, W·m⁻²·sr⁻¹: what faces the camera is brighter, what turns away darker."""
_KEY = 1.1
"""What the key light adds, about as much as a dome of this radiance where it falls straight."""
_CONCENTRATION = 12.0
"""Of the key light, exp(κ (cos θ − 1)): it falls to a half at 20 degrees."""
_FROM = (-0.5, 0.65, -0.6)
"""Where the key light comes from, along the camera's right, up and view."""
_ROWS = 64


def default_sky(camera: Camera, bands: Bands) -> Sky:
    """Return the same radiance in every band, brightest above and to the left of the camera.

    Parameters
    ----------
    camera : a checked one
    """
    view, right, up = frame_of(camera)
    x, y, z = _FROM
    key = x * right + y * up + z * view
    key /= np.linalg.norm(key)
    polar = (np.arange(_ROWS) + 0.5) * (np.pi / _ROWS)
    azimuth = (np.arange(2 * _ROWS) + 0.5) * (np.pi / _ROWS) - np.pi  # of −z at the centre
    across = key[0] * np.sin(azimuth) - key[2] * np.cos(azimuth)
    cosine = np.sin(polar)[:, None] * across + key[1] * np.cos(polar)[:, None]
    peak = _KEY * _CONCENTRATION / 2.0
    radiance = AMBIENT + peak * np.exp(_CONCENTRATION * (cosine - 1.0))
    texels = np.repeat(radiance[..., None], 3, axis=2).astype(np.float32)
    return Sky(texels, np.full((3, bands.count), 1.0 / 3.0))
