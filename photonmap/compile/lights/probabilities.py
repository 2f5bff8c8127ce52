"""The probabilities of emitters, for photons and light samples, and the tree of many of them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.core import records
from photonmap.kernels.lights.selection import WIDTH
from photonmap.spectra.curves import Floats

EVEN = 0.1
"""Share of the probability that lights get evenly: a weak one may be all that lights the view."""
SELDOM = 0.01  # Factor on the probability of a light that seems to send nothing into the view
TREE_FROM = 8
"""Emitters at a finite distance below which a choice by power costs less than it loses."""
_HALVINGS = WIDTH.bit_length() - 1  # Levels of a binary tree that become one


def make_cdf(weights: Floats) -> Floats:
    """Return the CDF of weights along the last axis: from above 0 to exactly 1.

    Where all weights are 0, so is the CDF.
    """
    sums = np.cumsum(weights, axis=-1, dtype=np.float64)
    totals = sums[..., -1:]
    return np.minimum(sums / np.where(totals > 0.0, totals, 1.0), 1.0)


def probabilities_of(cdf: Floats) -> Floats:
    """Return the probabilities that a CDF is made of."""
    return np.diff(cdf, prepend=0.0)


def mix_uniform(flux: Floats, names: Sequence[str]) -> Floats:
    """Return the probabilities of K emitters, (K,): mostly by power, evenly for the rest.

    The flux is above 0; names are those of the lights that emitters belong to.
    """
    _, light = np.unique(np.array(names), return_inverse=True)
    of_light = np.bincount(light, flux)
    return (1.0 - EVEN) * flux / flux.sum() + EVEN * flux / of_light[light] / len(of_light)


def downweight_hidden(
    lights: records.Lights, names: Sequence[str], hidden: Collection[str]
) -> records.Lights:
    """Return lights among which those that seem hidden have a low probability.

    Not 0: a light may reach the view by paths that were not found.
    """
    rare = np.array([name in hidden for name in names])
    if not rare.any() or rare.all():
        return lights
    weights = np.where(rare, SELDOM, 1.0)
    cdf = make_cdf(weights * probabilities_of(lights.cdf))
    tree = reweigh(lights.tree, weights, cdf) if lights.tree else None
    return lights._replace(cdf=cdf, tree=tree)


class EmitterBounds(NamedTuple):
    """Where emitters, or groups of them, are and how they shine."""

    low: Floats  # (n, 3) lower corners of boxes
    high: Floats
    axis: Floats  # (n, 3) axes of cones of normals
    cosines: Floats  # (n, 2) of the half angles of these cones, and of the light about each normal
    strength: Floats  # (n,) intensities


def grow_tree(
    bounds: EmitterBounds, cdf: Floats, far: NDArray[np.bool_]
) -> records.LightTree | None:
    """Build a balanced tree by halving along the longest side; None where emitters are few.

    `cdf`, (K,), is that of the emitters where they are chosen regardless of the point; `far`, (K,),
    are infinitely far.
    """
    near = np.flatnonzero(~far)
    if len(near) < TREE_FROM:
        return None
    halvings = (len(near) - 1).bit_length()
    depth = -(-halvings // _HALVINGS)
    slots = np.arange(len(near)) << depth * _HALVINGS - halvings  # the lowest nodes are not full
    emitter = np.full(WIDTH**depth, near[0], np.int32)
    emitter[slots] = near[_order(0.5 * (bounds.low + bounds.high)[near], 1 << halvings)]
    leaf = np.full(len(far), -1, np.int32)
    leaf[emitter[slots]] = slots
    empty = np.ones(len(emitter), bool)
    empty[slots] = False
    level = EmitterBounds(
        np.where(empty[:, None], np.inf, bounds.low[emitter]),
        np.where(empty[:, None], -np.inf, bounds.high[emitter]),
        bounds.axis[emitter],
        np.where(empty[:, None], 2.0, bounds.cosines[emitter]),
        np.where(empty, 0.0, bounds.strength[emitter]),
    )
    nodes = np.zeros((_blocks_above(len(emitter)), records.NODE_REACH + 1, WIDTH))
    while len(level.strength) > 1:
        _write(nodes, level)
        for _ in range(_HALVINGS):
            level = _join(level)
    return records.LightTree(nodes, emitter, leaf, *_share_out(cdf, far))


def reweigh(tree: records.LightTree, weights: Floats, cdf: Floats) -> records.LightTree:
    """Return a tree whose emitters' strengths are multiplied by weights, (K,)."""
    nodes = tree.nodes.copy()
    strength = _of_level(nodes, len(tree.emitter))[:, records.NODE_STRENGTH].ravel()
    strength *= weights[tree.emitter]
    while len(strength) > 1:
        _of_level(nodes, len(strength))[:, records.NODE_STRENGTH] = strength.reshape(-1, WIDTH)
        strength = strength.reshape(-1, WIDTH).sum(axis=1)
    near, far = _share_out(cdf, tree.leaf < 0)
    return tree._replace(nodes=nodes, near=near, far=far)


def _blocks_above(count: int) -> int:
    """Return how many blocks are above a level of so many nodes, its own blocks among them."""
    return (count - 1) // (WIDTH - 1)


def _of_level(nodes: Floats, count: int) -> Floats:
    """Return the blocks of a level of so many nodes, (count / WIDTH, 11, WIDTH), as a view."""
    return nodes[_blocks_above(count // WIDTH) : _blocks_above(count)]


def _share_out(cdf: Floats, far: NDArray[np.bool_]) -> tuple[float, Floats]:
    """Return the probability of all near emitters, and the CDF of the far ones."""
    probabilities = probabilities_of(cdf)
    return float(probabilities[~far].sum()), make_cdf(np.where(far, probabilities, 0.0))


def _order(center: Floats, leaves: int) -> NDArray[np.int64]:
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


def _write(nodes: Floats, level: EmitterBounds) -> None:
    """Write a level of the tree to its blocks of nodes."""
    blocks = _of_level(nodes, len(level.strength))
    full = (level.strength > 0.0)[:, None]
    low, high = np.where(full, level.low, 0.0), np.where(full, level.high, 0.0)
    columns = {
        records.NODE_CENTER: 0.5 * (low + high),
        records.NODE_AXIS: level.axis,
        records.NODE_RADIUS: 0.5 * np.linalg.norm(high - low, axis=1),
        records.NODE_STRENGTH: level.strength,
        records.NODE_CONE: level.cosines[:, 0],
        records.NODE_CONE_SINE: np.sqrt(np.maximum(1.0 - level.cosines[:, 0] ** 2, 0.0)),
        records.NODE_REACH: level.cosines[:, 1],
    }
    for first, values in columns.items():
        values = values.reshape(len(blocks), WIDTH, -1).swapaxes(1, 2)
        blocks[:, first : first + values.shape[1]] = values


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


def _join_cones(axis: Floats, cosine: Floats) -> tuple[Floats, Floats]:
    """Return cones around pairs, as axes and cosines; above 1 is no cone (pbrt-v4, 3.8.4)."""
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
