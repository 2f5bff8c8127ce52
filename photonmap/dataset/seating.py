"""Chairs, stools, armchairs and sofas, in metres, with their fronts towards +z."""

from __future__ import annotations

from photonmap.dataset.furniture import at
from photonmap.dataset.palette import Palette
from photonmap.dataset.shapes import Shape, box, cylinder, rotation
from photonmap.dataset.solids import Random, superquadric, tube
from photonmap.dataset.things import Part, Thing


def chair(palette: Palette) -> Thing:
    """Return a chair with slats in its back."""
    wood, seat = palette.wood(), palette.fabric()
    x, z, leg = 0.19, 0.18, 0.036
    parts = [at(box(leg, 0.43, leg), i * x, 0.0, z, wood) for i in (-1, 1)]
    parts += [at(box(leg, 0.88, leg), i * x, 0.0, -z, wood) for i in (-1, 1)]
    parts.append(at(box(0.43, 0.03, 0.41, 0.012), 0.0, 0.43, 0.005, wood))
    parts.append(at(box(0.4, 0.03, 0.36, 0.014), 0.0, 0.46, 0.02, seat))
    for y in (0.56, 0.68, 0.79):
        parts.append(at(box(2 * x - leg, 0.06, 0.018, 0.006), 0.0, y, -z, wood))
    parts += [at(box(2 * x - leg, 0.03, 0.02), 0.0, 0.2, k * z, wood) for k in (-1, 1)]
    return Thing("chair", parts)


def stool(palette: Palette) -> Thing:
    """Return a round stool on three legs."""
    wood = palette.wood()
    leg = tube([(0.17, 0.0, 0.0), (0.1, 0.44, 0.0)], 0.017, 16).resting()
    parts = [Part(leg.turned(120.0 * i + 30.0), wood) for i in range(3)]
    parts.append(at(cylinder(0.17, 0.035, 0.012), 0.0, 0.45, 0.0, palette.accent()))
    return Thing("stool", parts)


def sofa(rng: Random, palette: Palette, seats: int) -> Thing:
    """Return a sofa, or with one seat an armchair, with cushions."""
    cloth = palette.chip(None, (4, 6), (4, 8))
    wide, arm, deep = 0.62 * seats, 0.16, 0.82
    whole = wide + 2 * arm
    parts = [at(box(whole - 0.02, 0.26, deep - 0.02, 0.03, 3), 0.0, 0.06, 0.0, cloth)]
    parts.append(at(box(whole, 0.72, 0.2, 0.07, 4), 0.0, 0.08, -0.5 * deep + 0.1, cloth))
    side = box(arm, 0.5, deep - 0.2, 0.06, 4)
    parts += [at(side, i * 0.5 * (wide + arm), 0.08, 0.1, cloth) for i in (-1, 1)]
    feet = [(i * (0.5 * whole - 0.08), k * (0.5 * deep - 0.08)) for i in (-1, 1) for k in (-1, 1)]
    parts += [at(cylinder(0.025, 0.08, segments=24), x, 0.0, z, palette.grey(3)) for x, z in feet]
    for index in range(seats):
        x = (index - 0.5 * (seats - 1)) * 0.62
        parts.append(at(box(0.61, 0.15, 0.62, 0.05, 4), x, 0.31, 0.09, cloth))
    for x in (-0.5 * wide + 0.22, 0.5 * wide - 0.22)[: seats if seats < 3 else 2]:
        parts.append(Part(_leaning(rng).moved((x, 0.45, -0.06)), palette.accent()))
    return Thing("sofa" if seats > 1 else "armchair", parts)


def _leaning(rng: Random) -> Shape:
    """Return a cushion that leans back against a sofa."""
    shape = superquadric((0.4, 0.14, 0.4), 1.0, 0.35, 40, 64)
    matrix = rotation(68.0, 0)
    shape = Shape(shape.vertices @ matrix.T, shape.faces, shape.normals @ matrix.T)
    return shape.turned(float(rng.uniform(-12.0, 12.0))).resting()
