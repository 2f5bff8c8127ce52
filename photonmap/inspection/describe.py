"""All that there is to say about a scene file, as plain values for JSON, with remedies."""

from __future__ import annotations

import re
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
from photonmap.io.readers.scene_file import scene_files
from photonmap.io.scene_source import SceneSource
from photonmap.scene.camera import Camera, check_camera
from photonmap.scene.lights import (
    EnvironmentLight,
    Light,
    PhotometricLight,
    SpotLight,
    check_lights,
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
from photonmap.spectra.fluorescence import DonaldsonMatrix, Fluorescence

FORMATS = {".glb": "glTF 2.0, binary", ".gltf": "glTF 2.0", ".obj": "Wavefront OBJ"}
"""Formats whose names are not their suffixes."""
UNITS = ((0.0, "metres", 1.0), (50.0, "centimetres", 0.01), (1600.0, "millimetres", 0.001))
"""From which longest side on, a unit's name, and metres in it: rooms are the likeliest scenes, and
measure about 5 m. The limits are geometric means: 50 m are as unlikely as 0.5 m."""
_IN_METRES = (".glb", ".gltf")
LARGEST = 1e6
"""Longest side of which a unit can be guessed."""


def inspect_file(source: SceneSource, bands: Bands) -> tuple[Scene, dict[str, Any]]:
    """Load a scene; return it and what is in its file, with its warnings, which are not issued."""
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

    `size` is that of the box around the scene; of files with a suffix of glTF, the unit is given.
    """
    longest = max(size)
    says = "glTF prescribes metres" if suffix in _IN_METRES else "the format does not say"
    if not 0.0 < longest <= LARGEST:
        return {"guess": None, "metres": None, "why": f"the size is unusual; {says}"}
    name, metres = [(name, longest * metre) for least, name, metre in UNITS if longest >= least][-1]
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
    count = Counter(group[0].material.name for group in users.values())
    described = []
    for group in users.values():
        material = group[0].material
        meshes_of = {"meshes": [*dict.fromkeys(mesh.name for mesh in group)]}
        about = {
            "name": material.name,
            "kind": name_kind(material),
            "triangles": sum(len(mesh.faces) for mesh in group),
            **(meshes_of if count[material.name] > 1 else {}),
            **_describe_attributes(material),
        }
        described.append(about)
    return described


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
        size = {"width": width, "height": height, "channels": channels}
        return {"texture": {**size, "bits": bits, "mean": list(color.mean)}}
    if isinstance(color, NormalMap | BumpMap):
        return {"type": color.kind, "factor": color.factor, **describe_color(color.texture)}
    if isinstance(color, AnisotropyMap):
        return describe_color(color.texture)
    if isinstance(color, NoRelief):
        return color.kind
    if isinstance(color, Cauchy | Sellmeier | NamedGlass):
        return {"type": color.kind, **asdict(color)}
    if isinstance(color, Fluorescence):
        peaks = {name: getattr(color, name) for name in ("excitation", "emission")}
        at = {f"{k}_nm": float(v.wavelengths[v.values.argmax()]) for k, v in peaks.items()}
        return {**at, "quantum_efficiency": color.quantum_efficiency}
    if isinstance(color, DonaldsonMatrix):
        axes = {"excitation_nm": color.excitation, "emission_nm": color.emission}
        return {name: axis[[0, -1]].tolist() for name, axis in axes.items()}
    return [describe_color(each) for each in color] if isinstance(color, tuple) else color


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
        about = {
            "name": names[thing - 1],
            "material": compiled.light_names[mine[0]],
            "triangles": len(mine),
            "area": float(compiled.lights.area[mine].sum()) * compiled.size**2,
            "power": power,
            "share": power / total,
        }
        described.append(about)
    return described


def describe_lights(scene: Scene, compiled: CompiledScene) -> list[dict[str, Any]]:
    """Return what the JSON says of lights that are not surfaces, or of the sky in place of none."""
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
    lights = check_lights(scene.lights, areas)
    described = [
        {
            "name": light.name,
            "kind": light.kind,
            "group": light.group or light.name,
            "power": powers.get(light.name, 0.0),
            "share": powers.get(light.name, 0.0) / total,
            **_describe_light(light),
        }
        for light in lights
    ]
    known = {light.name for light in lights}
    for name in (name for name in powers if name not in known):  # the sky
        about = {"name": name, "kind": EnvironmentLight.kind, "group": name}
        described.append({**about, "power": powers[name], "share": 1.0})
    return described


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
        properties["direction"] = unit(np.array(light.direction)).tolist()
    return properties


def describe_camera(camera: Camera) -> dict[str, Any]:
    """Return what the JSON says of a checked camera."""
    return {
        "name": camera.name,
        "kind": camera.model.kind,
        **{name: list(getattr(camera, name)) for name in ("origin", "target", "up")},
        **camera.model.describe(),
        "lens": None if camera.lens is None else camera.lens.describe(),
    }


_NOTHING = "nothing: the picture is the same"
_BAKE = "bake the texture into one that lies like that of the base colour, and repeats"
_SPLIT = "give parts that differ their own material, where the mean is not good enough"
_TOML = "in [material.NAME] of a TOML file"
_POLYGONS, _NEAR = "export what should be seen as polygons", "as near as it gets"
_DEFAULT = "in [material.default] of a TOML file"
_REMEDIES = (
    (r"no light", "add [[light]] to a TOML file, or emission to a material"),
    (r"no texture coordinates", "unwrap the meshes, and export texture coordinates"),
    (r"degenerate|have no area|without area|in no face", _NOTHING),
    (r"in 32 bits", "move the mesh to the origin in the program that made it, and export it again"),
    (r"coincide", "delete one copy of doubled faces, unless any will do"),
    (r"add up to more than 1|lowered to 1", f"lower the reflectance in the file, or {_TOML}"),
    (r"textures?\b.* grey|relief w.* not readable", "put the images where the file looks for them"),
    (r"MTL file", f"put the MTL file beside the OBJ, or give the reflectances {_TOML}"),
    (r"\b(normalTexture|map_[Bb]ump|[Bb]ump|norm|disp)\b", "model the relief, where it matters"),
    (r"(colours|opacity) of (vertices|faces)|attribute bytes", "bake the colours into a texture"),
    (r"animations", "export the pose to be rendered as a plain mesh"),
    (r"points and lines|lines are not simulated|fewer than three corners", _POLYGONS),
    (r"emission from the back", "model the light closed, or with a second face, turned back"),
    (r"absolute name", _NOTHING + ", if it is the right image"),
    (r"variation of|mean of (map_|its image)|map_(Ks|Ns)", _SPLIT),
    (r"KHR_materials_transmission", f"make it all glass: transmission 1, or ior {_TOML}"),
    (r"roughness of thin glass", f"model its two sides, or give it a partial alpha {_TOML}"),
    (r"specularColorFactor", f"give the colour as glossy {_TOML}"),
    (r"EXT_mesh_gpu_instancing", "realize its instances and export again: one copy is rendered"),
    (r"_variants", "nothing, if the default variant is meant"),
    (
        r"KHR_materials_(?!transmission|variants)|EXT_(?!mesh_gpu)",
        f"describe the surface {_TOML}, {_NEAR}",
    ),
    (r"\brange\b", "nothing: light falls off with the square of the distance"),
    (r"wrap mode|coordinates of a further texture", _BAKE),
    (r"mirrored view", "give the camera's node a scale without minus signs"),
    (r"\.ply: .*\btexture of", f"give it as reflectance = {{ file = … }} {_DEFAULT}"),
    (r"candela and lux", "export it anew, with Data → Lighting → Unitless"),
    (r"max_depth|hide_emitters", "nothing: light is followed until it is absorbed, and seen"),
    (r"black backs", "nothing, where the camera and lights are in front of them"),
    (r"innerConeAngle", "lower it in the file: the edge of the spot is hard"),
    (r"newmtl is repeated", "give each material its own name"),
    (r"\b(Ks|Ns|Ni|Tf|illum|halo)\b", f"give mirror, glossy or ior {_TOML}"),
    (r"\bsheen\b", f"give sheen {_TOML}, without coat, ior and mirror"),
    (r"\bsheenRoughnessTexture\b", f"give sheen_roughness {_TOML}: one number stands for it"),
    (r"munsell", "give the measured chips with --munsell, or accept the recovered curve"),
)
"""A pattern in a warning, and what to do."""
_OTHER_FORMAT = r"^(?!.*\.(gltf|glb): ).*\b(property|element|texture)\b"
_EXPORT = "export it as glTF or OBJ with materials, if it matters"
_OTHERWISE = "compare a render with what it should show"


def find_remedy(message: str) -> str:
    """Return what to do about a warning, for each part of it that is known, in their order."""
    matches = [(re.search(pattern, message), remedy) for pattern, remedy in _REMEDIES]
    places = sorted((match.start(), remedy) for match, remedy in matches if match)
    found = [remedy for _, remedy in places]
    if not found and re.search(_OTHER_FORMAT, message):
        return _EXPORT
    return "; ".join(dict.fromkeys(found)) or _OTHERWISE
