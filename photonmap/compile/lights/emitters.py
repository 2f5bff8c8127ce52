"""Collect a scene's lights, meshes that emit among them, as emitters of a total power of 1."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.frame import Frame
from photonmap.compile.geometry import triangle_areas
from photonmap.compile.lights.environment import AMBIENT, MappedLight, Sky, compile_sky, default_sky
from photonmap.compile.lights.probabilities import EmitterBounds, grow_tree, make_cdf, mix_uniform
from photonmap.compile.textures import TextureTable
from photonmap.errors import InputError, naming, naming_file, warn
from photonmap.kernels.core.records import Geometry, Lights, LightTree, Profiles, SunPortals
from photonmap.kernels.lights import kinds, sun
from photonmap.kernels.lights.selection import FEW_EMITTERS
from photonmap.runtime.wording import listed
from photonmap.scene.camera import Camera
from photonmap.scene.lights import DomeLight, EnvironmentLight, Light, Profile, check_lights
from photonmap.scene.material import Material
from photonmap.scene.scene import Scene
from photonmap.scene.textures import Paint, mean_color
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Floats

DIMMEST, BRIGHTEST = 1e-30, 1e30
"""Power of all lights, W·m⁻²·sr⁻¹ times the square of the scene's size: images are float32."""

_MOST_PARAMETERS = max(len(kind.functions.Parameters._fields) for kind in kinds.KINDS.values())
DEFAULT_LIGHT = "default"
"""Name of the light of a scene without any."""
EDGE_ON = 1e-6  # Share of a portal's area that a sun sees at least: photons of suns start somewhere


@dataclass(frozen=True)
class Emitters:
    """The lights as kernels see them."""

    lights: Lights
    names: list[str]  # of each emitter, (K,)
    groups: list[str]  # of each emitter, (K,)
    of_triangle: NDArray[np.int32]  # (T,) the emitter that a triangle is, -1 for none
    flux: Floats
    """(K,) power of each emitter, the mean over bands, in the kernels' unit of length; textures
    count with their mean"""
    white: Floats  # (N,) colour of all light together, of mean 1

    @property
    def power(self) -> float:
        """What all radiances were divided by."""
        return float(self.flux.sum())


class _Shining(NamedTuple):
    """Lights that are not black, and the sky's map if there is one."""

    lights: list[Light]
    sky: Sky | None
    dome: int  # which of them is all around, -1 for none


class _Layout(NamedTuple):
    """Where emitters are and how they shine."""

    lights: Lights  # without spectra and probabilities
    extent: Floats  # (K,) power of an emission of 1
    cone: Floats  # (K, 2), as in `EmitterBounds`


def compile_lights(
    geometry: Geometry,
    materials: Sequence[Material],
    scene: Scene,
    bands: Bands,
    frame: Frame,
    textures: TextureTable,
    camera: Camera,
) -> Emitters:
    """Collect all emitters, at a total power of 1; geometry is in the kernels' units.

    The camera places the default light. A light that is not valid, or an emission that is negative
    or not finite, is an `InputError`.
    """
    material = geometry.material
    emission = np.stack([emission_of(m.emission, bands, f"material {m.name!r}") for m in materials])
    emits = np.asarray(emission.any(axis=1))
    area_names = [materials[k].name for k in material[emits[material]]]
    with naming_file(scene.lights_file):
        shining = _find_shining(scene.lights, area_names, bands, camera)
    portals = find_portals(materials, emission)
    opens = portals & (shining.dome >= 0)
    emitting = np.flatnonzero((emits | opens)[material])
    rest = [k for k in range(len(shining.lights)) if k != shining.dome or not opens.any()]
    layout = _lay_out(geometry, emitting, [shining.lights[k] for k in rest], frame)
    layout = _let_suns_in(geometry, portals, layout)
    if layout.lights.portals is None and shining.dome < 0:
        warn_of_black_portals(materials)
    row = np.concatenate([material[emitting], len(emission) + np.array(rest, int)])
    row[: len(emitting)][opens[material[emitting]]] = len(emission) + shining.dome
    spectra = np.stack(
        [*emission, *(_spectrum(each, shining.sky, bands) for each in shining.lights)]
    )
    is_point = np.isin(layout.lights.kind, kinds.numbers_where(has_place=True, has_area=False))
    spectra[row[is_point]] /= frame.size * frame.size
    described = [(each.name, each.name) for each in materials]
    described += [(light.name, light.group or light.name) for light in shining.lights]
    names, groups = ([described[k][part] for k in row] for part in (0, 1))
    record, flux = _record(geometry, layout, names, row, spectra)
    power, environment = float(flux.sum()), None
    images = textures.emission_textures(bands, power, len(spectra), geometry)
    if shining.sky and shining.dome >= 0:
        environment = shining.sky.record(power, len(emission) + shining.dome)
    record = record._replace(emission_textures=images, environment=environment)
    total = layout.extent @ spectra[row]
    of_triangle = np.full(len(material), -1, np.int32)
    of_triangle[emitting] = np.arange(len(emitting))
    return Emitters(record, names, groups, of_triangle, flux, total / total.mean())


