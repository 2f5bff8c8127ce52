"""Check a scene once, and turn it into the arrays that kernels trust.

Kernels work near the origin, at unit size and unit power, whatever the scene's: `CompiledScene`
keeps the factors that turn lengths and radiances back.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.camera import compile_camera, frame_scene
from photonmap.compile.frame import Frame, choose_frame
from photonmap.compile.geometry import check_meshes, join_meshes
from photonmap.compile.lights.emitters import DEFAULT_LIGHT, Emitters, compile_lights
from photonmap.compile.materials import compile_materials
from photonmap.compile.media.media import plan_media
from photonmap.compile.surfaces.coats import with_coats
from photonmap.compile.surfaces.fluorescence import with_concentrations
from photonmap.compile.surfaces.glass import beside_glass, clear_textures, opaque_part, with_glass
from photonmap.compile.surfaces.relief import Reliefs, given_tangents
from photonmap.compile.surfaces.sheens import with_sheens
from photonmap.compile.textures import compile_textures
from photonmap.compile.ultraviolet import warn_of_ultraviolet
from photonmap.errors import naming_file
from photonmap.kernels.core import passes, records
from photonmap.kernels.core.jit import CACHE_FOLDER
from photonmap.kernels.core.record_types import with_absent
from photonmap.kernels.geometry.embree import EmbreeScene
from photonmap.kernels.lights import kinds
from photonmap.runtime.fingerprint import digest
from photonmap.scene.camera import Camera, check_camera
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Colored, parameters_of
from photonmap.scene.scene import Scene
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Floats, Spectrum
from photonmap.version import __version__

_LOBES = frozenset({"specular", "scattering", "fluorescence"})
VARIANTS: dict[str, frozenset[str]] = {
    "plain": _LOBES | {"textures", "alpha", "relief"},
    "textured": _LOBES,
    "full": frozenset({"fluorescence"}),
    "fluorescent": frozenset(),
}
"""Kernels are compiled without these records of the scene and its geometry: the leanest first.

A record that a scene lacks is absent, and kernels find out at run time. That costs next to nothing
where it is about lights, up to 3% where surfaces lack images, and more where they lack lobes
(docs/performance.md).
"""


@dataclass
class CompiledScene:
    """A scene as kernels see it, and the way back to scene units."""

    geometry: records.Geometry
    materials: records.Materials
    lights: records.Lights
    specular: records.Specular | None  # None in a scene without mirrors and glass
    textures: records.Textures | None  # None in a scene without textured reflectances
    scattering: records.Scattering | None  # None where all surfaces are Lambertian or specular
    fluorescence: records.Fluorescence | None  # None where no surface fluoresces
    camera: Camera  # in scene units
    center: Floats
    size: float  # scene units in a unit of the kernels' length
    power: float  # W·m⁻²·sr⁻¹ in a unit of the kernels' radiance
    white: Floats  # (N,) colour of all light together, of mean 1
    object_ids: NDArray[np.uint32]  # (T,) from 1
    material_ids: NDArray[np.uint32]  # (T,) from 1
    light_names: list[str]  # of each emitter, (K,)
    light_groups: list[str]  # of each emitter, (K,)
    light_powers: Floats
    """of each emitter, (K,), W for scene units of metres: the mean over bands; textures count with
    their mean"""
    counts: dict[str, int]
    object_names: list[str]  # of object 1, 2, …
    material_names: list[str]  # of material 1, 2, …
    images: list[Any] = field(repr=False)  # texels, of which kernels have the addresses
    embree: EmbreeScene | None = None  # None where rays cannot be traced

    @cached_property
    def arrays(self) -> records.SceneArrays:
        """The scene as kernels take it: most of what it lacks is `absent`, so false, not None."""
        arrays = records.SceneArrays(
            self.geometry,
            self.materials,
            self.lights,
            self.specular,
            self.textures,
            self.scattering,
            self.fluorescence,
        )
        return with_absent(arrays, VARIANTS[variant_of(arrays)])

    @property
    def has_residual(self) -> bool:
        """Whether light may be seen that is not the Lambertian reflection of first hits."""
        return self.specular is not None or self.scattering is not None

    @property
    def group_whites(self) -> dict[str, Floats]:
        """The part of `white` that is due to the lights of each group, (N,)."""
        spectra = self.lights.spectra[self.lights.spectrum].astype(np.float64)
        mean = spectra.mean(axis=1, keepdims=True)
        color = np.divide(spectra, mean, where=mean > 0.0, out=np.zeros_like(spectra))
        parts = color * (self.light_powers / self.light_powers.sum())[:, None]
        whites = {group: np.zeros(spectra.shape[1]) for group in self.light_groups}
        for group, part in zip(self.light_groups, parts, strict=True):
            whites[group] += part
        return whites

    @property
    def is_thin(self) -> NDArray[np.bool_]:
        """Which materials are thin glass, (M,)."""
        alpha, specular = self.geometry.alpha, self.specular
        thin = np.zeros(len(self.materials.reflectance), bool)
        if specular is not None:
            thin |= specular.kind == records.THIN
        if alpha is not None and alpha.panes is not None:
            thin |= alpha.panes.ior > 0.0
        return thin

    @cached_property
    def hashes(self) -> dict[str, str]:
        """Hashes of all arrays, by what they describe."""
        scatterers = self.specular, self.scattering, self.textures
        glow = () if self.fluorescence is None else (self.fluorescence,)
        ids = self.object_ids, self.material_ids
        return {
            "geometry": digest((self.geometry, (self.center, self.size), ids)),
            "materials": digest((self.materials, scatterers, self.images, *glow)),
            "lights": digest((self.lights, self.light_groups, self.power)),
        }

    def film_camera(self, width: int, height: int) -> passes.Camera:
        """Return the camera over an image of the given size, in the kernels' units."""
        camera = compile_camera(self.camera, Frame(self.center, self.size), (width, height))
        return with_absent(camera)


