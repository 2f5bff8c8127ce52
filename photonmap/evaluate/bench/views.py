"""The images of a data set as methods see them, one view of a scene in all its lights at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.dataset.files.reader import Dataset, Image, open_dataset
from photonmap.errors import InputError
from photonmap.evaluate.bench.direct_light import in_direct_light
from photonmap.evaluate.bench.kinds import Kind, kind_of
from photonmap.evaluate.bench.truth import Truth, load_truth
from photonmap.evaluate.methods.method import View
from photonmap.runtime.wording import listed

LIGHTS = ("all", "direct")
"""The light that images are seen in: all of it, or without interreflection."""


@dataclass(frozen=True, eq=False)
class Shot:
    """An image of a data set: its ground truth, what a method sees, and of which kind it is."""

    truth: Truth
    view: View
    kind: Kind


def open_finished(folder: Path) -> Dataset:
    """Open a data set of which all images are there.

    Raises
    ------
    InputError : the folder holds no data set, or images are missing
    """
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
    """Yield the images, those of one view of a scene after each other.

    Parameters
    ----------
    space : as `photonmap.evaluate.bench.truth.load_truth` takes it
    light : one of `LIGHTS`
    """
    views: dict[Any, list[Image]] = {}
    for image in images:
        views.setdefault(_view_of(image), []).append(image)
    for group in views.values():
        truths = [load_truth(image, space) for image in group]
        if light == "direct":
            pairs = zip(group, truths, strict=True)
            truths = [in_direct_light(image, truth, space) for image, truth in pairs]
        relit = tuple(np.where(truth.mask[..., None], truth.radiance, np.nan) for truth in truths)
        for image, truth in zip(group, truths, strict=True):
            view = View(truth.name, truth.radiance, truth.mask, relit)
            yield Shot(truth, view, kind_of(image))


def _view_of(image: Image) -> tuple[Any, ...]:
    """Return what images share that differ in light alone."""
    job = image.entry["job"]
    return image.geometry, job["seed"], *sorted(job["view"].items())
