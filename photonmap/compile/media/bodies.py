"""Closed bodies of glass, the order in which they claim space, and what lies beside triangles.

Meshes are cut where bodies cross them, so that each triangle has one medium on each side. Where
surfaces cross, triangles are cut along the planes of those that they cross; where they touch over
an area, along the edges of the others. Sizes are in the kernels' units.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.frame import Frame
from photonmap.errors import warn
from photonmap.kernels.core.records import Geometry
from photonmap.runtime.wording import listed
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.textures import is_black
from photonmap.spectra.curves import Floats, Spectrum

TOUCHING = 1e-6  # Distance, in sizes of the scene, below which surfaces touch

UNRANKED = (1 << 30) - 1  # Rank of meshes that are no bodies

Bools = NDArray[np.bool_]
Ints = NDArray[np.int32]

FLAT = 2e-7  # Height below which points count as in a plane
MOST_PAIRS = 1 << 28  # Triangles of one mesh times those of another, beyond which they are not cut


class Body(NamedTuple):
    """A closed mesh of solid glass."""

    mesh: int  # among the scene's meshes
    material: Material
    shape: Any  # `trimesh.Trimesh` in the kernels' units

    @property
    def inside(self) -> int:
        """The mesh of what is inside: -1, air, where it is wound inwards, like a bubble's."""
        return self.mesh if self.shape.volume > 0.0 else -1

    @property
    def bounds(self) -> Floats:
        """Smallest and largest coordinates, (2, 3)."""
        return np.asarray(self.shape.bounds)

    def contains(self, points: Floats) -> Bools:
        """Return which points, (P, 3), lie inside."""
        within = near(self.bounds, points, points)
        rows = np.flatnonzero(within)
        if len(rows):
            within[rows] = self.shape.contains(points[rows])
        return within


def near(bounds: Floats, low: Floats, high: Floats) -> Bools:
    """Return which boxes, from low to high, (…, 3), touch one of bounds (2, 3)."""
    touches = (low <= bounds[1] + TOUCHING) & (high >= bounds[0] - TOUCHING)
    return np.asarray(touches.all(axis=-1))


def find_bodies(meshes: Sequence[Mesh], absorbing: set[int], frame: Frame) -> list[Body]:
    """Return the bodies that matter to what lies around them: those that claim space come first.

    That is glass that absorbs (ids of materials), and glass that touches other glass or contains
    it. Of bodies that overlap, the one of the higher priority claims what they share, or else the
    smaller one.
    """
    solid = [i for i, mesh in enumerate(meshes) if is_solid(mesh.material)]
    if not solid:
        return []
    boxes = {i: np.stack([f(meshes[i].vertices, axis=0) for f in (np.min, np.max)]) for i in solid}
    scaled = {i: (box - frame.center) / frame.size for i, box in boxes.items()}
    met = {i: any(j != i and near(scaled[i], *scaled[j]) for j in solid) for i in solid}
    found, unknown = [], []
    for i in solid:
        absorbs = id(meshes[i].material) in absorbing
        if not absorbs and not met[i]:
            continue
        import trimesh  # half a second, which most glass does not need

        vertices = ((meshes[i].vertices - frame.center) / frame.size).astype(np.float32)
        shape = trimesh.Trimesh(vertices.astype(np.float64), meshes[i].faces, process=True)
        body = Body(i, meshes[i].material, shape)
        if body.shape.is_watertight:
            found.append(body)
        elif absorbs or any(j != i and _overlap(scaled[i], scaled[j]) for j in solid):
            unknown.append(meshes[i])
    names = [mesh.name for mesh in unknown if mesh.material.outside == 1.0]
    if names:
        warn(
            f"glass is no closed mesh in {listed(names)}: what lies inside is unknown, and it "
            "refracts against air"
        )
    return sorted(found, key=lambda body: (-body.material.priority, np.ptp(body.bounds, 0).prod()))


