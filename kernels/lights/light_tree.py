"""The choice among many emitters for a point, down a tree by what may reach it.

A. Conty Estévez and C. Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting",
HPG 2018; bounds as in pbrt-v4, 12.6.3. The tree is complete, and its nodes have `WIDTH` children,
which lie side by side in a block: without branches they are weighed several at a time by the
processor's vector instructions. Block 0 is the root's; the children of node i of block b are in
block WIDTH · b + i + 1, or they are leaves where there is no such block.
"""

import math

from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit, outlined, vectorized
from photonmap.kernels.core.records import (
    NODE_AXIS,
    NODE_CENTER,
    NODE_CONE,
    NODE_CONE_SINE,
    NODE_RADIUS,
    NODE_REACH,
    NODE_STRENGTH,
)

WIDTH = 16
"""Children of a node."""
_BELOW = 1.0 - 1e-15
"""Keeps a random number times a sum below the sum, whatever is rounded."""
_TINY = 1e-30


@jit
def _vector(nodes, block, first, i):
    return nodes[block, first, i], nodes[block, first + 1, i], nodes[block, first + 2, i]


@jit
def _clamp(cosine):
    return min(max(cosine, 0.0), 1.0)


@jit
def importance(nodes, block, i, point, ns):
    """Bound the irradiance at a point, about its normal, that comes from a node; roughly.

    A sphere that is seen at an angle b adds at most 2 sin b to a cosine, and sin b where that makes
    it 0: what may reach the point is never 0.
    """
    radius = nodes[block, NODE_RADIUS, i]
    step = vec.sub(_vector(nodes, block, NODE_CENTER, i), point)
    inverse = 1.0 / max(vec.dot(step, step), radius * radius, _TINY)
    scale = math.sqrt(inverse)
    lit = vec.dot(ns, step) * scale
    sent = -vec.dot(_vector(nodes, block, NODE_AXIS, i), step) * scale
    cone = nodes[block, NODE_CONE, i]
    closer = sent * cone + math.sqrt(max(1.0 - sent * sent, 0.0)) * nodes[block, NODE_CONE_SINE, i]
    sent = 1.0 if sent >= cone else closer
    sine = radius * scale
    most = nodes[block, NODE_STRENGTH, i] * _clamp(lit + sine) * _clamp(sent + sine) * inverse
    return most if sent + 2.0 * sine >= nodes[block, NODE_REACH, i] else 0.0


@vectorized
def weigh_nodes(nodes, block, point, ns, sums):
    """Fill sums[:WIDTH] with the importances of a block's nodes, added up to each."""
    for i in range(nodes.shape[2]):  # the width as a number would keep it from being vectorised
        sums[i] = importance(nodes, block, i, point, ns)
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
        child, share, u = _choose(sums, u)
        if child < 0:
            return -1, 0.0, u
        probability *= share
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
            total += importance(nodes, block, i, point, ns)
            upto = total if i == child else upto
        if upto == below:
            return 0.0
        probability *= (upto - below) / total
        node = block
    return probability
