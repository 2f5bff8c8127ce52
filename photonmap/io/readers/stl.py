"""Read STL files."""

from __future__ import annotations

import re
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers.decoding import (
    Losses,
    check_decimals,
    decode_colors,
    decode_file,
    note_loss,
)
from photonmap.io.readers.meshes import Part, build_mesh
from photonmap.io.readers.registry import GREY, ReadOptions
from photonmap.scene.material import Material
from photonmap.scene.scene import Scene

SUFFIXES = (".stl",)


def read(path: Path, options: ReadOptions) -> Scene:
    """Read the solids of an STL file, binary or text, each a mesh of the material "default".

    Colours are those of binary facets, by VisCAM's or Materialise's convention.
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
    try:
        loaded: dict[str, Any] = load_stl(BytesIO(data))
    except ValueError:
        _check_vertices(path, data)
        raise
    attributes = loaded.get("face_attributes", {}).get("stl")
    solids = loaded.get("geometry", {"": loaded})
    colors = None
    if attributes is None:
        faces = sum(len(solid["faces"]) for solid in solids.values())
        facets = len(re.findall(rb"(?i)\bfacet\s+normal\b", data))
        vertices = len(re.findall(rb"(?i)\bvertex[ \t]+[-+.\dni]", data))
        if (facets, vertices) != (faces, 3 * faces):  # some were skipped
            _check_vertices(path, data)
            message = f"is damaged: {faces} of {facets} facets ({vertices} vertices) are complete"
            raise InputError(f"{message}; export it again", path)
    else:
        colors = _facet_colors(data[:80], attributes, losses)
    names = re.findall(rb"(?im)^[ \t]*solid\b[ \t]*(.*?)\s*$", data) if attributes is None else []
    if len(names) != len(solids):
        names = [b""] * len(solids)
    default, scene = Material("default"), Scene(name=path.stem)
    for name, solid in zip(names, solids.values(), strict=True):
        corners = np.asarray(solid["faces"], np.int64)
        part = Part(np.asarray(solid["vertices"], np.float64), corners, colors=colors)
        scene.meshes.append(build_mesh(path, part, default, name.decode() or path.stem))
    return scene


def _check_vertices(path: Path, data: bytes) -> None:
    """Raise `InputError` for the first vertex of a text that is not three numbers."""
    for number, line in enumerate(data.splitlines(), start=1):
        keyword, *words = line.split() or [b""]
        if keyword.lower() == b"vertex":
            check_decimals(path, b" ".join(words), number - 1)
            if len(words) != 3:
                message = f"vertex has {len(words)} numbers, not 3; export it again"
                raise InputError(message, path, number)


def _facet_colors(
    header: bytes, attributes: NDArray[np.uint16], losses: Losses
) -> NDArray[np.float64] | None:
    """Return the colours of binary facets, (F, 1, 3), linear; None where there are none.

    VisCAM and SolidView set bit 15 of a facet that has a colour, with blue in the lowest five bits.
    Materialise Magics writes the colour of the part behind "COLOR=" in the header, clears bit 15 of
    a facet with a colour of its own, and has red in the lowest bits.
    """
    of_part = header.partition(b"COLOR=")[2]
    by_magics = len(of_part) >= 4
    shifts = (0, 5, 10) if by_magics else (10, 5, 0)
    colors = np.stack([(attributes >> shift & 31) / 31.0 for shift in shifts], axis=1)
    colored = (attributes >> 15 == 0) == by_magics
    if by_magics:
        colored &= attributes.any()
        colors[~colored] = np.frombuffer(of_part[:3], np.uint8) / 255.0
    elif not colored.any():
        if attributes.any():
            note_loss(losses, "attribute bytes")
        return None
    linear = decode_colors(colors, partial(note_loss, losses), "facets")
    if not by_magics:
        linear[~colored] = GREY
    return linear[:, None]
