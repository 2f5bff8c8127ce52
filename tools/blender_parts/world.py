"""The world: a dome where it is even, or else a map as Cycles sees it, with suns of a size."""

import math
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from blender_parts.draft import Draft, color_of, output_of, upstream, value_of
from blender_parts.lights import Sun

WIDTH = 2048
"""Pixels across a map, unless an image of the world has more."""
SAMPLES = 16
"""Of each pixel of a map; and the root of that of each pixel at the edge of a sun."""
PRECISION = 4096
"""Steps between a power of 2 and the next in a map."""
NAME = "world"


def add_world(draft: Draft, suns: Sequence[Sun]) -> None:
    """Add the light of the world and of suns that have a size."""
    color = _even_color(draft)
    if color is not None and not suns:
        if color.any():
            draft.light("dome", NAME, radiance=color)
        return
    sky = _bake(draft.scene.world) if color is None else np.tile(color, (WIDTH // 2, WIDTH, 1))
    for sun in suns:
        sky += _disk(sky.shape[0], sun)
    path = draft.out.with_name(f"{draft.out.name}_{NAME}.exr")
    _save(path, sky)
    draft.light("environment", NAME, file=path.name)


def _even_color(draft: Draft) -> np.ndarray | None:
    """Return the radiance of a world that is the same all around; None if it is not."""
    world = draft.scene.world
    output = output_of(world.node_tree, "OUTPUT_WORLD") if world else None
    if output is None:
        return np.zeros(3)
    if output.inputs["Volume"].is_linked:
        draft.lose("volume", world.name)
    surface = output.inputs["Surface"]
    if not surface.is_linked:
        return np.zeros(3)
    shader = surface.links[0].from_node
    if shader.type != "BACKGROUND" or any(socket.is_linked for socket in shader.inputs):
        return None
    return color_of(shader, "Color") * value_of(shader, "Strength")


def _bake(world: Any) -> np.ndarray:
    """Return the radiance of a world, (H, 2H, 3), the first row around the top."""
    surface = output_of(world.node_tree, "OUTPUT_WORLD").inputs["Surface"]
    images = [node.image for node in upstream(surface) if node.type == "TEX_ENVIRONMENT"]
    width = max([WIDTH, *(image.size[0] for image in images if image)])
    scene, data = bpy.data.scenes.new("bake"), bpy.data.cameras.new("bake")
    camera = bpy.data.objects.new("bake", data)
    camera.matrix_world = Matrix.Rotation(math.pi / 2.0, 4, "X")  # looks along +y: -z with y up
    scene.collection.objects.link(camera)
    scene.camera, scene.world = camera, world
    scene.render.resolution_x, scene.render.resolution_y = width, width // 2
    try:
        return _render(scene, data)
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(data)


def _render(scene: Any, camera: Any) -> np.ndarray:
    """Return a picture of all that is around a camera."""
    scene.render.engine = "CYCLES"
    camera.type = "PANO"
    holder = camera if hasattr(camera, "panorama_type") else camera.cycles
    holder.panorama_type = "EQUIRECTANGULAR"
    scene.cycles.samples, scene.cycles.use_denoising = SAMPLES, False
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.filter_size = 1.0
    scene.render.resolution_percentage = 100
    _choose_exr(scene)
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "sky.exr")
        bpy.ops.render.render(write_still=True, scene=scene.name)
        image = bpy.data.images.load(scene.render.filepath)
        image.colorspace_settings.name = "Non-Color"
        values = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(values)
        width, height = image.size
        bpy.data.images.remove(image)
    return values.reshape(height, width, 4)[::-1, :, :3].astype(np.float64)


def _disk(height: int, sun: Sun) -> np.ndarray:
    """Return a sky of one sun, whose irradiance on what faces it is as given."""
    edges = np.pi * np.arange(height + 1) / height
    solid = (np.cos(edges[:-1]) - np.cos(edges[1:])) * np.pi / height
    part = (np.arange(SAMPLES) + 0.5) / SAMPLES
    sky, total = np.zeros((height, 2 * height)), 0.0
    for row in range(height):
        polar = np.pi * (row + part) / height
        if abs(np.mean(polar) - np.arccos(sun.towards.z)) > sun.angle + np.pi / height:
            continue
        turned = np.pi * (np.arange(2 * height)[:, None] + part) / height
        x, y, z = np.sin(turned - np.pi), np.cos(turned - np.pi), np.cos(polar)[:, None, None]
        flat = sun.towards.x * x + sun.towards.y * y
        cosine = np.sin(polar)[:, None, None] * flat + sun.towards.z * z
        inside = cosine >= math.cos(0.5 * sun.angle)
        sky[row] = inside.mean(axis=(0, 2))
        total += float((cosine * inside).mean(axis=(0, 2)).sum() * solid[row])
    return sky[..., None] * (sun.irradiance / total)


def _save(path: Path, sky: np.ndarray) -> None:
    """Write a sky as OpenEXR, float32 with fewer digits, which are a third of the bytes."""
    height, width, _ = sky.shape
    image = bpy.data.images.new(NAME, width, height, float_buffer=True, is_data=True)
    pixels = np.ones((height, width, 4), np.float32)
    mantissa, exponent = np.frexp(sky[::-1])
    pixels[..., :3] = np.ldexp(np.round(mantissa * PRECISION) / PRECISION, exponent)
    image.pixels.foreach_set(pixels.ravel())
    scene = bpy.data.scenes.new("save")
    _choose_exr(scene)
    image.save_render(str(path), scene=scene)
    bpy.data.scenes.remove(scene)
    bpy.data.images.remove(image)


def _choose_exr(scene: Any) -> None:
    """Let a scene write linear float32, compressed without losses."""
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR", "32", "ZIP"
    scene.view_settings.view_transform = "Raw"
