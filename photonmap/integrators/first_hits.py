"""Buffers of the surface at each pixel's centre: one function for each, registered by name.

A new one is a row of `photonmap.buffers.TABLE` with the source "first hit", and a function here.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import BY_NAME, DEFAULT, names_where
from photonmap.compile.scene_arrays import CompiledScene
from photonmap.compile.surfaces.glossy import mean_albedo
from photonmap.integrators.base import TILE
from photonmap.integrators.seen_surfaces import (
    Surfaces,
    has_textured_lobes,
    surfaces_at_hits,
    surfaces_of_materials,
)
from photonmap.kernels.core.passes import Film, Span, View
from photonmap.kernels.core.records import GLASS, METAL, MIRROR
from photonmap.kernels.integrators.first_hits import FirstHits, find_first_hits
from photonmap.runtime.storage import RAM, Storage, strips
from photonmap.runtime.workers import Workers
from photonmap.scene.surfaces.metallic import USUAL_COAT, metallic_fraction

Array = NDArray[Any]


Compute = Callable[[CompiledScene, FirstHits], Array]
"""Returns the values of a buffer, (P,) or (P, channels), in the unit of its row."""
_COMPUTE: dict[str, Compute] = {}


def at_centre(name: str) -> Callable[[Compute], Compute]:
    """Register the function that computes a buffer of `photonmap.buffers.TABLE`."""

    def register(compute: Compute) -> Compute:
        _COMPUTE[name] = compute
        return compute

    return register


def of_surface(name: str) -> Callable[[Callable[[Surfaces], Array]], Callable[[Surfaces], Array]]:
    """Register the function that computes a buffer from what surfaces reflect, one row each."""

    def register(compute: Callable[[Surfaces], Array]) -> Callable[[Surfaces], Array]:
        def look_up(compiled: CompiledScene, hits: FirstHits) -> Array:
            if has_textured_lobes(compiled):
                rows = compute(surfaces_at_hits(compiled, hits))
            else:
                material = compiled.geometry.material[hits.triangle]
                rows = compute(surfaces_of_materials(compiled))[material]
            rows[hits.triangle < 0] = 0
            return rows

        _COMPUTE[name] = look_up
        return compute

    return register


def first_hit_buffers(
    compiled: CompiledScene,
    film: Film,
    workers: Workers,
    kept: Container[str] = DEFAULT,
    storage: Storage = RAM,
) -> dict[str, Array]:
    """Return the buffers at the pixels' centres that are kept, one row a pixel."""
    names = [name for name in names_where(source="first hit") if name in kept]
    if not names:
        return {}
    pixels = film.width * film.height
    view = View(compiled.film_camera(film.width, film.height), film)
    images = {name: _empty(name, pixels, compiled, storage) for name in names}
    for part in strips(pixels):
        hits = _hits_of(compiled, view, part, workers)
        for name, image in images.items():
            image[part] = _COMPUTE[name](compiled, hits)
    return images


def _hits_of(compiled: CompiledScene, view: View, part: slice, workers: Workers) -> FirstHits:
    """Return the first hits of some consecutive pixels."""
    count, geometry = part.stop - part.start, compiled.arrays.geometry
    hits = FirstHits(
        triangle=np.empty(count, np.int32),
        barycentrics=np.empty((count, 2), np.float32),
        direction=np.empty((count, 3), np.float32),
        distance=np.empty(count, np.float32),
        depth=np.empty(count, np.float32),
        normal=np.empty((count, 3), np.float32),
    )

    def find(first: int, last: int) -> None:
        span = Span(part.start + first, part.start + last)
        find_first_hits(geometry, view, span, FirstHits(*(array[first:last] for array in hits)))

    workers.ranges(find, count, TILE, uninterrupted=True)
    return hits


def _of_triangles(table: Array, hits: FirstHits) -> Array:
    """Return the rows of a table (T, …) that the hit triangles have; 0 for the background."""
    rows = table[hits.triangle]
    rows[hits.triangle < 0] = 0
    return rows


def _empty(name: str, pixels: int, compiled: CompiledScene, storage: Storage) -> Array:
    """Make the array of a buffer, as its row describes it."""
    row = BY_NAME[name]
    bands = compiled.materials.reflectance.shape[1]
    count = bands if row.channels is None else len(row.channels)
    shape = (pixels, count) if row.is_banded or count > 1 else (pixels,)
    return storage.zeros(shape, np.dtype(row.dtype))


@at_centre("depth")
def _depth(compiled: CompiledScene, hits: FirstHits) -> Array:
    # What touches the camera may be behind it by a rounding error.
    return np.maximum(hits.depth, 0.0) * np.float32(compiled.size)


@at_centre("distance")
def _distance(compiled: CompiledScene, hits: FirstHits) -> Array:
    return hits.distance * np.float32(compiled.size)


@at_centre("normal")
def _normal(compiled: CompiledScene, hits: FirstHits) -> Array:
    return hits.normal


@at_centre("object_id")
def _object_id(compiled: CompiledScene, hits: FirstHits) -> Array:
    return _of_triangles(compiled.object_ids, hits)


@at_centre("material_id")
def _material_id(compiled: CompiledScene, hits: FirstHits) -> Array:
    return _of_triangles(compiled.material_ids, hits)


