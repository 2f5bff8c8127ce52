"""Images of how glossy lobes differ along a surface."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

from photonmap.scene.surfaces.relief import IMAGE, find_conflict, find_grey
from photonmap.scene.textures import Texture


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
        return find_conflict(self.texture) or find_grey(self.texture, "an anisotropy map")

    def scaled(self, strength: float) -> Texture:
        """Return the image with a strength in place of its factor."""
        return replace(self.texture, factor=(1.0, 1.0, strength))

    @property
    def strengths(self) -> tuple[float, float]:
        """The smallest and the largest value of blue."""
        blue = self.texture.image.linear(slice(None), slice(None))[..., 2]
        return float(blue.min()), float(blue.max())
