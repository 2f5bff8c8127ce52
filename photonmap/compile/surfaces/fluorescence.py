"""Fluorescent materials as kernels take them: a matrix over bands each, and concentrations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from photonmap.compile.textures import TextureTable
from photonmap.kernels.core import records
from photonmap.scene.material import Material
from photonmap.scene.textures import mean_number
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Floats
from photonmap.spectra.fluorescence import reradiation


def compile_fluorescence(
    materials: Sequence[Material], opaque: Floats, bands: Bands
) -> records.Fluorescence | None:
    """Return what M materials re-emit, None where none does; textured concentrations follow.

    `opaque` (M,) is the part of each that is no glass, by which reflectances are multiplied too.
    """
    rows, matrices = np.full(len(materials), -1, np.int32), list[Floats]()
    concentration = np.ones(len(materials))
    for index, material in enumerate(materials):
        if material.fluorescence is None:
            continue
        rows[index] = len(matrices)
        matrices.append(opaque[index] * reradiation(material.fluorescence, bands).T)
        concentration[index] = mean_number(material.fluorescence_concentration)
    if not matrices:
        return None
    matrix = np.array(matrices, np.float32, order="C")
    taken = matrix.sum(axis=-1, dtype=np.float64).astype(np.float32)
    none = np.full(len(materials), -1, np.int32)
    return records.Fluorescence(rows, matrix, taken, concentration, none, None)


def with_concentrations(
    fluorescence: records.Fluorescence | None, table: TextureTable
) -> records.Fluorescence | None:
    """Return fluorescence with the textures of its concentrations, where there are any."""
    image = table.rows["fluorescence_concentration"]
    if fluorescence is None or (image[fluorescence.row >= 0] < 0).all():
        return fluorescence
    return fluorescence._replace(image=image, maps=table.maps)
