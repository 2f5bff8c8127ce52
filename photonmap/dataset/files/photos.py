"""Photos of a data set's images: what a camera would have recorded of them."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photonmap.dataset.files.lean import as_lean

if TYPE_CHECKING:
    from photonmap.capture.sensor import Sensor
    from photonmap.results.result import Result

PHOTO = "photo"
"""Folder of an image that holds its photo."""
_DIGITS = 16
_TOLD = ("time_s", "saturated", "negative")
"""What the manifest says of a photo."""


def choose_sensor(text: str | None) -> tuple[Sensor, dict[str, Any]] | tuple[None, None]:
    """Return the sensor of a camera or a FILE.toml, and what the head of a set says of it.

    Raises
    ------
    InputError : there is none
    """
    if text is None:
        return None, None
    from photonmap.capture.expose import find_response
    from photonmap.capture.sensor import load_sensor
    from photonmap.spectra.sensitivities import table_of

    sensor = load_sensor(text)
    if (path := table_of(sensor.camera)) is not None:
        sensor = replace(sensor, camera=str(path.resolve()))
    curves = json.dumps(find_response(sensor).bands.describe())
    digest = hashlib.sha256(curves.encode()).hexdigest()[:_DIGITS]
    return sensor, {**sensor.describe(), "sensitivities": digest}


def add_photo(
    folder: Path, result: Result, sensor: Sensor, seed: int, full: bool
) -> dict[str, Any]:
    """Write the photo of an image, of the radiance that its files hold; return its description.

    Raises
    ------
    InputError : the sensor cannot record the image
    """
    from photonmap.capture.expose import expose
    from photonmap.capture.photo import write_photo

    seen = result.select(["radiance", "emission"])
    photo = expose(seen if full else as_lean(seen)[0], sensor, seed)
    (folder / PHOTO).mkdir()
    write_photo(photo, folder / PHOTO)
    return {name: photo.record[name] for name in _TOLD}
