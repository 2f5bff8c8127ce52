"""Normals of the faces that an OBJ file smooths by `s` lines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from photonmap.io.readers.vertex_normals import vertex_normals
from photonmap.io.readers.wavefront.obj_lines import ObjLines

_KEYWORD = "s"
_OFF = ("", "0", "off")
"""What stands behind the keyword where faces are flat."""


def smooth(lines: ObjLines) -> ObjLines:
    """Return lines whose smoothed faces have normals, one for each vertex and smoothing group.

    Faces that have normals keep them.
    """
    groups = _group_faces(lines)
    begins = np.cumsum(lines.sizes) - lines.sizes
    groups[np.maximum.reduceat(lines.corners[:, 2], begins) > 0] = 0
    by_corner = np.repeat(groups, lines.sizes)
    chosen = by_corner > 0
    if not chosen.any():
        return lines
    at = lines.corners[chosen, 0] - 1
    code = by_corner[chosen] * len(lines.vertices) + at
    distinct, which = np.unique(code, return_inverse=True)
    sizes = lines.sizes[groups > 0]
    normals = vertex_normals(lines.vertices[at], sizes, which, len(distinct))
    corners = lines.corners.copy()
    corners[chosen, 2] = len(lines.normals) + 1 + which
    return replace(lines, corners=corners, normals=np.vstack([lines.normals, normals]))


def _group_faces(lines: ObjLines) -> NDArray[np.int64]:
    """Return the smoothing group of each face, (F,); 0 where it is flat."""
    offsets, numbers, known = [0], [0], dict.fromkeys(_OFF, 0)
    for offset, keyword, name in lines.states:
        if keyword == _KEYWORD:
            offsets.append(offset)
            numbers.append(known.setdefault(name.lower(), len(known)))
    return np.array(numbers)[np.searchsorted(offsets, lines.offsets, "right") - 1]
