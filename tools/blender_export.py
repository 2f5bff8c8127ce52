"""Write a Blender scene as OUT.glb and OUT.toml, which photonmap reads together.

    blender room.blend --background --python tools/blender_export.py -- out/room
    python tools/blender_export.py room.blend out/room        # with Blender as a module, bpy

Meshes and materials go through Blender's own glTF exporter. What that drops follows in the TOML
file: lights with their sizes, the world, cameras and their lenses, and bodies of glass. Everything
that neither holds is named in one warning. Needs the folder `blender_parts` beside this file;
tested with Blender 5.0.
"""

import argparse
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from blender_parts.cameras import add_cameras
from blender_parts.draft import Draft, toml
from blender_parts.lights import add_lights
from blender_parts.materials import prepare_materials
from blender_parts.world import add_world


def export(out: Path, frame: int | None = None) -> str:
    """Write the current scene; return the warning of what is lost, empty if nothing is.

    Parameters
    ----------
    out : the files' name without suffix; `.glb` and `.toml` are appended
    frame : of an animation; None for the current one
    """
    draft = Draft(out.with_name(out.name.removesuffix(".glb").removesuffix(".toml")))
    if frame is not None:
        draft.scene.frame_set(frame)
    bpy.context.view_layer.update()
    draft.out.parent.mkdir(parents=True, exist_ok=True)
    glb, beside = (draft.out.with_name(draft.out.name + suffix) for suffix in (".glb", ".toml"))
    try:
        prepare_materials(draft)
        add_world(draft, add_lights(draft))
        add_cameras(draft)
        _write_gltf(glb)
    finally:
        draft.restore()
    width, height = draft.size
    command = f"# Blender {bpy.app.version_string}; render with --size {width}x{height}"
    head = f"{command}\nmesh = {toml(glb.name)}"
    beside.write_text("\n\n".join([head, *draft.sections]) + "\n", "utf-8")
    return _warning(draft)


def _write_gltf(path: Path) -> None:
    """Run Blender's exporter: surfaces as they are rendered, and nothing else."""
    bpy.ops.export_scene.gltf(
        filepath=str(path),
        export_format="GLB",
        use_renderable=True,
        use_active_scene=True,
        export_apply=True,
        export_gn_mesh=True,
        export_current_frame=True,
        export_cameras=False,
        export_lights=False,
        export_animations=False,
        export_morph=False,
        export_skins=False,
    )


def _warning(draft: Draft) -> str:
    """Return what is lost, counted, with some names."""
    parts = []
    for what, owners in draft.lost.items():
        more = f" and {len(owners) - 3} more" if len(owners) > 3 else ""
        parts.append(f"{what} of {', '.join(owners[:3])}{more}")
    return f"warning: not exported ({len(parts)}): {'; '.join(parts)}" if parts else ""


def main() -> None:
    """Export by the command line, after `--` if Blender itself has arguments."""
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("blend", nargs="?", type=Path, help="scene, unless Blender has opened one")
    parser.add_argument("out", type=Path, help="name of the files to write, without suffix")
    parser.add_argument("--frame", type=int, help="frame of an animation (default: the current)")
    args = parser.parse_args(given)
    if args.blend is not None:
        if not args.blend.is_file():
            parser.error(f"{args.blend} cannot be read (no such file); check the name")
        try:
            bpy.ops.wm.open_mainfile(filepath=str(args.blend.resolve()))
        except RuntimeError as error:
            parser.error(f"{args.blend} cannot be read ({' '.join(str(error).split())})")
    if warning := export(args.out.resolve(), args.frame):
        print(warning, file=sys.stderr)


if __name__ == "__main__":
    main()
