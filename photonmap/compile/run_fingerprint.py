"""What decides the arrays of a render: runs that agree in it can be resumed, or merged."""

from __future__ import annotations

import json
from typing import Any

from photonmap.compile.scene_arrays import CompiledScene
from photonmap.kernels.core.jit import CACHE_FOLDER
from photonmap.kernels.core.passes import Film
from photonmap.runtime.fingerprint import digest
from photonmap.spectra.bands import Bands
from photonmap.version import __version__


def describe_run(
    compiled: CompiledScene, bands: Bands, film: Film, arguments: dict[str, Any]
) -> dict[str, Any]:
    """Return the fingerprint of a render, JSON-able: arguments as they are, arrays as hashes.

    Parameters
    ----------
    compiled : the whole scene, in these bands
    bands : of the render
    film : the image
    arguments : further ones that decide the arrays, by name: numbers and strings
    """
    camera = compiled.film_camera(film.width, film.height)
    scatterers = compiled.specular, compiled.scattering, compiled.textures
    place = compiled.center, compiled.size
    ids = compiled.object_ids, compiled.material_ids
    hashed = {
        "band curves": json.dumps(bands.describe()),
        "camera": camera,
        "geometry": (compiled.geometry, place, ids),
        "materials": (compiled.materials, scatterers, compiled.images),
        "lights": (compiled.lights, compiled.light_groups, compiled.power),
    }
    return {
        "photonmap": __version__,
        "bands": bands.count,
        "size": f"{film.width}x{film.height}",
        **arguments,
        **{name: digest(value) for name, value in hashed.items()},
        "kernels": CACHE_FOLDER.name,
    }
