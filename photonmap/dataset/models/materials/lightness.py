"""Lighter or darker Munsell chips, until a scene's surfaces reflect as much as is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from photonmap.dataset.models.materials.surfaces import reflectance_of, surface_of, whole_step
from photonmap.dataset.models.scene_object import SceneObject
from photonmap.errors import InputError
from photonmap.scene.material import Material

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


def _shifted(material: Material, step: float) -> Material:
    """Return a material whose chip is lighter by a number of values, rounded up or down."""
    surface = surface_of(material.name)
    lighter = surface.lighter(whole_step(surface.chip, step))
    return material if lighter is None else lighter.material()
