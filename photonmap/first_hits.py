"""What lies at the pixels' centres: depth, normal and ids."""

from typing import Any

import numpy as np

from photonmap.kernels.first_hit import first_hits
from photonmap.kernels.records import Film
from photonmap.prepare import Prepared
from photonmap.survey import TILE
from photonmap.workers import Workers


def first_hit_buffers(prepared: Prepared, film: Film, workers: Workers) -> dict[str, Any]:
    """Return depth, normal and ids at the pixels' centres, one row a pixel."""
    pixels = film.width * film.height
    triangles = np.empty(pixels, np.int32)
    depth, normal = np.empty(pixels, np.float32), np.empty((pixels, 3), np.float32)
    camera = prepared.film_camera(film.width, film.height)
    workers.ranges(
        lambda first, last: first_hits(
            prepared.geometry, camera, film, first, last, triangles, depth, normal
        ),
        pixels,
        TILE,
        whole=True,
    )
    hit = triangles >= 0
    return {
        "depth": depth * np.float32(prepared.size),
        "normal": normal,
        "object_id": np.where(hit, prepared.object_ids[triangles], 0).astype(np.uint32),
        "material_id": np.where(hit, prepared.material_ids[triangles], 0).astype(np.uint32),
    }
