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

from photonmap.buffers import row_of
from photonmap.dataset.files.inside import inside
from photonmap.dataset.files.lean import DROPPED, OFTEN_ZERO, Arrays, Parts, exact_halves, lacking
from photonmap.dataset.files.manifest import read_head, read_lines, with_table
from photonmap.dataset.files.splits import FRACTIONS, LAYOUT, split_scenes
from photonmap.errors import InputError
from photonmap.io.exr import current_name
from photonmap.runtime.wording import shown
from photonmap.spectra.projection import SRGB

if TYPE_CHECKING:
    from photonmap.capture.photo import Photo
    from photonmap.dataset.files.flow import Flow
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
        self.folder, self.entry = inside(folder, entry["name"], is_part=True), entry

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

    @property
    def chosen(self) -> tuple[str, ...] | None:
        """The buffers that its files hold, as `--buffers` chose them; None for all."""
        names = self.entry.get("buffers")
        return None if names is None else tuple(map(current_name, names))

    @cached_property
    def result(self) -> Result:
        """The render, in its bands.

        Raises
        ------
        InputError : its files are missing or damaged
        """
        from photonmap.dataset.files.image_files import BANDS_EXR, BANDS_HDF5, read_image

        for name in (BANDS_EXR, BANDS_HDF5):
            inside(self.folder, name)
        return read_image(self.folder)

    @cached_property
    def rgb(self) -> Mapping[str, Array]:
        """Arrays in the set's RGB by name, as `derived_buffers.as_rgb` makes them."""
        from photonmap.dataset.files.derived_buffers import as_rgb
        from photonmap.dataset.files.image_files import RGB_EXR

        path = inside(self.folder, RGB_EXR)
        if path.is_file():
            return Parts(path)
        folder = self.folder.parent
        space = with_table(self._space, lambda path: str(inside(folder, path.as_posix())))
        return Arrays(as_rgb(self.result, space).buffers)

    @cached_property
    def srgb(self) -> Mapping[str, Array]:
        """Arrays in linear sRGB by name, whatever the set's RGB."""
        from photonmap.dataset.files.derived_buffers import as_rgb

        return self.rgb if self._space == SRGB else Arrays(as_rgb(self.result, SRGB).buffers)

    @property
    def _space(self) -> str:
        """The set's RGB."""
        return self.entry.get("rgb", {}).get("space", SRGB)

    @cached_property
    def photo(self) -> Photo:
        """What the set's sensor recorded.

        Raises
        ------
        InputError : the set was made without `--sensor`, or the photo is damaged
        """
        from photonmap.capture.photo import load_photo
        from photonmap.dataset.files.image_files import PHOTO, list_files

        folder = inside(self.folder, PHOTO, is_part=True)
        for name in list_files(folder):
            inside(folder, name)
        return load_photo(folder)

    def flow_to(self, other: Image) -> Flow:
        """Return where the points of this image are in another view of the same scene.

        What is hidden there is found by comparing surfaces at the centres of pixels; rays are more
        exact at silhouettes: see `photonmap.dataset.jobs.flows.flow_by_rays`.

        Raises
        ------
        InputError : the other image is of another scene, or a camera is not a pinhole
        """
        from photonmap.dataset.files.flow import Eye, compare_surfaces, find_targets, flow_of

        if other.geometry != self.geometry:
            raise InputError(f"{self.name} and {other.name} show two scenes; flow is within one")
        here, there = (
            Eye.of(each.entry["camera"], each["distance"].shape[::-1]) for each in (self, other)
        )
        target = find_targets(here, there, self["distance"])
        visible = compare_surfaces(target, self["object_id"], there, other)
        return flow_of(here, there, target, visible)

    def light_shares(self) -> dict[str, Array]:
        """Return each light's share of the irradiance by light group, interreflection included.

        (H, W) float32 each, of the means over bands; they add up to 1, and are 0 where no light
        arrives. In a pixel that is not pure, they are shares of shading.
        """
        from photonmap.results.relighting import shares_of

        return shares_of({light: self[f"shading@{light}"] for light in self.entry["lights"]})

    def light_share_errors(self) -> dict[str, Array]:
        """Return the standard errors of `light_shares` by light group, (H, W) float32 each.

        `photonmap.results.relighting` says how the covariance of lights enters them.

        Raises
        ------
        InputError : the files hold no errors of light groups, which those of `--full` do
        """
        from photonmap.results.relighting import share_errors

        return share_errors(self.result, list(self.entry["lights"]))

    @cached_property
    def _arrays(self) -> Mapping[str, Array]:
        from photonmap.dataset.files.image_files import BANDS_EXR

        path = inside(self.folder, BANDS_EXR)
        return Parts(path) if path.is_file() else self.result.arrays

    @property
    def halves(self) -> set[str]:
        """Names of the arrays that its files have in half precision, which lose nothing by it."""
        from photonmap.dataset.files.image_files import BANDS_HDF5, hdf5_halves

        if isinstance(self._arrays, Parts):
            return self._arrays.halves
        return exact_halves(self._arrays, *hdf5_halves(self.folder / BANDS_HDF5))

    @property
    def rgb_halves(self) -> set[str]:
        """The same of those in the set's RGB."""
        return self.rgb.halves if isinstance(self.rgb, Parts) else set()

    def __getitem__(self, name: str) -> Array:
        """Return an array; zeros for one of `OFTEN_ZERO` that files leave out, being 0.

        Raises
        ------
        KeyError : there is none of this name
        InputError : its file is damaged
        """
        if name in self._arrays:
            return self._arrays[name]
        if name in OFTEN_ZERO and (self.chosen is None or name in self.chosen):
            return np.zeros_like(self["shading"])
        raise lacking(name, self._arrays, self._how_to_have(name))

    def _how_to_have(self, name: str) -> str:
        """Return how to come by an array that files do not hold; "" where there is no such."""
        buffer, is_error, _ = name.partition(".")
        row = row_of(buffer)
        if row is None or "@" in buffer or (is_error and not row.has_error):
            return ""
        is_dropped = is_error or buffer in DROPPED
        if is_dropped and not is_error and self.entry.get("full", True):
            return f"it is 0 everywhere: image.result.{buffer}"
        return f"make the set with {'--full' if is_dropped else f'{buffer} among --buffers'}"

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
        try:
            entry = self.entries[index]
        except (IndexError, TypeError) as error:
            message = (
                f"{shown(index)} is no image: they are numbered from 0 to {len(self) - 1}, and "
                f"image.name is the name of one"
            )
            raise type(error)(message) from None
        return Image(self.folder, entry)

    @property
    def geometries(self) -> list[str]:
        """Names of the scenes, in order of appearance."""
        return list(dict.fromkeys(entry["geometry"] for entry in self.entries))

    def splits(
        self,
        train: float = FRACTIONS[0],
        val: float = FRACTIONS[1],
        test: float = FRACTIONS[2],
        seed: int = 0,
        by: str = LAYOUT,
    ) -> tuple[Dataset, Dataset, Dataset]:
        """Split into parts that share no scene, whatever the illumination, colours or view.

        A hash of its name decides a scene's part, so that none moves to another when the set
        grows. The fractions are met on average. The manifest has the parts of the default.

        Parameters
        ----------
        train, val, test : fractions of the scenes
        seed : of another split
        by : "layout" for parts that share no scene of one name and seed, "type" for parts that
            share no scene of one name either, such as studies

        Raises
        ------
        InputError : a fraction is negative, they do not add up to 1, a part that is not 0 would be
            empty, or there is no such way to split
        """
        scenes = [entry["geometry"] for entry in self.entries]
        first, second, third = (
            Dataset(self.folder, self.head, [self.entries[place] for place in places])
            for places in split_scenes(scenes, (train, val, test), seed, by).values()
        )
        return first, second, third

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
        rgb : load those that have bands in the set's RGB
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
    return Dataset(Path(folder), read_head(folder), read_lines(folder))
