"""The meshes, shapes and point instancers of USD stages."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers import meshes
from photonmap.io.readers.decoding import Ints
from photonmap.io.readers.usd.lights import is_light
from photonmap.io.readers.usd.materials import Look
from photonmap.io.readers.usd.stage import Stage
from photonmap.runtime.bounds import OF_TRIANGLE
from photonmap.scene.mesh import Mesh
from photonmap.scene.textures import is_black
from photonmap.spectra.curves import Floats

if find_spec("pxr") is not None:
    from pxr import Usd, UsdGeom, UsdShade, UsdSkel

MOST_COPIES = 1_000_000
"""Meshes that point instancers may show: instancers within instancers multiply"""
_USUAL = ("st", "UVMap")  # Names of texture coordinates where a material names none
_AXES = {
    "X": np.array([[0.0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]),
    "Y": np.array([[0.0, 1, 0, 0], [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 1]]),
    "Z": np.eye(4),
}
"""From shapes along z to those along another axis"""


class Piece(NamedTuple):
    """A mesh to be made: a part in the coordinates of the scene or of a prototype, and its look."""

    part: meshes.Part
    look: Look
    prim: Any
    copy: tuple[Any, ...] = ()  # by which instance it is shown
    name: str = ""


@dataclass
class Geometry:
    """What a stage shows: meshes to be made among those that lights are, and their materials."""

    stage: Stage
    items: list[Mesh | Piece] = field(default_factory=list)
    _looks: dict[str, Look] = field(default_factory=dict)
    _prototypes: dict[str, list[Piece]] = field(default_factory=dict)
    _within: list[Any] = field(default_factory=list)  # instancers whose prototypes are read
    _copies: int = 0

    def add(self, prim: Any) -> None:
        """Take what a prim shows where it is."""
        matrix = self.stage.matrix(prim)
        if not prim.IsA(UsdGeom.PointInstancer):
            name = self.stage.name(prim)
            for piece in self._read(prim):
                moved = meshes.move(piece.part, matrix)
                self.items.append(piece._replace(part=moved, name=name))
            return
        names: dict[Any, str] = {}
        for piece in self._instances(prim, matrix):
            key = str(piece.prim.GetPath()), piece.copy
            if key not in names:
                names[key] = self.stage.name(piece.prim)
            self.items.append(piece._replace(name=names[key]))

    def build(self) -> Iterator[Mesh]:
        """Yield the meshes."""
        for item in self.items:
            if isinstance(item, Mesh):
                yield item
                continue
            part, material = item.part, item.look.material
            if part.colors is not None and material.is_textured:
                self.stage.lose("colours of vertices beside textures", item.prim)
                part = replace(part, colors=None)
            is_double = UsdGeom.Gprim(item.prim).GetDoubleSidedAttr().Get()
            if is_double and not is_black(material.emission) and not meshes.is_closed(part):
                self.stage.lose("emission from the back (doubleSided)", item.prim)
            yield meshes.build_mesh(self.stage.path, part, material, item.name)

    def _look(self, prim: Any) -> Look:
        """Return the material of a prim, the same one each time."""
        api = UsdShade.MaterialBindingAPI(prim)
        for purpose in (UsdShade.Tokens.full, UsdShade.Tokens.preview):
            if material := api.ComputeBoundMaterial(purpose)[0]:
                break
        path = str(material.GetPath()) if material else ""
        found = material.GetPrim() if material else None
        return self._looks.setdefault(path, Look(self.stage, found))

    def _read(self, prim: Any) -> Iterator[Piece]:
        """Yield the pieces of a prim: one for each of its subsets of faces that has a material."""
        stage = self.stage
        if is_light(prim):
            stage.lose("lights of surfaces", prim)
        look = self._look(prim)
        is_left = stage.value(UsdGeom.Gprim(prim).GetOrientationAttr()) == "leftHanded"
        opacity = UsdGeom.Gprim(prim).GetDisplayOpacityPrimvar()
        if not look.prim and opacity.HasValue() and min(opacity.ComputeFlattened(stage.time)) < 1.0:
            stage.lose("displayOpacity", prim)
        if not prim.IsA(UsdGeom.Mesh):
            part = _SHAPES[prim.GetTypeName()](stage, prim)
            stage.budget.spend(OF_TRIANGLE * len(part.faces))
            where = {"constant": np.zeros(len(part.vertices), np.int64)}
            if look.colors:
                part = replace(part, colors=_spread(stage, prim, look.colors, 3, where))
            look.reach(part.uv)
            yield Piece(_flipped(part) if is_left else part, look, prim)
            return
        for chosen, kept in self._subsets(prim, look):
            part = _read_part(stage, UsdGeom.Mesh(prim), chosen, kept)
            chosen.reach(part.uv)
            turned = replace(part, faces=part.faces[:, ::-1]) if is_left else part
            yield Piece(turned, chosen, prim)

    def _subsets(self, prim: Any, look: Look) -> Iterator[tuple[Look, NDArray[np.bool_]]]:
        """Yield each material of a mesh, and which of its faces have it."""
        stage, mesh = self.stage, UsdGeom.Mesh(prim)
        count = len(stage.value(mesh.GetFaceVertexCountsAttr(), ()))
        if stage.value(mesh.GetSubdivisionSchemeAttr()) != UsdGeom.Tokens.none:
            stage.lose("subdivision", prim)
        skin = UsdSkel.BindingAPI(prim)
        if skin.GetJointIndicesAttr().HasValue() or skin.GetBlendShapeTargetsRel().GetTargets():
            stage.lose("skinning", prim)
        owners, looks = np.zeros(count, np.int64), [look]
        binding = UsdShade.MaterialBindingAPI(prim)
        for subset in binding.GetMaterialBindSubsets() if prim.GetChildren() else ():
            if stage.value(subset.GetElementTypeAttr(), "face") != "face":
                stage.lose("materials of parts other than faces", subset.GetPrim())
                continue
            faces = np.array(stage.value(subset.GetIndicesAttr(), ()), np.int64)
            meshes.check_indices(faces, count)
            owners[faces] = len(looks)
            looks.append(self._look(subset.GetPrim()))
        if len(holes := stage.value(mesh.GetHoleIndicesAttr(), ())):
            holes = np.array(holes, np.int64)
            meshes.check_indices(holes, count)
            owners[holes] = -1
        for index, each in enumerate(looks):
            if (owners == index).any():
                yield each, owners == index

    def _instances(self, prim: Any, matrix: Floats) -> list[Piece]:
        """Return what a point instancer shows, moved by a matrix."""
        stage, instancer = self.stage, UsdGeom.PointInstancer(prim)
        if prim in self._within:
            raise InputError("it is an instance of itself; export it again")
        targets = instancer.GetPrototypesRel().GetTargets()
        chosen = _chosen(stage, instancer, len(targets))
        for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithValues():
            stage.lose(f"{primvar.GetPrimvarName()} of instances", prim)
        self._within.append(prim)
        prototypes = [self._prototype(target) for target in targets]
        self._within.pop()
        moved = instancer.ComputeInstanceTransformsAtTime(
            stage.time, stage.time, instancer.ExcludeProtoXform, instancer.IgnoreMask
        )
        mask = np.array(instancer.ComputeMaskAtTime(stage.time), bool)
        shown = np.flatnonzero(mask if len(mask) else np.ones(len(chosen), bool))
        sizes = np.array([len(each) for each in prototypes], np.int64)
        if len(shown) and sizes[chosen[shown]].sum() > MOST_COPIES:
            message = f"its point instancers show more than {MOST_COPIES} meshes"
            raise InputError(f"{message}; export fewer instances")
        counts = np.array([sum(len(each.part.faces) for each in some) for some in prototypes])
        stage.budget.spend(OF_TRIANGLE * int(counts[chosen[shown]].sum()) if len(shown) else 0)
        result = []
        for index in shown.tolist():
            whole = matrix @ np.array(moved[index], np.float64).T
            self._copies += 1
            for piece in prototypes[chosen[index]]:
                placed = meshes.move(piece.part, whole)
                result.append(piece._replace(part=placed, copy=(self._copies, piece.copy)))
        return result

    def _prototype(self, target: Any) -> list[Piece]:
        """Return what a prototype shows, in the coordinates of its parent."""
        stage, path = self.stage, str(target)
        if path in self._prototypes:
            return self._prototypes[path]
        root = stage.stage.GetPrimAtPath(target)
        if not root:
            raise InputError(f"its prototype {target} does not exist; export it again")
        above = np.linalg.inv(stage.matrix(root.GetParent()))
        everything = Usd.PrimIsActive & Usd.PrimIsLoaded  # classes and overs hold prototypes, too
        prims = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies(everything)))
        result = []
        for prim in prims:
            matrix = above @ stage.matrix(prim)
            if prim.IsA(UsdGeom.PointInstancer):
                prims.PruneChildren()
                result += self._instances(prim, matrix) if _is_shown(stage, prim, root) else []
            elif prim.GetTypeName() in SHAPES and _is_shown(stage, prim, root):
                for piece in self._read(prim):
                    result.append(piece._replace(part=meshes.move(piece.part, matrix)))
            elif is_light(prim) or prim.IsA(UsdGeom.Camera) or not is_known(prim):
                stage.lose(f"{prim.GetTypeName()} of instances", prim)
        self._prototypes[path] = result
        return result


def _chosen(stage: Stage, instancer: Any, count: int) -> Ints:
    """Return which prototype each instance shows; refuse lists that do not fit together."""
    chosen = np.array(stage.value(instancer.GetProtoIndicesAttr(), ()), np.int64)
    wrong = chosen[(chosen < 0) | (chosen >= count)]
    if wrong.size:
        raise InputError(f"an instance shows prototype {wrong[0]}, but there are {count}, "
                         "counted from 0; export it again")  # fmt: skip
    lists = ("positions", "orientations", "orientationsf", "scales", "ids")
    for name in lists:
        rows = stage.value(instancer.GetPrim().GetAttribute(name), ())
        if len(rows) != len(chosen) and (len(rows) or name == "positions"):
            raise InputError(f"has {len(rows)} {name} for {len(chosen)} instances; export it again")
    return chosen


def _is_shown(stage: Stage, prim: Any, root: Any) -> bool:
    """Return whether a prim of a prototype is visible when rendered, whatever is above it."""
    purpose = None
    while True:
        item = UsdGeom.Imageable(prim)
        if item and stage.value(item.GetVisibilityAttr()) == UsdGeom.Tokens.invisible:
            return False
        if item and purpose is None and item.GetPurposeAttr().HasAuthoredValue():
            purpose = item.GetPurposeAttr().Get()
        if prim == root:
            return purpose in (None, UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
        prim = prim.GetParent()


def _read_part(stage: Stage, mesh: Any, look: Look, kept: NDArray[np.bool_]) -> meshes.Part:
    """Read those faces of a mesh that have a material."""
    sizes = np.array(stage.value(mesh.GetFaceVertexCountsAttr(), ()), np.int64)
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
    prim = mesh.GetPrim()
    normals = _spread(stage, prim, "normals", 3, places)
    if normals is None:
        values = np.array(stage.value(mesh.GetNormalsAttr(), ()), np.float64).reshape(-1, 3)
        where = places[mesh.GetNormalsInterpolation()]
        if len(values) and len(values) > where.max(initial=-1):
            normals = values[where]
        elif len(values):
            stage.lose("normals of a wrong number", prim)
    uv = _coordinates(stage, prim, look, places)
    colors = _spread(stage, prim, look.colors, 3, places) if look.colors else None
    used: Any = slice(None) if kept.all() else kept[faces]
    rows = [None if each is None else each[used] for each in (normals, uv, colors)]
    vertices = points[corners[used]]
    order = np.arange(len(vertices))
    stage.budget.spend(OF_TRIANGLE // 3 * len(order))
    return meshes.cut_polygons(vertices, order, sizes[kept], stage.losses, *rows)


def _coordinates(stage: Stage, prim: Any, look: Look, places: dict[str, Ints]) -> Floats | None:
    """Return the texture coordinates that a material names; those that are usual without any."""
    lie = look.lie
    wanted = lie.primvar if lie else ""
    for name in ([wanted] if wanted else []) + [name for name in _USUAL if name != wanted]:
        uv = _spread(stage, prim, name, 2, places)
        if uv is not None:
            if wanted and name != wanted:
                stage.lose(f"texture coordinates {wanted!r}, which are missing,", prim)
            return lie.turn(uv) if lie else uv
    return None


def _spread(
    stage: Stage, prim: Any, name: str, columns: int, places: dict[str, Ints]
) -> Floats | None:
    """Return a value of a prim, or of those above it, for each corner; None without any."""
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
    if not primvar or not primvar.HasValue():
        return None
    attribute, found = primvar.GetAttr(), primvar.ComputeFlattened(stage.time)
    if stage.moves and attribute.GetNumTimeSamples() > 1:
        stage.lose("animation", prim)
    values = np.array(found, np.float64).reshape(-1, columns)
    if columns == 3:
        values = stage.linear_srgb(attribute, values, 1.0)
    where = places.get(primvar.GetInterpolation())
    if where is None or where.max(initial=-1) >= len(values):
        stage.lose(f"{name} of a wrong number", prim)
        return None
    return np.asarray(values[where])


def _flipped(part: meshes.Part) -> meshes.Part:
    """Return a shape that faces inwards."""
    normals = None if part.normals is None else -part.normals
    return replace(part, faces=part.faces[:, ::-1], normals=normals)


def _number(stage: Stage, prim: Any, name: str) -> float:
    value = float(stage.value(prim.GetAttribute(name)))
    if not 0.0 <= value < math.inf:
        raise InputError(f"its {name} is {value:g}; give a finite number of at least 0")
    return value


def _along(stage: Stage, prim: Any, part: meshes.Part) -> meshes.Part:
    """Return a shape about z about the axis that a prim states."""
    return meshes.move(part, _AXES[stage.value(prim.GetAttribute("axis"), "Z")])


def _sphere(stage: Stage, prim: Any) -> meshes.Part:
    return meshes.sphere(np.zeros(3), _number(stage, prim, "radius"))


def _cube(stage: Stage, prim: Any) -> meshes.Part:
    half = 0.5 * _number(stage, prim, "size")
    return meshes.move(meshes.cube(), np.diag([half, half, half, 1.0]))


def _plane(stage: Stage, prim: Any) -> meshes.Part:
    wide, long = (0.5 * _number(stage, prim, name) for name in ("width", "length"))
    if stage.value(prim.GetAttribute("axis"), "Z") != "Z":
        wide, long = long, wide  # Along y and z, and along z and x: as the axis is turned
    return _along(stage, prim, meshes.move(meshes.rectangle(), np.diag([wide, long, 1.0, 1.0])))


def _radii(stage: Stage, prim: Any) -> tuple[float, float]:
    """Return the radii of a shape at its top and its bottom."""
    names = ("radiusTop", "radiusBottom")
    names = names if prim.HasAttribute(names[0]) else ("radius", "radius")
    top, bottom = (_number(stage, prim, name) for name in names)
    return (0.0, bottom) if prim.GetTypeName() == "Cone" else (top, bottom)


def _cylinder(stage: Stage, prim: Any) -> meshes.Part:
    """Return a cylinder or a cone with closed ends."""
    half, (top, bottom) = 0.5 * _number(stage, prim, "height"), _radii(stage, prim)
    slope = np.array([2.0 * half, bottom - top])
    outwards = slope / max(float(np.linalg.norm(slope)), np.finfo(float).tiny)
    rows = np.array([
        [0.0, half, 0.0, 1.0], [top, half, 0.0, 1.0],
        [top, half, *outwards], [bottom, -half, *outwards],
        [bottom, -half, 0.0, -1.0], [0.0, -half, 0.0, -1.0],
    ])  # fmt: skip
    return _along(stage, prim, _revolved(rows, meshes.CIRCLE_EDGES))


def _capsule(stage: Stage, prim: Any) -> meshes.Part:
    """Return two spheres and the cone that touches both."""
    half, (top, bottom) = 0.5 * _number(stage, prim, "height"), _radii(stage, prim)
    rise = bottom - top
    seam = (
        math.asin(min(max(rise / (2.0 * half), -1.0), 1.0))
        if half > 0.0
        else math.copysign(0.5 * math.pi if rise else 0.0, rise)
    )
    rows = []
    for radius, place, ends in (
        (top, half, (0.5 * math.pi, seam)),
        (bottom, -half, (seam, -0.5 * math.pi)),
    ):
        angle = np.linspace(*ends, meshes.SPHERE_EDGES // 4 + 1)
        across, up = np.cos(angle), np.sin(angle)
        across[np.abs(across) < 1e-12] = 0.0
        rows.append(np.stack([radius * across, place + radius * up, across, up], axis=1))
    return _along(stage, prim, _revolved(np.concatenate(rows), meshes.SPHERE_EDGES))


def _revolved(rows: Floats, edges: int) -> meshes.Part:
    """Return what a profile, from top to bottom, becomes when it is turned about z.

    rows : (P, 4) radius and z, and both of the normal; two rows of one place are an edge
    """
    azimuth = np.linspace(0.0, 2.0 * math.pi, edges + 1)
    around = np.stack([np.cos(azimuth), np.sin(azimuth), np.ones(edges + 1)], axis=1)
    around[-1] = around[0]
    vertices, normals = (
        (rows[:, None, columns] * around).reshape(-1, 3) for columns in ([0, 0, 1], [2, 2, 3])
    )
    across, down = np.meshgrid(azimuth / azimuth[-1], np.linspace(1.0, 0.0, len(rows)))
    first = np.arange(edges)
    faces = []
    for row in range(len(rows) - 1):
        if (rows[row, :2] == rows[row + 1, :2]).all():
            continue
        upper, lower = row * (edges + 1) + first, (row + 1) * (edges + 1) + first
        if rows[row + 1, 0] > 0.0:
            faces.append(np.stack([upper, lower, lower + 1], axis=1))
        if rows[row, 0] > 0.0:
            faces.append(np.stack([upper, lower + 1, upper + 1], axis=1))
    if not faces:
        raise InputError("it has no area; give it a radius above 0")
    uv = np.stack([across.ravel(), down.ravel()], axis=1)
    return meshes.Part(vertices, np.concatenate(faces), normals, uv)


_SHAPES: dict[str, Callable[[Stage, Any], meshes.Part]] = {
    "Sphere": _sphere, "Cube": _cube, "Plane": _plane, "Cylinder": _cylinder,
    "Cylinder_1": _cylinder, "Cone": _cylinder, "Capsule": _capsule, "Capsule_1": _capsule,
}  # fmt: skip
SHAPES = ("Mesh", *_SHAPES)  # Types of prims that become meshes
_SILENT = (
    "", "Xform", "Scope", "Material", "Shader", "GeomSubset", "NodeGraph", "Skeleton", "SkelRoot",
)  # fmt: skip
"""Types of prims that show nothing by themselves."""


def is_known(prim: Any) -> bool:
    """Return whether the type of a prim is drawn, or shows nothing by itself."""
    return prim.GetTypeName() in (*_SILENT, *SHAPES)
