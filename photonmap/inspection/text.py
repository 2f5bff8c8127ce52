"""The description of a scene file, laid out for reading."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from photonmap.errors import visible
from photonmap.report.tables import aligned
from photonmap.runtime.wording import listed

MOST_ROWS = 40
"""Meshes, materials and lights that a table lists."""
_HEAD = ("name", "kind", "triangles")  # keys of materials and lights that have columns of their own
_LIGHT_HEAD = ("name", "kind", "power", "share")
_PLACES = ("origin", "target", "position")
"""Keys of points, which have as many digits as the scene's distance from the origin asks for."""
_MOST_NAMES = 4  # meshes of a material that are named
_DIGITS, _MOST_DIGITS = 6, 17
"""Significant digits of numbers, and those with which float64 is exact."""


def as_text(description: dict[str, Any]) -> str:
    """Return the description as lines of text."""
    return "\n".join(map(visible, _lines(description)))


def _lines(description: dict[str, Any]) -> Iterator[str]:
    totals, bounds, unit = description["totals"], description["bounds"], description["unit"]
    yield f"{description['file']}: {description['format']}, of {', '.join(description['files'])}"
    yield (
        f"{_count(totals['meshes'], 'mesh', 'meshes')}, {_count(totals['triangles'], 'triangle')}, "
        f"{_count(totals['vertices'], 'vertex', 'vertices')}, "
        f"{_count(totals['materials'], 'material')}"
    )
    digits = _count_digits(bounds)
    low, high = (_show(bounds[corner], digits) for corner in ("low", "high"))
    yield f"bounds {low} to {high}, size {_show(bounds['size'])}"
    yield f"unit: probably {unit['guess'] or 'none of the usual ones'}, a guess: {unit['why']}"
    yield from _section("meshes", _mesh_rows(description["meshes"]))
    yield from _section("materials", _rows(description["materials"], _HEAD))
    yield from _section("lights", _light_rows(description["lights"], _LIGHT_HEAD, digits))
    area = _light_rows(description["area_lights"], ("name", "material", "power", "share"))
    yield from _section("area lights", area)
    yield from _section("cameras", _camera_rows(description, digits))
    effects = description["effects"].items()
    rows = [(name, "on" if effect["on"] else "off", effect["why"]) for name, effect in effects]
    yield from _section("effects of a render", rows)
    yield ""
    yield f"warnings: {len(description['warnings']) or 'none'}"
    yield from _warning_lines(description["warnings"])


def _warning_lines(warnings: Sequence[dict[str, str]]) -> Iterator[str]:
    """Yield warnings, those of one remedy together with it."""
    by_remedy: dict[str, list[str]] = {}
    for warning in warnings:
        by_remedy.setdefault(warning["remedy"], []).append(warning["message"])
    for remedy, messages in by_remedy.items():
        yield from (f"  {message}" for message in messages)
        several = f" about these {len(messages)}" if len(messages) > 1 else ""
        yield f"    what to do{several}: {remedy}"


