"""A compiled scene as `mitsuba_server` reads it: a JSON file beside the arrays of its meshes.

Meshes go over as triangles with their shading normals, reflectances and radiances as linear RGB;
emitters shine from their front, diffuse surfaces and mirrors are the same on both sides. All is in
the kernels' units of light: `CompiledScene.power` turns radiances into those of the scene.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import photonmap as pm
from photonmap.compile.scene_arrays import CompiledScene, compile_scene
from photonmap.kernels.core.records import GLASS, MIRROR
from photonmap.spectra.bands import Bands

TEXEL = 64
"""Pixels across a texel of a sky, which are constant in photonmap and interpolated in Mitsuba."""
SCALE = 100.0
"""Mitsuba's units of length in one of the kernels': its rays start (1 + the largest coordinate) ×
9e-5 off a surface, which in a scene of size 1 is 0.7 mm of a room of 6 m, and light leaks."""

Node = dict[str, Any]


def export_scene(scene: pm.Scene, size: tuple[int, int], folder: Path) -> tuple[Path, float]:
    """Write a scene into a folder.

    Returns
    -------
    the JSON file, and the factor that turns the radiances of its images into those of the scene

    Raises
    ------
    ValueError : the scene has what is not exported: textures, rough surfaces, or lights and cameras
        other than points, suns, skies and pinholes
    """
    compiled = compile_scene(scene, Bands.parse("rgb"), size[0] / size[1])
    geometry = compiled.geometry
    if (compiled.textures, compiled.scattering, geometry.alpha, geometry.relief) != (None,) * 4:
        raise ValueError(f"{scene.name}: only plain diffuse and specular surfaces are exported")
    tree: Node = {"type": "scene", "sensor": _sensor(compiled, size)}
    tree |= _meshes(compiled, folder) | _lights(scene, compiled, folder)
    file = folder / "scene.json"
    file.write_text(json.dumps(tree))
    return file, compiled.power


def _rgb(values: NDArray[Any]) -> Node:
    return {"type": "rgb", "value": [float(value) for value in values]}


def _sensor(compiled: CompiledScene, size: tuple[int, int]) -> Node:
    camera = compiled.camera
    if camera.height is not None or camera.projection is not None or camera.lens is not None:
        raise ValueError("only pinhole cameras are exported")
    origin, target = (
        (SCALE * (np.array(point) - compiled.center) / compiled.size).tolist()
        for point in (camera.origin, camera.target)
    )
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}}
    return {
        "type": "perspective",
        "fov": camera.fov,
        "fov_axis": "y",
        "near_clip": 1e-4 * SCALE,
        "far_clip": 1e4 * SCALE,
        "to_world": {"look_at": [origin, target, list(camera.up)]},
        "film": film,
        "sampler": {"type": "independent"},
    }


def _meshes(compiled: CompiledScene, folder: Path) -> Node:
    """Return shapes: triangles of one material, one emission, and with normals or without."""
    geometry, lights = compiled.geometry, compiled.lights
    emission = np.where(geometry.emitter < 0, -1, lights.spectrum[geometry.emitter])
    normals = geometry.shading_normals
    smooth = np.zeros(len(emission), bool)
    if len(normals):
        smooth = (normals[geometry.triangles] != 0.0).any(axis=2).all(axis=1)
    keys = np.stack([geometry.material, emission, smooth], axis=1)
    shapes = {}
    for number, (material, row, is_smooth) in enumerate(np.unique(keys, axis=0)):
        faces = geometry.triangles[(keys == (material, row, is_smooth)).all(axis=1)]
        used, faces = np.unique(faces, return_inverse=True)
        place = folder / f"mesh{number}.ply"
        _write_ply(
            place,
            geometry.vertices[used] * np.float32(SCALE),
            normals[used] if is_smooth else None,
            faces.reshape(-1, 3),
        )
        shape = {"type": "ply", "filename": str(place), "face_normals": not is_smooth}
        shape["bsdf"] = _bsdf(compiled, int(material))
        if row >= 0:
            shape["emitter"] = {"type": "area", "radiance": _rgb(lights.spectra[row])}
        shapes[f"mesh{number}"] = shape
    return shapes


def _bsdf(compiled: CompiledScene, material: int) -> Node:
    specular = compiled.specular
    kind = 0 if specular is None else specular.kind[material]
    if specular is None or kind == 0:
        color = _rgb(compiled.materials.reflectance[material])
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": color}}
    if specular.alpha.any() or specular.probability[material] < 1.0:
        raise ValueError("rough metal and glass, and coats, are not exported")
    if kind == MIRROR:
        mirror = {"type": "conductor", "material": "none"}
        return {
            "type": "twosided",
            "bsdf": {**mirror, "specular_reflectance": _rgb(specular.mirror[material])},
        }
    if kind == GLASS and (specular.tint[material] == 1.0).all():
        return {"type": "dielectric", "int_ior": float(specular.ior[material]), "ext_ior": 1.0}
    raise ValueError("metal and tinted glass are not exported")


def _lights(scene: pm.Scene, compiled: CompiledScene, folder: Path) -> Node:
    """Return the lights that are not surfaces."""
    lights = compiled.lights
    others = np.flatnonzero(lights.triangle < 0)
    nodes: Node = {}
    for light, row in zip(scene.lights, others, strict=True):
        color = _rgb(lights.spectra[lights.spectrum[row]])
        nodes[f"light{row}"] = {
            pm.PointLight: lambda row=row, color=color: {
                "type": "point",
                "position": (SCALE * lights.position[row]).tolist(),
                "intensity": _rgb(SCALE**2 * lights.spectra[lights.spectrum[row]]),
            },
            pm.DirectionalLight: lambda row=row, color=color: {
                "type": "directional",
                "direction": lights.axis[row].tolist(),
                "irradiance": color,
            },
            pm.DomeLight: lambda color=color: {"type": "constant", "radiance": color},
            pm.EnvironmentLight: lambda light=light: _sky(light, compiled.power, folder),
        }[type(light)]()
    return nodes


def _sky(light: pm.EnvironmentLight, power: float, folder: Path) -> Node:
    """Return an environment map, enlarged and rotated as Mitsuba needs it."""
    if light.rotation != 0.0:
        raise ValueError("only skies without rotation are exported")
    texels = np.asarray(light.image, np.float32) * np.float32(light.scale / power)
    texels = np.roll(texels, texels.shape[1] // 2, axis=1)
    place = folder / "sky.npy"
    np.save(place, texels.repeat(TEXEL, axis=0).repeat(TEXEL, axis=1))
    return {"type": "envmap", "bitmap": {"array": str(place)}}


def _write_ply(
    place: Path,
    vertices: NDArray[np.float32],
    normals: NDArray[np.float32] | None,
    faces: NDArray[np.integer],
) -> None:
    """Write a binary PLY file."""
    columns = ["x", "y", "z"] + ([] if normals is None else ["nx", "ny", "nz"])
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    head += [f"property float {column}" for column in columns]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    rows = vertices if normals is None else np.concatenate([vertices, normals], axis=1)
    corners = np.empty(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
    corners["count"], corners["corners"] = 3, faces
    place.write_bytes(
        "\n".join([*head, ""]).encode() + rows.astype("<f4").tobytes() + corners.tobytes()
    )
