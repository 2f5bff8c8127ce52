"""Images on surfaces: what they look like from code, and what kernels take of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming
from photonmap.messages import shown
from photonmap.readers.images import LINEAR_TABLE, SRGB_TABLE, Image, read_mask, read_texture
from photonmap.spectra.curves import LARGEST_REFLECTANCE, Color

if TYPE_CHECKING:
    from photonmap.bands import Bands
    from photonmap.kernels.records import Alpha, Glow, Maps, Textures
    from photonmap.prepare import Prepared
    from photonmap.scene import Material

Floats = NDArray[np.float64]
Triple = tuple[float, float, float]
FARTHEST = 1e9
"""Of texture coordinates, scales and offsets: beyond, kernels would run out of whole numbers."""
ROWS = 256
"""Of an image that are looked at together, so that temporary arrays stay small."""


@dataclass(frozen=True)
class Texture:
    """An image on a surface, bilinear between the centres of its texels.

    Its lower left corner lies at texture coordinates (0, 0), its upper right one at (1, 1); it is
    looked up at `scale` · (u, v) + `offset`. As reflectance or emission it is linear RGB, which
    becomes a spectrum as other RGB does; as opacity its luminance counts.

    Parameters
    ----------
    image : its texels
    scale, offset : of texture coordinates
    clamp : its edges go on outside the unit square; otherwise it repeats
    factor : multiplies linear red, green and blue
    """

    image: Image
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    clamp: bool = False
    factor: Triple = (1.0, 1.0, 1.0)

    @classmethod
    def read(cls, path: str | PathLike[str], linear: bool = False, **placing: Any) -> Texture:
        """Read an image; one that is read again is shared.

        Parameters
        ----------
        path : a file that OpenImageIO reads
        linear : integers are linear, not sRGB; floats always are
        placing : scale, offset, clamp, factor

        Raises
        ------
        InputError : the file cannot be read
        """
        return cls(shared_image(path, linear), **placing)

    @classmethod
    def of(cls, texels: Any, srgb: bool = True, **placing: Any) -> Texture:
        """Make a texture of an array.

        Parameters
        ----------
        texels : (H, W), (H, W, 1) or (H, W, 3), the top row first; uint8, or numbers that are
            linear
        srgb : whether uint8 texels are encoded in sRGB
        placing : scale, offset, clamp, factor
        """
        array = np.asarray(texels)
        array = array[..., None] if array.ndim == 2 else array
        if array.dtype != np.uint8:
            return cls(Image(np.ascontiguousarray(array, np.float32), False), **placing)
        return cls(Image(np.ascontiguousarray(array), srgb), **placing)

    @cached_property
    def mean(self) -> Triple:
        """Mean linear RGB over the image."""
        texels, table = self.image.texels, self.image.table.astype(np.float64)
        total = np.zeros(texels.shape[2])
        for start in range(0, len(texels), ROWS):
            part = texels[start : start + ROWS]
            if part.dtype == np.uint8:
                for channel in range(len(total)):
                    count = np.bincount(part[..., channel].ravel(), minlength=256)
                    total[channel] += count @ table
            else:
                total += part.sum(axis=(0, 1), dtype=np.float64)
        return self._triple(total / (texels.shape[0] * texels.shape[1]))

    @cached_property
    def largest(self) -> float:
        """The largest linear value."""
        most = self.image.texels.max(axis=(0, 1))
        return max(self._triple(self.image.table[most] if most.dtype == np.uint8 else most))

    def _triple(self, channels: NDArray[Any]) -> Triple:
        red, green, blue = (np.ones(3) * channels * self.factor).tolist()
        return red, green, blue


Paint = Color | Texture
"""What a material's reflectance or emission may be."""


def mean_color(paint: Paint) -> Color:
    """Return the mean of a texture, or a colour as it is."""
    return paint.mean if isinstance(paint, Texture) else paint


