"""Find the portals of a scene, and how suns shine through them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.cdf import make_cdf
from photonmap.compile.triangles import triangle_areas
from photonmap.errors import InputError, warn
from photonmap.kernels.core.records import Geometry, SunPortals
from photonmap.kernels.lights import sun
from photonmap.kernels.lights.kinds import DIRECTIONAL
from photonmap.runtime.wording import listed
from photonmap.scene.material import Material

EDGE_ON = 1e-6
"""Share of a portal's area that a sun sees at least: photons of suns start somewhere."""


def find_portals(materials: Sequence[Material], emission: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which materials are portals, (M,).

    Parameters
    ----------
    emission : of the materials by themselves, (M, N)

    Raises
    ------
    InputError : a portal emits by itself, too
    """
    portals = np.array([material.portal for material in materials])
    for index in np.flatnonzero(portals & emission.any(axis=1)).tolist():
        raise InputError(
            f"material {materials[index].name!r} is a portal, and has an emission; remove one"
        )
    return portals


def warn_of_black_portals(materials: Sequence[Material]) -> None:
    """Warn of portals, if there are any, of a scene without light outside."""
    if any(material.portal for material in materials):
        names = listed(material.name for material in materials if material.portal)
        warn(f"portals ({names}) are black: there is no sky, environment or dome for them to show")


def open_to_suns(
    geometry: Geometry,
    portals: NDArray[np.bool_],
    kind: NDArray[np.uint8],
    axis: NDArray[np.float64],
    parameters: NDArray[np.float64],
) -> SunPortals | None:
    """Return the portals as suns see them; None where there are none, or no suns.

    Parameters
    ----------
    portals : which materials are, (M,)
    kind, axis, parameters : of K emitters, as in `Lights`
    """
    triangles = np.flatnonzero(portals[geometry.material])
    suns = np.flatnonzero(kind == DIRECTIONAL)
    if not (len(triangles) and len(suns)):
        return None
    area = triangle_areas(geometry, triangles)
    facing = np.abs(axis[suns] @ geometry.normals[triangles].T.astype(np.float64))
    edge = parameters[suns, sun.Parameters._fields.index("edge"), None]
    seen = area * (facing + np.sqrt(1.0 - edge * edge) + EDGE_ON)  # a disc sees some more
    row = np.full(len(kind), -1, np.int32)
    row[suns] = np.arange(len(suns))
    return SunPortals(
        is_portal=portals,
        triangle=triangles.astype(np.int32),
        area=area,
        row=row,
        cdf=make_cdf(seen),
        extent=seen.sum(axis=1),
    )
