"""Keys, kinds and ranges of what manifest.json and the lines of manifest.jsonl hold."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from photonmap.dataset.files.splits import PARTS
from photonmap.runtime.wording import shown

LARGEST = 2**63 - 1
"""Largest whole number, which a seed may be."""


class Kind(NamedTuple):
    """A kind of values."""

    test: Callable[[Any], bool]
    words: str  # what a value must be, as in "must be …"


class Maybe(NamedTuple):
    """None, or a value of a kind."""

    kind: Any


class Later(NamedTuple):
    """The value of a key that earlier sets lack; without it, a default holds."""

    kind: Any


class Table(NamedTuple):
    """Values of one kind by names."""

    kind: Any


def number(low: float = -math.inf, high: float = math.inf) -> Kind:
    """Return the kind of finite numbers within a range."""
    limits = [f" {word} {end:g}" for word, end in (("from", low), ("to", high)) if abs(end) < 1e300]

    def test(value: Any) -> bool:
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return is_number and low <= value <= high and abs(value) < math.inf

    return Kind(test, f"a finite number{''.join(limits)}")


def whole(low: int = 0, high: int = LARGEST) -> Kind:
    """Return the kind of whole numbers within a range."""

    def test(value: Any) -> bool:
        return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high

    return Kind(test, f"a whole number from {low} to {high}")


def one_of(*values: Any) -> Kind:
    """Return the kind of a few values."""
    return Kind(lambda value: value in values, f"one of {', '.join(map(shown, values))}")


def digest(digits: int) -> Kind:
    """Return the kind of hexadecimal digests."""
    pattern = re.compile(rf"[0-9a-f]{{{digits}}}")
    words = f"a digest of {digits} digits"
    return Kind(lambda value: isinstance(value, str) and bool(pattern.fullmatch(value)), words)


TEXT = Kind(lambda value: isinstance(value, str), "a text")
FLAG = Kind(lambda value: isinstance(value, bool), "true or false")
_NUMBER, _LENGTH, _SHARE = number(), number(0.0), number(0.0, 1.0)
_SECONDS = number(0.0, 1e9)  # 30 years: sums and differences of several stay finite
_SIZE = [whole(1, 2**20)] * 2
_BANDS = Maybe([_NUMBER, ...])
_MATRIX = [[_NUMBER, ...], ...]
_NAMES = [TEXT, ...]
_HISTOGRAM = [whole()] * 20  # bins, of `photonmap.dataset.report.page.BINS`
_COMMON = {
    "size": _SIZE, "bands": TEXT, "error": TEXT, "pixel": TEXT, "rgb": TEXT, "materials": TEXT,
    "lightness": Later(Maybe(_NUMBER)), "scale": Later(_NUMBER), "recolor": FLAG,
    "munsell": Maybe(TEXT), "illuminants": Maybe(TEXT), "inputs": TEXT,
    "identity": Later(one_of("content", "text")), "own_noise": Later(FLAG),
}  # fmt: skip
_VIEW = {"name": TEXT, "yaw": _NUMBER, "pitch": _NUMBER, "distance": number(1e-300)}
_LIGHT = {"illumination": TEXT, "colors": _NAMES, "shares": [_SHARE, ...], "spectra": _NAMES}
_JOB = {
    "scene": TEXT, "seed": whole(), "illumination": TEXT, "colors": _NAMES, "view": _VIEW,
    "common": _COMMON, "content": TEXT, "shares": Later([_SHARE, ...]),
    "spectra": Later(_NAMES),
}  # fmt: skip
ENTRY_KINDS = {
    "name": TEXT, "job": _JOB, "geometry": TEXT, "split": Later(one_of(*PARTS)),
    "render_seed": whole(), "together": Later(Maybe([_LIGHT, ...])),
    "lights": Table(_BANDS), "objects": _NAMES, "materials": _NAMES, "reflectances": Table(_BANDS),
    "camera": {"kind": TEXT},
    "size": _SIZE, "bands": whole(1), "passes": whole(1), "pass_samples": number(0.0),
    "error": Maybe(_LENGTH),
    "goal": Maybe({"limit": _LENGTH, "buffer": TEXT, "percentile": Maybe(number(0.0, 100.0)),
                   "reached": Maybe(_LENGTH)}),
    "reached": FLAG, "effects": Table([FLAG, TEXT]),
    "rgb": {"space": TEXT, "method": TEXT, "fit_residual": Maybe([_LENGTH, ...]),
            "residual": _LENGTH, "negative": Later(Maybe(_SHARE))},
    "statistics": {"direct_share": Maybe(_LENGTH), "valid": _SHARE, "reflectance": _HISTOGRAM,
                   "illuminant_red": _HISTOGRAM, "illuminant_blue": _HISTOGRAM},
    "unresolved": whole(), "versions": Table(TEXT), "fingerprint": {"kernels": TEXT},
    "warnings": _NAMES, "full": Later(FLAG), "buffers": Later(Maybe(_NAMES)),
    "arrays": Table(digest(16)),
    "photo": Later(Maybe({"time_s": _LENGTH, "saturated": _SHARE, "negative": _SHARE})),
    "files": Table(digest(64)), "cpu_seconds": _SECONDS,
    "seconds": dict.fromkeys(("build", "compile", "render", "write"), _SECONDS),
}  # fmt: skip
"""Of an image; `dataset verify` compares the values."""
HEAD_KINDS = {"format": TEXT, "images": _NAMES}
"""What readers need of the head."""
GROWN_HEAD_KINDS = HEAD_KINDS | {
    "preset": TEXT, "common": {"size": _SIZE, "bands": TEXT, "error": TEXT}, "formats": _NAMES,
    "versions": Table(TEXT),
}  # fmt: skip
"""What is needed to add images."""
WHOLE_HEAD_KINDS = GROWN_HEAD_KINDS | {
    "format": one_of("photonmap data set 1", "photonmap data set 2"), "common": _COMMON,
    "full": Later(FLAG), "buffers": Later(Maybe(_NAMES)),
    "sensor": Later(Maybe({"camera": TEXT, "sensitivities": digest(16)})),
    "choices": Later({"seed": whole(), "count": whole(1), "illuminations": _NAMES,
                      "materials": Maybe(TEXT), "lightness": Maybe(_NUMBER),
                      "scale": Maybe(_NUMBER)}),
    "left_out": Later([{"scene": TEXT, "reason": TEXT}, ...]),
    "split_sizes": Later(Table(_SIZE)),
}  # fmt: skip
"""All that a head has."""


def faults_of_entry(entry: Mapping[str, Any], is_old: bool) -> list[str]:
    """Return the values of an entry that are missing, of another kind, or out of range.

    Entries of the first format, which `is_old`, have fewer keys.
    """
    found = list(misfits(entry, ENTRY_KINDS))
    if not found:
        job, count = entry["job"], len(entry["job"]["colors"])
        uneven = [n for n in ("shares", "spectra") if len(job.get(n) or job["colors"]) != count]
        found = [f"job.{name} are not as many as job.colors" for name in uneven]
    return [fault for fault in found if not (is_old and fault.endswith(" is missing"))]


def misfits(value: Any, kind: Any, place: str = "") -> Iterator[str]:
    """Yield what is wrong with a value from JSON: its place, such as "job.seed", and its kind."""
    if isinstance(kind, Later):
        yield from misfits(value, kind.kind, place)
    elif isinstance(kind, Maybe):
        if value is not None:
            yield from misfits(value, kind.kind, place)
    elif isinstance(kind, Table | dict):
        yield from _misfits_of_table(value, kind, place)
    elif isinstance(kind, list):
        yield from _misfits_of_list(value, kind, place)
    elif not kind.test(value):
        yield f"{place} {shown(value)} must be {kind.words}"


def _misfits_of_table(value: Any, kind: Any, place: str) -> Iterator[str]:
    if not isinstance(value, Mapping):
        yield f"{place} {shown(value)} must be a table".lstrip()
        return
    kinds = dict.fromkeys(value, kind.kind) if isinstance(kind, Table) else kind
    for name, inner in kinds.items():
        where = f"{place}.{name}".lstrip(".")
        if name in value:
            yield from misfits(value[name], inner, where)
        elif not isinstance(inner, Later):
            yield f"{where} is missing"


def _misfits_of_list(value: Any, kind: list[Any], place: str) -> Iterator[str]:
    """Yield those of a list; one that ends with … has any number of values of its first kind."""
    is_open = kind[-1] is ...
    if not isinstance(value, list) or (not is_open and len(value) != len(kind)):
        count = "" if is_open else f" of {len(kind)}"
        yield f"{place} {shown(value)} must be a list{count}"
        return
    kinds = [kind[0]] * len(value) if is_open else kind
    for index, (each, inner) in enumerate(zip(value, kinds, strict=True)):
        yield from misfits(each, inner, f"{place}[{index}]")