def compile_scene(scene: Scene, bands: Bands, aspect: float = 1.0) -> CompiledScene:
    """Check a scene and turn it into arrays, among which rays can be traced.

    As `compile_arrays` otherwise.
    """
    compiled = compile_arrays(scene, bands, aspect)
    embree = EmbreeScene(compiled.geometry.vertices, compiled.geometry.triangles)
    geometry = compiled.geometry._replace(scene=embree.address)
    return replace(compiled, geometry=geometry, embree=embree)


def seen_by(compiled: CompiledScene, scene: Scene, vertices: Floats) -> CompiledScene | None:
    """Return a compiled scene as the camera of a scene of the same meshes and lights sees it.

    None where more depends on the camera: the origin, which may be a camera that stands close to
    something, or the default light. Vertices are those of the scene's faces, (V, 3).
    """
    if scene.camera is None or DEFAULT_LIGHT in compiled.light_names:
        return None
    with naming_file(scene.file):
        camera = check_camera(scene.camera)
    center, size = choose_frame(vertices, camera)
    if size != compiled.size or not np.array_equal(center, compiled.center):
        return None
    seen = replace(compiled, camera=camera)
    seen.hashes = compiled.hashes
    return seen


def compile_arrays(scene: Scene, bands: Bands, aspect: float = 1.0) -> CompiledScene:
    """Check a scene and turn it into arrays.

    `aspect` is width / height of the image, to frame a scene without a camera. An `InputError` says
    that there is nothing to render, or which mesh, material, light or camera is not valid.
    """
    with naming_file(scene.file):
        compiled = _compile(scene, bands, aspect)
    warn_of_ultraviolet(scene, bands)
    return compiled


