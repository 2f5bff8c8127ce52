"""Read USD stages: text, binary and packages. Needs pxr, `pip install 'photonmap[usd]'`."""

from __future__ import annotations

from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from photonmap.errors import InputError
from photonmap.io.readers import decoding
from photonmap.io.readers.registry import ReadOptions
from photonmap.io.readers.usd.lights import is_light, note_clipped, read_camera, read_light
from photonmap.io.readers.usd.meshes import SHAPES, Geometry, is_known
from photonmap.io.readers.usd.stage import Stage, check_layers, open_stage
from photonmap.scene.camera import Camera
from photonmap.scene.lights import Light
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene

if find_spec("pxr") is not None:
    from pxr import Usd, UsdGeom, UsdUtils

SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")


def read(path: Path, options: ReadOptions) -> Scene:
    """Read the meshes, preview surfaces, lights and cameras of a stage, as it begins.

    Units of length are those of the stage; y is up.
    """
    if find_spec("pxr") is None:
        raise InputError("needs usd-core: pip install 'photonmap[usd]'", path)
    return decoding.decode_file(path, partial(_decode, options))


def _decode(options: ReadOptions, path: Path, data: bytes, losses: decoding.Losses) -> Scene:
    quiet = UsdUtils.CoalescingDiagnosticDelegate()  # what pxr would print
    stage = Stage(path, *open_stage(path, losses), options, losses)
    try:
        return _read(stage)
    finally:
        stage.stage = None  # which has USD close its files
        quiet.TakeUncoalescedDiagnostics()


def _read(stage: Stage) -> Scene:
    path = stage.path
    for error in stage.stage.GetCompositionErrors():
        if "Could not open asset" not in str(error):  # which are named by their files
            decoding.note_loss(stage.losses, "what USD cannot compose", error.rootSite.path.name)
    geometry, cameras, lights = Geometry(stage), dict[Any, Camera](), list[Light]()
    prims = iter(Usd.PrimRange.Stage(stage.stage, Usd.TraverseInstanceProxies()))
    for prim in prims:
        is_instancer = prim.IsA(UsdGeom.PointInstancer)
        if is_instancer:
            prims.PruneChildren()  # prototypes
        stage.note_motion(prim)
        try:
            if prim.IsA(UsdGeom.Camera):
                cameras[prim] = read_camera(stage, prim)
            elif is_instancer or prim.GetTypeName() in SHAPES:
                if is_shown(stage, prim):
                    geometry.add(prim)
            elif is_light(prim) and is_shown(stage, prim):
                found = read_light(stage, prim)
                geometry.items += [found] if isinstance(found, Mesh) else []
                lights += [found] if isinstance(found, Light) else []
            elif not is_known(prim) and not is_light(prim):
                stage.lose(prim.GetTypeName(), prim)
        except InputError as error:
            if str(path) in str(error):
                raise
            raise InputError(f"{prim.GetName()}: {error}", path) from None
    surfaces = list(geometry.build())
    for prim in cameras:
        note_clipped(stage, prim, (mesh.vertices for mesh in surfaces))
    check_layers(path, stage.stage)
    return Scene(surfaces, name=path.stem, cameras=list(cameras.values()), lights=lights)


def is_shown(stage: Stage, prim: Any) -> bool:
    """Return whether a prim is visible when rendered."""
    item = UsdGeom.Imageable(prim)
    if not item or item.ComputeVisibility(stage.time) == UsdGeom.Tokens.invisible:
        return False
    return item.ComputePurpose() in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
