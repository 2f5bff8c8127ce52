"""Read a data set: images as arrays that are loaded when they are asked for, splits by scenes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.messages import listed

if TYPE_CHECKING:
    from photonmap.result import Result

Array = NDArray[Any]


class Image(Mapping[str, Array]):
    """One image: arrays by name, read from its files when one is first asked for.

    Names are those of `photonmap.Result`'s buffers, "shading@lamp" of one group of lights, and
    "shading.error" of a standard error, "indirect.error8" of that of blocks' means; and those that
    `photonmap.dataset.derived` adds.

    Parameters
    ----------
    folder : of the data set
    entry : what the manifest says of it
    """

    def __init__(self, folder: Path, entry: dict[str, Any]):
        self.folder, self.entry = folder / entry["name"], entry

    def __repr__(self) -> str:
        return f"<Image {self.name}>"

    @property
    def name(self) -> str:
        """The name of its folder."""
        return self.entry["name"]

    @property
    def geometry(self) -> str:
        """What it shares with the other images of its scene."""
        return self.entry["geometry"]

    @cached_property
    def result(self) -> Result:
        """The render, in its bands.

        Raises
        ------
        InputError : its files are missing or damaged
        """
        from photonmap.dataset.files import read_image

        return read_image(self.folder)

    @cached_property
    def rgb(self) -> dict[str, Array]:
        """Arrays in linear sRGB by name, as `photonmap.dataset.derived.as_rgb` makes them."""
        from photonmap.dataset.files import read_rgb

        return read_rgb(self.folder)

    @cached_property
    def _arrays(self) -> dict[str, Array]:
        from photonmap.output import name_errors

        return self.result.buffers | name_errors(self.result)

    def __getitem__(self, name: str) -> Array:
        if name not in self._arrays:
            raise KeyError(f"{name!r} is none of {listed(self._arrays, 99)}")
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)


class Dataset(Sequence[Image]):
    """The images of a data set, in the order of its manifest.

    Parameters
    ----------
    folder : of the data set
    head : what manifest.json says of it
    entries : of its images
    """

    def __init__(self, folder: Path, head: dict[str, Any], entries: Sequence[dict[str, Any]]):
        self.folder, self.head, self.entries = folder, head, list(entries)

    def __repr__(self) -> str:
        return f"<Dataset {self.folder}: {len(self)} images>"

    def __len__(self) -> int:
        return len(self.entries)

    @overload
    def __getitem__(self, index: int) -> Image: ...
    @overload
    def __getitem__(self, index: slice) -> Dataset: ...
    def __getitem__(self, index: int | slice) -> Image | Dataset:
        """Return an image, its arrays not yet read; or a part of the set."""
        if isinstance(index, slice):
            return Dataset(self.folder, self.head, self.entries[index])
        return Image(self.folder, self.entries[index])

    @property
    def geometries(self) -> list[str]:
        """The scenes, in order of appearance."""
        return list(dict.fromkeys(entry["geometry"] for entry in self.entries))

    def splits(
        self, train: float = 0.8, val: float = 0.1, test: float = 0.1, seed: int = 0
    ) -> tuple[Dataset, Dataset, Dataset]:
        """Split into parts that share no scene, in whatever light, colours or view.

        Parameters
        ----------
        train, val, test : shares of the scenes, to the nearest whole number
        seed : draws which scenes go where

        Raises
        ------
        InputError : shares below 0, or that do not add up to 1
        """
        shares = np.array([train, val, test], np.float64)
        if not (shares >= 0.0).all() or abs(shares.sum() - 1.0) > 1e-6:
            raise InputError(f"splits {train}, {val}, {test} must be from 0 and add up to 1")
        scenes = np.array(sorted(self.geometries), dtype=object)
        np.random.Generator(np.random.PCG64(seed)).shuffle(scenes)
        ends = np.rint(np.cumsum(shares) * len(scenes)).astype(int)[:2]
        parts = [set(part) for part in np.split(scenes, ends)]
        first, second, third = (self._of(part) for part in parts)
        return first, second, third

    def _of(self, scenes: set[str]) -> Dataset:
        """Return the images of some scenes."""
        entries = [entry for entry in self.entries if entry["geometry"] in scenes]
        return Dataset(self.folder, self.head, entries)

    def torch(
        self,
        names: Sequence[str] = ("radiance", "reflectance", "shading"),
        rgb: bool = False,
        transform: Callable[[dict[str, Any]], Any] | None = None,
    ) -> Any:
        """Return a `torch.utils.data.Dataset` of dicts of tensors, bands first, as (N, H, W).

        Parameters
        ----------
        names : of the arrays
        rgb : those in linear sRGB
        transform : is given each dict, and returns what the data set yields

        Raises
        ------
        InputError : torch is not installed
        """
        if find_spec("torch") is None:
            raise InputError("tensors need torch: pip install torch")
        from photonmap.dataset.tensors import Tensors

        return Tensors(self, names, rgb, transform)


def open_dataset(folder: str | PathLike[str]) -> Dataset:
    """Open a data set that `python -m photonmap dataset` made; arrays are read when asked for.

    Raises
    ------
    InputError : the folder holds none, or its manifest is damaged
    """
    from photonmap.dataset.manifest import read_head, read_lines

    return Dataset(Path(folder), read_head(folder), read_lines(folder))