def _let_suns_in(geometry: Geometry, portals: NDArray[np.bool_], layout: _Layout) -> _Layout:
    """Return a layout in which all the power of suns goes through portals, if there are any."""
    opened = open_to_suns(geometry, portals, layout.lights)
    if opened is None:
        return layout
    of_sun = opened.row >= 0
    extent = layout.extent.copy()
    extent[of_sun] = opened.extent[opened.row[of_sun]]
    return layout._replace(extent=extent, lights=layout.lights._replace(portals=opened))


def _record(
    geometry: Geometry, layout: _Layout, names: list[str], row: NDArray[np.int64], spectra: Floats
) -> tuple[Lights, Floats]:
    """Return what kernels take, without maps and textures, and the power of each emitter."""
    mean = spectra[row].mean(axis=1)
    with np.errstate(over="ignore"):
        flux = layout.extent * mean
        power = float(flux.sum())
    if not DIMMEST <= power <= BRIGHTEST:
        raise InputError(
            f"lights radiate {power:.3g} in units of the scene: images can hold "
            f"{DIMMEST:g} to {BRIGHTEST:g}; scale the lights"
        )
    cdf = make_cdf(mix_uniform(flux, names))
    record = layout.lights._replace(
        spectrum=row.astype(np.int32),
        spectra=(spectra / power).astype(np.float32),
        cdf=cdf,
        tree=_grow_tree(geometry, layout, mean, cdf),
    )
    return record, flux


def _find_shining(
    lights: Sequence[Light], area_names: Sequence[str], bands: Bands, camera: Camera
) -> _Shining:
    """Return the lights that are not black, with names; the default light where nothing emits."""
    named = check_lights(lights, area_names)
    skies = [light for light in named if isinstance(light, DomeLight | MappedLight)]
    if len(skies) > 1:
        both = f"{skies[0].name!r} and {skies[1].name!r}"
        raise InputError(f"a scene has one dome or environment at most: leave one of {both} out")
    sky = next((compile_sky(s, bands) for s in skies if isinstance(s, MappedLight)), None)
    shining = [light for light in named if _spectrum(light, sky, bands).any()]
    if not shining and not area_names:
        if named:
            raise InputError(
                f"all lights are off, being 0 in every band: {listed(one.name for one in named)}; "
                "turn one on, or remove them to have the default light"
            )
        warn(
            f"the scene has no light: a dome of radiance {AMBIENT:g} in every band lights it, and "
            "a soft key light from above and to the left of the camera"
        )
        sky = default_sky(camera, bands)
        return _Shining([EnvironmentLight(sky.texels, name=DEFAULT_LIGHT)], sky, 0)
    around = [k for k, light in enumerate(shining) if isinstance(light, DomeLight | MappedLight)]
    return _Shining(shining, sky, around[0] if around else -1)


def _lay_out(
    geometry: Geometry, emitting: NDArray[np.int64], lights: Sequence[Light], frame: Frame
) -> _Layout:
    """Lay out emitting triangles, then lights, in the kernels' units."""
    first, count = len(emitting), len(emitting) + len(lights)
    kind, extent, area = np.full(count, kinds.TRIANGLE, np.uint8), np.zeros(count), np.zeros(count)
    position, axis, cone = np.zeros((count, 3)), np.zeros((count, 3)), np.ones((count, 2))
    triangle, parameters = np.full(count, -1, np.int32), np.zeros((count, _MOST_PARAMETERS))
    triangle[:first] = emitting
    area[:first] = triangle_areas(geometry, emitting)
    extent[:first] = np.pi * area[:first]
    cone[:first] = 1.0, 0.0
    radius = 1.001 * float(np.linalg.norm(geometry.vertices, axis=1).max())
    described = [light.emitter() for light in lights]
    for index, emitter in enumerate(described, start=first):
        kind[index] = kinds.NUMBERS[emitter.kind]
        if emitter.position is not None:
            position[index] = frame.into(np.array(emitter.position))
        axis[index] = emitter.axis
        own = kinds.KINDS[emitter.kind].functions.Parameters(**emitter.parameters)
        parameters[index, : len(own)] = own
        extent[index] = emitter.extent(radius)
        cone[index] = emitter.cone, 1.0
    none, dome = np.empty(0), np.flatnonzero(kind == kinds.DOME)
    record = Lights(
        kind=kind,
        triangle=triangle,
        position=position,
        axis=axis,
        parameters=parameters,
        area=area,
        spectrum=none.astype(np.int32),
        spectra=none.astype(np.float32).reshape(0, 0),
        cdf=none,
        in_turn=count <= FEW_EMITTERS and bool(np.isin(kind, kinds.WITHOUT_AREA).all()),
        dome=int(dome[0]) if len(dome) else -1,
        radius=radius,
        environment=None,
        profiles=_collect_profiles([emitter.profile for emitter in described], first),
        emission_textures=None,
        tree=None,
        portals=None,
    )
    return _Layout(record, extent, cone)


