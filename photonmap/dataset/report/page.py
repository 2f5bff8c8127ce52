"""The report of a data set: statistics of images, an HTML page, and a contact sheet as PNG."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.files.image_files import PREVIEWED
from photonmap.errors import InputError
from photonmap.io.png import write_png
from photonmap.report.pages import has_jinja, render_page
from photonmap.results.result import Result
from photonmap.runtime.writing import written_together

PAGE, SHEET = "report.html", "contact_sheet.png"
BINS = 20
"""Number of bins of every histogram."""
_WIDTH = 160  # width of a picture on the contact sheet, pixels
_GAP = 6  # space between pictures, pixels

Entry = dict[str, Any]
Bytes = NDArray[np.uint8]


def write_report(
    folder: Path, entries: Sequence[Entry], left_out: Sequence[str] = ()
) -> list[Path]:
    """Write the page and, where images have a PNG, the contact sheet; return their paths."""
    shown = [entry for entry in entries if f"{PREVIEWED[0]}.png" in entry["files"]]
    with written_together(folder) as part:
        if has_jinja():
            (part / PAGE).write_text(write_page(entries, left_out), encoding="utf-8")
        if shown:
            write_png(draw_sheet(folder, shown), part / SHEET)
        written = sorted(file.name for file in part.iterdir())
    return [folder / name for name in written]


def write_page(entries: Sequence[Entry], left_out: Sequence[str] = ()) -> str:
    """Return the page as HTML; its pictures are the files of the images."""
    columns, stages = columns_of(entries), ("build", "compile", "render", "write")
    seconds = {stage: sum(entry["seconds"][stage] for entry in entries) for stage in stages}
    return render_page(
        __package__,
        "dataset.html",
        count=len(entries),
        columns=list(dict.fromkeys(columns.values())),
        rows=[_row(scene, of, columns) for scene, of in by_scene(entries).items()],
        buffers=PREVIEWED,
        mean=mean_share(entries),
        histograms=_histograms(entries),
        seconds=seconds,
        left_out=left_out,
    )


def by_scene(entries: Iterable[Entry]) -> dict[str, list[Entry]]:
    """Return the entries of each scene, in order of appearance."""
    scenes: dict[str, list[Entry]] = {}
    for entry in entries:
        scenes.setdefault(entry["geometry"], []).append(entry)
    return scenes


def columns_of(entries: Sequence[Entry]) -> dict[str, str]:
    """Return the titles of the images' columns by the names of images, in order of appearance.

    A title is an illumination, the view if it is named, and the seed where a scene has several
    images under these.
    """
    titles = {}
    for entry in entries:
        lit, view = entry["job"]["illumination"], entry["job"]["view"]["name"]
        titles[entry["name"]] = f"{lit}, {view}" if view else lit
    counts = Counter((entry["geometry"], titles[entry["name"]]) for entry in entries)
    several = {title for (_, title), count in counts.items() if count > 1}
    for entry in entries:
        if titles[entry["name"]] in several:
            titles[entry["name"]] += f", seed {entry['job']['seed']}"
    return titles


def mean_share(entries: Iterable[Entry]) -> float | None:
    """Return the mean direct share over images, see `summarise`; None without light."""
    shares = [entry["statistics"]["direct_share"] for entry in entries]
    known = [share for share in shares if share is not None]
    return sum(known) / len(known) if known else None


def _row(scene: str, entries: Sequence[Entry], columns: Mapping[str, str]) -> dict[str, Any]:
    """Return the table row of a scene: a cell for each column, None where there is no image."""
    cells: dict[str, dict[str, Any] | None] = dict.fromkeys(columns.values())
    for entry in entries:
        cells[columns[entry["name"]]] = {
            "name": entry["name"],
            "lights": " + ".join(entry["job"]["colors"]),
            "share": entry["statistics"]["direct_share"],
            "error": entry["error"],
            "pictures": f"{PREVIEWED[0]}.png" in entry["files"],
        }
    return {"scene": scene, "share": mean_share(entries), "cells": list(cells.values())}


def _histograms(entries: Sequence[Entry]) -> list[dict[str, Any]]:
    """Return the summed histograms of all images, with heights in percent of the highest bin."""
    titles = {
        "reflectance": "Reflectance, all bands",
        "illuminant_red": "Illuminant: red of R + G + B",
        "illuminant_blue": "Illuminant: blue of R + G + B",
    }
    made = []
    for name, title in titles.items():
        counts = np.sum([entry["statistics"][name] for entry in entries], axis=0)
        heights = 100.0 * counts / max(int(np.max(counts)), 1)
        parts = 100.0 * counts / max(int(np.sum(counts)), 1)
        bars = [
            {"height": float(height), "part": float(part), "low": i / BINS, "high": (i + 1) / BINS}
            for i, (height, part) in enumerate(zip(heights, parts, strict=True))
        ]
        made.append({"name": name, "title": title, "bars": bars})
    return made


def draw_sheet(folder: Path, entries: Sequence[Entry]) -> Bytes:
    """Draw the contact sheet: a row a scene, a column an illumination, buffers below radiance.

    Scenes go on beside the first ones where the sheet would be higher than wide. (H, W, 3) uint8,
    sRGB, white where there is no image.
    """
    column, scenes = columns_of(entries), by_scene(entries)
    columns = list(dict.fromkeys(column.values()))
    width, height = entries[0]["size"]
    tall = max(round(_WIDTH * height / width), 1)
    small_width, small = _WIDTH // 2, max(tall // 2, 1)
    cell = np.array([tall + 2 * small, 2 * small_width])
    step = cell + _GAP
    side = np.sqrt(len(scenes) * step[0] / (len(columns) * step[1]))
    rows = math.ceil(len(scenes) / max(round(side), 1))
    blocks = math.ceil(len(scenes) / rows)
    sheet = np.full((*(step * (rows, blocks * len(columns)) + _GAP), 3), 255, np.uint8)
    for number, of in enumerate(scenes.values()):
        block, row = divmod(number, rows)
        for entry in of:
            place = row, block * len(columns) + columns.index(column[entry["name"]])
            top, left = step * place + _GAP
            images = folder / entry["name"]
            _draw(sheet, images / f"{PREVIEWED[0]}.png", top, left, tall, 2 * small_width)
            for i, name in enumerate(PREVIEWED[1:]):
                down, right = top + tall + i // 2 * small, left + i % 2 * small_width
                _draw(sheet, images / f"{name}.png", down, right, small, small_width)
    return sheet


def _draw(sheet: Bytes, file: Path, top: int, left: int, height: int, width: int) -> None:
    """Copy a picture onto the sheet, resized."""
    import OpenImageIO

    picture = OpenImageIO.ImageBuf(str(file))
    roi = OpenImageIO.ROI(0, width, 0, height, 0, 1, 0, 3)
    resized = OpenImageIO.ImageBufAlgo.resize(picture, filtername="box", roi=roi)
    pixels = resized.get_pixels(OpenImageIO.UINT8, roi)
    if pixels is None or resized.has_error:
        problem = f"cannot be read ({resized.geterror()})"
        raise InputError(f"{problem}; render it again with --resume", file)
    sheet[top : top + height, left : left + width] = pixels[..., :3]


def summarise(result: Result, rgb: Result) -> dict[str, Any]:
    """Return an image's statistics, JSON-able.

    `direct_share` is Σ|direct| / Σ|direct + indirect| over pixels and bands, None without light.
    Histograms over valid pixels have `BINS` bins over [0, 1]: one of reflectance in all bands, and
    those of the illuminant's red and blue fractions of R + G + B where none of the three is
    negative. `result`, in its bands, has the buffers that `with_derived` adds; `rgb` is the same in
    linear sRGB.
    """
    direct = result.direct.astype(np.float64)
    whole = float(np.abs(direct + result.indirect).sum())
    valid = result.buffers["valid"]
    light = rgb.buffers["illuminant"][valid]
    light = light[(light >= 0.0).all(axis=-1) & light.any(axis=-1)].astype(np.float64)
    fractions = light / light.sum(axis=-1, keepdims=True)
    return {
        "direct_share": float(np.abs(direct).sum()) / whole if whole else None,
        "valid": float(valid.mean()),
        "reflectance": _histogram(result.reflectance[valid]),
        "illuminant_red": _histogram(fractions[:, 0]),
        "illuminant_blue": _histogram(fractions[:, 2]),
    }


def _histogram(values: Any) -> list[int]:
    return np.histogram(np.clip(values, 0.0, 1.0), BINS, (0.0, 1.0))[0].tolist()
