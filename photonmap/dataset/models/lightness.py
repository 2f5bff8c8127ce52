"""Lighter or darker Munsell chips, until a scene's surfaces reflect as much as is asked for."""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from photonmap.dataset.models.palette import COAT, GLAZED, chips
from photonmap.dataset.models.scene_object import SceneObject
from photonmap.errors import InputError
from photonmap.scene.material import Material
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.munsell import munsell

_GREY = re.compile(r"N(\d)")
_LIGHTEST, _DARKEST = 9, 2
"""Munsell values of the grey chips."""
_MOST_STEPS = 7.0
"""The most steps of Munsell value by which all chips become lighter or darker."""
_HALVINGS = 14
"""Halvings of the interval in which the step is searched."""


def with_lightness(objects: Sequence[SceneObject], mean: float | None) -> Sequence[SceneObject]:
    """Return objects whose chips are so much lighter or darker that they reflect a mean.

    It is met as nearly as whole chips allow: closely in rooms, less so where one chip covers most
    of a scene. Chips keep their hue, and their chroma as nearly as there are chips. What is no
    chip, such as metal, stays as it is, and so do emitters.

    Parameters
    ----------
    mean : reflectance over all wavelengths and the area of all surfaces; None changes nothing

    Raises
    ------
    InputError : no chips reflect so much, or so little
    """
    if mean is None:
        return objects
    areas = dict[str, float]()
    known = dict[str, Material]()
    for part in (part for obj in objects for part in obj.parts if not part.light_group):
        name = part.material.name
        known[name] = part.material
        areas[name] = areas.get(name, 0.0) + part.shape.area
    weights = np.array(list(areas.values())) / sum(areas.values())

    def mean_at(step: float) -> float:
        return float(weights @ [reflectance_of(_shifted(m, step)) for m in known.values()])

    low, high = -_MOST_STEPS, _MOST_STEPS
    least, most = mean_at(low), mean_at(high)
    if not least <= mean <= most:
        raise InputError(
            f"lightness {mean:g} is out of reach: with Munsell chips the scene reflects "
            f"{least:.2f} to {most:.2f}"
        )
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if mean_at(middle) < mean else (low, middle)
    step = min((low, high), key=lambda each: abs(mean_at(each) - mean))
    changed = {name: _shifted(m, step) for name, m in known.items()}
    return [
        replace(
            obj,
            parts=[
                part if part.light_group else replace(part, material=changed[part.material.name])
                for part in obj.parts
            ],
        )
        for obj in objects
    ]


def reflectance_of(material: Material) -> float:
    """Return the mean reflectance of a material over its wavelengths, diffuse and mirrored."""
    paint = material.reflectance
    diffuse = float(paint.values.mean()) if isinstance(paint, Spectrum) else 0.0
    mirrored = material.mirror if isinstance(material.mirror, float) else 0.0
    return diffuse + mirrored


def _shifted(material: Material, step: float) -> Material:
    """Return a material whose chip is lighter by a number of values, rounded up or down."""
    name = material.name.removeprefix(GLAZED)
    dither = zlib.crc32(name.encode()) / 2.0**32
    chip = _chip_beside(name, math.floor(step + dither))
    if chip is None:
        return material
    if name == material.name:
        return _bare(chip)
    return _glazed(chip)


@cache
def _bare(chip: str) -> Material:
    return Material(chip, munsell(chip))


@cache
def _glazed(chip: str) -> Material:
    return Material(f"{GLAZED}{chip}", (1.0 - COAT) * munsell(chip), mirror=COAT)


@cache
def _chip_beside(name: str, shift: int) -> str | None:
    """Return the chip that is `shift` values lighter; None if the name is not that of a chip."""
    if grey := _GREY.fullmatch(name):
        return f"N{min(max(int(grey[1]) + shift, _DARKEST), _LIGHTEST)}"
    names, rows = chips()
    if name not in names:
        return None
    hue, value, chroma = rows[names.index(name)]
    turn = np.abs((rows[:, 0] - hue + 50.0) % 100.0 - 50.0)
    cost = 100.0 * np.abs(rows[:, 1] - value - shift) + turn + 0.5 * np.abs(rows[:, 2] - chroma)
    return names[int(np.argmin(cost))]
