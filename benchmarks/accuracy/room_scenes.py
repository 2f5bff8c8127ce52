"""The twelve scenes of `benchmarks.accuracy.rooms`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

import photonmap as pm
from benchmarks.accuracy.matter import make_scene
from photonmap.dataset.models.shapes import knot
from photonmap.dataset.scenes.build import build_scene

Vector = tuple[float, float, float]

SQUARE, WIDE = (256, 256), (320, 240)
"""Sizes of images: of boxes, and of rooms from the data sets."""
ROOMS = ("living_room", "kitchen", "library", "pottery")
GREY = pm.Material("grey", (0.6, 0.6, 0.6))
STEPS = 1200
"""Rings of the knot, of 64 triangles each."""


def scenes() -> dict[str, tuple[Callable[[], pm.Scene], tuple[int, int]]]:
    """Return how to build each scene, and the usual size of its image, by name."""
    lit = {
        f"box-{light}": (lambda light=light: make_scene(light), SQUARE)
        for light in ("point", "sun", "dome", "sky")
    }
    rooms = {name: (lambda name=name: room(name), WIDE) for name in ROOMS}
    return {
        "box": (pm.scenes.cornell_box, SQUARE),
        **lit,
        "box-balls": (pm.scenes.cornell_balls, SQUARE),
        "studio": (studio, SQUARE),
        "corridor": (corridor, SQUARE),
        **rooms,
    }


def room(name: str) -> pm.Scene:
    """Return a room from the data sets whose windows are area lights as bright as the horizon.

    There they are portals to an overcast sky, for which Mitsuba has no counterpart.
    """
    scene = build_scene(name)
    skies = [light for light in scene.lights if isinstance(light, pm.OvercastLight)]
    if not skies:
        return scene
    pane = pm.Material("pane", 0.0, skies[0].radiance * (1.0 / 3.0))
    meshes = [replace(m, material=pane) if m.material.portal else m for m in scene.meshes]
    return replace(scene, meshes=meshes, lights=[])


def studio() -> pm.Scene:
    """Return a torus knot of 77 k triangles on a wide floor under a large lamp."""
    shape = knot(0.45, 0.11, steps=STEPS)
    clay = pm.Material("clay", (0.7, 0.45, 0.3))
    lamp = pm.Material("lamp", 0.0, (6.0, 6.0, 6.0))
    return pm.Scene(
        [
            pm.Mesh(shape.vertices, shape.faces, clay, "knot", shape.normals),
            quad((-4, 0, 4), (8, 0, 0), (0, 0, -6), GREY, "floor"),
            quad((-4, 0, -2), (8, 0, 0), (0, 5, 0), GREY, "backdrop"),
            quad((-1, 3, -1), (2, 0, 0), (0, 0, 2), lamp, "lamp"),
        ],
        camera=pm.Camera((0.6, 1.3, 3.4), (0.0, 0.6, 0.0), fov=35.0),
        name="studio",
    )


def corridor() -> pm.Scene:
    """Return a corridor 12 units long and 2 wide, lit at its far end, seen from the dark one."""
    lamp = pm.Material("lamp", 0.0, (20.0, 18.0, 15.0))
    red, blue = pm.Material("red", (0.6, 0.2, 0.15)), pm.Material("blue", (0.2, 0.3, 0.6))
    return pm.Scene(
        [
            quad((-1, 0, 6), (2, 0, 0), (0, 0, -12), GREY, "floor"),
            quad((-1, 2, -6), (2, 0, 0), (0, 0, 12), GREY, "ceiling"),
            quad((-1, 0, 6), (0, 0, -12), (0, 2, 0), red, "left"),
            quad((1, 0, -6), (0, 0, 12), (0, 2, 0), blue, "right"),
            quad((-1, 0, -6), (2, 0, 0), (0, 2, 0), GREY, "end"),
            quad((1, 0, 6), (-2, 0, 0), (0, 2, 0), GREY, "entrance"),
            quad((-0.4, 1.95, -5.5), (0.8, 0, 0), (0, 0, 0.8), lamp, "lamp"),
        ],
        camera=pm.Camera((0.2, 1.2, 5.5), (0.0, 0.9, -2.0), fov=50.0),
        name="corridor",
    )


def quad(
    corner: Sequence[float],
    along: Sequence[float],
    up: Sequence[float],
    material: pm.Material,
    name: str,
) -> pm.Mesh:
    """Return a parallelogram whose front is on the side of along × up."""
    a, b, c = (np.asarray(vector, float) for vector in (corner, along, up))
    return pm.Mesh(np.stack([a, a + b, a + b + c, a + c]), [[0, 1, 2], [0, 2, 3]], material, name)
