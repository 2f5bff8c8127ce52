"""How a result is seen: in linear sRGB, in XYZ, by other sensors, and as a preview."""

from __future__ import annotations

from collections.abc import Iterator
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import is_banded, names_where, row_of
from photonmap.errors import InputError
from photonmap.io.exr import Projector
from photonmap.results.preview import Preview, as_bytes, choose_exposure
from photonmap.runtime.wording import suggest
from photonmap.spectra.bands import Bands
from photonmap.spectra.color_text import emission
from photonmap.spectra.curves import Color
from photonmap.spectra.observer import adapt_to_d65, observer
from photonmap.spectra.photometry import (
    corrected_weights,
    luminance_weights,
    warn_of_luminance,
)
from photonmap.spectra.projection import (
    Method,
    Projection,
    Target,
    choose_projection,
    default_method,
)

Image = NDArray[np.float32]
White = Color | str
"""`SCENE`, or a light as a colour or as text."""

_EFFICACY = 683.002
"""lm·W⁻¹, K_m: the luminous efficacy at 555 nm for photopic vision."""
SCENE, AS_IT_IS = "scene", "D65"
"""As a white: all lights of the scene together; that of sRGB, to which nothing is adapted."""


class Colors:
    """What can be seen of buffers in bands; see `photonmap.Result`."""

    buffers: dict[str, NDArray[Any]]
    bands: Bands
    record: dict[str, Any]

    def rgb(
        self, buffer: str = "radiance", method: Method | None = None, white: White = SCENE
    ) -> Image:
        """Project a buffer onto linear sRGB: (H, W, 3) float32, in the buffer's unit.

        Radiances and shading are projected by one matrix, adapted so that `white` is white;
        reflectance by the same under equal-energy white, so that a perfect diffuser is (1, 1, 1).
        Projection does not commute with products. Colours out of gamut are negative; what exceeds
        float32 is its largest.

        Parameters
        ----------
        buffer : its name
        method : see `projection`
        white : see `adaptation`; "D65" leaves colours as they are

        Raises
        ------
        InputError : there is no such buffer, or it has no bands; or no such method or white; or the
            file is in another RGB than linear sRGB, as `rgb.exr` of data sets is
        """
        return np.stack([*self._projected(buffer, "rgb", method, white)])

    def xyz(self, buffer: str = "radiance", method: Method | None = None) -> Image:
        """Project a buffer onto CIE 1931 XYZ: (H, W, 3) float32, as `rgb` with white "D65"."""
        return np.stack([*self._projected(buffer, "xyz", method)])

    def luminance(self, buffer: str = "radiance", method: Method | None = None) -> Image:
        """Return the luminance of a buffer of radiances: (H, W) float32, cd·m⁻².

        683.002 lm·W⁻¹ × ∫ L V dλ with V = ȳ of the CIE 1931 observer (CIE S 017). The spectra of
        lights count as W·m⁻²·sr⁻¹·nm⁻¹. In scenes whose lights are given in photometric units
        already, as in many glTF files, Y of `xyz` is the luminance. Without a method the weights of
        bands are corrected, so that each light of the scene, and grey surfaces under it, have their
        exact luminance; `light_luminance` of the record states each light's error before and after,
        and above 2% a warning does.

        Parameters
        ----------
        buffer, method : as for `rgb`

        Raises
        ------
        InputError : there is no such buffer or method, or the buffer's unit is not that of a
            radiance
        """
        row = row_of(buffer)
        if row is not None and row.quantity != "radiance":
            raise InputError(f"{buffer!r} is no radiance, and so has no luminance")
        self._check_colored(buffer)
        weights = luminance_weights(self.bands, method or self._method)
        if method is None and (lights := self.record.get("light_luminance")):
            warn_of_luminance(lights)
            weights = corrected_weights(weights, lights)
        scaled = _EFFICACY * observer().efficiency * weights[:, None]
        return np.stack([*_project_lines(self.buffers[buffer], scaled)])[..., 0]

    def illuminance(self, method: Method | None = None) -> Image:
        """Return the illuminance of the surface seen: (H, W) float32, lx.

        π × `luminance` of `shading`, which is irradiance / π; for lights in W·m⁻²·sr⁻¹·nm⁻¹.

        Raises
        ------
        InputError : as `luminance` does
        """
        return (np.float32(np.pi) * self.luminance("shading", method)).astype(np.float32)

    def to_sensor(
        self,
        curves: Bands | str | PathLike[str],
        buffer: str = "radiance",
        method: Method | None = None,
    ) -> Image:
        """Return what another sensor sees of a buffer: (H, W, T) float32, band averages.

        Parameters
        ----------
        curves : `Bands`, or what `Bands.parse` takes: a FILE.csv, the name of a camera, a number
        buffer, method : as for `rgb`

        Raises
        ------
        InputError : as `rgb` does; or if there are no such curves
        """
        return np.stack([*self._projected(buffer, Bands.parse(curves), method)])

    def projection(self, target: Target = "rgb", method: Method | None = None) -> Projection:
        """Return the matrix by which the bands of radiances are projected, and its residual.

        Parameters
        ----------
        target : "rgb", "xyz" or `Bands`
        method : "direct" integrates the smoothest spectra that have these band values.
            "primaries" corrects it so that RGB emission, and RGB surfaces under D65, return to
            their RGB. "regression" is the fit to Munsell chips under equal energy, D65 and A;
            `photonmap.spectra.projection.fit_projection` makes one for any others. None is
            "primaries" if all colours of the scene are RGB or constant, else "direct".

        Raises
        ------
        InputError : there is no such target or method
        """
        return choose_projection(self.bands, target, method or self._method)

    @property
    def _method(self) -> Method:
        """The method of `projection` unless another is given."""
        return default_method(self.record.get("scene", {}).get("spectra", False))

    def adaptation(self, white: White = SCENE, method: Method | None = None) -> NDArray[np.float64]:
        """Return the matrix that `rgb` applies after `projection`, so that a light is white.

        Parameters
        ----------
        white : "scene" for all lights of the scene together; or a light, as a colour, or as text
            that `photonmap.emission` takes: "D65" for none
        method : see `projection`

        Returns
        -------
        (3, 3) float64 for linear sRGB, see `photonmap.spectra.observer`

        Raises
        ------
        InputError : there is no such light
        """
        values = None
        if not isinstance(white, str):
            values = self.bands.emission(white)
        elif white == SCENE:
            values = self.record.get("white")
        elif white != AS_IT_IS:
            values = self.bands.emission(emission(white))
        if values is None:
            return np.eye(3)
        return adapt_to_d65(self.projection("rgb", method).matrix @ values)

    def projector(self, white: White = SCENE) -> Projector:
        """Return what projects lines of radiance, (h, W, N), onto linear sRGB, as `rgb` does."""
        matrix = (self.adaptation(white) @ self.projection().matrix).T
        return lambda lines: np.stack([*_project_lines(lines, matrix)])

    @property
    def exposure(self) -> float:
        """The factor `preview` applies: the 99th percentile of the luminance becomes 0.8.

        Of the pixels that are not black; and not emissive, unless all the others are black. 1 if
        there is none.
        """
        return self._exposure(SCENE)

    def _exposure(self, white: White) -> float:
        lines = self._projected("radiance", white=white)
        return choose_exposure(lines, self.buffers.get("emission"))

    def preview(self, exposure: float | None = None, white: White = SCENE) -> NDArray[np.uint8]:
        """Return `radiance` × exposure, clamped to [0, 1], as 8-bit sRGB: (H, W, 3) uint8.

        Parameters
        ----------
        exposure : None takes the image's own; another image's makes the two comparable
        white : as for `rgb`
        """
        exposure = self._exposure(white) if exposure is None else exposure
        return as_bytes(self._projected("radiance", white=white), exposure)

    def shown(self, white: White = SCENE) -> Preview:
        """Return the preview and its exposure."""
        exposure = self._exposure(white)
        return Preview(self.preview(exposure, white), exposure)

    def _projected(
        self,
        buffer: str,
        target: Target = "rgb",
        method: Method | None = None,
        white: White | None = None,
    ) -> Iterator[NDArray[np.float32]]:
        """Project line by line: (W, T) each. This spares copies of whole images."""
        self._check_colored(buffer)
        image, row = self.buffers[buffer], row_of(buffer)
        matrix = self.projection(target, method).matrix
        if row is not None and row.quantity == "reflectance":
            matrix = matrix / matrix.sum(axis=1, keepdims=True)
        elif white is not None:
            matrix = self.adaptation(white, method) @ matrix
        return _project_lines(image, matrix.T)

    def _check_colored(self, buffer: str) -> None:
        if buffer not in self.buffers:
            raise InputError(self._missing(buffer))
        if self.buffers[buffer].ndim != 3 or not is_banded(buffer):
            raise InputError(f"{buffer!r} has no bands, and so no colour")
        if space := self.record.get("rgb_space"):
            raise InputError(
                f"this is red, green and blue of {space}, not of sRGB; take the image in its bands"
            )

    def _missing(self, name: str) -> str:
        absent = set(names_where(kept="all", omitted="never")) - {*self.buffers}
        if absent == {name} == {"distance"}:
            return (
                "'distance' is not here: this was written before it was separated from 'depth', "
                "which holds the distance along the camera's ray"
            )
        row = row_of(name)
        if row is not None and row.source == "data set":
            own = f", or take result.{name}" if hasattr(type(self), name) else ""
            return f"{name!r} is a buffer of data sets; dataset.with_derived adds it{own}"
        return f"{name!r} was not among the buffers written; {suggest(name, self.buffers)}"


def _project_lines(image: NDArray[Any], matrix: NDArray[Any]) -> Iterator[NDArray[np.float32]]:
    """Project an image (H, W, N) by a matrix (N, T) line by line; bound it by float32's range."""
    most = np.finfo(np.float32).max
    for row in image:
        yield np.clip(row @ matrix, -most, most).astype(np.float32)
