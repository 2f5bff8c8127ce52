"""Read colours: RGB, curves over wavelength, textures, and what metals reflect."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, Literal

import numpy as np

from photonmap.errors import InputError, naming
from photonmap.io.readers.decoding import note_loss, plain
from photonmap.io.readers.mitsuba.nodes import Node
from photonmap.io.readers.registry import GREY, OR_WITHOUT, extended
from photonmap.runtime.wording import shown, suggest
from photonmap.scene.images import decode_srgb
from photonmap.scene.textures import Paint, Texture, mean_color, shared_image
from photonmap.spectra.curves import LARGEST_REFLECTANCE, VISIBLE, Color, Floats, Spectrum
from photonmap.spectra.metals import EDGE_COSINE, conductor_reflectance, metal
from photonmap.spectra.observer import radiance_to_rgb, reflectance_to_rgb

Kind = Literal["reflectance", "emission", "index"]
COLOR_TAGS = ("rgb", "srgb", "spectrum", "blackbody", "float")
_SPECTRA = ("d65", "uniform", "srgb", "blackbody", "irregular", "regular")
_EDGE = 1e-3  # Width of the edges of a curve, nm, outside of which it is 0
_PLANCK = 2.0 * 6.62607015e-34 * 299792458.0**2, 6.62607015e-34 * 299792458.0 / 1.380649e-23
"""First (for radiance, W·m²·sr⁻¹) and second (m·K) radiation constants"""
_CHECKS = 256  # Texels along a side of a checkerboard's image: its edges blur over one of them
_NAMED = {
    "vacuum": 1.0, "helium": 1.000036, "hydrogen": 1.000132, "air": 1.000277,
    "carbon dioxide": 1.00045, "water": 1.333, "acetone": 1.36, "ethanol": 1.361,
    "carbon tetrachloride": 1.461, "glycerol": 1.4729, "benzene": 1.501, "silicone oil": 1.52045,
    "bromine": 1.661, "water ice": 1.31, "fused quartz": 1.458, "pyrex": 1.47,
    "acrylic glass": 1.49, "polypropylene": 1.49, "bk7": 1.5046, "sodium chloride": 1.544,
    "amber": 1.55, "pet": 1.575, "diamond": 2.419,
}  # fmt: skip
"""Indices of refraction that Mitsuba knows by name"""
_PERFECT = "none"


def read_color(node: Node, kind: Kind) -> Color:
    """Return a colour.

    A single number is grey, lights of which are D65; a curve is 0 beyond its ends.

    kind : a reflectance lies in [0, 1], an emission or index above 0
    """
    color = _read_any(node, kind)
    values = color.values if isinstance(color, Spectrum) else np.array(color, np.float64)
    highest = LARGEST_REFLECTANCE if kind == "reflectance" else math.inf
    outside = ~((values >= 0.0) & (values <= highest))
    if outside.any():
        limits = "keep it within [0, 1]" if kind == "reflectance" else "keep it at least 0"
        noun = node.element.attributes.get("name", kind)
        raise node.error(f"{noun} is {values[outside][0]:g}; {limits}")
    return combined(lambda value: np.minimum(value, 1.0), color) if highest < 2.0 else color


def _read_any(node: Node, kind: Kind) -> Color:
    element = node.element
    match node.tag:
        case "float":
            value = element.number(element.attribute("value"))
            return (value, value, value) if kind == "emission" else value
        case "rgb" | "srgb":
            return _rgb(node)
        case "blackbody":
            kelvin = element.attribute("temperature").strip().removesuffix("K")
            scale = element.number(element.attributes.get("scale", "1"))
            return _black_body(node, element.number(kelvin)) * scale
        case _ if node.type:
            return _typed(node)
        case _:
            return _spectrum(node, kind)


def _rgb(node: Node) -> Color:
    element = node.element
    text = element.attribute("value").strip()
    values = _digits(node, text) if text.startswith("#") else np.array(element.triple("value"))
    return plain(decode_srgb(values) if node.tag == "srgb" else values)


def _digits(node: Node, text: str) -> Floats:
    """Return hexadecimal digits as numbers from 0 to 1; in <rgb>, only Mitsuba 0.x has them."""
    try:
        values = np.frombuffer(bytes.fromhex(text[1:]), np.uint8) / 255.0
    except ValueError:
        values = np.zeros(0)
    if len(values) != 3:
        raise node.error(f"{shown(text)} is not a colour; write six digits after #")
    if node.tag == "rgb" and not node.is_old:
        linear = " ".join(f"{value:.4g}" for value in decode_srgb(values))
        problem = f"{shown(text)} is no <rgb>, which has linear numbers"
        raise node.error(f"{problem}; if it is sRGB, write {linear}")
    return values


def _spectrum(node: Node, kind: Kind) -> Color:
    """Return what a plain <spectrum> holds: a number, a curve, or the name of its file."""
    element = node.element
    if "filename" in element.attributes:
        path = node.context.find(element, element.attributes["filename"])
        text = path.read_text("utf-8", "replace")
        rows = [line for line in text.splitlines() if not line.lstrip().startswith("#")]
        values = element.numbers(" ".join(rows))
        return _curve(node, values[::2], values[1::2])
    text = element.attribute("value")
    if ":" in text:
        values = element.numbers(text.replace(":", " "))
        return _curve(node, values[::2], values[1::2])
    values = element.numbers(text)
    if len(values) == 3:  # as Mitsuba 0.x, compiled for RGB, has it
        return plain(np.array(values))
    if len(values) != 1:
        raise node.error(
            f"{shown(text)} is not a spectrum; write one number, or pairs wavelength:value"
        )
    return flat(values[0]) if kind == "emission" else values[0]


def _typed(node: Node) -> Color:
    match node.type:
        case "uniform":
            return flat(node.number("value", 1.0))
        case "srgb" | "d65":
            color, scale = node.find("color"), node.number("scale", 1.0)
            values = np.ones(3) if color is None else np.array(color.element.triple("value"))
            return plain(scale * values)
        case "blackbody":
            return _black_body(node, node.number("temperature", 5000.0))
        case "irregular" | "regular":
            return _curve(node, _wavelengths(node), node.element.numbers(node.text("values")))
    images = ("bitmap", "checkerboard") if node.tag == "texture" else ()
    raise node.unknown((*_SPECTRA, *images))


def _wavelengths(node: Node) -> list[float]:
    if node.type == "irregular":
        return node.element.numbers(node.text("wavelengths"))
    low = node.number("wavelength_min", node.number("lambda_min", 360.0))
    high = node.number("wavelength_max", node.number("lambda_max", 830.0))
    count = len(node.element.numbers(node.text("values")))
    return np.linspace(low, high, count).tolist()


def _black_body(node: Node, kelvin: float) -> Spectrum:
    """Return the light of a black body, W·m⁻²·sr⁻¹·nm⁻¹."""
    if not kelvin > 0.0:
        raise node.error(f"a black body has {kelvin:g} K; give a temperature above 0")
    first, second = _PLANCK

    def radiance(nanometres: Floats) -> Floats:
        metres = nanometres * 1e-9
        return 1e-9 * first / (metres**5 * np.expm1(np.minimum(second / (metres * kelvin), 700.0)))

    return Spectrum.sample(radiance, 300.0, 1000.0)


def _curve(node: Node, wavelengths: list[float], values: list[float]) -> Spectrum:
    """Return a curve that is 0 beyond its ends."""
    with naming(f"{node.tag} {node.type or node.id}".strip(), node.element.path, node.element.line):
        curve = Spectrum(np.array(wavelengths), np.array(values))
    first, last = curve.wavelengths[[0, -1]]
    low, high = min(first - _EDGE, VISIBLE[0]) - 1.0, max(last + _EDGE, VISIBLE[1]) + 1.0
    grid = np.array([low, first - _EDGE, *curve.wavelengths, last + _EDGE, high])
    return Spectrum(grid, np.array([0.0, 0.0, *curve.values, 0.0, 0.0]), extrapolate=True)


def flat(value: float) -> Spectrum:
    """Return a spectrum that is the same at all wavelengths."""
    return Spectrum(np.array(VISIBLE), np.array([value, value]), extrapolate=True)


def combined(function: Callable[..., Any], *colors: Color) -> Color:
    """Return what a function of numbers makes of colours, wavelength by wavelength.

    Curves meet colours in RGB as their RGB.
    """
    if any(isinstance(color, tuple) for color in colors):
        return plain(function(*map(as_rgb, colors)))
    curves = [color for color in colors if isinstance(color, Spectrum)]
    if not curves:
        return float(function(*colors))
    grid = np.unique(np.concatenate([curve.wavelengths for curve in curves]))
    values = [color(grid) if isinstance(color, Spectrum) else color for color in colors]
    return Spectrum(grid, function(*values), all(curve.extrapolate for curve in curves))


def as_rgb(color: Color, kind: Kind = "reflectance") -> Floats:
    """Return linear RGB; of a curve of a reflectance or index, as seen under D65."""
    if isinstance(color, Spectrum):
        project = radiance_to_rgb if kind == "emission" else reflectance_to_rgb
        return np.maximum(project(color), 0.0)
    return np.ones(3) * color


def read_paint(node: Node, name: str, default: Color, kind: Kind = "reflectance") -> Paint:
    """Return a parameter that is a colour or a texture."""
    found = node.find(name)
    if found is None:
        return default
    if found.tag in COLOR_TAGS:
        return read_color(found, kind)
    if found.tag != "texture":
        raise found.error(f"{name} is a <{found.tag}>; give a colour or a texture")
    return read_texture(found, kind)


def read_texture(found: Node, kind: Kind) -> Paint:
    """Return what a texture stands for: an image, or a colour."""
    if found.type == "bitmap":
        return _bitmap(found)
    if found.type == "checkerboard":
        return _checkerboard(found, kind)
    return read_color(found, kind)


def read_plain(node: Node, name: str, default: Color, kind: Kind = "reflectance") -> Color:
    """Return a parameter that is simulated as a colour: the mean of a texture, which is noted."""
    paint = read_paint(node, name, default, kind)
    if isinstance(paint, Texture):
        node.lose(f"texture of {name}")
    return mean_color(paint)


def read_scalar(node: Node, name: str, default: float) -> float:
    """Return a parameter that is simulated as a number: the mean of anything else."""
    color = read_plain(node, name, default, "index")
    return float(np.mean(as_rgb(color) if isinstance(color, Spectrum) else color))


def changed(paint: Paint, function: Callable[..., Any]) -> Paint:
    """Return what a function of numbers makes of a colour, or of each texel."""
    if not isinstance(paint, Texture):
        return combined(function, paint)
    linear = paint.image.linear(slice(None), slice(None)) * np.array(paint.factor, np.float32)
    texels = function(linear).astype(np.float32)
    return replace(paint, image=Texture.of(texels).image, factor=(1.0, 1.0, 1.0))


def _bitmap(node: Node) -> Paint:
    """Return an image; grey if it is missing and that is allowed."""
    raw = node.flag("raw", False)
    is_nearest = node.text("filter_type", "bilinear") == "nearest"
    both = node.text("wrap_mode", "repeat")
    wraps = [node.text(f"wrap_mode_{axis}", both) for axis in "uv"]  # as 0.x has them
    if unknown := [wrap for wrap in wraps if wrap not in ("repeat", "mirror", "clamp")]:
        node.lose(f"wrap mode {shown(unknown[0])}")
    name = node.text("filename")
    try:
        image = shared_image(node.file(), raw)
    except InputError as error:
        if node.context.missing_textures == "error":
            raise extended(error, OR_WITHOUT) from None
        note_loss(node.context.losses, "unreadable textures, with grey in their place,", name[:80])
        return GREY
    placed = _placement(node)
    node.lose_unread()
    clamp = wraps[0] == "clamp", wraps[1] == "clamp"
    texture = Texture(image, clamp=clamp, nearest=is_nearest, **placed)
    return texture.mirrored(wraps[0] == "mirror", wraps[1] == "mirror")


def _checkerboard(node: Node, kind: Kind) -> Texture:
    highest = 1.0 if kind == "reflectance" else np.inf
    one, other = (
        np.minimum(as_rgb(read_plain(node, name, default, kind), kind), highest)
        for name, default in (("color0", 0.4), ("color1", 0.2))
    )
    index = np.arange(_CHECKS) >= _CHECKS // 2
    same = index[:, None] == index
    texels = np.where(same[..., None], one, other).astype(np.float32)
    placed = _placement(node)
    node.lose_unread()
    return Texture.of(texels, **placed)


def _placement(node: Node) -> dict[str, Any]:
    """Return how a texture lies on a surface; Mitsuba's v counts downwards, ours upwards."""
    matrix = node.transform("to_uv")
    if matrix[0, 1] or matrix[1, 0]:
        node.lose("rotation of textures")
    # What stood in place of to_uv in Mitsuba 0.x
    du, dv = node.number("uoffset", 0.0), node.number("voffset", 0.0)
    u, v = node.number("uscale", 1.0), node.number("vscale", 1.0)
    scale = float(matrix[0, 0]) * u, float(matrix[1, 1]) * v
    shift = u * (float(matrix[0, 3]) + du), v * (float(matrix[1, 3]) + dv)
    return {"scale": scale, "offset": (shift[0], 1.0 - scale[1] - shift[1])}


