"""Sheen, as kernels take it: how much of it is kept, what it reflects, and what it lets pass."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from photonmap.compile.materials import reflectance_of
from photonmap.compile.surfaces.glossy import NODES, node_cosines
from photonmap.compile.surfaces.white_bases import WHITE_BASES, through
from photonmap.compile.table_cache import kept_on_disk
from photonmap.compile.textures import TextureTable
from photonmap.kernels.bsdf.models import SHEEN
from photonmap.kernels.bsdf.sheen import tabulate
from photonmap.kernels.core import records
from photonmap.scene.material import Material
from photonmap.scene.textures import Texture
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Floats

LEAST_SHEEN_ALPHA = 0.01
"""Smallest α of a sheen: a smoother one shines only where a surface is seen edge-on."""
COLORS = 17  # Values of the colour of a sheen for which T is tabulated, evenly from 0 to 1
ANGLES, AZIMUTHS = 192, 128
"""Of the quadrature: Gauss–Legendre in the square root of the cosine, and midpoints."""
BOUNDS = 200  # Rounds in which the lobe is held to what arrives


class Lobe(NamedTuple):
    """What a sheen of a colour of 1 does at each of NODES angles."""

    kept: Floats  # (NODES,), K
    albedo: Floats  # (NODES + 1,), E, and its cosine-weighted mean


def with_sheens(
    scattering: records.Scattering | None,
    materials: Sequence[Material],
    table: TextureTable,
    bands: Bands,
) -> records.Scattering | None:
    """Return BSDFs of M materials below sheen, where any has one.

    A colour of a sheen outside [0, 1] is an `InputError`.
    """
    chosen = [index for index, material in enumerate(materials) if material.has_sheen]
    if scattering is None or not chosen:
        return scattering
    count, kept, albedo, passing = len(materials), [], [], []
    color, alpha = np.zeros((count, bands.count), np.float32), np.ones(count)
    row, model = np.zeros(count, np.int32), scattering.model.copy()
    for place, index in enumerate(chosen):
        material = materials[index]
        color[index] = reflectance_of(material, "sheen", material.sheen, bands)
        alpha[index] = max(material.sheen_roughness**2, LEAST_SHEEN_ALPHA)
        row[index], model[index] = place, SHEEN
        lobe = sheen_lobe(float(alpha[index]))
        kept.append(np.append(lobe.kept, 0.0))
        albedo.append(lobe.albedo)
        passing.append(through_sheen(float(alpha[index]), *_base_of(material, scattering, index)))
    tables = np.array(kept), np.array(albedo), np.array(passing)
    maps = table.maps if (table.rows["sheen"][chosen] >= 0).any() else None
    basis = bands.reflectance_basis.astype(np.float32, order="C")
    basis = basis if maps is not None else basis[:0]
    mean = color.mean(axis=1, dtype=float)
    sheens = records.Sheens(color, mean, alpha, row, *tables, maps, table.rows["sheen"], basis)
    return scattering._replace(model=model, sheens=sheens)


def _base_of(
    material: Material, scattering: records.Scattering, index: int
) -> tuple[str, tuple[float, ...]]:
    """Return the model below the sheen of a material, and what `WHITE_BASES` has of it."""
    name, numbers = material.scattering or ("Lambertian", ())
    if name != "glossy":
        return name, numbers
    f0, base, refraction = scattering.parameters[index, 1:4].tolist()
    is_metal = base == 0.0 and not isinstance(material.reflectance, Texture)
    return name, (*numbers, *((1.0, 0.0) if is_metal else (f0, refraction)))


def sheen_lobe(alpha: float) -> Lobe:
    """Return how much of a lobe is kept at each angle, and what it then reflects."""
    kept, albedo = _lobe_rows(alpha)
    return Lobe(kept[:-1], albedo)


@kept_on_disk
def _lobe_rows(alpha: float) -> Floats:
    """Return K and E of a lobe, (2, NODES + 1); the last K is unused.

    K starts as 1, and is lowered where more is reflected than arrives, until that is so nowhere.
    """
    roots, weights = np.polynomial.legendre.leggauss(ANGLES)
    roots, weights = 0.5 * (roots + 1.0), 0.5 * weights
    azimuths = np.pi * (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS
    table = np.empty((NODES, ANGLES))
    tabulate(alpha, node_cosines(), roots**2, azimuths, table)
    table *= 4.0 * np.pi * weights * roots**3  # 2π μ dμ, for μ = t²
    places = np.linspace(0.0, 1.0, NODES)
    kept = np.ones(NODES)
    for _ in range(BOUNDS):
        albedo = kept * (table @ np.interp(roots, places, kept))
        kept /= np.sqrt(np.maximum(albedo, 1.0))
    albedo = np.minimum(kept * (table @ np.interp(roots, places, kept)), 1.0)
    mean = float(np.interp(roots, places, albedo) @ (4.0 * weights * roots**3))
    return np.array([np.append(kept, 0.0), np.append(albedo, mean)])


@cache
def through_sheen(alpha: float, base: str, numbers: tuple[float, ...]) -> Floats:
    """Return T(θ) of sheens over a white base, (COLORS, NODES + 1), see `white_bases.through`.

    The base is a model, and the numbers that `WHITE_BASES` has of it.
    """
    below, albedo = WHITE_BASES[base](*numbers), sheen_lobe(alpha).albedo[:-1]
    colors = np.linspace(0.0, 1.0, COLORS).tolist()
    return np.array([through(np.maximum(1.0 - s * albedo, 1e-9), below) for s in colors])
