"""Lights: points, spots and suns of the TOML file; those that have a size become meshes."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import bpy
import numpy as np
from mathutils import Matrix, Vector

from blender_parts.draft import Draft, color_of, output_of, toml, turn, value_of

SHARP_SUN = 0.02
"""Angle of a sun, radians, up to which its light is parallel; others become part of the sky."""
SIDES = 64
"""Of the polygons that stand for disks and ellipses."""
RINGS = 16
"""Of spheres, along half a turn."""


class Sun(NamedTuple):
    """A sun that has a size."""

    towards: Vector
    irradiance: np.ndarray
    angle: float


def add_lights(draft: Draft) -> list[Sun]:
    """Add all lights but suns of a size, which are returned: they belong into the sky."""
    suns = []
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        item = instance.object
        if item.type != "LIGHT" or item.original.hide_render:
            continue
        light, name = item.data, _unused_name(item.name)
        matrix, amount = instance.matrix_world.copy(), _amount(draft, light, name)
        behind = matrix.col[2].xyz.normalized()
        is_ball = light.type == "POINT" and light.shadow_soft_size > 0.0
        if light.type == "SUN" and light.angle > SHARP_SUN:
            suns.append(Sun(behind, amount, light.angle))
        elif light.type == "SUN":
            if light.angle > 0.0:
                draft.lose(f"penumbra ({math.degrees(light.angle):.2f}°)", name)
            draft.light("directional", name, direction=turn(-behind), irradiance=amount)
        elif light.type == "AREA" or is_ball:
            if not item.visible_camera:
                draft.lose("invisibility to the camera", name)
            add = _add_area if light.type == "AREA" else _add_ball
            add(draft, name, light, matrix, amount)
        else:
            _add_point(draft, name, light, matrix, amount)
    return suns


def _unused_name(wanted: str) -> str:
    """Return a name for a light that no material has."""
    name = wanted
    while name in bpy.data.materials:
        name += " light"
    return name


def _amount(draft: Draft, light: Any, name: str) -> np.ndarray:
    """Return the power of a light, W, or the irradiance of a sun, W/m²: (3,)."""
    color = np.array(light.color[:])
    if getattr(light, "use_temperature", False):
        color *= light.temperature_color[:]
    energy = light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    if light.use_nodes:
        output = output_of(light.node_tree, "OUTPUT_LIGHT")
        links = output.inputs["Surface"].links if output else ()
        shader = links[0].from_node if links else None
        if shader is None or shader.type != "EMISSION" or any(i.is_linked for i in shader.inputs):
            draft.lose("nodes", name)
        else:
            color, energy = color * color_of(shader, "Color"), energy * value_of(shader, "Strength")
    return color * energy


def _add_point(draft: Draft, name: str, light: Any, matrix: Matrix, amount: np.ndarray) -> None:
    """Add a point or a spot: of P watts, P / 4π in W·sr⁻¹, whatever its cone."""
    place, intensity = matrix.translation, amount / (4.0 * math.pi)
    if light.type == "POINT":
        draft.light("point", name, position=turn(place), intensity=intensity)
        return
    if light.shadow_soft_size > 0.0:
        draft.lose("size of a spot", name)
    outer = 0.5 * light.spot_size
    edge = math.cos(outer) + (1.0 - math.cos(outer)) * light.spot_blend
    draft.light(
        "spot",
        name,
        position=turn(place),
        target=turn(place - matrix.col[2].xyz.normalized()),
        intensity=intensity,
        inner=math.degrees(math.acos(min(edge, 1.0))),
        outer=math.degrees(outer),
    )


def _add_area(draft: Draft, name: str, light: Any, matrix: Matrix, amount: np.ndarray) -> None:
    """Add the mesh of an area light, whose power leaves its front."""
    if light.spread < math.pi - 1e-3:
        draft.lose("spread", name)
    across = down = light.size
    if light.shape in ("RECTANGLE", "ELLIPSE"):
        down = light.size_y
    if light.shape in ("SQUARE", "RECTANGLE"):
        outline = [(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)]
    else:
        step = 2.0 * math.pi / SIDES
        radius = 0.5 * math.sqrt(step / math.sin(step))  # of the same area
        angles = [-step * side for side in range(SIDES)]
        outline = [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
    corners = [matrix @ Vector((across * x, down * y, 0.0)) for x, y in outline]
    if matrix.determinant() < 0.0:
        corners.reverse()
    _add_mesh(draft, name, (corners, [range(len(corners))]), light.normalize, amount)


def _add_ball(draft: Draft, name: str, light: Any, matrix: Matrix, amount: np.ndarray) -> None:
    """Add the sphere of a point light that has a size."""
    radius, n = light.shadow_soft_size, 2 * RINGS
    polar, turned = np.pi * np.arange(1, RINGS) / RINGS, 2.0 * np.pi * np.arange(n) / n
    ring = np.stack([np.cos(turned), np.sin(turned), 0.0 * turned], axis=1)
    rings = [np.sin(p) * ring + [0.0, 0.0, np.cos(p)] for p in polar]
    units = np.concatenate([*rings, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    at, after = np.arange(n), (np.arange(n) + 1) % n
    last, top = (RINGS - 2) * n, (RINGS - 1) * n
    faces = [(top, i, j) for i, j in zip(at, after, strict=True)]
    faces += [(top + 1, last + j, last + i) for i, j in zip(at, after, strict=True)]
    for first in range(0, last, n):
        quads = (first + at, first + n + at, first + n + after, first + after)
        faces += list(zip(*quads, strict=True))
    corners = (np.array(matrix.translation) + radius * units).tolist()
    _add_mesh(draft, name, (corners, faces), light.normalize, amount)


def _add_mesh(
    draft: Draft,
    name: str,
    shape: tuple[Sequence[Any], Sequence[Any]],
    is_power: bool,
    amount: np.ndarray,
) -> None:
    """Add a black mesh that emits its power evenly, or else an amount per square unit."""
    mesh = bpy.data.meshes.new(name)
    corners, faces = shape
    mesh.from_pydata(corners, [], [[int(corner) for corner in face] for face in faces])
    area = sum(polygon.area for polygon in mesh.polygons) if is_power else 1.0
    material = bpy.data.materials.new(name)
    mesh.materials.append(material)
    item = bpy.data.objects.new(name, mesh)
    draft.scene.collection.objects.link(item)
    draft.undo += [lambda: bpy.data.materials.remove(material)]
    draft.undo += [lambda: bpy.data.meshes.remove(mesh)]
    draft.section(
        f"[material.{toml(material.name)}]",
        reflectance=0.0,
        glossy=0.0,
        emission=amount / (math.pi * area),
    )