def mean_opacity(alpha: float | Texture) -> float:
    """Return the mean of a texture, or a number as it is."""
    if isinstance(alpha, Texture):
        return float(np.dot((0.2126, 0.7152, 0.0722), alpha.mean))
    return alpha


def stand_ins(prepared: Prepared) -> dict[str, Any]:
    """Return attributes of a material that needs the same code as a scene's textures.

    It is no lamp, of which none of its own light could be seen.
    """
    image, black = Texture.of(np.full((1, 1), 0.4)), Texture.of(np.zeros((1, 1)))
    needs: tuple[tuple[str, Any, object], ...] = (
        ("reflectance", prepared.textures, image),
        ("emission", prepared.lights.glow, black),
        ("alpha", prepared.geometry.alpha, 0.5),
    )
    return {name: value for name, record, value in needs if record is not None}


_images: WeakValueDictionary[tuple[Any, ...], Image] = WeakValueDictionary()


def shared_image(path: str | PathLike[str], linear: bool = False, mask: bool = False) -> Image:
    """Read a texture or a mask, unless the same file was read before and is in use.

    Raises
    ------
    InputError : as in `readers.images`
    """
    path = Path(path)
    try:
        state = path.stat()
        key: tuple[Any, ...] | None
        key = (path.resolve(), state.st_mtime_ns, state.st_size, linear, mask)
    except (OSError, ValueError):
        key = None
    image = None if key is None else _images.get(key)
    if image is None:
        image = _as_mask(read_mask(path, linear)) if mask else read_texture(path, linear)
        if key is not None:
            _images[key] = image
    return image


def _as_mask(values: NDArray[np.float32]) -> Image:
    """Return an image of one channel, in bytes if they hold it."""
    count = np.rint(np.minimum(values, 1.0) * 255).astype(np.uint8)
    if np.array_equal(LINEAR_TABLE[count], values):
        return Image(count[..., None], False)
    return Image(np.ascontiguousarray(values[..., None]), False)


@dataclass
class Pictures:
    """All textures of a scene as kernels take them.

    Parameters
    ----------
    maps : one row a use
    reflectance, emission, alpha : (M,) the row that each material uses, -1 for none
    opacity : (M,) where there is no texture
    images : keeps the texels alive, of which kernels have the addresses
    """

    maps: Maps
    reflectance: NDArray[np.int32]
    emission: NDArray[np.int32]
    alpha: NDArray[np.int32]
    opacity: Floats
    images: list[Any] = field(repr=False)

    def textures(self, bands: Bands) -> Textures | None:
        """Return textured reflectances; None where there are none."""
        from photonmap.kernels.records import Textures

        if (self.reflectance < 0).all():
            return None
        basis = bands.reflectance_basis.astype(np.float32)
        return Textures(self.maps, self.reflectance, basis)

    def holes(self) -> Alpha | None:
        """Return opacities; None where all surfaces are opaque."""
        from photonmap.kernels.records import Alpha

        if (self.alpha < 0).all() and (self.opacity == 1.0).all():
            return None
        return Alpha(self.opacity, self.alpha, self.maps)

    def glow(
        self, bands: Bands, power: float, rows: int, uv: NDArray[Any], triangles: NDArray[Any]
    ) -> Glow | None:
        """Return textured lamps; None where there are none.

        Parameters
        ----------
        power : what radiances are divided by
        rows : of `Lights.spectra`, of which the first are those of materials
        uv, triangles : of the geometry
        """
        from photonmap.kernels.records import Glow

        lamps = np.flatnonzero(self.emission >= 0)
        if not len(lamps):
            return None
        slot = np.full(rows, -1, np.int32)
        slot[lamps] = np.arange(len(lamps))
        basis = np.tile(bands.emission_basis / power, (len(lamps), 1)).astype(np.float32)
        return Glow(self.maps, slot, self.emission[lamps], basis, uv, triangles)