def _compile(scene: Scene, bands: Bands, aspect: float) -> CompiledScene:
    meshes = check_meshes(scene)
    camera, frame = _look(scene, np.concatenate([mesh.vertices for mesh in meshes]), aspect)
    materials = list({id(mesh.material): mesh.material for mesh in meshes}.values())
    plan = plan_media(meshes, materials, bands, frame)
    materials = [opaque_part(material) for material in materials]
    compiled = compile_materials(materials, bands)
    geometry, owner, media = plan.place(*join_meshes(plan.meshes, frame, plan.ranks), frame)
    geometry, objects = geometry._replace(material=plan.rows[owner]), _object_ids(meshes)
    table = compile_textures(materials, compiled.divisors, clear_textures(materials, bands))
    reliefs = Reliefs(geometry, table, frame.size, given_tangents(plan.meshes))
    specular = with_glass(compiled.specular, materials, table, bands)
    specular = reliefs.with_anisotropic_chains(specular, materials)
    lobes = reliefs.with_anisotropy(table.lobes(compiled.scattering, bands), materials)
    lobes = with_coats(with_sheens(lobes, materials, table, bands), materials, reliefs)
    emitters = compile_lights(geometry, materials, scene, bands, frame, table, camera)
    alpha, relief = table.holes(compiled.panes), reliefs.of_surfaces(materials)
    geometry = geometry._replace(emitter=emitters.of_triangle, alpha=alpha, relief=relief)
    return CompiledScene(
        geometry=_with_corners(geometry, emitters.lights),
        materials=compiled.diffuse,
        lights=emitters.lights,
        specular=specular and specular._replace(media=media),
        textures=table.textures(bands),
        scattering=beside_glass(lobes, materials, specular),
        fluorescence=with_concentrations(compiled.fluorescence, table),
        camera=camera,
        center=frame.center,
        size=frame.size,
        power=emitters.power,
        white=emitters.white,
        object_ids=objects[owner],
        material_ids=(geometry.material + 1).astype(np.uint32),
        light_names=emitters.names,
        light_groups=emitters.groups,
        light_powers=emitters.flux * frame.size**2,
        counts=_count(scene, objects, materials, geometry, emitters),
        object_names=list(dict.fromkeys(mesh.name for mesh in meshes)),
        material_names=[material.name for material in materials],
        images=table.images,
    )


def _with_corners(geometry: records.Geometry, lights: records.Lights) -> records.Geometry:
    """Leave out exact vertices and normals where all emitters have an area."""
    if np.isin(lights.kind, kinds.WITHOUT_AREA).any():
        return geometry
    return geometry._replace(corners=np.empty((0, 3)), corner_normals=np.empty((0, 3)))


def _look(scene: Scene, vertices: Floats, aspect: float) -> tuple[Camera, Frame]:
    """Return the scene's camera, or one that shows all of it, and the frame of the kernels."""
    camera = None if scene.camera is None else check_camera(scene.camera)
    frame = choose_frame(vertices, camera)
    return camera or frame_scene(vertices, aspect, scene.up, scene.fov), frame


def _count(
    scene: Scene,
    objects: NDArray[np.uint32],
    materials: list[Material],
    geometry: records.Geometry,
    emitters: Emitters,
) -> dict[str, int]:
    """Return what the run record counts."""
    colored = [name for name, kind in parameters_of(Material).items() if isinstance(kind, Colored)]
    colors = [getattr(mesh.material, name) for mesh in scene.meshes for name in colored]
    colors += [light.color for light in scene.lights]
    return {
        "objects": int(objects.max()),
        "materials": len(materials),
        "triangles": len(geometry.triangles),
        "vertices": len(geometry.vertices),
        "emitting_triangles": int((emitters.of_triangle >= 0).sum()),
        "lights": len(set(emitters.names)),
        "spectra": any(isinstance(color, Spectrum) for color in colors),
    }


def _object_ids(meshes: list[Mesh]) -> NDArray[np.uint32]:
    """Count meshes by name, from 1, in order of appearance."""
    number = {name: i for i, name in enumerate(dict.fromkeys(m.name for m in meshes), start=1)}
    return np.array([number[mesh.name] for mesh in meshes], np.uint32)


def variant_of(scene: records.SceneArrays) -> str:
    """Return the first variant that has all that a scene has."""
    holders = scene, scene.geometry
    there = {
        name
        for name in VARIANTS["plain"]
        if any(getattr(holder, name, None) is not None for holder in holders)
    }
    return next(name for name, without in VARIANTS.items() if not there & without)


def describe_run(
    compiled: CompiledScene, bands: Bands, film: passes.Film, arguments: dict[str, Any]
) -> dict[str, Any]:
    """Return the fingerprint of a render, JSON-able: arguments as they are, arrays as hashes.

    Runs that agree in it can be resumed, or merged. The scene is whole, in these bands; arguments
    are further numbers and strings that decide the arrays, by name.
    """
    camera = compiled.film_camera(film.width, film.height)
    return {
        "photonmap": __version__,
        "bands": bands.count,
        "size": f"{film.width}x{film.height}",
        **arguments,
        "band curves": digest(json.dumps(bands.describe())),
        "camera": digest(camera),
        **compiled.hashes,
        "kernels": CACHE_FOLDER.name,
    }
