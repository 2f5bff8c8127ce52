"""Read scenes of Mitsuba, versions 2 and 3, and those of 0.x whose names differ."""

from __future__ import annotations

import math
import re
import struct
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers import meshes, obj, ply
from photonmap.io.readers.decoding import Losses, decode_file, plain, point_ahead
from photonmap.io.readers.environment_maps import turned_map
from photonmap.io.readers.mitsuba.bsdfs import is_one_sided, read_material
from photonmap.io.readers.mitsuba.colors import combined, read_paint, read_plain
from photonmap.io.readers.mitsuba.nodes import Context, Node, load_nodes, once
from photonmap.io.readers.registry import ReadOptions
from photonmap.runtime.bounds import OF_TRIANGLE, check_unpacked
from photonmap.runtime.files import allowed_folder
from photonmap.runtime.wording import shown, suggest
from photonmap.scene import lights
from photonmap.scene.camera import NOT_IN_FILES, Camera, Lens, check_camera
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Vector, unit
from photonmap.scene.projections import Intrinsics
from photonmap.scene.scene import Scene
from photonmap.scene.textures import is_black
from photonmap.spectra.curves import Color, Floats
from photonmap.spectra.tables import read_bytes

SUFFIXES = (".xml",)

_COMPLETE = (
    "path", "volpath", "volpathmis", "ptracer", "prb", "prb_basic", "prbvolpath",
    "bdpt", "photonmapper", "ppm", "sppm", "pssmlt", "mlt", "erpt",
)  # fmt: skip
"""Integrators that simulate all light"""
_NARROW = 2.0  # Width, degrees, of an edge so narrow that its falloff does not matter
_AROUND = ("constant", "envmap")
_PERSPECTIVE, _THIN_LENS, _ORTHOGRAPHIC = "perspective", "thinlens", "orthographic"
_SENSORS = (_PERSPECTIVE, _THIN_LENS, _ORTHOGRAPHIC)
_IGNORED = ("shutter_open", "shutter_close")
_FULL_FRAME = math.hypot(36.0, 24.0)  # Diagonal of the film, mm, to which focal lengths refer


def read(path: Path, options: ReadOptions) -> Scene:
    """Read a scene with its shapes, emitters and sensors.

    Each shape becomes a mesh, called by its id or else its type. Files that the scene names are
    looked up in its folder, and not outside of it.
    """
    return decode_file(path, partial(_decode, options))


def _decode(options: ReadOptions, path: Path, data: bytes, losses: Losses) -> Scene:
    context = Context(path, allowed_folder(path), options.missing_textures, losses)
    scene = load_nodes(path, data, context)
    shapes = [mesh for shape in scene.parts("shape") for mesh in read_shapes(shape)]
    shining = read_emitters(scene.parts("emitter"))
    cameras = [read_sensor(sensor, shapes) for sensor in scene.parts("sensor")]
    for integrator in scene.parts("integrator"):
        _note_integrator(integrator)
    return Scene(shapes, shining, name=path.stem, cameras=cameras)


def _note_integrator(node: Node) -> None:
    """Note what an integrator leaves out of the picture: photonmap simulates all light."""
    if node.type not in _COMPLETE:
        node.lose(f"integrator {shown(node.type)}")
    if node.number("max_depth", -1.0) >= 0.0:
        node.lose("an end of paths (max_depth)")
    if node.flag("hide_emitters", False):
        node.lose("hidden emitters (hide_emitters)")


def read_emitters(nodes: Iterable[Node]) -> list[lights.Light]:
    """Return the lights of emitters."""
    found, around = [], None
    for node in nodes:
        if node.type in _AROUND:
            if around is not None:
                place = around.element.place(node.element.path)
                problem = f"the scene has an environment already, in {place}"
                raise node.error(f"{problem}; remove one of them")
            around = node
        found.append(_read_emitter(node))
    return found


def _read_emitter(node: Node) -> lights.Light:
    if node.type not in _EMITTERS:
        raise node.unknown(_EMITTERS)
    name = node.unique_name("light") if node.id else ""
    try:
        light = lights.check_light(_EMITTERS[node.type](node, name))
    except InputError as invalid:
        raise node.error(str(invalid)) from None
    node.read.add("sampling_weight")
    node.lose_unread()
    return light


