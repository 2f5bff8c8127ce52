"""Read BSDFs as materials, and note what is not simulated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from photonmap.io.readers.decoding import SHEEN
from photonmap.io.readers.mitsuba_parts.albedos import (
    base_albedo,
    coat_albedo,
    metal_reflectance,
    plastic_albedo,
    scaled_normal,
)
from photonmap.io.readers.mitsuba_parts.colors import (
    as_rgb,
    changed,
    combined,
    index_of,
    metal_reflectances,
    read_paint,
    read_plain,
    read_scalar,
    read_texture,
)
from photonmap.io.readers.mitsuba_parts.nodes import Context, Node
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
_BOTH_SIDES = ("twosided", "dielectric", "roughdielectric", "thindielectric", "null")
_WRAPPERS = ("mask", "bumpmap", "normalmap", "blendbsdf")
_LOBES = ("diff_trans", "flatness", "spec_tint")
"""Of principled surfaces, not simulated where they are not 0"""
_SHEEN, _SHEEN_ROUGHNESS = 0.11, 0.4
"""Colour and roughness of the sheen here that comes nearest a principled one of 1, which is
(1 - cos)⁵ of the angle to the half vector: it reflects as much of the light from all around, 1.2%,
and at angles of light about as much, but for 9% of that (root mean square)"""
LIKE_AIR = 1e-3  # By how much an index of refraction may differ from 1 for air
_SAMPLING = "sample_visible"  # A parameter that changes noise alone


@dataclass
class Bsdfs:
    """The BSDFs of a scene, each read once."""

    context: Context  # what all parts of the reader share
    looks: dict[int, Look] = field(default_factory=dict)  # what is known of those read already
    materials: dict[int, Material] = field(default_factory=dict)
    one_sided: dict[int, bool] = field(default_factory=dict)

    def material(self, node: Node) -> Material:
        """Return the material that stands for a BSDF."""
        if id(node) not in self.materials:
            name = self.context.name("material", node)
            self.materials[id(node)] = Material(name, **self.look(node))
        return self.materials[id(node)]

    def look(self, node: Node) -> Look:
        """Return the attributes of the material that stands for a BSDF."""
        if id(node) not in self.looks:
            if node.type not in _TYPES:
                raise node.unknown(_TYPES)
            self.looks[id(node)] = _TYPES[node.type](self, node)
            node.read.add(_SAMPLING)
            self.context.lose_unread(node)
        return self.looks[id(node)]

    def is_one_sided(self, node: Node) -> bool:
        """Return whether a BSDF is black from behind."""
        if id(node) not in self.one_sided:
            inner = node.parts("bsdf") if node.type in _WRAPPERS else []
            alone = node.type not in (*_BOTH_SIDES, *_WRAPPERS)
            self.one_sided[id(node)] = alone or any([*map(self.is_one_sided, inner)])
        return self.one_sided[id(node)]

    def inner(self, node: Node, count: int = 1) -> list[Node]:
        """Return the BSDFs that one contains, `count` of them."""
        found = node.parts("bsdf")
        if len(found) != count:
            wanted = "one bsdf" if count == 1 else f"{count} bsdfs"
            raise node.error(f"a {node.type} has {len(found)} bsdfs in it; give it {wanted}")
        return found


def _diffuse(bsdfs: Bsdfs, node: Node) -> Look:
    name = "diffuse_reflectance" if node.find("diffuse_reflectance") else "reflectance"
    return {"reflectance": read_paint(bsdfs.context, node, name, 0.5)}


def _conductor(bsdfs: Bsdfs, node: Node) -> Look:
    """Return metal, or a mirror that reflects alike at all angles."""
    context = bsdfs.context
    specular = read_plain(context, node, "specular_reflectance", 1.0)
    metal = metal_reflectances(context, node)
    if node.type == "conductor":
        glossy, edge = (combined(np.multiply, specular, part) for part in metal)
        if metal[0] == 1.0:
            return {"reflectance": 0.0, "mirror": glossy}
        return {"reflectance": 0.0, "glossy": glossy, "glossy_edge": edge, "roughness": 0.0}
    roughness = _roughness_map(context, node)
    convert = metal_reflectance(mean_number(roughness) ** 2)
    glossy, edge = (combined(partial(convert, part), specular, *metal) for part in (0, 1))
    look = {"reflectance": 0.0, "glossy": glossy, "glossy_edge": edge, "roughness": roughness}
    return look | _stretch(context, node)


def _stretch(context: Context, node: Node) -> Look:
    """Return roughness and anisotropy of two α that differ, and are 1 at most."""
    if node.find("alpha_u") is None and node.find("alpha_v") is None:
        return {}
    alpha = read_scalar(context, node, "alpha", 0.1)
    along, across = (read_scalar(context, node, f"alpha_{axis}", alpha) for axis in "uv")
    if along == across:
        return {}
    if not 0.0 <= min(along, across) <= max(along, across) <= 1.0:
        context.lose("anisotropy with an alpha above 1", node)
        return {}
    return {**_stretched(along, across)}


def _stretched(along: float, across: float) -> dict[str, float]:
    """Return roughness and anisotropy of a lobe of these α, within [0, 1], where u and v rise."""
    low, high = sorted((along, across))
    strength = ((high - low) / max(1.0 - low, 1e-30)) ** 0.5
    look = {"roughness": low**0.5, "anisotropy": strength}
    return look | {"anisotropy_rotation": 0.25} if along < across else look


def _roughness_map(context: Context, node: Node) -> float | Texture:
    """Return the square root of α, of each texel of a texture; of two α, as `_roughness`."""
    paint = None if node.find("alpha_u") else read_paint(context, node, "alpha", 0.1, "index")
    if not isinstance(paint, Texture) or paint.largest > 1.0:
        return _roughness(context, node)
    _note_distribution(context, node)
    texture = changed(paint, np.sqrt)
    assert isinstance(texture, Texture)
    return texture


def _note_distribution(context: Context, node: Node) -> None:
    if node.text("distribution", "beckmann").lower() != "ggx":
        context.lose("Beckmann's distribution, with GGX in its place,", node)


def _roughness(context: Context, node: Node) -> float:
    """Return the square root of α, of the geometric mean of two."""
    _note_distribution(context, node)
    alpha = read_scalar(context, node, "alpha", 0.1)
    along, across = (read_scalar(context, node, f"alpha_{axis}", alpha) for axis in "uv")
    if along != across and node.type not in ("roughconductor", "roughdielectric"):
        context.lose("anisotropy", node)
    if min(along, across) < 0.0 or along * across > 1.0:
        raise node.error(f"alpha {shown(alpha)} is not a roughness from 0 to 1; correct it")
    return float((along * across) ** 0.25)


def _dielectric(bsdfs: Bsdfs, node: Node) -> Look:
    tint = read_plain(bsdfs.context, node, "specular_transmittance", 1.0)
    look = {"reflectance": 0.0, **_indices(node), "tint": tint}
    if node.type == "roughdielectric":
        look["roughness"] = _roughness(bsdfs.context, node)
        look |= _stretch(bsdfs.context, node)
    return look


def _indices(node: Node) -> Look:
    """Return the index inside, relative to air, and outside unless that is air."""
    inside, outside = index_of(node, "int_ior", "bk7"), index_of(node, "ext_ior", "air")
    if abs(outside - 1.0) < LIKE_AIR:
        return {"ior": inside / outside}
    return {"ior": inside, "outside": outside}


def _relative_index(node: Node, inside: str) -> float:
    return index_of(node, "int_ior", inside) / index_of(node, "ext_ior", "air")


def _thin(bsdfs: Bsdfs, node: Node) -> Look:
    tint = read_plain(bsdfs.context, node, "specular_transmittance", 1.0)
    if read_plain(bsdfs.context, node, "specular_reflectance", 1.0) != 1.0:
        bsdfs.context.lose("specular_reflectance of thin glass", node)
    index = _relative_index(node, "bk7")
    return {"reflectance": 0.0, "ior": index, "tint": tint, "thin": True}


def _plastic(bsdfs: Bsdfs, node: Node) -> Look:
    """Return a diffuse base below a coat."""
    context = bsdfs.context
    index = _relative_index(node, "polypropylene")
    specular = read_plain(context, node, "specular_reflectance", 1.0)
    glossy = combined(scaled_normal, specular, normal_reflectance(index))
    rough = _roughness_map(context, node) if node.type == "roughplastic" else 0.0
    normal = float(np.mean(as_rgb(glossy)))
    base = plastic_albedo(index, mean_number(rough) ** 2, node.flag("nonlinear", False), normal)
    diffuse = read_paint(context, node, "diffuse_reflectance", 0.5)
    return {"reflectance": changed(diffuse, base), "glossy": glossy, "roughness": rough}


def _principled(bsdfs: Bsdfs, node: Node) -> Look:
    """Return a surface that is a metal in part, or glass."""
    context = bsdfs.context
    paint = read_paint(context, node, "base_color", 0.5)
    transmission = _fraction(context, node, "spec_trans", 0.0)
    metallic = _fraction_map(context, node, "metallic", 0.0)
    roughness = _fraction_map(context, node, "roughness", 0.5)
    for name in _LOBES:
        if read_scalar(context, node, name, 0.0) != 0.0:
            context.lose(name, node)
    layer, sheen = _clear_coat(context, node), _sheen(context, node, paint, metallic)
    if sheen and (layer or transmission > 0.0):
        context.lose(SHEEN, node)
    elif sheen:
        layer = sheen
    coat = 0.08 * _fraction(context, node, "specular", 0.5)
    if node.find("eta"):
        coat = normal_reflectance(max(index_of(node, "eta", "bk7"), 1.0))
    share = transmission * (1.0 - mean_number(metallic))
    glass: Look = {}
    if share > 0.0:
        if "coat" in layer:
            context.lose("clearcoat", node)
        if isinstance(metallic, Texture):
            context.lose("texture of metallic", node)
        tint = changed(paint, np.sqrt)
        index = (1.0 + coat**0.5) / (1.0 - coat**0.5)
        glass = {"ior": index, "tint": tint, "roughness": roughness, "transmission": share}
        if share == 1.0:
            return glass | {"reflectance": 0.0} | _brush(context, node, roughness)
        metallic, layer = min(mean_number(metallic) / (1.0 - share), 1.0), {}
    if not lie_alike(paint, metallic):
        context.lose("texture of metallic", node)
    gloss = metallic_gloss(paint, metallic, coat, roughness)
    normal = float(np.mean(as_rgb(mean_color(gloss.glossy))))
    outside = coat_albedo(normal, mean_number(roughness) ** 2)
    base = changed(gloss.reflectance, lambda albedo: base_albedo(albedo, outside))
    look = gloss._replace(reflectance=base)._asdict() | layer | glass
    return look | _brush(context, node, roughness)


def _brush(context: Context, node: Node, roughness: float | Texture) -> Look:
    """Return roughness and anisotropy of a principled surface that is anisotropic."""
    anisotropic = _fraction(context, node, "anisotropic", 0.0)
    if anisotropic == 0.0:
        return {}
    if isinstance(roughness, Texture):
        context.lose("texture of roughness beside anisotropic", node)
        roughness = mean_number(roughness)
    alpha, aspect = roughness**2, (1.0 - 0.9 * anisotropic) ** 0.5
    return {**_stretched(min(alpha / aspect, 1.0), alpha * aspect)}


def _clear_coat(context: Context, node: Node) -> Look:
    """Return the clear coat of a principled surface, whose lobe is wider at its foot there."""
    weight = 0.25 * _fraction(context, node, "clearcoat", 0.0)
    shine = _fraction(context, node, "clearcoat_gloss", 0.0)
    alpha = 0.1 + shine * (0.001 - 0.1)
    return {"coat": weight, "coat_roughness": alpha**0.5} if weight else {}


def _sheen(context: Context, node: Node, base: Paint, metallic: float | Texture) -> Look:
    """Return the sheen of a principled surface that is no metal, in the mean tint of its base."""
    amount = _fraction(context, node, "sheen", 0.0) * (1.0 - mean_number(metallic))
    tint = _fraction(context, node, "sheen_tint", 0.0)
    if amount == 0.0:
        return {}
    color = np.asarray(as_rgb(mean_color(base)), float)
    level = float(color @ np.array(LUMINANCE))
    hue = color / level if level > 0.0 else np.ones(3)
    red, green, blue = np.clip(_SHEEN * amount * (1.0 + tint * (hue - 1.0)), 0.0, 1.0).tolist()
    return {"sheen": (red, green, blue), "sheen_roughness": _SHEEN_ROUGHNESS}


def _fraction(context: Context, node: Node, name: str, default: float) -> float:
    value = read_scalar(context, node, name, default)
    if not 0.0 <= value <= 1.0:
        raise node.error(f"{name} {value:g} is not within [0, 1]; correct it")
    return value


def _fraction_map(context: Context, node: Node, name: str, default: float) -> float | Texture:
    """Return a fraction that may be a texture."""
    paint = read_paint(context, node, name, default, "index")
    if isinstance(paint, Texture) and paint.largest <= 1.0:
        return paint
    return _fraction(context, node, name, default)


def _two_sided(bsdfs: Bsdfs, node: Node) -> Look:
    parts = node.parts("bsdf")
    if len(parts) == 2:
        bsdfs.context.lose("another back side", node)
        return bsdfs.look(parts[0])
    return bsdfs.look(bsdfs.inner(node)[0])


def _mask(bsdfs: Bsdfs, node: Node) -> Look:
    """Return a surface with holes."""
    opacity = read_paint(bsdfs.context, node, "opacity", 0.5)
    look = bsdfs.look(bsdfs.inner(node)[0])
    if "alpha" in look:
        bsdfs.context.lose("opacity of what a mask contains", node)
    if not isinstance(opacity, Texture):
        opacity = read_scalar(bsdfs.context, node, "opacity", 0.5)
    return look | {"alpha": opacity}


def _relief(bsdfs: Bsdfs, node: Node) -> Look:
    """Return the surface with its normals, or with heights times `scale`."""
    context = bsdfs.context
    found, factor = node.parts("texture"), node.number("scale", 1.0)
    look = bsdfs.look(bsdfs.inner(node)[0])
    if len(found) != 1:
        raise node.error(f"a {node.type} has {len(found)} textures in it; give it one")
    image = read_texture(context, found[0], "index")
    if not isinstance(image, Texture) or factor == 0.0:
        return look
    if "relief" in look:
        context.lose("one relief on another", node)
    is_bumps = node.type == "bumpmap"
    relief = BumpMap(image, factor) if is_bumps else NormalMap(image)
    if problem := relief.find_conflict():
        raise node.error(problem)
    return look | {"relief": relief}


def _blend(bsdfs: Bsdfs, node: Node) -> Look:
    weight = _fraction(bsdfs.context, node, "weight", 0.5)
    one, other = (bsdfs.look(part) for part in bsdfs.inner(node, 2))
    look, lost = blended(one, other, weight)
    for what in lost:
        bsdfs.context.lose(what, node)
    return look


def _null(bsdfs: Bsdfs, node: Node) -> Look:
    """Return a surface that nothing meets."""
    return {"reflectance": 0.0, "alpha": 0.0}


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
    if _OF_SHEEN[0] in {*one, *other}:
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
    if _OF_SHEEN[0] in rest:
        lost.append("sheen of a blend")
    rest = {name: value for name, value in rest.items() if name not in (*_STRETCH, *_OF_SHEEN)}
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
    means = mean_color(one), mean_color(other)
    return combined(lambda a, b: (1.0 - weight) * a + weight * b, *means)


_TYPES: dict[str, Callable[[Bsdfs, Node], Look]] = {
    "diffuse": _diffuse,
    "roughdiffuse": _diffuse,
    "conductor": _conductor,
    "roughconductor": _conductor,
    "dielectric": _dielectric,
    "roughdielectric": _dielectric,
    "thindielectric": _thin,
    "plastic": _plastic,
    "roughplastic": _plastic,
    "principled": _principled,
    "twosided": _two_sided,
    "mask": _mask,
    "bumpmap": _relief,
    "normalmap": _relief,
    "blendbsdf": _blend,
    "null": _null,
}
