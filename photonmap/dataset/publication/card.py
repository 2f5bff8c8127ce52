"""The data card of a data set, filled from its manifest, and its licence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.dataset.files.manifest import lines_of
from photonmap.dataset.files.reader import Dataset
from photonmap.dataset.report.page import BINS
from photonmap.errors import InputError
from photonmap.runtime.wording import enumerated, suggest

_NAMES = {
    "CC0-1.0": ("CC0 1.0 Universal", "publicdomain/zero/1.0"),
    "CC-BY-4.0": ("Creative Commons Attribution 4.0 International", "licenses/by/4.0"),
    "CC-BY-SA-4.0": (
        "Creative Commons Attribution-ShareAlike 4.0 International", "licenses/by-sa/4.0",
    ),
    "CC-BY-NC-4.0": (
        "Creative Commons Attribution-NonCommercial 4.0 International", "licenses/by-nc/4.0",
    ),
}  # fmt: skip
NAMES = tuple(_NAMES)
"""SPDX names of the licences."""


@dataclass(frozen=True)
class License:
    """A licence."""

    name: str  # of SPDX, or that of the user's file
    url: str  # of its text; "" for the user's
    text: str  # of the file LICENSE


def find_license(name: str) -> License:
    """Return a licence by its SPDX name, or one of the user's from a file of its text."""
    if name in _NAMES:
        title, place = _NAMES[name]
        url = f"https://creativecommons.org/{place}/"
        text = f"This data set is licensed under {title}.\n\nThe legal code is at\n{url}legalcode\n"
        return License(name, url, text)
    if not Path(name).is_file():
        raise InputError(f"there is no license {name!r}; {suggest(name, NAMES)} (or give a file)")
    return License(Path(name).name, "", Path(name).read_text(encoding="utf-8"))


_SIZES = ((1000, "n<1K"), (10_000, "1K<n<10K"), (100_000, "10K<n<100K"), (10**6, "100K<n<1M"))
"""Categories of Hugging Face's cards by the numbers of images below which they hold."""

_LISTED = 12  # combinations of lights that are listed of an illumination


def how_to_read(layout: str, has_annotations: bool = True) -> str:
    """Return how the files of a layout are read, in Markdown; "folder" is that of `publish`."""
    annotations = "`annotations.json` the objects in COCO's format, " * has_annotations
    return _read(f"reading_{layout}").removesuffix("\n").replace("{annotations}", annotations)


def _read(name: str) -> str:
    """Return a text of this package."""
    return Path(__file__).with_name(f"{name}.md").read_text(encoding="utf-8")


def write_card(
    images: Dataset, license_: License, title: str, reading: str, head: Sequence[str] = ()
) -> str:
    """Return the data card in Markdown, with the head that Hugging Face reads.

    `reading` says how the files are read; `head` has further lines of the head, in YAML.
    """
    entries, common = images.entries, images.head["common"]
    width, height = common["size"]
    versions = (f"{name} {version}" for name, version in images.head["versions"].items())
    return _read("card").format(
        license_id=license_.name.lower() if license_.url else "other",
        size=next((name for most, name in _SIZES if len(entries) < most), "n>1M"),
        head="".join(f"\n{line}" for line in head),
        title=title,
        count=len(entries),
        scenes=len(images.geometries),
        images="\n".join([*_counts(images), *_left_out(images)]),
        distributions="\n".join(_distributions(entries)),
        errors="\n".join(_errors(entries)),
        preset=Path(images.head["preset"]).name,
        width=width,
        height=height,
        **{name: common[name] for name in ("bands", "error", "materials")},
        rgb=common.get("rgb", "srgb"),
        versions=", ".join(versions),
        reading=reading,
        licence=_licence(common, license_),
    )


def _table(names: Sequence[str], rows: Iterable[Sequence[Any]]) -> list[str]:
    lines = [names, ["---"] * len(names), *rows]
    return [f"| {' | '.join(str(cell) for cell in row)} |" for row in lines]


