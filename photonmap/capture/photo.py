"""A photo: raw numbers, what they were before noise, and how they are developed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.capture.demosaic import demosaic
from photonmap.capture.mosaic import Pattern
from photonmap.kernels.core.color import LUMINANCE
from photonmap.results.preview import as_bytes

Image = NDArray[np.float32]

_FADES = 0.8
"""Fraction of saturation from which on colours are not trusted."""


@dataclass(eq=False)
class Photo:
    """What a sensor recorded of a render. H, W and C are height, width and the number of channels.

    Parameters
    ----------
    raw : (H, W) uint16 of a mosaic, (H, W, C) without one; the numbers of the converter
    truth : (H, W, C) float32: what all channels of all pixels would give without noise, saturation
        and rounding; 0 is no light, 1 the white level
    record : JSON-able: sensor, channels, mosaic, exposure, black and white level, colours
    """

    raw: NDArray[np.uint16]
    truth: Image
    record: dict[str, Any]

    def __repr__(self) -> str:
        height, width, channels = self.truth.shape
        return f"<Photo {width} × {height}, {channels} channels, {self.record['time_s']:.3g} s>"

    @property
    def pattern(self) -> Pattern | None:
        """The channel of each filter of the mosaic, from 0; None without a mosaic."""
        rows = self.record["mosaic"]
        return None if rows is None else np.array(rows, np.intp)

    @property
    def linear(self) -> Image:
        """The raw numbers less black and the mean dark signal, 1 at the white level, as `raw`."""
        black, white = self.record["black"], self.record["white"]
        return ((self.raw - black) / (white - black)).astype(np.float32)

    @cached_property
    def demosaiced(self) -> Image:
        """(H, W, C) float32 in the unit of `truth`, which it estimates: the camera's colours."""
        pattern, linear = self.pattern, self.linear
        if pattern is None:
            return linear
        method = self.record["sensor"]["demosaic"]
        channels = self.truth.shape[2]
        return demosaic(linear.astype(np.float64), pattern, channels, method).astype(np.float32)

    def rgb(self, image: Image | None = None) -> Image:
        """Return an image in linear sRGB: (H, W, 3) float32; `demosaiced` by default.

        White-balanced, by the record's matrix; where a channel saturates, colour fades to white.

        Parameters
        ----------
        image : (H, W, C) in the camera's colours, such as `truth`
        """
        camera = self.demosaiced if image is None else image
        neutral = np.array(self.record["neutral"])
        full = camera.max(axis=-1, keepdims=True) / self.record["saturates_at"]
        fade = np.clip((full - _FADES) / (1.0 - _FADES), 0.0, 1.0)
        balanced = camera / neutral
        balanced += fade**2 * (3.0 - 2.0 * fade) * (balanced.max(axis=-1, keepdims=True) - balanced)
        return (balanced * neutral @ np.array(self.record["to_srgb"]).T).astype(np.float32)

    @cached_property
    def srgb(self) -> NDArray[np.uint8]:
        """(H, W, 3) uint8 sRGB: `rgb`, in which a white at the white level is 1, compressed.

        The compression is equation 4 of E. Reinhard et al., "Photographic tone reproduction for
        digital images", SIGGRAPH 2002, without its key: the largest luminance becomes 1, and an
        image that has none above 1 stays as it is.
        """
        image = self.rgb().astype(np.float64)
        white = np.array(self.record["to_srgb"]) @ np.array(self.record["neutral"])
        image /= float(np.array(LUMINANCE) @ white)
        luminance = np.maximum(image @ np.array(LUMINANCE), 0.0)
        most = max(float(luminance.max(initial=0.0)), 1.0)
        scale = (1.0 + luminance / most**2) / (1.0 + luminance)
        return as_bytes(image * scale[..., None], 1.0)
