"""Turn a map of the sky into what kernels draw directions from."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from photonmap.bands import Bands
from photonmap.errors import naming
from photonmap.kernels.records import Environment
from photonmap.lights import EnvironmentLight
from photonmap.readers.panorama import check_panorama, read_panorama


@dataclass(frozen=True)
class Sky:
    """A map, and its colours in bands."""

    texels: NDArray[np.float32]
    """(H, W, 3)"""
    basis: NDArray[np.float64]
    """(3, N), the light's scale included"""
    cosines: NDArray[np.float64]
    """(H + 1,)"""
    turn: float

    @property
    def mean(self) -> NDArray[np.float64]:
        """The mean radiance over all directions, (N,)."""
        rows = self.texels.mean(axis=1, dtype=np.float64)
        return -0.5 * np.diff(self.cosines) @ rows @ self.basis

    def record(self, power: float) -> Environment:
        """Return what kernels take; radiances are divided by `power`."""
        # Texels of one row cover the same solid angle.
        light = self.texels @ (self.basis.mean(axis=1) / self.basis.max())
        columns = np.cumsum(light, axis=1)
        rows = np.cumsum(columns[:, -1] * -np.diff(self.cosines))
        total = np.where(columns[:, -1:] > 0.0, columns[:, -1:], 1.0)
        basis = (self.basis / power).astype(np.float32)
        return Environment(
            self.texels, basis, rows / rows[-1], columns / total, self.cosines, self.turn
        )


def sky_of(light: EnvironmentLight, bands: Bands) -> Sky:
    """Read a checked light's map."""
    label = f"light {light.name or light.kind!r}"
    if isinstance(light.image, str | PathLike):
        with naming(label):
            texels = read_panorama(light.image)
    else:
        texels = check_panorama(light.image, label)
    cosines = np.cos(np.linspace(0.0, np.pi, len(texels) + 1))
    return Sky(texels, bands.emission_basis * light.scale, cosines, light.rotation / 360.0 % 1.0)
