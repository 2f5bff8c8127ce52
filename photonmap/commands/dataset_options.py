"""The options of the command `python -m photonmap dataset`."""

from __future__ import annotations

import argparse

from photonmap.commands.arguments import number, reader
from photonmap.commands.options import add_measured_sets, add_options, add_quiet, add_scheduler
from photonmap.dataset.files.chosen_buffers import ALWAYS
from photonmap.film.budget import DEFAULT_ERROR
from photonmap.runtime.options import read_list, read_memory
from photonmap.settings import DATASET
from photonmap.spectra.rgb_spaces import REC2020, SPACES


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.usage = (
        f"{parser.prog} FOLDER [options]\n"
        f"       {parser.prog} verify FOLDER [--sample N] [--scenes DIR]\n"
        f"       {parser.prog} flow FOLDER\n       {parser.prog} publish FOLDER --license NAME\n"
        f"       {parser.prog} export FOLDER NEW --layout LAYOUT --license NAME"
    )
    parser.add_argument(
        "words",
        nargs="+",
        metavar="FOLDER",
        help="folder of the data set; created where it is missing",
    )
    _add_images(parser)
    error = f"{DEFAULT_ERROR}"
    add_options(parser, DATASET, size={"default": (640, 480)}, error={"default": error})
    _add_files(parser)
    _add_work(parser)
    check = parser.add_argument_group("verify")
    check.add_argument(
        "--sample",
        type=reader(int),
        default=1,
        metavar="N",
        help="number of images to render again and compare (default: 1)",
    )
    check.add_argument(
        "--scenes",
        metavar="DIR",
        help="where scene files are that are not where the set was made; also for flow",
    )
    add = parser.add_argument_group("publish")
    add.add_argument(
        "--license",
        metavar="NAME",
        help="one of CC0-1.0, CC-BY-4.0, CC-BY-SA-4.0, CC-BY-NC-4.0, or a file with another",
    )
    _add_export(parser)
    add_quiet(parser)


def _add_export(parser: argparse.ArgumentParser) -> None:
    export = parser.add_argument_group("export")
    export.add_argument(
        "--layout",
        choices=("webdataset", "huggingface"),
        default="webdataset",
        help="tar files with an index, or Parquet tables (default: webdataset)",
    )
    export.add_argument(
        "--shard-size",
        type=reader(read_memory),
        metavar="SIZE",
        help="bytes of a file, as in 512M or 1G (default: 512M)",
    )
    export.add_argument(
        "--arrays",
        type=read_list,
        metavar="LIST",
        help="names of arrays, as in rgb.radiance,rgb.shading,shading,depth; rgb.NAME is in the "
        "set's RGB (default: light, reflectance and shading in RGB, depth, normals, ids, masks)",
    )


def _add_images(parser: argparse.ArgumentParser) -> None:
    """Add the options that decide which scenes are rendered."""
    what = parser.add_argument_group("scenes")
    what.add_argument(
        "--preset",
        default="small",
        metavar="NAME",
        help="small, icip2013, varied, or FILE.toml (default: small)",
    )
    what.add_argument(
        "--count",
        type=reader(int),
        default=1,
        metavar="N",
        help="number of seeds for which each scene is built (default: 1)",
    )
    what.add_argument(
        "--seed", type=reader(int), default=0, metavar="N", help="first of the seeds (default: 0)"
    )
    _add_looks(what)
    add_measured_sets(what)


def _add_looks(what: argparse._ArgumentGroup) -> None:
    """Add the options that decide how procedural scenes look, and what lights them."""
    what.add_argument(
        "--materials",
        choices=("lambertian", "mixed", "textured", "glossy", "rich"),
        help="materials of procedural scenes (default: the preset's, or lambertian)",
    )
    what.add_argument(
        "--lightness",
        type=reader(float),
        metavar="R",
        help="mean reflectance of procedural scenes (default: the preset's, or as chips are drawn)",
    )
    what.add_argument(
        "--scale",
        type=reader(float),
        metavar="F",
        help="factor of the size of rooms, 0.8 to 3 (default: the preset's, or 1)",
    )
    what.add_argument(
        "--illuminations",
        type=read_list,
        default=[],
        metavar="LIST",
        help="names separated by commas, such as white,random_3 (default: the preset's, or white,"
        "colored,two_planckian,two_mixed)",
    )


def _add_files(parser: argparse.ArgumentParser) -> None:
    """Add the options that decide what is written of each image."""
    files = parser.add_argument_group("files")
    files.add_argument(
        "--format",
        type=read_list,
        default=["exr", "png"],
        metavar="LIST",
        help="file formats, of exr, hdf5 and png, separated by commas (default: exr,png)",
    )
    files.add_argument(
        "--full",
        action="store_true",
        help="write everything in single precision, ten times as large, instead of lean files",
    )
    files.add_argument(
        "--buffers",
        type=read_list,
        metavar="LIST",
        help="names of the buffers that files hold, with their errors and those of light groups, "
        f"separated by commas; {', '.join(ALWAYS)} always belong to them (default: all)",
    )
    files.add_argument(
        "--rgb",
        default=REC2020,
        metavar="SPACE",
        help=f"space of the images in RGB: {', '.join(SPACES)}, a camera, or FILE.csv of three "
        f"sensitivities (default: {REC2020})",
    )
    files.add_argument(
        "--sensor",
        metavar="NAME",
        help="also write what this camera would have recorded: its name, or a FILE.toml that "
        "`photonmap sensor` takes",
    )


def _add_work(parser: argparse.ArgumentParser) -> None:
    """Add the options that decide how and where images are rendered."""
    work = parser.add_argument_group("work")
    work.add_argument(
        "--time-limit",
        type=number(0.001, 1e9, " s"),
        metavar="S",
        help="seconds of rendering after which an image stops short of its error, and is marked "
        "(default: 1 hour)",
    )
    add_scheduler(work, may_be_auto=True)
    work.add_argument(
        "--resume", action="store_true", help="render only the images that are missing or damaged"
    )
    _add_previews(work)


def _add_previews(work: argparse._ArgumentGroup) -> None:
    work.add_argument(
        "--dry-run", action="store_true", help="list the images without rendering them"
    )
    work.add_argument(
        "--estimate",
        action="store_true",
        help="say what the images will cost, by scene, from small pilots, and render nothing else",
    )
