"""What lies at each pixel's centre: where its ray hits, and what the surface there reflects."""

import math
from typing import NamedTuple

from numba.types import float32, float64, int32

from photonmap.kernels.bsdf import coated, glossy, models, sheen
from photonmap.kernels.bsdf.glass import alpha_at, glass_fraction
from photonmap.kernels.bsdf.material import albedo, look_up_material
from photonmap.kernels.camera.cameras import first_hit, generate_ray, is_dark
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.passes import Hit
from photonmap.kernels.core.record_types import by_reference
from photonmap.kernels.geometry.interaction import point_at, surface_interaction


@by_reference
class FirstHits(NamedTuple):
    """What the rays through the centres of P pixels hit; all is 0 for the background but rays."""

    triangle: int32[::1]  # (P,), row of `Geometry.triangles`; -1 for the background
    barycentrics: float32[:, ::1]  # (P, 2), of the second and third corner
    direction: float32[:, ::1]
    """(P, 3), of the ray, a unit vector in the world; 0 where no light reaches the film"""
    distance: float32[::1]  # (P,), from where the ray begins in the kernels' unit
    depth: float32[::1]  # (P,), the same along the camera's axis; where it has none, the distance
    normal: float32[:, ::1]  # (P, 3), unit shading normal towards the camera


@by_reference
class SurfaceRows(NamedTuple):
    """What the surfaces of P first hits reflect; of what a scene lacks, no rows."""

    reflectance: float32[:, ::1]  # (P, N) diffuse albedo
    glossy: float32[:, ::1]  # (P, N) reflectance of the glossy lobe at normal incidence
    lobes: float64[:, ::1]
    """(P, 8) its α, and its mean albedos at the Fresnel terms of `Scattering.albedos`; the last
    column is not looked up"""
    coat_weight: float64[:, ::1]  # (P, 1) fraction of the surface that a clear coat covers
    coat_lobes: float64[:, ::1]  # (P, 8) the coat's, as `lobes`
    sheen_color: float32[:, ::1]  # (P, N)
    alpha: float64[::1]  # (P,) α of specular surfaces, 0 of what is smooth
    glass: float64[::1]  # (P,) fraction that is glass


@kernel
def find_first_hits(geometry, view, span, hits):
    """Fill the `FirstHits` of the pixels of a span, by rays through the centre of the lens."""
    film, ahead = view.film, view.camera.axis
    has_axis = vec.dot(ahead, ahead) > 0.0
    for pixel in range(span.first, span.last):
        row = pixel - span.first
        ray = generate_ray(view.camera, pixel % film.width + 0.5, pixel // film.width + 0.5)
        hit = first_hit(geometry, ray)
        hits.triangle[row] = hit.triangle
        dark = is_dark(ray)
        _fill(hits.direction[row], ray.direction if dark else vec.normalize(ray.direction))
        if hit.triangle < 0:
            hits.barycentrics[row], hits.normal[row] = 0.0, 0.0
            hits.distance[row], hits.depth[row] = 0.0, 0.0
            continue
        hits.barycentrics[row, 0], hits.barycentrics[row, 1] = hit.u, hit.v
        step = vec.sub(point_at(geometry, hit.triangle, hit.u, hit.v)[0], ray.origin)
        hits.distance[row] = math.sqrt(vec.dot(step, step))
        hits.depth[row] = vec.dot(step, ahead) if has_axis else hits.distance[row]
        _fill(hits.normal[row], surface_interaction(geometry, hit, ray.direction).ns)


@jit
def _fill(row, vector):
    for axis in range(3):
        row[axis] = vector[axis]


@kernel
def describe_surfaces(scene, hits, rows):
    """Fill `SurfaceRows` of `FirstHits` with what images say of them; other values stay."""
    for row in range(len(hits.triangle)):
        if hits.triangle[row] < 0:
            continue
        hit = Hit(hits.triangle[row], hits.barycentrics[row, 0], hits.barycentrics[row, 1], 0.0)
        if scene.scattering is not None:
            _describe_scattering(scene, hit, row, rows)
        if scene.specular is not None:
            specular = scene.specular
            if len(specular.alpha) > 0 and rows.alpha[row] > 0.0:
                rows.alpha[row] = alpha_at(scene.geometry, specular.alpha, specular.maps, hit)
            rows.glass[row] = glass_fraction(scene.geometry, specular.glass, hit)


@jit
def _describe_scattering(scene, hit, row, rows):
    geometry, scattering, sheens = scene.geometry, scene.scattering, scene.scattering.sheens
    if scattering.maps is not None:
        if models.model_below(scene, hit.triangle) == models.GLOSSY:
            lobe = glossy.lobe_at(geometry, scattering, hit)
            color = look_up_material(scene, hit)
            _fill_lobe(scattering, lobe, rows.lobes[row])
            for band in range(rows.glossy.shape[1]):
                rows.reflectance[row, band] = albedo(scene, color, band)
                rows.glossy[row, band] = glossy.normal_reflectance(scattering, lobe, band)
        if scattering.coats is not None:
            rows.coat_weight[row, 0] = coated.weight_at(geometry, scattering, hit)
            if rows.coat_weight[row, 0] > 0.0:
                lobe, _ = coated.lobe_at(geometry, scattering.coats, hit)
                _fill_lobe(scattering, lobe, rows.coat_lobes[row])
    if sheens is not None and sheens.image[geometry.material[hit.triangle]] >= 0:
        over = sheen.sheen_at(geometry, sheens, hit)
        for band in range(rows.sheen_color.shape[1]):
            rows.sheen_color[row, band] = sheen.color_of(sheens, over, band)


@jit
def _fill_lobe(scattering, lobe, row):
    row[0] = lobe.alpha
    for term in range(scattering.albedos.shape[1]):
        row[1 + term] = glossy.mean_albedo(scattering, lobe, term)
