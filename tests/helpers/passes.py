"""Passes over a scene, without a render around them."""

from photonmap.integrators.base import PassSetup
from photonmap.kernels.core.passes import Film


def setup_of(compiled, workers, film=None, photons=4096, seed=1):
    """What passes over a compiled scene are made of; a film of one pixel by default."""
    bands = compiled.materials.reflectance.shape[1]
    return PassSetup(compiled, film or Film(1, 1, True), bands, photons, seed, workers)
