"""What a render returns: buffers, their standard errors, and the record of the run."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import BUFFERS, BY_NAME, is_banded, is_omitted, row_of, split_name
from photonmap.errors import InputError
from photonmap.film.bias import BlockBias
from photonmap.film.blocks import SIDE, block_means, block_minima
from photonmap.film.budget import share_on_edges
from photonmap.film.variance_smoothing import (
    BLOCK_PRIOR,
    degrees_of_freedom,
    prior_of,
    smooth_error,
    widen_ratio,
)
from photonmap.io.exr import Contents, name_errors, read_exr, write_exr, write_layers
from photonmap.io.png import encode_png
from photonmap.results.colors import SCENE, Image, White
from photonmap.results.files import save_all
from photonmap.results.labels import Arrays, Groups
from photonmap.results.plots import Plots
from photonmap.runtime.options import read_list
from photonmap.runtime.wording import listed, shown
from photonmap.runtime.writing import replacing_target
from photonmap.spectra.bands import Bands


@dataclass(eq=False, repr=False)
class Result(Plots):
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

    def __post_init__(self) -> None:
        """Take lists for arrays; raise `InputError` unless all images go together."""
        self.buffers = _as_images(self.buffers, "buffer")
        self.errors = _as_images(self.errors, "error")
        self.block_errors = _as_images(self.block_errors, "block error")
        _check_shapes(self.buffers, self.errors, self.block_errors, self.bands)
        if not isinstance(self.record, dict):
            raise InputError(f"record {shown(self.record)} is no dictionary; {{}} for none")
        self.record = _as_record(self.record)

    def __repr__(self) -> str:
        width, height = self.size
        kind = "RGB" if self.bands.is_rgb else f"{self.bands.count} bands"
        return f"<Result {width} × {height}, {kind}: {', '.join(self.buffers)}>"

    def _repr_png_(self) -> bytes | None:
        """Return the preview for Jupyter, or None without `radiance`."""
        return encode_png(self.preview()) if "radiance" in self.buffers else None

    def _buffer(self, name: str) -> NDArray[Any]:
        """Return a buffer, also what it is where it is left out; `AttributeError` if not kept."""
        if name in self.buffers:
            return self.buffers[name]
        kept = self.record.get("arguments", {}).get("buffers")
        if not is_omitted(name) or (kept is not None and name not in kept):
            raise AttributeError(self._missing(name))
        if (source := BY_NAME[split_name(name)[0]].then) != "0":
            return self._buffer(source)
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
    def per_light(self) -> Groups:
        """The buffers split by light group: group to name to image, (H, W, N) float32.

        `direct`, `indirect`, `shading`, and `caustics` and `fluorescence` where there are any; the
        whole buffers are their sums in this order. Empty unless the render was asked to split them.
        Lights that are off, 0 in every band, are not rendered and have no group. Standard errors go
        by names as in "direct@sun".
        """
        split = Groups()
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

        With Student's t of `degrees_of_freedom`, its intervals hold the truth as often as they
        state. It is that of `errors`, from each pixel's own replicates of passes, smoothed by its
        neighbours: see `photonmap.film.replicates` and `variance_smoothing`.

        Raises
        ------
        InputError : there is none, saying why
        """
        self._check_error(name)
        counts = self.buffers.get("passes", self.record.get("passes", 2))
        is_center = self.record.get("arguments", {}).get("pixel") == "center"
        edges = 0.0 if is_center else share_on_edges(self.record.get("pass_samples", 1.0))
        emission = self.buffers.get("emission") if name == "radiance" else None
        emits = None if emission is None else emission.max(axis=-1) > 0.0
        prior = prior_of(split_name(name)[0])
        error = smooth_error(self.errors[name], self.buffers[name], counts, prior, edges, emits)
        if name.startswith("shading") and "reflectance" in self.errors:
            of_reflectance = smooth_error(self.errors["reflectance"], self.reflectance, counts)
            error = widen_ratio(error, self.buffers[name], self.reflectance, of_reflectance)
        return error

    def _check_error(self, name: str) -> None:
        """Raise an `InputError` that says why a buffer has no standard error, if so."""
        if name in self.errors:
            return
        if name not in self.buffers:
            raise InputError(self._missing(name))
        if self.errors:
            raise InputError(f"{name!r} has no standard error; {listed(self.errors, 99)} have one")
        raise InputError("a single pass has no standard errors; render with 2 passes or more")

    def degrees_of_freedom(self, name: str) -> NDArray[np.float64]:
        """Return those of Student's t that the `standard_error` of a buffer has: (H, W) or ().

        More than those of a pixel's passes, since its neighbours say how certain it is, too: of
        radiance 9 after 4 passes, 20 after 16.

        Raises
        ------
        InputError : there is no standard error, saying why
        """
        self._check_error(name)
        passes = self.buffers.get("passes", self.record.get("passes", 2))
        return degrees_of_freedom(split_name(name)[0], passes)

    def block_mean(self, name: str) -> Image:
        """Return the means of a buffer over blocks of 8×8 pixels: (⌈H / 8⌉, ⌈W / 8⌉, …) float32.

        Raises
        ------
        InputError : there is no such buffer
        """
        if name not in self.buffers:
            raise InputError(self._missing(name))
        return block_means(self.buffers[name], SIDE).astype(np.float32)

    def block_error(self, name: str) -> Image:
        """Return the standard error of `block_mean`: (⌈H / 8⌉, ⌈W / 8⌉, N) float32.

        Smoothed by the neighbours as `standard_error` is; `photonmap.film.blocks` says of
        which buffers, and why it does not follow from the errors of pixels.

        Raises
        ------
        InputError : there is none, saying why
        """
        if name in self.block_errors:
            counts = self.buffers.get("passes", np.array([[self.record.get("passes", 2)]]))
            error, mean = self.block_errors[name], self.block_mean(name)
            return smooth_error(error, mean, block_minima(counts, SIDE), BLOCK_PRIOR)
        if name not in self.buffers:
            raise InputError(self._missing(name))
        known = listed(self.block_errors)
        which = f"there is one of {known}" if known else "after a single pass there is none"
        raise InputError(f"{name!r} has no standard error of blocks: {which}")

    def bias(self, name: str) -> BlockBias:
        """Return the estimated bias of a buffer as an image of blocks, which are stated with it.

        `value` is estimate − truth, and `error` its standard error, both (rows, columns) float32 in
        the unit of radiance, means over bands. Cells, footprints and disks bias indirect light
        alone; `photonmap.film.bias` says how it is estimated. A block's bias is worth a look where
        it is several times the errors around.

        Raises
        ------
        InputError : it is another buffer than radiance, direct and indirect; or was not estimated,
            as of renders that have none
        """
        if name not in ("radiance", "direct", "indirect"):
            raise InputError(f"the bias of {name!r} is not estimated; that of 'indirect' is")
        described = self.record.get("bias_blocks")
        if described is None and self.record.get("bias") == 0.0:
            raise InputError("this render has no bias")
        if described is None and "relit" in self.record:
            raise InputError("the bias of relit light is not known; that of the render is")
        if described is None:
            raise InputError("the bias was not estimated; photon mapping of 14 passes or more does")
        blocks = BlockBias.read(described)
        if name == "direct":
            nothing = np.zeros_like(blocks.value)
            return blocks._replace(value=nothing, error=nothing)
        return blocks

    def interval(self, name: str, level: float = 0.95) -> tuple[Image, Image]:
        """Return the bounds of a buffer, within which the truth lies with probability `level`.

        Lower and upper, of its shape, unit and type. They are sqrt(standard error² + b²) times
        Student's t apart from it, where b is the root mean square over the image of `bias`: of
        direct light, emission and reflectance none; of shading that of radiance by reflectance.

        Raises
        ------
        InputError : there is no standard error, or the bias is unknown, saying why; or the level is
            not between 0 and 1
        """
        from scipy import stats

        if not (isinstance(level, float) and 0.0 < level < 1.0):
            raise InputError(f"level {shown(level)} is no probability; give one as in 0.95")
        error, bias = self.standard_error(name).astype(np.float64), 0.0
        base, _ = split_name(name)
        unbiased = self.record.get("bias_blocks") is None and self.record.get("bias") == 0.0
        if base not in ("direct", "emission", "reflectance") and not unbiased:
            blocks = self.bias("radiance").value
            bias = float(np.sqrt(np.mean(blocks[blocks != 0.0] ** 2))) if blocks.any() else 0.0
        if base == "shading":
            bias = bias / np.maximum(self.reflectance, 1e-6)
        quantile = stats.t.ppf(0.5 + level / 2.0, self.degrees_of_freedom(name))
        apart = np.hypot(error, bias) * quantile[..., None]
        value = self.buffers[name]
        return (value - apart).astype(np.float32), (value + apart).astype(np.float32)

    def select(self, names: str | Iterable[str]) -> Result:
        """Return a `Result` of these buffers and their errors, which share their memory.

        A buffer that was left out because it is 0 is left out here too. A text holds one name, or
        several separated by commas.

        Raises
        ------
        InputError : one of them is missing, or there is none
        """
        names = read_list(names)
        missing = [name for name in names if name not in self.buffers and not is_omitted(name)]
        buffers = {name: self.buffers[name] for name in names if name in self.buffers}
        if missing or not buffers:
            missing = missing or names
            raise InputError(self._missing(missing[0]) if missing else "no buffer was chosen")
        errors = {name: self.errors[name] for name in names if name in self.errors}
        blocks = {name: self.block_errors[name] for name in names if name in self.block_errors}
        record = self.record
        if "arguments" in record:
            asked = sorted({split_name(name)[0] for name in names})
            record = record | {"arguments": record["arguments"] | {"buffers": asked}}
        return Result(buffers, errors, self.bands, record, blocks)

    def relit(self, gains: Mapping[str, float | Sequence[float] | Image]) -> Result:
        """Return what light groups of other strengths or spectra give: each times its gain.

        Direct light, indirect light, caustics, shading, the residual and radiance are of the new
        light, and so is the white of the scene, if the record knows that of each group. `emission`
        is not split, and stays. Errors of groups stay known, those of their sums where one group
        alone is lit or there are two: groups share samples, so errors of other sums, and that of
        radiance, are left out. So are bias and error in the record, which cannot be merged any
        more.

        Parameters
        ----------
        gains : by light group, a number of at least 0 or (N,), one for each band; 1 if left out

        Raises
        ------
        InputError : lights were not split, there is no such group, or a gain is something else; or
            it differs between bands, though surfaces fluoresce, which mixes them
        """
        from photonmap.results.relighting import relit

        return relit(self, gains)

    def save(
        self,
        path: str | PathLike[str],
        buffers: str | Iterable[str] | None = None,
        white: White = SCENE,
    ) -> None:
        """Write FILE.exr, a preview FILE.png and the record FILE.json: all of them or none.

        Without `radiance` there is no preview. The suffix may also be .nc or .hdf5 (which need
        `pip install 'photonmap[netcdf]'`), or .hdr or .img for ENVI; `load_result` reads .exr.

        Parameters
        ----------
        path : FILE.exr, or of another suffix
        buffers : names of those to write, with their errors and those of their light groups; None
            for all
        white : of the preview and of the R, G and B for viewers, see `rgb`

        Raises
        ------
        InputError : such files cannot be written to `path`, a buffer is missing, or there is no
            such white
        OSError : the disk is full or the like
        """
        chosen = self
        if buffers is not None:
            names = read_list(buffers)
            groups = [name for name in self.buffers if split_name(name)[0] in names]
            chosen = self.select(dict.fromkeys([*names, *groups]))
        preview = partial(self.shown, white) if "radiance" in self.buffers else None
        save_all(chosen._contents, path, self.projector(white), preview)

    def save_exr(self, path: str | PathLike[str], halves: Collection[str] = ()) -> None:
        """Write the OpenEXR alone: all buffers, their errors and the record.

        Parameters
        ----------
        path : of the file
        halves : names of `arrays` to write in half precision

        Raises
        ------
        OSError : writing fails
        """
        with replacing_target(path, sum(image.nbytes for image in self.arrays.values())) as draft:
            write_exr(self._contents, draft, self.projector(), halves)

    def save_layers(self, path: str | PathLike[str], white: White = SCENE) -> None:
        """Write all buffers as layers of one OpenEXR in linear sRGB, for compositors.

        Channels are named as in "photonmap.direct.R"; radiance is called Combined, and has
        `coverage` as its alpha; depth is called Depth. Errors are not written.

        Parameters
        ----------
        path : FILE.exr
        white : see `rgb`

        Raises
        ------
        InputError : the suffix is another one, or there is no such white
        OSError : writing fails
        """
        colors = {name: self.rgb(name, white=white) for name in self.buffers if is_banded(name)}
        others = {name: image for name, image in self.buffers.items() if not is_banded(name)}
        size = sum(image.nbytes for image in (*colors.values(), *others.values()))
        with replacing_target(path, size) as draft:
            write_layers(colors, others, draft)

    @property
    def _contents(self) -> Contents:
        return Contents(self.buffers, self.errors, self.bands, self.record, self.block_errors)


