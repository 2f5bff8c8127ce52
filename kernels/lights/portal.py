"""Portals: area lights that show the environment, as openings to the outside do.

They are sampled as other area lights are. What they send follows from the direction alone, so a
position on a portal is the texel of the environment map that is seen through it.
"""

from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights.environment import texel_at


@jit
def position_on(lights, environment, emitter, barycentrics, direction):
    """Return the position on an emitting triangle, as in `LightSample`, seen in a direction.

    `environment` is that of the lights: Numba leaves out a branch on None only where it is an
    argument.
    """
    if environment is not None and lights.spectrum[emitter] == environment.row:
        return texel_at(environment, direction)
    return barycentrics
