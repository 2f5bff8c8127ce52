"""What a render returns: buffers, their standard errors, and the record of the run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import BUFFERS, BY_NAME, is_omitted, row_of, split_name
from photonmap.errors import InputError
from photonmap.film.block_errors import SIDE
from photonmap.film.blocks import block_means, block_minima
from photonmap.film.variance_smoothing import (
    BLOCK_PRIOR,
    PRIOR,
    PRIORS,
    smooth_error,
    widen_ratio,
)
from photonmap.io.exr import Contents, name_errors, read_exr, write_exr
from photonmap.io.png import encode_png
from photonmap.results.files import Preview, save_all
from photonmap.results.preview import as_bytes, choose_exposure
from photonmap.runtime.wording import listed
from photonmap.spectra.bands import Bands
from photonmap.spectra.projection import Method, Projection, Target, choose_projection

Image = NDArray[np.float32]


@dataclass(eq=False, repr=False)
class Result:
    """The images of one render, linear and scene-referred.

    H, W and N are the image's height and width and the number of bands. Every buffer is a property
    of its name, as in `result.shading`; `photonmap.buffers` lists them. Those that were asked for
    are present; reading another one raises AttributeError.

    Parameters
    ----------
    buffers : images by name
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

    def _missing(self, name: str) -> str:
        return f"{name!r} was not among the buffers written, which are {listed(self.buffers, 99)}"

    def _buffer(self, name: str) -> NDArray[Any]:
        """Return a buffer; zeros for one that is left out where it is 0 or there is none.

        Raises
        ------
        AttributeError
            if it was not kept
        """
        if name in self.buffers:
            return self.buffers[name]
        if not is_omitted(name):
            raise AttributeError(self._missing(name))
        width, height = self.size
        return np.zeros((height, width, self.bands.count), np.float32)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> NDArray[Any]:
            """Stand for the properties that are added below, one for each buffer."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        height, width = next(iter(self.buffers.values())).shape[:2]
        return width, height

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All buffers and errors by their names in files: "direct", "direct.error", and so on."""
        return self.buffers | name_errors(self.errors, self.block_errors)

    @property
    def per_light(self) -> dict[str, dict[str, Image]]:
        """The buffers split by light group: group to name to image, (H, W, N) float32.

        `direct`, `indirect`, `shading`, and `caustics` where there are any; the whole buffers are
        their sums in this order. Empty unless the render was asked to split them. Standard errors
        go by names as in "direct@sun".
        """
        split: dict[str, dict[str, Image]] = {}
        for name, image in self.buffers.items():
            (buffer, group), row = split_name(name), row_of(name)
            if group and row is not None and row.has_error:
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

        With Student's t of one degree of freedom less than passes, its intervals hold the truth as
        often as they state. It is that of `errors`, from each pixel's own passes, smoothed by its
        neighbours: see `photonmap.film.variance_smoothing`.

        Raises
        ------
        ValueError
            if there is none, saying why
        """
        if name in self.errors:
            return self._smoothed_error(name)
        if name not in self.buffers:
            raise ValueError(self._missing(name))
        if self.errors:
            raise ValueError(f"{name!r} has no standard error; {listed(self.errors, 99)} have one")
        raise ValueError("a single pass has no standard errors; render with 2 passes or more")

    def _smoothed_error(self, name: str) -> Image:
        counts = self.buffers.get("passes", self.record.get("passes", 2))
        prior = PRIORS.get(split_name(name)[0], PRIOR)
        edges = self.record.get("arguments", {}).get("pixel") != "center"
        error = smooth_error(self.errors[name], self.buffers[name], counts, prior, edges)
        if name.startswith("shading") and "reflectance" in self.errors:
            of_reflectance = smooth_error(self.errors["reflectance"], self.reflectance, counts)
            error = widen_ratio(error, self.reflectance, of_reflectance)
        return error

    def block_mean(self, name: str) -> Image:
        """Return the means of a buffer over blocks of 8×8 pixels: (⌈H / 8⌉, ⌈W / 8⌉, …) float32.

        Raises
        ------
        ValueError
            if there is no such buffer
        """
        if name not in self.buffers:
            raise ValueError(self._missing(name))
        return block_means(self.buffers[name], SIDE).astype(np.float32)

    def block_error(self, name: str) -> Image:
        """Return the standard error of `block_mean`: (⌈H / 8⌉, ⌈W / 8⌉, N) float32.

        Smoothed by the neighbours as `standard_error` is; `photonmap.film.block_errors` says of
        which buffers, and why it does not follow from the errors of pixels.

        Raises
        ------
        ValueError
            if there is none, saying why
        """
        if name in self.block_errors:
            counts = self.buffers.get("passes", np.array([[self.record.get("passes", 2)]]))
            error, mean = self.block_errors[name], self.block_mean(name)
            return smooth_error(error, mean, block_minima(counts, SIDE), BLOCK_PRIOR)
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
            `photonmap.spectra.projection.fit_projection` makes one for any others. None is
            "primaries" if all colours of the scene are RGB or constant, else "direct".

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
        image, row = self.buffers[buffer], row_of(buffer)
        if image.ndim != 3 or (row is not None and not row.is_banded):
            raise ValueError(f"{buffer!r} has no bands, and so no colour")
        matrix = self.projection(target, method).matrix.T
        if row is not None and row.quantity == "reflectance":
            matrix = matrix / matrix.sum(axis=0)
        return _project_lines(image, matrix)

    @property
    def exposure(self) -> float:
        """The factor `preview` applies: the 99th percentile of the luminance becomes 0.8.

        Of the pixels that are not black; and not emissive, unless all the others are black. 1 if
        there is none.
        """
        return choose_exposure(self._projected("radiance"), self.buffers.get("emission"))

    def preview(self, exposure: float | None = None) -> NDArray[np.uint8]:
        """Return `radiance` × exposure, clamped to [0, 1], as 8-bit sRGB: (H, W, 3) uint8.

        Parameters
        ----------
        exposure : None takes the image's own; another image's makes the two comparable
        """
        exposure = self.exposure if exposure is None else exposure
        return as_bytes(self._projected("radiance"), exposure)

    def select(self, names: Iterable[str]) -> Result:
        """Return a `Result` of these buffers and their errors, which share their memory.

        A buffer that was left out because it is 0 is left out here too.

        Raises
        ------
        InputError
            if one of them is missing, or there is none
        """
        names = list(names)
        missing = [name for name in names if name not in self.buffers and not is_omitted(name)]
        buffers = {name: self.buffers[name] for name in names if name in self.buffers}
        if missing or not buffers:
            missing = missing or names
            raise InputError(self._missing(missing[0]) if missing else "no buffer was chosen")
        errors = {name: self.errors[name] for name in names if name in self.errors}
        blocks = {name: self.block_errors[name] for name in names if name in self.block_errors}
        return Result(buffers, errors, self.bands, self.record, blocks)

    def save(self, path: str | PathLike[str], buffers: Iterable[str] | None = None) -> None:
        """Write FILE.exr, a preview FILE.png and the record FILE.json: all of them or none.

        Without `radiance` there is no preview.

        Parameters
        ----------
        path : FILE.exr
        buffers : names of those to write, with their errors; None for all

        Raises
        ------
        InputError
            if such files cannot be written to `path`, or a buffer is missing
        OSError
            if the disk is full or the like
        """
        chosen = self if buffers is None else self.select(buffers)
        preview = self._shown if "radiance" in self.buffers else None
        save_all(chosen._contents, path, self._to_rgb, preview)

    def save_exr(self, path: str | PathLike[str]) -> None:
        """Write the OpenEXR alone: all buffers, their errors and the record.

        Raises
        ------
        OSError
            if writing fails
        """
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        write_exr(self._contents, path, self._to_rgb)

    @property
    def _contents(self) -> Contents:
        return Contents(self.buffers, self.errors, self.bands, self.record, self.block_errors)

    def _to_rgb(self, lines: NDArray[Any]) -> Image:
        """Project lines of radiance, (h, W, N), onto linear sRGB."""
        return np.stack([*_project_lines(lines, self.projection().matrix.T)])

    def _shown(self) -> Preview:
        exposure = self.exposure
        return Preview(self.preview(exposure), exposure)


def _project_lines(image: NDArray[Any], matrix: NDArray[Any]) -> Iterator[NDArray[np.float32]]:
    """Project an image (H, W, N) by a matrix (N, T) line by line; bound it by float32's range."""
    most = np.finfo(np.float32).max
    for row in image:
        yield np.clip(row @ matrix, -most, most).astype(np.float32)


def _reader(name: str) -> property:
    """Return the property that reads a buffer."""
    return property(lambda result: result._buffer(name), doc=BY_NAME[name].summary)


for _name in BUFFERS:
    setattr(Result, _name, _reader(_name))


def load_result(path: str | PathLike[str]) -> Result:
    """Read what `Result.save` wrote to FILE.exr, bit for bit.

    Raises
    ------
    InputError
        if there is no such file, or it was not written by photonmap
    """
    return Result(*read_exr(path))
