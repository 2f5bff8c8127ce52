"""All that there is to say about a scene file, as plain values for JSON."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from os import PathLike
from typing import Any

import numpy as np

from photonmap.compile.effects import plan_effects
from photonmap.compile.scene_arrays import CompiledScene, compile_arrays
from photonmap.compile.spectral_columns import count_distinct
from photonmap.errors import SceneWarning, listening
from photonmap.inspection.remedies import find_remedy
from photonmap.io.readers.scene_file import scene_files
from photonmap.io.scene_source import SceneSource
from photonmap.scene.camera import Camera, check_camera
from photonmap.scene.lights import (
    EnvironmentLight,
    Light,
    PhotometricLight,
    SpotLight,
    check_light,
    name_lights,
)
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Direction, File, Number, Point, parameters_of, unit
from photonmap.scene.scene import Scene
from photonmap.scene.surfaces.dispersion import Cauchy, NamedGlass, Sellmeier
from photonmap.scene.surfaces.layers import name_kind
from photonmap.scene.surfaces.relief import AnisotropyMap, BumpMap, NoRelief, NormalMap
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum

FORMATS = {
    ".glb": "glTF 2.0, binary",
    ".gltf": "glTF 2.0",
    ".obj": "Wavefront OBJ",
    ".off": "OFF",
    ".ply": "PLY",
    ".stl": "STL",
}
UNITS = ((0.0, "metres", 1.0), (50.0, "centimetres", 0.01), (1600.0, "millimetres", 0.001))
"""From which longest side on, a unit's name, and metres in it: rooms are the likeliest scenes, and
measure about 5 m. The limits are geometric means: 50 m are as unlikely as 0.5 m."""
_IN_METRES = (".glb", ".gltf")
LARGEST = 1e6
"""Longest side of which a unit can be guessed."""


def inspect_file(source: SceneSource, bands: Bands) -> tuple[Scene, dict[str, Any]]:
    """Load a scene; return it, and what is in its file.

    Warnings are part of the description, and not issued.

    Parameters
    ----------
    bands : over which light is averaged
    """
    files = scene_files(source.path)
    suffix = files[0].suffix.lower()
    with warnings.catch_warnings(), listening() as messages:
        warnings.simplefilter("ignore", SceneWarning)
        scene = source.load()
        described = describe_scene(scene, bands, suffix)
    about = [{"message": message, "remedy": find_remedy(message)} for message in messages]
    head = {
        "file": source.path,
        "files": [str(path) for path in files],
        "format": FORMATS.get(suffix, suffix[1:].upper()),
    }
    return scene, {**head, **described, "warnings": about}


def describe_scene(scene: Scene, bands: Bands, suffix: str = "") -> dict[str, Any]:
    """Return what is in a scene, which was read from a file of a suffix."""
    compiled = compile_arrays(scene, bands)
    plan = plan_effects(compiled, "auto", count_distinct(compiled), bands.count)
    meshes = [mesh for mesh in scene.meshes if len(mesh.faces)]
    materials = describe_materials(meshes)
    bounds = describe_bounds(meshes)
    cameras = [check_camera(camera) for camera in scene.every_camera]
    return {
        "totals": {
            "meshes": len(meshes),
            "triangles": sum(len(mesh.faces) for mesh in meshes),
            "vertices": sum(len(mesh.vertices) for mesh in meshes),
            "materials": len(materials),
            "lights": len(scene.lights),
            "cameras": len(cameras),
            "power": float(compiled.light_powers.sum()),
        },
        "bounds": bounds,
        "unit": guess_unit(bounds["size"], suffix),
        "meshes": [describe_mesh(mesh) for mesh in meshes],
        "materials": materials,
        "lights": describe_lights(scene, compiled),
        "area_lights": describe_area_lights(scene, compiled),
        "cameras": [describe_camera(camera) for camera in cameras],
        "framed_camera": None if cameras else describe_camera(compiled.camera),
        "bands": bands.describe(),
        "effects": {name: {"on": e.on, "why": e.why} for name, e in plan.effects.items()},
    }


def describe_bounds(meshes: Sequence[Mesh]) -> dict[str, Any]:
    """Return the corners of the box around meshes that have vertices, and its sides."""
    low = np.min([mesh.vertices.min(axis=0) for mesh in meshes], axis=0)
    high = np.max([mesh.vertices.max(axis=0) for mesh in meshes], axis=0)
    return {"low": low.tolist(), "high": high.tolist(), "size": (high - low).tolist()}


def guess_unit(size: Sequence[float], suffix: str = "") -> dict[str, Any]:
    """Return the likely unit of length, the longest side in metres, and what this rests on.

    Parameters
    ----------
    size : sides of the box around the scene
    suffix : of the file; glTF prescribes a unit
    """
    longest = max(size)
    says = "glTF prescribes metres" if suffix in _IN_METRES else "the format does not say"
    if not 0.0 < longest <= LARGEST:
        return {"guess": None, "metres": None, "why": f"the size is unusual; {says}"}
    name, metre = [(name, metre) for least, name, metre in UNITS if longest >= least][-1]
    metres = longest * metre
    why = f"the longest side would be {metres:.3g} m; {says}"
    return {"guess": name, "metres": metres, "why": why}


SMOOTH = 1e-4
"""Radians by which normals of a triangle's corners differ where shading is smooth."""
MOST = 1 << 16
"""Triangles of a mesh that are examined, evenly chosen."""


