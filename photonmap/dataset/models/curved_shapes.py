"""Curved shapes: spheres, lumps of smooth noise, superquadrics, tubes and torus knots."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.dataset.models.shapes import (
    Floats,
    Random,
    Shape,
    lattice,
    normalised,
    smooth_normals,
    without_degenerate,
)

_BASE = 0.07
"""Fraction of a lump's height that is flattened into its base."""


class Noise:
    """A smooth random field: a sum of plane waves of random directions.

    Its mean is 0 and its variance about 1; each octave is half as strong as the one before.

    Parameters
    ----------
    rng : draws the waves
    frequency : of the first octave, cycles a unit of length
    octaves : number of octaves, each of twice the frequency of the one before
    waves : number of plane waves in each octave
    """

    def __init__(self, rng: Random, frequency: float, octaves: int = 3, waves: int = 12) -> None:
        scales = np.repeat(2.0 ** np.arange(octaves), waves)
        directions = normalised(rng.normal(size=(len(scales), 3)))
        self._waves = 2.0 * np.pi * frequency * scales[:, None] * directions
        self._phases = rng.uniform(0.0, 2.0 * np.pi, len(scales))
        amplitudes = 1.0 / scales
        self._amplitudes = amplitudes * np.sqrt(2.0 / (amplitudes**2).sum())

    def __call__(self, points: Floats) -> Floats:
        """Return the field at points (V, 3) as (V,)."""
        return np.sin(points @ self._waves.T + self._phases) @ self._amplitudes


@cache
def _icosphere(subdivisions: int) -> tuple[Floats, NDArray[np.int64]]:
    from trimesh.creation import icosphere

    ball = icosphere(subdivisions=subdivisions)
    return np.array(ball.vertices), np.array(ball.faces, np.int64)


def sphere(radius: float, subdivisions: int = 4) -> Shape:
    """Return a ball that rests on y = 0."""
    vertices, faces = _icosphere(subdivisions)
    return Shape(radius * vertices, faces, vertices).resting()


def lump(rng: Random, radius: float, roughness: float = 0.12, frequency: float = 0.45) -> Shape:
    """Return a ball displaced by smooth noise, on a flat base.

    Parameters
    ----------
    roughness : standard deviation of the displacement, in radii
    frequency : of the slowest waves, cycles a radius
    """
    vertices, faces = _icosphere(5)
    field = np.clip(Noise(rng, frequency)(vertices), -2.5, 2.5)
    moved = radius * vertices * (1.0 + roughness * field[:, None])
    low, high = moved[:, 1].min(), moved[:, 1].max()
    moved[:, 1] = np.maximum(moved[:, 1], low + _BASE * (high - low))
    return Shape(moved, faces, smooth_normals(moved, faces)).resting()


