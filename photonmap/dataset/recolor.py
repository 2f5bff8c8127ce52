"""Other lights and other reflectances for scenes that exist."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields, replace
from os import PathLike
from typing import Any

import numpy as np

from photonmap.dataset.lighting import Illumination, choose_illumination, light
from photonmap.dataset.palette import Palette
from photonmap.dataset.solids import Random
from photonmap.errors import InputError, naming
from photonmap.lights import DomeLight, EnvironmentLight, Light
from photonmap.readers.panorama import check_panorama, read_panorama
from photonmap.scene import Material, Scene
from photonmap.spectra.curves import Color, Spectrum
from photonmap.spectra.observer import emission_spectrum, observer, radiance_to_rgb
from photonmap.textures import Paint, Texture, mean_color

_COLORS = ("intensity", "irradiance", "radiance")


def relight(scene: Scene, illumination: str | Illumination, seed: int = 0) -> Scene:
    """Give a scene's lights other spectra; each keeps its luminance.

    Groups of lights (of materials that emit, the name) take the colours in turn, in an order that
    the seed decides. Textures and maps, which are RGB, keep their luminance and take the light's
    RGB. A scene without lights gets a dome.

    Parameters
    ----------
    scene : stays as it is
    illumination : one of `photonmap.dataset.lighting.ILLUMINATIONS`, or one of your own
    seed : draws the colours of an illumination, and what takes which

    Returns
    -------
    Scene that shares all other arrays with the given one

    Raises
    ------
    InputError : there is no such illumination, or it has two colours and the scene one group
    """
    rng = np.random.Generator(np.random.PCG64(seed))
    chosen = choose_illumination(illumination, rng)
    lamps = {id(m.material): m.material for m in scene.meshes if _shines(m.material.emission)}
    lights: list[Light] = list(scene.lights)
    if not lamps and not lights:
        lights = [DomeLight(name="dome")]
    groups = list(dict.fromkeys([*(m.name for m in lamps.values()), *map(_group, lights)]))
    with naming(f"scene {scene.name!r}"):
        spectra = _assign(groups, chosen, rng)
    changed = {
        key: replace(lamp, emission=_recolored(lamp.emission, spectra[lamp.name]))
        for key, lamp in lamps.items()
    }
    shining = [_relit(each, spectra[_group(each)]) for each in lights]
    return replace(_with_materials(scene, changed), lights=shining)


def recolor(scene: Scene, seed: int = 0, materials: Iterable[str] | None = None) -> Scene:
    """Give a scene's diffuse surfaces Munsell chips at random.

    Glass and mirrors without a diffuse part, black surfaces and lamps keep theirs. A texture, which
    is RGB and has no spectra, gives way to one chip.

    Parameters
    ----------
    scene : stays as it is
    seed : draws the chips
    materials : names of those to change; None for all

    Returns
    -------
    Scene that shares all other arrays with the given one
    """
    palette = Palette(np.random.Generator(np.random.PCG64(seed)))
    wanted = None if materials is None else set(materials)
    changed: dict[int, Material] = {}
    for material in {id(mesh.material): mesh.material for mesh in scene.meshes}.values():
        if _is_painted(material) and (wanted is None or material.name in wanted):
            chip = palette.chip(None, (3, 8), (2, 12))
            changed[id(material)] = replace(material, reflectance=chip.reflectance)
    return _with_materials(scene, changed)


def _with_materials(scene: Scene, changed: dict[int, Material]) -> Scene:
    """Return a scene with other materials in place of those of these ids."""
    meshes = [replace(m, material=changed.get(id(m.material), m.material)) for m in scene.meshes]
    return replace(scene, meshes=meshes)


def _assign(groups: list[str], chosen: Illumination, rng: Random) -> dict[str, Spectrum]:
    """Give groups of lights the colours of an illumination in turn, in random order."""
    colors = [light(name) for name in chosen.colors]
    if len(groups) < len(colors):
        raise InputError(
            f"has one group of lights, {groups[0]!r}; illumination {chosen.name!r} needs two: "
            f"choose one of a single colour"
        )
    order = rng.permutation(len(groups))
    return {groups[group]: colors[i % len(colors)] for i, group in enumerate(order)}


def _shines(emission: Paint) -> bool:
    """Tell whether a material emits."""
    if isinstance(emission, Texture):
        return emission.largest > 0.0
    return luminance(emission) > 0.0


def _is_painted(material: Material) -> bool:
    """Tell whether a material is a diffuse surface that is neither black nor a lamp."""
    paint = material.reflectance
    values = paint.values if isinstance(paint, Spectrum) else np.asarray(mean_color(paint))
    return bool(np.any(values > 0.0)) and not _shines(material.emission)


def _group(light: Light) -> str:
    return light.group or light.name or light.kind


def luminance(color: Color) -> float:
    """Return ∫ L ȳ dλ / ∫ ȳ dλ of a radiance."""
    return float(observer().rgb_to_xyz[1] @ radiance_to_rgb(emission_spectrum(color)))


def _recolored(paint: Paint, spectrum: Spectrum) -> Paint:
    """Return a radiance of the same luminance in another colour, of luminance 1."""
    if not isinstance(paint, Texture):
        return spectrum * luminance(paint)
    linear = paint.image.linear(slice(None), slice(None)) * np.array(paint.factor)
    red, green, blue = _rgb(spectrum).tolist()
    image = Texture.of(linear @ observer().rgb_to_xyz[1]).image
    return replace(paint, image=image, factor=(red, green, blue))


def _relit(light: Light, spectrum: Spectrum) -> Light:
    """Return a light of the same luminance in another colour, of luminance 1."""
    if isinstance(light, EnvironmentLight):
        if isinstance(light.image, str | PathLike):
            texels = read_panorama(light.image)
        else:
            texels = check_panorama(light.image, light.kind)
        return replace(light, image=(texels @ observer().rgb_to_xyz[1])[..., None] * _rgb(spectrum))
    described: Any = light
    name = next(field.name for field in fields(described) if field.name in _COLORS)
    return replace(described, **{name: _recolored(light.color, spectrum)})


def _rgb(spectrum: Spectrum) -> np.ndarray:
    """Return the linear sRGB of a light, (3,), moved into the gamut at a luminance of 1."""
    rgb = np.maximum(radiance_to_rgb(spectrum), 0.0)
    return rgb / (observer().rgb_to_xyz[1] @ rgb)
