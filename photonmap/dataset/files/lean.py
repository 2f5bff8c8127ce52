"""What files hold of a render: chosen buffers, in half precision, none that follow from others."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import ADDED, BUFFERS, DEFAULT, group_name, names_where, row_of, split_name
from photonmap.errors import InputError
from photonmap.io.exr import list_parts, name_errors, read_exr
from photonmap.runtime.wording import listed, suggest

if TYPE_CHECKING:
    from photonmap.results.result import Result

Array = NDArray[Any]

ERRORS = ("radiance", "reflectance", "shading")
"""Buffers whose standard errors lean files hold."""
RGB = (
    "radiance", "emission", "direct", "indirect", "reflectance", "shading", "residual",
    "illuminant_direct", "fluorescence",
)  # fmt: skip
"""Buffers that lean files hold in RGB."""
DERIVED = ("scalar_shading", "illuminant")
"""Buffers that `derive` computes where files do not hold them."""
DROPPED = ("covariance", "direct_unfiltered", "indirect_unfiltered", *DERIVED)
"""Buffers that lean files do not hold: they follow from others, or only merging needs them."""
OFTEN_ZERO = ("residual", "caustics", "fluorescence")
"""Buffers that lean files do not hold where they are 0 everywhere."""
_ERROR = ".error"  # ending of the names of parts that hold standard errors
_LARGEST = 6e4  # values above do not fit half precision
_LEAST_MEAN, _LEAST_REST = 6e-3, 1e-5
"""Mean magnitude, of what is not 0, from which on rounding of the darkest values does not count: of
values, and of what is small beside them, their errors and residuals, where 0.3% of the mean may."""


def fits_half(name: str, image: Array) -> bool:
    """Return whether half precision can hold a part.

    Lengths, ids, masks and counts stay as they are, as do values out of half precision's range.
    """
    is_rest = name.endswith(_ERROR) or name in ("residual", "fluorescence")
    row = row_of(name.removesuffix(_ERROR))
    if row is None or row.is_integer or row.quantity == "length" or image.dtype != np.float32:
        return False
    sizes = np.abs(image)
    largest = float(sizes.max(initial=0.0))
    if not largest <= _LARGEST:
        return False
    lit = sizes[sizes > 0.0]
    least = _LEAST_REST if is_rest else _LEAST_MEAN
    return not lit.size or float(lit.mean(dtype=np.float64)) >= least


def as_lean(
    result: Result, kept: Collection[str] | None = None, like: Collection[str] | None = None
) -> tuple[Result, list[str]]:
    """Return a result as lean files hold it, and the names of its parts in half precision.

    Its values are rounded as in the files. `restored` adds what was left out.

    Parameters
    ----------
    kept : names of the buffers to keep, with those of light groups; None for all but what follows
        from others
    like : names of the parts in half precision; None for those that it can hold
    """
    alone = len(result.per_light) < 2

    def keeps(name: str, image: Array) -> bool:
        buffer, group = split_name(name)
        if (group and alone) or buffer in DROPPED or (buffer in OFTEN_ZERO and not image.any()):
            return False
        return kept is None or buffer in kept

    buffers = {name: image for name, image in result.buffers.items() if keeps(name, image)}
    errors = {name: result.errors[name] for name in ERRORS if name in result.errors}
    halves = []
    for images, ending in ((buffers, ""), (errors, _ERROR)):
        for name, image in images.items():
            part = name + ending
            if fits_half(part, image) if like is None else part in like:
                images[name] = to_half(image)
                halves.append(part)
    return replace(result, buffers=buffers, errors=errors, block_errors={}), halves


def to_half(image: Array) -> Array:
    """Return an image rounded to half precision, as float32."""
    return image.astype(np.float16).astype(np.float32)


def restored(result: Result) -> Result:
    """Return what was read from lean files with the buffers that follow from others."""
    buffers = dict(result.buffers)
    for name in derived_names(buffers, result.record):
        source = source_of(name, buffers)
        if source is not None:
            buffers[name] = derive(name, buffers[source])
    return replace(result, buffers=buffers)


def derived_names(held: Collection[str], record: dict[str, Any]) -> list[str]:
    """Return the names of buffers that a file does not hold, but that follow from those it does."""
    names = [name for name in DERIVED if "shading" in held]
    groups = record.get("light_groups") or []
    if len(groups) == 1:
        names += [
            group_name(name, groups[0]) for name in names_where(per_light=True) if name in held
        ]
    return [name for name in names if name not in held]


def source_of(name: str, held: Collection[str]) -> str | None:
    """Return the part of a file that an array comes from; None where there is none."""
    if name in held:
        return name
    # an only light group has the buffers of the whole
    base = "shading" if name in DERIVED else split_name(name)[0]
    return base if base in held else None


def exact_halves(
    names: Collection[str], held: Collection[str], halves: Collection[str]
) -> set[str]:
    """Return those of an image's arrays that are exact in half precision, as its file has them.

    `held` are the parts of the file, and `halves` those in half precision.
    """
    return {name for name in names if name not in DERIVED and source_of(name, held) in halves}


def derive(name: str, source: Array) -> Array:
    """Return an array from the part that `source_of` names."""
    if name not in DERIVED:
        return source
    mean = source.mean(axis=-1, keepdims=True, dtype=np.float64)
    if name == "scalar_shading":
        return mean[..., 0].astype(np.float32)
    lit = np.broadcast_to(mean != 0.0, source.shape)
    return np.divide(source, mean, where=lit, out=np.zeros(source.shape)).astype(np.float32)


def lacking(name: str, held: Iterable[str], remedy: str = "") -> KeyError:
    """Return the error that there is no array of a name: which there are, and a remedy."""
    row = row_of(name)
    if not remedy and row is not None and not row.is_banded:
        remedy = f"it has no bands, so it is among the image's own: image[{name!r}]"
    return KeyError(f"{name!r} is not one of {listed(held, 99)}{remedy and '; '}{remedy}")


class Arrays(dict[str, Array]):
    """Arrays by name; a missing one raises an error that says how to get it."""

    def __missing__(self, name: str) -> Array:
        raise lacking(name, self)


class Parts(Mapping[str, Array]):
    """The arrays of a file, and those that follow from them where lean files do not hold them."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read: dict[str, Array] = {}

    @cached_property
    def _held(self) -> list[str]:
        return list_parts(self._path)

    @cached_property
    def _names(self) -> list[str]:
        record = read_exr(self._path, ()).record
        return [*self._held, *derived_names(self._held, record)]

    @property
    def halves(self) -> set[str]:
        """Names of the arrays that the file has in half precision."""
        return exact_halves(self._names, self._held, list_parts(self._path, half=True))

    def __getitem__(self, name: str) -> Array:
        """Return an array, read from its part alone.

        Raises
        ------
        KeyError : there is none of this name
        InputError : the file is damaged
        """
        if name not in self._read:
            source = source_of(name, self._held) if name in self._names else None
            if source is None:
                raise lacking(name, self)
            if source not in self._read:
                found = read_exr(self._path, (source,))
                self._read |= found.buffers | name_errors(found.errors, found.block_errors)
            if name != source:
                self._read[name] = derive(name, self._read[source])
        return self._read[name]

    def __contains__(self, name: object) -> bool:
        """Return whether there is such an array; none is read."""
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


