"""Turn a sky into what kernels draw directions from: a map, a model, or that of unlit scenes."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.lights.sky_cdfs import fine_enough, sky_cdfs
from photonmap.errors import naming
from photonmap.kernels.core.records import Environment
from photonmap.scene.camera import Camera, frame_of
from photonmap.scene.daylight import OvercastLight, SkyLight
from photonmap.scene.lights import EnvironmentLight
from photonmap.scene.panorama import check_panorama, read_panorama
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import integrate_products
from photonmap.spectra.daylight import daylight_basis
from photonmap.spectra.observer import observer

AMBIENT = 0.2
"""Radiance of the dome of an unlit scene, W·m⁻²·sr⁻¹: what faces the camera is brighter, what turns
away darker."""
_KEY = 1.1
"""What the key light adds, about as much as a dome of this radiance where it falls straight."""
_CONCENTRATION = 12.0
"""Of the key light, exp(κ (cos θ − 1)): it falls to a half at 20 degrees."""
_FROM = (-0.5, 0.65, -0.6)
"""Where the key light comes from, along the camera's right, up and view."""
_ROWS = 64


@dataclass(frozen=True)
class Sky:
    """A map, and its colours in bands."""

    texels: NDArray[np.float32]
    """(H, W, 3), linear RGB, or how much of each spectrum of daylight"""
    basis: NDArray[np.float64]
    """(3, N), bands of each, the light's scale included"""
    rotation: float = 0.0
    """about +y, 1 for a full turn"""

    @property
    def mean(self) -> NDArray[np.float64]:
        """The mean radiance over all directions, (N,)."""
        rows = self.texels.mean(axis=1, dtype=np.float64)
        return -0.5 * np.diff(_row_cosines(self.texels)) @ rows @ self.basis

    def record(self, power: float, row: int) -> Environment:
        """Return what kernels take; radiances are divided by `power`, `row` has their mean."""
        texels = fine_enough(self.texels)
        basis = (self.basis / power).astype(np.float32, order="C")
        light, cosines = texels @ (self.basis.mean(axis=1) / self.basis.max()), _row_cosines(texels)
        cdfs = sky_cdfs(light, cosines, self.rotation)
        return Environment(texels, basis, *cdfs, cosines, self.rotation, row)


MappedLight = EnvironmentLight | SkyLight | OvercastLight
"""Lights that differ by direction all around."""


def compile_sky(light: MappedLight, bands: Bands) -> Sky:
    """Read a checked light's map, or compute that of a sky."""
    if isinstance(light, SkyLight):
        return _clear_sky(light, bands)
    if isinstance(light, OvercastLight):
        return _overcast(light, bands)
    label = f"light {light.name or light.kind!r}"
    if isinstance(light.image, str | PathLike):
        with naming(label):
            texels = read_panorama(light.image)
    else:
        texels = check_panorama(light.image, label)
    basis = bands.emission_basis * light.scale
    return Sky(texels, basis, light.rotation / 360.0 % 1.0)


def _clear_sky(light: SkyLight, bands: Bands) -> Sky:
    """Return a sky as sums of the three spectra of daylight; in RGB, colours within the gamut."""
    texels, (wavelengths, curves) = light.weights(), daylight_basis()
    if not bands.is_rgb:
        basis = bands.average_all(wavelengths, curves)
    else:
        eye = observer()
        rgb = integrate_products(eye.wavelengths, eye.matching, wavelengths, curves).T
        texels, basis = np.maximum(texels @ rgb, 0.0).astype(np.float32), np.eye(3)
    return Sky(texels, basis * light.scale)


def _overcast(light: OvercastLight, bands: Bands) -> Sky:
    """Return a sky whose map counts one colour, the zenith's."""
    amounts = light.amounts()
    texels = np.stack([amounts, *[np.zeros_like(amounts)] * 2], axis=-1)
    basis = np.zeros((3, bands.count))
    basis[0] = bands.emission(light.radiance)
    return Sky(texels, basis)


def default_sky(camera: Camera, bands: Bands) -> Sky:
    """Return the light of scenes without any: a dome, and a soft key light that shows shapes.

    Its radiance is the same in every band, brightest above and to the left of the camera.

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


def _row_cosines(texels: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the cosines of the zenith angles between the rows of a map, (H + 1,)."""
    return np.cos(np.linspace(0.0, np.pi, len(texels) + 1))
