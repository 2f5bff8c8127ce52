"""The options of the command `python -m photonmap dataset`."""

from __future__ import annotations

import argparse
from typing import Any

from photonmap.commands.arguments import number
from photonmap.commands.options import (
    add_measured_sets,
    add_options,
    add_quiet,
    add_scheduler,
    add_value,
)
from photonmap.dataset.files.chosen_buffers import ALWAYS
from photonmap.film.budget import DEFAULT_ERROR
from photonmap.runtime.options import read_list, read_memory
from photonmap.settings import DATASET, OPTIONS, taken_by
from photonmap.spectra.projection import REC2020, SPACES

USUAL: dict[str, Any] = {
    **{name: OPTIONS[name].default for name in taken_by(DATASET)},
    "size": (640, 480),
    "error": f"{DEFAULT_ERROR}",
    "preset": "small",
    "count": 1,
    "seed": 0,
    "illuminations": [],
    "materials": None,
    "lightness": None,
    "scale": None,
    "format": ["exr", "png"],
    "full": False,
    "buffers": None,
    "rgb": REC2020,
}
"""What options are where neither they nor a data set that is resumed say: None as not given."""


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
    usual = {"size": "640x480"} | {name: str(USUAL[name]) for name in ("bands", "pixel", "error")}
    changes = {name: {"default": None, "default_text": text} for name, text in usual.items()}
    add_options(parser, DATASET, **changes)
    _add_files(parser)
    _add_work(parser)
    check = parser.add_argument_group("verify")
    text = "number of images to render again and compare"
    add_value(check, "sample", "N", text, read=int, default=1)
    text = "where scene files are that are not where the set was made; also for flow"
    add_value(check, "scenes", "DIR", text)
    publish = parser.add_argument_group("publish")
    text = "one of CC0-1.0, CC-BY-4.0, CC-BY-SA-4.0, CC-BY-NC-4.0, or a file with another"
    add_value(publish, "license", "NAME", text)
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
    text = "bytes of a file, as in 512M or 1G"
    add_value(export, "shard_size", "SIZE", text, read=read_memory, default_text="512M")
    add_value(
        export,
        "arrays",
        "LIST",
        "names of arrays, as in rgb.radiance,rgb.shading,shading,depth; rgb.NAME is in the set's "
        "RGB",
        read=read_list,
        default_text="light, reflectance and shading in RGB, depth, normals, ids, masks",
    )


def _add_images(parser: argparse.ArgumentParser) -> None:
    """Add the options that decide which scenes are rendered."""
    what = parser.add_argument_group("scenes")
    text = "small, icip2013, varied, or FILE.toml"
    add_value(what, "preset", "NAME", text, default_text="small")
    text = "number of seeds for which each scene is built"
    add_value(what, "count", "N", text, read=int, default_text="1")
    add_value(what, "seed", "N", "first of the seeds", read=int, default_text="0")
    _add_looks(what)
    add_measured_sets(what)


def _add_looks(what: argparse._ArgumentGroup) -> None:
    """Add the options that decide how procedural scenes look, and what lights them."""
    what.add_argument(
        "--materials",
        choices=("lambertian", "mixed", "textured", "glossy", "rich"),
        help="materials of procedural scenes (default: the preset's, or lambertian)",
    )
    text, usual = "mean reflectance of procedural scenes", "the preset's, or as chips are drawn"
    add_value(what, "lightness", "R", text, read=float, default_text=usual)
    text = "factor of the size of rooms, 0.8 to 3"
    add_value(what, "scale", "F", text, read=float, default_text="the preset's, or 1")
    add_value(
        what,
        "illuminations",
        "LIST",
        "names separated by commas, such as white,random_3",
        read=read_list,
        default_text="the preset's, or white,colored,two_planckian,two_mixed",
    )


def _add_files(parser: argparse.ArgumentParser) -> None:
    """Add the options that decide what is written of each image."""
    files = parser.add_argument_group("files")
    add_value(
        files,
        "format",
        "LIST",
        "file formats, of exr, hdf5 and png, separated by commas",
        read=read_list,
        default_text="exr,png",
    )
    files.add_argument(
        "--full",
        action="store_true",
        default=None,
        help="write everything in single precision, 3 to 7 times as large, not as lean files",
    )
    add_value(
        files,
        "buffers",
        "LIST",
        "names of the buffers that files hold, with their errors and those of light groups, "
        f"separated by commas; {', '.join(ALWAYS)} always belong to them",
        read=read_list,
        default_text="all",
    )
    add_value(
        files,
        "rgb",
        "SPACE",
        f"space of the images in RGB: {', '.join(SPACES)}, a camera, or FILE.csv of three "
        "sensitivities",
        default_text=REC2020,
    )
    add_value(
        files,
        "sensor",
        "NAME",
        "also write what this camera would have recorded: its name, or a FILE.toml that "
        "`photonmap sensor` takes",
    )


def _add_work(parser: argparse.ArgumentParser) -> None:
    """Add the options that decide how and where images are rendered."""
    work = parser.add_argument_group("work")
    add_value(
        work,
        "time_limit",
        "S",
        "seconds of rendering after which an image stops short of its error, and is marked",
        read=number(0.001, 1e9, " s"),
        default_text="1 hour",
    )
    add_scheduler(work, may_be_auto=True)
    for flag, text in (
        (
            "--resume",
            "render only the images that are missing or damaged, with the set's own options",
        ),
        ("--dry-run", "list the images without rendering them"),
        (
            "--estimate",
            "say what the images will cost, by scene, from small pilots, and render nothing else",
        ),
    ):
        work.add_argument(flag, action="store_true", help=text)
