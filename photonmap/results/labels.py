"""A result's arrays by name and by wavelength, and as labelled arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import row_of
from photonmap.errors import InputError
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
        KeyError
            if there is none of this name
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
        InputError
            for RGB, which has none
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
        InputError
            if it is no number or outside of the range, or the bands are RGB
        """
        if finite(wavelength) is None:
            raise InputError(f"wavelength {shown(wavelength)} is not a number; give one, in nm")
        at = int(np.abs(self.wavelengths - wavelength).argmin())
        low, high = self.bands.limits or (0.0, 0.0)
        if not low <= wavelength <= high:
            raise InputError(f"{wavelength:g} nm is outside of the bands, {low:g} to {high:g} nm")

        def chosen(images: Arrays) -> Arrays:
            return {
                name: image[..., at : at + 1] if _is_banded(name) else image
                for name, image in images.items()
            }

        curve = self.bands.sensitivities[at]
        ends = float(curve.wavelengths[0]), float(curve.wavelengths[-1])
        bands = Bands("sensors", self.bands.names[at : at + 1], (curve,), ends)
        white, parts = self.record.get("white"), self.record.get("group_whites", {})
        whites = {
            "white": white and white[at : at + 1],
            "group_whites": {group: part[at : at + 1] for group, part in parts.items()},
        }
        record = {**self.record, "bands": bands.describe(), **whites}
        images = {name: chosen(getattr(self, name)) for name in _IMAGES}
        return replace(self, bands=bands, record=record, **images)  # type: ignore[type-var]

    def to_xarray(self) -> xarray.Dataset:
        """Return all arrays as a labelled data set, over y, x and band; errors are variables.

        The coordinates are the centres of pixels, the names of the bands, and, unless they are
        RGB, their `wavelength` in nm. Variables have `units` and `long_name`. The record is the
        attribute `record`, in JSON, and the data set can be written by its `to_netcdf`. The arrays
        are shared.

        Raises
        ------
        InputError
            if xarray is not installed
        """
        from photonmap.results.labelled import make_dataset

        return make_dataset(self.arrays, self.bands, self.record)


def _is_banded(name: str) -> bool:
    row = row_of(name)
    return row is None or row.is_banded
