"""Sheen, as kernels take it: how much of it is kept, what it reflects, and what it lets pass."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from photonmap.compile.materials import reflectance_of
from photonmap.compile.surfaces.coats import ROUNDS, evenly, white_base
from photonmap.compile.surfaces.glossy import NODES, SMALLEST_COSINE
from photonmap.compile.table_cache import Floats, kept_on_disk
from photonmap.compile.textures import TextureTable
from photonmap.kernels.bsdf.models import SHEEN
from photonmap.kernels.bsdf.rough_diffuse import DARKENING
from photonmap.kernels.bsdf.sheen import tabulate
from photonmap.kernels.core import records
from photonmap.kernels.core.lobe_records import Sheens
from photonmap.scene.material import LEAST_ALPHA, Material
from photonmap.scene.textures import Texture, mean_number
from photonmap.spectra.bands import Bands

LEAST_SHEEN_ALPHA = 0.01
"""Smallest α of a sheen: a smoother one shines only where a surface is seen edge-on."""
COLORS = 17
"""Values of the colour of a sheen for which T is tabulated, evenly from 0 to 1."""
ANGLES, AZIMUTHS = 192, 128
"""Of the quadrature: Gauss–Legendre in the square root of the cosine, and midpoints."""
BOUNDS = 200
"""Rounds in which the lobe is held to what arrives."""


class Base(NamedTuple):
    """A white surface that sends light where another one does."""

    alpha: float
    """of its glossy lobe"""
    f0: float | None
    """reflectance of that at normal incidence; None where it has none"""
    refraction: float
    """index of that, 0 for Schlick's formula"""
    diffuse_roughness: float
    """as of materials"""


class Lobe(NamedTuple):
    """What a sheen of a colour of 1 does at each of NODES angles."""

    kept: Floats
    """(NODES,), K"""
    albedo: Floats
    """(NODES + 1,), E, and its cosine-weighted mean"""


def with_sheens(
    scattering: records.Scattering | None,
    materials: Sequence[Material],
    table: TextureTable,
    bands: Bands,
) -> records.Scattering | None:
    """Return BSDFs below sheen, where any material has one.

    Parameters
    ----------
    scattering : of M materials
    materials : (M,)
    table : of their textures
    bands : of the render

    Raises
    ------
    InputError : the colour of a sheen is outside [0, 1]
    """
    chosen = [index for index, material in enumerate(materials) if material.has_sheen]
    if scattering is None or not chosen:
        return scattering
    count, kept, albedo, through = len(materials), [], [], []
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
        through.append(through_sheen(float(alpha[index]), _base_of(material, scattering, index)))
    tables = np.array(kept), np.array(albedo), np.array(through)
    maps = table.maps if (table.sheen[chosen] >= 0).any() else None
    basis = bands.reflectance_basis.astype(np.float32, order="C")
    mean = color.mean(axis=1, dtype=float)
    sheens = Sheens(color, mean, alpha, row, *tables, maps, table.sheen, basis)
    return scattering._replace(model=model, sheens=sheens)


def _base_of(material: Material, scattering: records.Scattering, index: int) -> Base:
    """Return the white base that sends light where a material does below its sheen."""
    if not material.is_glossy:
        return Base(1.0, None, 0.0, material.diffuse_roughness)
    f0, base, refraction = scattering.parameters[index, 1:4].tolist()
    alpha = max(mean_number(material.roughness) ** 2, LEAST_ALPHA)
    is_metal = base == 0.0 and not isinstance(material.reflectance, Texture)
    return Base(alpha, 1.0 if is_metal else f0, 0.0 if is_metal else refraction, 0.0)


def _cosines() -> Floats:
    return np.asarray(np.maximum(np.linspace(0.0, 1.0, NODES) ** 2, SMALLEST_COSINE))


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
    tabulate(alpha, _cosines(), roots**2, azimuths, table)
    table *= 4.0 * np.pi * weights * roots**3  # 2π μ dμ, for μ = t²
    places = np.linspace(0.0, 1.0, NODES)
    kept = np.ones(NODES)
    for _ in range(BOUNDS):
        albedo = kept * (table @ np.interp(roots, places, kept))
        kept /= np.sqrt(np.maximum(albedo, 1.0))
    albedo = np.minimum(kept * (table @ np.interp(roots, places, kept)), 1.0)
    mean = float(np.interp(roots, places, albedo) @ (4.0 * weights * roots**3))
    return np.array([np.append(kept, 0.0), np.append(albedo, mean)])


def _white_clay(roughness: float) -> Floats:
    """Return where rough diffuse white sends light from each node's angle: rows add up to 1.

    Over azimuths, the mean of what `kernels.bsdf.rough_diffuse` adds to Lambert's law is
    sin(i) sin(o) / π · (1 / max(cos(i), cos(o)) - 1); what is missing leaves evenly.
    """
    cosines = _cosines()
    sines = np.sqrt(1.0 - cosines**2)
    more = np.outer(sines, sines) / np.pi * (1.0 / np.maximum.outer(cosines, cosines) - 1.0)
    level = 1.0 / (1.0 + DARKENING * roughness)
    once = evenly(np.ones(NODES)) * level * (1.0 + roughness * more)
    return np.asarray(once + evenly(np.maximum(1.0 - once.sum(axis=1), 0.0)))


@cache
def through_sheen(alpha: float, below: Base) -> Floats:
    """Return T(θ) of sheens over a white base, (COLORS, NODES + 1), the last column unused.

    It solves T · ∫ f T cos dω = 1 - s E, as a coat's does
    (`photonmap.compile.surfaces.coats.through_coat`).

    Parameters
    ----------
    alpha : of the sheen
    below : the base
    """
    rough = below.diffuse_roughness
    base = (
        _white_clay(rough) if rough > 0.0 else white_base(below.alpha, below.f0, below.refraction)
    )
    rows, albedo = [], sheen_lobe(alpha).albedo[:-1]
    for color in np.linspace(0.0, 1.0, COLORS).tolist():
        passed = np.maximum(1.0 - color * albedo, 1e-9)
        through = np.sqrt(passed)
        for _ in range(ROUNDS):
            through = np.sqrt(through * passed / (base @ through))
        rows.append(np.append(through, 0.0))
    return np.array(rows)
