"""Read STL files."""

from __future__ import annotations

import re
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Losses, decode_file, note_loss
from photonmap.io.readers.meshes import Part, build_mesh
from photonmap.io.readers.registry import ReadOptions
from photonmap.scene.material import Material
from photonmap.scene.scene import Scene

SUFFIXES = (".stl",)


def read(path: Path, options: ReadOptions) -> Scene:
    """Read the solids of an STL file, binary or text, each a mesh of the material "default".

    Raises
    ------
    InputError : as `decode_file`; or a number is not valid
    """
    return decode_file(path, _decode)


def _decode(path: Path, data: bytes, losses: Losses) -> Scene:
    from trimesh.exchange.stl import load_stl

    count = int.from_bytes(data[80:84], "little")
    if len(data) != 84 + 50 * count:
        if not re.search(rb"(?i)\b(facet|endsolid)\b", data[:4096]):
            message = f"is damaged: binary of {count} triangles would have {84 + 50 * count} bytes"
            raise InputError(f"{message}, not {len(data)}; export it again", path)
        data = data.decode(errors="replace").encode()
    loaded: dict[str, Any] = load_stl(BytesIO(data))
    attributes = loaded.get("face_attributes", {}).get("stl")
    solids = loaded.get("geometry", {"": loaded})
    if attributes is None:
        _check_ascii_stl(path, data, sum(len(solid["faces"]) for solid in solids.values()))
    elif attributes.any():
        note_loss(losses, "colours in attribute bytes")
    names = re.findall(rb"(?im)^[ \t]*solid\b[ \t]*(.*?)\s*$", data) if attributes is None else []
    if len(names) != len(solids):
        names = [b""] * len(solids)
    default = Material("default")
    meshes = [
        build_mesh(
            path,
            Part(np.asarray(solid["vertices"], np.float64), np.asarray(solid["faces"], np.int64)),
            default,
            name.decode() or path.stem,
        )
        for name, solid in zip(names, solids.values(), strict=True)
    ]
    return Scene(meshes, name=path.stem)


def _check_ascii_stl(path: Path, data: bytes, faces: int) -> None:
    """Refuse text of which some facets were skipped."""
    facets = len(re.findall(rb"(?i)\bfacet\s+normal\b", data))
    vertices = len(re.findall(rb"(?i)\bvertex[ \t]+[-+.\dni]", data))
    if (facets, vertices) != (faces, 3 * faces):
        message = f"is damaged: {faces} of {facets} facets ({vertices} vertices) are complete"
        raise InputError(f"{message}; export it again", path)