def _amount(node: Node, name: str) -> Color:
    return read_plain(node, name, (1.0, 1.0, 1.0), "emission")


def _given(node: Node, name: str, transformed: Vector) -> Vector:
    """Return a vector, which may be given by its name or else by a transformation."""
    if node.find(name) and node.find("to_world"):
        raise node.error(f"{name} and to_world are both given; keep one of them")
    return node.vector(name, transformed)


def _is_even(*axes: Floats) -> bool:
    """Return whether axes are perpendicular and of one length, as those of a turn and a scale."""
    products = np.array(axes) @ np.array(axes).T
    mean = np.trace(products) / len(axes)
    return np.allclose(products, mean * np.eye(len(axes)), atol=1e-5 * mean)


def _point(node: Node, name: str) -> lights.Light:
    place = _given(node, "position", plain(node.transform()[:3, 3]))
    return lights.PointLight(place, _amount(node, "intensity"), name)


def _spot(node: Node, name: str) -> lights.Light:
    """Return a spot, whose intensity falls linearly with the angle between its beam and its edge.

    As photonmap's own spots fall in another way, it is a table unless that range is narrow.
    """
    matrix = node.transform()
    origin, target = plain(matrix[:3, 3]), plain(matrix[:3, 3] + matrix[:3, 2])
    if not _is_even(*matrix[:3, :3].T):
        node.lose("shear or uneven scale of its cone")
    intensity = _amount(node, "intensity")
    edge = node.number("cutoff_angle", 20.0)
    beam = node.number("beam_width", 0.75 * edge)
    if edge - beam < _NARROW:
        return lights.SpotLight(origin, target, intensity, beam, edge, name=name)
    angles = np.linspace(0.0, 180.0, 181)
    falloff = np.clip((edge - angles) / (edge - beam), 0.0, 1.0)
    mean = float(np.average(falloff, weights=np.sin(np.radians(angles))))
    mean_intensity = combined(lambda value: mean * value, intensity)
    direction, side = plain(matrix[:3, 2]), plain(matrix[:3, 0])
    table = np.stack([falloff, falloff], axis=1)
    return lights.PhotometricLight(origin, table, mean_intensity, direction, side, name)


def _directional(node: Node, name: str) -> lights.Light:
    axis = node.transform()[:3, 2]
    ahead = _given(node, "direction", plain(axis))
    if not math.isclose(np.linalg.norm(axis), 1.0, rel_tol=1e-4):
        node.lose("the scale of to_world, by which Mitsuba multiplies its irradiance,")
    return lights.DirectionalLight(ahead, _amount(node, "irradiance"), name)


def _environment(node: Node, name: str) -> lights.EnvironmentLight:
    scale = node.number("scale", 1.0)
    return turned_map(node.file(), node.transform()[:3, :3], scale, name)


_EMITTERS: dict[str, Callable[[Node, str], lights.Light]] = {
    "point": _point,
    "spot": _spot,
    "directional": _directional,
    "constant": lambda node, name: lights.DomeLight(_amount(node, "radiance"), name),
    "envmap": _environment,
}


def read_sensor(node: Node, shapes: list[Mesh]) -> Camera:
    """Return the camera of a sensor; near and far planes cut nothing off, which is noted."""
    if node.type not in _SENSORS:
        raise node.unknown(_SENSORS)
    matrix = node.transform()
    if np.linalg.det(matrix[:3, :3]) < 0.0:
        node.lose("mirrored view")
    right, up, ahead = matrix[:3, :3].T
    ahead = unit(ahead)
    across = float(np.linalg.norm(up))
    if not _is_even(right, up, across * ahead):
        node.lose("shear or uneven scale of the view")
    origin, target, up = matrix[:3, 3], point_ahead(matrix[:3, 3], ahead), up
    size = _film_size(node)
    look: dict[str, Any]
    if node.type == _ORTHOGRAPHIC:
        look = {"height": 2.0 * across * size[1] / size[0]}
    else:
        look = _perspective(node, size)
    if node.type == _THIN_LENS and (radius := node.number("aperture_radius", 0.0)) != 0.0:
        if (focus := node.number("focus_distance", 0.0)) == 0.0:
            raise node.error("aperture_radius is given without focus_distance; add one above 0")
        look["lens"] = Lens(focus, radius)
    planes = node.number("near_clip", 0.0), node.number("far_clip", 1e4)
    view = matrix @ np.diag([1.0, 1.0, -1.0, 1.0])
    vertices = (mesh.vertices for mesh in shapes)
    if meshes.are_clipped(vertices, view, planes, *_reach(look, size)):
        node.lose("what near_clip and far_clip cut off")
    node.read.update(("", *_IGNORED))
    node.lose_unread()
    name = re.sub(f"[{re.escape(NOT_IN_FILES)}]", "_", node.unique_name("camera"))
    try:
        return check_camera(Camera(plain(origin), target, plain(up), name=name, **look))
    except InputError as invalid:
        raise node.error(str(invalid)) from None


