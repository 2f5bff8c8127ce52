"""Read a data set: images whose arrays are loaded on demand, and splits by scene."""

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
from photonmap.runtime.wording import listed

if TYPE_CHECKING:
    from photonmap.results.result import Result

Array = NDArray[Any]


class Image(Mapping[str, Array]):
    """One image: arrays by name, read from its files on first access.

    Names are those of `photonmap.Result`'s buffers, "shading@lamp" for one light group,
    "shading.error" for a standard error, "indirect.error8" for that of block means; and those that
    `photonmap.dataset.files.derived_buffers` adds.

    Parameters
    ----------
    folder : of the data set
    entry : of the image in the manifest
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
        """The scene as images share it, whatever the illumination, colours and view."""
        return self.entry["geometry"]

    @cached_property
    def result(self) -> Result:
        """The render, in its bands.

        Raises
        ------
        InputError : its files are missing or damaged
        """
        from photonmap.dataset.files.image_files import read_image

        return read_image(self.folder)

    @cached_property
    def rgb(self) -> Mapping[str, Array]:
        """Arrays in linear sRGB by name, as `derived_buffers.as_rgb` makes them."""
        from photonmap.dataset.files.image_files import RGB_EXR, read_rgb
        from photonmap.dataset.files.parts import Parts

        path = self.folder / RGB_EXR
        return Parts(path) if path.is_file() else read_rgb(self.folder)

    @cached_property
    def _arrays(self) -> Mapping[str, Array]:
        from photonmap.dataset.files.image_files import BANDS_EXR
        from photonmap.dataset.files.parts import Parts

        path = self.folder / BANDS_EXR
        return Parts(path) if path.is_file() else self.result.arrays

    def __getitem__(self, name: str) -> Array:
        if name not in self._arrays:
            raise KeyError(f"{name!r} is not one of {listed(self._arrays, 99)}")
        return self._arrays[name]

    def __contains__(self, name: object) -> bool:
        """Return whether there is such an array; none is read."""
        return name in self._arrays

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)


class Dataset(Sequence[Image]):
    """The images of a data set, in the order of its manifest.

    Parameters
    ----------
    folder : of the data set
    head : contents of manifest.json
    entries : of the images, from manifest.jsonl
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
        """Return an image, whose arrays are not read yet; for a slice, a smaller data set."""
        if isinstance(index, slice):
            return Dataset(self.folder, self.head, self.entries[index])
        return Image(self.folder, self.entries[index])

    @property
    def geometries(self) -> list[str]:
        """Names of the scenes, in order of appearance."""
        return list(dict.fromkeys(entry["geometry"] for entry in self.entries))

    def splits(
        self, train: float = 0.8, val: float = 0.1, test: float = 0.1, seed: int = 0
    ) -> tuple[Dataset, Dataset, Dataset]:
        """Split into parts that share no scene, whatever the illumination, colours or view.

        Parameters
        ----------
        train, val, test : fractions of the scenes, rounded to whole numbers of them
        seed : shuffles the scenes

        Raises
        ------
        InputError : a fraction is negative, or they do not add up to 1
        """
        fractions = np.array([train, val, test], np.float64)
        if not (fractions >= 0.0).all() or abs(fractions.sum() - 1.0) > 1e-6:
            raise InputError(
                f"splits {train}, {val}, {test} must not be negative and must add up to 1"
            )
        scenes = np.array(sorted(self.geometries), dtype=object)
        np.random.Generator(np.random.PCG64(seed)).shuffle(scenes)
        ends = np.rint(np.cumsum(fractions) * len(scenes)).astype(int)[:2]
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
        names : of the arrays to load
        rgb : load those that have bands in linear sRGB
        transform : applied to each dict; its return value is yielded

        Raises
        ------
        InputError : torch is not installed
        """
        if find_spec("torch") is None:
            raise InputError("tensors need torch: pip install torch")
        from photonmap.dataset.files.torch_dataset import TensorDataset

        return TensorDataset(self, names, rgb, transform)


def open_dataset(folder: str | PathLike[str]) -> Dataset:
    """Open a data set made by `python -m photonmap dataset`; arrays are read on demand.

    Raises
    ------
    InputError : the folder does not hold a data set, or its manifest is damaged
    """
    from photonmap.dataset.files.manifest import read_head, read_lines

    return Dataset(Path(folder), read_head(folder), read_lines(folder))