def _counts(images: Dataset) -> list[str]:
    entries = images.entries
    columns = {
        "type of scene": Counter(entry["geometry"].rpartition("-")[0] for entry in entries),
        "illumination": Counter(entry["job"]["illumination"] for entry in entries),
        "view": Counter(name for entry in entries if (name := entry["job"]["view"]["name"])),
        "split": Counter(entry.get("split", "none") for entry in entries),
    }
    lines: list[str] = []
    for name, counts in columns.items():
        if counts:
            lines += [*_table((name, "images"), sorted(counts.items())), ""]
    lines += [*_table(("illumination", "its lights"), sorted(_lights(entries).items())), ""]
    seeds = sorted({entry["job"]["seed"] for entry in entries})
    photos = sum(entry.get("photo") is not None for entry in entries)
    also = f"; {photos} images have a photo of a simulated sensor" if photos else ""
    return [*lines, f"Seeds of scenes: {seeds[0]} to {seeds[-1]}{also}."]


def _lights(entries: Sequence[dict[str, Any]]) -> dict[str, str]:
    """Return the lights of each illumination, the most frequent first, with shares if chosen."""
    found: dict[str, Counter[str]] = {}
    for job in (entry["job"] for entry in entries):
        shares = [f" {share:.0%}" for share in job.get("shares", ())] or [""] * len(job["colors"])
        lights = (f"`{color}`{share}" for color, share in zip(job["colors"], shares, strict=True))
        found.setdefault(job["illumination"], Counter())[" + ".join(lights)] += 1
    return {
        name: enumerated([lights for lights, _ in counts.most_common()], _LISTED)
        for name, counts in found.items()
    }


def _left_out(images: Dataset) -> list[str]:
    """Return a list of the scene files that could not be read, with a head; nothing if none."""
    lines = [f"- {line}" for line in lines_of(images.head)]
    return ["", "Left out, as they could not be read:", "", *lines] if lines else []


def _distributions(entries: Sequence[dict[str, Any]]) -> list[str]:
    rows = []
    for name, label in (
        ("reflectance", "reflectance"),
        ("illuminant_red", "red fraction of the light in sRGB"),
        ("illuminant_blue", "blue fraction of the light in sRGB"),
    ):
        histogram = np.sum([entry["statistics"][name] for entry in entries], axis=0)
        total = np.cumsum(histogram) / max(histogram.sum(), 1)
        marks = [(np.searchsorted(total, part) + 0.5) / BINS for part in (0.1, 0.5, 0.9)]
        rows.append((label, *(f"{mark:.2f}" for mark in marks)))
    return _table(("over valid pixels", "10%", "median", "90%"), rows)


def _errors(entries: Sequence[dict[str, Any]]) -> list[str]:
    errors = [entry["error"] for entry in entries if entry["error"] is not None]
    residuals = [entry["rgb"]["residual"] for entry in entries]
    negative = [share for entry in entries if (share := entry["rgb"].get("negative")) is not None]
    direct = [s for entry in entries if (s := entry["statistics"]["direct_share"]) is not None]
    hours = sum(entry["cpu_seconds"] for entry in entries) / 3600.0
    rows = [
        ("relative error of radiance, bias included", *_spread(errors)),
        ("residual of RGB", *_spread(residuals)),
        ("share of pixels with a negative channel in RGB", *_spread(negative)),
        ("direct / (direct + indirect)", *_spread(direct)),
    ]
    missed = sum(not entry["reached"] for entry in entries)
    return [
        *_table(("", "mean", "largest"), rows),
        "",
        f"{missed} images missed the error that was aimed at. Rendering took {hours:.2f} processor "
        "hours.",
    ]


def _spread(values: Sequence[float]) -> tuple[str, str]:
    return (f"{np.mean(values):.4f}", f"{max(values):.4f}") if values else ("–", "–")


_INCLUDED = {
    "munsell": "Munsell chips are spectra that photonmap (MIT) recovered from the renotation of "
    "Newhall, Nickerson and Judd (1943), as colour-science (BSD-3-Clause) has it.",
    "illuminants": "Spectra of lights are the CIE's, as colour-science (BSD-3-Clause) has them, or "
    "follow formulas.",
}
"""Sources of the spectra that photonmap includes, and their licences, by the option for others."""


def _licence(common: dict[str, Any], license_: License) -> str:
    sets = {"munsell": "Munsell chips", "illuminants": "spectra of lights"}
    given = [f"{label} of `{common[name]}`" for name, label in sets.items() if common.get(name)]
    own = [text for name, text in _INCLUDED.items() if not common.get(name)]
    measured = (
        f"The images were made from {' and '.join(given)}; those measurements have licences of "
        "their own, and are not part of this set. "
    )
    where = f" ({license_.url})" if license_.url else ""
    text = f"{license_.name}{where}, see `LICENSE`. {measured if given else ''}{' '.join(own)}"
    return text.strip()
