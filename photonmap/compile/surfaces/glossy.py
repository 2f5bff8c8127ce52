"""What glossy lobes reflect in all, which their kernels look up."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.table_cache import kept_on_disk
from photonmap.kernels.core.metals import DIP_MEANS, DIP_POWERS
from photonmap.scene.material import LEAST_ALPHA
from photonmap.scene.surfaces.conductors import dip_terms
from photonmap.scene.surfaces.fresnel import even_light, rise
from photonmap.spectra.curves import Floats

Values = Any  # Numbers, or arrays that go together
NODES = 64  # Angles, evenly in the square root of the cosine
GRID = 128  # Samples per angle: its square
STEPS = 33
"""Values of roughness for which textured lobes have albedos; what lies between is interpolated."""
AZIMUTHS = 9
"""Azimuths for which lobes that differ along a surface have albedos, evenly in their sine²."""
COARSE = 64  # In place of `GRID` where there are many tables: they differ by up to 0.0015
SMALLEST_COSINE = 1e-4
TERMS = 2 + len(DIP_POWERS)  # Fresnel terms of `Scattering.albedos`


def node_cosines() -> Floats:
    """Return the cosines of the angles that albedos are tabulated for, (NODES,)."""
    return np.asarray(np.maximum(np.linspace(0.0, 1.0, NODES) ** 2, SMALLEST_COSINE))


@kept_on_disk
def lobe_albedos(alpha: float, index: float = 0.0) -> Floats:
    """Return what a GGX lobe reflects, (TERMS, NODES + 1), by `Scattering.albedos`' Fresnel terms.

    Of light from each angle, and last the cosine-weighted mean over all angles; by quadrature over
    visible normals (Dupuy and Benyoub 2023). The index is that of refraction, 0 for Schlick's
    formula.
    """
    return _albedos_at((alpha, alpha, index), 0.0, GRID)


@kept_on_disk
def azimuth_albedos(along: float, across: float, index: float = 0.0, grid: int = GRID) -> Floats:
    """Return `lobe_albedos` by azimuth, (1 + AZIMUTHS, TERMS, NODES + 1), the first of all.

    `along` and `across` are α along a tangent, and across it; `grid` is the root of the samples per
    angle.
    """
    lobe, shares = (along, across, index), np.linspace(0.0, 1.0, AZIMUTHS)
    rows = np.array([_albedos_at(lobe, share, grid) for share in shares.tolist()])
    angles = np.pi * (np.arange(256) + 0.5) / 512.0
    places = np.sin(angles) ** 2 * (AZIMUTHS - 1)
    weights = np.maximum(1.0 - np.abs(places[:, None] - np.arange(AZIMUTHS)), 0.0).mean(axis=0)
    return np.concatenate([np.tensordot(weights, rows, 1)[None], rows])


def _albedos_at(lobe: tuple[float, float, float], share: float, grid: int) -> Floats:
    """Return `lobe_albedos` of light from one azimuth, of which `share` is the sine².

    A lobe is α along and across, and the index of refraction.
    """
    rows = np.array([_albedos(lobe, share, cosine, grid) for cosine in node_cosines()]).T
    nodes, shares = even_light(NODES)
    means = [np.interp(np.sqrt(nodes), np.linspace(0.0, 1.0, NODES), row) for row in rows]
    return np.column_stack([rows, np.array(means) @ shares])


@kept_on_disk
def stepped_albedos(index: float) -> Floats:
    """Return `lobe_albedos` for even steps of roughness from 0 to 1, (STEPS, TERMS, NODES + 1)."""
    roughness = np.linspace(0.0, 1.0, STEPS).tolist()
    return np.array([lobe_albedos(max(value * value, LEAST_ALPHA), index) for value in roughness])


def append_stepped(
    albedos: Floats, index: Floats, chosen: NDArray[np.bool_]
) -> tuple[Floats, NDArray[np.int32]]:
    """Append rows to `Scattering.albedos` for lobes whose roughness varies, and a next row for all.

    Of M lobes, with an index as of `lobe_albedos`, the chosen ones vary. Return all rows, and the
    first of those of each chosen lobe, (M,); -1 for others.
    """
    distinct, first = np.unique(index[chosen]), np.full(len(index), -1, np.int32)
    first[chosen] = len(albedos) + STEPS * np.searchsorted(distinct, index[chosen])
    rows = [stepped_albedos(each) for each in distinct.tolist()]
    return np.concatenate([albedos, *rows, albedos[:1]]), first


def mean_albedo(
    f0: NDArray[np.floating], lobes: Floats, dip: NDArray[np.floating] | None = None
) -> Floats:
    """Return what glossy surfaces of F₀ (M, N) reflect of light from all around, (M, N).

    Lobes, (M, TERMS + 1), are what the lobe reflects with the terms of `Scattering.albedos`,
    likewise, and its `mean_rise`; the dip is that of metals, (M, 4, N), or (M, 0, 0) for none.
    """
    single, grazing, rising = (lobes[:, term : term + 1] for term in (0, 1, TERMS))
    if dip is None or dip.size == 0:
        return lobe_albedo(single, grazing, f0, multiple_fresnel(f0, single, rising))
    several = multiple_fresnel(f0, single, rising, np.tensordot(DIP_MEANS, dip, (0, 1)))
    less = np.einsum("mt,mtn->mn", lobes[:, 2:TERMS], dip)
    return lobe_albedo(single, grazing, f0, several) - less


def multiple_fresnel(f0: Values, mean: Values, rising: Values, dip: Values = 0.0) -> Values:
    """Return the Fresnel term of what is scattered several times.

    `mean` is that of the albedo at term 1, `rising` the `mean_rise`, `dip` the mean of the dip.
    """
    fresnel = f0 + (1.0 - f0) * rising - dip
    return fresnel**2 * mean / (1.0 - fresnel * (1.0 - mean))


def lobe_albedo(single: Values, grazing: Values, f0: Values, multiple: Values) -> Floats:
    """Return what a lobe reflects in all, of the albedos at Fresnel terms 1 and `rise`."""
    return np.asarray(f0 * (single - grazing) + grazing + (1.0 - single) * multiple)


def _albedos(
    lobe: tuple[float, float, float], share: float, cosine: float, grid: int
) -> tuple[float, ...]:
    """Return the mean of G2 / G1 over visible normals, times each Fresnel term."""
    along, across, index = lobe
    weight, beside, _ = reflections(along, across, share, cosine, grid)
    beside = np.minimum(beside, 1.0)
    terms = (1.0, rise(beside, index), *np.moveaxis(dip_terms(beside), -1, 0))
    return tuple(float((weight * term).mean()) for term in terms)


def reflections(
    along: float, across: float, share: float, cosine: float, grid: int
) -> tuple[Floats, Floats, Floats]:
    """Return how visible normals reflect light: G2 / G1, its cosine to them, and that of leaving.

    Each (grid, grid), evenly over the density of visible normals (Dupuy and Benyoub 2023). `along`
    and `across` are α along a tangent, and across it; of the light, `share` is the sine² of its
    azimuth from the tangent.
    """
    places = (np.arange(grid) + 0.5) / grid
    u, v = np.meshgrid(places, places)
    sine = np.sqrt(1.0 - cosine * cosine)
    wo = np.array([sine * np.sqrt(1.0 - share), sine * np.sqrt(share), cosine])
    stretched = wo * [along, across, 1.0]
    stretched /= np.linalg.norm(stretched)
    height = (1.0 - v) * (1.0 + stretched[2]) - stretched[2]
    r = np.sqrt(np.maximum(1.0 - height * height, 0.0))
    phi = 2.0 * np.pi * u
    h = np.stack(
        [
            along * (r * np.cos(phi) + stretched[0]),
            across * (r * np.sin(phi) + stretched[1]),
            height + stretched[2],
        ]
    )
    h /= np.linalg.norm(h, axis=0)
    beside = np.tensordot(wo, h, 1)
    out = np.maximum(2.0 * beside * h[2] - cosine, 0.0)
    alpha: Floats | float = along
    alpha_out: Floats | float = along
    if along != across:
        alpha = np.sqrt(along**2 * (1.0 - share) + across**2 * share)
        x, y = (2.0 * beside * h[axis] - wo[axis] for axis in range(2))
        squares = np.maximum(x * x + y * y, 1e-30)
        alpha_out = np.sqrt(((along * x) ** 2 + (across * y) ** 2) / squares)
    shadowed = 1.0 + _smith(alpha, cosine) + _smith(alpha_out, np.maximum(out, 1e-9))
    weight = np.where(out > 0.0, (1.0 + _smith(alpha, cosine)) / shadowed, 0.0)
    return weight, beside, out


def _smith(alpha: Floats | float, cosine: Floats | float) -> Floats:
    tangent = 1.0 / np.square(cosine) - 1.0
    return np.asarray(0.5 * (np.sqrt(1.0 + alpha * alpha * tangent) - 1.0))
