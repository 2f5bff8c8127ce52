"""Read the meshes, lights and cameras of USD stages."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import UsdGeom, UsdLux, UsdShade

from photonmap.errors import InputError
from photonmap.io.readers import meshes
from photonmap.io.readers.decoding import Ints, plain, point_ahead
from photonmap.io.readers.environment_maps import turned_map
from photonmap.io.readers.usd_stage import Materials, Stage, radiance_of
from photonmap.runtime.files import named_image
from photonmap.scene.camera import Camera, Lens, check_camera
from photonmap.scene.lights import DirectionalLight, DomeLight, Light, PointLight, SpotLight
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.projections import Intrinsics
from photonmap.spectra.curves import Floats

TENTH = 0.1  # Apertures and focal lengths are in tenths of scene units
_PIXELS = 1000.0
_SIZED = ("RectLight", "DiskLight", "SphereLight")
_SUN, _SKY = "DistantLight", "DomeLight"
_EVERYWHERE = 90.0  # Half-angle of a cone, degrees, from which on a light shines as without one
_FLIP = np.diag([1.0, -1.0, -1.0, 1.0])  # From shapes that face +z to lights that face -z
Rows = Floats


def read_camera(stage: Stage, prim: Any) -> Camera:
    """Return a camera; the shape of its picture is that of the render."""
    camera, matrix = UsdGeom.Camera(prim), stage.matrix(prim)
    value = stage.value
    origin, ahead = matrix[:3, 3], -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    high = float(value(camera.GetVerticalApertureAttr(), 15.2908))
    wide = float(value(camera.GetHorizontalApertureAttr(), 20.955))
    shifts = (camera.GetHorizontalApertureOffsetAttr(), camera.GetVerticalApertureOffsetAttr())
    across, up = (float(value(attribute, 0.0)) for attribute in shifts)
    focal = float(value(camera.GetFocalLengthAttr(), 50.0))
    look: dict[str, Any] = {"fov": math.degrees(2.0 * math.atan(0.5 * high / focal))}
    if value(camera.GetProjectionAttr()) == UsdGeom.Tokens.orthographic:
        look = {"height": TENTH * high}
        origin = origin + TENTH * (across * matrix[:3, 0] + up * matrix[:3, 1])
    elif across or up:
        size = (round(_PIXELS * wide), round(_PIXELS * high))
        fx, cx, cy = _PIXELS * focal, 0.5 * wide - across, 0.5 * high + up
        look = {"projection": Intrinsics(fx, size, fx, _PIXELS * cx, _PIXELS * cy)}
    number = float(value(camera.GetFStopAttr(), 0.0))
    if number > 0.0:
        focus = float(value(camera.GetFocusDistanceAttr(), 0.0))
        look["lens"] = Lens(focus, f_number=number, focal_length=TENTH * focal)
    return check_camera(
        Camera(
            plain(origin),
            point_ahead(origin, ahead),
            plain(matrix[:3, 1]),
            name=stage.name(prim),
            **look,
        ),
        stage.path,
    )


def read_light(stage: Stage, prim: Any) -> Light | Mesh | None:
    """Return a light, or the mesh that it becomes; None, and noted, for other types."""
    kind, name = prim.GetTypeName(), stage.name(prim)
    light = (
        UsdLux.BoundableLightBase(prim) if kind in _SIZED else UsdLux.NonboundableLightBase(prim)
    )
    if kind not in (*_SIZED, _SUN, _SKY, "DomeLight_1"):
        stage.lose(f"lights of type {kind}", prim)
        return None
    amount, is_whole = radiance_of(stage, light), stage.value(light.GetNormalizeAttr(), False)
    if kind == _SUN:
        return _sun(stage, prim, name, (amount, is_whole))
    if kind in _SIZED:
        return _shape(stage, prim, name, (amount, is_whole))
    file = getattr(stage.value(UsdLux.DomeLight(prim).GetTextureFileAttr()), "path", "")
    if not file:
        return DomeLight(plain(amount), name=name)
    if np.ptp(amount) > 0.0:
        stage.lose("colour of a sky with an image", prim)
    path: Path = named_image(stage.path.parent, file)
    return turned_map(path, stage.matrix(prim)[:3, :3], float(amount.mean()), name)


def _sun(stage: Stage, prim: Any, name: str, shines: tuple[Floats, bool]) -> Light:
    """Return a sun; without `normalize` its radiance counts, over a disk of its angle."""
    amount, is_whole = shines
    angle = math.radians(stage.value(UsdLux.DistantLight(prim).GetAngleAttr(), 0.53))
    if not is_whole and angle > 0.0:
        amount = amount * math.pi * math.sin(0.5 * min(angle, math.pi)) ** 2
    ahead = -stage.matrix(prim)[:3, 2]
    return DirectionalLight(plain(ahead), plain(amount), name=name)


def _shape(stage: Stage, prim: Any, name: str, shines: tuple[Floats, bool]) -> Mesh | Light:
    """Return the mesh of a light that has a size; `normalize` divides by its area."""
    amount, is_whole = shines
    matrix, kind = stage.matrix(prim), prim.GetTypeName()
    if kind == "SphereLight":
        light = UsdLux.SphereLight(prim)
        radius = stage.value(light.GetRadiusAttr(), 0.5)
        if stage.value(light.GetTreatAsPointAttr(), False) or radius == 0.0:
            factor = 0.25 if is_whole else math.pi * radius**2
            return _point(stage, prim, name, amount * factor)
        part = meshes.move(meshes.sphere(np.zeros(3), radius), matrix)
    elif kind == "DiskLight":
        radius = stage.value(UsdLux.DiskLight(prim).GetRadiusAttr(), 0.5)
        part = meshes.move(meshes.disk(), matrix @ _FLIP @ np.diag([radius, radius, 1.0, 1.0]))
    else:
        light = UsdLux.RectLight(prim)
        if stage.value(light.GetTextureFileAttr()):
            stage.lose("textures of lights", prim)
        wide = 0.5 * stage.value(light.GetWidthAttr(), 1.0)
        high = 0.5 * stage.value(light.GetHeightAttr(), 1.0)
        part = meshes.move(meshes.rectangle(), matrix @ _FLIP @ np.diag([wide, high, 1.0, 1.0]))
    if _cone(stage, prim)[0] < _EVERYWHERE:
        stage.lose("cones of lights that have a size", prim)
    if is_whole:
        a, b, c = (part.vertices[part.faces[:, corner]] for corner in range(3))
        amount = amount / (0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    return meshes.build_mesh(stage.path, part, Material(name, 0.0, plain(amount)), name)


def _point(stage: Stage, prim: Any, name: str, intensity: Floats) -> Light:
    matrix, (outer, softness) = stage.matrix(prim), _cone(stage, prim)
    place = matrix[:3, 3]
    if outer >= _EVERYWHERE:
        return PointLight(plain(place), plain(intensity), name=name)
    target, inner = place - matrix[:3, 2], outer * (1.0 - min(max(softness, 0.0), 1.0))
    return SpotLight(plain(place), plain(target), plain(intensity), inner, outer, name=name)


def _cone(stage: Stage, prim: Any) -> tuple[float, float]:
    """Return the half-angle of a light's cone, degrees, and how soft its edge is."""
    if not prim.HasAPI(UsdLux.ShapingAPI):
        return 180.0, 0.0
    shaping = UsdLux.ShapingAPI(prim)
    if stage.value(shaping.GetShapingFocusAttr(), 0.0) or shaping.GetShapingIesFileAttr().Get():
        stage.lose("focus or IES file of lights", prim)
    softness = stage.value(shaping.GetShapingConeSoftnessAttr(), 0.0)
    return stage.value(shaping.GetShapingConeAngleAttr(), _EVERYWHERE), softness


