"""The ground truth of an image of a data set, and what a method sees of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.files.derived_buffers import rgb_method
from photonmap.dataset.files.reader import Image
from photonmap.errors import InputError
from photonmap.evaluate.metrics.arrays import Floats, Mask, to_grey
from photonmap.results.result import Result

SPACES = ("rgb", "bands")
"""In which images are compared: linear sRGB, or the bands they were rendered in."""
_WHITE = 99.0
"""Percentile of the grey values of valid pixels that becomes 1."""
_DRAWN = ("reflectance", "shading")


@dataclass(frozen=True, eq=False)
class Truth:
    """The ground truth of an image, (H, W, C) float64 each unless stated.

    Parameters
    ----------
    name : of the image
    scene : of the image, whatever the light
    radiance : what a camera sees; its grey values have their 99th percentile at 1
    reflectance : of a perfect diffuser 1
    shading : its grey values have their 99th percentile at 1; its colour is that of the light
    regions : (H, W) int, number of the material, 0 for none
    mask : (H, W) bool, valid pixels
    errors : standard errors of reflectance and shading by name, of bands projected like the values;
        empty if there are none
    """

    name: str
    scene: str
    radiance: Floats
    reflectance: Floats
    shading: Floats
    regions: NDArray[Any]
    mask: Mask
    errors: dict[str, Floats]

    def drawn(self, rng: np.random.Generator) -> Truth:
        """Return the truth with the noise of its standard errors added once more.

        Noise is normal and the same in all bands, as all are carried by the same photons, and
        independent between pixels, and between reflectance and shading.
        """
        noise = {name: rng.standard_normal((*self.mask.shape, 1)) for name in _DRAWN}
        return replace(
            self,
            reflectance=self.reflectance + noise["reflectance"] * self.errors["reflectance"],
            shading=self.shading + noise["shading"] * self.errors["shading"],
        )


def load_truth(image: Image, space: str) -> Truth:
    """Read the ground truth of an image of a data set.

    Parameters
    ----------
    space : one of `SPACES`

    Raises
    ------
    InputError : files are missing or damaged, no pixel is valid, or values are not finite
    """
    arrays: Any = image.srgb if space == "rgb" else image
    mask = np.asarray(image["valid"])
    if not mask.any():
        raise InputError("has no valid pixel; leave it out", image.folder)
    values = {
        name: np.asarray(arrays[name], np.float64)
        for name in ("radiance", "reflectance", "shading")
    }
    if bad := [name for name, array in values.items() if not np.isfinite(array[mask]).all()]:
        raise InputError(f"{bad[0]} has NaN or infinity; render it again", image.folder)
    brightness = white_level(values["shading"], mask)
    values["radiance"] = values["radiance"] / white_level(values["radiance"], mask)
    values["shading"] = values["shading"] / brightness
    errors = _errors(image.result, space)
    if errors:
        errors["shading"] = errors["shading"] / brightness
    if "material_id" not in image:
        raise InputError(
            "holds no material_id, which scores need; add it to --buffers", image.folder
        )
    regions = np.asarray(image["material_id"]).astype(np.int64)
    return Truth(image.name, image.geometry, **values, regions=regions, mask=mask, errors=errors)


def white_level(image: Floats, mask: Mask) -> float:
    """Return the grey value that becomes 1; 1 for an image that is black."""
    white = float(np.percentile(to_grey(image)[mask], _WHITE))
    return white if white > 0.0 else 1.0


def _errors(result: Result, space: str) -> dict[str, Floats]:
    """Return the standard errors of reflectance and shading, projected as the values are."""
    if not all(name in result.errors for name in _DRAWN):
        return {}
    errors = {name: result.standard_error(name) for name in _DRAWN}
    if space == "rgb":
        spread = Result(errors, {}, result.bands, result.record)
        errors = {name: spread.rgb(name, rgb_method(result.bands)) for name in _DRAWN}
    return {name: error.astype(np.float64) for name, error in errors.items()}
