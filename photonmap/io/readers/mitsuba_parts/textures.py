"""Read textures: images and checkerboards, and the colours that stand in their place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers.decoding import note_loss
from photonmap.io.readers.mitsuba_parts.colors import (
    COLOR_TAGS,
    Kind,
    as_rgb,
    combined,
    read_color,
)
from photonmap.io.readers.mitsuba_parts.context import Context
from photonmap.io.readers.mitsuba_parts.nodes import Node
from photonmap.io.readers.registry import GREY, OR_WITHOUT
from photonmap.runtime.wording import shown
from photonmap.scene.textures import Paint, Texture, mean_color, shared_image
from photonmap.spectra.curves import Color, Spectrum

_CHECKS = 256
"""Texels along a side of a checkerboard's image: its edges blur over one of them."""


def read_paint(
    context: Context, node: Node, name: str, default: Color, kind: Kind = "reflectance"
) -> Paint:
    """Return a parameter that is a colour or a texture.

    Raises
    ------
    InputError : it is neither, its image cannot be read, or a value is out of range
    """
    found = node.find(name)
    if found is None:
        return default
    if found.tag in COLOR_TAGS:
        return read_color(found, kind, context.files)
    if found.tag != "texture":
        raise found.error(f"{name} is a <{found.tag}>; give a colour or a texture")
    return read_texture(context, found, kind)


def read_texture(context: Context, found: Node, kind: Kind) -> Paint:
    """Return what a texture stands for: an image, or a colour.

    Raises
    ------
    InputError : its image cannot be read, or a value is out of range
    """
    if found.type == "bitmap":
        return _bitmap(context, found)
    if found.type == "checkerboard":
        return _checkerboard(context, found, kind)
    return read_color(found, kind, context.files)


def read_plain(
    context: Context, node: Node, name: str, default: Color, kind: Kind = "reflectance"
) -> Color:
    """Return a parameter that is simulated as a colour: the mean of a texture, which is noted."""
    paint = read_paint(context, node, name, default, kind)
    if isinstance(paint, Texture):
        context.lose(f"texture of {name}", node)
    return mean_color(paint)


def read_scalar(context: Context, node: Node, name: str, default: float) -> float:
    """Return a parameter that is simulated as a number: the mean of anything else."""
    color = read_plain(context, node, name, default, "index")
    return float(np.mean(as_rgb(color) if isinstance(color, Spectrum) else color))


def changed(paint: Paint, function: Callable[..., Any]) -> Paint:
    """Return what a function of numbers makes of a colour, or of each texel."""
    if not isinstance(paint, Texture):
        return combined(function, paint)
    linear = paint.image.linear(slice(None), slice(None)) * np.array(paint.factor, np.float32)
    texels = function(linear).astype(np.float32)
    return replace(Texture.of(texels), scale=paint.scale, offset=paint.offset, clamp=paint.clamp)


def _bitmap(context: Context, node: Node) -> Paint:
    """Return an image; grey if it is missing and that is allowed."""
    raw = node.flag("raw", False)
    if (filtered := node.text("filter_type", "bilinear")) == "nearest":
        context.lose(f"filter {shown(filtered)}", node)
    wrap = node.text("wrap_mode", "repeat")
    if wrap not in ("repeat", "clamp"):
        context.lose(f"wrap mode {shown(wrap)}", node)
    name = node.text("filename")
    try:
        image = shared_image(context.files.find(node.element, name), raw)
    except InputError as error:
        if context.missing_textures == "error":
            raise InputError(f"{error}{OR_WITHOUT}") from None
        note_loss(context.losses, "unreadable textures, with grey in their place,", name[:80])
        return GREY
    placed = _placement(context, node)
    context.lose_unread(node)
    return Texture(image, clamp=wrap == "clamp", **placed)


def _checkerboard(context: Context, node: Node, kind: Kind) -> Texture:
    """Return two colours in a pattern of 2 × 2."""
    highest = 1.0 if kind == "reflectance" else np.inf
    one, other = (
        np.minimum(as_rgb(read_plain(context, node, name, default, kind), kind), highest)
        for name, default in (("color0", 0.4), ("color1", 0.2))
    )
    index = np.arange(_CHECKS) >= _CHECKS // 2
    same = index[:, None] == index
    texels = np.where(same[..., None], one, other).astype(np.float32)
    placed = _placement(context, node)
    context.lose_unread(node)
    return Texture.of(texels, **placed)


def _placement(context: Context, node: Node) -> dict[str, Any]:
    """Return how a texture lies on a surface; Mitsuba's v counts downwards, ours upwards."""
    matrix = node.transform("to_uv")
    if matrix[0, 1] or matrix[1, 0]:
        context.lose("rotation of textures", node)
    # What stood in place of to_uv in Mitsuba 0.x
    du, dv = node.number("uoffset", 0.0), node.number("voffset", 0.0)
    u, v = node.number("uscale", 1.0), node.number("vscale", 1.0)
    scale = float(matrix[0, 0]) * u, float(matrix[1, 1]) * v
    shift = u * (float(matrix[0, 3]) + du), v * (float(matrix[1, 3]) + dv)
    return {"scale": scale, "offset": (shift[0], 1.0 - scale[1] - shift[1])}
