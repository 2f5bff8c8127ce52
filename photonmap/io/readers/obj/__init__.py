"""Read Wavefront OBJ files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming, warn
from photonmap.io.readers.decoding import Ints
from photonmap.io.readers.meshes import triangulate, vertex_normals
from photonmap.io.readers.obj.lines import ObjLines, Source, parse_lines, read_source
from photonmap.io.readers.obj.mtl import read_mtl
from photonmap.io.readers.registry import GREY, MissingTextures, ReadOptions
from photonmap.runtime.files import named_file
from photonmap.runtime.wording import listed, shown, suggest
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene

SUFFIXES = (".obj",)

_KEYWORD = "s"
_OFF = ("", "0", "off")  # What stands behind the keyword where faces are flat
_NAMED = 8  # MTL files that are not there, named one by one
_SPARSE = 64  # Numbers of vertices for each that is used, from which on a table of all is too long


def read(path: Path, options: ReadOptions) -> Scene:
    """Read the surfaces of an OBJ file and their materials.

    There is one mesh for each object and material. An object is named by its `o` line, or by
    its `g` line where there is no `o`, or else by the file. Polygons are cut into triangles;
    vertices are split where normals or texture coordinates differ, and unused ones are left
    out. Faces of a smoothing group (`s`) without normals get smooth ones. Faces before any
    `usemtl` get the default `Material`, and those of a material that is in no MTL file a grey one
    of its name, with a warning. Colours of vertices replace the reflectance of their material,
    unless it has a texture or is glass.

    Returns Scene, its meshes in the order of their first faces
    """
    source = read_source(path, "OBJ")
    lines = smooth(parse_lines(source))
    parts, part_of = _divide(lines, path.stem)
    used = dict.fromkeys(parts[number][1] for number in np.flatnonzero(np.bincount(part_of)))
    materials = _find_materials(source, lines, used, options.missing_textures)
    triangles, owners = _triangulate(source, lines)
    _warn_of_losses(path, lines, owners)
    del source  # its text is no longer needed
    part_of = part_of[owners]
    order = np.argsort(part_of, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(part_of[order])) + 1)
    meshes = [
        _build_mesh(lines, lines.corners[triangles[group].ravel()], name, materials[material])
        for group in sorted(groups, key=lambda group: int(group[0]))
        for name, material in [parts[part_of[group[0]]]]
    ]
    return Scene(_drop_colors(path, meshes), name=path.stem)


def read_shape(path: Path) -> Mesh:
    """Read all faces of an OBJ file as one mesh, whatever their objects, materials and groups."""
    source = read_source(path, "OBJ")
    lines = parse_lines(source)
    triangles, _ = _triangulate(source, lines)
    return _build_mesh(lines, lines.corners[triangles.ravel()], path.stem, Material())


def _triangulate(source: Source, lines: ObjLines) -> tuple[Ints, Ints]:
    if not len(lines.sizes):
        raise InputError("has no faces; export the surfaces as polygons", source.path)
    triangles, owners = triangulate(lines.vertices, lines.corners[:, 0] - 1, lines.sizes)
    if not len(triangles):
        raise InputError("has no face with an area; check the vertices", source.path)
    return triangles, owners


def _divide(lines: ObjLines, stem: str) -> tuple[list[tuple[str, str]], Ints]:
    """Return the pairs of object and material, and the pair that each face belongs to."""
    current = {"o": "", "g": "", "usemtl": ""}
    parts = {(stem, ""): 0}
    marks = [(0, 0)]
    for offset, keyword, name in lines.states:
        if keyword in current:
            current[keyword] = name
            part = (current["o"] or current["g"] or stem, current["usemtl"])
            marks.append((offset, parts.setdefault(part, len(parts))))
    return list(parts), _spread(lines, marks)


def _spread(lines: ObjLines, marks: list[tuple[int, int]]) -> Ints:
    """Return for each face, (F,), the number of the last mark before it: (offset, number)."""
    offsets, numbers = np.array(marks).T
    return numbers[np.searchsorted(offsets, lines.offsets, "right") - 1]


def _build_mesh(lines: ObjLines, corners: NDArray[np.int32], name: str, material: Material) -> Mesh:
    distinct, faces = _distinct(corners)
    at, uv_at, normal_at = distinct.T
    uv = normals = None
    if uv_at.any():
        uv = np.where(uv_at[:, None] > 0, lines.uv[uv_at - 1], 0.0)
    if normal_at.any():
        normals = np.where(normal_at[:, None] > 0, lines.normals[normal_at - 1], 0.0)
    colors = None if lines.colors is None else lines.colors[at - 1]
    if colors is not None:
        colors = None if np.isnan(colors).all() else np.nan_to_num(colors, nan=GREY)
    vertices = lines.vertices[at - 1]
    return Mesh(vertices, faces.reshape(-1, 3), material, name, normals, uv, colors)


def _distinct(rows: NDArray[np.int32]) -> tuple[NDArray[np.int32], Ints]:
    """Return the distinct rows of three indices in ascending order, and which one each row is."""
    if not rows[:, 1:].any() and int(rows[:, 0].max()) < _SPARSE * len(rows):
        used = np.zeros(int(rows[:, 0].max()) + 1, np.bool_)
        used[rows[:, 0]] = True
        distinct = np.zeros((np.count_nonzero(used), 3), np.int32)
        distinct[:, 0] = np.flatnonzero(used)
        return distinct, (np.cumsum(used) - 1)[rows[:, 0]]
    code = rows[:, 0].astype(np.int64)
    for column in rows.T[1:]:
        width = int(column.max()) + 1
        if (int(code.max()) + 1) * width > np.iinfo(np.int64).max:
            code = np.unique(code, return_inverse=True)[1]
        code = code * width + column
    _, first, inverse = np.unique(code, return_index=True, return_inverse=True)
    return rows[first], inverse


def _find_materials(
    source: Source, lines: ObjLines, used: Iterable[str], missing_textures: MissingTextures
) -> Mapping[str, Material]:
    """Return the materials of all MTL files, of one name the first; "" is the default material.

    What MTL files say of materials that are not used is not read.
    """
    wanted = [name for name in used if name]
    materials: dict[str, Material] = {}
    needed, known = set(wanted), set[str | Path]()
    lost: dict[str, int] = {}
    for offset, keyword, names in lines.states:
        if keyword != "mtllib" or names in known:
            continue
        known.add(names)
        for path in _find_libraries(source, offset, names, lost):
            if path not in known:
                known.add(path)
                for name, material in read_mtl(path, missing_textures, needed).items():
                    materials.setdefault(name, material)
    _warn_of_lost(source, lost)
    if missing := [name for name in wanted if name not in materials]:
        remedy = f"; {suggest(missing[0], materials)}" if materials else ""
        warn(
            f"{source.path}: {len(missing)} of {len(wanted)} materials are in no MTL file and "
            f"become {GREY} grey: {listed(missing)}{remedy}"
        )
    return materials | {name: Material(name) for name in missing} | {"": Material()}


def _find_libraries(
    source: Source, offset: int, names: str, lost: dict[str, int]
) -> Iterator[Path]:
    """Yield the MTL files of a line; what is not there is entered with the line's offset."""
    folder = source.path.parent
    with naming("mtllib", source.path, lambda: source.line_number(offset)):
        chosen = [names] if _find(folder, names) else names.split()
        found = {name: _find(folder, name) for name in chosen}
    for name, path in found.items():
        if path is None:
            lost.setdefault(name, offset)
        elif not path.stat().st_size:
            warn(str(source.error(f"MTL file {shown(name)} is empty; export it again", offset)))
        else:
            yield path


