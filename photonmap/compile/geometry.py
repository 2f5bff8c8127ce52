"""Meshes checked, cleaned up and joined into one geometry near the origin, at unit size."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.frame import Frame
from photonmap.compile.media.bodies import UNRANKED, medium_of
from photonmap.compile.textures import paint_meshes
from photonmap.errors import InputError, warn
from photonmap.kernels.core import records
from photonmap.runtime.storage import strips
from photonmap.runtime.wording import enumerated, shown
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene
from photonmap.scene.surfaces.layers import check_textures, without_images
from photonmap.scene.textures import FARTHEST, Texture, mean_number
from photonmap.spectra.curves import LARGEST_REFLECTANCE, Floats, Spectrum

LEAST_AREA = 1e-34
"""Area of a triangle, in squares of the scene's size, below which light cannot meet it: its inverse
is float32."""
Bools = NDArray[np.bool_]
_MIX = np.array([0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB], np.uint64)


def check_meshes(scene: Scene) -> list[Mesh]:
    """Return a scene's meshes, checked, without vertices that no face uses; colours as textures."""
    meshes = [mesh for mesh in scene.meshes if len(mesh.faces)]
    if not meshes:
        raise InputError(f"scene {scene.name!r} has no faces: there is nothing to render")
    for mesh in meshes:
        _check_mesh(mesh)
    for material in {id(mesh.material): mesh.material for mesh in meshes}.values():
        check_textures(material)
    return _even_gloss(_flatten(paint_meshes([without_strays(mesh) for mesh in meshes])))


def _check_mesh(mesh: Mesh) -> None:
    name = f"mesh {mesh.name!r}"
    for label, array, columns in (("vertices", mesh.vertices, 3), ("faces", mesh.faces, 3)):
        if array.ndim != 2 or array.shape[1] != columns:
            raise InputError(f"{name}: {label} must be (n, {columns}), not {array.shape}")
    if not np.isfinite(mesh.vertices).all():
        row = int(np.argmin(np.isfinite(mesh.vertices).all(axis=1)))
        raise InputError(f"{name}: vertex {row} is {mesh.vertices[row]}; give finite numbers")
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        worst = mesh.faces.max() if mesh.faces.min() >= 0 else mesh.faces.min()
        raise InputError(f"{name}: a face names vertex {worst}, but there are {len(mesh.vertices)}")
    for label, columns in (("normals", 3), ("tangents", 4), ("uv", 2)):
        given, wanted = getattr(mesh, label), (len(mesh.vertices), columns)
        is_idle = given is None or (label == "uv" and not mesh.material.uses_uv)
        if not is_idle and given.shape != wanted:
            raise InputError(f"{name}: {label} must be {wanted}, one per vertex, not {given.shape}")
    _check_colors(mesh, name)
    if mesh.uv is not None and mesh.material.uses_uv:
        sound = (np.abs(mesh.uv) <= FARTHEST).all(axis=1)
        if not sound.all():
            row = int(np.argmin(sound))
            raise InputError(
                f"{name}: uv {row} is {mesh.uv[row]}; give finite numbers up to {FARTHEST:g}"
            )


def _check_colors(mesh: Mesh, name: str) -> None:
    """Refuse colours of another shape, outside [0, 1], or on a material that has textures."""
    if mesh.colors is None:
        return
    vertices, faces = (len(mesh.vertices), 3), (len(mesh.faces), 1, 3)
    if mesh.colors.shape not in (vertices, faces, (len(mesh.faces), 3, 3)):
        raise InputError(
            f"{name}: colors must be {vertices}, one per vertex, or {faces}, one per face, "
            f"not {mesh.colors.shape}"
        )
    bad = ~((mesh.colors >= 0.0) & (mesh.colors <= LARGEST_REFLECTANCE))
    if bad.any():
        row = int(np.argmax(bad.reshape(len(bad), -1).any(axis=1)))
        raise InputError(
            f"{name}: color {row} is {mesh.colors[row].tolist()}; keep it within [0, 1]"
        )
    if mesh.material.is_textured:
        raise InputError(
            f"{name} has colors, and its material {mesh.material.name!r} has textures; "
            "remove one of them"
        )