def describe_mesh(mesh: Mesh) -> dict[str, Any]:
    """Return what the JSON says of a mesh."""
    return {
        "name": mesh.name,
        "material": mesh.material.name,
        "triangles": len(mesh.faces),
        "vertices": len(mesh.vertices),
        "uv": mesh.uv is not None,
        "normals": mesh.normals is not None,
        "smooth": _is_smooth(mesh),
        "colors": _describe_colors(mesh),
    }


def _describe_colors(mesh: Mesh) -> dict[str, Any] | None:
    """Return whose the colours are that replace the reflectance, and their mean; None for none."""
    if mesh.colors is None:
        return None
    owners = "vertices" if mesh.colors.ndim == 2 else "faces"
    if mesh.colors.shape[1:] == (3, 3):
        owners = "corners of faces"
    return {"of": owners, "mean": mesh.colors.reshape(-1, 3).mean(axis=0).tolist()}


def _is_smooth(mesh: Mesh) -> bool:
    """Return whether normals vary within triangles."""
    if mesh.normals is None:
        return False
    faces = mesh.faces[:: -(-len(mesh.faces) // MOST)]
    normals = mesh.normals[faces]
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), np.finfo(float).tiny)
    return bool((np.abs(normals - normals[:, :1]) > SMOOTH).any())


def describe_materials(meshes: Sequence[Mesh]) -> list[dict[str, Any]]:
    """Return what the JSON says of the materials of meshes, in order of appearance.

    Materials of one name, as one in the colours of several meshes, have the names of their meshes.
    """
    users: dict[int, list[Mesh]] = {}
    for mesh in meshes:
        users.setdefault(id(mesh.material), []).append(mesh)
    materials = [group[0].material for group in users.values()]
    count = Counter(material.name for material in materials)
    return [
        {
            "name": material.name,
            "kind": name_kind(material),
            "triangles": sum(len(mesh.faces) for mesh in group),
            **(_name_users(group) if count[material.name] > 1 else {}),
            **_describe_attributes(material),
        }
        for material, group in zip(materials, users.values(), strict=True)
    ]


def _name_users(meshes: Sequence[Mesh]) -> dict[str, list[str]]:
    return {"meshes": [*dict.fromkeys(mesh.name for mesh in meshes)]}


def _describe_attributes(material: Material) -> dict[str, Any]:
    """Return the attributes that differ from the defaults, and the reflectance of what has one."""
    attributes = {}
    for attribute in parameters_of(Material):
        value = getattr(material, attribute)
        if attribute == "name" or not material.takes(attribute):
            continue
        default = getattr(Material, attribute)
        is_default = isinstance(value, float | int | tuple) and value in (default, (default,) * 3)
        if attribute == "reflectance" or not is_default:
            attributes[attribute] = describe_color(value)
    return {name: value for name, value in attributes.items() if value is not None}


