"""Triangles as files hold them, and of shapes that have a formula: cut, checked and moved.

The vertices of shapes lie on them; spheres and cylinders have the normals of the true shape there.
The area of a sphere is 0.05% too small, that of a cylinder or a disk less than 0.003%. Coordinates
u and v are those of Mitsuba, but v counts upwards.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import mapbox_earcut
import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming
from photonmap.io.readers.decoding import Ints, Losses, note_loss
from photonmap.runtime.wording import shown
from photonmap.scene.material import Material
from photonmap.scene.mesh import LARGEST_COORDINATE, Mesh
from photonmap.spectra.curves import Floats

LARGEST_FACE = 1 << 15
"""Most corners of a polygon: ear clipping takes time with the square of their number."""

_CHUNK = 1 << 18  # Corners triangulated at a time, to bound the memory of temporary arrays
_ROUNDING = 8 * np.finfo(np.float64).eps


def triangulate(points: Floats, polygons: NDArray[np.int32], sizes: Ints) -> tuple[Ints, Ints]:
    """Cut polygons into triangles of the same winding.

    A polygon that is star-shaped from its first or second corner (each convex one is) becomes
    a fan, any other is cut by ear clipping in the plane of its Newell normal. Triangles
    thinner than the rounding of their coordinates are left out.

    points : (V, 3) float64
    polygons : (C,) int, the corners of all polygons as indices into `points`
    sizes : (F,) int, corners of each polygon, three or more
    Returns triangles, (T, 3) int64, indices into `polygons`, and owners, (T,) int64, the polygon of
    each, ascending.
    """
    if (sizes == 3).all():
        owners = np.flatnonzero(_find_solid(points, polygons.reshape(-1, 3)))
        return 3 * owners[:, None] + np.arange(3), owners
    begins = np.cumsum(sizes) - sizes
    order = np.argsort(sizes, kind="stable")
    ends = np.flatnonzero(np.diff(sizes[order])) + 1
    parts = []
    for group in np.split(order, ends) if len(ends) else [order]:
        step = _CHUNK // int(sizes[group[0]])
        for chunk in (group[i : i + step] for i in range(0, len(group), step)):
            corners = begins[chunk, None] + np.arange(sizes[chunk[0]])
            local, solid = _cut(points[polygons[corners]])
            triangles = (local + begins[chunk, None, None])[solid]
            owners = np.broadcast_to(chunk[:, None], solid.shape)[solid]
            parts.append((triangles, owners))
    if len(parts) == 1:
        return parts[0]
    triangles, owners = (np.concatenate(part) for part in zip(*parts, strict=True))
    order = np.argsort(owners, kind="stable")
    return triangles[order], owners[order]


def _find_solid(points: Floats, triangles: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return which triangles, (F, 3), have an area."""
    step, local = _CHUNK // 3, np.arange(3)[None, None]
    solid = [
        np.linalg.norm(crosses, axis=2)[:, 0] > limits[:, 0]
        for chunk in (triangles[i : i + step] for i in range(0, len(triangles), step))
        for crosses, limits in [_crosses(points[chunk], np.tile(local, (len(chunk), 1, 1)))]
    ]
    return np.concatenate(solid)


def _cut(corners: Floats) -> tuple[Ints, NDArray[np.bool_]]:
    """Cut R polygons of n corners each.

    corners : (R, n, 3)

    Returns local, (R, n - 2, 3) int64, triangles as indices of corners
      solid : (R, n - 2), whether a triangle has an area
    """
    rows, size = corners.shape[:2]
    fans = np.stack([np.zeros(size - 2, np.int64), np.arange(1, size - 1), np.arange(2, size)], 1)
    local = np.tile(fans, (rows, 1, 1))
    crosses, limits = _crosses(corners, local)
    if size == 3:
        return local, np.linalg.norm(crosses, axis=2) > limits
    newell = crosses.sum(1, keepdims=True)
    newell /= np.maximum(np.linalg.norm(newell, axis=2, keepdims=True), np.finfo(float).tiny)
    heights = (crosses * newell).sum(2)
    solid = heights > limits
    doubtful = np.flatnonzero(~solid.all(1))
    if not len(doubtful):
        return local, solid
    second = (local[doubtful] + 1) % size
    crosses, others = _crosses(corners[doubtful], second)
    whole = ((crosses * newell[doubtful]).sum(2) > others).all(1)
    local[doubtful[whole]] = second[whole]
    for row in doubtful[~whole & (heights[doubtful] < -limits[doubtful]).any(1)]:
        local[row] = _clip_ears(corners[row], newell[row, 0])
    crosses, others = _crosses(corners[doubtful], local[doubtful])
    solid[doubtful] = np.linalg.norm(crosses, axis=2) > others
    return local, solid


