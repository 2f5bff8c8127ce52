"""Read STL files."""

from __future__ import annotations

import re
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.readers.meshes import Losses, Part, build_mesh, note
from photonmap.scene import Material, Mesh


def read_stl(path: Path, data: bytes, losses: Losses) -> list[Mesh]:
    """Read the solids of an STL file, binary or text."""
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
        note(losses, "colours in attribute bytes")
    names = re.findall(rb"(?im)^[ \t]*solid\b[ \t]*(.*?)\s*$", data) if attributes is None else []
    if len(names) != len(solids):
        names = [b""] * len(solids)
    default = Material("default")
    return [
        build_mesh(
            path,
            Part(np.asarray(solid["vertices"], np.float64), np.asarray(solid["faces"], np.int64)),
            default,
            name.decode() or path.stem,
        )
        for name, solid in zip(names, solids.values(), strict=True)
    ]


def _check_ascii_stl(path: Path, data: bytes, faces: int) -> None:
    """Refuse a text of which some facets were passed over."""
    facets = len(re.findall(rb"(?i)\bfacet\s+normal\b", data))
    vertices = len(re.findall(rb"(?i)\bvertex[ \t]+[-+.\dni]", data))
    if (facets, vertices) != (faces, 3 * faces):
        message = f"is damaged: of {facets} facets and {vertices} vertices {faces} facets are whole"
        raise InputError(f"{message}; export it again", path)
