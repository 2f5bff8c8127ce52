"""The command `python -m photonmap inspect`: a page to look at the buffers of a render."""

from __future__ import annotations

import argparse
from pathlib import Path

from photonmap.commands import shared
from photonmap.runtime.options import read_list

HELP = "Write an HTML page that shows a render's buffers and the spectra of its pixels."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="FILE.exr", help="a render")
    text = "a second render, to show the difference"
    parser.add_argument("other", nargs="?", metavar="OTHER.exr", help=text)
    text = "where to write the page"
    more = {"default_text": "FILE.html", "short": "o", "read": shared.file_name}
    shared.add_value(parser, "output", "FILE.html", text, **more)
    text = "show only these buffers; their names, separated by commas"
    usual = "all but masks, counts and covariance"
    shared.add_value(parser, "buffers", "LIST", text, read=read_list, default_text=usual)
    shared.add_quiet(parser)


def run(options: argparse.Namespace) -> None:
    """Write the page."""
    from photonmap.errors import InputError
    from photonmap.runtime.writing import check_file
    from photonmap.viewer.page import load_for_page, write_page

    page = Path(options.output or Path(options.file).with_suffix(".html"))
    if page.suffix.lower() != ".html":
        raise InputError("the name of the page must end in .html, as in box.html", page)
    check_file(page)
    files = [file for file in (options.file, options.other) if file is not None]
    results = [load_for_page(file, options.buffers) for file in files]
    write_page(results, [Path(file).name for file in files], page, options.buffers)
    size = page.stat().st_size / 1e6
    shared.say(options, f"the page: {page} ({size:.1f} MB); open it in a browser")
