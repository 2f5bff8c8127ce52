"""Read BSDFs as materials, and note what is not simulated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from photonmap.io.readers.decoding import SHEEN, plain
from photonmap.io.readers.mitsuba import albedos, colors
from photonmap.io.readers.mitsuba.nodes import Node, once
from photonmap.kernels.core.color import LUMINANCE
from photonmap.runtime.wording import shown
from photonmap.scene.material import Material
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.metallic import metallic_gloss
from photonmap.scene.surfaces.relief import BumpMap, NormalMap
from photonmap.scene.textures import Paint, Texture, lie_alike, mean_color, mean_number

Look = dict[str, Any]  # Attributes of a `Material`, without its name
_OF_METAL = ("glossy", "glossy_edge", "roughness")
_STRETCH = ("anisotropy", "anisotropy_rotation")
_OF_SHEEN = ("sheen", "sheen_roughness")
_OF_COAT = {"coat_roughness": "roughness of a coat", "coat_ior": "refraction of a coat"}
_BOTH_SIDES = ("twosided", "dielectric", "roughdielectric", "thindielectric", "null")
_WRAPPERS = ("mask", "bumpmap", "normalmap", "blendbsdf")
_LOBES = ("diff_trans", "flatness", "spec_tint")
"""Of principled surfaces, not simulated where they are not 0"""
_SHEEN, _SHEEN_ROUGHNESS = 0.11, 0.4
"""Colour and roughness of the sheen here that comes nearest a principled one of 1, which is
(1 - cos)⁵ of the angle to the half vector: it reflects as much of the light from all around, 1.2%,
and at angles of light about as much, but for 9% of that (root mean square)"""
_GREY = 1e-3  # By how much the channels of a grey may differ
LIKE_AIR = 1e-3  # By how much an index of refraction may differ from 1 for air


@once
def read_material(node: Node) -> Material:
    """Return the material that stands for a BSDF."""
    return Material(node.unique_name("material"), **read_look(node))


@once
def read_look(node: Node) -> Look:
    """Return the attributes of the material that stands for a BSDF."""
    if node.type not in _TYPES:
        raise node.unknown(_TYPES)
    look = _TYPES[node.type](node)
    node.read.add("sample_visible")  # which changes noise alone
    node.lose_unread()
    return look


@once
def is_one_sided(node: Node) -> bool:
    """Return whether a BSDF is black from behind."""
    if node.type in _WRAPPERS:
        return any([*map(is_one_sided, node.parts("bsdf"))])
    return node.type not in _BOTH_SIDES


def _inner(node: Node, count: int = 1) -> list[Look]:
    """Return the looks of the BSDFs that one contains, `count` of them."""
    found = node.parts("bsdf")
    if len(found) != count:
        wanted = "one bsdf" if count == 1 else f"{count} bsdfs"
        raise node.error(f"a {node.type} has {len(found)} bsdfs in it; give it {wanted}")
    return [read_look(part) for part in found]


def _diffuse(node: Node) -> Look:
    name = "diffuse_reflectance" if node.find("diffuse_reflectance") else "reflectance"
    return {"reflectance": colors.read_paint(node, name, 0.5)}


def _conductor(node: Node) -> Look:
    specular = colors.read_plain(node, "specular_reflectance", 1.0)
    metal = colors.metal_reflectances(node)
    if node.type == "conductor":
        glossy, edge = (colors.combined(np.multiply, specular, part) for part in metal)
        if metal[0] == 1.0:
            return {"reflectance": 0.0, "mirror": glossy}
        return {"reflectance": 0.0, "glossy": glossy, "glossy_edge": edge, "roughness": 0.0}
    roughness = _roughness_map(node)
    convert = albedos.metal_reflectance(mean_number(roughness) ** 2)
    glossy, edge = (colors.combined(partial(convert, part), specular, *metal) for part in (0, 1))
    look = {"reflectance": 0.0, "glossy": glossy, "glossy_edge": edge, "roughness": roughness}
    return look | _stretch(node)


def _alphas(node: Node) -> list[float]:
    alpha = colors.read_scalar(node, "alpha", 0.1)
    return [colors.read_scalar(node, f"alpha_{axis}", alpha) for axis in "uv"]


def _stretch(node: Node) -> Look:
    """Return roughness and anisotropy of two α that differ, and are 1 at most."""
    along, across = _alphas(node)
    if along == across:
        return {}
    if not 0.0 <= min(along, across) <= max(along, across) <= 1.0:
        node.lose("anisotropy with an alpha above 1")
        return {}
    return _stretched(along, across)


def _stretched(along: float, across: float) -> Look:
    """Return roughness and anisotropy of a lobe of these α, within [0, 1], where u and v rise."""
    low, high = sorted((along, across))
    strength = ((high - low) / max(1.0 - low, 1e-30)) ** 0.5
    look = {"roughness": low**0.5, "anisotropy": strength}
    return look | {"anisotropy_rotation": 0.25} if along < across else look


def _roughness_map(node: Node) -> float | Texture:
    """Return the square root of α, of each texel of a texture; of two α, as `_roughness`."""
    paint = None if node.find("alpha_u") else colors.read_paint(node, "alpha", 0.1, "index")
    if not isinstance(paint, Texture) or paint.largest > 1.0:
        return _roughness(node)
    _note_distribution(node)
    texture = colors.changed(paint, np.sqrt)
    assert isinstance(texture, Texture)
    return texture


def _note_distribution(node: Node) -> None:
    if node.text("distribution", "beckmann").lower() != "ggx":
        node.lose("Beckmann's distribution, with GGX in its place,")


def _roughness(node: Node) -> float:
    """Return the square root of α, of the geometric mean of two."""
    _note_distribution(node)
    along, across = _alphas(node)
    if along != across and node.type not in ("roughconductor", "roughdielectric"):
        node.lose("anisotropy")
    if min(along, across) < 0.0 or along * across > 1.0:
        alpha = colors.read_scalar(node, "alpha", 0.1)
        raise node.error(f"alpha {shown(alpha)} is not a roughness from 0 to 1; correct it")
    return float((along * across) ** 0.25)


def _dielectric(node: Node) -> Look:
    tint = colors.read_plain(node, "specular_transmittance", 1.0)
    inside = colors.index_of(node, "int_ior", "bk7")
    outside = colors.index_of(node, "ext_ior", "air")
    if abs(outside - 1.0) < LIKE_AIR:
        look: Look = {"reflectance": 0.0, "ior": inside / outside, "tint": tint}
    else:
        look = {"reflectance": 0.0, "ior": inside, "outside": outside, "tint": tint}
    if node.type == "roughdielectric":
        look["roughness"] = _roughness(node)
        look |= _stretch(node)
    return look


def _relative_index(node: Node, inside: str) -> float:
    return colors.index_of(node, "int_ior", inside) / colors.index_of(node, "ext_ior", "air")


def _thin(node: Node) -> Look:
    tint = colors.read_plain(node, "specular_transmittance", 1.0)
    if colors.read_plain(node, "specular_reflectance", 1.0) != 1.0:
        node.lose("specular_reflectance of thin glass")
    index = _relative_index(node, "bk7")
    return {"reflectance": 0.0, "ior": index, "tint": tint, "thin": True}


def _plastic(node: Node) -> Look:
    """Return a base below a lobe of `specular_reflectance`: a coat that covers so much of it.

    A coloured one becomes gloss, which is white at grazing angles.
    """
    index = _relative_index(node, "polypropylene")
    specular = colors.read_plain(node, "specular_reflectance", 1.0)
    rough = _roughness_map(node) if node.type == "roughplastic" else 0.0
    levels, normal, weight = colors.as_rgb(specular), normal_reflectance(index), 1.0
    if np.ptp(levels) > _GREY:
        node.lose("the colour of specular_reflectance at grazing angles")
        look: Look = {"glossy": colors.combined(lambda part: part * normal, specular)}
        look["roughness"], normal = rough, float(levels.mean()) * normal
    elif (weight := float(levels.mean())) < 1.0 - _GREY:
        ior = max(index, 1.0 / index)
        look = {"coat": weight, "coat_roughness": rough, "coat_ior": ior} if weight else {}
    else:
        look = {"glossy": normal, "roughness": rough}
    base = albedos.plastic_albedo(
        index, mean_number(rough) ** 2, node.flag("nonlinear", False), normal, weight
    )
    diffuse = colors.read_paint(node, "diffuse_reflectance", 0.5)
    return look | {"reflectance": colors.changed(diffuse, base)}


def _principled(node: Node) -> Look:
    paint = colors.read_paint(node, "base_color", 0.5)
    transmission = _fraction(node, "spec_trans", 0.0)
    metallic = _fraction_map(node, "metallic", 0.0)
    roughness = _fraction_map(node, "roughness", 0.5)
    for name in _LOBES:
        if colors.read_scalar(node, name, 0.0) != 0.0:
            node.lose(name)
    layer, sheen = _clear_coat(node), _sheen(node, paint, metallic)
    if sheen and (layer or transmission > 0.0):
        node.lose(SHEEN)
    elif sheen:
        layer = sheen
    coat = 0.08 * _fraction(node, "specular", 0.5)
    if node.find("eta"):
        coat = normal_reflectance(max(colors.index_of(node, "eta", "bk7"), 1.0))
    share = transmission * (1.0 - mean_number(metallic))
    glass: Look = {}
    if share > 0.0:
        if "coat" in layer:
            node.lose("clearcoat")
        if isinstance(metallic, Texture):
            node.lose("texture of metallic")
        tint = colors.changed(paint, np.sqrt)
        index = (1.0 + coat**0.5) / (1.0 - coat**0.5)
        glass = {"ior": index, "tint": tint, "roughness": roughness, "transmission": share}
        if share == 1.0:
            return glass | {"reflectance": 0.0} | _brush(node, roughness)
        metallic, layer = min(mean_number(metallic) / (1.0 - share), 1.0), {}
    if not lie_alike(paint, metallic):
        node.lose("texture of metallic")
    gloss = metallic_gloss(paint, metallic, coat, roughness)
    outside = albedos.coat_albedo(coat, mean_number(roughness) ** 2)
    rest = 1.0 if isinstance(metallic, Texture) else max(1.0 - metallic, 1e-9)
    base = colors.changed(
        gloss.reflectance, lambda albedo: rest * albedos.base_albedo(albedo / rest, outside)
    )
    look = gloss._replace(reflectance=base)._asdict() | layer | glass
    return look | _brush(node, roughness)


def _brush(node: Node, roughness: float | Texture) -> Look:
    """Return roughness and anisotropy of a principled surface that is anisotropic."""
    anisotropic = _fraction(node, "anisotropic", 0.0)
    if anisotropic == 0.0:
        return {}
    if isinstance(roughness, Texture):
        node.lose("texture of roughness beside anisotropic")
        roughness = mean_number(roughness)
    alpha, aspect = roughness**2, (1.0 - 0.9 * anisotropic) ** 0.5
    return _stretched(min(alpha / aspect, 1.0), alpha * aspect)


def _clear_coat(node: Node) -> Look:
    """Return the clear coat of a principled surface, whose lobe is wider at its foot there."""
    weight = 0.25 * _fraction(node, "clearcoat", 0.0)
    shine = _fraction(node, "clearcoat_gloss", 0.0)
    alpha = 0.1 + shine * (0.001 - 0.1)
    return {"coat": weight, "coat_roughness": alpha**0.5} if weight else {}


def _sheen(node: Node, base: Paint, metallic: float | Texture) -> Look:
    """Return the sheen of a principled surface that is no metal, in the mean tint of its base."""
    amount = _fraction(node, "sheen", 0.0) * (1.0 - mean_number(metallic))
    tint = _fraction(node, "sheen_tint", 0.0)
    if amount == 0.0:
        return {}
    color = np.asarray(colors.as_rgb(mean_color(base)), float)
    level = float(color @ np.array(LUMINANCE))
    hue = color / level if level > 0.0 else np.ones(3)
    sheen = plain(np.clip(_SHEEN * amount * (1.0 + tint * (hue - 1.0)), 0.0, 1.0))
    return {"sheen": sheen, "sheen_roughness": _SHEEN_ROUGHNESS}


def _fraction(node: Node, name: str, default: float) -> float:
    value = colors.read_scalar(node, name, default)
    if not 0.0 <= value <= 1.0:
        raise node.error(f"{name} {value:g} is not within [0, 1]; correct it")
    return value


def _fraction_map(node: Node, name: str, default: float) -> float | Texture:
    paint = colors.read_paint(node, name, default, "index")
    if isinstance(paint, Texture) and paint.largest <= 1.0:
        return paint
    return _fraction(node, name, default)


def _two_sided(node: Node) -> Look:
    parts = node.parts("bsdf")
    if len(parts) == 2:
        node.lose("another back side")
        return read_look(parts[0])
    return _inner(node)[0]


def _mask(node: Node) -> Look:
    opacity = colors.read_paint(node, "opacity", 0.5)
    look = _inner(node)[0]
    if "alpha" in look:
        node.lose("opacity of what a mask contains")
    if not isinstance(opacity, Texture):
        opacity = colors.read_scalar(node, "opacity", 0.5)
    return look | {"alpha": opacity}


def _relief(node: Node) -> Look:
    found, factor = node.parts("texture"), node.number("scale", 1.0)
    look = _inner(node)[0]
    if len(found) != 1:
        raise node.error(f"a {node.type} has {len(found)} textures in it; give it one")
    image = colors.read_texture(found[0], "index")
    if not isinstance(image, Texture) or factor == 0.0:
        return look
    if "relief" in look:
        node.lose("one relief on another")
    relief = BumpMap(image, factor) if node.type == "bumpmap" else NormalMap(image)
    if problem := relief.find_conflict():
        raise node.error(problem)
    return look | {"relief": relief}


def _blend(node: Node) -> Look:
    weight = _fraction(node, "weight", 0.5)
    one, other = _inner(node, 2)
    look, lost = blended(one, other, weight)
    for what in lost:
        node.lose(what)
    return look


def blended(one: Look, other: Look, weight: float) -> tuple[Look, list[str]]:
    """Return a surface that is one to 1 - weight and another to weight, and what is lost of them.

    one, other : attributes of a `Material`; with a reflectance
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
    if "mirror" in {*one, *other} and {"glossy", "coat"} & {*one, *other}:
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
        look["covering"] = _mixed_covering(one, other, weight)
        look["roughness"] = _mixed_number("roughness", one, other, weight, lost)
    if "coat" in {*one, *other}:
        look |= _mixed_coat(one, other, weight, lost)
    if _STRETCH[0] in {*one, *other}:
        lost.append("anisotropy of a blend")
    if _OF_SHEEN[0] in {*one, *other}:
        lost.append("sheen of a blend")
    alphas = one.get("alpha", 1.0), other.get("alpha", 1.0)
    if alphas != (1.0, 1.0):
        if any(isinstance(alpha, Texture) for alpha in alphas):
            lost.append("textures of a blend")
        look["alpha"] = float(np.dot([1.0 - weight, weight], [*map(mean_number, alphas)]))
    return look, lost


