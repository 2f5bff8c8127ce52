"""Materials all of which is stated, for files that know no metals by name."""

from dataclasses import replace

from photonmap.scene.material import Material


def explicit(material: Material) -> Material:
    """Return the same material, with what follows from a metal's index given by itself."""
    if not material.is_metal_mirror:
        return replace(material, glossy_edge=material.edge)
    metal = material.mirror
    return replace(material, mirror=0.0, glossy=metal, glossy_edge=material.edge, roughness=0.0)