def _crosses(corners: Floats, local: Ints) -> tuple[Floats, Floats]:
    """Return twice the vector area of each triangle, and how much of it may be rounding error."""
    a, b, c = np.moveaxis(corners[np.arange(len(corners))[:, None, None], local], 2, 0)
    ab, ac = b - a, c - a
    longest = np.sqrt(np.maximum((ab**2).sum(2), (ac**2).sum(2)))
    reach = np.abs(corners).max((1, 2))
    return np.cross(ab, ac), _ROUNDING * reach[:, None] * longest


def _clip_ears(corners: Floats, normal: Floats) -> Ints:
    """Cut one polygon, (n, 3), in the coordinate plane its normal faces most."""
    axis = int(np.argmax(np.abs(normal)))
    flat = np.ascontiguousarray((corners - corners[0])[:, [(axis + 1) % 3, (axis + 2) % 3]])
    rings = np.array([len(flat)], np.uint32)
    ears = mapbox_earcut.triangulate_float64(flat, rings).reshape(-1, 3).astype(np.int64)
    crosses, _ = _crosses(corners[None], ears[None])
    turned = crosses[0] @ normal < 0
    ears[turned] = ears[turned, ::-1]
    triangles = np.zeros((len(corners) - 2, 3), np.int64)
    triangles[: len(ears)] = ears
    return triangles


@dataclass(frozen=True)
class Part:
    """Triangles that are not checked yet."""

    vertices: Floats  # (V, 3), scene units
    faces: Ints  # (F, 3), indices of vertices
    normals: Floats | None = None  # (V, 3) or None
    uv: Floats | None = None  # (V, 2) or None, v upwards
    colors: Floats | None = None  # linear: of vertices (V, 3), or faces (F, 1, 3)
    tangents: Floats | None = None  # (V, 4) or None, as in `Mesh`
    rows: Ints | None = None  # (V,) of a file's vertices, those that these are; None for all


def cut_polygons(
    vertices: Floats,
    corners: Ints,
    sizes: Ints,
    losses: Losses,
    normals: Floats | None = None,
    uv: Floats | None = None,
    colors: Floats | None = None,
) -> Part:
    """Cut polygons into triangles, and note those of fewer than three corners or without area.

    vertices, normals, uv : as in `Part`
    corners : (C,) indices of vertices, one polygon after another; all of them valid
    sizes : (F,) corners of each polygon, up to `LARGEST_FACE`
    colors : as in `Part`, those of faces for each polygon
    """
    large = sizes >= 3
    if small := np.count_nonzero(~large):
        note_loss(losses, f"{small} faces of fewer than three corners")
        corners, sizes = corners[np.repeat(large, sizes)], sizes[large]
        if colors is not None and colors.ndim == 3:
            colors = colors[large]
    if (sizes == 3).all():
        return Part(vertices, corners.reshape(-1, 3), normals, uv, colors)
    triangles, owners = triangulate(vertices, corners.astype(np.int32), sizes)
    if empty := len(sizes) - np.count_nonzero(np.bincount(owners)):
        note_loss(losses, f"{empty} faces without area")
    if colors is not None and colors.ndim == 3:
        colors = colors[owners]
    return Part(vertices, corners[triangles], normals, uv, colors)


def are_clipped(
    parts: Iterable[Floats],
    matrix: Floats,
    planes: tuple[float, float],
    radius: float,
    slope: float,
) -> bool:
    """Return whether vertices in view lie before or behind the clipping planes of a camera.

    parts : vertices of meshes, (V, 3)
    matrix : (4, 4) of the camera, which looks along -z
    planes : depths of both
    radius, slope : of the cylinder or the cone around its view, at depth 0 and for each depth
    """
    to_camera, (near, far) = np.linalg.inv(matrix), planes
    for vertices in parts:
        depth = -(vertices @ to_camera[2, :3] + to_camera[2, 3])
        cut = (depth > 0.0) & ((depth < near) | (depth > far))
        if cut.any():
            across = vertices[cut] @ to_camera[:2, :3].T + to_camera[:2, 3]
            if (np.linalg.norm(across, axis=1) <= radius + slope * depth[cut]).any():
                return True
    return False


def move(part: Part, matrix: Floats) -> Part:
    """Transform a part by a (4, 4) matrix; faces are reversed where it mirrors, to stay outside."""
    linear = matrix[:3, :3]
    mirrors = bool(np.linalg.det(linear) < 0)
    vertices = part.vertices
    if not np.array_equal(matrix, np.eye(4)):
        vertices = vertices @ linear.T + matrix[:3, 3]
    faces = part.faces[:, ::-1] if mirrors else part.faces
    normals = part.normals
    if normals is not None:
        columns = linear.T
        cofactors = np.cross(columns[[1, 2, 0]], columns[[2, 0, 1]])
        normals = normals @ (-cofactors if mirrors else cofactors)
        normals = unit_rows(normals)
    tangents = part.tangents
    if tangents is not None:
        sign = -tangents[:, 3] if mirrors else tangents[:, 3]
        tangents = np.column_stack([tangents[:, :3] @ linear.T, sign])
    return replace(part, vertices=vertices, faces=faces, normals=normals, tangents=tangents)