@of_surface("specular_reflectance")
def _specular_reflectance(surfaces: Surfaces) -> Array:
    """Look up the reflectance at normal incidence of a mirror, glossy lobes, or glass.

    That of glass of index n is R = ((n − 1) / (n + 1))², of both sides of a pane 2 R / (1 + R).
    """
    reflectance, specular = surfaces.glossy, surfaces.specular
    if specular is not None:
        of_glass = ((specular.ior - 1.0) / (specular.ior + 1.0)) ** 2
        mirrors = np.isin(specular.kind, (MIRROR, METAL))
        reflectance = np.where(mirrors[:, None], specular.mirror, reflectance)
        reflectance = np.where((specular.kind == GLASS)[:, None], of_glass[:, None], reflectance)
        of_pane = 2.0 * of_glass / (1.0 + of_glass)
        reflectance = np.where(surfaces.is_thin[:, None], of_pane[:, None], reflectance)
    if surfaces.coat is not None:
        own, transmitted = surfaces.coat.over(reflectance, surfaces.coat.f0)
        reflectance = own + transmitted * reflectance
    return reflectance


@of_surface("roughness")
def _roughness(surfaces: Surfaces) -> Array:
    specular, alpha = surfaces.specular, np.where(surfaces.is_glossy, surfaces.lobes[:, 0], 1.0)
    if surfaces.coat is not None:
        bare = ~surfaces.is_glossy & (surfaces.coat.weight[:, 0] > 0.0)
        alpha = np.where(bare, surfaces.coat.lobes[:, 0], alpha)
    roughness = np.sqrt(alpha).astype(np.float32)
    if specular is not None:
        roughness[specular.kind != 0] = 0.0
        rough = specular.alpha > 0.0
        roughness[rough] = np.sqrt(specular.alpha[rough])
    return roughness


@of_surface("metallic")
def _metallic(surfaces: Surfaces) -> Array:
    base = surfaces.reflectance.mean(axis=1, dtype=float)
    lobe = np.zeros_like(base) + surfaces.glossy.mean(axis=1)
    if surfaces.specular is not None:
        lobe += np.where(surfaces.is_thin, 0.0, surfaces.specular.mirror.mean(axis=1))
    coat = np.where(surfaces.covering >= 0.0, surfaces.covering, USUAL_COAT)
    return metallic_fraction(base, lobe, coat).astype(np.float32)


def _gloss(surfaces: Surfaces) -> tuple[Array, Array, Array]:
    """Return what lobes reflect of light from all around, and what covers bases, (R, N) both.

    And the part of a surface, (R, 1), that is a base below its cover; the rest is bare metal.
    """
    whole, part = np.zeros((2, *surfaces.glossy.shape)), np.ones((len(surfaces.glossy), 1))
    glossy, mixed = surfaces.is_glossy, surfaces.is_glossy & (surfaces.covering >= 0.0)

    def mean(rows: Array, f0: Array) -> Array:
        return mean_albedo(f0, surfaces.lobes[rows, 1:], surfaces.dip[rows])

    if glossy.any():
        whole[:, glossy] = mean(glossy, surfaces.glossy[glossy])
    lobe, over = whole
    if mixed.any():
        coat, f0 = surfaces.covering[mixed, None], surfaces.glossy[mixed]
        base = surfaces.reflectance[mixed].mean(axis=1, keepdims=True, dtype=float)
        metal = metallic_fraction(base, f0.mean(axis=1, keepdims=True), coat)
        part[mixed] = np.maximum(np.maximum(1.0 - metal, base), 1e-12)
        bare = np.clip((f0 - (1.0 - metal) * coat) / np.maximum(metal, 1e-12), 0.0, 1.0)
        over[mixed] = mean_albedo(coat + 0.0 * f0, surfaces.lobes[mixed, 1:])
        lobe[mixed] = metal * mean(mixed, bare) + (1.0 - metal) * over[mixed]
    return lobe, over, part


@of_surface("diffuse_fraction")
def _diffuse_fraction(surfaces: Surfaces) -> Array:
    """Look up base / (base + lobe) of the hemispherical albedos; 1 for what is black."""
    base, specular = surfaces.reflectance.astype(float), surfaces.specular
    glass = surfaces.glass_fraction[:, None]
    base /= np.maximum(1.0 - glass, 1e-12)
    lobe, over, covered_part = _gloss(surfaces)
    again = np.minimum(base / covered_part, 1.0) * over
    base *= (1.0 - over) ** 2 / np.maximum(1.0 - again, 1e-12)
    if surfaces.coat is not None:
        own, transmitted = surfaces.coat.over(base + lobe, surfaces.coat.mean)
        base, lobe = base * transmitted, lobe * transmitted + own
    if surfaces.sheen is not None:
        own = surfaces.sheen.color * surfaces.sheen.albedo
        base, lobe = base * (1.0 - own), lobe * (1.0 - own) + own
    if specular is not None:
        lobe += np.where(surfaces.is_thin[:, None], 0.0, specular.mirror)
    total = (1.0 - glass) * (base + lobe) + glass
    fraction = (1.0 - glass) * base
    np.divide(fraction, total, out=fraction, where=total > 0.0)
    fraction[total == 0.0] = 1.0
    return fraction.astype(np.float32)
