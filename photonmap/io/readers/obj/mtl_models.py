"""The materials that the statements of MTL files stand for, by their illumination models."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.io.readers.decoding import plain
from photonmap.io.readers.registry import GREY
from photonmap.kernels.core.color import LUMINANCE
from photonmap.scene.material import Material
from photonmap.scene.parameters import Number, parameters_of
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.metallic import USUAL_INDEX, Gloss, as_triple, metallic_gloss
from photonmap.scene.surfaces.relief import BumpMap, NormalMap
from photonmap.scene.textures import Paint, Texture, is_black, lie_alike
from photonmap.spectra.curves import Color, Spectrum
from photonmap.spectra.observer import radiance_to_rgb, reflectance_to_rgb

NUMBERS = {
    "Ns": Number("exponent", at_least=0.0),
    "Pr": Number("roughness", at_least=0.0, at_most=1.0),
    "Pm": Number("metallic fraction", at_least=0.0, at_most=1.0),
}
"""What statements of these keywords hold."""
USUAL_ROUGHNESS = 0.5  # Of a metal that gives none: Blender's default
BLENDER_RANGE = 0.08  # Reflectance at normal incidence at which Blender's specular is 1
_MIRRORS, _GLASSES = (3, 5), (4, 6, 7)
_DECIDED = ("Kd", "Ke", "Ks", "Ni", "Tf", "d")
"""Statements whose meaning depends on the illumination model."""


@dataclass
class Draft:
    """A material as far as it has been read."""

    blender: float = 0.0  # of Blender's files the `Ns` that stands for roughness 0; else 0
    colors: dict[str, Color] = field(default_factory=dict)  # `Kd`, `Ke`, `Ks`, `Tf`, `Ps`
    maps: dict[str, Texture | None] = field(default_factory=dict)  # None: a missing file
    # `map_Pr` and `map_Pm`, which replace `Pr` and `Pm`, and `map_Ns`, which multiplies `Ns`
    data: dict[str, Texture] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)  # of them `Tr` as 1 - Tr
    clamped: list[str] = field(default_factory=list)  # keywords of colours that were lowered to 1
    ignored: list[str] = field(default_factory=list)  # keywords of what is not simulated
    averaged: list[str] = field(default_factory=list)  # keywords of maps whose mean stands for them
    relief: NormalMap | BumpMap | None = None  # of `norm` or `bump`, and which of them
    relief_keyword: str = ""

    @property
    def is_metallic(self) -> bool:
        """Whether `Pr` or `Pm` makes it glossy, whatever `Ks` and `Ns` say."""
        return "Pr" in self.numbers or self.numbers.get("Pm", 0.0) != 0.0

    def number(self, keyword: str) -> float | Texture:
        """Return the texture that replaces a number, or else the number."""
        return self.data[keyword] if keyword in self.data else self.numbers[keyword]


def matters(color: Color, neutral: float = 0.0) -> bool:
    """Return whether a colour differs from the one that changes nothing."""
    if isinstance(color, Spectrum):
        return True
    return any(value != neutral for value in (color if isinstance(color, tuple) else (color,)))


def has_exponent(draft: Draft) -> bool:
    """Return whether a draft has a lobe of colour `Ks` and of the exponent `Ns`."""
    numbers = draft.numbers
    is_metallic = "Pr" in numbers or draft.blender > 0.0
    return numbers.get("illum", 2.0) == 2.0 and "Ns" in numbers and not is_metallic


def gloss_of(draft: Draft, albedo: Paint) -> Gloss | None:
    """Return the glossy lobe that a draft describes, over a base of this albedo; None if none.

    - With `Pr` or `Pm`, the metallic workflow: `Pm` of the surface is a metal of this colour, and
      the rest has a coat of index `Ni`.
    - From Blender's exporter, likewise: `Ks` is its specular, `Ns` stands for its roughness, and
      under `illum 3` and 6 `Ka` for its metallic.
    - Else, under `illum 2`, or none, with `Ks` and `Ns`, and their maps: a coat that reflects `Ks`
      at normal incidence, whose lobe is about as wide as Phong's of this exponent:
      α² = 2 / (Ns + 2), as in Walter et al. 2007, "Microfacet models for refraction through rough
      surfaces".

    Statements about gloss that have no effect are noted as ignored.
    """
    numbers, model = draft.numbers, draft.numbers.get("illum", 2.0)
    if draft.is_metallic:
        index = numbers.get("Ni", 1.0)  # 1 is what exporters write that know of no index
        if index < 1.0:
            draft.ignored.append("Ni")
        coat = normal_reflectance(index if index > 1.0 else USUAL_INDEX)
        metallic = draft.number("Pm") if "Pm" in numbers else 0.0
        roughness = _from_exponent(draft) if "Ns" in numbers else USUAL_ROUGHNESS
        roughness = draft.number("Pr") if "Pr" in numbers else roughness
        return _metallic(draft, albedo, metallic, coat, roughness)
    if draft.blender and model >= 2.0 and "Ns" in numbers:
        roughness = 1.0 - math.sqrt(min(numbers["Ns"] / draft.blender, 1.0))
        metallic = numbers.get("Ka", 0.0) if model in (3.0, 6.0) else 0.0
        specular = draft.colors.get("Ks", 0.0)
        mean = float(np.mean(specular)) if not isinstance(specular, Spectrum) else 0.5
        return _metallic(draft, albedo, metallic, BLENDER_RANGE * mean, roughness)
    if has_exponent(draft):
        glossy = _textured(draft)
        if glossy is not None:
            return Gloss(albedo, glossy, _from_exponent(draft))
        if "Ks" in draft.colors:
            return None
    if "Ns" in numbers and matters(draft.colors.get("Ks", 1.0)):
        draft.ignored.append("Ns")
    return None


def _metallic(
    draft: Draft, albedo: Paint, metallic: float | Texture, coat: float, roughness: float | Texture
) -> Gloss | None:
    """Return a surface that is a metal in part; None if it reflects diffusely alone."""
    if not lie_alike(albedo, metallic):
        draft.averaged.append("map_Pm")
    gloss = metallic_gloss(albedo, metallic, coat, roughness)
    return None if is_black(gloss.glossy) else gloss


def _textured(draft: Draft) -> Paint | None:
    """Return `Ks` times its map; None where it is 0 or there is neither."""
    color, texture = draft.colors.get("Ks"), draft.maps.get("map_Ks")
    if texture is None:
        return color if color is not None and matters(color) else None
    factor = as_triple(1.0 if color is None else color)
    return replace(texture, factor=factor) if any(factor) else None


def _from_exponent(draft: Draft) -> float | Texture:
    """Return the roughness of a lobe as wide as Phong's of the exponent `Ns` times its map."""
    exponent, texture = draft.numbers["Ns"], draft.data.get("Ns")
    if texture is None:
        return (2.0 / (exponent + 2.0)) ** 0.25
    share = texture.image.linear(slice(None), slice(None)) @ np.array(LUMINANCE)
    roughness = (2.0 / (exponent * share + 2.0)) ** 0.25
    return replace(texture, image=Texture.of(roughness).image)