def turned_to_normals(part: Part) -> Part:
    """Return a part whose faces look where the normals of their vertices do."""
    assert part.normals is not None
    a, b, c = (part.vertices[part.faces[:, corner]] for corner in range(3))
    along = part.normals[part.faces].sum(axis=1)
    is_behind = (np.cross(b - a, c - a) * along).sum(axis=1) < 0.0
    return replace(part, faces=np.where(is_behind[:, None], part.faces[:, ::-1], part.faces))


def is_closed(part: Part) -> bool:
    """Return whether each edge has a triangle on either side; vertices of one place are one."""
    _, same = np.unique(part.vertices, axis=0, return_inverse=True)
    corners = same.reshape(-1)[part.faces]
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges = edges[edges[:, 0] != edges[:, 1]]
    counts = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)[1]
    return bool((counts % 2 == 0).all())


def build_mesh(path: Path, part: Part, material: Material, name: str) -> Mesh:
    """Check triangles and leave out the vertices they do not use."""
    with naming(f"mesh {shown(name)}", path):
        for kind, rows in (
            ("vertex", part.vertices),
            ("normal", part.normals),
            ("texture coordinate", part.uv),
            ("colour", part.colors),
        ):
            if rows is not None:
                check_rows(kind, rows.reshape(len(rows), -1))
        check_indices(part.faces, len(part.vertices))
    used = np.zeros(len(part.vertices), np.bool_)
    used[part.faces] = True
    colors, others = part.colors, (part.normals, part.uv, part.tangents)
    if used.all():
        normals, uv, tangents = others
        return Mesh(part.vertices, part.faces, material, name, normals, uv, colors, tangents)
    faces = (np.cumsum(used) - 1)[part.faces]
    normals, uv, tangents = (None if rows is None else rows[used] for rows in others)
    if colors is not None and colors.ndim == 2:
        colors = colors[used]
    return Mesh(part.vertices[used], faces, material, name, normals, uv, colors, tangents)


def check_rows(kind: str, rows: Floats) -> None:
    """Refuse rows of numbers that are not finite, or too large."""
    if rows.size and not (-rows.min() <= LARGEST_COORDINATE >= rows.max()):  # or one is NaN
        bad = ~(np.abs(rows) <= LARGEST_COORDINATE).all(axis=1)
        row = int(np.argmax(bad))
        values = ", ".join(f"{value:g}" for value in rows[row])
        limit = f"finite numbers up to {LARGEST_COORDINATE:g}"
        raise InputError(f"{kind} {row} is ({values}); export it with {limit}")


def check_indices(corners: Ints, count: int) -> None:
    """Refuse corners that are none of `count` vertices."""
    if corners.size and not 0 <= corners.min() <= corners.max() < count:
        bad = (corners < 0) | (corners >= count)
        message = f"a face names vertex {corners[bad][0]}, but there are {count}, counted from 0"
        raise InputError(f"{message}; export it again")


def vertex_normals(points: Floats, sizes: Ints, vertices: Ints, count: int) -> Floats:
    """Return means of the normals of polygons about each vertex, weighted by their angles there.

    G. Thürmer and C. Wüthrich, "Computing vertex normals from polygonal facets", 1998.

    points : (C, 3), the corners of all polygons
    sizes : (F,), corners of each polygon, three or more
    vertices : (C,), the vertex of each corner, below `count`
    Returns (count, 3), of length 1; 0 where there is none
    """
    ends = np.cumsum(sizes)
    begins = ends - sizes
    following, previous = np.arange(1, len(points) + 1), np.arange(-1, len(points) - 1)
    following[ends - 1], previous[begins] = begins, ends - 1
    ahead, back = points[following] - points, points[previous] - points
    angles = np.arctan2(np.linalg.norm(np.cross(ahead, back), axis=1), (ahead * back).sum(axis=1))
    from_first = points - np.repeat(points[begins], sizes, axis=0)
    normals = unit_rows(np.add.reduceat(np.cross(from_first, ahead), begins))
    weighted = angles[:, None] * np.repeat(normals, sizes, axis=0)
    return unit_rows(np.stack([np.bincount(vertices, each, count) for each in weighted.T], axis=1))


def unit_rows(rows: Floats) -> Floats:
    """Return rows scaled to length 1; those of length 0 and what is not finite stay so."""
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.divide(rows, length, out=np.zeros_like(rows), where=length != 0.0)