def _overlap(one: Floats, other: Floats) -> bool:
    """Return whether boxes share more than parts of their surfaces."""
    low, high = np.maximum(one[0], other[0]), np.minimum(one[1], other[1])
    flat = np.ptp(one, axis=0) <= TOUCHING
    beyond = (one[0] > other[0] + TOUCHING) & (one[1] < other[1] - TOUCHING)
    return bool(np.where(flat, beyond, high > low + TOUCHING).all())


def ranks_of(count: int, bodies: Sequence[Body]) -> NDArray[np.int32]:
    """Return the rank of each of so many meshes, by which they claim space: 0 comes first."""
    ranks = np.full(count, UNRANKED, np.int32)
    ranks[[body.mesh for body in bodies]] = np.arange(len(bodies), dtype=np.int32)
    return ranks


def is_solid(material: Material) -> bool:
    """Return whether it is glass with an inside."""
    return material.ior is not None and not material.thin


class Sides(NamedTuple):
    """Of T triangles."""

    mesh: Ints  # (T, 2), the mesh of glass in which the front and the back lie, -1 for air
    kept: Bools  # (T,), whether light changes there


def find_sides(
    meshes: Sequence[Mesh], bodies: Sequence[Body], geometry: Geometry, owner: NDArray[np.int64]
) -> Sides:
    """Return what lies on each side of triangles, and which of those of glass to keep.

    One is left out where the same glass lies on both sides, or where it lies on the surface of a
    body that claims more: its triangles are kept there. `owner`, (T,), is the mesh of each
    triangle.
    """
    glass = np.array([is_solid(mesh.material) for mesh in meshes])[owner]
    ranks = ranks_of(len(meshes), bodies)
    mesh = np.full((len(owner), 2), -1, np.int32)
    mesh[glass, 1] = owner[glass]
    claimed = np.full((len(owner), 2), UNRANKED + 1, np.int32)
    claimed[glass, 1] = ranks[owner[glass]]
    for rank, body in enumerate(bodies):
        if body.inside < 0:
            claimed[owner == body.mesh] = rank, UNRANKED
    kept = np.ones(len(owner), bool)
    centroids = geometry.vertices[geometry.triangles].mean(axis=1, dtype=np.float64)
    for rank, body in enumerate(bodies):
        rows = np.flatnonzero((owner != body.mesh) & near(body.bounds, centroids, centroids))
        step = TOUCHING * geometry.normals[rows]
        within = np.stack([body.contains(centroids[rows] + step * sign) for sign in (1, -1)], 1)
        kept[rows] &= ~(glass[rows] & (within[:, 0] != within[:, 1]) & (ranks[owner[rows]] > rank))
        within &= rank < claimed[rows]
        mesh[rows] = np.where(within, body.inside, mesh[rows])
        claimed[rows] = np.where(within, rank, claimed[rows])
    numbers: dict[object, int] = {}
    each = [numbers.setdefault(medium_of(mesh.material), len(numbers)) for mesh in meshes]
    media = np.array([*each, -1], np.int32)  # the last one is air
    return Sides(mesh, kept & ~(glass & (media[mesh[:, 0]] == media[mesh[:, 1]])))


def medium_of(material: Material) -> tuple[object, ...]:
    """Return what the inside of a material does with light: equal for equal insides of glass."""
    color, distance = material.attenuation_color, material.attenuation_distance
    index = material.ior, material.abbe, material.dispersion
    if isinstance(color, Spectrum):
        return *index, id(color), distance
    clear = bool(np.all(np.equal(color, 1.0)))
    return *index, *((1.0, None) if clear else (tuple(np.ravel(color).tolist()), distance))


def cut_meshes(
    meshes: Sequence[Mesh], bodies: Sequence[Body], absorbing: set[int], frame: Frame
) -> list[Mesh]:
    """Return the meshes, their triangles cut where bodies of glass cross them.

    Those of glass are, and where it absorbs (ids of materials) all but emitters.
    """
    result, whole = list(meshes), []
    solid = {body.mesh for body in bodies}
    for index, mesh in enumerate(meshes):
        emits = not is_black(mesh.material.emission)
        others = [
            body
            for body in bodies
            if body.mesh != index
            and (index in solid or (id(body.material) in absorbing and not emits))
        ]
        if others:
            result[index], complete = _cut_mesh(mesh, others, index in solid, frame)
            if not complete:
                whole.append(mesh.name)
    if whole:
        warn(f"too many triangles to cut {listed(whole)} where bodies of glass cross them")
    return result


