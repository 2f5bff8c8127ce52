"""The extent of a scene, and a guess at its unit of length."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from photonmap.scene.mesh import Mesh

UNITS = ((0.0, "metres", 1.0), (50.0, "centimetres", 0.01), (1600.0, "millimetres", 0.001))
"""From which longest side on, a unit's name, and metres in it: rooms are the likeliest scenes, and
measure about 5 m. The limits are geometric means: 50 m are as unlikely as 0.5 m."""
_IN_METRES = (".glb", ".gltf")
LARGEST = 1e6
"""Longest side of which a unit can be guessed."""


def describe_bounds(meshes: Sequence[Mesh]) -> dict[str, Any]:
    """Return the corners of the box around meshes that have vertices, and its sides."""
    low = np.min([mesh.vertices.min(axis=0) for mesh in meshes], axis=0)
    high = np.max([mesh.vertices.max(axis=0) for mesh in meshes], axis=0)
    return {"low": low.tolist(), "high": high.tolist(), "size": (high - low).tolist()}


def guess_unit(size: Sequence[float], suffix: str = "") -> dict[str, Any]:
    """Return the likely unit of length, the longest side in metres, and what this rests on.

    Parameters
    ----------
    size : sides of the box around the scene
    suffix : of the file; glTF prescribes a unit
    """
    longest = max(size)
    says = "glTF prescribes metres" if suffix in _IN_METRES else "the format does not say"
    if not 0.0 < longest <= LARGEST:
        return {"guess": None, "metres": None, "why": f"the size is unusual; {says}"}
    name, metre = [(name, metre) for least, name, metre in UNITS if longest >= least][-1]
    metres = longest * metre
    why = f"the longest side would be {metres:.3g} m; {says}"
    return {"guess": name, "metres": metres, "why": why}