def _flatten(meshes: list[Mesh]) -> list[Mesh]:
    """Give meshes without texture coordinates the mean of their textures, and say so."""
    bare = {id(mesh): mesh for mesh in meshes if mesh.uv is None and mesh.material.is_textured}
    if not bare:
        return meshes
    named = dict.fromkeys(
        f"{shown(mesh.name)} of material {shown(mesh.material.name)}" for mesh in bare.values()
    )
    warn(f"no texture coordinates in {enumerated(named)}: the mean of their textures is used")
    textured = {id(mesh.material): mesh.material for mesh in bare.values()}
    flat = {key: without_images(material, base=True) for key, material in textured.items()}
    return [
        replace(mesh, material=flat[id(mesh.material)]) if id(mesh) in bare else mesh
        for mesh in meshes
    ]


def _even_gloss(meshes: list[Mesh]) -> list[Mesh]:
    """Give anisotropic gloss the mean of the image of its roughness, and say so."""
    even: dict[int, Material] = {}
    for material in (mesh.material for mesh in meshes):
        is_brushed = material.is_glossy and material.is_anisotropic
        if is_brushed and isinstance(material.roughness, Texture):
            even[id(material)] = replace(material, roughness=mean_number(material.roughness))
    if not even:
        return meshes
    named = dict.fromkeys(shown(material.name) for material in even.values())
    warn(
        f"anisotropic gloss has one roughness: the mean of its image is used in {enumerated(named)}"
    )
    return [replace(mesh, material=even.get(id(mesh.material), mesh.material)) for mesh in meshes]


def join_meshes(
    meshes: list[Mesh], frame: Frame, ranks: NDArray[np.int32]
) -> tuple[records.Geometry, NDArray[np.int64]]:
    """Join meshes near the origin at unit size; return them and each triangle's mesh.

    Of triangles that coincide, those of the lowest `ranks`, one for each mesh, are kept.
    """
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    vertices = np.concatenate([(mesh.vertices - frame.center) / frame.size for mesh in meshes])
    corners, vertices = vertices, vertices.astype(np.float32)
    triangles = np.concatenate(
        [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    )
    owner = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])
    normals = winding_normals(vertices, triangles)
    length = lengths(normals)
    triangles, owner, normals, length = _choose(
        _find_sound(length), triangles, owner, normals, length
    )
    kept = _find_single(meshes, vertices, triangles, owner, ranks)
    triangles, owner, normals, length = _choose(kept, triangles, owner, normals, length)
    none = np.empty(0, np.int32)
    smooth = [mesh.unit_normals for mesh in meshes]
    leaning = _join_rows(meshes, smooth, 3, any(rows is not None for rows in smooth))
    coordinates = [mesh.uv if mesh.material.uses_uv else None for mesh in meshes]
    return records.Geometry(
        scene=0,
        vertices=vertices,
        triangles=triangles.astype(np.int32),
        normals=(normals / length[:, None]).astype(np.float32),
        shading_normals=leaning.astype(np.float32),
        material=none,
        emitter=none,
        uv=_join_rows(meshes, coordinates, 2, any(mesh.material.uses_uv for mesh in meshes)).astype(
            np.float32
        ),
        alpha=None,
        relief=None,
        corners=corners,
        corner_normals=leaning,
    ), owner


def _choose(chosen: Bools, *arrays: NDArray[Any]) -> list[NDArray[Any]]:
    """Return the chosen rows of arrays; copies only if not all are, as they most often are."""
    return list(arrays) if chosen.all() else [rows[chosen] for rows in arrays]


def _find_sound(length: Floats) -> NDArray[np.bool_]:
    """Return which triangles have an area, (T,), by their normals' lengths; warn of others."""
    sound = length > LEAST_AREA
    if count := int((~sound).sum()):
        warn(f"{count} degenerate triangle{'s' * (count > 1)} (no area) left out")
    if not sound.any():
        raise InputError("no triangle has an area: there is nothing to render; export it again")
    return sound


def _join_rows(meshes: list[Mesh], rows: list[Floats | None], columns: int, wanted: bool) -> Floats:
    """Return rows of all vertices, 0 where a mesh has none; (0, columns) unless they are wanted."""
    if not wanted:
        return np.zeros((0, columns))
    pairs = zip(meshes, rows, strict=True)
    parts = [np.zeros((len(mesh.vertices), columns)) if row is None else row for mesh, row in pairs]
    return np.concatenate(parts)


