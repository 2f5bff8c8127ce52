"""What trimesh knows about the look of a mesh, as materials, texture coordinates and colours."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.scene.images import decode_srgb
from photonmap.scene.material import Material
from photonmap.scene.textures import Texture

Rows = NDArray[np.float64] | None


class Look(NamedTuple):
    """A material, and the attributes of `Mesh` that go with it."""

    material: Material
    uv: Rows = None
    colors: Rows = None


def look_of(visual: Any, name: str) -> Look:
    """Return the look of a `trimesh.Trimesh`, of which `visual` is the attribute.

    Colours of vertices and faces, and the texels of images, are sRGB; the colour of a material,
    which multiplies its image if it is of the PBR kind, is linear, as in glTF and MTL. Opacity,
    gloss and emission are not taken.

    Parameters
    ----------
    name : of the material, where it has none of its own
    """
    match visual.kind:
        case "vertex":
            return Look(Material(), colors=_decode(visual.vertex_colors))
        case "face":
            return Look(Material(), colors=_decode(visual.face_colors)[:, None])
        case "texture":
            material = visual.material
            image = getattr(material, "baseColorTexture", getattr(material, "image", None))
            factor = getattr(material, "baseColorFactor", None)
            if image is None and factor is None:
                factor = getattr(material, "diffuse", None)
            red, green, blue = _unit(factor) if factor is not None else (1.0, 1.0, 1.0)
            name = getattr(material, "name", None) or name
            if image is None:
                return Look(Material(name, (red, green, blue)))
            texels = np.asarray(image.convert("RGB"))
            return Look(Material(name, Texture.of(texels, factor=(red, green, blue))), visual.uv)
    return Look(Material())


def _decode(colors: Any) -> NDArray[np.float64]:
    """Return linear RGB, (n, 3), of 8-bit RGBA."""
    linear: NDArray[np.float64] = decode_srgb(np.asarray(colors)[:, :3] / 255.0)
    return linear


def _unit(color: Any) -> tuple[float, float, float]:
    """Return the first three components as fractions, of integers those of 255."""
    values = np.asarray(color)[:3]
    red, green, blue = (values / (255.0 if values.dtype.kind in "ui" else 1.0)).tolist()
    return red, green, blue
