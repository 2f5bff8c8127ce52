"""Read transformations: moves, turns, scales, views and matrices, one after another."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from photonmap.io.readers.mitsuba_parts.values import (
    number_of,
    numbers_of,
    triple_of,
    vector_of,
)
from photonmap.io.readers.mitsuba_parts.xml import Element
from photonmap.runtime.wording import shown
from photonmap.scene.vectors import unit

Matrix = NDArray[np.float64]
_FLATTEST = 1e-30
"""Least determinant of the linear part."""


def read_transform(element: Element) -> Matrix:
    """Return the 4×4 matrix of a `<transform>`, whose steps are applied in their order.

    Raises
    ------
    InputError : a step is unknown or not valid, or all of them together are not affine or flatten
    """
    matrix = np.eye(4)
    for step in element.children:
        if step.tag not in _STEPS:
            known = ", ".join(_STEPS)
            raise step.error(f"<{shown(step.tag)[1:-1]}> is not a transformation; give {known}")
        with np.errstate(over="ignore", invalid="ignore"):
            matrix = _STEPS[step.tag](step) @ matrix
    if not np.isfinite(matrix).all() or (matrix[3] != [0.0, 0.0, 0.0, 1.0]).any():
        raise element.error("the transformation is not affine; correct its matrix")
    if abs(np.linalg.det(matrix[:3, :3])) < _FLATTEST:
        raise element.error("the transformation flattens everything; correct its scale")
    return matrix


def _translate(step: Element) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, 3] = vector_of(step, 0.0)
    return matrix


def _scale(step: Element) -> Matrix:
    return np.diag([*vector_of(step, 1.0), 1.0])


def _rotate(step: Element) -> Matrix:
    """Return a turn about an axis by degrees: Rodrigues' formula."""
    axis = unit(np.array(vector_of(step, 0.0)))
    if axis is None:
        raise step.error("the axis of a rotation is 0; give its x, y or z")
    angle = math.radians(number_of(step, step.attribute("angle")))
    x, y, z = axis.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.eye(4)
    matrix[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return matrix


def _look_at(step: Element) -> Matrix:
    """Return a frame at the origin whose z leads to the target, and whose y is nearest to up."""
    origin, target = np.array(triple_of(step, "origin")), np.array(triple_of(step, "target"))
    view = unit(target / 2 - origin / 2)
    if view is None:
        raise step.error("target and origin are the same; move one of them")
    up = np.array(triple_of(step, "up")) if "up" in step.attributes else np.zeros(3)
    if not up.any():
        up, _ = side_axes(view)
    left = unit(np.cross(up, view))
    if left is None:
        raise step.error("up is parallel to the view; choose another direction")
    matrix = np.eye(4)
    matrix[:3] = np.stack([left, np.cross(view, left), view, origin], axis=1)
    return matrix


def _matrix(step: Element) -> Matrix:
    """Return a matrix, row by row: all 16 numbers, or the 9 of its linear part."""
    values = numbers_of(step, step.attribute("value"))
    if len(values) not in (9, 16):
        raise step.error(f"a matrix has {len(values)} numbers; give 9 or 16")
    size = 3 if len(values) == 9 else 4
    matrix = np.eye(4)
    matrix[:size, :size] = np.reshape(values, (size, size))
    return matrix


def side_axes(z: Matrix) -> tuple[Matrix, Matrix]:
    """Return x and y of a right-handed frame about a unit vector z.

    T. Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017.
    """
    sign = math.copysign(1.0, z[2])
    a = -1.0 / (sign + z[2])
    b = z[0] * z[1] * a
    x = np.array([1.0 + sign * z[0] ** 2 * a, sign * b, -sign * z[0]])
    return x, np.array([b, sign + z[1] ** 2 * a, -z[1]])


_STEPS: dict[str, Callable[[Element], Matrix]] = {
    "translate": _translate,
    "rotate": _rotate,
    "scale": _scale,
    "lookat": _look_at,
    "matrix": _matrix,
}
