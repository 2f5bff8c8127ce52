"""Read colours: RGB, and curves over wavelength."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import naming
from photonmap.io.readers.mitsuba_parts.context import Files
from photonmap.io.readers.mitsuba_parts.nodes import Node
from photonmap.io.readers.mitsuba_parts.values import (
    number_of,
    numbers_of,
    plain,
    triple_of,
)
from photonmap.runtime.wording import shown
from photonmap.scene.images import decode_srgb
from photonmap.spectra.curves import LARGEST_REFLECTANCE, VISIBLE, Color, Spectrum
from photonmap.spectra.observer import radiance_to_rgb, reflectance_to_rgb

Floats = NDArray[np.float64]
Kind = Literal["reflectance", "emission", "index"]
COLOR_TAGS = ("rgb", "srgb", "spectrum", "blackbody", "float")
_TYPES = ("d65", "uniform", "srgb", "blackbody", "irregular", "regular")
_EDGE = 1e-3
"""Width of the edges of a curve, nm, outside of which it is 0."""
_PLANCK = 2.0 * 6.62607015e-34 * 299792458.0**2, 6.62607015e-34 * 299792458.0 / 1.380649e-23
"""First (for radiance, W·m²·sr⁻¹) and second (m·K) radiation constants"""


def read_color(node: Node, kind: Kind, files: Files) -> Color:
    """Return a colour.

    A single number is grey, lights of which are D65; a curve is 0 beyond its ends.

    Parameters
    ----------
    node : <rgb>, <spectrum> or <float>
    kind : a reflectance lies in [0, 1], an emission or index above 0
    files : finds curves

    Raises
    ------
    InputError : it is not a colour, or out of range
    """
    color = _read(node, kind, files)
    values = color.values if isinstance(color, Spectrum) else np.array(color, np.float64)
    highest = LARGEST_REFLECTANCE if kind == "reflectance" else math.inf
    outside = ~((values >= 0.0) & (values <= highest))
    if outside.any():
        limits = "keep it within [0, 1]" if kind == "reflectance" else "keep it at least 0"
        noun = node.element.attributes.get("name", kind)
        raise node.error(f"{noun} is {values[outside][0]:g}; {limits}")
    return combined(lambda value: np.minimum(value, 1.0), color) if highest < 2.0 else color


def _read(node: Node, kind: Kind, files: Files) -> Color:
    element = node.element
    match node.tag:
        case "float":
            value = number_of(element, element.attribute("value"))
            return (value, value, value) if kind == "emission" else value
        case "rgb" | "srgb":
            return _rgb(node)
        case "blackbody":
            kelvin = element.attribute("temperature").strip().removesuffix("K")
            scale = number_of(element, element.attributes.get("scale", "1"))
            return _black_body(node, number_of(element, kelvin)) * scale
        case _ if node.type:
            return _typed(node)
        case _:
            return _spectrum(node, kind, files)


def _rgb(node: Node) -> Color:
    """Return linear RGB; <srgb>, and hexadecimal digits, of Mitsuba 0.x are encoded in sRGB."""
    element = node.element
    text = element.attribute("value").strip()
    if text.startswith("#"):
        try:
            values = np.frombuffer(bytes.fromhex(text[1:]), np.uint8) / 255.0
        except ValueError:
            values = np.zeros(0)
        if len(values) != 3:
            raise node.error(f"{shown(text)} is not a colour; write six digits after #")
        return plain(decode_srgb(values))
    values = np.array(triple_of(element, "value"))
    return plain(decode_srgb(values) if node.tag == "srgb" else values)


def _spectrum(node: Node, kind: Kind, files: Files) -> Color:
    """Return what a plain <spectrum> holds: a number, a curve, or the name of its file."""
    element = node.element
    if "filename" in element.attributes:
        path = files.find(element, element.attributes["filename"])
        text = path.read_text("utf-8", "replace")
        rows = [line for line in text.splitlines() if not line.lstrip().startswith("#")]
        values = numbers_of(element, " ".join(rows))
        return _curve(node, values[::2], values[1::2])
    text = element.attribute("value")
    if ":" in text:
        values = numbers_of(element, text.replace(":", " "))
        return _curve(node, values[::2], values[1::2])
    values = numbers_of(element, text)
    if len(values) == 3:  # as Mitsuba 0.x, compiled for RGB, has it
        return plain(np.array(values))
    if len(values) != 1:
        raise node.error(f"{shown(text)} is no spectrum; write one number, or wavelength:value")
    return flat(values[0]) if kind == "emission" else values[0]


def _typed(node: Node) -> Color:
    """Return a spectrum that has a type and parameters."""
    match node.type:
        case "uniform":
            return flat(node.number("value", 1.0))
        case "srgb" | "d65":
            color, scale = node.find("color"), node.number("scale", 1.0)
            values = np.ones(3) if color is None else np.array(triple_of(color.element, "value"))
            return plain(scale * values)
        case "blackbody":
            return _black_body(node, node.number("temperature", 5000.0))
        case "irregular" | "regular":
            return _curve(node, _wavelengths(node), numbers_of(node.element, node.text("values")))
    images = ("bitmap", "checkerboard") if node.tag == "texture" else ()
    raise node.unknown((*_TYPES, *images))


def _wavelengths(node: Node) -> list[float]:
    """Return the wavelengths of a spectrum's values, nm."""
    if node.type == "irregular":
        return numbers_of(node.element, node.text("wavelengths"))
    low = node.number("wavelength_min", node.number("lambda_min", 360.0))
    high = node.number("wavelength_max", node.number("lambda_max", 830.0))
    count = len(numbers_of(node.element, node.text("values")))
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
