"""Check a scene once, and turn it into the arrays that kernels trust.

Kernels work near the origin, at unit size and unit power, whatever the scene's: `Prepared` keeps
the factors that turn lengths and radiances back.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.bands import Bands
from photonmap.camera import check_camera, frame_of, frame_scene
from photonmap.emitters import collect_emitters
from photonmap.errors import InputError, warn
from photonmap.kernels import records
from photonmap.kernels.embree import EmbreeScene
from photonmap.matter import collect_matter
from photonmap.messages import listed
from photonmap.scene import Camera, Material, Mesh, Scene
from photonmap.spectra.curves import Spectrum
from photonmap.textures import FARTHEST, Paint, Texture, collect_pictures, mean_color, mean_opacity
from photonmap.tidy import find_single, without_strays
from photonmap.triangles import winding_normals

SMALLEST, LARGEST = 1e-30, 1e30
"""Scene units of a scene: images are float32."""
LEAST_AREA = 1e-34
"""Of a triangle, in the square of the scene's size, that light can meet: its inverse is float32."""
CLOSE = 1e-3
"""Of a scene's size: nearer vertices are seen in detail that its middle would blur."""


@dataclass
class Prepared:
    """A scene as kernels see it, and the way back to scene units."""

    geometry: records.Geometry
    materials: records.Materials
    lights: records.Lights
    optics: records.Optics | None
    """None in a scene without smooth surfaces"""
    textures: records.Textures | None
    """None in a scene without textured reflectances"""
    camera: Camera
    """in scene units"""
    center: NDArray[np.float64]
    size: float
    """scene units in a unit of the kernels' length"""
    power: float
    """W·m⁻²·sr⁻¹ in a unit of the kernels' radiance"""
    object_ids: NDArray[np.uint32]
    """(T,) from 1"""
    material_ids: NDArray[np.uint32]
    """(T,) from 1"""
    light_names: list[str]
    """of each emitter, (K,)"""
    light_groups: list[str]
    """of each emitter, (K,)"""
    counts: dict[str, int]
    embree: EmbreeScene
    images: list[Any] = field(repr=False)
    """texels, of which kernels have the addresses"""

    @property
    def arrays(self) -> records.SceneArrays:
        """The scene as kernels take it."""
        return self.geometry, self.materials, self.lights, self.optics, self.textures

    def film_camera(self, width: int, height: int) -> records.Camera:
        """Return the camera over an image of the given size, in the kernels' units."""
        origin = (np.array(self.camera.origin) - self.center) / self.size
        view, right, up = frame_of(self.camera)
        pixel = 2.0 * np.tan(np.radians(self.camera.fov) / 2.0) / height
        corner = view + pixel * (0.5 * height * up - 0.5 * width * right)
        vectors = (origin, corner, pixel * right, -pixel * up)
        return records.Camera(*(tuple(map(float, vector)) for vector in vectors))


def prepare(scene: Scene, bands: Bands, aspect: float = 1.0) -> Prepared:
    """Check a scene and turn it into arrays.

    Parameters
    ----------
    scene : what to render
    bands : in how many bands
    aspect : width / height of the image, to frame a scene without a camera

    Raises
    ------
    InputError : nothing to render, or a mesh, material, light or camera that is not valid
    """
    meshes = [mesh for mesh in scene.meshes if len(mesh.faces)]
    if not meshes:
        raise InputError(f"scene {scene.name!r} has no faces: there is nothing to render")
    for mesh in meshes:
        _check_mesh(mesh)
    meshes = _flatten([without_strays(mesh) for mesh in meshes])
    camera = check_camera(scene.camera) if scene.camera else None
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    size = _size(low, high)
    center = _choose_center(vertices, camera, 0.5 * (low + high), size)
    materials = _distinct_materials(meshes)
    geometry, owner = _triangles(meshes, center, size)
    index_of = {id(material): index for index, material in enumerate(materials)}
    material = np.array([index_of[id(mesh.material)] for mesh in meshes], np.int32)[owner]
    matter, optics, shrink = collect_matter(materials, bands)
    pictures = collect_pictures(materials, shrink)
    emitters = collect_emitters(
        geometry, material, materials, scene.lights, bands, center, size, pictures
    )
    embree = EmbreeScene(geometry.vertices, geometry.triangles)
    objects = _object_ids(meshes)
    return Prepared(
        geometry._replace(
            scene=embree.address,
            material=material,
            emitter=emitters.of_triangle,
            alpha=pictures.holes(),
        ),
        matter,
        emitters.lights,
        optics,
        pictures.textures(bands),
        camera or frame_scene(vertices, aspect),
        center,
        size,
        emitters.power,
        objects[owner],
        (material + 1).astype(np.uint32),
        emitters.names,
        emitters.groups,
        {
            "objects": int(objects.max()),
            "materials": len(materials),
            "triangles": len(material),
            "vertices": len(vertices),
            "emitting_triangles": int((emitters.of_triangle >= 0).sum()),
            "lights": len(set(emitters.names)),
            "spectra": any(isinstance(color, Spectrum) for color in _colors(scene)),
        },
        embree,
        pictures.images,
    )