def index_of(node: Node, name: str, default: str) -> float:
    """Return an index of refraction, given as a number or by name."""
    found = node.find(name)
    if found is None:
        return _NAMED[default]
    if found.tag != "string":
        value = node.number(name, 1.0)
        if value <= 0.0:
            raise found.error(f"{name} {value:g} is not above 0; correct it")
        return value
    wanted = node.text(name).lower()
    if wanted not in _NAMED:
        raise found.error(f"{name} {shown(wanted)} is not known; {suggest(wanted, _NAMED)}")
    return _NAMED[wanted]


def metal_reflectances(node: Node) -> tuple[Color, Color]:
    """Return what a metal reflects at normal incidence, and at 82°: 1 if none is named."""
    if node.find("eta") or node.find("k"):
        eta = read_plain(node, "eta", 0.0, "index")
        k = read_plain(node, "k", 1.0, "index")
        normal, edge = (
            combined(partial(conductor_reflectance, cosine=cosine), eta, k)
            for cosine in (1.0, EDGE_COSINE)
        )
        return normal, edge
    name = node.text("material", _PERFECT)
    if name.lower() == _PERFECT:
        return 1.0, 1.0
    element = node.element
    with naming(f"material {shown(name)}", element.path, element.line):
        found = metal(name)
    assert found.edge is not None
    return found, found.edge
