"""Arrays of a result as an xarray.Dataset."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import row_of
from photonmap.errors import InputError
from photonmap.io.exr import sort_parts
from photonmap.spectra.bands import Bands

if TYPE_CHECKING:
    import xarray

_AXIS = ("x", "y", "z")


def make_dataset(
    arrays: dict[str, NDArray[Any]], bands: Bands, record: dict[str, Any]
) -> xarray.Dataset:
    """Return arrays by their names in files as variables; see `photonmap.Result.to_xarray`."""
    try:
        import xarray
    except ImportError:
        raise InputError("labelled arrays need xarray: pip install 'photonmap[xarray]'") from None
    buffers, errors, block_errors = sort_parts(arrays)
    height, width = next(iter(buffers.values())).shape[:2]
    variables = {name: _variable(name, image) for name, image in buffers.items()}
    for name, image in errors.items():
        variables[f"{name}.error"] = _variable(name, image, "standard error of")
    for name, image in block_errors.items():
        label = "standard error of the mean over 8×8 pixels of"
        variables[f"{name}.error8"] = _variable(name, image, label, "block_")
    return xarray.Dataset(
        variables,
        {
            "y": ("y", np.arange(height) + 0.5, {"units": "pixel", "long_name": "from the top"}),
            "x": ("x", np.arange(width) + 0.5, {"units": "pixel", "long_name": "from the left"}),
            **_band_coordinates(variables, bands),
        },
        {"record": json.dumps(record)},
    )


def _variable(
    name: str, image: NDArray[Any], of: str = "", block: str = ""
) -> tuple[tuple[str, ...], NDArray[Any], dict[str, str]]:
    """Return the dimensions, the values and the attributes of a variable."""
    row = row_of(name)
    banded = row is None or row.is_banded
    last = "band" if banded else "axis"
    dimensions = (f"{block}y", f"{block}x", last)[: image.ndim]
    meaning = name if row is None else row.meaning
    unit = (row.unit if row is not None else "") or "1"
    return dimensions, image, {"long_name": f"{of} {meaning}".strip(), "units": unit}


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