def read_meshes(stage: Stage, materials: Materials, prim: Any) -> Iterator[Mesh]:
    """Yield the meshes of a prim: one for each of its subsets of faces that has a material."""
    name, matrix = stage.name(prim), stage.matrix(prim)
    bound = UsdShade.MaterialBindingAPI(prim)
    if not prim.IsA(UsdGeom.Mesh):
        part = _SHAPES[prim.GetTypeName()](stage, prim)
        yield meshes.build_mesh(stage.path, meshes.move(part, matrix), materials.of(bound), name)
        return
    mesh = UsdGeom.Mesh(prim)
    sizes = np.array(stage.value(mesh.GetFaceVertexCountsAttr(), ()), np.int64)
    if stage.value(mesh.GetSubdivisionSchemeAttr()) != UsdGeom.Tokens.none:
        stage.lose("subdivision", prim)
    owners = np.zeros(len(sizes), np.int64)
    looks = [materials.of(bound)]
    for subset in bound.GetMaterialBindSubsets():
        faces = np.array(stage.value(subset.GetIndicesAttr(), ()), np.int64)
        meshes.check_indices(faces, len(sizes))
        owners[faces] = len(looks)
        inside = subset.GetPrim()
        looks.append(materials.of(UsdShade.MaterialBindingAPI(inside)))
    for index, look in enumerate(looks):
        if (owners == index).any():
            part = _read_part(stage, mesh, sizes, owners == index)
            yield meshes.build_mesh(stage.path, meshes.move(part, matrix), look, name)


def _read_part(stage: Stage, mesh: Any, sizes: Ints, kept: NDArray[np.bool_]) -> meshes.Part:
    points = np.array(stage.value(mesh.GetPointsAttr(), ()), np.float64).reshape(-1, 3)
    corners = np.array(stage.value(mesh.GetFaceVertexIndicesAttr(), ()), np.int64)
    if (sizes < 0).any() or sizes.sum() != len(corners):
        name = mesh.GetPrim().GetName()
        raise InputError(f"mesh {name}: its faces have {sizes.sum()} corners, but {len(corners)} "
                         "are given; export it again", stage.path)  # fmt: skip
    meshes.check_indices(corners, len(points))
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
    part = meshes.cut_polygons(points[corners][used], order, sizes[kept], stage.losses, *rows)
    if mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded:
        return meshes.Part(part.vertices, part.faces[:, ::-1], part.normals, part.uv, part.colors)
    return part


def _spread(stage: Stage, primvar: Any, columns: int, places: dict[str, Ints]) -> Rows | None:
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


def _sphere(stage: Stage, prim: Any) -> meshes.Part:
    return meshes.sphere(np.zeros(3), stage.value(UsdGeom.Sphere(prim).GetRadiusAttr()))


def _cube(stage: Stage, prim: Any) -> meshes.Part:
    half = 0.5 * stage.value(UsdGeom.Cube(prim).GetSizeAttr())
    return meshes.move(meshes.cube(), np.diag([half, half, half, 1.0]))


_SHAPES: dict[str, Callable[[Stage, Any], meshes.Part]] = {"Sphere": _sphere, "Cube": _cube}
SHAPES = ("Mesh", *_SHAPES)  # Types of prims that become meshes
