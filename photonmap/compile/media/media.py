"""Glass that absorbs, disperses, or touches or holds other glass, as kernels take it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.frame import Frame
from photonmap.compile.media.bodies import (
    Body,
    cut_meshes,
    find_bodies,
    find_sides,
    is_solid,
    ranks_of,
)
from photonmap.errors import InputError, naming
from photonmap.kernels.core import records
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.surfaces.dispersion import LINES, abbe_index
from photonmap.scene.surfaces.layers import check_relative_indices
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Floats, Spectrum
from photonmap.spectra.observer import observer

Owner = NDArray[np.int64]
LEAST_TRANSMITTANCE = 1e-30  # What is darker counts as this, which no image can tell from black
STEPS = 64  # Wavelengths of each band, of which every pass takes one
LIKE = 0.01  # By how much an index may differ from that of its dispersion


@dataclass(frozen=True)
class MediaPlan:
    """Bodies of glass in a scene, before its meshes are joined.

    The meshes are cut where bodies cross them. Of the bodies, those that claim space come first.
    `absorption`, (M, N) of the M materials, is in the inverse of scene units.
    """

    meshes: list[Mesh]
    materials: list[Material]
    bodies: list[Body]
    absorption: Floats
    bands: Bands

    @property
    def ranks(self) -> NDArray[np.int32]:
        """By which meshes claim space, 0 first."""
        return ranks_of(len(self.meshes), self.bodies)

    @property
    def rows(self) -> NDArray[np.int32]:
        """The row of each mesh's material."""
        row_of = {id(material): row for row, material in enumerate(self.materials)}
        return np.array([row_of[id(mesh.material)] for mesh in self.meshes], np.int32)

    @property
    def is_called_for(self) -> bool:
        """Whether glass absorbs, or lies beside other media than air."""
        own = any(each.outside != 1.0 or disperses(each) for each in self.materials)
        return bool(self.bodies) or own or bool(self.absorption.any())

    def place(
        self, geometry: records.Geometry, owner: Owner, frame: Frame
    ) -> tuple[records.Geometry, Owner, records.Media | None]:
        """Return the triangles at which light changes, their meshes, and the media beside them.

        None in place of media where all glass is clear and lies in air.
        """
        if not self.is_called_for:
            return geometry, owner, None
        sides = find_sides(self.meshes, self.bodies, geometry, owner)
        kept = sides.kept
        geometry = geometry._replace(
            triangles=geometry.triangles[kept], normals=geometry.normals[kept]
        )
        of_side, owner = sides.mesh[kept], owner[kept]
        rows = self.rows
        media = self._media(np.append(rows, np.int32(-1))[of_side], rows[owner], frame)
        glass = np.array([is_solid(mesh.material) for mesh in self.meshes])[owner]
        in_air = (
            not len(media.absorption) and media.dispersion is None and (of_side[glass, 0] < 0).all()
        )
        in_air = in_air and (of_side[glass, 1] == owner[glass]).all() and kept.all()
        in_air = in_air and len(media.ior) == len(self.materials)
        return geometry, owner, None if in_air else media

    def _media(
        self, of_side: NDArray[np.int32], material: NDArray[np.int32], frame: Frame
    ) -> records.Media:
        """Return the media; what has an index by its surface's own account follows the materials.

        That is what is around glass, or glass whose index is below 1: relative to what is around.
        """
        indices = [material.ior or 1.0 for material in self.materials]
        for row, each in enumerate(self.materials):
            own, count = material == row, len(indices)
            if is_solid(each) and each.outside != 1.0:
                of_side[own & (of_side[:, 0] < 0), 0] = count
                indices.append(each.outside)
            elif is_solid(each) and indices[row] < 1.0:
                for around in np.unique(of_side[own & (of_side[:, 0] >= 0), 0]).tolist():
                    of_side[own & (of_side[:, 0] == around), 1] = len(indices)
                    indices.append(indices[row] * indices[around])
        absorption = np.zeros((len(indices), self.absorption.shape[1]), np.float32)
        absorption[: len(self.materials)] = self.absorption * frame.size
        absorption = absorption if absorption.any() else absorption[:0]
        dispersion = _disperse(self.materials, indices, self.bands)
        return records.Media(of_side, np.array(indices), absorption, dispersion)


