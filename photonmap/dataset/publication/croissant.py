"""Metadata of a data set in Croissant, the JSON-LD of MLCommons, with its RAI fields."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from photonmap.dataset.files.manifest import LINES
from photonmap.dataset.files.reader import Dataset
from photonmap.dataset.publication.card import License

_CONTEXT = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileProperty": "cr:fileProperty",
    "fileObject": "cr:fileObject",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}
"""The context that Croissant 1.0 recommends."""
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
    """Return the metadata of a data set.

    Parameters
    ----------
    digests : SHA-256 of its files by path
    """
    return {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": title,
        "description": f"{len(images)} renders of {len(images.geometries)} scenes as ground truth "
        "for intrinsic images, with standard errors.",
        "license": license_.url or license_.name,
        "version": "1.0.0",
        **_responsible(images),
        "distribution": [_manifest(digests), *_file_sets(images)],
        "recordSet": [_records()],
    }


def _responsible(images: Dataset) -> dict[str, Any]:
    """Return the fields of the vocabulary for responsible AI."""
    return {
        "rai:dataCollection": "Simulated: scenes built by rules from seeds, rendered by photon "
        "mapping with photonmap. No person took part, and none is shown.",
        "rai:dataCollectionType": "Synthetic",
        "rai:dataLimitations": "Objects, rooms and lights follow rules, not measured statistics of "
        "the world. Values have the standard errors that the files state.",
        "rai:dataUseCases": "Training and evaluation of methods that separate reflectance from "
        "light, of colour constancy, and of methods that estimate geometry.",
        "rai:personalSensitiveInformation": "None.",
        "rai:dataAnnotationProtocol": "Annotations are computed from the scenes: ids, boxes and "
        "masks are those of the surfaces at the centres of the pixels.",
    }


def _manifest(digests: Mapping[str, str]) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": LINES,
        "name": LINES,
        "description": "one line of JSON for each image",
        "contentUrl": LINES,
        "encodingFormat": "application/jsonlines",
        "sha256": digests[LINES],
    }


def _file_sets(images: Dataset) -> list[dict[str, Any]]:
    """Return the files of all images by their kinds."""
    kinds = {"exr": "image/x-exr", "hdf5": "application/x-hdf5", "png": "image/png"}
    return [
        {
            "@type": "cr:FileSet",
            "@id": f"{kind}-files",
            "name": f"{kind}-files",
            "encodingFormat": kinds[kind],
            "includes": f"**/*.{kind}",
        }
        for kind in images.head["formats"]
    ]


def _records() -> dict[str, Any]:
    return {
        "@type": "cr:RecordSet",
        "@id": "images",
        "name": "images",
        "field": [
            {
                "@type": "cr:Field",
                "@id": f"images/{name}",
                "name": name,
                "description": meaning,
                "dataType": kind,
                "source": {"fileObject": {"@id": LINES}, "extract": {"column": name}},
            }
            for name, (kind, meaning) in _FIELDS.items()
        ],
    }
