"""The images of a data set: the truth of each, what a method sees of it, and which kind it is.

Kinds are those that the first data set of this sort distinguished: S. Beigpour, M. Serra, J. van de
Weijer, R. Benavente, M. Vanrell, O. Penacchio and D. Samaras, "Intrinsic image evaluation on
synthetic complex scenes", ICIP 2013: single objects or complex scenes, in white light, light of one
colour, or two lights.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.files.derived_buffers import rgb_method
from photonmap.dataset.files.reader import Dataset, Image, open_dataset
from photonmap.dataset.scenes.illumination import WHITE
from photonmap.dataset.scenes.rooms.catalogue import ROOMS
from photonmap.dataset.scenes.single_objects import OBJECTS
from photonmap.errors import InputError
from photonmap.evaluate.methods.method import View
from photonmap.evaluate.metrics.arrays import Floats, Mask, to_grey
from photonmap.results.result import Result
from photonmap.runtime.wording import listed

OBJECT, COMPLEX = "objects", "complex scenes"
WHITE_LIGHT, ONE_LIGHT, TWO_LIGHTS = "white", "one colour", "two lights"
CONTENTS = (OBJECT, COMPLEX)
COLORS_OF_LIGHT = (WHITE_LIGHT, ONE_LIGHT, TWO_LIGHTS)


class Kind(NamedTuple):
    """What an image shows, "" where that is not known."""

    content: str  # one of `CONTENTS`
    light: str  # one of `COLORS_OF_LIGHT`


def kind_of(image: Image) -> Kind:
    """Return the kind of an image; scenes from files have no known content."""
    job = image.entry["job"]
    scene, colors = job.get("scene"), job.get("colors") or []
    content = OBJECT if scene in OBJECTS else COMPLEX if scene in ROOMS else ""
    if not colors:
        return Kind(content, "")
    one = WHITE_LIGHT if list(colors) == [WHITE] else ONE_LIGHT
    return Kind(content, TWO_LIGHTS if len(colors) > 1 else one)


SPACES = ("rgb", "bands")
"""In which images are compared: linear sRGB, or the bands they were rendered in."""
_WHITE = 99.0  # Percentile of the grey values of valid pixels that becomes 1
_DRAWN = ("reflectance", "shading")


@dataclass(frozen=True, eq=False)
class Truth:
    """The ground truth of an image, (H, W, C) float64 each unless stated."""

    name: str  # of the image
    scene: str  # of the image, whatever the light
    radiance: Floats  # what a camera sees; its grey values have their 99th percentile at 1
    reflectance: Floats  # of a perfect diffuser 1
    shading: Floats
    """its grey values have their 99th percentile at 1; its colour is that of the light"""
    regions: NDArray[Any]  # (H, W) int, number of the material, 0 for none
    mask: Mask  # (H, W) bool, valid pixels
    errors: dict[str, Floats]
    """standard errors of reflectance and shading by name, of bands projected like the values; empty
    if there are none"""

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
    """Read the ground truth of an image in one of `SPACES`.

    An `InputError` says that files are missing or damaged, no pixel is valid, or values are not
    finite.
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
            "has no material_id, which metrics need; add it to --buffers and render again",
            image.folder,
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


def in_direct_light(image: Image, truth: Truth, space: str) -> Truth:
    """Return the truth of the same view without indirect light; it has no standard errors.

    The shading is (direct − fluorescence_direct) / reflectance. Pixels where a band reflects
    nothing are no longer valid.
    The truth is that of `load_truth` for the space. An `InputError` says that some light of the
    image is not reflected diffusely, or that no pixel is left.
    """
    found = image.result
    if found.residual[truth.mask].any():
        raise InputError(
            "has surfaces that are not diffuse, so its direct shading is not known; render the set "
            "with --materials lambertian",
            image.folder,
        )
    if found.fluorescence[truth.mask].any() and "fluorescence_direct" not in found.buffers:
        raise InputError(
            "has surfaces that fluoresce, and not how much of that direct light excites; add "
            "fluorescence_direct to --buffers and render again",
            image.folder,
        )
    reflected = found.direct - found.buffers.get("fluorescence_direct", 0.0)
    reflectance = found.reflectance.astype(np.float64)
    mask = truth.mask & (reflectance > 0.0).all(axis=-1)
    if not mask.any():
        raise InputError("has no pixel that reflects all bands; leave it out", image.folder)
    shading = np.divide(reflected, reflectance, where=mask[..., None],
                        out=np.zeros(reflectance.shape))  # fmt: skip
    light = {"direct": found.direct, "shading": shading.astype(np.float32)}
    if space == "rgb":
        apart = Result(light, {}, found.bands, found.record)
        light = {name: apart.rgb(name, rgb_method(found.bands), "D65") for name in light}
    radiance, seen = (light[name].astype(np.float64) for name in ("direct", "shading"))
    return replace(
        truth,
        radiance=radiance / white_level(radiance, mask),
        shading=seen / white_level(seen, mask),
        mask=mask,
        errors={},
    )


LIGHTS = ("all", "direct")
"""The light that images are seen in: all of it, or without interreflection."""


@dataclass(frozen=True, eq=False)
class Shot:
    """An image of a data set: its ground truth, what a method sees, and of which kind it is."""

    truth: Truth
    view: View
    kind: Kind


def open_finished(folder: Path) -> Dataset:
    """Open a data set; if it is none, or images are missing, that is an `InputError`."""
    images = open_dataset(folder)
    there = {image.name for image in images}
    if missing := [name for name in images.head["images"] if name not in there]:
        raise InputError(
            f"the data set is not finished, {len(missing)} of {len(images.head['images'])} images "
            f"are missing ({listed(missing, 3)}); run it again with --resume",
            folder,
        )
    if not there:
        raise InputError("the data set has no images; run it again with --resume", folder)
    return images


def shots(images: Dataset, space: str, light: str = LIGHTS[0]) -> Iterator[Shot]:
    """Yield the images in a space and one of `LIGHTS`, those of one view of a scene in a row."""
    views: dict[Any, list[Image]] = {}
    for image in images:
        job = image.entry["job"]
        view = image.geometry, job["seed"], *sorted(job["view"].items())
        views.setdefault(view, []).append(image)
    for group in views.values():
        truths = [load_truth(image, space) for image in group]
        if light == "direct":
            pairs = zip(group, truths, strict=True)
            truths = [in_direct_light(image, truth, space) for image, truth in pairs]
        relit = tuple(np.where(truth.mask[..., None], truth.radiance, np.nan) for truth in truths)
        for image, truth in zip(group, truths, strict=True):
            seen = View(truth.name, truth.radiance, truth.mask, relit)
            yield Shot(truth, seen, kind_of(image))
