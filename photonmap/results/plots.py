"""Plots of a result, by matplotlib."""

from __future__ import annotations

from numbers import Integral
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import is_banded, row_of
from photonmap.errors import InputError
from photonmap.results.colors import SCENE, Image, White
from photonmap.results.labels import Labels
from photonmap.results.preview import as_bytes
from photonmap.runtime.wording import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Plots(Labels):
    """What can be drawn of buffers; see `photonmap.Result`."""

    def standard_error(self, name: str) -> Image:
        """Return the standard error of the mean of a buffer."""
        raise NotImplementedError

    def plot(
        self, buffer: str = "radiance", axes: Axes | None = None, white: White = SCENE
    ) -> Axes:
        """Draw a buffer: in colour, at the exposure of the preview; or, without bands, as numbers.

        Parameters
        ----------
        buffer : its name
        axes : where to draw; None makes a new figure
        white : see `rgb`

        Raises
        ------
        InputError : there is no such buffer, or matplotlib is not installed
        """
        image, row = self._drawn(buffer), row_of(buffer)
        axes = axes or _new_axes()
        if not is_banded(buffer) and image.ndim == 3:
            axes.imshow(0.5 + 0.5 * image)  # directions
        elif image.ndim == 3:
            is_light = row is None or row.quantity == "radiance"
            exposure = self.exposure if is_light and "radiance" in self.buffers else 1.0
            axes.imshow(as_bytes(self.rgb(buffer, white=white), exposure))
        else:
            unit = "" if row is None else row.unit
            axes.figure.colorbar(axes.imshow(image), ax=axes, label=unit)
        axes.set_title(buffer)
        axes.set_axis_off()
        return axes

    def plot_spectrum(
        self, x: int, y: int, buffer: str = "radiance", axes: Axes | None = None
    ) -> Axes:
        """Plot a pixel's values over wavelength, with bars of one standard error.

        Parameters
        ----------
        x, y : column and row of the pixel, from the top left
        buffer : its name
        axes : where to draw; None makes a new figure

        Raises
        ------
        InputError : there is no such pixel or buffer, the buffer has no bands, or matplotlib is not
            installed
        """
        image, row = self._drawn(buffer), row_of(buffer)
        if image.ndim != 3 or not is_banded(buffer):
            raise InputError(f"{buffer!r} has no bands, and so no spectrum")
        height, width = image.shape[:2]
        whole = isinstance(x, Integral) and isinstance(y, Integral)
        if not (whole and 0 <= x < width and 0 <= y < height):
            pixel = f"({shown(x)}, {shown(y)})"
            raise InputError(f"there is no pixel {pixel} in an image of {width}x{height}")
        axes = axes or _new_axes()
        names = self.bands.names
        positions = np.arange(len(names)) if self.bands.is_rgb else self.wavelengths
        spread = self.standard_error(buffer)[y, x] if f"{buffer}.error" in self else None
        label = f"{buffer} ({x}, {y})"
        axes.errorbar(positions, image[y, x], spread, marker="o", capsize=3, label=label)
        if self.bands.is_rgb:
            axes.set_xticks(positions, names)
        else:
            axes.set_xlabel("wavelength (nm)")
        axes.set_ylabel("" if row is None else row.unit)
        axes.legend()
        return axes

    def _drawn(self, buffer: str) -> NDArray[Any]:
        if buffer not in self.buffers:
            raise InputError(self._missing(buffer))
        return self.buffers[buffer]


def _new_axes() -> Axes:
    try:
        from matplotlib import pyplot
    except ImportError:
        raise InputError("plots need matplotlib: pip install 'photonmap[plot]'") from None
    return pyplot.subplots()[1]
