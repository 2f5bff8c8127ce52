"""Write the materials of a scene as MTL."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from photonmap.errors import naming
from photonmap.scene import Material, Scene
from photonmap.textures import Paint, Texture
from photonmap.writers.assets import Assets, check_name


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
    names: dict[int, str] = {}
    taken: set[str] = set()
    blocks = []
    for material in (mesh.material for mesh in scene.meshes if len(mesh.faces)):
        if id(material) in names:
            continue
        with naming("material"):
            check_name(material.name)
        wanted = name = material.name or "material"
        count = 1
        while name in taken:
            count += 1
            name = f"{wanted} {count}"
        taken.add(name)
        names[id(material)] = name
        blocks.append("\n".join([f"newmtl {name}", *_statements(material, name, assets), ""]))
    path.write_text("\n".join(blocks), "utf-8")
    return names


def _statements(material: Material, name: str, assets: Assets) -> Iterator[str]:
    """Give the lines of a material behind its name."""
    if _shines(material.emission):
        yield _paint("Ke", material.emission, f"{name} emission", assets)
    if material.ior is not None:
        yield f"illum 4\nNi {float(material.ior)!r}"
        yield f"Tf spectral {assets.color(material.tint, f'{name} tint')}"
        return
    yield _paint("Kd", material.reflectance, name, assets)
    if material.mirror != 0.0:
        yield f"illum 3\nKs spectral {assets.color(material.mirror, f'{name} mirror')}"
    else:
        yield "illum 1"
    if isinstance(material.alpha, Texture):
        yield f"map_d {assets.texture(material.alpha, f'{name} alpha', opacity=True)}"
    elif material.alpha != 1.0:
        yield f"d {float(material.alpha)!r}"


def _shines(emission: Paint) -> bool:
    return isinstance(emission, Texture) or emission != 0.0


def _paint(keyword: str, paint: Paint, label: str, assets: Assets) -> str:
    """Return the line of a colour, or of a texture."""
    if isinstance(paint, Texture):
        return f"map_{keyword} {assets.texture(paint, label)}"
    return f"{keyword} spectral {assets.color(paint, label)}"