def superquadric(
    size: ArrayLike, north: float, east: float, rows: int = 96, columns: int = 128
) -> Shape:
    """Return a superquadric (Barr 1981).

    Parameters
    ----------
    size : extents along x, y and z, metres
    north, east : exponents: 1 is an ellipsoid, towards 0 a box, 2 an octahedron
    """
    half = 0.5 * np.asarray(size, np.float64)
    latitude = _eased(np.linspace(-np.pi / 2, np.pi / 2, rows))
    longitude = _eased(np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False))
    ring, rise = _power(np.cos(latitude), north), _power(np.sin(latitude), north)
    ring[[0, -1]] = 0.0
    vertices = np.stack(
        [
            np.outer(ring, _power(np.cos(longitude), east)),
            np.outer(rise, np.ones(columns)),
            -np.outer(ring, _power(np.sin(longitude), east)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    vertices = half * vertices
    faces = without_degenerate(vertices, lattice(rows, columns, wrap_columns=True))
    normals = smooth_normals(vertices, faces)
    normals[:columns], normals[-columns:] = (0.0, -1.0, 0.0), (0.0, 1.0, 0.0)
    return Shape(vertices, faces, normals).resting()


def _power(values: Floats, exponent: float) -> Floats:
    """Raise magnitudes to a power and keep signs; values within rounding of 0 become 0."""
    values = np.where(np.abs(values) < 1e-12, 0.0, values)
    return np.sign(values) * np.abs(values) ** exponent


def _eased(angles: Floats) -> Floats:
    """Concentrate angles where superquadrics bend most, halfway between the axes."""
    return angles - 0.2 * np.sin(4.0 * angles)


def tube(path: ArrayLike, radius: float, sides: int = 32, closed: bool = False) -> Shape:
    """Sweep a circle along a path; an open path gets hemispherical caps.

    Parameters
    ----------
    path : (P, 3) points, metres
    radius : of the circle, metres
    sides : vertices around the circle
    closed : join the last point to the first, which is not repeated
    """
    line = np.asarray(path, np.float64)
    before, after = np.roll(line, 1, axis=0), np.roll(line, -1, axis=0)
    tangent = normalised(after - before if closed else np.gradient(line, axis=0))
    radii = np.full(len(line), radius)
    if not closed:
        line, tangent, radii = _capped(line, tangent, radius)
    right, up = _frames(tangent, closed)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    outward = np.cos(angle)[:, None] * right[:, None] + np.sin(angle)[:, None] * up[:, None]
    vertices = (line[:, None] + radii[:, None, None] * outward).reshape(-1, 3)
    faces = lattice(len(line), sides, wrap_rows=closed, wrap_columns=True)
    faces = without_degenerate(vertices, faces)
    return Shape(vertices, faces, smooth_normals(vertices, faces))


def _capped(line: Floats, tangent: Floats, radius: float) -> tuple[Floats, Floats, Floats]:
    """Add a hemisphere of rings to either end."""
    angle = np.linspace(0.0, np.pi / 2, 7)[1:]
    out, radii = radius * np.sin(angle)[:, None], radius * np.cos(angle)
    radii[-1] = 0.0
    first = (line[0] - out * tangent[0])[::-1]
    last = line[-1] + out * tangent[-1]
    directions = [np.tile(tangent[0], (6, 1)), tangent, np.tile(tangent[-1], (6, 1))]
    return (
        np.concatenate([first, line, last]),
        np.concatenate(directions),
        np.concatenate([radii[::-1], np.full(len(line), radius), radii]),
    )


def _frames(tangent: Floats, closed: bool) -> tuple[Floats, Floats]:
    """Return a rotation-minimising frame along a path; on a closed one its twist is spread out."""
    start = np.eye(3)[np.argmin(np.abs(tangent[0]))]
    right = [normalised(start - tangent[0] * (start @ tangent[0]))]
    for direction in tangent[1:]:
        right.append(normalised(right[-1] - direction * (right[-1] @ direction)))
    rights = np.stack(right)
    ups = np.cross(tangent, rights)
    if closed:
        back = normalised(rights[-1] - tangent[0] * (rights[-1] @ tangent[0]))
        twist = np.arctan2(back @ ups[0], back @ rights[0])
        turn = -twist * np.arange(len(rights)) / len(rights)
        cosine, sine = np.cos(turn)[:, None], np.sin(turn)[:, None]
        rights, ups = cosine * rights + sine * ups, cosine * ups - sine * rights
    return rights, ups


def knot(radius: float, thickness: float, p: int = 2, q: int = 3, steps: int = 320) -> Shape:
    """Return a torus knot that winds p times around the axis and q times around the ring.

    It stands upright and rests on y = 0.
    """
    t = 2.0 * np.pi * np.arange(steps) / steps
    ring = 1.0 + 0.42 * np.cos(q * t)
    path = [ring * np.cos(p * t), ring * np.sin(p * t), 0.42 * np.sin(q * t)]
    return tube(radius * np.stack(path, axis=1), thickness, closed=True).resting()
