"""What stands in bathrooms, in metres, fronts towards +z."""

from __future__ import annotations

from photonmap.dataset.models import furniture
from photonmap.dataset.models.arrangements import Maker, draw_makers, place_at
from photonmap.dataset.models.curved_shapes import superquadric, tube
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import Part, Row, SceneObject, assembled, part_at
from photonmap.dataset.models.shapes import Random, box, cylinder, smooth_curve
from photonmap.dataset.models.vessels import COARSE, bowl_shape, hollow, pot_shape


def bathtub(rng: Random, palette: Palette) -> SceneObject:
    """Return a bathtub with a panel of another colour in front and a tap at its right end."""
    long, deep, tall, wall = float(rng.uniform(1.55, 1.8)), 0.75, 0.56, 0.07
    glaze, panel = palette.glazed(palette.grey(9)), palette.glazed(palette.pale())
    x, end = 0.5 * (long - wall), deep - 2 * wall + 0.02
    spout = tube([(0.0, 0.0, 0.0), (0.0, 0.16, 0.0), (-0.1, 0.18, 0.0)], 0.014, 16).resting()
    rows: list[Row] = [
        (box(long, tall, wall, 0.03, 4), (0.0, 0.0, 0.5 * (deep - wall)), glaze, "z"),
        (box(wall, tall, end, 0.03, 4), (x, 0.0, 0.0), glaze, "x"),
        (box(long - 0.1, 0.12, deep - 0.1), (0.0, 0.0, 0.0), glaze),
        (box(long - 0.08, tall - 0.14, 0.012), (0.0, 0.03, 0.5 * deep), panel),
        (spout, (x, tall, 0.0), palette.metal()),
    ]
    return assembled("bathtub", rows)


def toilet(palette: Palette) -> SceneObject:
    """Return a toilet with its cistern."""
    glaze, lid = palette.glazed(palette.grey(9)), palette.glazed(palette.pale())
    parts = [
        part_at(superquadric((0.24, 0.44, 0.42), 0.6, 0.6, 32, 48), 0.0, 0.0, -0.02, glaze),
        part_at(superquadric((0.37, 0.2, 0.5), 0.7, 0.7, 32, 48), 0.0, 0.22, 0.03, glaze),
        part_at(superquadric((0.36, 0.05, 0.48), 0.5, 0.7, 24, 48), 0.0, 0.4, 0.03, lid),
        part_at(box(0.38, 0.36, 0.17, 0.025, 3), 0.0, 0.42, -0.27, glaze),
        part_at(box(0.12, 0.02, 0.06, 0.006), 0.0, 0.78, -0.27, palette.metal()),
    ]
    return SceneObject("toilet", parts)


def washstand(rng: Random, palette: Palette) -> tuple[SceneObject, list[SceneObject]]:
    """Return a cupboard, and what stands on it: a basin and a tap behind it."""
    doors = int(rng.integers(1, 4))
    wide = max(0.62, doors * float(rng.uniform(0.38, 0.5)))
    stand = furniture.cabinet(palette, wide, float(rng.uniform(0.7, 0.8)), doors, 0.5)
    basin = bowl_shape(rng, float(rng.uniform(0.18, 0.21)), COARSE)
    bowl = SceneObject("basin", [Part(basin, palette.glazed(palette.grey(9)))])
    bowl = place_at(stand.supports[0], bowl, 0.5, 0.62)
    spout = tube([(0, 0, 0), (0, 0.2, 0), (0, 0.23, 0.05), (0, 0.21, 0.09)], 0.012, 24).resting()
    tap = SceneObject("tap", [Part(spout, palette.metal())])
    behind = float(bowl.bounds[0, 2]) - float(tap.bounds[1, 2]) - 0.005
    return stand, [bowl, tap.moved((0.0, stand.supports[0].y, behind))]


def towel_rail(rng: Random, palette: Palette) -> SceneObject:
    """Return a rail with one to three towels, its back at z = 0 and its foot at y = 0."""
    count = int(rng.integers(1, 4))
    wide = 0.34 * count + 0.08
    metal, y, z = palette.metal(), 0.62, 0.075
    rail = cylinder(0.009, wide, 0.002, 16).turned(90.0, 2).moved((0.5 * wide, 0.0, 0.0))
    parts = [part_at(rail, 0.0, y, z, metal)]
    arm = cylinder(0.009, z, 0.002, 16).turned(90.0, 0)
    parts += [part_at(arm, i * (0.5 * wide - 0.02), y, 0.0, metal) for i in (-1, 1)]
    for index in range(count):
        x, long = (index - 0.5 * (count - 1)) * 0.34, float(rng.uniform(0.4, 0.6))
        cloth, edge = palette.fabric(), palette.pale()
        towel = box(0.29, long, 0.034, 0.016, 3)
        parts.append(part_at(towel, x, y + 0.02 - long, z, cloth))
        parts.append(part_at(box(0.292, 0.05, 0.036, 0.017, 3), x, y + 0.06 - long, z, edge))
    return SceneObject("towel rail", parts)


def basket(rng: Random, palette: Palette) -> SceneObject:
    """Return a basket for laundry."""
    shape = pot_shape(rng, float(rng.uniform(0.4, 0.6)))
    return SceneObject("basket", [Part(shape, palette.wood())])


def soap_bottle(rng: Random, palette: Palette) -> SceneObject:
    """Return a bottle with a pump."""
    tall = float(rng.uniform(0.1, 0.15))
    outer = smooth_curve([(0.03, 0.0), (0.034, 0.01), (0.034, 0.8 * tall), (0.012, tall)], 14)
    neck = cylinder(0.008, 0.04, 0.002, 16)
    parts = [
        Part(hollow(outer, 0.003, 0.004, COARSE.segments), palette.glazed(palette.accent())),
        part_at(neck, 0.0, tall, 0.0, palette.grey(8)),
        part_at(box(0.014, 0.01, 0.05, 0.003), 0.0, tall + 0.04, 0.015, palette.grey(8)),
    ]
    return SceneObject("soap", parts)


def paper_roll(palette: Palette) -> SceneObject:
    """Return a roll of paper that stands."""
    return SceneObject("paper roll", [Part(cylinder(0.055, 0.1, 0.006, 32), palette.grey(9))])


def toiletries(rng: Random, palette: Palette, count: int) -> list[Maker]:
    """Return makers of small things that stand beside a basin."""

    def towel() -> SceneObject:
        folded = box(0.24, 0.07, 0.16, 0.02, 3)
        return SceneObject("towel", [Part(folded, palette.fabric())])

    makers: list[Maker] = [lambda: soap_bottle(rng, palette), lambda: paper_roll(palette), towel]
    return draw_makers(rng, makers, count)