def _reach(look: dict[str, Any], size: tuple[int, int]) -> tuple[float, float]:
    """Return the radius and the slope of the cylinder, or of the cone, around a view."""
    if "height" in look:
        return math.sqrt(2.0), 0.0
    if "projection" in look:
        return 0.0, math.hypot(*size) / look["projection"].fx
    return 0.0, math.tan(math.radians(look["fov"]) / 2.0) * math.hypot(1.0, size[0] / size[1])


def _film_size(node: Node) -> tuple[int, int]:
    """Return width and height of the film: only their ratio, and a crop, matter."""
    film = node.only("film")
    if film is None:
        return 768, 576
    size = film.whole("width", 768), film.whole("height", 576)
    if not 0 < min(size) <= max(size) <= 1 << 20:
        raise film.error(f"a film of {size[0]}x{size[1]} is not possible; correct its size")
    if any(film.find(f"crop_{what}") for what in ("width", "height")):
        node.lose("crop")
    return size


def _perspective(node: Node, size: tuple[int, int]) -> dict[str, Any]:
    """Return the vertical angle of view; or intrinsics, if the principal point is not central."""
    width, height = size
    sides = {"x": width, "y": height, "diagonal": math.hypot(width, height)}
    sides |= {"smaller": min(size), "larger": max(size)}
    axis = node.text("fov_axis", "x").lower()
    if axis not in sides:
        raise node.error(f"fov_axis {shown(axis)} is not known; {suggest(axis, sides)}")
    if node.find("fov"):
        fov = node.number("fov", 0.0)
    else:
        millimetres = node.element.number(node.text("focal_length", "50mm").removesuffix("mm"))
        fov = 2.0 * math.degrees(math.atan2(0.5 * _FULL_FRAME, millimetres))
        axis = "diagonal"
    if not 0.0 < fov < 180.0:
        raise node.error(f"an angle of view of {fov:g} degrees is not within 0 and 180; correct it")
    focal = 0.5 * sides[axis] / math.tan(math.radians(fov) / 2.0)
    right, down = (node.number(f"principal_point_offset_{axis}", 0.0) for axis in "xy")
    if right == down == 0.0:
        return {"fov": 2.0 * math.degrees(math.atan(0.5 * height / focal))}
    center = (0.5 - right) * width, (0.5 - down) * height
    return {"projection": Intrinsics(focal, size, cx=center[0], cy=center[1])}


_MAGIC = 0x041C
_OFFSETS = {3: "<I", 4: "<Q"}  # How versions store where each mesh begins
_FLAT, _DOUBLE = 0x10, 0x2000  # Flags of a mesh
_TABLES = {0x1: 3, 0x2: 2, 0x8: 3}
"""Flags of meshes that have normals, texture coordinates and colours: columns of their tables"""
_LONGEST_NAME = 4096
_HEADER = 4  # Bytes before the compressed data
_MOST = 1100  # Bytes that zlib can pack into one: 1032, and a little more
_CLOSED = ("sphere", "cube")
_GROUP, _INSTANCE = "shapegroup", "instance"


