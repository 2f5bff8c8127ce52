"""What decides the arrays of a render: runs that agree in it can go on, or be merged."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any

import numpy as np

from photonmap.bands import Bands

if TYPE_CHECKING:
    from photonmap.kernels.records import Film
    from photonmap.prepare import Prepared

ADDRESSES = ("scene", "address")
"""Fields of the kernels' records that differ from process to process."""
DIGESTS = ("band curves", "camera", "geometry", "materials", "lights", "kernels")
"""What is told as a hash alone."""


def describe_run(
    prepared: Prepared, bands: Bands, film: Film, arguments: dict[str, Any]
) -> dict[str, Any]:
    """Return the fingerprint of a render, JSON-able: arguments as they are, arrays as hashes.

    Parameters
    ----------
    prepared : the whole scene, in these bands
    bands : of the render
    film : the image
    arguments : further ones that decide the arrays, by name: numbers and strings
    """
    from photonmap import __version__
    from photonmap.kernels.jit import CACHE_FOLDER

    camera = prepared.film_camera(film.width, film.height)
    optics, textures = prepared.optics, prepared.textures
    place = prepared.center, prepared.size, prepared.power
    ids = prepared.object_ids, prepared.material_ids
    hashed = {
        "band curves": json.dumps(bands.describe()),
        "camera": camera,
        "geometry": (prepared.geometry, place, ids),
        "materials": (prepared.materials, optics, textures, prepared.images),
        "lights": (prepared.lights, prepared.light_groups),
    }
    return {
        "photonmap": __version__,
        "bands": bands.count,
        "size": f"{film.width}x{film.height}",
        **arguments,
        **{name: _digest(value) for name, value in hashed.items()},
        "kernels": CACHE_FOLDER.name,
    }


def difference(there: dict[str, Any], here: dict[str, Any]) -> str:
    """Say in which entries two fingerprints differ, "seed 0 there, 1 here"; "" if in none.

    Hashes are named only where no argument explains why they differ.
    """
    names = [name for name in {**here, **there} if there.get(name) != here.get(name)]
    told = [name for name in names if name not in DIGESTS]
    if told:
        return ", ".join(f"{name} {there.get(name)} there, {here.get(name)} here" for name in told)
    return f"other {' and '.join(names)}" if names else ""


def _digest(value: Any) -> str:
    digest = hashlib.blake2b(digest_size=8)
    _feed(digest, value)
    return digest.hexdigest()


def _feed(digest: hashlib.blake2b, value: Any) -> None:
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).data)
    elif hasattr(value, "_asdict"):
        _feed(digest, [part for name, part in value._asdict().items() if name not in ADDRESSES])
    elif isinstance(value, list | tuple):
        digest.update(f"{len(value)}(".encode())
        for part in value:
            _feed(digest, part)
    else:
        digest.update(f"{value!r};".encode())
