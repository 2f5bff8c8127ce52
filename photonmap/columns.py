"""How many columns a render carries: each distinct band once, and once for each group of lights."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.records import Pixels
from photonmap.prepare import Prepared

Array = NDArray[np.float32]


@dataclass(frozen=True)
class Columns:
    """Which column of the kernels' arrays a band is.

    Parameters
    ----------
    of_band : (N,) int, the distinct column that a band equals
    groups : of lights, in the order of the file; one, named "", where they are not split
    """

    of_band: NDArray[np.intp]
    groups: tuple[str, ...] = ("",)

    @property
    def distinct(self) -> int:
        """Columns of one group."""
        return int(self.of_band.max()) + 1

    @property
    def count(self) -> int:
        """Columns carried: groups one after another, the distinct columns of each together."""
        return self.distinct * len(self.groups)

    @property
    def weights(self) -> NDArray[np.float64]:
        """How many bands each distinct column stands for."""
        return np.bincount(self.of_band).astype(np.float64)

    def of_group(self, image: Array, group: int) -> Array:
        """Return the distinct columns (P, U) of one group among all carried (P, C)."""
        start = group * self.distinct
        return np.ascontiguousarray(image[..., start : start + self.distinct])

    def whole(self, image: Array) -> Array:
        """Return the sum over groups, in their order: (P, U)."""
        if len(self.groups) == 1:
            return image
        total = self.of_group(image, 0)
        for group in range(1, len(self.groups)):
            total += image[..., group * self.distinct : (group + 1) * self.distinct]
        return total


def split_pixels(columns: Columns, pixels: Pixels, group: int | None = None) -> Pixels:
    """Return what a pass estimates for one group alone, or for all of them together (None)."""
    if len(columns.groups) == 1:
        return pixels

    def take(image: Array) -> Array:
        return columns.whole(image) if group is None else columns.of_group(image, group)

    return pixels._replace(
        **{name: take(getattr(pixels, name)) for name in _LIGHT},
        reflectance=columns.of_group(pixels.reflectance, 0),
    )


_LIGHT = ("emission", "direct", "indirect", "irradiance_direct", "irradiance_indirect")


def choose_columns(prepared: Prepared, merge: bool, split: bool) -> Columns:
    """Find the distinct bands of a scene, and its groups of lights.

    Parameters
    ----------
    merge : carry bands once that are the same in every spectrum
    split : carry every group of lights on its own
    """
    table = np.concatenate([table for table in _tables(prepared) if len(table)])
    of_band = np.arange(table.shape[1])
    if merge:
        first = np.unique(table, axis=1, return_index=True, return_inverse=True)
        order = np.argsort(np.argsort(first[1]))  # distinct columns in order of appearance
        of_band = order[first[2].ravel()]
    groups = tuple(dict.fromkeys(prepared.light_groups)) if split else ("",)
    return Columns(of_band, groups)


def count_distinct(prepared: Prepared) -> int:
    """Return how many bands of a scene differ."""
    return choose_columns(prepared, merge=True, split=False).distinct


def carry(prepared: Prepared, columns: Columns) -> Prepared:
    """Return the scene with columns in place of bands: lights shine in those of their group."""
    keep = [int(np.flatnonzero(columns.of_band == k)[0]) for k in range(columns.distinct)]
    if columns.count == len(columns.of_band):
        return prepared
    count = len(columns.groups)

    def tile(table: Array) -> Array:
        return np.ascontiguousarray(np.tile(table[:, keep], count))

    def shine(table: Array, groups: list[str]) -> Array:
        blocks = np.zeros((len(table), count, columns.distinct), np.float32)
        for row, group in enumerate(groups):
            if count == 1 or group in columns.groups:
                blocks[row, columns.groups.index(group) if count > 1 else 0] = table[row, keep]
        return blocks.reshape(len(table), -1)

    lights, optics, textures = prepared.lights, prepared.optics, prepared.textures
    group_of_row = [""] * len(lights.spectra)
    for emitter, row in enumerate(lights.spectrum):
        group_of_row[row] = prepared.light_groups[emitter]
    environment = lights.environment
    if environment is not None:
        sky = [prepared.light_groups[lights.dome]] * 3
        environment = environment._replace(basis=shine(environment.basis, sky))
    glow = lights.glow
    if glow is not None:
        lamps = [group_of_row[row] for row in np.flatnonzero(glow.slot >= 0)]
        glow = glow._replace(basis=shine(glow.basis, [lamp for lamp in lamps for _ in range(3)]))
    if textures is not None:
        textures = textures._replace(basis=tile(textures.basis))
    if optics is not None:
        optics = optics._replace(mirror=tile(optics.mirror), tint=tile(optics.tint))
    return replace(
        prepared,
        materials=prepared.materials._replace(reflectance=tile(prepared.materials.reflectance)),
        lights=lights._replace(
            spectra=shine(lights.spectra, group_of_row), environment=environment, glow=glow
        ),
        optics=optics,
        textures=textures,
    )


def _tables(prepared: Prepared) -> list[Array]:
    """Return all arrays whose last axis is bands."""
    tables = [prepared.materials.reflectance, prepared.lights.spectra]
    if prepared.lights.environment is not None:
        tables.append(prepared.lights.environment.basis)
    if prepared.optics is not None:
        tables += [prepared.optics.mirror, prepared.optics.tint]
    if prepared.textures is not None:
        tables.append(prepared.textures.basis)
    if prepared.lights.glow is not None:
        tables.append(prepared.lights.glow.basis)
    return tables
