"""Objects and cameras of all images, in the formats of COCO and of OpenCV and OpenGL."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.files.reader import Dataset, Image
from photonmap.dataset.publication.categories import Category, categories_of, kind_of
from photonmap.dataset.publication.licenses import License


def encode_mask(mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Return a mask in COCO's uncompressed run-length encoding.

    Runs go down the columns, and begin with those outside the mask.

    Examples
    --------
    >>> encode_mask(np.array([[False, True], [True, True]]))
    {'size': [2, 2], 'counts': [1, 3]}
    """
    flat = mask.ravel(order="F")
    ends = np.flatnonzero(np.diff(flat)) + 1
    runs = np.diff(np.concatenate([[0], ends, [flat.size]])).tolist()
    return {"size": list(mask.shape), "counts": [0, *runs] if flat.size and flat[0] else runs}


def describe_coco(images: Dataset, license_: License) -> dict[str, Any]:
    """Return boxes and masks of all objects that are seen, as COCO's JSON has them.

    Every object at the centre of a pixel counts, walls and lights included. Categories are kinds of
    objects, whose numbers are the same in all sets, with the labels of NYU40 and COCO.
    """
    categories = categories_of(name for entry in images.entries for name in entry["objects"])
    listed: list[dict[str, Any]] = []
    annotations: list[dict[str, Any]] = []
    for number, image in enumerate(images, 1):
        width, height = image.entry["size"]
        file = f"{image.name}/radiance.png"
        size = {"width": width, "height": height}
        listed.append({"id": number, "file_name": file, **size, "license": 1})
        for annotation in _objects(image, categories):
            annotations.append({"id": len(annotations) + 1, "image_id": number, **annotation})
    return {
        "info": {"description": f"objects of a data set of {len(images)} renders"},
        "licenses": [{"id": 1, "name": license_.name, "url": license_.url}],
        "images": listed,
        "annotations": annotations,
        "categories": [each.describe() for each in categories.values()],
    }


def _objects(image: Image, categories: dict[str, Category]) -> Iterable[dict[str, Any]]:
    ids = image["object_id"]
    for number in np.unique(ids[ids > 0]).tolist():
        mask, name = ids == number, image.entry["objects"][number - 1]
        rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
        left, top = int(columns[0]), int(rows[0])
        yield {
            "category_id": categories[kind_of(name)].number,
            "object": name,
            "bbox": [left, top, int(columns[-1]) - left + 1, int(rows[-1]) - top + 1],
            "area": int(mask.sum()),
            "segmentation": encode_mask(mask),
            "iscrowd": 0,
        }


def describe_cameras(images: Dataset) -> dict[str, Any]:
    """Return the cameras of all images by name, with their matrices in both conventions."""
    return {
        "conventions": {
            "camera_to_world": "OpenGL: x right, y up, the view along -z; scene units",
            "camera_to_world_opencv": "OpenCV: x right, y down, the view along z; scene units",
            "intrinsics": "pixels; the centre of the first pixel is at (0.5, 0.5)",
        },
        "images": {
            entry["name"]: {
                "scene": entry["geometry"],
                "view": entry["job"]["view"],
                "size": entry["size"],
                **entry["camera"],
            }
            for entry in images.entries
        },
    }