def describe_color(color: Any) -> Any:
    """Return a colour for JSON: a number, [red, green, blue], or an object for what is larger."""
    if isinstance(color, Spectrum):
        low, high = color.wavelengths[[0, -1]].tolist()
        return {"spectrum": {"samples": len(color.values), "range_nm": [low, high]}}
    if isinstance(color, SpectralTexture):
        (height, width), low_high = color.index.shape, color.wavelengths[[0, -1]].tolist()
        spectra = {"spectra": len(color.spectra), "samples": len(color.wavelengths)}
        size = {"width": width, "height": height}
        return {"texture": {**size, **spectra, "range_nm": low_high, "mean": list(color.mean)}}
    if isinstance(color, Texture):
        height, width, channels = color.image.texels.shape
        bits = 8 * color.image.texels.itemsize
        return {
            "texture": {
                "width": width,
                "height": height,
                "channels": channels,
                "bits": bits,
                "mean": list(color.mean),
            }
        }
    if isinstance(color, NormalMap | BumpMap):
        return {"type": color.kind, "factor": color.factor, **describe_color(color.texture)}
    if isinstance(color, AnisotropyMap):
        return describe_color(color.texture)
    if isinstance(color, NoRelief):
        return color.kind
    if isinstance(color, Cauchy | Sellmeier | NamedGlass):
        return {"type": color.kind, **asdict(color)}
    return list(color) if isinstance(color, tuple) else color


def describe_area_lights(scene: Scene, compiled: CompiledScene) -> list[dict[str, Any]]:
    """Return what the JSON says of each emitting surface: of an object, and of a material."""
    is_area = compiled.lights.triangle >= 0
    triangles = compiled.lights.triangle[is_area]
    if not len(triangles):
        return []
    pairs = np.stack([compiled.object_ids[triangles], compiled.material_ids[triangles]], axis=1)
    owners, owner = np.unique(pairs, axis=0, return_inverse=True)
    meshes = [mesh for mesh in scene.meshes if len(mesh.faces)]
    names = list(dict.fromkeys(mesh.name for mesh in meshes))
    total = compiled.light_powers.sum()
    described = []
    for number, (thing, _) in enumerate(owners):
        mine = np.flatnonzero(is_area)[owner.ravel() == number]
        power = float(compiled.light_powers[mine].sum())
        described.append(
            {
                "name": names[thing - 1],
                "material": compiled.light_names[mine[0]],
                "triangles": len(mine),
                "area": float(compiled.lights.area[mine].sum()) * compiled.size**2,
                "power": power,
                "share": power / total,
            }
        )
    return described


def describe_lights(scene: Scene, compiled: CompiledScene) -> list[dict[str, Any]]:
    """Return what the JSON says of the lights that are not surfaces; a dark one has no power.

    In a scene without light, this is the sky in its place.
    """
    powers: dict[str, float] = {}
    areas = []
    for name, triangle, power in zip(
        compiled.light_names, compiled.lights.triangle, compiled.light_powers.tolist(), strict=True
    ):
        if triangle >= 0:
            areas.append(name)
        else:
            powers[name] = power
    total = compiled.light_powers.sum()
    lights = name_lights([check_light(light) for light in scene.lights], areas)
    known = {light.name for light in lights}
    default = [name for name in powers if name not in known]
    return [
        {
            "name": light.name,
            "kind": light.kind,
            "group": light.group or light.name,
            "power": powers.get(light.name, 0.0),
            "share": powers.get(light.name, 0.0) / total,
            **_describe_light(light),
        }
        for light in lights
    ] + [
        {
            "name": name,
            "kind": EnvironmentLight.kind,
            "group": name,
            "power": powers[name],
            "share": 1.0,
        }
        for name in default
    ]


def _describe_light(light: Light) -> dict[str, Any]:
    """Return the amount of a light, where it stands, and in which direction it shines."""
    properties: dict[str, Any] = {}
    if light.color_attribute is not None:
        properties[light.color_attribute] = describe_color(light.color)
    for attribute, parameter in parameters_of(type(light)).items():
        value: Any = getattr(light, attribute)
        if isinstance(parameter, Point | Direction):
            properties[attribute] = list(value)
        elif isinstance(parameter, Number):
            properties[attribute] = value
        elif isinstance(parameter, File):
            is_name = isinstance(value, str | PathLike)
            properties[attribute] = str(value) if is_name else list(np.shape(value))
    if isinstance(light, SpotLight):
        properties["direction"] = list(light.emitter().axis)
    if isinstance(light, PhotometricLight):
        direction = unit(np.array(light.direction))
        assert direction is not None
        properties["direction"] = direction.tolist()
    return properties


def describe_camera(camera: Camera) -> dict[str, Any]:
    """Return what the JSON says of a checked camera."""
    return {
        "name": camera.name,
        "kind": camera.model.kind,
        "origin": list(camera.origin),
        "target": list(camera.target),
        "up": list(camera.up),
        **camera.model.describe(),
        "lens": None if camera.lens is None else camera.lens.describe(),
    }
