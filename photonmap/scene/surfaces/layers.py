"""Which layers of a surface do not go together, and what to do instead."""

from __future__ import annotations

from photonmap.errors import InputError
from photonmap.scene.material import Material
from photonmap.scene.textures import is_black

_LAMBERT = "only a Lambertian base lies below; set diffuse_roughness to 0, or leave out"
_METAL = "for metal below it give glossy in place of mirror"
_GLASS = "glass has none; leave out ior, or"
_CLASHES = {
    ("glossy", "mirror"): "set mirror to 0; a glossy of roughness 0 over reflectance 0 is a mirror",
    ("glossy", "diffuse_roughness"): f"{_LAMBERT} glossy",
    ("coat", "ior"): f"{_GLASS} coat",
    ("coat", "mirror"): _METAL,
    ("coat", "diffuse_roughness"): f"{_LAMBERT} coat",
    ("sheen", "ior"): f"{_GLASS} sheen",
    ("sheen", "mirror"): _METAL,
    ("sheen", "coat"): "one of them lies on top; for a shine below a sheen give glossy, not coat",
}
"""Layers and what they cannot have below or beside them, with what to do"""


class LayerError(InputError):
    """Layers of a material that do not go together: `attributes` names the two."""

    def __init__(self, material: Material, attributes: tuple[str, str]) -> None:
        self.attributes = attributes
        layer, other = attributes
        super().__init__(
            f"material {material.name!r}: {layer} does not go with {other}: {_CLASHES[attributes]}"
        )


def check_layers(material: Material) -> None:
    """Check that the layers of a material go together.

    Raises
    ------
    LayerError : two do not
    """
    there = {
        "glossy": material.is_glossy,
        "coat": material.is_coated,
        "sheen": material.has_sheen,
        "ior": material.ior is not None,
        "mirror": not is_black(material.mirror),
        "diffuse_roughness": material.diffuse_roughness != 0.0,
    }
    for layer, other in _CLASHES:
        if there[layer] and there[other]:
            raise LayerError(material, (layer, other))
