"""All that there is to say about a scene file, as plain values for JSON."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from photonmap.compile.effects import plan_effects
from photonmap.compile.scene_arrays import compile_arrays
from photonmap.compile.spectral_columns import count_distinct
from photonmap.errors import SceneWarning, listening
from photonmap.inspection.lights import describe_area_lights, describe_camera, describe_lights
from photonmap.inspection.remedies import find_remedy
from photonmap.inspection.surfaces import describe_materials, describe_mesh
from photonmap.io.readers.scene_file import scene_files
from photonmap.io.scene_source import SceneSource
from photonmap.scene.camera import check_camera
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene
from photonmap.spectra.bands import Bands

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

    Raises
    ------
    InputError : the scene cannot be read or rendered
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
    """Return what is in a scene, which was read from a file of a suffix.

    Raises
    ------
    InputError : the scene cannot be rendered
    """
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