def _warn_of_lost(source: Source, lost: dict[str, int]) -> None:
    """Name the MTL files that are not there, the first few of them."""
    if not lost:
        return
    known = sorted(each.name for each in source.path.parent.glob("*.[mM][tT][lL]"))
    for name, offset in islice(lost.items(), _NAMED):
        problem = f"MTL file {shown(name)} is not beside the OBJ; {suggest(name, known)}"
        warn(str(source.error(problem, offset)))
    if len(lost) > _NAMED:
        warn(f"{source.path}: {len(lost) - _NAMED} more MTL files are not beside the OBJ")


def _find(folder: Path, name: str) -> Path | None:
    """Return the file of a name that may have Windows' separators; None if there is none."""
    for candidate in (name, name.replace("\\", "/")):
        path = named_file(folder, candidate)
        try:
            if path.is_file():
                return path
        except (OSError, ValueError):
            continue
    return None


def _drop_colors(path: Path, meshes: list[Mesh]) -> list[Mesh]:
    """Remove the colours of meshes with textures or of glass, and name these."""
    lost = [
        mesh
        for mesh in meshes
        if mesh.colors is not None and (mesh.material.is_textured or mesh.material.ior is not None)
    ]
    if lost:
        names = listed({mesh.material.name: None for mesh in lost})
        warn(
            f"{path}: colours of vertices are not used in {len(lost)} of {len(meshes)} "
            f"meshes, whose material has textures or is glass: {names}"
        )
    dropped = set(map(id, lost))
    return [replace(mesh, colors=None) if id(mesh) in dropped else mesh for mesh in meshes]


def _warn_of_losses(path: Path, lines: ObjLines, owners: Ints) -> None:
    """Name all that was read but is not in the meshes."""
    if lines.others:
        total = sum(lines.others.values())
        warn(f"{path}: {total} lines are not simulated: {listed(lines.others)}")
    if flat := len(lines.sizes) - np.count_nonzero(np.bincount(owners)):
        warn(f"{path}: {flat} of {len(lines.sizes)} faces have no area and are left out")
    used = np.zeros(len(lines.vertices), bool)
    used[lines.corners[:, 0] - 1] = True
    if unused := np.count_nonzero(~used):
        warn(f"{path}: {unused} of {len(used)} vertices are in no face")


def smooth(lines: ObjLines) -> ObjLines:
    """Return lines whose smoothed faces have normals, one for each vertex and smoothing group.

    Faces that have normals keep them.
    """
    known = dict.fromkeys(_OFF, 0)
    states = [(at, name.lower()) for at, keyword, name in lines.states if keyword == _KEYWORD]
    marks = [(at, known.setdefault(name, len(known))) for at, name in states]
    groups = _spread(lines, [(0, 0), *marks])  # 0 where faces are flat
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
