"""Colours of vertices and faces as mesh files hold them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.scene.images import decode_srgb

Note = Callable[[str], None]
"""Takes what is not simulated."""


def decode_colors(values: NDArray[Any], note: Note, owners: str) -> NDArray[np.float64]:
    """Return linear reflectances of colours that are encoded in sRGB.

    OBJ, PLY, OFF and STL do not define an encoding. Scanners and MeshLab write what a screen shows,
    and Blender and three.js read these colours as sRGB.

    Parameters
    ----------
    values : (n, 3), or (n, 4) with an opacity, which is not simulated: integers are fractions of
        the largest of their type; floats lie in [0, 1], or are all whole numbers, up to 255
    note : takes what is not simulated
    owners : what has these colours, such as "vertices"

    Returns
    -------
    (n, 3), of a row that is not finite NaN
    """
    if values.dtype.kind in "ui":
        scaled = values / np.iinfo(values.dtype).max
    else:
        finite = values[np.isfinite(values)]
        in_bytes = finite.max(initial=0.0) > 1.0 and (finite == np.rint(finite)).all()
        scaled = values.astype(np.float64) / (255.0 if in_bytes else 1.0)
    colors = np.clip(scaled[:, :3], 0.0, 1.0)
    if count := int((colors != scaled[:, :3]).any(axis=1, where=~np.isnan(colors)).sum()):
        note(f"{count} colours of {owners} outside [0, 1]")
    if (scaled[:, 3:] < 1.0).any():
        note(f"opacity of {owners}")
    return decode_srgb(colors)
