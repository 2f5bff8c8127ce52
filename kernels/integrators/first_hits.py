"""What lies at each pixel's centre: distance, depth, normal and identity of the first hit."""

import math

from photonmap.kernels.bsdf import coated, glossy, models, sheen
from photonmap.kernels.bsdf.glass import alpha_at, glass_share
from photonmap.kernels.bsdf.material import albedo, look_up_material
from photonmap.kernels.camera.cameras import first_hit, generate_ray
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.passes import Hit
from photonmap.kernels.geometry.interaction import point_at, surface_interaction


@kernel
def first_hits(geometry, view, span, triangles, barycentrics, distance, depth, normal):
    """Fill the first hits of the pixels of a span, by rays through the centre of the lens.

    Triangles (P,) int32 (-1: none), barycentrics (P, 2), distance and depth (P,), normal (P, 3).
    Depth is measured along the camera's axis; where it has none, it is the distance.
    """
    film, ahead = view.film, view.camera.axis
    has_axis = vec.dot(ahead, ahead) > 0.0
    for pixel in range(span.first, span.last):
        column, row = pixel % film.width, pixel // film.width
        ray = generate_ray(view.camera, column + 0.5, row + 0.5)
        hit = first_hit(geometry, ray)
        triangles[pixel] = hit.triangle
        barycentrics[pixel] = 0.0
        distance[pixel] = 0.0
        depth[pixel] = 0.0
        normal[pixel] = 0.0
        if hit.triangle < 0:
            continue
        barycentrics[pixel, 0], barycentrics[pixel, 1] = hit.u, hit.v
        step = vec.sub(point_at(geometry, hit.triangle, hit.u, hit.v)[0], ray.origin)
        ns = surface_interaction(geometry, hit, ray.direction).ns
        distance[pixel] = math.sqrt(vec.dot(step, step))
        depth[pixel] = vec.dot(step, ahead) if has_axis else distance[pixel]
        for axis in range(3):
            normal[pixel, axis] = ns[axis]


@kernel
def look_up_lobes(scene, scattering, maps, triangles, barycentrics, base, specular, lobes):
    """Fill what first hits reflect where textures give their glossy lobes: one row a hit.

    Diffuse albedos and reflectances at normal incidence (P, N); α, and the mean albedos of the
    lobe at the Fresnel terms of `Scattering.albedos`, in all but the last of (P, 8). Rows of other
    surfaces stay as they are.
    """
    geometry = scene.geometry
    for pixel in range(len(triangles)):
        triangle = triangles[pixel]
        if triangle < 0:
            continue
        if models.model_below(geometry, scattering, triangle) != models.GLOSSY:
            continue
        hit = Hit(triangle, barycentrics[pixel, 0], barycentrics[pixel, 1], 0.0)
        color = look_up_material(geometry, scene.textures, hit)
        lobe = glossy.lobe_at(geometry, scattering, maps, hit)
        lobes[pixel, 0] = lobe.alpha
        for term in range(scattering.albedos.shape[1]):
            lobes[pixel, 1 + term] = glossy.mean_albedo(scattering.albedos, maps, lobe, term)
        for band in range(base.shape[1]):
            base[pixel, band] = albedo(scene.materials, scene.textures, color, band)
            specular[pixel, band] = glossy.normal_reflectance(scattering, maps, lobe, band)


@kernel
def look_up_coats(geometry, scattering, maps, triangles, barycentrics, weights, lobes):
    """Fill which fraction of each surface hit a coat covers, (P,); rows of the sky stay.

    And its lobe, (P, 8), as `look_up_lobes` does.
    """
    coats = scattering.coats
    for pixel in range(len(triangles)):
        if triangles[pixel] >= 0:
            hit = Hit(triangles[pixel], barycentrics[pixel, 0], barycentrics[pixel, 1], 0.0)
            weights[pixel] = coated.weight_at(geometry, scattering, maps, hit)
            lobe, _ = coated.lobe_at(geometry, coats, coats.maps, hit)
            if weights[pixel] > 0.0:
                lobes[pixel, 0] = lobe.alpha
                for term in range(scattering.albedos.shape[1]):
                    mean = glossy.mean_albedo(scattering.albedos, coats.maps, lobe, term)
                    lobes[pixel, 1 + term] = mean


@kernel
def look_up_sheens(geometry, sheens, maps, triangles, barycentrics, colors):
    """Fill the colour of the sheen of each surface hit, (P, N), where an image gives it."""
    for pixel in range(len(triangles)):
        if triangles[pixel] < 0:
            continue
        if sheens.image[geometry.material[triangles[pixel]]] >= 0:
            hit = Hit(triangles[pixel], barycentrics[pixel, 0], barycentrics[pixel, 1], 0.0)
            over = sheen.sheen_at(geometry, sheens, maps, hit)
            for band in range(colors.shape[1]):
                colors[pixel, band] = sheen.color_of(sheens, maps, over, band)


@jit
def _rough_alpha(geometry, alpha, maps, hit):
    """Return α of a specular surface, 0 where it is smooth."""
    if len(alpha) == 0:
        return 0.0
    if alpha[geometry.material[hit.triangle]] == 0.0:
        return 0.0
    return alpha_at(geometry, alpha, maps, hit)


@kernel
def look_up_glass(geometry, specular, triangles, barycentrics, alphas, shares):
    """Fill α, and the fraction that is glass, of specular surfaces, (P,); rows of the sky stay."""
    for pixel in range(len(triangles)):
        if triangles[pixel] >= 0:
            hit = Hit(triangles[pixel], barycentrics[pixel, 0], barycentrics[pixel, 1], 0.0)
            alphas[pixel] = _rough_alpha(geometry, specular.alpha, specular.maps, hit)
            shares[pixel] = glass_share(geometry, specular.share, hit)
