"""A result's arrays by name and by wavelength, and as labelled arrays."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import is_banded, row_of
from photonmap.errors import InputError
from photonmap.io.exr import sort_parts
from photonmap.results.colors import Colors, Image
from photonmap.runtime.wording import listed, shown, suggest
from photonmap.scene.parameters import finite
from photonmap.spectra.bands import Bands

if TYPE_CHECKING:
    import xarray

Arrays = dict[str, NDArray[Any]]

_IMAGES = ("buffers", "errors", "block_errors")


class Groups(dict[str, dict[str, Image]]):
    """Images by light group and name."""

    def __missing__(self, group: str) -> dict[str, Image]:
        """Raise `KeyError` that names the groups there are."""
        choice = f"choose from {listed(self)}" if self else "render with per_light=True"
        raise KeyError(
            f"there is no light group {group!r}; {choice}; lights that are off have none"
        )


class Labels(Colors, Mapping[str, NDArray[Any]]):
    """What can be asked of arrays by name; see `photonmap.Result`."""

    errors: Arrays
    block_errors: Arrays

    __eq__, __hash__ = object.__eq__, object.__hash__  # arrays do not compare to one truth

    @property
    def arrays(self) -> Arrays:
        """All arrays by their names in files."""
        raise NotImplementedError

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return a buffer or a standard error by its name in files, as in "direct.error".

        Raises
        ------
        KeyError : there is none of this name
        """
        arrays = self.arrays
        if name not in arrays:
            raise KeyError(f"there is no array {name!r}; {suggest(str(name), arrays)}")
        return arrays[name]

    def __contains__(self, name: object) -> bool:
        return name in self.arrays

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def __len__(self) -> int:
        return len(self.arrays)

    @property
    def wavelengths(self) -> NDArray[np.float64]:
        """(N,) float64, nm: the mean wavelength of each band.

        Raises
        ------
        InputError : for RGB, which has none
        """
        if self.bands.centroids is None:
            raise InputError("RGB has no wavelengths; render in a number of bands")
        return self.bands.centroids

    def sel(self, wavelength: float) -> Self:
        """Return the result of one band alone: that whose mean wavelength is nearest, (H, W, 1).

        What the record says of the run, and `bias`, are still over all bands.

        Parameters
        ----------
        wavelength : nm, within the range of the bands

        Raises
        ------
        InputError : it is no number or outside of the range, or the bands are RGB
        """
        if finite(wavelength) is None:
            raise InputError(f"wavelength {shown(wavelength)} is not a number; give one, in nm")
        at = int(np.abs(self.wavelengths - wavelength).argmin())
        low, high = self.bands.limits or (0.0, 0.0)
        if not low <= wavelength <= high:
            raise InputError(f"{wavelength:g} nm is outside of the bands, {low:g} to {high:g} nm")

        def chosen(images: Arrays) -> Arrays:
            return {
                name: image[..., at : at + 1] if is_banded(name) else image
                for name, image in images.items()
            }

        curve = self.bands.sensitivities[at]
        ends = float(curve.wavelengths[0]), float(curve.wavelengths[-1])
        bands = Bands("sensors", self.bands.names[at : at + 1], (curve,), ends)
        white, parts = self.record.get("white"), self.record.get("group_whites", {})
        whites = {
            "white": white and white[at : at + 1],
            "light_luminance": None,
            "group_whites": {group: part[at : at + 1] for group, part in parts.items()},
        }
        record = {**self.record, "bands": bands.describe(), **whites}
        images = {name: chosen(getattr(self, name)) for name in _IMAGES}
        return replace(self, bands=bands, record=record, **images)  # type: ignore[type-var]

    def to_xarray(self) -> xarray.Dataset:
        """Return all arrays as a labelled data set, over y, x and band; errors are variables.

        The coordinates are the centres of pixels, the names of the bands, and, unless they are
        RGB, their `wavelength` in nm. Variables have `units` and `long_name`. The record is the
        attribute `record`, in JSON, and the data set can be written by its `to_netcdf` unless the
        name of a light has a "/". The arrays are shared.

        Raises
        ------
        InputError : xarray is not installed
        """
        return make_dataset(self.arrays, self.bands, self.record)


_AXIS = ("x", "y", "z")
_ENDINGS = {
    ".error": ("standard error of", ""),
    ".error8": ("standard error of the mean over 8×8 pixels of", "block_"),
}
"""By the ending of a name: what the array is of its buffer, and the prefix of its dimensions."""


def make_dataset(
    arrays: dict[str, NDArray[Any]], bands: Bands, record: dict[str, Any]
) -> xarray.Dataset:
    """Return arrays by their names in files as variables; see `photonmap.Result.to_xarray`."""
    try:
        import xarray
    except ImportError:
        raise InputError("labelled arrays need xarray: pip install 'photonmap[xarray]'") from None
    height, width = next(iter(sort_parts(arrays)[0].values())).shape[:2]
    about = {name: describe_array(name, image) for name, image in arrays.items()}
    variables = {
        name: (row.dimensions, arrays[name], {"long_name": row.meaning, "units": row.unit})
        for name, row in about.items()
    }
    return xarray.Dataset(
        variables,
        {
            "y": ("y", np.arange(height) + 0.5, {"units": "pixel", "long_name": "from the top"}),
            "x": ("x", np.arange(width) + 0.5, {"units": "pixel", "long_name": "from the left"}),
            **_band_coordinates(variables, bands),
        },
        {"record": json.dumps(record), "bands": json.dumps(bands.describe())},
    )


class About(NamedTuple):
    """What an array of a result is."""

    dimensions: tuple[str, ...]
    """of "y" and "x", or of "block_y" and "block_x", and then "band" or "axis" """
    meaning: str
    unit: str
    """"1" where there is none"""


def describe_array(name: str, image: NDArray[Any]) -> About:
    """Return what an array, (H, W) or (H, W, N), is by its name in files, as in "direct.error8"."""
    of, block = "", ""
    buffer = name
    for ending, (meaning, prefix) in _ENDINGS.items():
        if name.endswith(ending):
            buffer, of, block = name.removesuffix(ending), meaning, prefix
    row = row_of(buffer)
    last = "band" if is_banded(buffer) else "axis"
    dimensions = (f"{block}y", f"{block}x", last)[: image.ndim]
    meaning = name if row is None else row.meaning
    return About(dimensions, f"{of} {meaning}".strip(), (row.unit if row else "") or "1")


def _band_coordinates(variables: dict[str, Any], bands: Bands) -> dict[str, Any]:
    """Return the coordinates of the dimensions that there are."""
    used = {dimension for dimensions, _, _ in variables.values() for dimension in dimensions}
    found: dict[str, Any] = {}
    if "band" in used:
        found["band"] = ("band", list(bands.names))
        if bands.centroids is not None:
            attributes = {"units": "nm", "long_name": "mean wavelength of the band"}
            found["wavelength"] = ("band", bands.centroids, attributes)
    if "axis" in used:
        found["axis"] = ("axis", list(_AXIS))
    return found
