"""The choice among many emitters for a point, down a tree by what may reach it.

A. Conty Estévez and C. Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting",
HPG 2018; bounds as in pbrt-v4, 12.6.3. The tree is complete: node n has the children 2n and
2n + 1, its root is node 1, and leaves fill its second half.
"""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.records import (
    NODE_AXIS,
    NODE_CENTER,
    NODE_CONE,
    NODE_REACH,
    NODE_SQUARED_RADIUS,
    NODE_STRENGTH,
)


@jit
def _sine(cosine):
    return math.sqrt(max(1.0 - cosine * cosine, 0.0))


@jit
def _closer(cosine, less, less_sine):
    """Return the cosine of an angle made smaller by another, 0 at least."""
    if cosine >= less:
        return 1.0
    return cosine * less + _sine(cosine) * less_sine


@jit
def _vector(nodes, node, first):
    return nodes[node, first], nodes[node, first + 1], nodes[node, first + 2]


@jit
def importance(nodes, node, point, ns):
    """Bound the irradiance at a point, about its normal, that comes from a node; roughly."""
    strength = nodes[node, NODE_STRENGTH]
    if strength == 0.0:
        return 0.0
    step = vec.sub(_vector(nodes, node, NODE_CENTER), point)
    squared, squared_radius = vec.dot(step, step), nodes[node, NODE_SQUARED_RADIUS]
    if squared <= squared_radius:
        return strength / max(squared_radius, 1e-30)
    inverse = 1.0 / squared
    direction = vec.scale(step, math.sqrt(inverse))
    spread = squared_radius * inverse
    width, width_sine = math.sqrt(1.0 - spread), math.sqrt(spread)
    lit = _closer(vec.dot(ns, direction), width, width_sine)
    if lit <= 0.0:
        return 0.0
    cone = nodes[node, NODE_CONE]
    if cone > -1.0:
        sent = -vec.dot(_vector(nodes, node, NODE_AXIS), direction)
        sent = _closer(_closer(sent, cone, _sine(cone)), width, width_sine)
        if sent < nodes[node, NODE_REACH]:
            return 0.0
        lit *= max(sent, 0.0)
    return strength * lit * inverse


@outlined
def descend(nodes, point, ns, u):
    """Go down from the root by importance; return (leaf, probability, u renewed).

    leaf is -1 where all importance is 0.
    """
    node, probability, leaves = 1, 1.0, len(nodes) // 2
    while node < leaves:
        first = importance(nodes, 2 * node, point, ns)
        both = first + importance(nodes, 2 * node + 1, point, ns)
        if both == 0.0:
            return -1, 0.0, u
        share = first / both
        if u < share:
            node, probability, u = 2 * node, probability * share, u / share
        else:
            node, probability = 2 * node + 1, probability * (1.0 - share)
            u = (u - share) / (1.0 - share)
        u = min(u, warp.BELOW_ONE)
    return node - leaves, probability, u


@outlined
def leaf_probability(nodes, leaf, point, ns):
    """Return the probability of `descend` to end at a leaf."""
    node, probability = leaf + len(nodes) // 2, 1.0
    while node > 1:
        own = importance(nodes, node, point, ns)
        if own == 0.0:
            return 0.0
        probability *= own / (own + importance(nodes, node ^ 1, point, ns))
        node //= 2
    return probability
