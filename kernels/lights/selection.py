"""The choice of an emitter for the light at a point, by the irradiance that it may send there."""

from photonmap.kernels.core import warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights.kinds import importance
from photonmap.kernels.lights.light_tree import WIDTH, descend, leaf_probability, weigh_nodes

BY_POWER = 0.1
"""Share of choices made by power alone: an emitter that would send much may be hidden."""
FEW_EMITTERS = WIDTH
"""Number of emitters up to which every one is considered for each point."""
SCRATCH = 2 * WIDTH
"""Numbers that a choice needs room for."""


@jit
def weigh_emitters(geometry, lights, point, ns, cdf):
    """Fill `cdf`, (SCRATCH,), by which `select_emitter` chooses for a point.

    That is the CDF of few emitters, or with a tree the sums of its first block. Of few, each
    emitter is chosen in one interval of the random number, so that stratified numbers remain
    stratified on each. The CDF is 0 where no emitter can reach the point.
    """
    count = len(lights.cdf)
    if lights.tree is not None:
        weigh_nodes(lights.tree.nodes, 0, point, ns, cdf)
        return
    if count > FEW_EMITTERS:
        return
    powers, lit, last = 0.0, 0.0, -1
    for emitter in range(count):
        power = warp.discrete_pdf(lights.cdf, emitter)
        cdf[emitter] = power * importance(geometry, lights, emitter, point, ns)
        if cdf[emitter] > 0.0:
            powers += power
            lit += cdf[emitter]
            last = emitter
    total = 0.0
    for emitter in range(count):
        if cdf[emitter] > 0.0:
            power = warp.discrete_pdf(lights.cdf, emitter)
            total += BY_POWER * power / powers + (1.0 - BY_POWER) * cdf[emitter] / lit
        cdf[emitter] = 1.0 if 0 <= last <= emitter else total


@jit
def _select_of_few(count, cdf, u):
    """Invert the CDF of `weigh_emitters`: (emitter, probability, u renewed)."""
    if cdf[count - 1] == 0.0:
        return -1, 0.0, u
    emitter, below = 0, 0.0
    while cdf[emitter] <= u:
        below = cdf[emitter]
        emitter += 1
    probability = cdf[emitter] - below
    return emitter, probability, min((u - below) / probability, warp.BELOW_ONE)


@jit
def _probability_of_few(geometry, lights, emitter, point, ns):
    """Return the probability of an emitter by the CDF of `weigh_emitters`."""
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
def select_emitter(lights, point, ns, cdf, u):
    """Choose an emitter for the light at a point; return (emitter, probability, u renewed).

    emitter is -1 where none can reach it. `cdf` is what `weigh_emitters` filled for the point.
    Without a tree, more than FEW_EMITTERS are chosen by power.
    """
    tree = lights.tree
    if tree is None:
        if len(lights.cdf) <= FEW_EMITTERS:
            return _select_of_few(len(lights.cdf), cdf, u)
        emitter, u = warp.discrete(lights.cdf, u)
        return emitter, warp.discrete_pdf(lights.cdf, emitter), u
    if u >= tree.near:
        emitter, u = warp.discrete(tree.far, (u - tree.near) / (1.0 - tree.near))
        return emitter, warp.discrete_pdf(lights.cdf, emitter), u
    leaf, probability, u = descend(tree.nodes, point, ns, cdf, u / tree.near)
    if leaf < 0:
        return -1, 0.0, u
    return tree.emitter[leaf], tree.near * probability, u


@jit
def selection_probability(geometry, lights, emitter, point, ns):
    """Return the probability of `select_emitter` to return an emitter."""
    tree = lights.tree
    if tree is None and len(lights.cdf) <= FEW_EMITTERS:
        return _probability_of_few(geometry, lights, emitter, point, ns)
    leaf = -1 if tree is None else tree.leaf[emitter]
    if leaf < 0:
        return warp.discrete_pdf(lights.cdf, emitter)
    return tree.near * leaf_probability(tree.nodes, leaf, point, ns)
