"""New spectra for the lights and the reflectances of existing scenes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields, replace
from os import PathLike
from typing import Any

import numpy as np

from photonmap.dataset.models.materials import Palette
from photonmap.dataset.models.shapes import Random
from photonmap.dataset.scenes.illumination import Illumination, choose_illumination, light_spectrum
from photonmap.dataset.scenes.random_lights import RandomLights
from photonmap.errors import InputError, naming
from photonmap.scene.daylight import SkyLight, SunLight
from photonmap.scene.images import check_panorama, read_panorama
from photonmap.scene.lights import DirectionalLight, DomeLight, EnvironmentLight, Light
from photonmap.scene.material import Material
from photonmap.scene.scene import Scene
from photonmap.scene.textures import Paint, Texture, mean_color
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.daylight import SUN_DIAMETER
from photonmap.spectra.observer import luminance, observer, radiance_to_rgb

_COLORS = ("intensity", "irradiance", "radiance")


def relight(scene: Scene, illumination: str | Illumination | RandomLights, seed: int = 0) -> Scene:
    """Give the lights of a scene other spectra of the same luminance.

    Light groups (an emitting material is a group under its name) take the colours in turn, in an
    order that the seed decides; shares do not matter, as every group keeps its luminance. Emission
    textures and environment maps, which are RGB, take the RGB of the light. A scene without lights
    gets a dome light.

    Parameters
    ----------
    scene : is not modified
    illumination : one of `photonmap.dataset.scenes.illumination.NAMED`, or your own
    seed : draws the colours of the illumination, and which group takes which

    Returns
    -------
    Scene that shares all other arrays with the given scene

    Raises
    ------
    InputError : the illumination is unknown, or has more colours than the scene has light groups
    """
    rng = np.random.Generator(np.random.PCG64(seed))
    chosen = choose_illumination(illumination, rng)
    emitters = _emitters(scene)
    with naming(f"scene {scene.name!r}"):
        spectra = _assign(light_groups(scene), chosen, rng)
    changed = {
        key: replace(material, emission=_recolored(material.emission, spectra[material.name]))
        for key, material in emitters.items()
    }
    relit = [_relit(each, spectra[_group(each)]) for each in _lights(scene)]
    return replace(_with_materials(scene, changed), lights=relit)


def recolor(scene: Scene, seed: int = 0, materials: Iterable[str] | None = None) -> Scene:
    """Give the diffuse surfaces of a scene the reflectances of random Munsell chips.

    Materials without a diffuse part, such as glass and mirrors, and emitters stay as they are. A
    reflectance texture, or colours of vertices or faces, which are RGB, are replaced by a single
    chip.

    Parameters
    ----------
    scene : is not modified
    seed : draws the chips
    materials : names of the materials to change; None for all

    Returns
    -------
    Scene that shares all other arrays with the given scene
    """
    palette = Palette(np.random.Generator(np.random.PCG64(seed)))
    wanted = None if materials is None else set(materials)
    changed: dict[int, Material] = {}
    for material in {id(mesh.material): mesh.material for mesh in scene.meshes}.values():
        if _is_diffuse(material) and (wanted is None or material.name in wanted):
            chip = palette.chip(None, (3, 8), (2, 12))
            changed[id(material)] = replace(material, reflectance=chip.reflectance)
    meshes = [replace(m, colors=None) if id(m.material) in changed else m for m in scene.meshes]
    return _with_materials(replace(scene, meshes=meshes), changed)


def _with_materials(scene: Scene, changed: dict[int, Material]) -> Scene:
    """Return a scene with materials replaced, by the `id` of the old one."""
    meshes = [replace(m, material=changed.get(id(m.material), m.material)) for m in scene.meshes]
    return replace(scene, meshes=meshes)


def light_groups(scene: Scene) -> list[str]:
    """Return the light groups of a scene to which `relight` gives colours."""
    emitters = (material.name for material in _emitters(scene).values())
    return list(dict.fromkeys([*emitters, *map(_group, _lights(scene))]))


def _emitters(scene: Scene) -> dict[int, Material]:
    """Return the materials that emit, by their ids."""
    return {id(m.material): m.material for m in scene.meshes if _emits(m.material.emission)}


def _lights(scene: Scene) -> list[Light]:
    """Return the other lights; a dome where there is no light at all."""
    return list(scene.lights) or ([] if _emitters(scene) else [DomeLight(name="dome")])


def _assign(groups: list[str], chosen: Illumination, rng: Random) -> dict[str, Spectrum]:
    """Assign the colours of an illumination to light groups in turn, in random order."""
    colors = [light_spectrum(name) for name in chosen.colors]
    if len(groups) < len(colors):
        raise InputError(
            f"has fewer light groups ({', '.join(groups)}) than the {len(colors)} colours of "
            f"illumination {chosen.name!r}; choose one of fewer colours"
        )
    order = rng.permutation(len(groups))
    return {groups[group]: colors[i % len(colors)] for i, group in enumerate(order)}


def _emits(emission: Paint) -> bool:
    """Return whether a material emits."""
    if isinstance(emission, Texture):
        return emission.largest > 0.0
    return luminance(emission) > 0.0


def _is_diffuse(material: Material) -> bool:
    """Return whether a material reflects diffusely and does not emit."""
    paint = material.reflectance
    values = paint.values if isinstance(paint, Spectrum) else np.asarray(mean_color(paint))
    return bool(np.any(values > 0.0)) and not _emits(material.emission)


def _group(light: Light) -> str:
    return light.group or light.name or light.kind


def _recolored(paint: Paint, spectrum: Spectrum) -> Paint:
    """Return an emission with its luminance and the colour of a spectrum of luminance 1."""
    if not isinstance(paint, Texture):
        return spectrum * luminance(paint)
    linear = paint.image.linear(slice(None), slice(None)) * np.array(paint.factor)
    red, green, blue = _rgb(spectrum).tolist()
    image = Texture.of(linear @ observer().rgb_to_xyz[1]).image
    return replace(paint, image=image, factor=(red, green, blue))


def _relit(light: Light, spectrum: Spectrum) -> Light:
    """Return a light with its luminance and the colour of a spectrum of luminance 1."""
    if isinstance(light, EnvironmentLight):
        if isinstance(light.image, str | PathLike):
            texels = read_panorama(light.image)
        else:
            texels = check_panorama(light.image, light.kind)
        return replace(light, image=(texels @ observer().rgb_to_xyz[1])[..., None] * _rgb(spectrum))
    if isinstance(light, SkyLight):
        texels = light.luminance()[..., None] * _rgb(spectrum)
        return EnvironmentLight(texels, light.scale, name=light.name, group=_group(light))
    if isinstance(light, SunLight):
        amount = spectrum * luminance(light.color)
        return DirectionalLight(light.direction, amount, light.name, _group(light), SUN_DIAMETER)
    described: Any = light
    name = next(field.name for field in fields(described) if field.name in _COLORS)
    return replace(described, **{name: _recolored(light.color, spectrum)})


def _rgb(spectrum: Spectrum) -> np.ndarray:
    """Return linear sRGB of a light, (3,), clipped to the gamut and scaled to luminance 1."""
    rgb = np.maximum(radiance_to_rgb(spectrum), 0.0)
    return rgb / (observer().rgb_to_xyz[1] @ rgb)
