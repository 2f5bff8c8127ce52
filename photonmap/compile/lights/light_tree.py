"""Build the tree from which direct light chooses among many emitters."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.cdf import make_cdf, probabilities_of
from photonmap.kernels.core.records import (
    NODE_AXIS,
    NODE_CENTER,
    NODE_CONE,
    NODE_REACH,
    NODE_SQUARED_RADIUS,
    NODE_STRENGTH,
    LightTree,
)

FEW = 8
"""Emitters at a finite distance below which a choice by power costs less than it loses."""

Array = NDArray[np.float64]


class EmitterBounds(NamedTuple):
    """Where emitters, or groups of them, are and how they shine."""

    low: Array
    """(n, 3) lower corners of boxes"""
    high: Array
    axis: Array
    """(n, 3) axes of cones of normals"""
    cosines: Array
    """(n, 2) of the half angles of these cones, and of the light about each normal"""
    strength: Array
    """(n,) intensities"""


def grow_tree(bounds: EmitterBounds, cdf: Array, far: NDArray[np.bool_]) -> LightTree | None:
    """Build a balanced tree by halving along the longest side; None where emitters are few.

    Parameters
    ----------
    bounds : of K emitters
    cdf : (K,) CDF of the emitters where they are chosen regardless of the point
    far : (K,) bool, infinitely far
    """
    near = np.flatnonzero(~far)
    if len(near) < FEW:
        return None
    leaves = 1 << (len(near) - 1).bit_length()
    emitter = np.full(leaves, near[0], np.int32)
    emitter[: len(near)] = near[_order(0.5 * (bounds.low + bounds.high)[near], leaves)]
    leaf = np.full(len(far), -1, np.int32)
    leaf[emitter[: len(near)]] = np.arange(len(near))
    empty = np.arange(leaves) >= len(near)
    level = EmitterBounds(
        np.where(empty[:, None], np.inf, bounds.low[emitter]),
        np.where(empty[:, None], -np.inf, bounds.high[emitter]),
        bounds.axis[emitter],
        np.where(empty[:, None], 2.0, bounds.cosines[emitter]),
        np.where(empty, 0.0, bounds.strength[emitter]),
    )
    nodes = np.zeros((2 * leaves, 10))
    while True:
        _write(nodes, level)
        if len(level.strength) == 1:
            break
        level = _join(level)
    return LightTree(nodes, emitter, leaf, *_share_out(cdf, far))


def reweigh(tree: LightTree, weights: Array, cdf: Array) -> LightTree:
    """Recone a tree whose emitters' strengths are multiplied by weights, (K,)."""
    nodes, leaves = tree.nodes.copy(), len(tree.emitter)
    strength = nodes[:, NODE_STRENGTH]
    strength[leaves:] *= weights[tree.emitter]
    for node in range(leaves - 1, 0, -1):
        strength[node] = strength[2 * node] + strength[2 * node + 1]
    near, far = _share_out(cdf, tree.leaf < 0)
    return tree._replace(nodes=nodes, near=near, far=far)


def _share_out(cdf: Array, far: NDArray[np.bool_]) -> tuple[float, Array]:
    """Recone the probability of all near emitters, and the CDF of the far ones."""
    probabilities = probabilities_of(cdf)
    return float(probabilities[~far].sum()), make_cdf(np.where(far, probabilities, 0.0))


def _order(center: Array, leaves: int) -> NDArray[np.int64]:
    """Recone emitters in the order of a complete tree's leaves, the empty ones last."""
    order, width = np.arange(len(center)), leaves
    while width > 1:
        part = np.arange(len(order)) // width
        starts = np.arange(0, len(order), width)
        placed = center[order]
        sides = np.maximum.reduceat(placed, starts) - np.minimum.reduceat(placed, starts)
        along = placed[np.arange(len(order)), sides.argmax(axis=1)[part]]
        order = order[np.lexsort((along, part))]
        width //= 2
    return order


def _write(nodes: Array, level: EmitterBounds) -> None:
    """Write a level of the tree to its rows of nodes."""
    strength = level.strength
    rows = nodes[len(strength) : 2 * len(strength)]
    full = (strength > 0.0)[:, None]
    low, high = np.where(full, level.low, 0.0), np.where(full, level.high, 0.0)
    rows[:, NODE_CENTER : NODE_CENTER + 3] = 0.5 * (low + high)
    rows[:, NODE_AXIS : NODE_AXIS + 3] = level.axis
    rows[:, NODE_SQUARED_RADIUS] = 0.25 * ((high - low) ** 2).sum(axis=1)
    rows[:, NODE_STRENGTH] = strength
    rows[:, [NODE_CONE, NODE_REACH]] = level.cosines


def _join(level: EmitterBounds) -> EmitterBounds:
    """Join neighbours into the next level."""
    low, high, axis, cosines, strength = level
    axis, cone = _join_cones(axis, cosines[:, 0])
    return EmitterBounds(
        np.minimum(low[0::2], low[1::2]),
        np.maximum(high[0::2], high[1::2]),
        axis,
        np.stack([cone, np.minimum(cosines[0::2, 1], cosines[1::2, 1])], axis=1),
        strength[0::2] + strength[1::2],
    )


def _join_cones(axis: Array, cosine: Array) -> tuple[Array, Array]:
    """Recone cones around pairs of cones, as axes and cosines; a cosine above 1 is no cone.

    pbrt-v4, 3.8.4.
    """
    a, b = axis[0::2], axis[1::2]
    first, second = np.arccos(np.minimum(cosine, 1.0)).reshape(-1, 2).T
    between = np.arccos(np.clip((a * b).sum(axis=1), -1.0, 1.0))
    angle = 0.5 * (first + between + second)
    cone = angle - first
    sine = np.maximum(np.sin(between), 1e-12)[:, None]
    joined = (np.sin(between - cone)[:, None] * a + np.sin(cone)[:, None] * b) / sine
    whole = (angle >= np.pi) | (between > np.pi - 1e-6)
    holds_second = (np.minimum(between + second, np.pi) <= first) | (cosine[1::2] > 1.0)
    holds_first = np.minimum(between + first, np.pi) <= second
    axis = np.where(holds_second[:, None] | whole[:, None], a, joined)
    axis = np.where((holds_first & ~holds_second)[:, None], b, axis)
    angle = np.where(whole, np.pi, angle)
    angle = np.where(holds_first, second, angle)
    angle = np.where(holds_second, first, angle)
    return axis, np.where(cosine[0::2] > 1.0, 2.0, np.cos(angle))
