"""ENVI images: a header FILE.hdr in text beside the plain values FILE.img, as L3Harris defines."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_TYPES = {"uint8": 1, "float32": 4, "uint32": 13}  # ENVI's numbers of data types


def write_envi(
    image: NDArray[Any],
    header: Path,
    names: Sequence[str],
    wavelengths: Sequence[float] | NDArray[np.float64] | None = None,
    description: str = "",
) -> tuple[Path, Path]:
    """Write an image as FILE.hdr and FILE.img, interleaved by pixel, little-endian.

    image : (H, W) or (H, W, N) float32, uint32, uint8 or bool, which becomes uint8
    wavelengths : of the bands, nm; None for what has none
    description : one line, with the unit
    Returns the two files
    """
    pixels = image.view(np.uint8) if image.dtype == bool else image
    data = header.with_suffix(".img")
    with data.open("wb") as file:
        for line in pixels:
            file.write(np.ascontiguousarray(line, line.dtype.newbyteorder("<")).tobytes())
    height, width = image.shape[:2]
    fields = {
        "description": f"{{{_plain(description)}}}",
        "samples": width,
        "lines": height,
        "bands": len(names),
        "header offset": 0,
        "file type": "ENVI Standard",
        "data type": _TYPES[pixels.dtype.name],
        "interleave": "bip",
        "byte order": 0,
        "band names": _listed(map(_plain, names)),
    }
    if wavelengths is not None:
        fields["wavelength units"] = "Nanometers"
        fields["wavelength"] = _listed(f"{at:.9g}" for at in wavelengths)
    lines = ["ENVI", *(f"{key} = {value}" for key, value in fields.items())]
    header.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return header, data


def _plain(text: str) -> str:
    """Return a text without what separates the values of a header."""
    for separator in "{},\n":
        text = text.replace(separator, " ")
    return " ".join(text.split())


def _listed(values: Any) -> str:
    return "{" + ", ".join(values) + "}"
