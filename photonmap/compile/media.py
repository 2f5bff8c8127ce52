"""What lies inside glass that absorbs, triangle by triangle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.frame import Frame
from photonmap.errors import InputError, naming, warn
from photonmap.kernels.core import records
from photonmap.runtime.wording import listed
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum

LEAST_TRANSMITTANCE = 1e-30
"""What is darker counts as this, which no image can tell from black."""
HEIGHT = 1e-6
"""Of the point over a triangle that is looked up, in sizes of the scene."""

Floats = NDArray[np.float64]


def with_media(
    specular: records.Specular | None,
    meshes: Sequence[Mesh],
    materials: Sequence[Material],
    geometry: records.Geometry,
    owner: NDArray[np.int64],
    bands: Bands,
    frame: Frame,
) -> records.Specular | None:
    """Return specular surfaces with the glass that absorbs, and what lies in it.

    Of other surfaces, those whose centroid a closed mesh of such glass contains lie in it, in the
    smallest of several.

    Parameters
    ----------
    owner : (T,) the mesh of each triangle
    frame : whose size is the kernels' unit of length

    Raises
    ------
    InputError : what absorbs is no solid glass, or has no distance
    """
    absorption = np.stack([_absorption(each, bands) * frame.size for each in materials])
    if specular is None or not absorption.any():
        return specular
    absorbs: NDArray[np.bool_] = np.any(absorption > 0.0, axis=1)
    of_side = np.full((len(geometry.triangles), 2), -1, np.int32)
    own = absorbs[geometry.material]
    of_side[own, 1] = geometry.material[own]
    unknown = []
    sizes = [np.ptp(mesh.vertices, axis=0).prod() for mesh in meshes]
    for index in np.argsort(sizes, kind="stable").tolist():  # what is inside comes first
        shell = owner == index
        material = int(geometry.material[shell][0]) if shell.any() else 0
        if shell.any() and absorbs[material] and not _fill(of_side, geometry, shell, material):
            unknown.append(meshes[index].name)
    if unknown:
        names = listed(unknown)
        warn(f"glass that absorbs is no closed mesh in {names}: what lies inside is unknown")
    return specular._replace(media=records.Media(of_side, absorption.astype(np.float32)))


def _absorption(material: Material, bands: Bands) -> Floats:
    """Return the absorption coefficient of each band, (N,), in the inverse of scene units."""
    color, distance = material.attenuation_color, material.attenuation_distance
    if not isinstance(color, Spectrum) and np.all(np.equal(color, 1.0)):
        return np.zeros(bands.count)
    with naming(f"material {material.name!r}: attenuation_color"):
        transmitted = bands.reflectance(color)
        if not ((transmitted >= 0.0) & (transmitted <= 1.001)).all():
            raise InputError("lies outside of [0, 1]; correct it")
        if material.ior is None or material.thin:
            raise InputError("only solid glass absorbs; give it an ior, and no thin")
        if distance is None:
            raise InputError("needs an attenuation_distance, after which this colour is left")
    return -np.log(np.clip(transmitted, LEAST_TRANSMITTANCE, 1.0)) / distance


def _fill(
    of_side: NDArray[np.int32],
    geometry: records.Geometry,
    shell: NDArray[np.bool_],
    material: int,
) -> bool:
    """Enter what lies inside one closed mesh; return whether it is closed."""
    import trimesh

    body = trimesh.Trimesh(geometry.vertices, geometry.triangles[shell], process=True)
    if not body.is_watertight:
        return False
    low, high = body.bounds
    centroids = geometry.vertices[geometry.triangles].mean(axis=1)
    near = ~shell & ((centroids >= low) & (centroids <= high)).all(axis=1)
    if not near.any():
        return True
    rows = np.flatnonzero(near)
    for side, sign in enumerate((1.0, -1.0)):
        points = centroids[rows] + sign * HEIGHT * geometry.normals[rows]
        within = body.contains(points) & (of_side[rows, side] < 0)
        of_side[rows[within], side] = material
    return True
