"""What MTL's illumination models stand for."""

from __future__ import annotations

from dataclasses import dataclass, field

from photonmap.scene import Material
from photonmap.spectra.curves import Color, Spectrum

_MIRRORS, _GLASSES = (3, 5), (4, 6, 7)


@dataclass
class Draft:
    """A material as far as it has been read.

    Parameters
    ----------
    colors : `Kd`, `Ke`, `Ks`, `Tf`
    numbers : `illum`, `Ni`
    clamped : keywords of colours that were lowered to 1
    ignored : keywords of what is not simulated
    """

    colors: dict[str, Color] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)
    clamped: list[str] = field(default_factory=list)
    ignored: list[str] = field(default_factory=list)


def make_material(name: str, draft: Draft) -> Material:
    """Return the material that a draft describes; what it leaves out is noted as ignored.

    `illum` 3 and 5 with `Ks` are a mirror of that reflectance, over `Kd` where it is given; 4, 6
    and 7 with `Ni` are smooth glass, tinted by `Tf` at each crossing. All others are diffuse.
    """
    model = draft.numbers.get("illum", 1.0)
    colors = draft.colors
    light, albedo = colors.get("Ke", 0.0), colors.get("Kd", 0.0)
    if model in _GLASSES and "Ni" in draft.numbers:
        draft.ignored += [key for key in ("Kd", "Ks") if _matters(colors.get(key, 0.0))]
        return Material(name, 0.0, light, 0.0, draft.numbers["Ni"], colors.get("Tf", 1.0))
    is_mirror = model in _MIRRORS and "Ks" in colors
    if not is_mirror and _matters(colors.get("Ks", 0.0)):
        draft.ignored.append("Ks")
    if draft.numbers.get("Ni", 1.0) != 1.0:
        draft.ignored.append("Ni")
    if _matters(colors.get("Tf", 1.0), 1.0):
        draft.ignored.append("Tf")
    if is_mirror:
        return Material(name, albedo, light, colors["Ks"])
    if model > 2:
        draft.ignored.append("illum")
    return Material(name, albedo if "Kd" in colors else Material.reflectance, light)


def _matters(color: Color, neutral: float = 0.0) -> bool:
    """Tell whether a colour differs from the one that changes nothing."""
    if isinstance(color, Spectrum):
        return True
    return any(value != neutral for value in (color if isinstance(color, tuple) else (color,)))