def _mixed_covering(one: Look, other: Look, weight: float) -> float | None:
    """Return what lies over what is diffuse in a mixture; None where nothing is."""
    over, below = 0.0, 0.0
    for look, part in ((one, 1.0 - weight), (other, weight)):
        lobe, covering = look.get("glossy", 0.0), look.get("covering")
        if np.any(colors.as_rgb(mean_color(look["reflectance"]))):
            whole = np.mean(colors.as_rgb(mean_color(lobe))) if covering is None else covering
            over, below = over + part * float(whole), below + part
    return over / below if below > 0.0 else None


def _partly_glass(glass: Look, rest: Look, share: float) -> tuple[Look, list[str]]:
    """Return a surface of which a share is glass, and what is lost of the rest."""
    lost: list[str] = []
    if "glossy" in rest and rest["roughness"] != glass.get("roughness", 0.0):
        lost.append("two degrees of roughness")
    if "glossy" in rest and any(rest.get(name) != glass.get(name) for name in _STRETCH):
        lost.append("two degrees of anisotropy")
    if _OF_SHEEN[0] in rest:
        lost.append("sheen of a blend")
    rest = {name: value for name, value in rest.items() if name not in (*_STRETCH, *_OF_SHEEN)}
    if "transmission" in glass:
        return glass, ["the lesser part of a blend with glass"]
    return rest | glass | {"reflectance": rest["reflectance"], "transmission": share}, lost


