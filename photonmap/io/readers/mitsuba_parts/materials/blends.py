"""Mix two surfaces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from photonmap.io.readers.mitsuba_parts.colors import combined
from photonmap.scene.textures import Paint, Texture, mean_color, mean_number
from photonmap.spectra.curves import Color

Look = dict[str, Any]
"""Attributes of a `Material`, without its name"""
_OF_METAL = ("glossy", "glossy_edge", "roughness")
_STRETCH = ("anisotropy", "anisotropy_rotation")
_SHEEN = ("sheen", "sheen_roughness")


def blended(one: Look, other: Look, weight: float) -> tuple[Look, list[str]]:
    """Return a surface that is one to 1 - weight and another to weight, and what is lost of them.

    Parameters
    ----------
    one, other : attributes of a `Material`; with a reflectance
    weight : in [0, 1]
    """
    if weight in (0.0, 1.0):
        return (other if weight else one), []
    (one, lost), (other, more) = _without_angles(one), _without_angles(other)
    look, losses = _mix(one, other, weight)
    return look, list(dict.fromkeys(lost + more + losses))


def _without_angles(look: Look) -> tuple[Look, list[str]]:
    """Return polished metal as a mirror, which may lie over what is diffuse, and what is lost."""
    if "glossy_edge" not in look or look["roughness"] != 0.0:
        return look, []
    kept = {name: value for name, value in look.items() if name not in _OF_METAL}
    lost = "reflectance of smooth metals that varies with the angle"
    return kept | {"mirror": look["glossy"]}, [lost]


def _mix(one: Look, other: Look, weight: float) -> tuple[Look, list[str]]:
    """Return what `blended` does of surfaces that both count."""
    heavier = other if weight > 0.5 else one
    if ("ior" in one) != ("ior" in other):
        pair = (one, other, 1.0 - weight) if "ior" in one else (other, one, weight)
        if not {"mirror", "diffuse_roughness", "coat", "alpha"} & {*one, *other}:
            return _partly_glass(*pair)
    if "ior" in one or "ior" in other:
        return heavier, ["the lesser part of a blend with glass"]
    if {"mirror", "glossy"} <= {*one, *other}:
        return heavier, ["the lesser part of a blend of a mirror and a glossy surface"]
    lost: list[str] = []
    look: Look = {
        "reflectance": _mixed_paint(one["reflectance"], other["reflectance"], weight, lost)
    }
    for name in {"mirror", "glossy"} & {*one, *other}:
        look[name] = _mixed_paint(one.get(name, 0.0), other.get(name, 0.0), weight, lost)
    glossy = [part for part in (one, other) if "glossy" in part]
    if glossy and all("glossy_edge" in part for part in glossy):
        first, last = (part.get("glossy_edge", 0.0) for part in (one, other))
        look["glossy_edge"] = _mixed_paint(first, last, weight, lost)
    if "glossy" in look:
        look["roughness"] = _mixed_roughness(one, other, weight, lost)
    if _STRETCH[0] in {*one, *other}:
        lost.append("anisotropy of a blend")
    if _SHEEN[0] in {*one, *other}:
        lost.append("sheen of a blend")
    alphas = one.get("alpha", 1.0), other.get("alpha", 1.0)
    if alphas != (1.0, 1.0):
        if any(isinstance(alpha, Texture) for alpha in alphas):
            lost.append("textures of a blend")
        look["alpha"] = float(np.dot([1.0 - weight, weight], [*map(mean_number, alphas)]))
    return look, lost


def _partly_glass(glass: Look, rest: Look, share: float) -> tuple[Look, list[str]]:
    """Return a surface of which a share is glass, and what is lost of the rest."""
    lost: list[str] = []
    if "glossy" in rest and rest["roughness"] != glass.get("roughness", 0.0):
        lost.append("two degrees of roughness")
    if "glossy" in rest and any(rest.get(name) != glass.get(name) for name in _STRETCH):
        lost.append("two degrees of anisotropy")
    if _SHEEN[0] in rest:
        lost.append("sheen of a blend")
    rest = {name: value for name, value in rest.items() if name not in (*_STRETCH, *_SHEEN)}
    if "transmission" in glass:
        return glass, ["the lesser part of a blend with glass"]
    return rest | glass | {"reflectance": rest["reflectance"], "transmission": share}, lost


def _mixed_roughness(one: Look, other: Look, weight: float, lost: list[str]) -> float | Texture:
    """Return the one degree of roughness of two surfaces, one of which may have none."""
    degrees = [surface["roughness"] for surface in (one, other) if "roughness" in surface]
    if degrees[0] is degrees[-1]:
        return degrees[0]
    if degrees[0] != degrees[-1]:
        lost.append("two degrees of roughness")
    first, last = mean_number(degrees[0]), mean_number(degrees[-1])
    return float((1.0 - weight) * first + weight * last)


def _mixed_paint(one: Paint, other: Paint, weight: float, lost: list[str]) -> Paint:
    """Return a mixture of colours, or of one texture and black; of means otherwise."""
    for texture, color, part in ((one, other, 1.0 - weight), (other, one, weight)):
        if isinstance(texture, Texture) and color in (0.0, (0.0, 0.0, 0.0)):
            red, green, blue = (part * factor for factor in texture.factor)
            return replace(texture, factor=(red, green, blue))
    if isinstance(one, Texture) or isinstance(other, Texture):
        lost.append("textures of a blend")
    return _mixed(mean_color(one), mean_color(other), weight)


def _mixed(one: Color, other: Color, weight: float) -> Color:
    return combined(lambda a, b: (1.0 - weight) * a + weight * b, one, other)
