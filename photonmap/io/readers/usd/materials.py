"""The materials of USD stages: preview surfaces, and their textures as meshes use them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers.decoding import plain
from photonmap.io.readers.registry import GREY, OR_WITHOUT, extended
from photonmap.io.readers.usd.stage import Stage, color_space
from photonmap.runtime.wording import shown
from photonmap.scene.image_headers import named_space
from photonmap.scene.images import Channels, Image, decode_srgb
from photonmap.scene.material import Material
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.layers import check_material
from photonmap.scene.surfaces.metallic import USUAL_INDEX, is_even, metallic_gloss
from photonmap.scene.surfaces.relief import NormalMap
from photonmap.scene.textures import (
    Texture,
    Triple,
    is_black,
    lie_alike,
    mean_number,
    resized,
)
from photonmap.spectra.curves import Floats
from photonmap.spectra.rgb_spaces import to_srgb

if find_spec("pxr") is not None:
    from pxr import UsdShade

_PREVIEW, _TEXTURE, _PLACE = "UsdPreviewSurface", "UsdUVTexture", "UsdTransform2d"
_READER = "UsdPrimvarReader_"  # How the names of nodes begin that read values of meshes
_GRAY = (0.18, 0.18, 0.18)  # diffuseColor where none is given
_ONE, _ZERO = (1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 0.0)  # `scale` and `bias` where none is given
_TEXTURED = (
    "diffuseColor", "emissiveColor", "specularColor", "metallic", "roughness", "normal",
    "opacity", "clearcoat", "clearcoatRoughness",
)  # fmt: skip
"""Inputs that may be textures, in the order in which the first places those of a material."""
_UNSAID = "useMetadata"  # The wrap mode of textures of which it is left to their files
_REPEATING = ("repeat", "mirror")
_FINE = 256  # Texels across an image from which on a rim of one is narrow
_RIM = 2  # Texels at each end of an image that is black beyond: one of its edge, one black


class Lie(NamedTuple):
    """Where a texture lies: on which coordinates, which are scaled, rotated and moved."""

    primvar: str
    scale: tuple[float, float] = (1.0, 1.0)
    rotation: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)

    def turn(self, uv: Floats) -> Floats:
        """Return coordinates of vertices, (V, 2), as the textures of a mesh use them.

        Textures themselves scale and move, but do not rotate.
        """
        if not self.rotation:
            return uv
        angle = math.radians(self.rotation)
        cosine, sine = math.cos(angle), math.sin(angle)
        matrix = np.array([[cosine, -sine], [sine, cosine]])
        return (uv * self.scale) @ matrix.T + self.offset


@dataclass
class Look:
    """A material. It is made once all meshes are known, for its textures end where it is seen."""

    stage: Stage
    prim: Any = None  # of a material; None where none is bound
    low: Floats = field(default_factory=lambda: np.zeros(2))  # Texture coordinates of its meshes
    high: Floats = field(default_factory=lambda: np.ones(2))

    def reach(self, uv: Floats | None) -> None:
        """Take the texture coordinates of a mesh."""
        if self.lie and uv is not None and len(uv):
            self.low = np.minimum(self.low, [column.min() for column in uv.T])
            self.high = np.maximum(self.high, [column.max() for column in uv.T])

    @cached_property
    def _surface(self) -> _Surface | None:
        if not self.prim:
            return None
        shader = UsdShade.Material(self.prim).ComputeSurfaceSource()[0]
        if not shader or shader.GetShaderId() != _PREVIEW:
            self.stage.lose("shaders other than UsdPreviewSurface", self.prim)
            return None
        return _Surface(self, shader)

    @cached_property
    def lie(self) -> Lie | None:
        """Where its first texture lies; None without one."""
        return next(self._surface.lies(), None) if self._surface else None

    @cached_property
    def colors(self) -> str:
        """The primvar that gives it its diffuse colour; "" where none does."""
        return self._surface.primvar("diffuseColor") if self._surface else "displayColor"

    @cached_property
    def material(self) -> Material:
        """What it looks like; grey without a material."""
        if not self.prim:
            return Material("default")
        name = str(self.prim.GetName())
        try:
            return check_material(self._surface.material(name) if self._surface else Material(name))
        except InputError as error:
            raise InputError(f"material {name}: {error}", self.stage.path) from None


@dataclass
class _Surface:
    """A preview surface: its shader, and whose it is."""

    look: Look
    shader: Any

    def lose(self, what: str) -> None:
        self.look.stage.lose(what, self.look.prim)

    def material(self, name: str) -> Material:
        """Return what it looks like."""
        if self._node("displacement") or self._value("displacement", 0.0) != 0.0:
            self.lose("displacement")
        base, roughness = self.color("diffuseColor", _GRAY), self.data("roughness", 0.5)
        look: dict[str, Any]
        if self._value("useSpecularWorkflow", 0):
            glossy = self.color("specularColor", (0.0, 0.0, 0.0))
            look = {"reflectance": base, "glossy": glossy, "roughness": roughness}
        else:
            metallic = self.data("metallic", 0.0)
            if not lie_alike(base, metallic):
                self.lose("variation of metallic")
            if metallic != 0.0 and self.primvar("diffuseColor"):
                self.lose("colours of metals that vertices give")
            lobe = normal_reflectance(max(float(self._value("ior", USUAL_INDEX)), 1.0))
            look = metallic_gloss(base, metallic, lobe, roughness)._asdict()
        coat = self.data("clearcoat", 0.0)
        if not is_black(coat):
            look |= {"coat": coat, "coat_roughness": self.data("clearcoatRoughness", 0.01)}
        if normal := self._normal():
            look["relief"] = NormalMap(normal)
        emission = self.color("emissiveColor", (0.0, 0.0, 0.0))
        if not is_black(emission):
            look["emission"] = emission
        return Material(name, alpha=self.opacity(), **look)

    def color(self, name: str, default: Triple) -> Triple | Texture:
        """Return a colour, or a texture of colours."""
        if self._node(name):
            return self._texture(name) or (GREY, GREY, GREY)
        return plain(self._value(name, default))

    def data(self, name: str, default: float) -> float | Texture:
        """Return a number, or a texture of numbers."""
        if self._node(name):
            texture = self._texture(name)
            if texture is None:
                return default
            return mean_number(texture) if is_even(texture) else texture
        return float(self._value(name, default))

    def opacity(self) -> float | Texture:
        """Return the opacity, cut off where there is a threshold."""
        threshold = float(self._value("opacityThreshold", 0.0))
        opacity = self.data("opacity", 1.0)
        if threshold > 0.0 and isinstance(opacity, Texture):
            texels = opacity.image.linear(slice(None), slice(None)) * np.float32(opacity.factor[0])
            cut = Image((texels >= threshold).astype(np.float32), False)
            return replace(opacity, image=cut, factor=(1.0, 1.0, 1.0))
        if threshold > 0.0:
            return float(mean_number(opacity) >= threshold)
        is_clear = isinstance(opacity, Texture) or opacity < 1.0
        if is_clear and self._value("opacityMode", "transparent") == "transparent":
            self.lose("what a transparent surface reflects (opacityMode)")
        return opacity

    def primvar(self, name: str) -> str:
        """Return the name of the values of meshes that feed an input; "" where none do."""
        attribute = self._attribute(name)
        node = UsdShade.Shader(attribute.GetPrim()) if attribute is not None else None
        if not node or not str(node.GetShaderId()).startswith(_READER):
            return ""
        return str(self.look.stage.input(node, "varname", ""))

    def lies(self) -> Iterator[Lie]:
        """Yield where its textures lie."""
        for name in _TEXTURED:
            if found := self._node(name):
                yield self._lie(found[0])

    def _attribute(self, name: str) -> Any:
        """Return the attribute that gives an input its value; None if there is none."""
        given = self.shader.GetInput(name)
        found = UsdShade.Utils.GetValueProducingAttributes(given) if given else ()
        return found[0] if found else None

    def _value(self, name: str, default: Any) -> Any:
        """Return the value of an input that no texture feeds."""
        attribute, stage = self._attribute(name), self.look.stage
        if attribute is None:
            return default
        node = UsdShade.Shader(attribute.GetPrim())
        if not UsdShade.Output.IsOutput(attribute):
            return stage.color(attribute, default, math.inf if name == "emissiveColor" else 1.0)
        if name != "diffuseColor" or not self.primvar(name):
            self.lose(f"what feeds {name} ({node.GetShaderId() or 'no shader'})")
        return stage.input(node, "fallback", default) if self.primvar(name) else default

    def _node(self, name: str) -> tuple[Any, str] | None:
        attribute = self._attribute(name)
        node = UsdShade.Shader(attribute.GetPrim()) if attribute is not None else None
        if not node or node.GetShaderId() != _TEXTURE:
            return None
        return node, attribute.GetName().rpartition(":")[2]

    def _image(self, name: str) -> tuple[Texture, Any, str] | None:
        """Return the texture of an input as it is stored, its node, and its channel."""
        found = self._node(name)
        if found is None:
            return None
        (node, output), stage = found, self.look.stage
        try:
            channels, head, tiles = stage.tiles(stage.input(node, "file"))
            self._note_space(node, name)
            space = str(stage.input(node, "sourceColorSpace", "auto"))
            is_srgb = space == "sRGB" or (space != "raw" and is_srgb_by_itself(channels, head))
            if name == "normal" and space not in ("raw", "sRGB") and is_srgb:
                self.lose("sRGB of normal maps, which are read as raw,")
                is_srgb = False
            if space not in ("raw", "sRGB") and channels.has_other_primaries():
                self.lose("primaries and profiles that a texture's file states")
            image = _channel(channels, output, is_srgb)
        except InputError as error:
            if stage.options.missing_textures == "error":
                raise extended(error, OR_WITHOUT) from None
            self.lose("unreadable textures, with grey in their place,")
            return None
        modes = self._modes(node, head) if tiles == (1, 1) else ("black", "black")
        return self._placed(Texture(image), self._lie(node), modes, tiles), node, output

    def _note_space(self, node: Any, name: str) -> None:
        """Note primaries of a colour texture that the stage states, not `sourceColorSpace`."""
        stated = color_space(node.GetInput("file").GetAttr())
        if not name.endswith("Color") or stated == "auto":
            return
        space = named_space(stated)
        if (
            space.lost
            or space.refused
            or (space.primaries and to_srgb(space.primaries) is not None)
        ):
            self.lose(f"colour space {shown(stated)} of textures, which are read as sRGB,")

    def _modes(self, node: Any, head: bytes) -> tuple[str, ...]:
        """Return how a texture goes on along u and v: black unless it is said."""
        modes = [self.look.stage.input(node, name, _UNSAID) for name in ("wrapS", "wrapT")]
        if _UNSAID in modes and (b"wrapmodes" in head or b"wrapS" in head):
            self.lose("wrap modes that a texture's file states")
        return tuple("black" if mode == _UNSAID else str(mode) for mode in modes)

    def _placed(
        self, texture: Texture, lie: Lie, modes: tuple[str, ...], tiles: tuple[int, int]
    ) -> Texture:
        """Return a texture as it lies on its meshes, and as it goes on beyond its tiles."""
        first = self.look.lie or lie
        is_turned = bool(first.rotation or lie.rotation)
        if lie.primvar != first.primvar or (lie != first and is_turned):
            self.lose("texture coordinates of a further texture")
        if not first.rotation:
            texture = replace(texture, scale=lie.scale, offset=lie.offset)
        if tiles != (1, 1):
            scale, offset = (np.array(each) / tiles for each in (texture.scale, texture.offset))
            texture = replace(texture, scale=tuple(scale.tolist()), offset=tuple(offset.tolist()))
        ends = np.sort(np.array([self.look.low, self.look.high]) * texture.scale, axis=0)
        return wrapped(texture, modes, *(ends + texture.offset))

    def _texture(self, name: str) -> Texture | None:
        """Return the texture of an input, scaled; None if it cannot be read, which is noted."""
        found = self._image(name)
        if found is None:
            return None
        texture, node, output = found
        scale, bias = self._range(node, output)
        if not any(bias) and min(scale) >= 0.0:
            return replace(texture, factor=scale)
        return self._scaled(texture, scale, bias)

    def _normal(self) -> Texture | None:
        """Return a normal map, of which 0 is -1 and 1 is 1."""
        found = self._image("normal")
        if found is None:
            if self._attribute("normal") is not None:
                self._value("normal", None)
            return None
        texture, node, output = found
        scale, bias = self._range(node, output)
        if (scale, bias) == ((1.0,) * 3, (0.0,) * 3):
            self.lose("normal maps without scale and bias, which are read as with 2 and -1,")
            return texture
        scale, bias = plain(0.5 * each for each in scale), plain(0.5 * each + 0.5 for each in bias)
        is_plain = scale == (1.0, 1.0, 1.0) and not any(bias)
        return texture if is_plain else self._scaled(texture, scale, bias)

    def _range(self, node: Any, output: str) -> tuple[Triple, Triple]:
        """Return what multiplies the channels of a texture, and what is added."""
        stage = self.look.stage
        both = (stage.input(node, "scale", _ONE), stage.input(node, "bias", _ZERO))
        at = "rgba".find(output)
        scale, bias = (
            plain(row[:3] if at < 0 or len(output) > 1 else [row[at]] * 3) for row in both
        )
        return scale, bias

    def _scaled(self, texture: Texture, scale: Triple, bias: Triple) -> Texture:
        texels = texture.image.linear(slice(None), slice(None))
        count = 3 if len(set(scale)) > 1 or len(set(bias)) > 1 else texels.shape[2]
        texels = texels * np.array(scale[:count], np.float32) + np.array(bias[:count], np.float32)
        if (texels < 0.0).any():
            self.lose("values of textures below 0, which are read as 0,")
        return replace(texture, image=Image(np.maximum(texels, np.float32(0.0)), False))

    def _lie(self, node: Any) -> Lie:
        """Return where a texture lies; without coordinates, on those that meshes usually have."""
        source, lie = self._feeding(node, "st"), Lie("")
        if source and source.GetShaderId() == _PLACE:
            s, t = self.look.stage.input(source, "scale", (1.0, 1.0))
            u, v = self.look.stage.input(source, "translation", (0.0, 0.0))
            turn = math.remainder(float(self.look.stage.input(source, "rotation", 0.0)), 360.0)
            lie = Lie("", (float(s), float(t)), turn, (float(u), float(v)))
            source = self._feeding(source, "in")
        if source and source.GetShaderId() == f"{_READER}float2":
            return lie._replace(primvar=str(self.look.stage.input(source, "varname", "")))
        self.lose("textures without coordinates (st), which lie on those of the mesh,")
        return lie

    def _feeding(self, node: Any, name: str) -> Any:
        given = node.GetInput(name)
        found = UsdShade.Utils.GetValueProducingAttributes(given) if given else ()
        return UsdShade.Shader(found[0].GetPrim()) if found else None


def is_srgb_by_itself(channels: Channels, head: bytes) -> bool:
    """Return whether an image is sRGB by what its file states, or else by its channels.

    With 8 bits, three or four channels are sRGB, and one or two are not (UsdPreviewSurface 2.6,
    `sourceColorSpace`). Of PNG files, the chunks sRGB and gAMA count.

    head : how the file begins
    """
    if head.startswith(b"\x89PNG"):
        head = head[: head.find(b"IDAT")]
        if b"sRGB" in head:
            return True
        at = head.find(b"gAMA")
        if at >= 0:
            return 40000 < int.from_bytes(head[at + 4 : at + 8], "big") < 50000
    return channels.pixels.dtype == np.uint8 and len(channels.names) in (3, 4)


def _channel(channels: Channels, output: str, is_srgb: bool) -> Image:
    """Return the colours of an image, or one of its channels; alpha, 1 without one, is linear."""
    if output == "a":
        return channels.opacity()
    image = channels.data()
    texels: NDArray[Any] = image.texels
    if len(output) == 1:
        at = "rgb".index(output)
        texels = np.ascontiguousarray(texels[..., at : at + 1])
    if texels.dtype == np.uint8:
        return Image(texels, is_srgb)
    return Image(decode_srgb(texels).astype(np.float32) if is_srgb else texels, False)


def wrapped(texture: Texture, modes: tuple[str, ...], low: Floats, high: Floats) -> Texture:
    """Return a texture that goes on beyond the unit square by its mode in each direction.

    Between the centres of its outermost texels and its edge it is even where it ends.

    modes : repeat, mirror, clamp or black, along u and along v
    low, high : (2,) the least and largest coordinates at which it is looked up
    """
    clamps = modes[0] not in _REPEATING, modes[1] not in _REPEATING
    texture = replace(texture, clamp=clamps[0] if clamps[0] == clamps[1] else clamps)
    texture = texture.mirrored(modes[0] == "mirror", modes[1] == "mirror")
    for axis, mode in enumerate(modes):
        if mode == "black" and (low[axis] < 0.0 or high[axis] > 1.0):
            texture = _rimmed(texture, axis)
    return texture


def _rimmed(texture: Texture, axis: int) -> Texture:
    """Return a texture with black beyond its ends along u (0) or v (1)."""
    image: Image = texture.image
    rows = 1 - axis
    shape = list(image.texels.shape[:2])
    if shape[rows] < _FINE:  # An odd number of texels in place of each keeps it as it is
        shape[rows] *= 2 * math.ceil((_FINE / shape[rows] - 1) / 2) + 1
        image = Image(resized(texture, shape), False)
    count = image.texels.shape[rows]
    rim = [(0, 0)] * 3
    rim[rows] = (1, 1)
    texels: NDArray[Any] = np.pad(np.pad(image.texels, rim, mode="edge"), rim)
    whole, scale, offset = count + 2 * _RIM, list(texture.scale), list(texture.offset)
    scale[axis] *= count / whole
    offset[axis] = (offset[axis] * count + _RIM) / whole
    image = Image(texels, image.srgb)
    return replace(texture, image=image, scale=(scale[0], scale[1]), offset=(offset[0], offset[1]))
