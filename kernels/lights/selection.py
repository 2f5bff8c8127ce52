"""The choice of an emitter for the light at a point, by the irradiance that it may send there.

Many are chosen among down a tree (A. Conty Estévez and C. Kulla, "Importance Sampling of Many
Lights with Adaptive Tree Splitting", HPG 2018; bounds as in pbrt-v4, 12.6.3). It is complete, and
its nodes have `WIDTH` children, which lie side by side in a block: without branches they are
weighed several at a time by the processor's vector instructions. Block 0 is the root's; the
children of node i of block b are in block WIDTH · b + i + 1, or they are leaves where there is no
such block.
"""

import math

from photonmap.kernels.core import records, vec, warp
from photonmap.kernels.core.jit import jit, outlined, vectorized
from photonmap.kernels.lights.kinds import importance

WIDTH = 16  # Children of a node
_BELOW = 1.0 - 1e-15  # Keeps a random number times a sum below the sum, whatever is rounded
_TINY = 1e-30


@jit
def _vector(nodes, block, first, i):
    return nodes[block, first, i], nodes[block, first + 1, i], nodes[block, first + 2, i]


@jit
def _clamp(cosine):
    return min(max(cosine, 0.0), 1.0)


@jit
def node_importance(nodes, block, i, point, ns):
    """Bound the irradiance at a point, about its normal, that comes from a node; roughly.

    A sphere that is seen at an angle b adds at most 2 sin b to a cosine, and sin b where that makes
    it 0: what may reach the point is never 0.
    """
    radius = nodes[block, records.NODE_RADIUS, i]
    step = vec.sub(_vector(nodes, block, records.NODE_CENTER, i), point)
    inverse = 1.0 / max(vec.dot(step, step), radius * radius, _TINY)
    scale = math.sqrt(inverse)
    lit = vec.dot(ns, step) * scale
    sent = -vec.dot(_vector(nodes, block, records.NODE_AXIS, i), step) * scale
    cone = nodes[block, records.NODE_CONE, i]
    closer = (
        sent * cone
        + math.sqrt(max(1.0 - sent * sent, 0.0)) * nodes[block, records.NODE_CONE_SINE, i]
    )
    sent = 1.0 if sent >= cone else closer
    sine = radius * scale
    most = (
        nodes[block, records.NODE_STRENGTH, i] * _clamp(lit + sine) * _clamp(sent + sine) * inverse
    )
    return most if sent + 2.0 * sine >= nodes[block, records.NODE_REACH, i] else 0.0


@vectorized
def weigh_nodes(nodes, block, point, ns, sums):
    """Fill sums[:WIDTH] with the importances of a block's nodes, added up to each."""
    for i in range(nodes.shape[2]):  # the width as a number would keep it from being vectorised
        sums[i] = node_importance(nodes, block, i, point, ns)
    for i in range(1, WIDTH):
        sums[i] += sums[i - 1]


@jit
def _choose(sums, u):
    """Return (child, probability, u renewed) by what `weigh_nodes` filled; child -1 if all is 0."""
    total = sums[WIDTH - 1]
    if total == 0.0:
        return -1, 0.0, u
    target, child = u * _BELOW * total, 0
    for i in range(WIDTH):
        child += 1 if sums[i] <= target else 0
    below = 0.0 if child == 0 else sums[child - 1]
    own = sums[child] - below
    return child, own / total, min((target - below) / own, _BELOW)


@outlined
def descend(nodes, point, ns, cdf, u):
    """Go down from the root by importance; return (leaf, probability, u renewed).

    `cdf`, (2 WIDTH,), begins with what `weigh_nodes` says of the root's block; the rest is scratch.
    leaf is -1 where all importance is 0.
    """
    child, probability, u = _choose(cdf, u)
    if child < 0:
        return -1, 0.0, u
    block, sums = 1 + child, cdf[WIDTH:]
    while block < len(nodes):
        weigh_nodes(nodes, block, point, ns, sums)
        child, chance, u = _choose(sums, u)
        if child < 0:
            return -1, 0.0, u
        probability *= chance
        block = WIDTH * block + 1 + child
    return block - len(nodes), probability, u


@outlined
def leaf_probability(nodes, leaf, point, ns):
    """Return the probability of `descend` to end at a leaf."""
    node, probability = leaf + len(nodes), 1.0
    while node > 0:
        block, child = (node - 1) // WIDTH, (node - 1) % WIDTH
        below, upto, total = 0.0, 0.0, 0.0
        for i in range(WIDTH):
            below = total if i == child else below
            total += node_importance(nodes, block, i, point, ns)
            upto = total if i == child else upto
        if upto == below:
            return 0.0
        probability *= (upto - below) / total
        node = block
    return probability


BY_POWER = 0.1  # Part of choices by power alone: an emitter that would send much may be hidden
FEW_EMITTERS = WIDTH  # Number of emitters up to which every one is considered for each point
SCRATCH = 2 * WIDTH  # Numbers that a choice needs room for


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