def without_strays(mesh: Mesh) -> Mesh:
    """Return a mesh without the vertices that no face uses: far ones would stretch the scene."""
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces] = True
    if used.all():
        return mesh
    colors = mesh.colors
    if mesh.uv is not None and len(mesh.uv) != len(used):
        mesh = replace(mesh, uv=None)
    return mesh.with_rows(
        lambda rows: rows[used],
        faces=(np.cumsum(used) - 1)[mesh.faces],
        colors=colors[used] if colors is not None and colors.ndim == 2 else colors,
    )


def _find_single(
    meshes: list[Mesh],
    vertices: NDArray[np.float32],
    triangles: NDArray[np.int64],
    owner: NDArray[np.int64],
    ranks: NDArray[np.int32],
) -> Bools:
    """Return which triangles to keep where several have the same corners, in any order: (T,).

    One of them, an emitter if there is one, or else of the lowest rank; two emitters back to back;
    and none where bodies of equal glass touch, since light passes there unhindered. `owner`, (T,),
    is the mesh of each triangle. Warn of those that go, but for bodies of glass, which may touch.
    """
    paints = [mesh.material.emission for mesh in meshes]
    emitting = np.array([isinstance(p, Spectrum | Texture) or bool(np.any(p)) for p in paints])
    numbers: dict[object, int] = {}
    media = np.array([
        numbers.setdefault(medium_of(mesh.material), len(numbers) + 1) if mesh.material.ior else 0
        for mesh in meshes
    ])  # fmt: skip
    kept = np.ones(len(triangles), bool)
    corners = _codes(vertices)[triangles]
    codes = corners.sum(axis=1)
    ordered = np.sort(codes)
    if (ordered[1:] != ordered[:-1]).all():
        return kept
    _, group, count = np.unique(codes, return_inverse=True, return_counts=True)
    several = np.flatnonzero(count[group] > 1)
    group = group[several]
    order = np.lexsort((ranks[owner[several]], ~emitting[owner[several]], group))
    several, group = several[order], group[order]
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    first = several[np.repeat(starts, np.diff(starts, append=len(group)))]
    turned = _winding(corners[several]) != _winding(corners[first])
    here, there = owner[several], owner[first]
    kept[several] = (several == first) | (turned & emitting[here] & emitting[there])
    inside = turned & (media[here] > 0) & (media[here] == media[there])
    kept[first[inside]] = False
    if gone := int((~kept & (ranks[owner] == UNRANKED)).sum()):
        several_gone = f"{gone} triangles that coincide with others removed"
        warn("1 triangle that coincides with another removed" if gone == 1 else several_gone)
    return kept


def _codes(vertices: NDArray[np.float32]) -> NDArray[np.uint64]:
    """Return a number for each place, (V,)."""
    bits = (vertices + np.float32(0.0)).view(np.uint32).astype(np.uint64)
    code = np.zeros(len(vertices), np.uint64)
    for axis in range(3):
        code = (code ^ bits[:, axis]) * _MIX[axis]
        code ^= code >> np.uint64(29)
    return code


def _winding(corners: NDArray[np.uint64]) -> Bools:
    """Return the orientation of triples of corners, (T,)."""
    return (corners < np.roll(corners, -1, axis=1)).sum(axis=1) == 2


def winding_normals(vertices: NDArray[np.float32], triangles: NDArray[np.integer]) -> Floats:
    """Return the normals of triangles' windings, (T, 3), as long as twice their areas."""
    normals = np.empty((len(triangles), 3))
    for part in strips(len(triangles)):
        a, b, c = (vertices[corner].astype(np.float64).T for corner in triangles[part].T)
        u, v = b - a, c - a
        for axis in range(3):  # np.cross takes twice as long
            after, last = (axis + 1) % 3, (axis + 2) % 3
            normals[part, axis] = u[after] * v[last] - u[last] * v[after]
    return normals


def lengths(vectors: Floats) -> Floats:
    """Return the lengths of (T, 3) vectors; np.linalg.norm takes six times as long."""
    x, y, z = vectors.T
    return np.sqrt(x * x + y * y + z * z)


def triangle_areas(
    geometry: records.Geometry, triangles: NDArray[np.int64] | slice = slice(None)
) -> Floats:
    """Return the areas of triangles, float64, in the geometry's units."""
    normals = winding_normals(geometry.vertices, geometry.triangles[triangles])
    return 0.5 * lengths(normals)
