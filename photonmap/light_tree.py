"""Build the tree from which direct light chooses among many emitters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.records import (
    NODE_AXIS,
    NODE_CENTER,
    NODE_REACH,
    NODE_SQUARED_RADIUS,
    NODE_STRENGTH,
    NODE_TURN,
    LightTree,
)

FEW = 8
"""Emitters at a finite distance below which a choice by power costs less than it loses."""

Array = NDArray[np.float64]


def grow_tree(
    low: Array,
    high: Array,
    axis: Array,
    cosines: Array,
    strength: Array,
    cumulative: Array,
    far: NDArray[np.bool_],
) -> LightTree | None:
    """Build a balanced tree by halving along the longest side; None where emitters are few.

    Parameters
    ----------
    low, high : (K, 3) boxes around the emitters
    axis : (K, 3) unit normals
    cosines : (K, 2) of the half angles of the cone of normals, and of the light about each
    strength : (K,) intensities
    cumulative : (K,) rises to 1 by the chances of emitters where all are chosen alike
    far : (K,) bool, infinitely far
    """
    near = np.flatnonzero(~far)
    if len(near) < FEW:
        return None
    leaves = 1 << (len(near) - 1).bit_length()
    emitter = np.full(leaves, near[0], np.int32)
    emitter[: len(near)] = near[_order(0.5 * (low + high)[near], leaves)]
    leaf = np.full(len(far), -1, np.int32)
    leaf[emitter[: len(near)]] = np.arange(len(near))
    empty = np.arange(leaves) >= len(near)
    level = (
        np.where(empty[:, None], np.inf, low[emitter]),
        np.where(empty[:, None], -np.inf, high[emitter]),
        axis[emitter],
        np.where(empty[:, None], 2.0, cosines[emitter]),
        np.where(empty, 0.0, strength[emitter]),
    )
    nodes = np.zeros((2 * leaves, 10))
    while True:
        _write(nodes, *level)
        if len(level[-1]) == 1:
            break
        level = _join(*level)
    return LightTree(nodes, emitter, leaf, *_share_out(cumulative, far))


def reweigh(tree: LightTree, weights: Array, cumulative: Array) -> LightTree:
    """Return a tree whose emitters' strengths are multiplied by weights, (K,)."""
    nodes, leaves = tree.nodes.copy(), len(tree.emitter)
    strength = nodes[:, NODE_STRENGTH]
    strength[leaves:] *= weights[tree.emitter]
    for node in range(leaves - 1, 0, -1):
        strength[node] = strength[2 * node] + strength[2 * node + 1]
    near, far = _share_out(cumulative, tree.leaf < 0)
    return tree._replace(nodes=nodes, near=near, far=far)


def _share_out(cumulative: Array, far: NDArray[np.bool_]) -> tuple[float, Array]:
    """Return the chance of all near emitters, and the rise of chances among the far ones."""
    chances = np.diff(cumulative, prepend=0.0)
    beyond = np.cumsum(np.where(far, chances, 0.0))
    return float(chances[~far].sum()), beyond / max(beyond[-1], 1e-300)


def _order(center: Array, leaves: int) -> NDArray[np.int64]:
    """Return emitters in the order of a complete tree's leaves, the empty ones last."""
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


def _write(
    nodes: Array, low: Array, high: Array, axis: Array, cosines: Array, strength: Array
) -> None:
    """Write a level of the tree to the rows that are its place."""
    rows = nodes[len(strength) : 2 * len(strength)]
    full = strength > 0.0
    low, high = np.where(full[:, None], low, 0.0), np.where(full[:, None], high, 0.0)
    rows[:, NODE_CENTER : NODE_CENTER + 3] = 0.5 * (low + high)
    rows[:, NODE_AXIS : NODE_AXIS + 3] = axis
    rows[:, NODE_SQUARED_RADIUS] = 0.25 * ((high - low) ** 2).sum(axis=1)
    rows[:, NODE_STRENGTH] = strength
    rows[:, [NODE_TURN, NODE_REACH]] = cosines


def _join(
    low: Array, high: Array, axis: Array, cosines: Array, strength: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Join neighbours into the next level."""
    axis, turn = _join_cones(axis, cosines[:, 0])
    return (
        np.minimum(low[0::2], low[1::2]),
        np.maximum(high[0::2], high[1::2]),
        axis,
        np.stack([turn, np.minimum(cosines[0::2, 1], cosines[1::2, 1])], axis=1),
        strength[0::2] + strength[1::2],
    )


def _join_cones(axis: Array, cosine: Array) -> tuple[Array, Array]:
    """Return cones around pairs of cones, as axes and cosines; a cosine above 1 is no cone.

    pbrt-v4, 3.8.4.
    """
    a, b = axis[0::2], axis[1::2]
    first, second = np.arccos(np.minimum(cosine, 1.0)).reshape(-1, 2).T
    between = np.arccos(np.clip((a * b).sum(axis=1), -1.0, 1.0))
    angle = 0.5 * (first + between + second)
    turn = angle - first
    sine = np.maximum(np.sin(between), 1e-12)[:, None]
    joined = (np.sin(between - turn)[:, None] * a + np.sin(turn)[:, None] * b) / sine
    whole = (angle >= np.pi) | (between > np.pi - 1e-6)
    holds_second = (np.minimum(between + second, np.pi) <= first) | (cosine[1::2] > 1.0)
    holds_first = np.minimum(between + first, np.pi) <= second
    axis = np.where(holds_second[:, None] | whole[:, None], a, joined)
    axis = np.where((holds_first & ~holds_second)[:, None], b, axis)
    angle = np.where(whole, np.pi, angle)
    angle = np.where(holds_first, second, angle)
    angle = np.where(holds_second, first, angle)
    return axis, np.where(cosine[0::2] > 1.0, 2.0, np.cos(angle))