def _reader(name: str) -> property:
    """Return the property that reads a buffer."""
    return property(lambda result: result._buffer(name), doc=BY_NAME[name].summary)


for _name in BUFFERS:
    setattr(Result, _name, _reader(_name))


def _as_images(images: Mapping[str, Any], kind: str) -> Arrays:
    """Return images by name, lists among them as arrays; messages call one of them by its kind.

    An `InputError` says that they go by no names, or one is not numbers of shape (H, W) or (H, W,
    N).
    """
    if not isinstance(images, Mapping):
        raise InputError(f"{kind}s {shown(images)} go by no names; give arrays in a dictionary")
    return {name: _as_image(image, f"{kind} {shown(name)}") for name, image in images.items()}


def _as_image(image: Any, owner: str) -> NDArray[Any]:
    try:
        array = np.asanyarray(image)
    except ValueError:
        raise InputError(f"{owner} has lines of different lengths; make them equal") from None
    if array.dtype.kind not in "biuf":
        raise InputError(f"{owner} is of type {array.dtype}; give real numbers")
    if array.ndim not in (2, 3):
        raise InputError(f"{owner} has shape {array.shape}, not (H, W) or (H, W, N)")
    return array


def _check_shapes(buffers: Arrays, errors: Arrays, block_errors: Arrays, bands: Bands) -> None:
    """Raise `InputError` unless all images are of one size and have all bands.

    Errors have the shape of their buffer, where there is one; those of blocks a value for each.
    """
    if not isinstance(bands, Bands):
        raise InputError(f"bands {shown(bands)} are no photonmap.Bands; take Bands.parse(…)")
    if not buffers:
        raise InputError("a result of no buffers; give one or more images by name")
    first, image = next(iter(buffers.items()))
    size = image.shape[:2]
    blocks = tuple(-(-side // SIDE) for side in size)
    for kind, images, sides in (
        ("buffer", buffers, size),
        ("error", errors, size),
        ("block error", block_errors, blocks),
    ):
        for name, other in images.items():
            row, own = row_of(name), buffers.get(name, other)
            banded = row is not None and row.is_banded
            wanted = (*sides, *((bands.count,) if banded else own.shape[2:]))
            if other.shape != wanted:
                found = f"{kind} {name!r} has shape {other.shape}"
                raise InputError(f"{found}, not {wanted} as {first!r}")


def _as_record(value: Any) -> Any:
    """Return a record in plain Python types; what JSON cannot hold is an `InputError`."""
    if value is None or type(value) in (str, int, float, bool):
        return value
    if isinstance(value, np.generic | np.ndarray):
        return _as_record(value.tolist())
    if isinstance(value, Mapping):
        return {name: _as_record(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_as_record(each) for each in value]
    if isinstance(value, str | int | float):
        return value
    raise InputError(f"the record has {shown(value)}, which JSON cannot hold; leave it out")


def check_result(result: object) -> Result:
    """Return a result; anything else is an `InputError`."""
    if isinstance(result, Result):
        return result
    is_file = isinstance(result, str | PathLike)
    remedy = "read it by photonmap.load_result" if is_file else "give what photonmap.render returns"
    raise InputError(f"{shown(result)} is not a result; {remedy}")


def load_result(path: str | PathLike[str]) -> Result:
    """Read what `Result.save` wrote to FILE.exr, bit for bit.

    Raises
    ------
    InputError : there is no such file, or it was not written by photonmap
    """
    if not isinstance(path, str | PathLike):
        raise InputError(f"{shown(path)} is not the name of a file; give the FILE.exr of a render")
    return Result(*read_exr(path))
