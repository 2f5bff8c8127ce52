"""Arrays of a result as an xarray.Dataset."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import row_of
from photonmap.errors import InputError
from photonmap.io.exr import sort_parts
from photonmap.spectra.bands import Bands

if TYPE_CHECKING:
    import xarray

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
    """Return what an array is, by its name in files: "direct", "direct.error", "indirect.error8".

    Parameters
    ----------
    image : (H, W) or (H, W, N)
    """
    of, block = "", ""
    buffer = name
    for ending, (meaning, prefix) in _ENDINGS.items():
        if name.endswith(ending):
            buffer, of, block = name.removesuffix(ending), meaning, prefix
    row = row_of(buffer)
    last = "band" if row is None or row.is_banded else "axis"
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