def _size(low: NDArray[np.float64], high: NDArray[np.float64]) -> float:
    """Return the longest side of the box from low to high; 1 where all is in one point."""
    with np.errstate(over="ignore"):
        size = float((high - low).max()) or 1.0
    if not SMALLEST <= size <= LARGEST:
        raise InputError(
            f"the scene measures {size:.3g} units: depths of {SMALLEST:g} to {LARGEST:g} can be "
            f"told; choose another unit"
        )
    return size


def _choose_center(
    vertices: NDArray[np.float64],
    camera: Camera | None,
    middle: NDArray[np.float64],
    size: float,
) -> NDArray[np.float64]:
    """Return the origin of the kernels' numbers, about which float32 is finest.

    The scene's middle; or the camera, where it stands among things that are small against the
    scene.
    """
    if camera is None:
        return middle
    origin = np.array(camera.origin)
    nearest = np.abs(vertices - origin).max(axis=1).min()
    inside = np.abs(origin - middle).max() <= size
    return origin if inside and nearest < CLOSE * size else middle


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
    if mesh.normals is not None and mesh.normals.shape != mesh.vertices.shape:
        raise InputError(
            f"{name}: normals must be {mesh.vertices.shape}, one a vertex, not {mesh.normals.shape}"
        )
    if mesh.uv is not None and _is_textured(mesh.material):
        if mesh.uv.shape != (len(mesh.vertices), 2):
            wanted = (len(mesh.vertices), 2)
            raise InputError(f"{name}: uv must be {wanted}, one a vertex, not {mesh.uv.shape}")
        sound = (np.abs(mesh.uv) <= FARTHEST).all(axis=1)
        if not sound.all():
            row = int(np.argmin(sound))
            raise InputError(
                f"{name}: uv {row} is {mesh.uv[row]}; give finite numbers up to {FARTHEST:g}"
            )


def _is_textured(material: Material) -> bool:
    paints = (material.reflectance, material.emission, material.alpha)
    return any(isinstance(paint, Texture) for paint in paints)


def _flatten(meshes: list[Mesh]) -> list[Mesh]:
    """Give meshes without texture coordinates the mean of their textures, and say so."""
    flat: dict[int, Material] = {}
    named: dict[str, None] = {}
    result = []
    for mesh in meshes:
        material = mesh.material
        if mesh.uv is None and _is_textured(material):
            named[f"{mesh.name} ({material.name})"] = None
            if id(material) not in flat:
                flat[id(material)] = replace(
                    material,
                    reflectance=mean_color(material.reflectance),
                    emission=mean_color(material.emission),
                    alpha=mean_opacity(material.alpha),
                )
            mesh = replace(mesh, material=flat[id(material)])
        result.append(mesh)
    if named:
        warn(
            f"no texture coordinates in meshes (of material) {listed(named)}: "
            "their textures' mean is taken"
        )
    return result


