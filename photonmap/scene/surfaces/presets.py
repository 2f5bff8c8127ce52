"""Usual materials by a few numbers each: methods of `Material`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

from photonmap.errors import naming
from photonmap.scene.parameters import Reflectance, finite, parameters_of, vector
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.metallic import FRACTION, metallic_gloss
from photonmap.scene.textures import Paint, Texture
from photonmap.spectra.curves import Color, Spectrum

_COLOR = Reflectance("reflectance")


class Presets:
    """What makes a `Material` of a kind."""

    if TYPE_CHECKING:

        def __init__(self, name: str, reflectance: Paint, **attributes: Any) -> None:
            """Stand for that of `Material`."""

    @classmethod
    def polished(cls, name: str = "mirror", mirror: Color = 1.0) -> Self:
        """Return a perfect mirror of this reflectance."""
        return cls(name, 0.0, mirror=mirror)

    @classmethod
    def metal(
        cls, name: str = "metal", glossy: Paint = 0.9, roughness: float | Texture = 0.3
    ) -> Self:
        """Return a rough metal of this reflectance at normal incidence."""
        return cls(name, 0.0, glossy=glossy, roughness=roughness)

    @classmethod
    def plastic(
        cls,
        name: str = "plastic",
        reflectance: Paint = 0.5,
        ior: float = 1.5,
        roughness: float | Texture = 0.3,
    ) -> Self:
        """Return a diffuse base below a rough coat of this index of refraction, at least 1."""
        return cls(name, reflectance, glossy=cls._coat(name, ior), roughness=roughness)

    @classmethod
    def glass(
        cls, name: str = "glass", ior: float = 1.5, tint: Color = 1.0, roughness: float = 0.0
    ) -> Self:
        """Return glass, smooth or rough."""
        return cls(name, 0.0, ior=ior, tint=tint, roughness=roughness)

    @classmethod
    def pane(
        cls, name: str = "pane", ior: float = 1.5, tint: Color = 1.0, roughness: float = 0.0
    ) -> Self:
        """Return thin glass, smooth or frosted."""
        return cls(name, 0.0, ior=ior, tint=tint, roughness=roughness, thin=True)

    @classmethod
    def metallic_roughness(
        cls,
        name: str = "metallic",
        base_color: Paint = 0.5,
        metallic: float | Texture = 0.0,
        roughness: float | Texture = 0.5,
        ior: float = 1.5,
    ) -> Self:
        """Return a metal in part, as glTF's factors and `metallic` in TOML files make it.

        Parameters
        ----------
        name : of the material
        base_color : reflectance of the metal at normal incidence, and diffuse albedo of the rest
        metallic : which fraction is metal, in [0, 1]; an image lies like that of the base colour
        roughness : of the metal, and of the coat of the rest
        ior : index of refraction of that coat, at least 1

        Raises
        ------
        InputError : a number is out of range, or the base colour is none or has a spectrum in every
            texel
        """
        coat = cls._coat(name, ior)
        with naming(f"material {name!r}: base_color"):
            base = _plain(base_color)
        with naming(f"material {name!r}: metallic"):
            share = metallic if isinstance(metallic, Texture) else FRACTION.check(metallic)
            gloss = metallic_gloss(base, share, coat, roughness)
        return cls(name, **gloss._asdict())

    @classmethod
    def _coat(cls, name: str, ior: float) -> float:
        """Return what a coat of this index of refraction reflects at normal incidence."""
        with naming(f"material {name!r}: ior"):
            return normal_reflectance(parameters_of(cls)["coat_ior"].check(ior))


def _plain(color: Paint) -> Paint:
    """Return a colour as a float or three, if it is no spectrum and no texture."""
    if isinstance(color, Spectrum | Texture):
        return color
    number = finite(color)
    plain = vector(color) if number is None else number
    if plain is None:
        raise _COLOR.error(color, "give a number, three for RGB, a Spectrum or a Texture")
    return plain