def make_material(name: str, draft: Draft) -> Material:
    """Return the material that a draft describes; what it leaves out is noted as ignored.

    `illum` 3 and 5 with `Ks` are a mirror of that reflectance, over `Kd` where it is given; 4, 6
    and 7 with `Ni` are glass of roughness `Pr`, or smooth, tinted by `Tf` at each crossing; of
    Blender's files, what transmits is, see `_restate_blender_glass`. All others are diffuse, and
    glossy where `gloss_of` says so.
    Textures are multiplied by the colour or number they belong to, where it is given. The opacity
    `d` of glass is ignored: its transmittance is what one sees through it.
    """
    model = draft.numbers.get("illum", 1.0)
    is_glass = _restate_blender_glass(draft) if draft.blender else model in _GLASSES
    if is_glass and "Ni" in draft.numbers:
        return _make_glass(name, draft)
    colors = draft.colors
    light, albedo = _color_or_texture(draft, "Ke", 0.0), _color_or_texture(draft, "Kd", 0.0)
    if matters(colors.get("Tf", 1.0), 1.0):
        draft.ignored.append("Tf")
    if model in _MIRRORS and "Ks" in colors and not (draft.blender or draft.is_metallic):
        _note_index(draft)
        _leave_out_covers(draft)
        draft.ignored += _numbers(draft)
        _leave_out_anisotropy(draft)
        return Material(name, albedo, light, colors["Ks"], alpha=_alpha(draft), **_others(draft))
    is_given = "Kd" in colors or "map_Kd" in draft.maps
    reflectance = albedo if is_given else Material.reflectance
    gloss = gloss_of(draft, reflectance)
    if gloss is None and "glossy" not in colors and "map_glossy" not in draft.maps:
        _leave_out_anisotropy(draft)
    others = {"emission": light, "alpha": _alpha(draft), **_sheen(draft)}
    others |= _others(draft) | _own_maps(draft)
    if gloss is not None:
        return Material(name, **{**gloss._asdict(), **others})
    if matters(colors.get("Ks", 0.0)):
        draft.ignored.append("Ks")
    _note_index(draft)
    if not (0 <= model <= 2 or draft.blender):
        draft.ignored.append("illum")
    return Material(name, reflectance, **others)


