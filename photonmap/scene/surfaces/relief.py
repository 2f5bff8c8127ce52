"""Images that turn the shading normals of a surface, and the tangents of its lobes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np

from photonmap.errors import InputError
from photonmap.kernels.core.color import LUMINANCE
from photonmap.runtime.wording import shown
from photonmap.scene.images import Image, write_image
from photonmap.scene.parameters import File, Number
from photonmap.scene.textures import Texture, check_texture

STEEPEST = 1e6  # Largest strength or height


def _read(path: Path) -> Texture:
    return Texture.read(path, linear=True)


def _save(texture: Texture, path: Path) -> None:
    linear = texture.image.linear(slice(None), slice(None)) * np.array(texture.factor)
    write_image(linear.astype(np.float32), path)


IMAGE = File("image", key="file", read=_read, save=_save, suffix=".exr")


@dataclass(frozen=True)
class NormalMap:
    """An image of directions, as glTF has them: x, y and z from -1 at 0 to 1 at 1.

    x points to where u rises, y to where v does, upwards in the image, and z along the normal.

    Parameters
    ----------
    texture : linear RGB, so read with `linear=True`
    strength : multiplies x and y
    """

    texture: Annotated[Texture, IMAGE]
    strength: Annotated[
        float, Number("strength", at_least=-STEEPEST, at_most=STEEPEST, such_as="1")
    ] = 1.0
    kind: ClassVar[str] = "normal"
    is_height: ClassVar[bool] = False

    @property
    def image(self) -> Texture:
        """What kernels look up."""
        return self.texture

    @property
    def factor(self) -> float:
        """By what lengths along the surface are multiplied."""
        return self.strength

    def find_conflict(self) -> str:
        """Return what is wrong with the image, if anything."""
        return _find_conflict(self.texture, "a normal map", ", or a BumpMap of heights")


@dataclass(frozen=True)
class BumpMap:
    """An image of heights above the surface: it is shaded as if they were there.

    Parameters
    ----------
    texture : its luminance counts; read with `linear=True`
    height : of 1, in scene units
    """

    texture: Annotated[Texture, IMAGE]
    height: Annotated[
        float, Number("height", "scene units", at_least=-STEEPEST, at_most=STEEPEST, such_as="0.01")
    ] = 1.0
    kind: ClassVar[str] = "bump"
    is_height: ClassVar[bool] = True

    @cached_property
    def image(self) -> Texture:
        """What kernels look up: derivatives by u and v, of central differences of texels."""
        texture = self.texture
        linear = texture.image.linear(slice(None), slice(None)) * np.array(texture.factor)
        heights = linear @ np.array(LUMINANCE)
        rows, columns = heights.shape
        along, up = ("edge" if clamp else "wrap" for clamp in texture.clamps)
        padded = np.pad(heights, ((1, 1), (0, 0)), mode=up)  # type: ignore[call-overload]
        padded = np.pad(padded, ((0, 0), (1, 1)), mode=along)  # type: ignore[call-overload]
        by_s = (padded[1:-1, 2:] - padded[1:-1, :-2]) * (0.5 * columns * texture.scale[0])
        by_t = (padded[:-2, 1:-1] - padded[2:, 1:-1]) * (0.5 * rows * texture.scale[1])
        slopes = np.stack([by_s, by_t, np.zeros_like(by_s)], axis=2).astype(np.float32)
        return replace(texture, image=Image(slopes, False), factor=(1.0, 1.0, 1.0))

    @property
    def factor(self) -> float:
        """By what derivatives are multiplied."""
        return self.height

    def find_conflict(self) -> str:
        """Return what is wrong with the image, if anything."""
        return _find_conflict(self.texture)


@dataclass(frozen=True)
class NoRelief:
    """Nothing: of a clear coat that is smooth over relief."""

    kind: ClassVar[str] = "none"
    is_height: ClassVar[bool] = False
    image: ClassVar[None] = None
    factor: ClassVar[float] = 0.0

    def find_conflict(self) -> str:
        """Return that nothing is wrong."""
        return ""


def _find_conflict(texture: Texture, directions: str = "", instead: str = "") -> str:
    """Return what is wrong with an image, if anything: of heights, or with a name of directions."""
    if not isinstance(texture, Texture):
        return f"{shown(texture)} is not an image; give a Texture"
    try:
        check_texture(texture, 1.0 + 1e-6 if directions else np.inf)
    except InputError as error:
        return str(error)
    if directions and texture.image.texels.shape[2] != 3:
        return f"{directions} has three channels; give RGB{instead}"
    return ""


@dataclass(frozen=True)
class AnisotropyMap:
    """An image of tangents and strengths, as glTF has it.

    Parameters
    ----------
    texture : linear RGB, so read with `linear=True`: red and green are the direction of the
        tangent, from -1 at 0 to 1 at 1, by where u and v rise; blue multiplies the `anisotropy`
    """

    texture: Annotated[Texture, IMAGE]
    kind: ClassVar[str] = "anisotropy"

    def find_conflict(self) -> str:
        """Return what is wrong with the image, if anything."""
        return _find_conflict(self.texture, "an anisotropy map")

    def scaled(self, strength: float) -> Texture:
        """Return the image with a strength in place of its factor."""
        return replace(self.texture, factor=(1.0, 1.0, strength))

    @property
    def strengths(self) -> tuple[float, float]:
        """The smallest and the largest value of blue."""
        blue = self.texture.image.linear(slice(None), slice(None))[..., 2]
        return float(blue.min()), float(blue.max())
