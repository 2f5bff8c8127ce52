"""Fluorescence: light that a diffuse base takes up in one band and sends out in others.

Of irradiance E, (N,), a base reflects ρ E / π, and re-emits c F E / π, with the reradiation matrix
F of its fluorophores (Donaldson 1954) and their concentration c. Kernels hold F transposed: row j
has what leaves in each band for a unit that arrives in band j, and S_j is its sum; where bands
overlap, some entries are negative. Light groups are blocks of columns, which F does not mix.

What covers a base, or roughens it, changes how much light gets in and out. With B(a) the BSDF of
the model over a base of albedo a, per steradian, B(ρ + c S) − B(ρ) is what leaves because of
fluorescence; over c S, that is how much of the light from a direction excites it. For Lambert's law
it is 1 / π. So covers let re-emitted light pass as they do the light that excited it.
"""

import numpy as np

from photonmap.kernels.bsdf.material import albedo, look_up_material, multiply_albedo
from photonmap.kernels.core.bands import copy
from photonmap.kernels.core.jit import jit, outlined, vectorized
from photonmap.kernels.geometry.texture import fraction_at

FLUORESCING = 254
"""Model of a surface of which paths look for what excites it; `bsdf.models` numbers the others"""

LEAST_TAKEN = np.float32(1e-3)


@jit
def fluoresces(scene, triangle):
    """Return whether the material of a triangle fluoresces."""
    if scene.fluorescence is None:
        return False
    return scene.fluorescence.row[scene.geometry.material[triangle]] >= 0


@outlined
def fluorophore_at(geometry, fluorescence, hit):
    """Return (row of the matrices, concentration) where a ray meets a fluorescent surface."""
    material = geometry.material[hit.triangle]
    row, image = np.int64(fluorescence.row[material]), fluorescence.image[material]
    concentration = fluorescence.concentration[material]
    if fluorescence.maps is not None and image >= 0:
        concentration = fraction_at(geometry, fluorescence.maps, image, hit)
    return row, concentration


@vectorized
def _add_row(emission, light, target):
    for band in range(len(emission)):
        target[band] += emission[band] * light


@jit
def add_band(fluorescence, row, band, light, target):
    """Add what leaves in all bands, (N,), for light that arrives in one."""
    if light != 0.0:
        size = fluorescence.matrix.shape[1]
        first = band - band % size
        _add_row(fluorescence.matrix[row, band - first], light, target[first : first + size])


@outlined
def add_reradiated(fluorescence, row, factor, source, target):
    """Add factor · F source to target, both (N,), which must not overlap."""
    factor = np.float32(factor)
    for band in range(len(source)):
        add_band(fluorescence, row, band, factor * source[band], target)


@outlined
def fill_transposed(fluorescence, row, factor, throughput, values):
    """Fill values, (N,), with factor · |F|ᵀ throughput; return their sum."""
    matrix, factor, total = fluorescence.matrix, np.float32(factor), np.float32(0.0)
    size = matrix.shape[1]
    for first in range(0, len(values), size):
        for band in range(size):
            value = np.float32(0.0)
            for other in range(size):
                value += abs(matrix[row, band, other]) * throughput[first + other]
            values[first + band] = value * factor
            total += value * factor
    return total


@jit
def _taken(fluorescence, fluorophore, rho, band):
    """Return c S, bounded so that ratios of it are no rounding errors, and ρ + c S no gain."""
    row, concentration = fluorophore
    taken = np.float32(concentration) * fluorescence.taken[row, band]
    return max(min(taken, np.float32(1.0) - rho), LEAST_TAKEN)


@jit
def fill_whole_albedo(scene, hit, values):
    """Fill values, (N,), with the part of light that a base sends out in any band, ρ + c S."""
    fluorescence, color = scene.fluorescence, look_up_material(scene, hit)
    fluorophore = fluorophore_at(scene.geometry, fluorescence, hit)
    for band in range(len(values)):
        rho = albedo(scene, color, band)
        values[band] = rho + _taken(fluorescence, fluorophore, rho, band)


@jit
def divide_by_taken(scene, hit, reflected, values):
    """Turn values, (N,), for a base of albedo ρ + c S into the part of light that excites it.

    `reflected`, (N,), are the same values for a base of albedo ρ.
    """
    fluorescence, color = scene.fluorescence, look_up_material(scene, hit)
    fluorophore = fluorophore_at(scene.geometry, fluorescence, hit)
    for band in range(len(values)):
        rest, rho = values[band] - reflected[band], albedo(scene, color, band)
        values[band] = rest / _taken(fluorescence, fluorophore, rho, band)


@jit
def reflect_flux(scene, hit, factor, flux, scratch):
    """Turn a photon's flux, (N,), into factor · (ρ + c F) flux; return the largest size of a band.

    `scratch`, (N,), is used where the surface fluoresces: then flux may be negative in some bands.
    """
    color = look_up_material(scene, hit)
    if scene.fluorescence is None:
        return multiply_albedo(scene, color, factor, flux)[1]
    if not fluoresces(scene, hit.triangle):
        return multiply_albedo(scene, color, factor, flux)[1]
    copy(flux, scratch)
    multiply_albedo(scene, color, factor, flux)
    row, concentration = fluorophore_at(scene.geometry, scene.fluorescence, hit)
    add_reradiated(scene.fluorescence, row, factor * concentration, scratch, flux)
    most = np.float32(0.0)
    for band in range(len(flux)):
        most = max(most, abs(flux[band]))
    return most
