"""Lambert's law: the diffuse lobe, of reflectance × shading and of the radiosity cache."""

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit


@jit
def sample(surface, u, v):
    """Return a direction about the shading normal, distributed by its cosine."""
    return vec.from_frame(warp.cosine_hemisphere(u, v), surface.ns)


@jit
def pdf(surface, wi):
    """Return the density of `sample` (per steradian)."""
    return warp.cosine_hemisphere_pdf(vec.dot(surface.ns, wi))
