"""Indices of refraction below 1, which are relative to glass around a mesh."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Real

import numpy as np

from photonmap.errors import InputError
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh

LIKE_AIR = 1e-3
"""By how much an index may lie below 1: that of air is 1.0003, of which some files take account."""
_TOUCHING = 1e-6
"""Distance, in sizes of a mesh, up to which boxes count as touching."""


def check_relative_indices(meshes: Sequence[Mesh]) -> None:
    """Check that where an index is below 1, there is glass to which it can be relative.

    Its bounding box meets that of the mesh; otherwise a `StrandedIndexError` is raised.
    """
    solid = [each for each in meshes if each.material.ior is not None and len(each.vertices)]
    for mesh in solid:
        if is_relative(mesh.material) and not any(_meet(mesh, each) for each in solid):
            raise StrandedIndexError(mesh)


def is_relative(material: Material) -> bool:
    """Return whether an index is relative to what is around."""
    index = material.ior
    return isinstance(index, Real) and material.outside == 1.0 and 0.0 < index < 1.0 - LIKE_AIR


class StrandedIndexError(InputError):
    """An index below 1 of a `mesh` that no glass surrounds."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        super().__init__(
            f"material {mesh.material.name!r}: ior {mesh.material.ior:g} is below 1, relative to "
            f"glass around it, and {mesh.name!r} lies in none; give it relative to air, such as 1.5"
        )


def _meet(mesh: Mesh, other: Mesh) -> bool:
    """Return whether the boxes of two meshes meet, and the other can be around."""
    if other is mesh or other.material.thin or is_relative(other.material):
        return False
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    slack = _TOUCHING * float(np.ptp(other.vertices))
    return bool(
        (low <= other.vertices.max(axis=0) + slack).all()
        and (high >= other.vertices.min(axis=0) - slack).all()
    )
