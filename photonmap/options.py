"""The options of a render on the command line."""

from __future__ import annotations

import argparse

from photonmap.arguments import amount, limits, size
from photonmap.budget import CEILING, DEFAULT_ERROR
from photonmap.scene_options import add_scene_options


def add_render_options(parser: argparse.ArgumentParser) -> None:
    """Add all arguments of a render."""
    add_scene_options(parser)
    parser.add_argument("--version", action="version", version=_version())
    parser.add_argument("--quiet", action="store_true", help="print errors and warnings alone")
    _add_image(parser)
    _add_budget(parser)
    _add_work(parser)
    _add_files(parser)


def _add_image(parser: argparse.ArgumentParser) -> None:
    image = parser.add_argument_group("image")
    image.add_argument(
        "--bands",
        default="6",
        metavar="BANDS",
        help="N Gaussian bands (default 6), box:N, FILE.csv of sensitivities, the name of a camera "
        "or observer; or rgb: the scene's R, G, B as they stand",
    )
    image.add_argument(
        "--range", type=limits, metavar="LOW:HIGH", help="of the bands, nm (default 400:700)"
    )
    image.add_argument("--size", type=size, default=(512, 512), metavar="WxH", help="512x512")
    image.add_argument(
        "--pixel",
        choices=("box", "center"),
        default="box",
        help="samples cover the pixel (default), or all pass through its centre",
    )


def _add_budget(parser: argparse.ArgumentParser) -> None:
    budget = parser.add_argument_group("budget", f"one of these; --error {DEFAULT_ERROR} if none")
    budget.add_argument("--passes", type=int, metavar="N")
    budget.add_argument("--seconds", type=float, metavar="S", help="of rendering")
    budget.add_argument(
        "--error",
        metavar="E",
        help="relative standard error of radiance, as 0.02; of another buffer, as indirect:0.02; "
        "or a percentile over pixels and bands, as indirect:p95:0.02; gives up after "
        f"{CEILING / 3600:g} hour",
    )


def _add_work(parser: argparse.ArgumentParser) -> None:
    work = parser.add_argument_group("work")
    work.add_argument(
        "--photons", type=int, metavar="N", help="emitted in each pass (default: one a pixel)"
    )
    work.add_argument("--seed", type=int, default=0, metavar="N", help="default 0")
    work.add_argument("--threads", type=int, metavar="N", help="default: every processor")
    work.add_argument(
        "--memory",
        type=amount,
        metavar="SIZE",
        help="as 4G, of RAM: where more is needed, the large arrays lie in scratch files in the "
        "folder for temporary files (TMPDIR)",
    )
    work.add_argument(
        "--method",
        choices=("photon", "path"),
        default="photon",
        help="photon mapping, or the plain path tracer that checks it",
    )
    work.add_argument(
        "--effects",
        default="auto",
        metavar="LIST",
        help="auto: what the scene calls for (default); all; or names, separated by commas",
    )
    work.add_argument(
        "--per-light",
        action="store_true",
        help="split direct, indirect, caustics and shading by groups of lights",
    )
    work.add_argument(
        "--no-adaptive",
        dest="adaptive",
        action="store_false",
        help="sample evenly to the end, not where the first passes were noisy",
    )


def _add_files(parser: argparse.ArgumentParser) -> None:
    files = parser.add_argument_group("files")
    files.add_argument("--output", metavar="FILE.exr", help="default: SCENE's name, here")
    files.add_argument(
        "--buffers",
        type=lambda text: text.split(","),
        metavar="LIST",
        help="write these alone, separated by commas (default: all)",
    )
    files.add_argument(
        "--checkpoint",
        nargs="?",
        const="",
        metavar="FILE",
        help="save the state every minute and in the end (default: the output's name.checkpoint)",
    )
    files.add_argument(
        "--resume",
        action="store_true",
        help="go on from the checkpoint, and save to it, as if there had been no break",
    )


def _version() -> str:
    from photonmap import __version__

    return f"photonmap {__version__}"
