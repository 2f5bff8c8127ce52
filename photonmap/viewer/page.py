"""The page: what it says of a result, and its arrays."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.buffers import BY_NAME, Buffer, row_of, split_name
from photonmap.errors import InputError
from photonmap.io.exr import list_parts, read_exr
from photonmap.report.pages import stylesheet
from photonmap.report.plots import COLORS
from photonmap.results.colors import AS_IT_IS, SCENE
from photonmap.results.result import Result
from photonmap.runtime.wording import suggest
from photonmap.runtime.writing import replacing
from photonmap.version import __version__
from photonmap.viewer.packing import find_scale, pack_errors, pack_numbers, pack_values

_PARTS = ("emission", "direct", "indirect")  # of which radiance is the sum
_LEFT_OUT = {"covariance", "unresolved", "passes", "coverage", "distance"}
"""Buffers that are shown only where they are asked for."""
_FOR_EXPOSURE = ("radiance", "emission")
_TEMPLATES = Path(__file__).parent / "templates"
_PALETTE = ("#000000", *COLORS)


def load_for_page(path: str | PathLike[str], buffers: Collection[str] | None = None) -> Result:
    """Read what a page shows of FILE.exr: these buffers, or all that a picture can be made of."""
    wanted = None if buffers is None else {*buffers, *_FOR_EXPOSURE}
    names = [
        name
        for name in list_parts(path)
        if (name.partition(".")[0] in wanted if wanted else not _is_left_out(name))
    ]
    return Result(*read_exr(path, names))


def _is_left_out(part: str) -> bool:
    return split_name(part.partition(".")[0])[0] in _LEFT_OUT or part.endswith(".error8")


def write_page(
    results: Sequence[Result],
    titles: Sequence[str],
    path: str | PathLike[str],
    buffers: Iterable[str] | None = None,
) -> None:
    """Write one page that shows the buffers of a result, or of two and their difference.

    It needs no other file and no network. Values are rounded to a half of their standard error.

    Parameters
    ----------
    results, titles : one or two, of equal size and bands, and what the page calls them
    path : FILE.html
    buffers : names of those to show; None for all that a picture can be made of
    """
    _check(results)
    names = _choose(results, buffers)
    with ThreadPoolExecutor(2) as pool:
        tasks = {
            (index, name): pool.submit(_pack_buffer, result, name)
            for index, result in enumerate(results)
            for name in names
            if name in result.buffers
        }
        packed = {key: task.result() for key, task in tasks.items()}
    head = _describe(results, titles, names)
    head["arrays"] = [
        {"file": index, "buffer": name, **about} for (index, name), (about, _) in packed.items()
    ]
    texts = [text for _, (_, texts) in packed.items() for text in texts]
    page = (_TEMPLATES / "viewer.html").read_text(encoding="utf-8")
    parts = {
        "TITLE": escape(" − ".join(titles), quote=False),
        "STYLE": stylesheet(),
        "SCRIPT": (_TEMPLATES / "viewer.js").read_text(encoding="utf-8"),
        "HEAD": json.dumps(head, ensure_ascii=False).replace("<", "\\u003c"),
        "DATA": "\n".join(f'<script type="text/plain">{text}</script>' for text in texts),
    }
    for key, text in parts.items():
        page = page.replace(f"<!--{key}-->", text, 1)
    data = page.encode()
    with replacing(path, len(data)) as part:
        part.write_bytes(data)


def _check(results: Sequence[Result]) -> None:
    """Check that two results can be compared."""
    first, *others = results
    for other in others:
        if other.size != first.size:
            sizes = " and ".join("{}x{}".format(*result.size) for result in results)
            raise InputError(f"the images differ in size, {sizes}; give two of one size")
        if other.bands != first.bands:
            raise InputError("the images differ in bands; give two of the same bands")


def _choose(results: Sequence[Result], buffers: Iterable[str] | None) -> list[str]:
    """Return the names of the buffers to show, in the order of the list of buffers."""
    found = list(dict.fromkeys(name for result in results for name in result.buffers))
    if buffers is None:
        chosen = [name for name in found if row_of(name) and not _is_left_out(name)]
    else:
        chosen = list(buffers)
        for name in chosen:
            if name not in found:
                remedy = "render it with --buffers" if row_of(name) else suggest(name, BY_NAME)
                raise InputError(f"there is no buffer {name!r}; {remedy}")
    if not chosen:
        raise InputError("there is no buffer that can be shown")
    order = {name: place for place, name in enumerate(BY_NAME)}

    def place(name: str) -> tuple[bool, bool, int]:
        row = row_of(name)
        return name != "radiance", "@" in name, len(order) if row is None else order[row.name]

    return sorted(chosen, key=place)


def _pack_buffer(result: Result, name: str) -> tuple[dict[str, Any], list[str]]:
    """Return what the page has to know of a buffer's array, and the texts of its data."""
    image, error = result.buffers[name], result.errors.get(name)
    row = row_of(name)
    if row is not None and row.is_integer:
        return {"scale": 0, "values": True}, [pack_numbers(image)]
    is_sum = name == "radiance" and all(part in result.buffers for part in _PARTS)
    scale, texts = find_scale(image), []
    if not is_sum:
        texts.append(pack_values(np.asarray(image), error, scale))
    about: dict[str, Any] = {"scale": scale, "values": not is_sum}
    if error is not None:
        text, about["errors"] = pack_errors(np.asarray(error))
        texts.append(text)
    return about, texts


def _describe(
    results: Sequence[Result], titles: Sequence[str], names: Sequence[str]
) -> dict[str, Any]:
    """Return all that the page has to know but the arrays."""
    first = results[0]
    (width, height), bands = first.size, first.bands
    of_record = ("passes", "error", "seed", "objects", "materials")
    files = [
        {"title": title, **{key: result.record.get(key) for key in of_record}}
        for title, result in zip(titles, results, strict=True)
    ]
    buffers = [
        _describe_buffer(name, _PALETTE[index % len(_PALETTE)], results)
        for index, name in enumerate(names)
    ]
    return {
        "version": __version__,
        "width": width,
        "height": height,
        "files": files,
        "bands": list(bands.names),
        "wavelengths": None if bands.centroids is None else bands.centroids.tolist(),
        "projections": _projections(first),
        "exposure": first.exposure if "radiance" in first.buffers else 1.0,
        "parts": _PARTS,
        "buffers": buffers,
    }


def _projections(result: Result) -> list[dict[str, Any]]:
    """Return the ways to see bands in linear sRGB, the usual one first."""
    matrix = result.projection().matrix
    plain = (matrix / matrix.sum(axis=1, keepdims=True)).tolist()
    ways = {"sRGB": SCENE, "sRGB, not adapted": AS_IT_IS}
    return [
        {"name": name, "matrix": (result.adaptation(white) @ matrix).tolist(), "reflectance": plain}
        for name, white in ways.items()
    ]


def _describe_buffer(name: str, color: str, results: Sequence[Result]) -> dict[str, Any]:
    row = row_of(name)
    image = next(result.buffers[name] for result in results if name in result.buffers)
    return {
        "name": name,
        "kind": _kind(row),
        "channels": 1 if image.ndim == 2 else image.shape[2],
        "unit": "" if row is None else row.unit,
        "meaning": "" if row is None else row.meaning.replace("`", ""),
        "color": color,
    }


def _kind(row: Buffer | None) -> str:
    """Return how a buffer is drawn: as light, reflectance, ratio, direction, id or number."""
    if row is None:
        return "radiance"
    if row.is_banded or row.quantity in ("direction", "id"):
        return row.quantity
    return "number"