def collect_pictures(materials: Sequence[Material], shrink: Floats) -> Pictures:
    """Collect the textures of M materials.

    Parameters
    ----------
    shrink : (M,) by which reflectances are divided

    Raises
    ------
    InputError
        a texture has no texels, or values that are no reflectance, opacity or radiance; or an
        opacity is outside [0, 1]
    """
    uses: list[tuple[Texture, float]] = []
    slots = np.full((3, len(materials)), -1, np.int32)
    opacity = np.ones(len(materials))
    for index, material in enumerate(materials):
        paints = (material.reflectance, material.emission, material.alpha)
        for slot, (name, paint) in enumerate(
            zip(("reflectance", "emission", "alpha"), paints, strict=True)
        ):
            with naming(f"material {material.name!r}: {name}"):
                if isinstance(paint, Texture):
                    check_texture(paint, np.inf if name == "emission" else LARGEST_REFLECTANCE)
                    slots[slot, index] = len(uses)
                    uses.append((paint, shrink[index] if slot == 0 else 1.0))
                elif name == "alpha":
                    opacity[index] = _opacity(paint)
    maps, images = _maps(uses)
    return Pictures(maps, slots[0], slots[1], slots[2], opacity, images)


def _opacity(value: Any) -> float:
    if not (isinstance(value, int | float | np.number) and 0.0 <= value <= 1.0):
        raise InputError(f"{value!r} is no opacity; it is a number in [0, 1], or a Texture")
    return float(value)


def check_texture(texture: Texture, most: float = np.inf) -> None:
    """Refuse an image without texels, of another shape, or with values outside [0, most].

    Raises
    ------
    InputError
    """
    texels = texture.image.texels
    if texels.ndim != 3 or texels.shape[2] not in (1, 3) or not texels.size:
        raise InputError(f"the texture's texels must be (H, W, 3) or (H, W, 1), not {texels.shape}")
    if texels.dtype not in (np.uint8, np.float32):
        raise InputError(f"the texture's texels must be uint8 or float32, not {texels.dtype}")
    numbers = np.array([*texture.scale, *texture.offset, *texture.factor], np.float64)
    if numbers.shape != (7,) or not np.isfinite(numbers).all() or (numbers[4:] < 0.0).any():
        raise InputError(
            "a texture has two numbers for scale and offset, and three from 0 for factor"
        )
    if np.abs(numbers[:4]).max() > FARTHEST:
        raise InputError(
            f"the texture's scale {shown(texture.scale)} or offset {shown(texture.offset)} is "
            f"beyond {FARTHEST:g}; keep them below"
        )
    if texels.dtype == np.float32 and not (texels.min() >= 0.0 and texels.max() < np.inf):
        raise InputError("the texture has values that are negative or not finite")
    if texture.largest > most:
        raise InputError(f"the texture reaches {texture.largest:.6g}; keep it between 0 and 1")


def _maps(uses: list[tuple[Texture, float]]) -> tuple[Maps, list[Any]]:
    """Return all uses as a table, and the arrays whose addresses are in it."""
    from photonmap.kernels.records import BYTES, FLOATS, SRGB, Maps

    arrays = [np.ascontiguousarray(texture.image.texels) for texture, _ in uses]
    textures = [texture for texture, _ in uses]
    kinds = [
        FLOATS if array.dtype == np.float32 else SRGB if texture.image.srgb else BYTES
        for texture, array in zip(textures, arrays, strict=True)
    ]
    factors = [np.array(texture.factor, np.float64) / shrink for texture, shrink in uses]
    maps = Maps(
        np.array([array.ctypes.data for array in arrays], np.int64),
        np.array([array.shape for array in arrays], np.int32).reshape(-1, 3),
        np.array(kinds, np.uint8),
        np.array([texture.clamp for texture in textures], np.uint8),
        np.array([(*t.scale, *t.offset) for t in textures], np.float64).reshape(-1, 4),
        np.array(factors, np.float64).reshape(-1, 3),
        np.stack([LINEAR_TABLE, SRGB_TABLE]),
    )
    return maps, arrays
