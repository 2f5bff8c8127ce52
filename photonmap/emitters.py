"""Collect a scene's lights, meshes that emit among them, and share samples out by power."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from photonmap.bands import Bands
from photonmap.errors import InputError, naming, warn
from photonmap.kernels.records import DOME, POINT, TRIANGLE, Geometry, Lights
from photonmap.scene import DomeLight, Light, Material, PointLight
from photonmap.spectra.curves import Color


@dataclass(frozen=True)
class Emitters:
    """The lights as kernels see them."""

    lights: Lights
    names: list[str]
    """of each emitter, (K,)"""
    of_triangle: NDArray[np.int32]
    """(T,) the emitter that a triangle is, -1 for none"""
    power: float
    """what all radiances were divided by"""


def collect_emitters(
    geometry: Geometry,
    material: NDArray[np.int32],
    materials: Sequence[Material],
    lights: Sequence[Light],
    bands: Bands,
    center: NDArray[np.float64],
    size: float,
) -> Emitters:
    """Collect all emitters, at a total power of 1.

    Parameters
    ----------
    geometry : in the kernels' units
    material : (T,) index into materials
    center, size : of the scene, to turn lights' positions into the kernels' units

    Raises
    ------
    InputError : emission that is negative or not finite, or a light that is not valid
    """
    emission = np.stack([emission_of(m.emission, bands, f"material {m.name!r}") for m in materials])
    shining = [light for light in lights if _spectrum(light, bands).any()]
    glowing = np.flatnonzero(emission[material].any(axis=1))
    if not shining and not len(glowing):
        warn("the scene has no light: a dome of radiance 1 in every band lights it")
        shining = [DomeLight()]
    if sum(isinstance(light, DomeLight) for light in shining) > 1:
        raise InputError("a scene has one dome at most: add the radiances of the others to it")

    row = np.concatenate([material[glowing], len(emission) + np.arange(len(shining))])
    spectra = np.concatenate([emission, *(_spectrum(light, bands)[None] for light in shining)])
    kind = np.array([TRIANGLE] * len(glowing) + [_kind(light) for light in shining], np.uint8)
    position = np.zeros((len(row), 3))
    points = np.flatnonzero(kind == POINT)
    for index in points:
        position[index] = (_position(shining[index - len(glowing)]) - center) / size
    spectra[row[points]] /= size * size
    area = np.concatenate([triangle_areas(geometry, glowing), np.zeros(len(shining))])
    radius = 1.001 * float(np.linalg.norm(geometry.vertices, axis=1).max())
    extent = np.choose(kind, [np.pi * area, 4.0 * np.pi, (2.0 * np.pi * radius) ** 2])
    flux = extent * spectra[row].mean(axis=1)
    power = float(flux.sum())

    of_triangle = np.full(len(material), -1, np.int32)
    of_triangle[glowing] = np.arange(len(glowing))
    triangle = np.full(len(row), -1, np.int32)
    triangle[: len(glowing)] = glowing
    cumulative = np.minimum(np.cumsum(flux) / power, 1.0)
    cumulative[-1] = 1.0
    dome = int(np.argmax(kind == DOME)) if (kind == DOME).any() else -1
    names = [materials[material[t]].name for t in glowing] + [light.name for light in shining]
    scaled = (spectra / power).astype(np.float32)
    record = Lights(
        kind, triangle, position, area, row.astype(np.int32), scaled, cumulative, dome, radius
    )
    return Emitters(record, names, of_triangle, power)


def emission_of(color: Color, bands: Bands, owner: str) -> NDArray[np.float64]:
    """Return a colour's emission per band, (N,); InputError names its owner if it is no light."""
    with naming(owner):
        values = bands.emission(color)
    if not (np.isfinite(values).all() and (values >= 0.0).all()):
        raise InputError(f"{owner} emits {values.min():.6g}: emission is finite and not negative")
    return values


def _kind(light: Light) -> int:
    return POINT if isinstance(light, PointLight) else DOME


def _spectrum(light: Light, bands: Bands) -> NDArray[np.float64]:
    if not isinstance(light, PointLight | DomeLight):
        raise InputError(f"{light!r} is neither a PointLight nor a DomeLight")
    return emission_of(light.color, bands, f"light {light.name!r}")


def _position(light: Light) -> NDArray[np.float64]:
    assert isinstance(light, PointLight)
    position = np.asarray(light.position, np.float64)
    if position.shape != (3,) or not np.isfinite(position).all():
        raise InputError(f"light {light.name!r}: position {light.position} is no point")
    return position


def triangle_areas(
    geometry: Geometry, triangles: NDArray[np.int64] | slice = slice(None)
) -> NDArray[np.float64]:
    """Return the areas of triangles, float64, in the geometry's units."""
    corners = geometry.vertices[geometry.triangles[triangles]].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * np.linalg.norm(normals, axis=1)
