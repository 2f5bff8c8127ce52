"""The kinds of images that the first data set of this sort distinguished.

S. Beigpour, M. Serra, J. van de Weijer, R. Benavente, M. Vanrell, O. Penacchio and D. Samaras,
"Intrinsic image evaluation on synthetic complex scenes", ICIP 2013: single objects or complex
scenes, in white light, light of one colour, or two lights.
"""

from __future__ import annotations

from typing import NamedTuple

from photonmap.dataset.files.reader import Image
from photonmap.dataset.scenes.illumination import WHITE
from photonmap.dataset.scenes.rooms.catalogue import ROOMS
from photonmap.dataset.scenes.single_objects import OBJECTS

OBJECT, COMPLEX = "objects", "complex scenes"
WHITE_LIGHT, ONE_LIGHT, TWO_LIGHTS = "white", "one colour", "two lights"
CONTENTS = (OBJECT, COMPLEX)
LIGHTS = (WHITE_LIGHT, ONE_LIGHT, TWO_LIGHTS)


class Kind(NamedTuple):
    """What an image shows, "" where that is not known."""

    content: str
    """one of `CONTENTS`"""
    light: str
    """one of `LIGHTS`"""


def kind_of(image: Image) -> Kind:
    """Return the kind of an image; scenes from files have no known content."""
    job = image.entry["job"]
    scene, colors = job.get("scene"), job.get("colors") or []
    content = OBJECT if scene in OBJECTS else COMPLEX if scene in ROOMS else ""
    if not colors:
        return Kind(content, "")
    one = WHITE_LIGHT if list(colors) == [WHITE] else ONE_LIGHT
    return Kind(content, TWO_LIGHTS if len(colors) > 1 else one)
