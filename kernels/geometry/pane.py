"""Smooth panes of thin glass, through which light goes straight on as through a surface with holes.

A ray passes a pane, unseen by it, with the probability that light of every band has in common; else
the pane stops it, and `bsdf.specular` scatters the rest: the reflection, and what colours let pass
beyond that. So lights shine through a window directly, and their shadows stay sharp.
"""

from photonmap.kernels.core import vec
from photonmap.kernels.core.fresnel import fresnel
from photonmap.kernels.core.jit import jit
from photonmap.kernels.geometry.texture import fraction_at


@jit
def pane_reflectance(ior, cosine):
    """Return 2 R / (1 + R): a pane's two surfaces, with all reflections between them."""
    once = fresnel(abs(cosine), 1.0 / ior)
    return 2.0 * once / (1.0 + once)


@jit
def pane_opacity(geometry, hit, direction):
    """Return the probability that a pane stops a ray; 1 for whatever is no pane."""
    panes = geometry.alpha.panes
    material = geometry.material[hit.triangle]
    if panes is None or panes.ior[material] == 0.0:
        return 1.0
    normal = vec.row(geometry.normals, hit.triangle)
    reflected = pane_reflectance(panes.ior[material], vec.dot(normal, vec.normalize(direction)))
    return 1.0 - (1.0 - reflected) * clear_at(geometry, panes, hit)


@jit
def clear_at(geometry, panes, hit):
    """Return what a pane transmits in every band, where a ray meets it."""
    material = geometry.material[hit.triangle]
    if panes.maps is None or panes.image[material] < 0:
        return panes.clear[material]
    return fraction_at(geometry, panes.maps, panes.image[material], hit)


@jit
def is_reflected(panes, material, clear, cosine, xi):
    """Choose, by a uniform number, whether light that a pane stopped is reflected."""
    reflected = pane_reflectance(panes.ior[material], cosine)
    return xi * (1.0 - (1.0 - reflected) * clear) < reflected
