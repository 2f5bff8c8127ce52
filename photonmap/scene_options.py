"""Options of every command that loads a scene: its camera, measured spectra, missing textures."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING

from photonmap.arguments import vector
from photonmap.errors import InputError

if TYPE_CHECKING:
    from photonmap.scene import Camera, Scene


def add_scene_options(parser: argparse.ArgumentParser) -> None:
    """Add SCENE and the options that say how to read it."""
    parser.add_argument("scene", metavar="SCENE", help="OBJ file, SCENE.toml beside it; or TOML")
    add_measured_sets(parser.add_argument_group("spectra"))
    camera = parser.add_argument_group("camera", "in place of the one in SCENE.toml")
    for name in ("origin", "target", "up"):
        camera.add_argument(f"--{name}", type=vector, metavar="x,y,z", help="scene units")
    camera.add_argument("--fov", type=float, metavar="DEG", help="full vertical angle (default 40)")
    parser.add_argument(
        "--missing-textures",
        choices=("error", "grey"),
        default="error",
        help="what becomes of an MTL file's textures that cannot be read (default: error)",
    )


def add_measured_sets(group: argparse._ArgumentGroup) -> None:
    """Add the options that name sets of measured spectra."""
    group.add_argument(
        "--munsell", metavar="PATH", help="measured chips for munsell: (or $PHOTONMAP_MUNSELL)"
    )
    group.add_argument(
        "--illuminants", metavar="PATH", help="measured lights for sfu: (or $PHOTONMAP_ILLUMINANTS)"
    )


def load_chosen_scene(options: argparse.Namespace) -> Scene:
    """Load the scene with the sets and the camera that the options name.

    Raises
    ------
    InputError
        as `load_scene`; or if a set cannot be read, or a camera is incomplete
    """
    from photonmap.readers.scene_file import load_scene

    scene = load_scene(options.scene, options.missing_textures)
    scene.camera = _camera(options, scene)
    return scene


def name_measured_sets(options: argparse.Namespace) -> None:
    """Let the names of colours find the sets that the options name.

    Raises
    ------
    InputError
        if one cannot be read
    """
    from photonmap.spectra import munsell, text

    if options.munsell:
        os.environ[munsell.VARIABLE] = options.munsell
        munsell.measured_set()
    if options.illuminants:
        os.environ[text.ILLUMINANTS] = options.illuminants
        text.measured_illuminants()


def _camera(options: argparse.Namespace, scene: Scene) -> Camera | None:
    """Return the scene's camera with the options' values in place of its own."""
    from photonmap.scene import Camera

    given = {
        name: getattr(options, name)
        for name in ("origin", "target", "up", "fov")
        if getattr(options, name) is not None
    }
    if not given:
        return scene.camera
    known = vars(scene.camera) if scene.camera else {}
    if missing := {"origin", "target"} - {*given, *known}:
        raise InputError(f"a camera needs --{' and --'.join(sorted(missing))} too")
    return Camera(**{**known, **given})
