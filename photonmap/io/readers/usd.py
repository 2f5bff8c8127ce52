"""Read USD stages: text, binary and packages. Needs pxr, `pip install 'photonmap[usd]'`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Losses, decode_file, note_loss
from photonmap.io.readers.registry import ReadOptions
from photonmap.scene.camera import Camera
from photonmap.scene.lights import Light
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene

SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")

_SILENT = (
    "", "Xform", "Scope", "Material", "Shader", "GeomSubset", "NodeGraph", "Skeleton", "SkelRoot",
)  # fmt: skip
"""Types of prims that show nothing by themselves."""


def read(path: Path, options: ReadOptions) -> Scene:
    """Read the meshes, preview surfaces, lights and cameras of a stage, as it begins.

    Units of length are those of the stage; y is up.
    """
    if find_spec("pxr") is None:
        raise InputError("needs usd-core: pip install 'photonmap[usd]'", path)
    return decode_file(path, partial(_decode, options))


def _decode(options: ReadOptions, path: Path, data: bytes, losses: Losses) -> Scene:
    from pxr import Usd, UsdGeom, UsdUtils

    from photonmap.io.readers.usd_prims import SHAPES, read_camera, read_light, read_meshes
    from photonmap.io.readers.usd_stage import Materials, Stage, is_light, is_shown, open_stage

    quiet = UsdUtils.CoalescingDiagnosticDelegate()  # what pxr would print
    stage = Stage(path, open_stage(path), options, losses)
    materials = Materials(stage)
    cameras, meshes, lights = list[Camera](), list[Mesh](), list[Light]()
    for prim in Usd.PrimRange.Stage(stage.stage, Usd.TraverseInstanceProxies()):
        kind = prim.GetTypeName()
        with _naming_file(path, prim.GetName()):
            if prim.IsA(UsdGeom.Camera):
                cameras.append(read_camera(stage, prim))
            elif kind in SHAPES and is_shown(prim):
                meshes += read_meshes(stage, materials, prim)
            elif is_light(prim) and is_shown(prim):
                found = read_light(stage, prim)
                meshes += [found] if isinstance(found, Mesh) else []
                lights += [found] if isinstance(found, Light) else []
            elif kind not in (*_SILENT, *SHAPES) and not is_light(prim):
                note_loss(losses, kind, prim.GetName())
    quiet.TakeUncoalescedDiagnostics()
    return Scene(meshes, name=path.stem, cameras=cameras, lights=lights)


@contextmanager
def _naming_file(path: Path, owner: str) -> Iterator[None]:
    """Put file and prim before errors that do not name the file."""
    try:
        yield
    except InputError as error:
        if str(path) in str(error):
            raise
        raise InputError(f"{owner}: {error}", path) from None