def _section(title: str, rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield a heading and its rows in columns; nothing without rows."""
    if not rows:
        return
    yield ""
    yield f"{title}:"
    yield from (f"  {line}" for line in aligned(rows[:MOST_ROWS]))
    if len(rows) > MOST_ROWS:
        yield f"  and {len(rows) - MOST_ROWS} more: --json lists all"


def _mesh_rows(meshes: Sequence[dict[str, Any]]) -> list[tuple[str, ...]]:
    """Return rows of meshes, those of most triangles first."""
    return [
        (
            mesh["name"],
            mesh["material"],
            _count(mesh["triangles"], "triangle"),
            _count(mesh["vertices"], "vertex", "vertices"),
            "uv" if mesh["uv"] else "no uv",
            "smooth" if mesh["smooth"] else "flat" if mesh["normals"] else "flat, no normals",
            _show_colors(mesh["colors"]),
        )
        for mesh in sorted(meshes, key=lambda mesh: -mesh["triangles"])
    ]


def _show_colors(colors: dict[str, Any] | None) -> str:
    """Return what the colours of a mesh do; nothing where it has none."""
    if colors is None:
        return ""
    mean = _show(colors["mean"])
    return f"colours of {colors['of']} in place of the reflectance, mean {mean}"


def _camera_rows(description: dict[str, Any], digits: int) -> list[tuple[str, ...]]:
    """Return rows of cameras; or the one that says where a scene without any is seen from."""
    if framed := description["framed_camera"]:
        place = _show(framed["origin"], digits)
        row = f"no camera given: seen from the front right, above, at {place} in a square image"
        return [(row,)]
    return _rows(description["cameras"], ("name", "kind"), digits)


def _light_rows(
    lights: Sequence[dict[str, Any]], head: Sequence[str], digits: int = _DIGITS
) -> list[tuple[str, ...]]:
    """Return rows of lights, the strongest first."""
    shown = [
        light | {"power": f"{light['power']:.4g} W", "share": f"{100.0 * light['share']:.1f}%"}
        for light in sorted(lights, key=lambda light: -light["power"])
    ]
    return _rows(shown, head, digits)


def _rows(
    items: Sequence[dict[str, Any]], head: Sequence[str], digits: int = _DIGITS
) -> list[tuple[str, ...]]:
    """Return a column for each key of the head, and one for all others."""
    rows = []
    for item in items:
        details = ", ".join(
            _show_detail(key, value, digits)
            for key, value in item.items()
            if key not in head and value not in (None, [])
        )
        rows.append((*(_cell(key, item[key]) for key in head), details))
    return rows


def _show_detail(key: str, value: Any, digits: int) -> str:
    """Return a value that has no column of its own, with its key."""
    if key == "lens":
        return _show_lens(value)
    if key == "meshes":
        return f"of {listed(value, _MOST_NAMES)} alone"
    return f"{key} {_show(value, digits if key in _PLACES else _DIGITS)}"


def _cell(key: str, value: Any) -> str:
    return _count(value, "triangle") if key == "triangles" else str(value) or f"(no {key})"


def _count(number: int, one: str, several: str = "") -> str:
    return f"{number:,} {one if number == 1 else several or one + 's'}"


def _count_digits(bounds: dict[str, Any]) -> int:
    """Return the digits that tell points apart as well as if the scene lay about the origin."""
    size = max(bounds["size"])
    farthest = max(map(abs, (*bounds["low"], *bounds["high"])))
    if not 0.0 < size < farthest:
        return _DIGITS
    return min(_DIGITS + math.ceil(math.log10(farthest / size)), _MOST_DIGITS)


def _show_lens(lens: dict[str, Any]) -> str:
    """Return a lens in words."""
    opening = f"of radius {_show(lens['radius'])}"
    if lens["f_number"] is not None:
        opening = f"f/{_show(lens['f_number'])} of focal length {_show(lens['focal_length'])}"
    words = f"{lens['kind']} lens {opening}, sharp at distance {_show(lens['focus'])}"
    if lens["blades"]:
        words += f", {lens['blades']} blades, turned by {_show(lens['rotation'])}°"
    return words


def _show(value: Any, digits: int = _DIGITS) -> str:
    """Return a value of the description as text, numbers to so many significant digits."""
    if isinstance(value, dict) and "texture" in value:
        image = value["texture"]
        mean = _show(image["mean"])
        texels = f"{image['bits']} bits" if "bits" in image else f"{image['spectra']} spectra"
        return f"texture {image['width']}x{image['height']}, {texels}, mean {mean}"
    if isinstance(value, dict) and "spectrum" in value:
        curve = value["spectrum"]
        low, high = curve["range_nm"]
        return f"spectrum of {curve['samples']} samples, {low:g} to {high:g} nm"
    if isinstance(value, dict):
        return " ".join(f"{key} {_show(part)}" for key, part in value.items())
    if isinstance(value, list | tuple):
        return f"({', '.join(_show(part, digits) for part in value)})"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)
