"""What lies at the pixels' centres: depth, normal and ids."""

from typing import Any

import numpy as np

from photonmap.kernels.first_hit import first_hits
from photonmap.kernels.records import Film
from photonmap.prepare import Prepared
from photonmap.storage import RAM, Storage, strips
from photonmap.survey import TILE
from photonmap.workers import Workers

AT_CENTRES = ("depth", "normal", "object_id", "material_id")
"""Buffers of what lies at the pixels' centres."""


def first_hit_buffers(
    prepared: Prepared, film: Film, workers: Workers, storage: Storage = RAM
) -> dict[str, Any]:
    """Return depth, normal and ids at the pixels' centres, one row a pixel."""
    pixels = film.width * film.height
    triangles = storage.zeros(pixels, np.int32)
    depth, normal = storage.zeros(pixels), storage.zeros((pixels, 3))
    object_id, material_id = (storage.zeros(pixels, np.uint32) for _ in range(2))
    camera = prepared.film_camera(film.width, film.height)
    workers.ranges(
        lambda first, last: first_hits(
            prepared.geometry, camera, film, first, last, triangles, depth, normal
        ),
        pixels,
        TILE,
        whole=True,
    )
    depth *= np.float32(prepared.size)
    for part in strips(pixels):
        hit = triangles[part] >= 0
        object_id[part] = np.where(hit, prepared.object_ids[triangles[part]], 0)
        material_id[part] = np.where(hit, prepared.material_ids[triangles[part]], 0)
    return dict(zip(AT_CENTRES, (depth, normal, object_id, material_id), strict=True))
