"""The colours of light groups, and the colour of direct light that follows from them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.results.result import Result
from photonmap.scene.light_parts.daylight import SkyLight
from photonmap.scene.lights import EnvironmentLight
from photonmap.scene.scene import Scene
from photonmap.scene.textures import Paint, Texture
from photonmap.spectra.bands import Bands

_SAME = 1e-5
"""Largest difference between the bands of lights that have one colour, of mean 1."""

Colors = Mapping[str, NDArray[np.float64] | None]
"""(N,) colours of mean 1 by light group; None for a group that has several."""


def light_colors(scene: Scene, groups: Iterable[str], bands: Bands) -> Colors:
    """Return the colours that light groups emit in bands.

    A group of lights of several colours, a texture, an environment map or a sky has None.
    """
    paints: dict[str, list[Paint | None]] = {group: [] for group in groups}
    for mesh in scene.meshes:
        if mesh.material.name in paints:
            paints[mesh.material.name].append(mesh.material.emission)
    for light in scene.lights:
        group = light.group or light.name or light.kind
        if group in paints:
            mapped = isinstance(light, EnvironmentLight | SkyLight)  # not under clouds
            paints[group].append(None if mapped else light.color)
    return {group: _common_color(found, bands) for group, found in paints.items()}


def _common_color(paints: list[Paint | None], bands: Bands) -> NDArray[np.float64] | None:
    """Return the one colour of paints; None if there are several, or it varies."""
    colors = []
    for paint in paints:
        if paint is None or isinstance(paint, Texture):
            return None
        emitted = np.asarray(bands.emission(paint), np.float64)
        if emitted.any():
            colors.append(emitted / emitted.mean())
    if not colors or any(np.abs(color - colors[0]).max() > _SAME for color in colors):
        return None
    return colors[0]


def direct_light_color(result: Result, colors: Colors) -> NDArray[np.float32] | None:
    """Return the colour of direct light, of band mean 1, (H, W, N); 0 where none is seen.

    Each group's light keeps the colour that it was emitted in, however many reflectances there are
    in a pixel. How much of it arrives is its direct light over what the pixel's mean reflectance
    sends back of that colour, both added up over the bands.

    Parameters
    ----------
    result : with its buffers split by light group
    colors : as `light_colors` returns them

    Returns
    -------
    None where a group has no one colour, or the buffers are not split
    """
    split = result.per_light
    if not split or any(colors.get(group) is None for group in split):
        return None
    reflectance = result.reflectance.astype(np.float64)
    light = np.zeros(reflectance.shape)
    for group, buffers in split.items():
        color: Any = colors[group]
        returned = reflectance @ color
        received = buffers["direct"].sum(axis=-1, dtype=np.float64)
        amount = np.divide(received, returned, where=returned > 0.0, out=np.zeros(received.shape))
        light += amount[..., None] * color
    return over_mean(light)


def over_mean(light: NDArray[Any]) -> NDArray[np.float32]:
    """Return light divided by its mean over bands, 0 where that is 0."""
    mean = light.mean(axis=-1, keepdims=True, dtype=np.float64)
    lit = np.broadcast_to(mean > 0.0, light.shape)
    return np.divide(light, mean, where=lit, out=np.zeros(light.shape)).astype(np.float32)