SPHERE_EDGES = 128  # Edges of a sphere along its equator; half as many from pole to pole
CIRCLE_EDGES = 512  # Edges of a disk and of a cylinder along a full turn
_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
_CUBE = (  # for each face its normal, and the axis along which u grows
    ((0, -1, 0), (0, 0, 1)),
    ((0, 1, 0), (-1, 0, 0)),
    ((1, 0, 0), (0, 1, 0)),
    ((0, 0, 1), (0, 1, 0)),
    ((-1, 0, 0), (0, 1, 0)),
    ((0, 0, -1), (0, -1, 0)),
)


def rectangle() -> Part:
    """Return the square from -1 to 1 in x and y, which faces +z."""
    square = _square(np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    return replace(square, uv=_CORNERS * [1.0, -1.0] + [0.0, 1.0])


def cube() -> Part:
    """Return the cube from -1 to 1."""
    faces = [
        _square(normal, along, np.cross(normal, along))
        for normal, along in np.array(_CUBE, np.float64)
    ]
    triangles = [face.faces + len(_CORNERS) * index for index, face in enumerate(faces)]
    vertices = np.concatenate([face.vertices for face in faces])
    return Part(vertices, np.concatenate(triangles), None, np.tile(_CORNERS, (len(faces), 1)))


def _square(center: Floats, along: Floats, across: Floats) -> Part:
    places = 2.0 * _CORNERS - 1.0
    vertices = center + places[:, :1] * along + places[:, 1:] * across
    return Part(vertices, np.array([[0, 1, 2], [0, 2, 3]]), None, _CORNERS)


def sphere(center: Floats, radius: float) -> Part:
    """Return a sphere; u runs about z, from +x towards +y, and v from +z to -z."""
    unit = _unit_sphere()
    faces = unit.faces if radius else unit.faces[:0]
    return replace(unit, vertices=center + radius * unit.vertices, faces=faces)


@cache
def _unit_sphere() -> Part:
    around, down, faces = _lattice(SPHERE_EDGES, SPHERE_EDGES // 2)
    azimuth, polar = 2.0 * np.pi * around, np.pi * down
    across = np.sin(polar)
    normals = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.cos(polar)], axis=1)
    uv = np.stack([around, 1.0 - down], axis=1)
    part = _solid(Part(normals, faces, normals, uv))
    for shared in (part.faces, normals, uv):
        shared.setflags(write=False)
    return part


def disk() -> Part:
    """Return the disk of radius 1 about z, which faces +z; u is the radius, v runs about z."""
    around, radius, faces = _lattice(CIRCLE_EDGES, 1)
    azimuth = 2.0 * np.pi * around
    x, y = radius * np.cos(azimuth), radius * np.sin(azimuth)
    uv = np.stack([radius, 1.0 - around], axis=1)
    return _solid(Part(np.stack([x, y, np.zeros(len(x))], axis=1), faces, None, uv))


def cylinder(start: Floats, end: Floats, radius: float) -> Part:
    """Return a cylinder without caps, which faces outwards; u runs about it, v along it.

    Its ends are two points that differ.
    """
    around, along, faces = _lattice(CIRCLE_EDGES, 1)
    axis = end - start
    x, y = side_axes(axis / np.linalg.norm(axis))
    azimuth = 2.0 * np.pi * around
    normals = np.outer(np.cos(azimuth), x) + np.outer(np.sin(azimuth), y)
    vertices = start + radius * normals + np.outer(along, axis)
    return Part(vertices, faces[:, ::-1], normals, np.stack([around, 1.0 - along], axis=1))


def _lattice(columns: int, rows: int) -> tuple[Floats, Floats, Ints]:
    """Return a unit square, cut into triangles: x and y of its vertices, and corners, (F, 3).

    They are counter-clockwise where y counts downwards.
    """
    y, x = np.mgrid[0 : rows + 1, 0 : columns + 1].reshape(2, -1).astype(np.float64)
    cells = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1, 1)
    below = columns + 1
    halves = [[0, below, below + 1], [0, below + 1, 1]]
    faces = np.concatenate([cells + half for half in halves])
    return x / columns, y / rows, faces


def _solid(part: Part) -> Part:
    """Leave out triangles without area: those at poles."""
    a, b, c = (part.vertices[part.faces[:, corner]] for corner in range(3))
    doubled = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return replace(part, faces=part.faces[doubled > 1e-9 * doubled.max()])


def side_axes(z: Floats) -> tuple[Floats, Floats]:
    """Return x and y of a right-handed frame about a unit vector z.

    T. Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017.
    """
    sign = math.copysign(1.0, z[2])
    a = -1.0 / (sign + z[2])
    b = z[0] * z[1] * a
    x = np.array([1.0 + sign * z[0] ** 2 * a, sign * b, -sign * z[0]])
    return x, np.array([b, sign + z[1] ** 2 * a, -z[1]])