def _colors(scene: Scene) -> Iterator[Paint]:
    """Give all colours of a scene."""
    for mesh in scene.meshes:
        material = mesh.material
        yield from (material.reflectance, material.emission, material.mirror, material.tint)
    for light in scene.lights:
        yield light.color


def _distinct_materials(meshes: list[Mesh]) -> list[Material]:
    return list({id(mesh.material): mesh.material for mesh in meshes}.values())


def _object_ids(meshes: list[Mesh]) -> NDArray[np.uint32]:
    """Count meshes by name, from 1, in order of appearance."""
    number = {name: i for i, name in enumerate(dict.fromkeys(m.name for m in meshes), start=1)}
    return np.array([number[mesh.name] for mesh in meshes], np.uint32)


def _triangles(
    meshes: list[Mesh], center: NDArray[np.float64], size: float
) -> tuple[records.Geometry, NDArray[np.int64]]:
    """Join meshes near the origin at unit size; return them and each triangle's mesh."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    vertices = np.concatenate([(mesh.vertices - center) / size for mesh in meshes])
    vertices = vertices.astype(np.float32)
    triangles = np.concatenate(
        [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    )
    owner = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])

    normals = winding_normals(vertices, triangles)
    length = np.linalg.norm(normals, axis=1)
    sound = length > LEAST_AREA
    if count := int((~sound).sum()):
        warn(f"{count} degenerate triangle{'s' * (count > 1)} (no area) left out")
    if not sound.any():
        raise InputError("every triangle is degenerate (no area): there is nothing to render")
    sound[sound] = _single(meshes, vertices, triangles[sound], owner[sound])
    triangles, owner, normals, length = (x[sound] for x in (triangles, owner, normals, length))
    smooth = any(mesh.normals is not None for mesh in meshes)
    shading = np.concatenate([_shading_normals(mesh) for mesh in meshes]) if smooth else None
    none = np.empty(0, np.int32)
    textured = any(_is_textured(mesh.material) for mesh in meshes)
    uv = np.concatenate([_uv(mesh) for mesh in meshes]) if textured else None
    return records.Geometry(
        0,
        vertices,
        triangles.astype(np.int32),
        (normals / length[:, None]).astype(np.float32),
        np.zeros((0, 3), np.float32) if shading is None else shading,
        none,
        none,
        np.zeros((0, 2), np.float32) if uv is None else uv,
        None,
    ), owner


def _single(
    meshes: list[Mesh],
    vertices: NDArray[np.float32],
    triangles: NDArray[np.int64],
    owner: NDArray[np.int64],
) -> NDArray[np.bool_]:
    """Tell which triangles are there once, and warn of the others: (T,)."""
    lamps = np.array([_may_emit(mesh.material.emission) for mesh in meshes])
    indices = np.array([_index(mesh.material) for mesh in meshes])
    kept = find_single(vertices, triangles, owner, lamps, indices)
    if count := int((~kept).sum()):
        warn(f"{count} triangle{'s' * (count > 1)} at the place of another left out")
    return kept


def _index(material: Material) -> float:
    return float(material.ior) if isinstance(material.ior, int | float) else 0.0


def _may_emit(paint: Paint) -> bool:
    return isinstance(paint, Spectrum | Texture) or bool(np.any(paint))


def _uv(mesh: Mesh) -> NDArray[np.float32]:
    if mesh.uv is None or not _is_textured(mesh.material):
        return np.zeros((len(mesh.vertices), 2), np.float32)
    return mesh.uv.astype(np.float32)


def _shading_normals(mesh: Mesh) -> NDArray[np.float32]:
    if mesh.normals is None:
        return np.zeros(mesh.vertices.shape, np.float32)
    largest = np.abs(mesh.normals).max(axis=1, initial=0.0, keepdims=True)
    sound = (largest > 0.0) & (largest < np.inf)
    scaled = np.divide(mesh.normals, largest, out=np.zeros_like(mesh.normals), where=sound)
    length = np.linalg.norm(scaled, axis=1, keepdims=True)
    return np.divide(scaled, length, out=scaled, where=sound).astype(np.float32)
