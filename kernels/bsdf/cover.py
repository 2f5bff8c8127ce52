"""What a clear coat makes of the BSDF below it; see `coated`."""

from typing import NamedTuple

from photonmap.kernels.core.jit import jit


class Cover(NamedTuple):
    """What lies over a surface, between two directions."""

    own: float  # what the coat itself reflects, per steradian
    bare: float  # fraction of the surface without a coat
    through: float  # what passes the coat to the base and back, once
    back: float  # part of the base's light that the coat returns to it


UNCOVERED = Cover(0.0, 1.0, 0.0, 0.0)  # Of a surface without a coat


@jit
def covered(cover, f0, albedo, base):
    """Return the BSDF, per steradian, of a `base` with all that covers it.

    `f0` is the normal reflectance of its lobe, `albedo` that of what is diffuse.
    """
    again = cover.back * min(f0 + albedo, 1.0)
    return cover.own + base * (cover.bare + cover.through / (1.0 - again))