def _collect_profiles(tables: Sequence[Profile | None], first: int) -> Profiles | None:
    """Return the tables of the emitters that have one; None without any."""
    used = [table for table in tables if table is not None]
    if not used:
        return None
    row = np.full(first + len(tables), -1, np.int32)
    row[first + np.flatnonzero([table is not None for table in tables])] = np.arange(len(used))
    frames = np.stack([table.frame for table in used])
    return Profiles(row, frames, np.stack([table.intensity for table in used]))


def _grow_tree(geometry: Geometry, layout: _Layout, mean: Floats, cdf: Floats) -> LightTree | None:
    """Build the tree of emitters that are not infinitely far."""
    lights, is_area = layout.lights, layout.lights.kind == kinds.TRIANGLE
    triangles = lights.triangle[is_area]
    low, high, axis = lights.position.copy(), lights.position.copy(), lights.axis.copy()
    corners = geometry.vertices[geometry.triangles[triangles]]
    low[is_area], high[is_area] = corners.min(axis=1), corners.max(axis=1)
    axis[is_area] = geometry.normals[triangles]
    strength = mean * np.where(is_area, lights.area, 1.0)
    far = np.isin(lights.kind, kinds.numbers_where(has_place=False))
    return grow_tree(EmitterBounds(low, high, axis, layout.cone, strength), cdf, far)


def emission_of(color: Paint, bands: Bands, owner: str) -> Floats:
    """Return the emission per band, (N,), of a colour, or of a texture the mean.

    An `InputError` names the owner of what is negative or not finite.
    """
    with naming(owner):
        values = bands.emission(mean_color(color))
    if not (np.isfinite(values).all() and (values >= 0.0).all()):
        raise InputError(
            f"{owner} emits {values.min():.6g}: emission must be finite and not negative"
        )
    return values


def _spectrum(light: Light, sky: Sky | None, bands: Bands) -> Floats:
    """Return a light's amount in each band, (N,): of an environment the mean."""
    if isinstance(light, MappedLight) and sky and light.color_attribute is None:
        return sky.mean
    amount = emission_of(light.color, bands, f"light {light.name!r}")
    return sky.mean if isinstance(light, MappedLight) and sky else amount


def find_portals(materials: Sequence[Material], emission: Floats) -> NDArray[np.bool_]:
    """Return which materials are portals, (M,); one that emits by itself, (M, N), is refused."""
    portals = np.array([material.portal for material in materials])
    for index in np.flatnonzero(portals & emission.any(axis=1)).tolist():
        raise InputError(
            f"material {materials[index].name!r} is a portal, and has an emission; remove one"
        )
    return portals


def warn_of_black_portals(materials: Sequence[Material]) -> None:
    """Warn of portals, if there are any, of a scene without light outside."""
    if any(material.portal for material in materials):
        names = listed(material.name for material in materials if material.portal)
        warn(f"portals ({names}) are black: there is no sky, environment or dome for them to show")


def open_to_suns(
    geometry: Geometry, portals: NDArray[np.bool_], lights: Lights
) -> SunPortals | None:
    """Return the portals as suns see them; None where there are none, or no suns.

    `portals`, (M,), are the materials that are.
    """
    triangles = np.flatnonzero(portals[geometry.material])
    suns = np.flatnonzero(lights.kind == kinds.DIRECTIONAL)
    if not (len(triangles) and len(suns)):
        return None
    area = triangle_areas(geometry, triangles)
    facing = np.abs(lights.axis[suns] @ geometry.normals[triangles].T.astype(np.float64))
    edge = lights.parameters[suns, sun.Parameters._fields.index("edge"), None]
    seen = area * (facing + np.sqrt(1.0 - edge * edge) + EDGE_ON)  # a disc sees some more
    row = np.full(len(lights.kind), -1, np.int32)
    row[suns] = np.arange(len(suns))
    return SunPortals(
        is_portal=portals,
        triangle=triangles.astype(np.int32),
        area=area,
        row=row,
        cdf=make_cdf(seen),
        extent=seen.sum(axis=1),
    )
