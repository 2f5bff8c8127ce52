"""The lobes of a surface: one row each says what it is called, and with which others it clashes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from photonmap.errors import InputError
from photonmap.scene.material import Material
from photonmap.scene.textures import is_black

_LAMBERT = "only a Lambertian base lies below; set diffuse_roughness to 0, or leave out"
_METAL = "for metal below it give glossy in place of mirror"
_GLASS = "glass has none; leave out ior, or"


class Lobe(NamedTuple):
    """A way in which surfaces scatter, beside Lambert's law."""

    attribute: str
    """of `Material` that asks for it"""
    is_there: Callable[[Material], bool]
    over: str = "{}"
    """Its name over what `{}` stands for"""
    alone: str = ""
    """Its name over black"""
    parameters: tuple[str, ...] = ()
    """Attributes that have no effect without it"""
    without: str = ""
    """What a material lacks that has these parameters alone, and what to do"""
    clashes: Mapping[str, str] = MappingProxyType({})
    """Attributes of lobes that it cannot have below or beside it, with what to do"""


LOBES = (
    Lobe("ior", lambda material: material.ior is not None),
    Lobe(
        "diffuse_roughness", lambda material: material.diffuse_roughness != 0.0, "rough {}", "black"
    ),
    Lobe("mirror", lambda material: not is_black(material.mirror), "mirror over {}", "mirror"),
    Lobe(
        "glossy",
        lambda material: material.is_glossy,
        "gloss over {}",
        "metal",
        ("roughness", "anisotropy", "glossy_edge"),
        "what is not glossy; add glossy = 0.04 for plastic, or glossy = 'metal:Au'",
        {
            "mirror": "set mirror to 0; a glossy of roughness 0 over reflectance 0 is a mirror",
            "diffuse_roughness": f"{_LAMBERT} glossy",
        },
    ),
    Lobe(
        "coat",
        lambda material: material.is_coated,
        "coated {}",
        "coated black",
        ("coat_roughness", "coat_ior", "coat_relief"),
        "what has no coat; add coat = 1",
        {"ior": f"{_GLASS} coat", "mirror": _METAL, "diffuse_roughness": f"{_LAMBERT} coat"},
    ),
    Lobe(
        "sheen",
        lambda material: material.has_sheen,
        "sheen over {}",
        "sheen over black",
        ("sheen_roughness",),
        "what has no sheen; add sheen = 0.5",
        {
            "ior": f"{_GLASS} sheen",
            "mirror": _METAL,
            "coat": "one of them lies on top; for a shine below a sheen give glossy, not coat",
        },
    ),
)
"""From the lowest to the topmost"""


class LayerError(InputError):
    """Layers of a material that do not go together: `attributes` names the two."""

    def __init__(self, material: Material, attributes: tuple[str, str], remedy: str) -> None:
        self.attributes = attributes
        layer, other = attributes
        super().__init__(f"material {material.name!r}: {layer} does not go with {other}: {remedy}")


def check_layers(material: Material) -> None:
    """Check that the layers of a material go together.

    Raises
    ------
    LayerError : two do not
    """
    there = [lobe for lobe in LOBES if lobe.is_there(material)]
    names = {lobe.attribute for lobe in there}
    for lobe in there:
        for other, remedy in lobe.clashes.items():
            if other in names:
                raise LayerError(material, (lobe.attribute, other), remedy)


def name_kind(material: Material) -> str:
    """Return how a material reflects or transmits, in a few words."""
    opaque = "" if is_black(material.reflectance) else "diffuse"
    for lobe in LOBES:
        if lobe.is_there(material):
            opaque = lobe.over.format(opaque) if opaque else lobe.alone
    opaque = opaque or "black"
    if material.ior is None:
        return opaque
    is_rough = bool(material.roughness) or material.is_anisotropic
    glass = f"{'rough ' * is_rough}{'thin ' * bool(material.thin)}glass"
    return glass if material.is_all_glass else f"part {glass}, part {opaque}"
