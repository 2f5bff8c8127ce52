"""The choice of an emitter for the light at a point, by the irradiance that it may send there."""

import math

from photonmap.kernels import vec, warp
from photonmap.kernels.jit import jit
from photonmap.kernels.lamp import TINY, look_at, sent_by
from photonmap.kernels.light_tree import BELOW_ONE, chance_of_leaf, descend
from photonmap.kernels.records import DIRECTIONAL, DOME, SPOT, TRIANGLE

BY_POWER = 0.1
"""Share of choices by power alone: an emitter that would send much may be hidden."""
FEW = 16
"""Emitters that are all looked at for each point."""


@jit
def _reach(geometry, lights, emitter, point, ns):
    """Estimate the irradiance at a point that an emitter of power 1 would send, unless blocked."""
    kind = lights.kind[emitter]
    if kind == TRIANGLE:
        return warp.INV_PI * sent_by(look_at(geometry, lights.triangle[emitter], point, ns))
    if kind == DOME:
        return 0.25 * warp.INV_PI / (lights.radius * lights.radius)
    axis = vec.row(lights.axis, emitter)
    if kind == DIRECTIONAL:
        return max(-vec.dot(ns, axis), 0.0) * warp.INV_PI / (lights.radius * lights.radius)
    step = vec.sub(vec.row(lights.position, emitter), point)
    squared = max(vec.dot(step, step), TINY)
    reach = max(vec.dot(ns, step), 0.0) / (squared * math.sqrt(squared))
    if kind != SPOT:
        return reach * warp.uniform_sphere_pdf()
    outer = lights.cosines[emitter, 1]
    inside = -vec.dot(axis, step) > outer * math.sqrt(squared)
    return reach * warp.uniform_cone_pdf(outer) if inside else 0.0


@jit
def _choose_of_few(geometry, lights, point, ns, u):
    """Go through all emitters: (emitter, chance, u renewed)."""
    cumulative = lights.cumulative
    if len(cumulative) == 1:
        return 0, 1.0, u
    by_power = u < BY_POWER
    u = u / BY_POWER if by_power else (u - BY_POWER) / (1.0 - BY_POWER)
    chosen, power, light, powers, lit = -1, 0.0, 0.0, 0.0, 0.0
    for emitter in range(len(cumulative)):
        own_power = warp.discrete_pdf(cumulative, emitter)
        own = own_power * _reach(geometry, lights, emitter, point, ns)
        if own > 0.0:
            powers += own_power
            lit += own
            share = own_power / powers if by_power else own / lit
            if u < share:
                chosen, power, light, u = emitter, own_power, own, u / share
            else:
                u = (u - share) / (1.0 - share)
            u = min(u, BELOW_ONE)
    if chosen < 0:
        return -1, 0.0, u
    return chosen, BY_POWER * power / powers + (1.0 - BY_POWER) * light / lit, u


@jit
def _chance_of_few(geometry, lights, emitter, point, ns):
    """Return the probability of `_choose_of_few` to return an emitter."""
    power, light, powers, lit = 0.0, 0.0, 0.0, 0.0
    for other in range(len(lights.cumulative)):
        own_power = warp.discrete_pdf(lights.cumulative, other)
        own = own_power * _reach(geometry, lights, other, point, ns)
        if own > 0.0:
            powers += own_power
            lit += own
            if other == emitter:
                power, light = own_power, own
    if light == 0.0:
        return 1.0 if len(lights.cumulative) == 1 else 0.0
    return BY_POWER * power / powers + (1.0 - BY_POWER) * light / lit


@jit
def choose(geometry, lights, tree, point, ns, u):
    """Choose an emitter for the light at a point; return (emitter, chance, u renewed).

    emitter is -1 where none can reach it. Without a tree (None) more than FEW are chosen by power.
    """
    if tree is None:
        if len(lights.cumulative) <= FEW:
            return _choose_of_few(geometry, lights, point, ns, u)
        emitter, u = warp.discrete(lights.cumulative, u)
        return emitter, warp.discrete_pdf(lights.cumulative, emitter), u
    if u >= tree.near:
        emitter, u = warp.discrete(tree.far, (u - tree.near) / (1.0 - tree.near))
        return emitter, warp.discrete_pdf(lights.cumulative, emitter), u
    leaf, chance, u = descend(tree.nodes, point, ns, u / tree.near)
    if leaf < 0:
        return -1, 0.0, u
    return tree.emitter[leaf], tree.near * chance, u


@jit
def chance_of(geometry, lights, tree, emitter, point, ns):
    """Return the probability of `choose` to return an emitter."""
    if tree is None and len(lights.cumulative) <= FEW:
        return _chance_of_few(geometry, lights, emitter, point, ns)
    leaf = -1 if tree is None else tree.leaf[emitter]
    if leaf < 0:
        return warp.discrete_pdf(lights.cumulative, emitter)
    return tree.near * chance_of_leaf(tree.nodes, leaf, point, ns)