def _cut_mesh(
    mesh: Mesh, others: Sequence[Body], is_glass: bool, frame: Frame
) -> tuple[Mesh, bool]:
    """Return a mesh whose triangles are cut, and whether all of them could be."""
    corners = ((mesh.vertices - frame.center) / frame.size)[mesh.faces]
    cuts: dict[int, list[Floats]] = {}
    complete = True
    for body in others:
        knives = np.asarray(body.shape.triangles)
        rows = np.flatnonzero(near(body.bounds, corners.min(axis=1), corners.max(axis=1)))
        if not len(rows):
            continue
        bounds = np.stack([corners[rows].min(axis=(0, 1)), corners[rows].max(axis=(0, 1))])
        knives = knives[near(bounds, knives.min(axis=1), knives.max(axis=1))]
        if len(rows) * len(knives) > MOST_PAIRS:
            complete = False
            continue
        for row, met in _meetings(corners[rows], knives, is_glass):
            cuts.setdefault(int(rows[row]), []).extend(knives[met])
    pieces = {row: _pieces(corners[row], knives) for row, knives in cuts.items()}
    pieces = {row: parts for row, parts in pieces.items() if len(parts) > 1}
    return (_with_pieces(mesh, corners, pieces) if pieces else mesh), complete


def _planes(triangles: Floats) -> tuple[Floats, Floats]:
    """Return unit normals (T, 3) and the planes' distances from the origin (T,)."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return normals, (normals * triangles[:, 0]).sum(axis=1)


def _meetings(
    corners: Floats, knives: Floats, coplanar: bool
) -> Iterator[tuple[int, NDArray[np.intp]]]:
    """Give each triangle's row with those of the knives whose planes it crosses, and they its own.

    With `coplanar` also those that lie in its plane.
    """
    normals, levels = _planes(knives)
    own, own_levels = _planes(corners)
    low, high = knives.min(axis=1), knives.max(axis=1)
    for row, triangle in enumerate(corners):
        box = np.stack([triangle.min(axis=0), triangle.max(axis=0)])
        met = np.flatnonzero(near(box, low, high))
        heights = triangle @ normals[met].T - levels[met]
        above, below = (heights > FLAT).any(axis=0), (heights < -FLAT).any(axis=0)
        back = knives[met] @ own[row] - own_levels[row]
        reached = (back > -FLAT).any(axis=1) & (back < FLAT).any(axis=1)
        flat = coplanar & ~above & ~below
        met = met[(above & below & reached) | flat]
        if len(met):
            yield row, met


def _pieces(triangle: Floats, knives: Sequence[Floats]) -> list[Floats]:
    """Return the convex polygons into which triangles cut one."""
    normal, level = (part[0] for part in _planes(triangle[None]))
    pieces = [triangle]
    for knife in knives:
        flat = np.abs(knife @ normal - level).max() <= FLAT
        cut = _cut_out if flat else _cut_through
        pieces = [part for piece in pieces for part in cut(piece, knife, normal)]
    return pieces


def _cut_through(piece: Floats, knife: Floats, normal: Floats) -> list[Floats]:
    """Cut a polygon along the plane of a triangle, if that meets it there."""
    (across,), (level,) = _planes(knife[None])
    line = np.cross(normal, across)
    length = np.linalg.norm(line)
    if length < 1e-9:
        return [piece]
    line /= length
    ours = _chord(piece, piece @ across - level, line)
    theirs = _chord(knife, (knife - piece[0]) @ normal, line)
    if ours is None or theirs is None:
        return [piece]
    if min(ours[1], theirs[1]) - max(ours[0], theirs[0]) <= FLAT:
        return [piece]
    return _split(piece, across, level)


def _chord(polygon: Floats, heights: Floats, line: Floats) -> tuple[float, float] | None:
    """Return from where to where along a line a polygon crosses height 0; None if it does not."""
    if heights.min() > FLAT or heights.max() < -FLAT:
        return None
    following, next_heights = np.roll(polygon, -1, axis=0), np.roll(heights, -1)
    places = list(polygon[np.abs(heights) <= FLAT] @ line)
    crosses = np.minimum(heights, next_heights) < -FLAT
    crosses &= np.maximum(heights, next_heights) > FLAT
    share = heights[crosses] / (heights[crosses] - next_heights[crosses])
    places += list((polygon[crosses] + share[:, None] * (following - polygon)[crosses]) @ line)
    return (min(places), max(places)) if places else None


def _cut_out(piece: Floats, knife: Floats, normal: Floats) -> list[Floats]:
    """Cut a polygon along the edges of a triangle in its plane."""
    center, parts, rest = knife.mean(axis=0), [], piece
    for corner, following in zip(knife, np.roll(knife, -1, axis=0), strict=True):
        across = np.cross(normal, following - corner)
        length = np.linalg.norm(across)
        if length == 0.0:
            return [piece]
        across *= np.sign((corner - center) @ across) / length
        heights = rest @ across - corner @ across
        if heights.min() > -FLAT:
            return [piece]
        if heights.max() > FLAT:
            inside, outside = _split(rest, -across, -(corner @ across))[::-1]
            parts.append(inside)
            rest = outside
    return [*parts, rest]


def _split(polygon: Floats, normal: Floats, level: float) -> list[Floats]:
    """Return the parts of a polygon above a plane and below it, or all of it on one side."""
    heights = polygon @ normal - level
    heights[np.abs(heights) <= FLAT] = 0.0
    if heights.min() >= 0.0 or heights.max() <= 0.0:
        return [polygon]
    parts: tuple[list[Floats], list[Floats]] = ([], [])
    for index, height in enumerate(heights):
        after = (index + 1) % len(polygon)
        for part, sign in zip(parts, (1.0, -1.0), strict=True):
            if sign * height >= 0.0:
                part.append(polygon[index])
        if height * heights[after] < 0.0:
            share = height / (height - heights[after])
            point = polygon[index] + share * (polygon[after] - polygon[index])
            parts[0].append(point)
            parts[1].append(point)
    return [np.array(part) for part in parts]


def _with_pieces(mesh: Mesh, corners: Floats, pieces: dict[int, list[Floats]]) -> Mesh:
    """Return a mesh with the pieces of some triangles in place of these."""
    kept = np.ones(len(mesh.faces), bool)
    kept[list(pieces)] = False
    weights, sources, faces = [], [], []
    count = len(mesh.vertices)
    for row, parts in pieces.items():
        for part in parts:
            weights.append(_barycentrics(corners[row], part))
            sources.append(np.repeat(mesh.faces[row][None], len(part), axis=0))
            fan = np.arange(1, len(part) - 1)
            faces.append(count + np.stack([np.zeros_like(fan), fan, fan + 1], axis=1))
            count += len(part)
    weight, source = np.concatenate(weights)[..., None], np.concatenate(sources)

    def extend(rows: Floats) -> Floats:
        return np.concatenate([rows, (weight * rows[source]).sum(axis=1)])

    sound = replace(mesh, normals=mesh.unit_normals, tangents=mesh.unit_tangents)
    return sound.with_rows(extend, faces=np.concatenate([mesh.faces[kept], *faces]))


def _barycentrics(triangle: Floats, points: Floats) -> Floats:
    """Return the weights of a triangle's corners at points of it, (P, 3)."""
    edges = (triangle[1:] - triangle[0]).T
    found = np.linalg.lstsq(edges, (points - triangle[0]).T, rcond=None)[0].T
    return np.column_stack([1.0 - found.sum(axis=1), found])
