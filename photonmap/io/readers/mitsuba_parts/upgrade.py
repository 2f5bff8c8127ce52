"""Names of Mitsuba 0.x, in files of a version below 2, as those of Mitsuba 3."""

from __future__ import annotations

import re
from dataclasses import replace

from photonmap.io.readers.mitsuba_parts.xml import Element
from photonmap.runtime.wording import shown

_CAMEL = re.compile("(?<=[a-z])[A-Z]+")
_TAGS = {"lookAt": "lookat", "luminaire": "emitter", "camera": "sensor"}


def is_old(root: Element) -> bool:
    """Return whether a file's root has a version below 2.

    Raises
    ------
    InputError : its version is not a number
    """
    version = root.attributes.get("version", "3.0.0")
    major = version.partition(".")[0]
    if not (major.isascii() and major.isdigit()):
        raise root.error(f'version {shown(version)} is none of Mitsuba; write version="3.0.0"')
    return int(major[:9]) < 2


def upgraded(element: Element) -> Element:
    """Return an element with the names of Mitsuba 3: `to_world` for `toWorld`."""
    attributes = dict(element.attributes)
    if "name" in attributes and element.tag != "default":
        attributes["name"] = _CAMEL.sub(lambda word: f"_{word[0].lower()}", attributes["name"])
    return replace(element, tag=_TAGS.get(element.tag, element.tag), attributes=attributes)
