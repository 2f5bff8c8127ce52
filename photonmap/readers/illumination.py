"""What MTL's illumination models stand for."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from photonmap.scene import Material
from photonmap.spectra.curves import Color, Spectrum
from photonmap.spectra.observer import radiance_to_rgb, reflectance_to_rgb
from photonmap.textures import Paint, Texture

_MIRRORS, _GLASSES = (3, 5), (4, 6, 7)


@dataclass
class Draft:
    """A material as far as it has been read.

    Parameters
    ----------
    colors : `Kd`, `Ke`, `Ks`, `Tf`
    maps : `map_Kd`, `map_Ke`, `map_d`; None for a file that is missing
    numbers : `illum`, `Ni`, `d`, and `Tr` as 1 - Tr
    clamped : keywords of colours that were lowered to 1
    ignored : keywords of what is not simulated
    """

    colors: dict[str, Color] = field(default_factory=dict)
    maps: dict[str, Texture | None] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)
    clamped: list[str] = field(default_factory=list)
    ignored: list[str] = field(default_factory=list)


def make_material(name: str, draft: Draft) -> Material:
    """Return the material that a draft describes; what it leaves out is noted as ignored.

    `illum` 3 and 5 with `Ks` are a mirror of that reflectance, over `Kd` where it is given; 4, 6
    and 7 with `Ni` are smooth glass, tinted by `Tf` at each crossing. All others are diffuse.
    Textures are multiplied by the colour or number they belong to, where it is given. Glass is
    seen through as it is, whatever its `d`.
    """
    model = draft.numbers.get("illum", 1.0)
    colors = draft.colors
    light, albedo = _paint(draft, "Ke", 0.0), _paint(draft, "Kd", 0.0)
    is_painted = "Kd" in colors or "map_Kd" in draft.maps
    if model in _GLASSES and "Ni" in draft.numbers:
        draft.ignored += [key for key in ("Kd", "Ks") if _matters(colors.get(key, 0.0))]
        draft.ignored += [key for key in ("map_Kd", "map_d") if key in draft.maps]
        draft.ignored += [key for key in ("d", "Tr") if draft.numbers.get(key, 1.0) != 1.0]
        return Material(name, 0.0, light, 0.0, draft.numbers["Ni"], colors.get("Tf", 1.0))
    is_mirror = model in _MIRRORS and "Ks" in colors
    if not is_mirror and _matters(colors.get("Ks", 0.0)):
        draft.ignored.append("Ks")
    if draft.numbers.get("Ni", 1.0) != 1.0:
        draft.ignored.append("Ni")
    if _matters(colors.get("Tf", 1.0), 1.0):
        draft.ignored.append("Tf")
    if is_mirror:
        return Material(name, albedo, light, colors["Ks"], alpha=_alpha(draft))
    if model > 2:
        draft.ignored.append("illum")
    reflectance = albedo if is_painted else Material.reflectance
    return Material(name, reflectance, light, alpha=_alpha(draft))


MISSING = 0.5
"""Grey in place of a texture that is missing."""


def _paint(draft: Draft, keyword: str, default: Color) -> Paint:
    """Return a texture times its colour, or the colour alone."""
    color = draft.colors.get(keyword)
    if f"map_{keyword}" not in draft.maps:
        return default if color is None else color
    texture = draft.maps[f"map_{keyword}"]
    if texture is None and keyword == "Kd":
        return (MISSING,) * 3
    rgb: NDArray[np.float64] = np.ones(3)
    if isinstance(color, Spectrum):
        seen = radiance_to_rgb(color) if keyword == "Ke" else reflectance_to_rgb(color)
        rgb = np.clip(seen, 0.0, np.inf if keyword == "Ke" else 1.0)
    elif color is not None:
        rgb = rgb * np.asarray(color, np.float64)
    red, green, blue = rgb.tolist()
    if texture is None:
        return red * MISSING, green * MISSING, blue * MISSING
    return replace(texture, factor=(red, green, blue))


def _alpha(draft: Draft) -> float | Texture:
    """Return the opacity: `d`, or else 1 - `Tr`, times the texture."""
    numbers = draft.numbers
    if "d" in numbers and numbers.get("Tr", numbers["d"]) != numbers["d"]:
        draft.ignored.append("Tr")
    alpha = numbers.get("d", numbers.get("Tr", 1.0))
    texture = draft.maps.get("map_d")
    return alpha if texture is None else replace(texture, factor=(alpha,) * 3)


def _matters(color: Color, neutral: float = 0.0) -> bool:
    """Tell whether a colour differs from the one that changes nothing."""
    if isinstance(color, Spectrum):
        return True
    return any(value != neutral for value in (color if isinstance(color, tuple) else (color,)))