def read_shapes(node: Node) -> Iterator[Mesh]:
    """Return the meshes of a shape, none of a group, which only its instances show."""
    if node.type == _INSTANCE:
        groups = [part for part in node.parts("shape") if part.type == _GROUP]
        if len(groups) != 1:
            raise node.error("an instance shows one shapegroup; give it a <ref> to that")
        matrix = node.transform()
        for shape in groups[0].parts("shape"):
            yield _mesh(shape, node.unique_name("mesh"), matrix)
        node.lose_unread()
    elif node.type != _GROUP:
        yield _mesh(node, node.unique_name("mesh"), np.eye(4))


@once
def _part(node: Node) -> meshes.Part:
    """Return the geometry of a shape in its own coordinates."""
    if node.type not in _SHAPES:
        raise node.unknown(_SHAPES)
    return _SHAPES[node.type](node)


def _mesh(node: Node, name: str, outer: Floats) -> Mesh:
    """Return the mesh of a shape, `outer` being the matrix of its instance.

    Faces look where Mitsuba's normals do. Those of other shapes, and of vertices in files, are
    turned as normals are; where they follow from how faces are wound, and those of spheres, the
    shape's own transformation turns them over if it mirrors.
    """
    local, own, material = _part(node), node.transform(), _material(node)
    node.context.budget.spend(OF_TRIANGLE * len(local.faces))
    part = meshes.move(local, outer @ own)
    is_wound = node.type == "sphere"
    node.read.add("face_normals")  # has no effect on shapes whose normals are known
    if node.type in _FILES:
        is_flat = node.flag("face_normals", False)
        is_wound = is_flat or local.normals is None or not local.normals.any()
        part = _with_normals(part, is_flat)
        if not is_wound and (material.ior is not None or not is_black(material.emission)):
            part = meshes.turned_to_normals(part)
    is_mirrored = is_wound and bool(np.linalg.det(own[:3, :3]) < 0.0)
    if node.flag("flip_normals", False) != is_mirrored:
        normals = None if part.normals is None else -part.normals
        part = replace(part, faces=part.faces[:, ::-1], normals=normals)
    mesh = meshes.build_mesh(node.element.path, part, material, name)
    node.lose_unread()
    return mesh


def _material(node: Node) -> Material:
    """Return the material of a shape; without a bsdf it is grey, or black if it emits."""
    bsdf, emitter = node.only("bsdf"), node.only("emitter")
    material = Material("default") if bsdf is None else read_material(bsdf)
    if bsdf is not None and node.type not in _CLOSED and is_one_sided(bsdf):
        node.lose("black backs of one-sided surfaces")
    if emitter is None:
        return material
    if emitter.type != "area":
        raise emitter.error(f"a shape has an emitter of type {shown(emitter.type)}; give area")
    radiance = read_paint(emitter, "radiance", (1.0, 1.0, 1.0), "emission")
    emitter.lose_unread()
    name = (emitter if emitter.id else node).unique_name("material")
    if bsdf is None:
        return Material(name, 0.0, radiance)
    return replace(material, name=name, emission=radiance)


def _sphere(node: Node) -> meshes.Part:
    return meshes.sphere(np.array(node.vector("center", (0.0, 0.0, 0.0))), _radius(node))


def _cylinder(node: Node) -> meshes.Part:
    start = np.array(node.vector("p0", (0.0, 0.0, 0.0)))
    end = np.array(node.vector("p1", (0.0, 0.0, 1.0)))
    if (start == end).all():
        raise node.error("both ends of a cylinder are the same; move p0 or p1")
    return meshes.cylinder(start, end, _radius(node))


def _radius(node: Node) -> float:
    radius = node.number("radius", 1.0)
    if radius <= 0.0:
        raise node.error(f"radius {radius:g} is not above 0; correct it")
    return radius


def _of_file(node: Node, mesh: Mesh, is_upright: bool) -> meshes.Part:
    """Return a mesh of a file; by default, its v counts upwards if it `is_upright`."""
    part = meshes.Part(mesh.vertices, mesh.faces, mesh.normals, mesh.uv)
    return part if node.flag("flip_tex_coords", is_upright) else _turned(part)


def _turned(part: meshes.Part) -> meshes.Part:
    """Return a part whose v counts upwards instead of downwards, or the other way round."""
    return part if part.uv is None else replace(part, uv=part.uv * [1.0, -1.0] + [0.0, 1.0])


