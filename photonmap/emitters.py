"""Collect a scene's lights, meshes that emit among them, and share samples out by power."""

from collections.abc import Sequence
from dataclasses import dataclass

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
)
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
    lights = name_lights([check_light(light) for light in lights], lamps)
    sky = _sky(lights, bands)
    shining = [light for light in lights if _spectrum(light, sky, bands).any()]
    if not shining and not len(glowing):
        warn("the scene has no light: a dome of radiance 1 in every band lights it")
        shining, sky = [DomeLight(name="dome")], None

    row = np.concatenate([material[glowing], len(emission) + np.arange(len(shining))])
    spectra = np.concatenate([emission, *(_spectrum(light, sky, bands)[None] for light in shining)])
    kind = np.array([TRIANGLE] * len(glowing) + [_KINDS[light.kind] for light in shining], np.uint8)
    position, axis, cosines = (
        np.zeros((len(row), 3)),
        np.zeros((len(row), 3)),
        np.ones((len(row), 2)),
    )
    area = np.concatenate([triangle_areas(geometry, glowing), np.zeros(len(shining))])
    radius = 1.001 * float(np.linalg.norm(geometry.vertices, axis=1).max())
    extent = np.pi * area
    for index, light in enumerate(shining, start=len(glowing)):
        if isinstance(light, PointLight | SpotLight):
            position[index] = (np.array(light.position) - center) / size
            spectra[row[index]] /= size * size
        if isinstance(light, DirectionalLight):
            axis[index] = unit(np.array(light.direction))
        if isinstance(light, SpotLight):
            axis[index] = spot_axis(light)
            cosines[index] = np.cos(np.radians([light.inner, light.outer]))
        extent[index] = _extent(light, cosines[index], radius)
    with np.errstate(over="ignore"):
        flux = extent * spectra[row].mean(axis=1)
        power = float(flux.sum())
    if not DIMMEST <= power <= BRIGHTEST:
        raise InputError(
            f"lights radiate {power:.3g} in units of the scene: images hold what comes from "
            f"{DIMMEST:g} to {BRIGHTEST:g}; scale the lights"
        )

    of_triangle = np.full(len(material), -1, np.int32)
    of_triangle[glowing] = np.arange(len(glowing))
    triangle = np.full(len(row), -1, np.int32)
    triangle[: len(glowing)] = glowing
    dome = int(np.argmax(kind == DOME)) if (kind == DOME).any() else -1
    lamp_names = [materials[material[t]].name for t in glowing]
    names = lamp_names + [light.name for light in shining]
    record = Lights(
        kind,
        triangle,
        position,
        axis,
        cosines,
        area,
        row.astype(np.int32),
        (spectra / power).astype(np.float32),
        rise(even_out(flux, names)),
        dome,
        radius,
        sky.record(power) if sky and dome >= 0 else None,
        pictures.glow(bands, power, len(spectra), geometry.uv, geometry.triangles),
    )
    groups = lamp_names + [light.group or light.name for light in shining]
    return Emitters(record, names, groups, of_triangle, power)


def emission_of(color: Paint, bands: Bands, owner: str) -> NDArray[np.float64]:
    """Return the emission per band, (N,), of a colour, or of a texture the mean.

    InputError names its owner if it is no light.
    """
    with naming(owner):
        values = bands.emission(mean_color(color))
    if not (np.isfinite(values).all() and (values >= 0.0).all()):
        raise InputError(f"{owner} emits {values.min():.6g}: emission is finite and not negative")
    return values


def _sky(lights: Sequence[Light], bands: Bands) -> Sky | None:
    """Read the environment's map, if there is one."""
    skies = [light for light in lights if isinstance(light, DomeLight | EnvironmentLight)]
    if len(skies) > 1:
        named = f"{skies[0].name!r} and {skies[1].name!r}"
        raise InputError(f"a scene has one dome or environment at most: leave one of {named} out")
    return next((sky_of(s, bands) for s in skies if isinstance(s, EnvironmentLight)), None)


def _spectrum(light: Light, sky: Sky | None, bands: Bands) -> NDArray[np.float64]:
    """Return a light's amount in each band, (N,): of an environment the mean."""
    if isinstance(light, EnvironmentLight) and sky:
        return sky.mean
    return emission_of(light.color, bands, f"light {light.name!r}")


def _extent(light: Light, cosines: NDArray[np.float64], radius: float) -> float:
    """Return the power of a light of amount 1, over a scene within `radius`."""
    match light:
        case PointLight():
            return 4.0 * np.pi
        case SpotLight():
            # The falloff's mean over its range of cosines is 1/2.
            return np.pi * float(2.0 - cosines.sum())
        case DirectionalLight():
            return np.pi * radius**2
    return (2.0 * np.pi * radius) ** 2


def triangle_areas(
    geometry: Geometry, triangles: NDArray[np.int64] | slice = slice(None)
) -> NDArray[np.float64]:
    """Return the areas of triangles, float64, in the geometry's units."""
    corners = geometry.vertices[geometry.triangles[triangles]].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * np.linalg.norm(normals, axis=1)
