"""A material of an MTL file as far as it has been read."""

from __future__ import annotations

from dataclasses import dataclass, field

from photonmap.scene.surfaces.relief import BumpMap, NormalMap
from photonmap.scene.textures import Texture
from photonmap.spectra.curves import Color, Spectrum


@dataclass
class Draft:
    """A material as far as it has been read.

    Parameters
    ----------
    blender : 0; of a file by Blender's exporter, the `Ns` that it writes for roughness 0
    colors : `Kd`, `Ke`, `Ks`, `Tf`, `Ps`
    maps : `map_Kd`, `map_Ke`, `map_d`; None for a missing file
    data : `map_Pr` and `map_Pm`, which replace `Pr` and `Pm`, and `map_Ns`, which multiplies `Ns`
    numbers : `illum`, `Ni`, `Ns`, `Pr`, `Pm`, `d`, and `Tr` as 1 - Tr
    clamped : keywords of colours that were lowered to 1
    ignored : keywords of what is not simulated
    averaged : keywords of maps whose mean stands for them
    relief, relief_keyword : of `norm` or `bump`, and which of them
    """

    blender: float = 0.0
    colors: dict[str, Color] = field(default_factory=dict)
    maps: dict[str, Texture | None] = field(default_factory=dict)
    data: dict[str, Texture] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)
    clamped: list[str] = field(default_factory=list)
    ignored: list[str] = field(default_factory=list)
    averaged: list[str] = field(default_factory=list)
    relief: NormalMap | BumpMap | None = None
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