def plan_media(
    meshes: Sequence[Mesh], materials: Sequence[Material], bands: Bands, frame: Frame
) -> MediaPlan:
    """Find the bodies of glass, and cut meshes where they cross them.

    An `InputError` says that what absorbs is no solid glass, or has no distance, or that an index
    below 1 is relative to nothing.
    """
    check_relative_indices(meshes)
    table = np.stack([_absorption(material, bands) for material in materials])
    absorbing = {id(each) for each, row in zip(materials, table, strict=True) if row.any()}
    bodies = find_bodies(meshes, absorbing, frame)
    cut = cut_meshes(meshes, bodies, absorbing, frame)
    return MediaPlan(cut, list(materials), bodies, table, bands)


def _absorption(material: Material, bands: Bands) -> Floats:
    """Return the absorption coefficient of each band, (N,), in the inverse of scene units."""
    color, distance = material.attenuation_color, material.attenuation_distance
    if not isinstance(color, Spectrum) and np.all(np.equal(color, 1.0)):
        return np.zeros(bands.count)
    with naming(f"material {material.name!r}: attenuation_color"):
        transmitted = bands.reflectance(color)
        if not ((transmitted >= 0.0) & (transmitted <= 1.001)).all():
            raise InputError("lies outside of [0, 1]; correct it")
        if material.ior is None or material.thin:
            raise InputError("only solid glass absorbs; give it an ior, and no thin")
        if distance is None:
            raise InputError("needs an attenuation_distance, after which this colour is left")
    return -np.log(np.clip(transmitted, LEAST_TRANSMITTANCE, 1.0)) / distance


def _disperse(
    materials: Sequence[Material], indices: Sequence[float], bands: Bands
) -> records.Dispersion | None:
    """Return indices of refraction, (K, R, N): of R media, at K wavelengths of each band.

    The wavelengths divide each band's sensitivity into K parts of the same integral; those in the
    middle stand for the bands. The first media are the insides of materials; None where nothing
    disperses. Two kinds of dispersion in one material, or an index that does not fit, are an
    `InputError`.
    """
    dispersing = [row for row, each in enumerate(materials) if disperses(each)]
    if not dispersing:
        return None
    wavelengths = _wavelengths(bands)
    steps = np.tile(np.array(indices)[:, None], (STEPS, 1, bands.count))
    for row in dispersing:
        steps[:, row] = _index(materials[row], wavelengths)
    flat = steps.reshape(-1, bands.count)
    wave = np.unique(flat, axis=1, return_inverse=True)[1].ravel().astype(np.int32)
    spread = np.ptp(steps, axis=2).max(axis=0)
    middle = steps[len(steps) // 2].copy()
    return records.Dispersion(middle, steps, wave, (spread > 0.0).astype(np.uint8))


def disperses(material: Material) -> bool:
    """Return whether the index of solid glass depends on wavelength."""
    has = material.dispersion is not None or material.abbe is not None
    return has and material.ior is not None and not material.thin


def _index(material: Material, wavelengths: Floats) -> Floats:
    """Return the index of a material at wavelengths."""
    curve, index, abbe = material.dispersion, material.ior, material.abbe
    assert index is not None
    with naming(f"material {material.name!r}"):
        if curve is None:
            assert abbe is not None
            return abbe_index(wavelengths, index, abbe)
        if abbe is not None:
            raise InputError("has an abbe number and a dispersion; remove one of them")
        wanted = float(curve.index(LINES[0]))
        if abs(wanted - index) > LIKE:
            raise InputError(
                f"ior {index:g} is not that of its dispersion, {wanted:.5g} at {LINES[0]:.1f} nm; "
                "leave it out"
            )
        return curve.index(wavelengths)


def _wavelengths(bands: Bands) -> Floats:
    """Return wavelengths that divide the sensitivity of each band evenly, (K, N)."""
    curves = bands.sensitivities or [
        Spectrum(observer().wavelengths, np.maximum(row, 0.0)) for row in observer().matching
    ]
    parts = (np.arange(STEPS) + 0.5) / STEPS
    columns = []
    for curve in curves:
        grid = np.linspace(curve.wavelengths[0], curve.wavelengths[-1], 4096)
        density = np.maximum(np.interp(grid, curve.wavelengths, curve.values), 0.0)
        rising = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
        columns.append(np.interp(parts * rising[-1], rising, grid))
    return np.stack(columns, axis=1)
