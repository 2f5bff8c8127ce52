"""The choice of an emitter for the light at a point, by the irradiance that it may send there."""

from photonmap.kernels.core import warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights.kinds import importance
from photonmap.kernels.lights.light_tree import descend, leaf_probability

BY_POWER = 0.1
"""Share of choices made by power alone: an emitter that would send much may be hidden."""
FEW = 16
"""Number of emitters up to which every one is considered for each point."""


@jit
def _select_of_few(geometry, lights, point, ns, u):
    """Go through all emitters: (emitter, probability, u renewed)."""
    cdf = lights.cdf
    if len(cdf) == 1:
        return 0, 1.0, u
    by_power = u < BY_POWER
    u = u / BY_POWER if by_power else (u - BY_POWER) / (1.0 - BY_POWER)
    chosen, power, light, powers, lit = -1, 0.0, 0.0, 0.0, 0.0
    for emitter in range(len(cdf)):
        own_power = warp.discrete_pdf(cdf, emitter)
        own = own_power * importance(geometry, lights, emitter, point, ns)
        if own > 0.0:
            powers += own_power
            lit += own
            share = own_power / powers if by_power else own / lit
            if u < share:
                chosen, power, light, u = emitter, own_power, own, u / share
            else:
                u = (u - share) / (1.0 - share)
            u = min(u, warp.BELOW_ONE)
    if chosen < 0:
        return -1, 0.0, u
    return chosen, BY_POWER * power / powers + (1.0 - BY_POWER) * light / lit, u


@jit
def _probability_of_few(geometry, lights, emitter, point, ns):
    """Return the probability of `_select_of_few` to return an emitter."""
    power, light, powers, lit = 0.0, 0.0, 0.0, 0.0
    for other in range(len(lights.cdf)):
        own_power = warp.discrete_pdf(lights.cdf, other)
        own = own_power * importance(geometry, lights, other, point, ns)
        if own > 0.0:
            powers += own_power
            lit += own
            if other == emitter:
                power, light = own_power, own
    if light == 0.0:
        return 1.0 if len(lights.cdf) == 1 else 0.0
    return BY_POWER * power / powers + (1.0 - BY_POWER) * light / lit


@jit
def select_emitter(geometry, lights, tree, point, ns, u):
    """Choose an emitter for the light at a point; return (emitter, probability, u renewed).

    emitter is -1 where none can reach it. Without a tree (None) more than FEW are chosen by power.
    """
    if tree is None:
        if len(lights.cdf) <= FEW:
            return _select_of_few(geometry, lights, point, ns, u)
        emitter, u = warp.discrete(lights.cdf, u)
        return emitter, warp.discrete_pdf(lights.cdf, emitter), u
    if u >= tree.near:
        emitter, u = warp.discrete(tree.far, (u - tree.near) / (1.0 - tree.near))
        return emitter, warp.discrete_pdf(lights.cdf, emitter), u
    leaf, probability, u = descend(tree.nodes, point, ns, u / tree.near)
    if leaf < 0:
        return -1, 0.0, u
    return tree.emitter[leaf], tree.near * probability, u


@jit
def selection_probability(geometry, lights, tree, emitter, point, ns):
    """Return the probability of `select_emitter` to return an emitter."""
    if tree is None and len(lights.cdf) <= FEW:
        return _probability_of_few(geometry, lights, emitter, point, ns)
    leaf = -1 if tree is None else tree.leaf[emitter]
    if leaf < 0:
        return warp.discrete_pdf(lights.cdf, emitter)
    return tree.near * leaf_probability(tree.nodes, leaf, point, ns)
