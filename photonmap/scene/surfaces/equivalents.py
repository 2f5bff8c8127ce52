"""Materials that stand for others: without images of their lobes, or without metals by name."""

from dataclasses import replace
from typing import Any

from photonmap.scene.material import Material
from photonmap.scene.textures import mean_color, mean_number


def without_images(material: Material) -> Material:
    """Return a material without relief, and with the mean of the images of its lobes.

    It is the same one if it has none.
    """
    even: dict[str, Any] = {
        name: mean_color(getattr(material, name)) for name in ("glossy", "sheen")
    }
    for name in ("roughness", "coat", "coat_roughness"):
        even[name] = mean_number(getattr(material, name))
    even |= dict.fromkeys(("relief", "coat_relief", "anisotropy_map"))
    changed = {name: value for name, value in even.items() if value is not getattr(material, name)}
    return replace(material, **changed) if changed else material


def explicit(material: Material) -> Material:
    """Return the same material, with what follows from a metal's index given by itself.

    It is for files that know no metals by name.
    """
    if not material.is_metal_mirror:
        return replace(material, glossy_edge=material.edge)
    metal = material.mirror
    return replace(material, mirror=0.0, glossy=metal, glossy_edge=material.edge, roughness=0.0)