def _mixed_coat(one: Look, other: Look, weight: float, lost: list[str]) -> Look:
    """Return the coat that lies over a blend, of two surfaces or one."""
    part = (1.0 - weight) * one.get("coat", 0.0) + weight * other.get("coat", 0.0)
    given = [name for name in _OF_COAT if name in {*one, *other}]
    return {"coat": part} | {name: _mixed_number(name, one, other, weight, lost) for name in given}


def _mixed_number(
    name: str, one: Look, other: Look, weight: float, lost: list[str]
) -> float | Texture:
    """Return the one number, such as roughness, of two surfaces, one of which may have none."""
    degrees = [surface[name] for surface in (one, other) if name in surface]
    if degrees[0] is degrees[-1]:
        return degrees[0]
    if degrees[0] != degrees[-1]:
        lost.append(f"two degrees of {_OF_COAT.get(name, name)}")
    first, last = mean_number(degrees[0]), mean_number(degrees[-1])
    return float((1.0 - weight) * first + weight * last)


def _mixed_paint(one: Paint, other: Paint, weight: float, lost: list[str]) -> Paint:
    """Return a mixture of colours, or of one texture and black; of means otherwise."""
    for texture, color, part in ((one, other, 1.0 - weight), (other, one, weight)):
        if isinstance(texture, Texture) and color in (0.0, (0.0, 0.0, 0.0)):
            return replace(texture, factor=plain(part * factor for factor in texture.factor))
    if isinstance(one, Texture) or isinstance(other, Texture):
        lost.append("textures of a blend")
    means = mean_color(one), mean_color(other)
    return colors.combined(lambda a, b: (1.0 - weight) * a + weight * b, *means)


_TYPES: dict[str, Callable[[Node], Look]] = {
    **dict.fromkeys(("diffuse", "roughdiffuse"), _diffuse),
    **dict.fromkeys(("conductor", "roughconductor"), _conductor),
    **dict.fromkeys(("dielectric", "roughdielectric"), _dielectric),
    "thindielectric": _thin,
    **dict.fromkeys(("plastic", "roughplastic"), _plastic),
    "principled": _principled,
    "twosided": _two_sided,
    "mask": _mask,
    **dict.fromkeys(("bumpmap", "normalmap"), _relief),
    "blendbsdf": _blend,
    "null": lambda node: {"reflectance": 0.0, "alpha": 0.0},  # which nothing meets
}
