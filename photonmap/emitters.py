"""Collect a scene's lights, meshes that emit among them, and share samples out by power."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.bands import Bands
from photonmap.chances import even_out, rise
from photonmap.environment import Sky, sky_of
from photonmap.errors import InputError, naming, warn
from photonmap.kernels.records import (
    DIRECTIONAL,
    DOME,
    POINT,
    SPOT,
    TRIANGLE,
    Geometry,
    Lights,
    LightTree,
)
from photonmap.light_tree import grow_tree
from photonmap.lights import (
    DirectionalLight,
    DomeLight,
    EnvironmentLight,
    Light,
    PointLight,
    SpotLight,
    check_light,
    name_lights,
    spot_axis,
)
from photonmap.scene import Material
from photonmap.textures import Paint, Pictures, mean_color
from photonmap.triangles import triangle_areas
from photonmap.vectors import unit

_KINDS = {
    PointLight.kind: POINT,
    SpotLight.kind: SPOT,
    DirectionalLight.kind: DIRECTIONAL,
    DomeLight.kind: DOME,
    EnvironmentLight.kind: DOME,
}

DIMMEST, BRIGHTEST = 1e-30, 1e30
"""Of all lights, W·m⁻²·sr⁻¹ times the square of the scene's size: images are float32."""


@dataclass(frozen=True)
class Emitters:
    """The lights as kernels see them."""

    lights: Lights
    names: list[str]
    """of each emitter, (K,)"""
    groups: list[str]
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
    pictures: Pictures,
) -> Emitters:
    """Collect all emitters, at a total power of 1.

    Parameters
    ----------
    geometry : in the kernels' units
    material : (T,) index into materials
    center, size : of the scene, to turn lights' positions into the kernels' units
    pictures : the materials' textures

    Raises
    ------
    InputError : emission that is negative or not finite, or a light that is not valid
    """
    emission = np.stack([emission_of(m.emission, bands, f"material {m.name!r}") for m in materials])
    glowing = np.flatnonzero(emission[material].any(axis=1))
    lamps = {materials[i].name for i in np.unique(material[glowing])}
    shining, sky = _shining(name_lights([check_light(light) for light in lights], lamps), bands)
    if not shining and not len(glowing):
        warn("the scene has no light: a dome of radiance 1 in every band lights it")
        shining, sky = [DomeLight(name="dome")], None

    places = _place(geometry, glowing, shining, center, size)
    row = np.concatenate([material[glowing], len(emission) + np.arange(len(shining))])
    spectra = np.concatenate([emission, *(_spectrum(light, sky, bands)[None] for light in shining)])
    spectra[row[np.isin(places.kind, (POINT, SPOT))]] /= size * size
    radius = 1.001 * float(np.linalg.norm(geometry.vertices, axis=1).max())
    mean = spectra[row].mean(axis=1)
    with np.errstate(over="ignore"):
        flux = _extents(places, radius) * mean
        power = float(flux.sum())
    if not DIMMEST <= power <= BRIGHTEST:
        raise InputError(
            f"lights radiate {power:.3g} in units of the scene: images hold what comes from "
            f"{DIMMEST:g} to {BRIGHTEST:g}; scale the lights"
        )
    lamp_names = [materials[material[t]].name for t in glowing]
    names = lamp_names + [light.name for light in shining]
    cumulative = rise(even_out(flux, names))
    record = Lights(
        places.kind,
        places.triangle,
        places.position,
        places.axis,
        places.cosines,
        places.area,
        row.astype(np.int32),
        (spectra / power).astype(np.float32),
        cumulative,
        int(np.argmax(places.kind == DOME)) if (places.kind == DOME).any() else -1,
        radius,
        sky.record(power) if sky and (places.kind == DOME).any() else None,
        pictures.glow(bands, power, len(spectra), geometry.uv, geometry.triangles),
        _tree(geometry, places, mean, cumulative),
    )
    of_triangle = np.full(len(material), -1, np.int32)
    of_triangle[glowing] = np.arange(len(glowing))
    groups = lamp_names + [light.group or light.name for light in shining]
    return Emitters(record, names, groups, of_triangle, power)


class _Places(NamedTuple):
    """Where emitters are and how they shine, as in `Lights`."""

    kind: NDArray[np.uint8]
    triangle: NDArray[np.int32]
    position: NDArray[np.float64]
    axis: NDArray[np.float64]
    cosines: NDArray[np.float64]
    area: NDArray[np.float64]


