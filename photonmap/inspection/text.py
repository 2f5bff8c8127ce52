"""The description of a scene file, laid out for reading."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

MOST_ROWS = 40
"""Meshes, materials and lights that a table lists."""
_HEAD = ("name", "kind", "triangles")
"""Keys of materials and lights that have columns of their own."""
_LIGHT_HEAD = ("name", "kind", "power", "share")


def as_text(description: dict[str, Any]) -> str:
    """Return the description as lines of text."""
    return "\n".join(_lines(description))


def _lines(description: dict[str, Any]) -> Iterator[str]:
    totals, bounds, unit = description["totals"], description["bounds"], description["unit"]
    yield f"{description['file']}: {description['format']}, of {', '.join(description['files'])}"
    yield (
        f"{_count(totals['meshes'], 'mesh', 'meshes')}, {_count(totals['triangles'], 'triangle')}, "
        f"{_count(totals['vertices'], 'vertex', 'vertices')}, "
        f"{_count(totals['materials'], 'material')}"
    )
    yield f"bounds {_show(bounds['low'])} to {_show(bounds['high'])}, size {_show(bounds['size'])}"
    yield f"unit: probably {unit['guess'] or 'none of the usual ones'}, a guess: {unit['why']}"
    yield from _section("meshes", _mesh_rows(description["meshes"]))
    yield from _section("materials", _rows(description["materials"], _HEAD))
    yield from _section("lights", _light_rows(description["lights"], _LIGHT_HEAD))
    area = _light_rows(description["area_lights"], ("name", "material", "power", "share"))
    yield from _section("area lights", area)
    yield from _section("cameras", _rows(description["cameras"], ("name", "kind")))
    if description["framed_camera"]:
        origin = _show(description["framed_camera"]["origin"])
        yield f"no camera given: seen from the front right, above, at {origin} in a square image"
    effects = [
        (name, "on" if effect["on"] else "off", effect["why"])
        for name, effect in description["effects"].items()
    ]
    yield from _section("effects of a render", effects)
    yield ""
    yield f"warnings: {len(description['warnings']) or 'none'}"
    for warning in description["warnings"]:
        yield f"  {warning['message']}"
        yield f"    what to do: {warning['remedy']}"


def _section(title: str, rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield a heading and its rows in columns; nothing without rows."""
    if not rows:
        return
    yield ""
    yield f"{title}:"
    shown = rows[:MOST_ROWS]
    widths = [max(len(row[column]) for row in shown) for column in range(len(shown[0]))]
    for row in shown:
        cells = (f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True))
        yield f"  {'  '.join(cells)}".rstrip()
    if len(rows) > MOST_ROWS:
        yield f"  and {len(rows) - MOST_ROWS} more: --json lists all"


def _mesh_rows(meshes: Sequence[dict[str, Any]]) -> list[tuple[str, ...]]:
    """Return rows of meshes, those of most triangles first."""
    ordered = sorted(meshes, key=lambda mesh: -mesh["triangles"])
    return [
        (
            mesh["name"],
            mesh["material"],
            _count(mesh["triangles"], "triangle"),
            _count(mesh["vertices"], "vertex", "vertices"),
            "uv" if mesh["uv"] else "no uv",
            "smooth" if mesh["smooth"] else "flat" if mesh["normals"] else "flat, no normals",
        )
        for mesh in ordered
    ]


def _light_rows(lights: Sequence[dict[str, Any]], head: Sequence[str]) -> list[tuple[str, ...]]:
    """Return rows of lights, the strongest first."""
    ordered = sorted(lights, key=lambda light: -light["power"])
    shown = [
        light | {"power": f"{light['power']:.4g} W", "share": f"{100.0 * light['share']:.1f}%"}
        for light in ordered
    ]
    return _rows(shown, head)


def _rows(items: Sequence[dict[str, Any]], head: Sequence[str]) -> list[tuple[str, ...]]:
    """Return a column for each key of the head, and one for all others."""
    rows = []
    for item in items:
        others = {key: value for key, value in item.items() if key not in head}
        details = ", ".join(
            f"{key} {_show(value)}" for key, value in others.items() if value not in (None, [])
        )
        rows.append((*(_cell(key, item[key]) for key in head), details))
    return rows


def _cell(key: str, value: Any) -> str:
    return _count(value, "triangle") if key == "triangles" else str(value) or f"(no {key})"


def _count(number: int, one: str, several: str = "") -> str:
    return f"{number:,} {one if number == 1 else several or one + 's'}"


def _show(value: Any) -> str:
    """Return a value of the description as text."""
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
    if isinstance(value, list):
        return f"({', '.join(map(_show, value))})"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
