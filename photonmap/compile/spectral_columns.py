"""How many columns a render carries: each distinct band once, and once for each light group."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import ERROR_ENDINGS, names_where
from photonmap.compile.scene_arrays import CompiledScene
from photonmap.errors import InputError
from photonmap.kernels.core import records
from photonmap.kernels.core.passes import Pixels
from photonmap.spectra.curves import Floats

Array = NDArray[np.float32]
T = TypeVar("T")


@dataclass(frozen=True)
class SpectralColumns:
    """Which column of the kernels' arrays a band is.

    `of_band`, (N,), is the distinct column that a band equals. Groups of lights are in the order of
    the file; there is one, named "", where they are not split.
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
    def weights(self) -> Floats:
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
        **{name: take(getattr(pixels, name)) for name in LIGHT},
        reflectance=columns.of_group(pixels.reflectance, 0),
    )


_RADIANCES = names_where(quantity="radiance")
LIGHT = tuple(name for name in Pixels._fields if name.removeprefix("irradiance_") in _RADIANCES)
"""The arrays of a pass that are split by light group."""


_TABLES: dict[type, tuple[str, ...]] = {
    records.Materials: ("reflectance",),
    records.Lights: ("spectra",),
    records.Environment: ("basis",),
    records.EmissionTextures: ("basis",),
    records.Specular: ("mirror", "tint", "dip", "grazing"),
    records.GlassMaps: ("basis",),
    records.Media: ("absorption",),
    records.Dispersion: ("ior", "steps", "wave"),
    records.Textures: ("basis",),
    records.Palettes: ("spectra",),
    records.Scattering: ("specular", "dip"),
    records.LobeMaps: ("basis",),
    records.Sheens: ("color", "basis"),
    records.Fluorescence: ("matrix", "taken"),
}
"""The arrays of each record whose last axis is bands"""


def _change_tables(record: T, change: Callable[[Array], Array]) -> T:
    """Return a record with its arrays over bands changed, and those of the records in it."""
    parts: Any = record
    names = _TABLES.get(type(record))
    if names is None:
        return record
    changed = {
        name: change(value) if name in names else _change_tables(value, change)
        for name, value in zip(parts._fields, parts, strict=True)
        if value is not None
    }
    return cast(T, parts._replace(**changed))


def choose_columns(compiled: CompiledScene, merge: bool, split: bool) -> SpectralColumns:
    """Find the distinct bands of a scene, and its light groups.

    `merge` carries bands once that are the same in every spectrum; `split`, every light group on
    its own.
    """
    tables: list[Array] = []

    def note(table: Array) -> Array:
        if table.size:
            tables.append(table.reshape(-1, table.shape[-1]))
        return table

    for part in (compiled.materials, compiled.lights, compiled.specular, compiled.scattering):
        _change_tables(part, note)
    _change_tables(compiled.textures, note)
    _change_tables(compiled.fluorescence, note)
    table = np.concatenate(tables)
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
    if columns.distinct == columns.count == len(columns.of_band):
        return compiled
    first = [int(np.flatnonzero(columns.of_band == k)[0]) for k in range(columns.distinct)]

    def tile(table: Array) -> Array:
        """Repeat the distinct bands for each light group, side by side as in any table."""
        if table.size == 0:
            return table
        return np.concatenate([np.take(table, first, axis=-1)] * len(columns.groups), axis=-1)

    return replace(
        compiled,
        materials=_change_tables(compiled.materials, tile),
        lights=_carry_lights(compiled, columns, first),
        specular=_change_tables(compiled.specular, tile),
        textures=_change_tables(compiled.textures, tile),
        scattering=_change_tables(compiled.scattering, tile),
        fluorescence=_carry_fluorescence(compiled.fluorescence, columns, tile),
    )


def _carry_fluorescence(
    fluorescence: records.Fluorescence | None,
    columns: SpectralColumns,
    tile: Callable[[Array], Array],
) -> records.Fluorescence | None:
    """Return fluorescence in columns: light arrives in all bands that one stands for."""
    if fluorescence is None:
        return None
    matrix = np.zeros((len(fluorescence.matrix), columns.distinct, columns.distinct))
    first = np.unique(columns.of_band, return_index=True)[1]
    for band, column in enumerate(columns.of_band):
        matrix[:, column] += fluorescence.matrix[:, band, first]
    matrix = matrix.astype(np.float32)
    return fluorescence._replace(matrix=matrix, taken=tile(fluorescence.taken))


def _carry_lights(
    compiled: CompiledScene, columns: SpectralColumns, first: list[int]
) -> records.Lights:
    """Return lights in the columns of their group; `first` has the band each column stands for."""
    lights, count = compiled.lights, len(columns.groups)

    def shine(table: Array, groups: list[str]) -> Array:
        blocks = np.zeros((len(table), count, columns.distinct), np.float32)
        for row, group in enumerate(groups):
            if count == 1 or group in columns.groups:
                index = columns.groups.index(group) if count > 1 else 0
                blocks[row, index] = table[row, first]
        return blocks.reshape(len(table), -1)

    group_of_row = [""] * len(lights.spectra)
    for emitter, row in enumerate(lights.spectrum):
        group_of_row[row] = compiled.light_groups[emitter]
    environment, textures = lights.environment, lights.emission_textures
    if environment is not None:
        sky = [group_of_row[environment.row]] * 3
        environment = environment._replace(basis=shine(environment.basis, sky))
    if textures is not None:
        owners = [group_of_row[row] for row in np.flatnonzero(textures.slot >= 0)]
        basis = shine(textures.basis, [owner for owner in owners for _ in range(3)])
        textures = textures._replace(basis=basis)
    spectra = shine(lights.spectra, group_of_row)
    return lights._replace(spectra=spectra, environment=environment, emission_textures=textures)
