"""Materials without the images that say how their lobes vary."""

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