ALWAYS = ("radiance", "reflectance", "shading", "valid")
"""Buffers that every image holds, as readers, scores and `verify` need them."""
_KEPT = "pure"
"""Mask that every image holds besides: without it nobody can tell where light is exact."""
_HYPERSIM = ("distance", "normal", "object_id")  # that Hypersim's files are made from besides
_KNOWN = (*BUFFERS, *(row.name for row in ADDED))


def check_chosen(
    names: Sequence[str] | None, formats: Collection[str], has_sensor: bool = False
) -> tuple[str, ...] | None:
    """Return the buffers that files hold in the usual order, `pure` included; None for all."""
    if names is None:
        return None
    for name in names:
        if name not in _KNOWN:
            raise InputError(f"there is no buffer {name!r}; {suggest(name, _KNOWN)}")
    for needed, what, is_asked in (
        (ALWAYS, "reading and verify", True),
        (_HYPERSIM, "Hypersim's files of the format hdf5", "hdf5" in formats),
        (("emission",), "a photo by --sensor", has_sensor),
    ):
        if is_asked and (missing := [name for name in needed if name not in names]):
            problem = f"buffers lack {', '.join(missing)}, which {what} need"
            raise InputError(f"{problem}; add to --buffers")
    return tuple(name for name in _KNOWN if name in (*names, _KEPT))


def rendered_for(chosen: Collection[str] | None) -> list[str]:
    """Return the buffers that a render has to keep for files of these; None for the usual ones.

    Those that renders keep of some scenes alone are not among the usual ones, so that all images of
    a set hold the same.
    """
    further = [name for name in chosen or () if name in BUFFERS and name not in DEFAULT]
    return [*DEFAULT, *further]


def held_in(result: Result, chosen: Collection[str] | None) -> Result:
    """Return what files hold of a result: the chosen buffers, light groups and errors included."""
    if chosen is None:
        return result

    def kept(images: dict[str, Any]) -> dict[str, Any]:
        return {name: image for name, image in images.items() if split_name(name)[0] in chosen}

    arguments = result.record.get("arguments", {}) | {"buffers": sorted(chosen)}
    images: dict[str, Any] = {
        name: kept(getattr(result, name)) for name in ("buffers", "errors", "block_errors")
    }
    return replace(result, **images, record=result.record | {"arguments": arguments})
