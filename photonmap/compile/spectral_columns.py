"""How many columns a render carries: each distinct band once, and once for each light group."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import ERROR_ENDINGS, names_where
from photonmap.compile.scene_arrays import CompiledScene
from photonmap.errors import InputError
from photonmap.kernels.core.passes import Pixels
from photonmap.kernels.core.records import Lights, Media, Scattering

Array = NDArray[np.float32]


@dataclass(frozen=True)
class SpectralColumns:
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


def split_pixels(columns: SpectralColumns, pixels: Pixels, group: int | None = None) -> Pixels:
    """Return what a pass estimates for one group alone, or for all of them together (None)."""
    if len(columns.groups) == 1:
        return pixels

    def take(image: Array) -> Array:
        return columns.whole(image) if group is None else columns.of_group(image, group)

    return pixels._replace(
        **{name: take(getattr(pixels, name)) for name in _LIGHT},
        reflectance=columns.of_group(pixels.reflectance, 0),
    )


_RADIANCES = names_where(quantity="radiance")
_LIGHT = tuple(name for name in Pixels._fields if name.removeprefix("irradiance_") in _RADIANCES)
"""The arrays of a pass that are split by light group."""


def choose_columns(compiled: CompiledScene, merge: bool, split: bool) -> SpectralColumns:
    """Find the distinct bands of a scene, and its light groups.

    Parameters
    ----------
    merge : carry bands once that are the same in every spectrum
    split : carry every light group on its own
    """
    tables = [table for table in _tables(compiled) if table.size]
    table = np.concatenate([table.reshape(-1, table.shape[-1]) for table in tables])
    of_band = np.arange(table.shape[1])
    if merge:
        first = np.unique(table, axis=1, return_index=True, return_inverse=True)
        order = np.argsort(np.argsort(first[1]))  # distinct columns in order of appearance
        of_band = order[first[2].ravel()]
    groups = tuple(dict.fromkeys(compiled.light_groups)) if split else ("",)
    if bad := [group for group in groups if group.endswith(ERROR_ENDINGS)]:
        raise InputError(f"light group {bad[0]!r} ends as standard errors do; rename its lights")
    return SpectralColumns(of_band, groups)


def count_distinct(compiled: CompiledScene) -> int:
    """Return how many bands of a scene differ."""
    return choose_columns(compiled, merge=True, split=False).distinct


def carry(compiled: CompiledScene, columns: SpectralColumns) -> CompiledScene:
    """Return the scene with columns in place of bands: lights shine in those of their group."""
    if columns.count == len(columns.of_band):
        return compiled
    carrier = _Carrier(columns)
    tile = carrier.tile
    specular, textures = compiled.specular, compiled.textures
    if textures is not None:
        palettes = textures.palettes
        if palettes is not None:
            palettes = palettes._replace(spectra=tile(palettes.spectra))
        textures = textures._replace(basis=tile(textures.basis), palettes=palettes)
    if specular is not None:
        specular = specular._replace(
            mirror=tile(specular.mirror),
            tint=tile(specular.tint),
            dip=tile(specular.dip),
            grazing=tile(specular.grazing),
        )
        if specular.maps is not None:
            glass = specular.maps._replace(basis=tile(specular.maps.basis))
            specular = specular._replace(maps=glass)
        if specular.media is not None:
            specular = specular._replace(media=carrier.carry_media(specular.media))
    return replace(
        compiled,
        materials=compiled.materials._replace(reflectance=tile(compiled.materials.reflectance)),
        lights=carrier.carry_lights(compiled),
        specular=specular,
        textures=textures,
        scattering=compiled.scattering and carrier.carry_scattering(compiled.scattering),
    )


class _Carrier:
    """Turns tables over bands into tables over columns."""

    def __init__(self, columns: SpectralColumns) -> None:
        self._columns = columns
        self._first = [
            int(np.flatnonzero(columns.of_band == k)[0]) for k in range(columns.distinct)
        ]

    def tile(self, table: Array) -> Array:
        """Repeat the distinct bands of a table, its last axis, for each light group.

        The bands of a row lie side by side, as in any table: kernels are compiled for one order.
        """
        if table.size == 0:
            return table
        chosen = np.take(table, self._first, axis=-1)
        return np.concatenate([chosen] * len(self._columns.groups), axis=-1)

    def shine(self, table: Array, groups: list[str]) -> Array:
        """Put each row of a table into the columns of its group alone."""
        columns = self._columns
        count = len(columns.groups)
        blocks = np.zeros((len(table), count, columns.distinct), np.float32)
        for row, group in enumerate(groups):
            if count == 1 or group in columns.groups:
                index = columns.groups.index(group) if count > 1 else 0
                blocks[row, index] = table[row, self._first]
        return blocks.reshape(len(table), -1)

    def carry_scattering(self, scattering: Scattering) -> Scattering:
        """Return the BSDFs of a scene."""
        tile, lobes, sheens = self.tile, scattering.maps, scattering.sheens
        if sheens is not None:
            sheens = sheens._replace(color=tile(sheens.color), basis=tile(sheens.basis))
        return scattering._replace(
            specular=tile(scattering.specular),
            dip=tile(scattering.dip),
            maps=None if lobes is None else lobes._replace(basis=tile(lobes.basis)),
            sheens=sheens,
        )

    def carry_media(self, media: Media) -> Media:
        """Return the media of a scene."""
        dispersion = media.dispersion
        if dispersion is not None:
            dispersion = dispersion._replace(
                ior=self.tile(dispersion.ior),
                steps=self.tile(dispersion.steps),
                wave=self.tile(dispersion.wave),
            )
        return media._replace(absorption=self.tile(media.absorption), dispersion=dispersion)

    def carry_lights(self, compiled: CompiledScene) -> Lights:
        """Return the lights of a scene, each in the columns of its group."""
        lights = compiled.lights
        group_of_row = [""] * len(lights.spectra)
        for emitter, row in enumerate(lights.spectrum):
            group_of_row[row] = compiled.light_groups[emitter]
        environment, textures = lights.environment, lights.emission_textures
        if environment is not None:
            sky = [group_of_row[environment.row]] * 3
            environment = environment._replace(basis=self.shine(environment.basis, sky))
        if textures is not None:
            owners = [group_of_row[row] for row in np.flatnonzero(textures.slot >= 0)]
            basis = self.shine(textures.basis, [owner for owner in owners for _ in range(3)])
            textures = textures._replace(basis=basis)
        return lights._replace(
            spectra=self.shine(lights.spectra, group_of_row),
            environment=environment,
            emission_textures=textures,
        )


def _tables(compiled: CompiledScene) -> list[Array]:
    """Return all arrays whose last axis is bands."""
    tables = [compiled.materials.reflectance, compiled.lights.spectra]
    if compiled.lights.environment is not None:
        tables.append(compiled.lights.environment.basis)
    if compiled.specular is not None:
        tables += [compiled.specular.mirror, compiled.specular.tint]
        tables += [compiled.specular.dip, compiled.specular.grazing]
        if compiled.specular.maps is not None:
            tables.append(compiled.specular.maps.basis)
        media = compiled.specular.media
        if media is not None:
            tables.append(media.absorption)
        if media is not None and media.dispersion is not None:
            tables.append(media.dispersion.steps)
    if compiled.scattering is not None:
        tables += [compiled.scattering.specular, compiled.scattering.dip]
        if compiled.scattering.maps is not None:
            tables.append(compiled.scattering.maps.basis)
        if (sheens := compiled.scattering.sheens) is not None:
            tables.append(sheens.color)
            if sheens.maps is not None:
                tables.append(sheens.basis)
    if compiled.textures is not None:
        tables.append(compiled.textures.basis)
        if compiled.textures.palettes is not None:
            tables.append(compiled.textures.palettes.spectra)
    if compiled.lights.emission_textures is not None:
        tables.append(compiled.lights.emission_textures.basis)
    return tables