def _with_normals(part: meshes.Part, is_flat: bool) -> meshes.Part:
    if is_flat:
        return replace(part, normals=None)
    if part.normals is not None:
        return part
    sizes, at = np.full(len(part.faces), 3), part.faces.ravel()
    normals = meshes.vertex_normals(part.vertices[at], sizes, at, len(part.vertices))
    return replace(part, normals=normals)


def _read_ply(path: Path) -> Mesh:
    return ply.read(path, ReadOptions()).meshes[0]


def read_serialized(path: Path, index: int, data: bytes) -> meshes.Part:
    """Return one of the meshes in a file's data, without normals if it is to be flat."""
    try:
        magic, version = struct.unpack_from("<HH", data)
        if magic != _MAGIC or version not in _OFFSETS:
            raise InputError("is not a .serialized file of version 3 or 4; export it again", path)
        start = _begin(path, data, version, index) if index else 0
        return _unpack(path, data[start + _HEADER :], is_named=version > min(_OFFSETS))
    except InputError:
        raise
    except (struct.error, zlib.error, ValueError):
        message = "is damaged: its meshes are not complete; export it again"
        raise InputError(message, path) from None


def _unpack(path: Path, packed: bytes, is_named: bool) -> meshes.Part:
    """Return a mesh that is compressed, of which no more is unpacked than it has to have."""
    stream = zlib.decompressobj()
    data = stream.decompress(packed, 4 + _LONGEST_NAME + 16)
    (flags,) = struct.unpack_from("<I", data)
    at = data.index(b"\0", 4, 4 + _LONGEST_NAME) + 1 if is_named else 4
    vertices, triangles = struct.unpack_from("<QQ", data, at)
    real = np.dtype("<f8" if flags & _DOUBLE else "<f4")
    whole = np.dtype("<u8" if vertices > 0xFFFFFFFF else "<u4")
    widths = [3, *(width * bool(flags & flag) for flag, width in _TABLES.items())]
    corners_at = at + 16 + vertices * sum(widths) * real.itemsize
    more = corners_at + 3 * triangles * whole.itemsize - len(data)
    if more > _MOST * len(packed):
        raise ValueError
    check_unpacked(path, more, len(packed))
    if more > 0:
        data += stream.decompress(stream.unconsumed_tail, more)
    values = np.frombuffer(data, real, vertices * sum(widths), at + 16)
    places, normals, uv, _ = (
        rows.reshape(-1, width).astype(np.float64) if width else None
        for rows, width in zip(
            np.split(values, vertices * np.cumsum(widths[:-1])), widths, strict=True
        )
    )
    assert places is not None
    faces = np.frombuffer(data, whole, 3 * triangles, corners_at).reshape(-1, 3).astype(np.int64)
    return meshes.Part(places, faces, np.zeros_like(places) if flags & _FLAT else normals, uv)


def _begin(path: Path, data: bytes, version: int, index: int) -> int:
    """Return where a mesh begins, from the table at the end of the file."""
    (count,) = struct.unpack_from("<I", data, len(data) - 4)
    if index >= count:
        message = f"has {count} meshes, counted from 0, and not number {index}"
        raise InputError(f"{message}; correct shape_index", path)
    kind = _OFFSETS[version]
    at = len(data) - 4 - struct.calcsize(kind) * (count - index)
    if at < 0:
        raise ValueError
    start: int = struct.unpack_from(kind, data, at)[0]
    return start


_FILES: dict[str, Callable[[Node], meshes.Part]] = {
    "obj": lambda node: _of_file(node, node.read_file(obj.read_shape), True),
    "ply": lambda node: _of_file(node, node.read_file(_read_ply), False),
    "serialized": lambda node: _turned(
        read_serialized(node.file(), node.whole("shape_index", 0), node.read_file(read_bytes))
    ),
}
_SHAPES: dict[str, Callable[[Node], meshes.Part]] = {
    "rectangle": lambda node: meshes.rectangle(),
    "cube": lambda node: meshes.cube(),
    "sphere": _sphere,
    "disk": lambda node: meshes.disk(),
    "cylinder": _cylinder,
    **_FILES,
}
