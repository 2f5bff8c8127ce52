"""Pictures of layers for a page: small, in sRGB, and part of it."""

from __future__ import annotations

import base64

import numpy as np

from photonmap.evaluate.bench.metric_list import ILLUMINANT
from photonmap.evaluate.bench.truth import Truth
from photonmap.evaluate.metrics.arrays import Floats, to_grey
from photonmap.io.png import encode_png
from photonmap.results.preview import as_bytes

_WIDTH = 160
"""Largest width of a picture, pixels."""
_SHOWN_AS = 0.8
"""Linear value that pictures give to a shading or radiance of 1."""
_PATCH = 24
"""Side of the patch that shows one illuminant, pixels."""


def layer_picture(truth: Truth, layer: str, values: Floats) -> str:
    """Return the picture of a layer; of an illuminant, its colour."""
    if layer != ILLUMINANT:
        return picture(truth, values, 1.0 if layer == "reflectance" else _SHOWN_AS)
    light = values if values.ndim == 1 else values[truth.mask].sum(axis=0)
    color = np.broadcast_to(light / np.abs(light).max(), (_PATCH, _PATCH, len(light)))
    return _as_uri(color, 1.0)


def picture(truth: Truth, values: Floats, exposure: float = _SHOWN_AS) -> str:
    """Return the valid pixels of an image, made smaller by leaving out lines and columns."""
    step = -(-truth.mask.shape[1] // _WIDTH)
    shown = np.where(truth.mask[..., None], values, 0.0)[::step, ::step]
    return _as_uri(shown, exposure)


def _as_uri(values: Floats, exposure: float) -> str:
    """Return linear RGB as a PNG in a data URI; other numbers of bands are shown in grey."""
    if values.shape[-1] != 3:
        values = np.repeat(to_grey(values)[..., None], 3, axis=-1)
    png = encode_png(as_bytes(values, exposure))
    return "data:image/png;base64," + base64.b64encode(png).decode()
