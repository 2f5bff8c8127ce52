"""What a render returns: buffers, their standard errors, and the record of the run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.bands import Bands
from photonmap.block_errors import block_means, block_minima
from photonmap.errors import InputError
from photonmap.messages import listed
from photonmap.output import encode_png, read_exr, save_all
from photonmap.preview import as_bytes, choose_exposure
from photonmap.projection import Method, Projection, Target, choose_projection
from photonmap.steady import PRIOR, PRIORS, steady_error, widen_ratio

Image = NDArray[np.float32]
Ids = NDArray[np.uint32]


@dataclass(eq=False, repr=False)
class Result:
    """The images of one render, linear and scene-referred.

    H, W and N are the image's height and width and the number of bands. Of the buffers below,
    those that were asked for are present; reading another one raises AttributeError.

    Parameters
    ----------
    buffers : images by name, as the properties below describe them
    errors : standard errors of the mean by the name of their buffer, in its shape, unit and type;
        empty after a single pass
    bands : what the last axis of (H, W, N) counts
    record : how the images came about, JSON-able
    block_errors : standard errors of the means over blocks of 8×8 pixels, by the name of their
        buffer, (⌈H / 8⌉, ⌈W / 8⌉, N) float32
    """

    buffers: dict[str, NDArray[Any]]
    errors: dict[str, NDArray[Any]]
    bands: Bands
    record: dict[str, Any]
    block_errors: dict[str, NDArray[Any]] = field(default_factory=dict)

    def __repr__(self) -> str:
        width, height = self.size
        kind = "RGB" if self.bands.is_rgb else f"{self.bands.count} bands"
        return f"<Result {width} × {height}, {kind}: {', '.join(self.buffers)}>"

    def _repr_png_(self) -> bytes | None:
        """Return the preview for Jupyter, or None without `radiance`."""
        return encode_png(self.preview()) if "radiance" in self.buffers else None

    def _buffer(self, name: str) -> NDArray[Any]:
        """Return a buffer, or raise AttributeError if there is none of this name."""
        if name not in self.buffers:
            raise AttributeError(self._missing(name))
        return self.buffers[name]

    def _or_zeros(self, name: str) -> Image:
        """Return a buffer with bands, or zeros in its place."""
        if name in self.buffers:
            return self.buffers[name]
        width, height = self.size
        return np.zeros((height, width, self.bands.count), np.float32)

    def _missing(self, name: str) -> str:
        return f"{name!r} was not among the buffers written, which are {listed(self.buffers, 99)}"

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        height, width = next(iter(self.buffers.values())).shape[:2]
        return width, height

    @property
    def radiance(self) -> Image:
        """(H, W, N) float32, W·m⁻²·sr⁻¹: what the camera sees, (emission + direct) + indirect."""
        return self._buffer("radiance")

    @property
    def emission(self) -> Image:
        """(H, W, N) float32, W·m⁻²·sr⁻¹: light sources and the background, seen directly."""
        return self._buffer("emission")

    @property
    def direct(self) -> Image:
        """(H, W, N) float32, W·m⁻²·sr⁻¹: light reflected once, straight from an emitter."""
        return self._buffer("direct")

    @property
    def indirect(self) -> Image:
        """(H, W, N) float32, W·m⁻²·sr⁻¹: light that met other surfaces before the one seen."""
        return self._buffer("indirect")

    @property
    def caustics(self) -> Image:
        """(H, W, N) float32, W·m⁻²·sr⁻¹: light that smooth surfaces alone sent; part of indirect.

        In a scene of diffuse surfaces alone it is exactly 0, and not written.
        """
        return self._or_zeros("caustics")

    @property
    def reflectance(self) -> Image:
        """(H, W, N) float32 in [0, 1]: diffuse albedo of the surface seen."""
        return self._buffer("reflectance")

    @property
    def shading(self) -> Image:
        """(H, W, N) float32, W·m⁻²·sr⁻¹: irradiance / π, also where the reflectance is 0."""
        return self._buffer("shading")

    @property
    def coverage(self) -> Image:
        """(H, W) float32 in [0, 1]: the fraction of the pixel that shows a surface."""
        return self._buffer("coverage")

    @property
    def unresolved(self) -> NDArray[np.bool_]:
        """(H, W) bool: no photon was found for the indirect light, although some were stored."""
        return self._buffer("unresolved")

    @property
    def passes(self) -> Ids:
        """(H, W) uint32: the number of passes that the pixel's means are over."""
        return self._buffer("passes")

    @property
    def depth(self) -> Image:
        """(H, W) float32, scene units: distance to the surface at the pixel's centre, or 0."""
        return self._buffer("depth")

    @property
    def normal(self) -> Image:
        """(H, W, 3) float32: world-space unit normal towards the camera at the centre, or 0."""
        return self._buffer("normal")

    @property
    def object_id(self) -> Ids:
        """(H, W) uint32: the object at the pixel's centre, from 1; 0 for the background."""
        return self._buffer("object_id")

    @property
    def material_id(self) -> Ids:
        """(H, W) uint32: the material at the pixel's centre, from 1; 0 for the background."""
        return self._buffer("material_id")

    @property
    def residual(self) -> Image:
        """(H, W, N) float32, W·m⁻²·sr⁻¹: radiance − emission − reflectance × shading.

        All that is not Lambertian: what is seen in mirrors and through glass. In a scene of
        diffuse surfaces alone it is exactly 0, and not written.
        """
        return self._or_zeros("residual")

    @property
    def covariance(self) -> Image:
        """(H, W, N) float32, W·m⁻²·sr⁻¹: of the means of reflectance × shading and reflectance.

        What the error of shading needs besides those of both, where a pixel shows several
        reflectances. If it is exactly 0 everywhere, it is not written.
        """
        return self._or_zeros("covariance")

    @property
    def per_light(self) -> dict[str, dict[str, Image]]:
        """The buffers split by groups of lights: group to name to image, (H, W, N) float32.

        `direct`, `indirect`, `shading`, and `caustics` where there are any; the whole buffers are
        their sums in this order. Empty unless the render was asked to split them. Standard errors
        go by names as in "direct@sun".
        """
        split: dict[str, dict[str, Image]] = {}
        for name, image in self.buffers.items():
            buffer, _, group = name.partition("@")
            if group and buffer != "covariance":
                split.setdefault(group, {})[buffer] = image
        return split

    @property
    def scalar_shading(self) -> Image:
        """(H, W) float32, W·m⁻²·sr⁻¹: the mean of `shading` over the bands."""
        return self.shading.mean(axis=-1, dtype=np.float64).astype(np.float32)

    @property
    def illuminant(self) -> np.ma.MaskedArray[Any, Any]:
        """(H, W, N) float32: the colour of the light, `shading` over its mean over the bands.

        A masked array: of band mean 1, and masked, with data 0, where no light arrives.
        """
        mean = self.shading.mean(axis=-1, keepdims=True, dtype=np.float64)
        dark = np.broadcast_to(mean == 0.0, self.shading.shape)
        data = np.divide(self.shading, mean, where=~dark, out=np.zeros(dark.shape))
        return np.ma.masked_array(data.astype(np.float32), mask=dark)

    def standard_error(self, name: str) -> Image:
        """Return the standard error of the mean of a buffer: its shape, unit and type.

        With Student's t of as many passes less one, its intervals hold the truth as often as they
        say. It is that of `errors`, which each pixel's own passes tell, steadied by neighbours:
        see `photonmap.steady`.

        Raises
        ------
        ValueError
            if there is none, saying why
        """
        if name in self.errors:
            return self._steady_error(name)
        if name not in self.buffers:
            raise ValueError(self._missing(name))
        if self.errors:
            raise ValueError(f"{name!r} has no standard error; {listed(self.errors, 99)} have one")
        raise ValueError("a single pass has no standard errors; render with 2 passes or more")

    def _steady_error(self, name: str) -> Image:
        counts = self.buffers.get("passes", self.record.get("passes", 2))
        prior = PRIORS.get(name.partition("@")[0], PRIOR)
        edges = self.record.get("arguments", {}).get("pixel") != "center"
        error = steady_error(self.errors[name], self.buffers[name], counts, prior, edges)
        if name.startswith("shading") and "reflectance" in self.errors:
            of_reflectance = steady_error(self.errors["reflectance"], self.reflectance, counts)
            error = widen_ratio(error, self.reflectance, of_reflectance)
        return error

    def block_mean(self, name: str) -> Image:
        """Return the means of a buffer over blocks of 8×8 pixels: (⌈H / 8⌉, ⌈W / 8⌉, …) float32.

        It raises ValueError if there is no such buffer.
        """
        if name not in self.buffers:
            raise ValueError(self._missing(name))
        return block_means(self.buffers[name]).astype(np.float32)

    def block_error(self, name: str) -> Image:
        """Return the standard error of `block_mean`: (⌈H / 8⌉, ⌈W / 8⌉, N) float32.

        Of `indirect` and `caustics`: see `photonmap.block_errors`. Steadied by neighbours as
        `standard_error` is; it raises ValueError as that does.
        """
        if name in self.block_errors:
            counts = self.buffers.get("passes", np.array([[self.record.get("passes", 2)]]))
            error, mean = self.block_errors[name], self.block_mean(name)
            return steady_error(error, mean, block_minima(counts))
        if name not in self.buffers:
            raise ValueError(self._missing(name))
        known = listed(self.block_errors) or "none, after a single pass,"
        raise ValueError(f"{name!r} has no standard error of blocks: {known} has one")

    def rgb(self, buffer: str = "radiance", method: Method | None = None) -> Image:
        """Project a buffer onto linear sRGB: (H, W, 3) float32, in the buffer's unit.

        Radiances and shading are projected by one matrix; reflectance by the same under
        equal-energy white, so that a perfect diffuser is (1, 1, 1). Projection does not commute
        with products. Colours out of gamut are negative; what exceeds float32 is its largest.

        Parameters
        ----------
        buffer : its name
        method : see `projection`

        Raises
        ------
        ValueError
            if there is no such buffer, or it has no bands; or no such method
        """
        return self._project(buffer, "rgb", method)

    def xyz(self, buffer: str = "radiance", method: Method | None = None) -> Image:
        """Project a buffer onto CIE 1931 XYZ: (H, W, 3) float32, as `rgb` does."""
        return self._project(buffer, "xyz", method)

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
        ValueError
            as `rgb` does; or if there are no such curves
        """
        return self._project(buffer, Bands.parse(curves), method)

    def projection(self, target: Target = "rgb", method: Method | None = None) -> Projection:
        """Return the matrix by which the bands of radiances are projected, and its residual.

        Parameters
        ----------
        target : "rgb", "xyz" or `Bands`
        method : "direct" integrates the smoothest spectra that have these band values.
            "primaries" corrects it so that RGB emission, and RGB surfaces under D65, return to
            their RGB. "regression" is the fit to Munsell chips under equal energy, D65 and A;
            `photonmap.projection.fit_projection` makes one for any others. None is "primaries" if
            all colours of the scene are RGB or constant, else "direct".

        Raises
        ------
        InputError
            if there is no such target or method
        """
        if method is None:
            spectra = self.record.get("scene", {}).get("spectra", False)
            method = "direct" if spectra else "primaries"
        return choose_projection(self.bands, target, method)

    def _project(self, buffer: str, target: Target, method: Method | None) -> Image:
        rows = self._projected(buffer, target, method)
        return np.stack([*rows])

    def _projected(
        self, buffer: str, target: Target = "rgb", method: Method | None = None
    ) -> Iterator[NDArray[np.float32]]:
        """Project line by line: (W, T) each. This spares copies of whole images."""
        if buffer not in self.buffers:
            raise ValueError(self._missing(buffer))
        image = self.buffers[buffer]
        if buffer == "normal" or image.ndim != 3:
            raise ValueError(f"{buffer!r} has no bands, and so no colour")
        matrix = self.projection(target, method).matrix.T
        if buffer == "reflectance":
            matrix = matrix / matrix.sum(axis=0)
        most = np.finfo(np.float32).max
        for row in image:
            yield np.clip(row @ matrix, -most, most).astype(np.float32)

    @property
    def exposure(self) -> float:
        """The factor `preview` applies: the 99th percentile of the luminance becomes 0.8.

        Of the pixels that are not black; and not emissive, unless all the others are black. 1 if
        there is none.
        """
        return choose_exposure(self._projected("radiance"), self.buffers.get("emission"))

    def preview(self, exposure: float | None = None) -> NDArray[np.uint8]:
        """Return `radiance` × exposure, cut to [0, 1], as 8-bit sRGB: (H, W, 3) uint8.

        Parameters
        ----------
        exposure : None takes the image's own; another image's makes the two comparable
        """
        exposure = self.exposure if exposure is None else exposure
        return as_bytes(self._projected("radiance"), exposure)

    def select(self, names: Iterable[str]) -> Result:
        """Return a `Result` of these buffers and their errors, which share their memory.

        Raises
        ------
        InputError
            if one of them is missing, or there is none
        """
        names = list(names)
        missing = [name for name in names if name not in self.buffers]
        if missing or not names:
            raise InputError(self._missing(missing[0]) if missing else "no buffer was chosen")
        buffers = {name: self.buffers[name] for name in names}
        errors = {name: self.errors[name] for name in names if name in self.errors}
        blocks = {name: self.block_errors[name] for name in names if name in self.block_errors}
        return Result(buffers, errors, self.bands, self.record, blocks)

    def save(self, path: str | PathLike[str], buffers: Iterable[str] | None = None) -> None:
        """Write FILE.exr, a preview FILE.png and the record FILE.json: all of them or none.

        Parameters
        ----------
        path : FILE.exr
        buffers : names of those to write, with their errors; None for all

        Raises
        ------
        InputError
            if `path` is no place for such files, or a buffer is missing
        OSError
            if the disk is full or the like
        """
        save_all(self, path, buffers)


def load_result(path: str | PathLike[str]) -> Result:
    """Read what `Result.save` wrote to FILE.exr, bit for bit.

    Raises
    ------
    InputError
        if there is no such file, or it was not written by photonmap
    """
    return Result(*read_exr(path))