def _numbers(draft: Draft) -> list[str]:
    """Return the statements about gloss that say more than that there is no metal."""
    numbers = draft.numbers
    return [key for key in NUMBERS if key in numbers and (key, numbers[key]) != ("Pm", 0.0)]


def _leave_out_anisotropy(draft: Draft) -> None:
    """Note that what is neither glossy nor glass is alike in all directions."""
    draft.numbers.pop("anisor", None)
    if draft.numbers.pop("aniso", 0.0) != 0.0:
        draft.ignored.append("aniso")


def _own_maps(draft: Draft) -> dict[str, Texture]:
    keys = {"glossy": "glossy", "roughness": "roughness", "coat": "Pc", "coat_roughness": "Pcr"}
    keys |= {name: name for name in ("transmission", "fluorescence_concentration")}
    maps = {attribute: draft.maps.get(f"map_{key}") for attribute, key in keys.items()}
    return {attribute: texture for attribute, texture in maps.items() if texture is not None}


def _leave_out_covers(draft: Draft) -> None:
    """Note that a mirror, or glass, gets no clear coat and no sheen."""
    is_coated = _has_coat(draft)
    for key in ("Pc", "Pcr"):
        if draft.numbers.pop(key, 0.0) != 0.0 and is_coated:
            draft.ignored.append(key)
        if draft.maps.pop(f"map_{key}", None) is not None and is_coated:
            draft.ignored.append(f"map_{key}")
    _leave_out_sheen(draft)


def _has_coat(draft: Draft) -> bool:
    return draft.numbers.get("Pc", 0.0) != 0.0 or "map_Pc" in draft.maps


def _leave_out_sheen(draft: Draft) -> None:
    draft.numbers.pop("sheen_roughness", None)
    has_map = "map_Ps" in draft.maps
    draft.maps.pop("map_Ps", None)
    if matters(draft.colors.pop("Ps", 1.0 if has_map else 0.0)):
        draft.ignored.append("map_Ps" if has_map else "Ps")


def _sheen(draft: Draft) -> dict[str, Any]:
    """Return the sheen, if there is one; below a clear coat it is left out."""
    if _has_coat(draft):
        _leave_out_sheen(draft)
    sheen = _color_or_texture(draft, "Ps", 1.0 if "map_Ps" in draft.maps else 0.0)
    draft.colors.pop("Ps", None)
    return {} if is_black(sheen) else {"sheen": sheen}


