"""Write the materials of a scene as MTL."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from photonmap.errors import naming
from photonmap.io.writers.assets import Assets, check_name
from photonmap.scene.material import Material
from photonmap.scene.parameters import Colored, Number, parameters_of
from photonmap.scene.scene import Scene
from photonmap.scene.surfaces.explicit import explicit
from photonmap.scene.textures import Texture


def write_mtl(scene: Scene, path: Path, assets: Assets) -> dict[int, str]:
    """Write all materials that faces use.

    Returns
    -------
    dict from the id of a material to its name in the file: the second "wall" is "wall 2"

    Raises
    ------
    InputError
        if a name cannot be written
    """
    named = name_materials(scene)
    blocks = []
    for name, material in named.items():
        with naming("material"):
            check_name(material.name)
        blocks.append("\n".join([f"newmtl {name}", *_statements(material, name, assets), ""]))
    path.write_text("\n".join(blocks), "utf-8")
    return {id(material): name for name, material in named.items()}


def name_materials(scene: Scene) -> dict[str, Material]:
    """Return all materials that faces use under names that differ: the second is "wall 2"."""
    used = {id(mesh.material): mesh.material for mesh in scene.meshes if len(mesh.faces)}
    named: dict[str, Material] = {}
    for material in used.values():
        wanted = name = material.name or "material"
        count = 1
        while name in named:
            count += 1
            name = f"{wanted} {count}"
        named[name] = material
    return named


def _statements(material: Material, name: str, assets: Assets) -> Iterator[str]:
    """Yield the lines of a material below its name: all that differs from the defaults.

    The reflectance is always among them: without it, a mirror in MTL has none.
    """
    material = explicit(material)
    yield f"illum {_illumination_model(material)}"
    if material.relief is not None:
        keyword = "map_Bump" if material.relief.is_height else "norm"
        image = assets.texture(material.relief.texture, f"{name} relief")
        yield f"{keyword} -bm {material.relief.factor!r} {image}"
    if material.dispersion is not None:
        yield f"abbe {material.nearest_abbe!r}"
    for attribute, parameter in parameters_of(Material).items():
        if not parameter.mtl or not (parameter.mtl == "Kd" or material.takes(attribute)):
            continue
        value = getattr(material, attribute)
        label = name if parameter.mtl == "Kd" else f"{name} {attribute}"
        if isinstance(value, Texture):
            is_mask = isinstance(parameter, Number)
            yield f"map_{parameter.mtl} {assets.texture(value, label, opacity=is_mask)}"
        elif isinstance(parameter, Number) and value != getattr(Material, attribute):
            yield f"{parameter.mtl} {float(value)!r}"
        elif isinstance(parameter, Colored) and (
            parameter.mtl == "Kd" or value != getattr(Material, attribute)
        ):
            yield f"{parameter.mtl} spectral {assets.color(value, label)}"


def _illumination_model(material: Material) -> int:
    """Return the number by which MTL calls glass, mirrors and diffuse surfaces."""
    if material.ior is not None:
        return 4
    return 3 if material.mirror != 0.0 else 1
