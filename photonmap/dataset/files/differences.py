"""How what a data set was begun with differs from what it is to be resumed with, in words."""

from __future__ import annotations

from typing import Any

from photonmap.dataset.files.inputs import CURVES
from photonmap.spectra.sensor_curves import table_of

_FILES = {"formats": "--format", "full": "--full", "sensor": "--sensor", "buffers": "--buffers"}
"""Options that decide what files hold, apart from what decides the arrays, by key of the head."""
_NOT_COMPARED = ("munsell", "illuminants", "identity", "inputs")
"""Names of files, what identifies them, and the digest of what is in them, which has words."""

Pairs = dict[str, tuple[Any, Any]]
Head = dict[str, Any]


def describe_difference(there: Head, here: Head) -> str:
    """Describe how two heads differ in what the images of one set share; "" if they do not."""
    if there["format"] != here["format"]:
        return describe_differences({"format": (there["format"], here["format"])})
    options = {
        **{option: (there.get(key), here[key]) for key, option in _FILES.items()},
        **_common(there["common"], here["common"]),
    }
    options["--sensor"] = (_sensor(there), _sensor(here))
    begun = [_begun(name, *pair) for name, pair in options.items() if pair[0] != pair[1]]
    if there["common"].get("inputs") != here["common"]["inputs"]:
        begun.append("with other curves of bands or measured sets")
    words = f"it was begun {' and '.join(begun)}" if begun else ""
    versions = describe_differences(
        {name: (there["versions"].get(name), value) for name, value in here["versions"].items()}
    )
    if not words and not versions and not set(there["images"]) & set(here["images"]):
        return f"preset {there['preset']} and other seeds there, {here['preset']} here"
    return "; ".join(filter(None, [words, versions]))


def describe_differences(pairs: Pairs) -> str:
    """Describe the pairs whose values, there and here, differ; "" if none does."""
    return ", ".join(
        f"{name} {_typed(there)} there, {_typed(here)} here"
        for name, (there, here) in pairs.items()
        if there != here
    )


def _common(there: dict[str, Any], here: dict[str, Any]) -> Pairs:
    """Return the settings of all images by option, but for files that `inputs` tells apart."""
    pairs = {name: (there.get(name), here[name]) for name in here if name not in _NOT_COMPARED}
    if here.get("identity"):
        for name in CURVES:
            if all(map(table_of, pairs[name])):
                del pairs[name]
    return {f"--{name}": pair for name, pair in pairs.items()}


def _sensor(head: Head) -> dict[str, Any] | None:
    """Return what a head says of its sensor, but for the name of its file of sensitivities."""
    sensor = head.get("sensor")
    if sensor is None or table_of(sensor["camera"]) is None:
        return sensor
    return {**sensor, "camera": "a file"}


def _begun(option: str, there: Any, here: Any) -> str:
    """Say what was given, or left out, when a set was begun.

    >>> _begun("--full", False, True), _begun("--size", [8, 6], [4, 3])
    ('without --full', 'with --size 8x6, not 4x3')
    """
    if option == "--recolor":
        return f"with recolor = {str(bool(there)).lower()} in its preset"
    if there is None or there is False:
        return f"without {option}"
    if isinstance(there, dict):
        return f"with {option}" if here is None else f"with another {option}"
    given = "" if there is True else f" {_typed(there, option)}"
    other = f", not {_typed(here, option)}" if here else ""
    return f"with {option}{given}{other}"


def _typed(value: Any, option: str = "") -> str:
    """Return a value as it is typed."""
    if isinstance(value, list | tuple):
        return ("x" if option == "--size" else ",").join(map(str, value))
    return "none" if value is None else str(value)
