"""The JSON of a material of a glTF file: its factors, checked, and its textures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Losses, note_loss
from photonmap.io.readers.gltf_parts.textures import Textures, find_placement
from photonmap.runtime.wording import shown
from photonmap.scene.images import Channels, Image
from photonmap.scene.surfaces.metallic import is_even
from photonmap.scene.textures import Texture, Triple, mean_number
from photonmap.spectra.curves import LARGEST_REFLECTANCE

METALLIC_TEXTURE = "metallicRoughnessTexture"
Factors = Mapping[str, Any]
Tint = tuple[float, float, float, float]
WHITE = (1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Source:
    """A material: its JSON, and where what is wrong or not simulated is said.

    Parameters
    ----------
    name : of the material
    item : its JSON
    textures : those of the file
    losses : takes what is not simulated
    tint : RGBA that multiplies the base colour; None for none
    """

    name: str
    item: Factors
    textures: Textures
    losses: Losses
    tint: Tint | None = None

    @property
    def surface(self) -> Factors:
        """The metallic-roughness model."""
        return self.item.get("pbrMetallicRoughness") or {}

    def extension(self, name: str) -> Factors:
        """Return the content of an extension, empty if there is none."""
        found: Factors = self.item.get("extensions", {}).get(f"KHR_materials_{name}") or {}
        return found

    def lose(self, what: str) -> None:
        """Note what is not simulated."""
        note_loss(self.losses, what, self.name)

    def number(self, values: Factors, key: str, default: float, largest: float = 1.0) -> float:
        """Return a factor from 0 to `largest`."""
        value = values.get(key, default)
        if type(value) not in (int, float) or not 0.0 <= value <= largest:
            raise self.error(key, value, f"a number from 0 to {largest:g}")
        return float(value)

    def color(self, values: Factors, key: str, largest: float = 1.0) -> tuple[float, float, float]:
        """Return three factors, each from 0 to `largest`."""
        value = values.get(key, [1, 1, 1])[:3]
        most = max(largest, LARGEST_REFLECTANCE)
        if len(value) < 3 or not all(
            type(part) in (int, float) and 0 <= part <= most for part in value
        ):
            raise self.error(key, value, f"three numbers within [0, {largest:g}]")
        red, green, blue = (min(float(part), largest) for part in value)
        return red, green, blue

    def texture(self, use: Factors) -> Texture | None:
        """Return a colour texture; None if it is missing."""
        return self.textures.color(use, find_placement(self.item), self.lose)

    def data(self, factor: str, channel: Callable[[Channels], Image]) -> float | Texture:
        """Return a factor of the surface times a channel of the texture beside it, if any."""
        number = self.number(self.surface, factor, 1.0)
        return self.times(number, self.surface.get(METALLIC_TEXTURE), channel)

    def times(
        self, number: float, use: Factors | None, channel: Callable[[Channels], Image]
    ) -> float | Texture:
        """Return a number times a channel of a texture, if there is one."""
        if use is None or number == 0.0:
            return number
        texture = self.textures.data(use, channel, find_placement(self.item), self.lose)
        if texture is None:
            return number
        texture = replace(texture, factor=(number,) * 3)
        return mean_number(texture) if is_even(texture) else texture

    def base_color(self) -> Triple:
        """Return the factor of the base colour, tinted."""
        red, green, blue = self.color(self.surface, "baseColorFactor")
        r, g, b, _ = self.tint or WHITE
        return r * red, g * green, b * blue

    def error(self, key: str, value: Any, wanted: str) -> InputError:
        """Return the error that a value is not what is wanted."""
        message = f"material {shown(self.name)}: {key} {shown(value)} is not {wanted}"
        return InputError(f"{message}; correct it", self.textures.path)
