"""The choice among many emitters for a point, down a tree by what may reach it.

A. Conty Estévez and C. Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting",
HPG 2018; bounds as in pbrt-v4, 12.6.3. The tree is complete: node n has the children 2n and
2n + 1, its root is node 1, and leaves fill its second half.
"""

import math

from photonmap.kernels import vec
from photonmap.kernels.jit import jit, outlined
from photonmap.kernels.records import (
    NODE_AXIS,
    NODE_CENTER,
    NODE_REACH,
    NODE_SQUARED_RADIUS,
    NODE_STRENGTH,
    NODE_TURN,
)

BELOW_ONE = 1.0 - 2.0**-53


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
    turn = nodes[node, NODE_TURN]
    if turn > -1.0:
        sent = -vec.dot(_vector(nodes, node, NODE_AXIS), direction)
        sent = _closer(_closer(sent, turn, _sine(turn)), width, width_sine)
        if sent < nodes[node, NODE_REACH]:
            return 0.0
        lit *= max(sent, 0.0)
    return strength * lit * inverse


@outlined
def descend(nodes, point, ns, u):
    """Go down from the root by importance; return (leaf, chance, u renewed).

    leaf is -1 where all importance is 0.
    """
    node, chance, leaves = 1, 1.0, len(nodes) // 2
    while node < leaves:
        first = importance(nodes, 2 * node, point, ns)
        both = first + importance(nodes, 2 * node + 1, point, ns)
        if both == 0.0:
            return -1, 0.0, u
        share = first / both
        if u < share:
            node, chance, u = 2 * node, chance * share, u / share
        else:
            node, chance, u = 2 * node + 1, chance * (1.0 - share), (u - share) / (1.0 - share)
        u = min(u, BELOW_ONE)
    return node - leaves, chance, u


@outlined
def chance_of_leaf(nodes, leaf, point, ns):
    """Return the probability of `descend` to end at a leaf."""
    node, chance = leaf + len(nodes) // 2, 1.0
    while node > 1:
        own = importance(nodes, node, point, ns)
        if own == 0.0:
            return 0.0
        chance *= own / (own + importance(nodes, node ^ 1, point, ns))
        node //= 2
    return chance