def _place(
    geometry: Geometry,
    glowing: NDArray[np.int64],
    shining: Sequence[Light],
    center: NDArray[np.float64],
    size: float,
) -> _Places:
    """Place emitting triangles and lights, in the kernels' units."""
    first, count = len(glowing), len(glowing) + len(shining)
    places = _Places(
        np.array([TRIANGLE] * first + [_KINDS[light.kind] for light in shining], np.uint8),
        np.full(count, -1, np.int32),
        np.zeros((count, 3)),
        np.zeros((count, 3)),
        np.ones((count, 2)),
        np.zeros(count),
    )
    places.triangle[:first] = glowing
    places.area[:first] = triangle_areas(geometry, glowing)
    for index, light in enumerate(shining, start=first):
        if isinstance(light, PointLight | SpotLight):
            places.position[index] = (np.array(light.position) - center) / size
        if isinstance(light, DirectionalLight):
            places.axis[index] = unit(np.array(light.direction))
        if isinstance(light, SpotLight):
            places.axis[index] = spot_axis(light)
            places.cosines[index] = np.cos(np.radians([light.inner, light.outer]))
    return places


def _tree(
    geometry: Geometry, places: _Places, mean: NDArray[np.float64], cumulative: NDArray[np.float64]
) -> LightTree | None:
    """Build the tree of emitters that are not infinitely far."""
    lamp = places.kind == TRIANGLE
    lamps = places.triangle[lamp]
    low, high, axis = places.position.copy(), places.position.copy(), places.axis.copy()
    corners = geometry.vertices[geometry.triangles[lamps]]
    low[lamp], high[lamp] = corners.min(axis=1), corners.max(axis=1)
    axis[lamp] = geometry.normals[lamps]
    cosines = np.ones((len(mean), 2))
    cosines[lamp] = 1.0, 0.0
    cosines[places.kind == POINT, 0] = -1.0
    cosines[places.kind == SPOT, 0] = places.cosines[places.kind == SPOT, 1]
    strength = mean * np.where(lamp, places.area, 1.0)
    far = np.isin(places.kind, (DOME, DIRECTIONAL))
    return grow_tree(low, high, axis, cosines, strength, cumulative, far)


def emission_of(color: Paint, bands: Bands, owner: str) -> NDArray[np.float64]:
    """Return the emission per band, (N,), of a colour, or of a texture the mean.

    InputError names its owner if it is no light.
    """
    with naming(owner):
        values = bands.emission(mean_color(color))
    if not (np.isfinite(values).all() and (values >= 0.0).all()):
        raise InputError(f"{owner} emits {values.min():.6g}: emission is finite and not negative")
    return values


def _shining(lights: Sequence[Light], bands: Bands) -> tuple[list[Light], Sky | None]:
    """Return the lights that are not black, and the environment's map if there is one."""
    skies = [light for light in lights if isinstance(light, DomeLight | EnvironmentLight)]
    if len(skies) > 1:
        named = f"{skies[0].name!r} and {skies[1].name!r}"
        raise InputError(f"a scene has one dome or environment at most: leave one of {named} out")
    sky = next((sky_of(s, bands) for s in skies if isinstance(s, EnvironmentLight)), None)
    return [light for light in lights if _spectrum(light, sky, bands).any()], sky


def _spectrum(light: Light, sky: Sky | None, bands: Bands) -> NDArray[np.float64]:
    """Return a light's amount in each band, (N,): of an environment the mean."""
    if isinstance(light, EnvironmentLight) and sky:
        return sky.mean
    return emission_of(light.color, bands, f"light {light.name!r}")


def _extents(places: _Places, radius: float) -> NDArray[np.float64]:
    """Return the power, (K,), of emitters of amount 1, over a scene within `radius`."""
    extents = np.pi * places.area
    # A spot's falloff has a mean of 1/2 over its range of cosines.
    spots = np.pi * (2.0 - places.cosines.sum(axis=1))
    for kind, extent in (
        (POINT, 4.0 * np.pi),
        (SPOT, spots),
        (DIRECTIONAL, np.pi * radius**2),
        (DOME, (2.0 * np.pi * radius) ** 2),
    ):
        extents = np.where(places.kind == kind, extent, extents)
    return extents
