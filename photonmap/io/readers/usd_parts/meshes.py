"""Read meshes and simple shapes of USD stages, one mesh for each material."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import UsdGeom, UsdShade

from photonmap.errors import InputError
from photonmap.io.readers.meshes import Part, build_mesh, check_indices, cut_polygons, move
from photonmap.io.readers.mitsuba_parts import surfaces
from photonmap.io.readers.usd_parts.materials import Materials
from photonmap.io.readers.usd_parts.stage import Stage
from photonmap.scene.mesh import Mesh

Rows = NDArray[np.float64]


def read_meshes(stage: Stage, materials: Materials, prim: Any) -> Iterator[Mesh]:
    """Yield the meshes of a prim: one for each of its subsets of faces that has a material.

    Raises
    ------
    InputError : its faces or values do not fit each other
    """
    name, matrix = stage.name(prim), stage.matrix(prim)
    bound = UsdShade.MaterialBindingAPI(prim)
    if not prim.IsA(UsdGeom.Mesh):
        part = _SHAPES[prim.GetTypeName()](stage, prim)
        yield build_mesh(stage.path, move(part, matrix), materials.of(bound), name)
        return
    mesh = UsdGeom.Mesh(prim)
    sizes = np.array(stage.value(mesh.GetFaceVertexCountsAttr(), ()), np.int64)
    if stage.value(mesh.GetSubdivisionSchemeAttr()) != UsdGeom.Tokens.none:
        stage.lose("subdivision", prim)
    owners = np.zeros(len(sizes), np.int64)
    looks = [materials.of(bound)]
    for subset in bound.GetMaterialBindSubsets():
        faces = np.array(stage.value(subset.GetIndicesAttr(), ()), np.int64)
        check_indices(faces, len(sizes))
        owners[faces] = len(looks)
        inside = subset.GetPrim()
        looks.append(materials.of(UsdShade.MaterialBindingAPI(inside)))
    for index, look in enumerate(looks):
        if (owners == index).any():
            part = _read_part(stage, mesh, sizes, owners == index)
            yield build_mesh(stage.path, move(part, matrix), look, name)


def _read_part(stage: Stage, mesh: Any, sizes: NDArray[np.int64], kept: NDArray[np.bool_]) -> Part:
    """Return the triangles of some faces; corners become vertices of their own."""
    points = np.array(stage.value(mesh.GetPointsAttr(), ()), np.float64).reshape(-1, 3)
    corners = np.array(stage.value(mesh.GetFaceVertexIndicesAttr(), ()), np.int64)
    if (sizes < 0).any() or sizes.sum() != len(corners):
        name = mesh.GetPrim().GetName()
        raise InputError(f"mesh {name}: its faces have {sizes.sum()} corners, but {len(corners)} "
                         "are given; export it again", stage.path)  # fmt: skip
    check_indices(corners, len(points))
    faces = np.repeat(np.arange(len(sizes)), sizes)
    places = {"vertex": corners, "varying": corners, "faceVarying": np.arange(len(corners)),
              "uniform": faces, "constant": np.zeros(len(corners), np.int64)}  # fmt: skip
    api = UsdGeom.PrimvarsAPI(mesh)
    normals = _spread(stage, api.GetPrimvar("normals"), 3, places)
    if normals is None:
        values = np.array(stage.value(mesh.GetNormalsAttr(), ()), np.float64).reshape(-1, 3)
        where = places[mesh.GetNormalsInterpolation()]
        normals = values[where] if len(values) > where.max(initial=-1) and len(values) else None
    uv = _spread(stage, api.GetPrimvar("st"), 2, places)
    uv = _spread(stage, api.GetPrimvar("UVMap"), 2, places) if uv is None else uv
    colors = _spread(stage, mesh.GetDisplayColorPrimvar(), 3, places)
    if UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0]:
        colors = None
    used = kept[faces]
    rows = [None if each is None else each[used] for each in (normals, uv, colors)]
    order = np.arange(np.count_nonzero(used))
    part = cut_polygons(points[corners][used], order, sizes[kept], stage.losses, *rows)
    if mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded:
        return Part(part.vertices, part.faces[:, ::-1], part.normals, part.uv, part.colors)
    return part


def _spread(
    stage: Stage, primvar: Any, columns: int, places: dict[str, NDArray[np.int64]]
) -> Rows | None:
    """Return a value for each corner; None where there are none."""
    if not primvar or not primvar.HasValue():
        return None
    found = primvar.ComputeFlattened(stage.stage.GetStartTimeCode())
    values = np.array(found, np.float64).reshape(-1, columns)
    where = places.get(primvar.GetInterpolation())
    if where is None or where.max(initial=-1) >= len(values):
        stage.lose(f"{primvar.GetPrimvarName()} of a wrong number", primvar.GetAttr().GetPrim())
        return None
    return np.asarray(values[where])


def _sphere(stage: Stage, prim: Any) -> Part:
    return surfaces.sphere(np.zeros(3), stage.value(UsdGeom.Sphere(prim).GetRadiusAttr()))


def _cube(stage: Stage, prim: Any) -> Part:
    half = 0.5 * stage.value(UsdGeom.Cube(prim).GetSizeAttr())
    return move(surfaces.cube(), np.diag([half, half, half, 1.0]))


_SHAPES: dict[str, Callable[[Stage, Any], Part]] = {"Sphere": _sphere, "Cube": _cube}
SHAPES = ("Mesh", *_SHAPES)
"""Types of prims that become meshes."""
