"""Buffers derived from those of a render: illuminant colours, masks, linear sRGB."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import RENDERED, split_name
from photonmap.errors import InputError
from photonmap.film.relative_error import valid_pixels
from photonmap.integrators.look import Onlooker
from photonmap.results.result import Result
from photonmap.scene.daylight import SkyLight
from photonmap.scene.lights import EnvironmentLight
from photonmap.scene.projections import RayMap
from photonmap.scene.scene import Scene
from photonmap.scene.textures import Paint, Texture
from photonmap.spectra.bands import Bands
from photonmap.spectra.projection import SRGB, Method, projection_onto

Mask = NDArray[np.bool_]

_RAYS = 3  # rays along each side of a pixel
_REACH = 2
"""How far from a pixel's centre its rays reach, in rays: a sixth of a pixel beyond its sides."""
_BEND = np.cos(np.radians(20.0))
"""Least cosine between the normals of one piece of surface in a pixel."""
_STEP = 0.5  # largest step in depth within a piece of surface, in widths of a pixel at its distance


def one_piece(scene: Scene, size: tuple[int, int], at_centre: bool = False) -> Mask:
    """Return the pixels that show one piece of surface, of one object and material: (H, W).

    5×5 rays through each pixel and just beside it meet the same object and material, with normals
    within 20° and no step in depth. `at_centre` says that samples pass through the pixels' centres
    alone, where there is one surface.
    """
    onlooker, (width, height), camera = Onlooker(scene), size, scene.camera
    if camera is None:
        raise InputError("the scene has no camera; give it one, and render it by that")
    if at_centre or isinstance(camera.projection, RayMap):
        there = onlooker.see(camera, size, ("object_id",))["object_id"] > 0
        return there & at_centre
    names = ("object_id", "material_id", "normal", "depth")
    seen = onlooker.see(camera, (_RAYS * width, _RAYS * height), names)
    padded = {
        name: np.pad(image, ((1, 1), (1, 1), (0, 0))[: image.ndim], mode="edge")
        for name, image in seen.items()
    }

    def at(name: str, row: int, column: int) -> NDArray[np.float64]:
        """Return the values of the rays so far from the pixels' centres."""
        first, other = row + _REACH, column + _REACH
        return padded[name][first::_RAYS, other::_RAYS][:height, :width].astype(np.float64)

    normal, depth = at("normal", 0, 0), at("depth", 0, 0)
    pure = at("object_id", 0, 0) > 0
    near = range(-_REACH, _REACH + 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        for row, column in product(near, near):
            for name in ("object_id", "material_id"):
                pure &= at(name, row, column) == at(name, 0, 0)
            pure &= (at("normal", row, column) * normal).sum(axis=-1) >= _BEND
            opposite = 1.0 / at("depth", row, column) + 1.0 / at("depth", -row, -column)
            pure &= np.abs(opposite * depth - 2.0) <= _STEP / height
    return pure


def pure_pixels(result: Result, scene: Scene, pieces: Mask | None = None) -> Mask:
    """Return where `one_piece` holds, no pass saw another reflectance, and surfaces cover it."""
    if pieces is None:
        pieces = one_piece(scene, result.size, result.record["arguments"]["pixel"] == "center")
    pure = pieces & (result.coverage == 1.0)
    spread = result.errors.get("reflectance")
    return pure if spread is None else pure & (spread == 0.0).all(axis=-1)


_SAME = 1e-5  # largest difference between the bands of lights that have one colour, of mean 1

Colors = Mapping[str, NDArray[np.float64] | None]
"""(N,) colours of mean 1 by light group; None for a group that has several."""


def light_colors(scene: Scene, groups: Iterable[str], bands: Bands) -> Colors:
    """Return the colours of light groups in bands; None for several colours, images and skies."""
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
    sends back of that colour, both added up over the bands. None where one of `colors`, as
    `light_colors` returns them, is not known, or the buffers are not split by light group.
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


Image = NDArray[Any]

PROJECTED = tuple(
    row.name for row in RENDERED if row.is_banded and row.name not in ("residual", "covariance")
)
"""Buffers that have a colour: not the residual, which is computed again, nor what errors need."""


def with_derived(
    result: Result, scene: Scene | None = None, pieces: NDArray[np.bool_] | None = None
) -> Result:
    """Return a render with the buffers that follow from its own, `photonmap.buffers.ADDED`.

    Without the scene that was rendered, no pixel is known to be pure, and the colour of direct
    light is that of direct / reflectance. `pieces` is what `one_piece` returns, where it is known.
    """
    color, pure = None, np.zeros(result.coverage.shape, bool)
    if scene is not None:
        colors = light_colors(scene, result.per_light, result.bands)
        color, pure = direct_light_color(result, colors), pure_pixels(result, scene, pieces)
    emits = result.emission.any(axis=-1)
    background = result.object_id == 0
    buffers = {
        **result.buffers,
        "scalar_shading": result.scalar_shading,
        "illuminant": result.illuminant.data,
        "illuminant_direct": _ratio_color(result) if color is None else color,
        "valid": _valid(result),
        "light_source": emits & ~background,
        "background": background,
        "pure": pure,
    }
    return replace(result, buffers=buffers)


def _valid(result: Result) -> NDArray[np.bool_]:
    """Return the valid pixels of a render but for those of mirrors, glass or bare metal.

    Such pixels have a residual and no reflectance; those at its edges are next to them.
    """
    seen = result.residual.any(axis=-1)
    specular = seen & ~result.reflectance.any(axis=-1)
    beside = np.pad(specular, 1)
    beside = beside[:-2] | beside[1:-1] | beside[2:]
    beside = beside[:, :-2] | beside[:, 1:-1] | beside[:, 2:]
    valid = valid_pixels(result.coverage, result.emission, result.unresolved)
    return valid & ~(seen & beside)


def _ratio_color(result: Result) -> Image:
    """Return the colour of direct / reflectance; 0 where a band of reflectance is 0."""
    reflectance = result.reflectance.astype(np.float64)
    known = (reflectance > 0.0).all(axis=-1, keepdims=True)
    known &= ~result.residual.any(axis=-1, keepdims=True)
    known &= ~result.fluorescence.any(axis=-1, keepdims=True)
    shading = np.divide(result.direct, reflectance, where=known, out=np.zeros(reflectance.shape))
    return over_mean(shading)


def rgb_method(bands: Bands) -> Method | None:
    """Return how bands are projected to RGB: by regression; None for RGB, which stays as it is."""
    return None if bands.is_rgb else "regression"


def as_rgb(result: Result, space: str = SRGB) -> Result:
    """Return the buffers in RGB, (H, W, 3) float32 each, those of light groups included.

    Radiances and shading are projected by one matrix, reflectance by the same under equal-energy
    white, and kept within [0, 1]; the colours of lights are kept. Projection does not commute with
    products: `residual` is the signed rest of these RGB images, radiance − emission − reflectance ×
    shading − fluorescence. `illuminant` is shading over its mean, `illuminant_direct` the same for
    direct light alone, 0 where it is unknown. What follows from a buffer that is not held is left
    out.

    Parameters
    ----------
    result : with the buffers that `with_derived` adds
    space : linear sRGB, or as `photonmap.spectra.projection.check_space` takes it
    """
    matrix = projection_onto(result.bands, space, rgb_method(result.bands))
    names = [name for name in result.buffers if split_name(name)[0] in PROJECTED]
    rgb = {name: _project(result.buffers[name], matrix) for name in names}
    white = matrix.sum(axis=1, keepdims=True)
    rgb["reflectance"] = np.clip(_project(result.reflectance, matrix / white), 0.0, 1.0)
    if "emission" in rgb:
        product = rgb["reflectance"].astype(np.float64) * rgb["shading"]
        rest = rgb["radiance"].astype(np.float64) - rgb["emission"] - product
        rest -= rgb.get("fluorescence", 0.0)
        rgb["residual"] = rest.astype(np.float32)
    other = {} if space == SRGB else {"rgb_space": Path(space).name}
    projected = Result(
        rgb, {}, Bands.rgb(), {**result.record, "white": None, "light_luminance": None, **other}
    )
    rgb["scalar_shading"] = projected.scalar_shading
    rgb["illuminant"] = projected.illuminant.data
    if (color := result.buffers.get("illuminant_direct")) is not None:
        rgb["illuminant_direct"] = over_mean(_project(color, matrix))
    return replace(projected, buffers=rgb)


def _project(image: Image, matrix: NDArray[np.float64]) -> NDArray[np.float32]:
    most = np.finfo(np.float32).max
    return np.clip(image @ matrix.T, -most, most).astype(np.float32)


def rgb_residual(rgb: Result) -> float:
    """Return the norm of the RGB residual relative to that of radiance − emission, or 0."""
    light = rgb.radiance.astype(np.float64) - rgb.emission
    whole = float(np.linalg.norm(light))
    return float(np.linalg.norm(rgb.residual.astype(np.float64))) / whole if whole else 0.0


def negative_share(rgb: Result, valid: NDArray[np.bool_]) -> float | None:
    """Return the share of valid pixels in which radiance is negative in a channel, or None."""
    return float((rgb.radiance[valid] < 0.0).any(axis=-1).mean()) if valid.any() else None
