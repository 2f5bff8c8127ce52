"""What programs read of a data set: objects as COCO has them, cameras, and Croissant metadata."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.files.manifest import LINES
from photonmap.dataset.files.reader import Dataset, Image
from photonmap.dataset.publication.card import License
from photonmap.errors import InputError

FIRST_OWN = 1001
"""Number of the first kind of objects that is not in the table, such as those of users' scenes."""
OTHER = "other"
"""The supercategory of those."""
_FOLDER = Path(__file__).parent

Label = dict[str, str | int]
"""The id and the name of a class of another data set."""


@dataclass(frozen=True)
class Category:
    """A kind of objects."""

    number: int  # the same in every set, if the kind is known
    name: str  # of the kind, in the singular where there may be several: "chair"
    group: str = OTHER  # to which it belongs, COCO's supercategory: "seat"
    nyu40: Label | None = None  # in the 40 classes of NYU Depth V2; None where none is known
    coco: Label | None = None  # category of COCO 2017; None where there is none

    def describe(self) -> dict[str, object]:
        """Return it as an item of "categories" in COCO's JSON, with the labels of other sets."""
        return {
            "id": self.number,
            "name": self.name,
            "supercategory": self.group,
            "nyu40": self.nyu40,
            "coco": self.coco,
        }


def _read_categories() -> dict[str, Category]:
    """Return the known categories by their names, each from a line of the table."""

    def label(row: dict[str, str], name: str) -> Label | None:
        return {"id": int(row[f"{name}_id"]), "name": row[name]} if row[name] else None

    with (_FOLDER / "categories.csv").open(encoding="utf-8", newline="") as file:
        return {
            row["name"]: Category(
                int(row["number"]),
                row["name"],
                row["group"],
                label(row, "nyu40"),
                label(row, "coco"),
            )
            for row in csv.DictReader(file)
        }


CATEGORIES = _read_categories()
"""All kinds of objects in generated scenes, by name. Numbers are published: new kinds come last.

Labels are those of NYU Depth V2 in 40 classes (Gupta et al. 2013), as in ScanNet and Hypersim, and
of COCO 2017.
"""


def kind_of(name: str) -> str:
    """Return the kind of an object: "vase" of "vase 2"."""
    return re.sub(r" \d+$", "", name)


def categories_of(objects: Iterable[str]) -> dict[str, Category]:
    """Return the categories of objects by kind; kinds that are not known are numbered by name."""
    kinds = {kind_of(name) for name in objects}
    own = sorted(kinds - {*CATEGORIES})
    unknown = {kind: Category(FIRST_OWN + place, kind) for place, kind in enumerate(own)}
    known = {kind: each for kind, each in CATEGORIES.items() if kind in kinds}
    return known | unknown


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
        size = dict(zip(("width", "height"), image.entry["size"], strict=True))
        file = f"{image.name}/radiance.png"
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
    ids, (width, height) = image["object_id"], image.entry["size"]
    if ids.shape != (height, width) or ids.max(initial=0) > len(image.entry["objects"]):
        problem = f"{image.name}: its size and objects are not those of its files"
        raise InputError(f"{problem}; see what `dataset verify` finds", image.folder)
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


_FIELDS = {
    "name": ("sc:Text", "the image, and its folder"),
    "geometry": ("sc:Text", "the scene, whatever its light, colours and view"),
    "split": ("sc:Text", "train, val or test"),
    "error": ("sc:Float", "relative error of radiance, bias included"),
}
"""Fields of the images, which are keys of the manifest's lines: type and meaning."""


def describe_croissant(
    images: Dataset, license_: License, title: str, digests: Mapping[str, str]
) -> dict[str, Any]:
    """Return the metadata of a data set; digests are SHA-256 of its files by path."""
    kinds = {"exr": "image/x-exr", "hdf5": "application/x-hdf5", "png": "image/png"}
    lines = {"contentUrl": LINES, "encodingFormat": "application/jsonlines"}
    text = "one line of JSON for each image"
    manifest = _node("FileObject", LINES, description=text, **lines, sha256=digests[LINES])
    files = [
        _node("FileSet", f"{kind}-files", encodingFormat=kinds[kind], includes=f"**/*.{kind}")
        for kind in images.head["formats"]
    ]
    fields = []
    for name, (kind, meaning) in _FIELDS.items():
        source = {"fileObject": {"@id": LINES}, "extract": {"column": name}}
        about = {"description": meaning, "dataType": kind, "source": source}
        fields.append(_node("Field", f"images/{name}", **about) | {"name": name})
    # the context that Croissant 1.0 recommends, and the fields of its vocabulary for responsible AI
    template = json.loads((_FOLDER / "croissant.json").read_text(encoding="utf-8"))
    return template | {
        "name": title,
        "description": f"{len(images)} renders of {len(images.geometries)} scenes as ground truth "
        "for intrinsic images, with standard errors.",
        "license": license_.url or license_.name,
        "distribution": [manifest, *files],
        "recordSet": [_node("RecordSet", "images", field=fields)],
    }


def _node(kind: str, name: str, **fields: Any) -> dict[str, Any]:
    return {"@type": f"cr:{kind}", "@id": name, "name": name, **fields}