def _note_index(draft: Draft) -> None:
    """Note an index of refraction that has no effect, unless the surface is said not to shine."""
    reflects = matters(draft.colors.get("Ks", 1.0)) or "map_Ks" in draft.maps
    if draft.numbers.get("Ni", 1.0) != 1.0 and reflects and not draft.blender:
        draft.ignored.append("Ni")


def _restate_blender_glass(draft: Draft) -> bool:
    """Turn Blender's statements about what transmits into those of glass; return whether any does.

    With PBR extensions, `Tf` is the fraction of what is no metal that transmits, and each crossing
    takes the root of the base colour. Models 6 and 9 are those of metals and others with an
    opacity.
    """
    numbers, colors = draft.numbers, draft.colors
    share = float(np.max(as_triple(colors.pop("Tf", 0.0)))) * (1.0 - numbers.get("Pm", 0.0))
    if share == 0.0:
        return False
    colors["Tf"] = plain(np.sqrt(as_triple(colors.get("Kd", 1.0))))
    colors.pop("Ks", None)
    for key in ("Ns", "Pm"):
        numbers.pop(key, None)
    if share == 1.0:
        colors.pop("Kd", None)
    else:
        numbers["transmission"] = share
        colors["glossy"] = normal_reflectance(numbers.get("Ni", USUAL_INDEX))
    return True


def _make_glass(name: str, draft: Draft) -> Material:
    _leave_out_covers(draft)
    draft.ignored += [key for key in _numbers(draft) if key != "Pr"]
    draft.ignored += [key for key in ("d", "Tr") if draft.numbers.get(key, 1.0) != 1.0]
    light, tint = _color_or_texture(draft, "Ke", 0.0), _color_or_texture(draft, "Tf", 1.0)
    roughness = draft.number("Pr") if "Pr" in draft.numbers or "Pr" in draft.data else 0.0
    look: dict[str, Any] = {
        "emission": light,
        "ior": draft.numbers["Ni"],
        "tint": tint,
        "roughness": roughness,
    }
    look |= _others(draft) | _own_maps(draft)
    if look.get("transmission", 1.0) == 1.0:
        draft.ignored += [key for key in ("Kd", "Ks") if matters(draft.colors.get(key, 0.0))]
        draft.ignored += [key for key in ("map_Kd", "map_d") if key in draft.maps]
        return Material(name, **{**look, "reflectance": 0.0, "glossy": 0.0})
    return Material(name, **look, reflectance=_color_or_texture(draft, "Kd", 0.0))


def _others(draft: Draft) -> dict[str, Any]:
    """Return the attributes that statements give whatever the illumination model."""
    given = {**draft.colors, **draft.numbers}
    relief = {} if draft.relief is None else {"relief": draft.relief}
    return relief | {
        attribute: given[parameter.mtl]
        for attribute, parameter in parameters_of(Material).items()
        if parameter.mtl in given and parameter.mtl not in _DECIDED
    }


def _color_or_texture(draft: Draft, keyword: str, default: Color) -> Paint:
    color = draft.colors.get(keyword)
    if f"map_{keyword}" not in draft.maps:
        return default if color is None else color
    texture = draft.maps[f"map_{keyword}"]
    if texture is None and keyword == "Kd":
        return (GREY,) * 3
    rgb: NDArray[np.float64] = np.ones(3)
    if isinstance(color, Spectrum):
        seen = radiance_to_rgb(color) if keyword == "Ke" else reflectance_to_rgb(color)
        rgb = np.clip(seen, 0.0, np.inf if keyword == "Ke" else 1.0)
    elif color is not None:
        rgb = rgb * np.asarray(color, np.float64)
    return plain(rgb * GREY) if texture is None else replace(texture, factor=plain(rgb))


def _alpha(draft: Draft) -> float | Texture:
    numbers = draft.numbers
    if "d" in numbers and numbers.get("Tr", numbers["d"]) != numbers["d"]:
        draft.ignored.append("Tr")
    alpha = numbers.get("d", numbers.get("Tr", 1.0))
    texture = draft.maps.get("map_d")
    return alpha if texture is None else replace(texture, factor=(alpha,) * 3)
