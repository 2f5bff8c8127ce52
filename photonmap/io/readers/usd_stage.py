"""A USD stage: opened within its folder, its matrices with y up, its materials and what is lost."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Ar, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdShade

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Losses, note_loss, read_embedded
from photonmap.io.readers.registry import GREY, OR_WITHOUT, ReadOptions, extended
from photonmap.runtime.files import named_file, named_image
from photonmap.runtime.wording import shown
from photonmap.scene.images import Channels, Image, read_channels
from photonmap.scene.material import Material
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.layers import check_material
from photonmap.scene.surfaces.metallic import USUAL_INDEX, metallic_gloss
from photonmap.scene.surfaces.relief import NormalMap
from photonmap.scene.textures import Texture, is_black, mean_number
from photonmap.spectra.curves import Floats

WHITE = 6500.0  # Temperature, K, of lights whose colour is as given
MOST_LAYERS = 1000  # Files that a stage may be composed of
_UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""From z up to y up."""


@dataclass
class Stage:
    """An opened stage."""

    path: Path  # its file
    stage: Any  # of pxr
    options: ReadOptions  # a user's choices
    losses: Losses  # takes what is not simulated
    _names: set[str] = field(default_factory=set)

    def lose(self, what: str, prim: Any) -> None:
        """Note what is not simulated."""
        note_loss(self.losses, what, prim.GetName())

    def matrix(self, prim: Any) -> Floats:
        """Return the matrix of a prim, 4×4, from its coordinates to those of the scene."""
        time = self.stage.GetStartTimeCode()
        moved = UsdGeom.Imageable(prim).ComputeLocalToWorldTransform(time)
        is_z_up = UsdGeom.GetStageUpAxis(self.stage) == UsdGeom.Tokens.z
        matrix = np.array(moved, np.float64).T
        return _UPRIGHT @ matrix if is_z_up else matrix

    def value(self, attribute: Any, default: Any = None) -> Any:
        """Return what an attribute holds when the stage begins."""
        found = attribute.Get(self.stage.GetStartTimeCode()) if attribute else None
        return default if found is None else found

    def name(self, prim: Any) -> str:
        """Return the name of a prim, with a number where another has it."""
        name, count = prim.GetName(), 1
        while name in self._names:
            count += 1
            name = f"{prim.GetName()}_{count}"
        self._names.add(name)
        return str(name)


def open_stage(path: Path) -> Any:
    """Return a stage all of whose layers lie where files may be opened."""
    try:
        root = Sdf.Layer.FindOrOpen(str(path))
    except Tf.ErrorException:
        root = None
    if root is None:
        raise InputError("is not a USD stage, or is damaged; export it again", path)
    seen, waiting = {root.realPath}, [root]
    while waiting:
        layer = waiting.pop()
        folder = Path(layer.realPath.split("[")[0]).parent
        for name in layer.GetCompositionAssetDependencies():
            if ".usdz[" in layer.realPath or path.suffix.lower() == ".usdz":
                break  # packages hold all of their layers
            below = Sdf.Layer.FindOrOpen(str(named_file(folder, name)))
            if below is not None and below.realPath not in seen:
                seen.add(below.realPath)
                waiting.append(below)
            if len(seen) > MOST_LAYERS:
                raise InputError(f"is composed of more than {MOST_LAYERS} files; merge them", path)
    return Usd.Stage.Open(root)


def read_image(stage: Stage, asset: Any) -> Channels:
    """Return the image of an asset, which may lie in a package."""
    name = getattr(asset, "resolvedPath", "") or getattr(asset, "path", "")
    if ".usdz[" not in name:
        return read_channels(named_image(stage.path.parent, name))
    inside = Path(name.partition("[")[2].rstrip("]"))
    data = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(name))
    if data is None:
        raise InputError(f"{shown(str(inside))} is not in the package; export it again")
    return read_embedded(data.GetBuffer(), f"image{inside.suffix}")


def is_shown(prim: Any) -> bool:
    """Return whether a prim is visible when rendered."""
    item = UsdGeom.Imageable(prim)
    if not item or item.ComputeVisibility() == UsdGeom.Tokens.invisible:
        return False
    return item.ComputePurpose() in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


def is_light(prim: Any) -> bool:
    """Return whether a prim is a light."""
    return bool(prim.HasAPI(UsdLux.LightAPI))


def radiance_of(stage: Stage, light: Any) -> Floats:
    """Return intensity · 2^exposure · colour of a light, (3,), before any normalisation."""
    color = np.array(stage.value(light.GetColorAttr(), (1.0, 1.0, 1.0)), np.float64)
    if stage.value(light.GetEnableColorTemperatureAttr(), False):
        kelvin = stage.value(light.GetColorTemperatureAttr(), 6500.0)
        warmth = [UsdLux.BlackbodyTemperatureAsRgb(each) for each in (kelvin, WHITE)]
        color = color * np.array(warmth[0], np.float64) / warmth[1]
    exposure = stage.value(light.GetExposureAttr(), 0.0)
    factor = stage.value(light.GetIntensityAttr(), 1.0) * 2.0**exposure
    amount: Floats = factor * color * stage.value(light.GetDiffuseAttr(), 1.0)
    if not (np.isfinite(amount).all() and (amount >= 0.0).all() and math.isfinite(factor)):
        raise InputError(f"light {light.GetPrim().GetName()} is negative or not finite; correct it")
    return amount


_PREVIEW, _TEXTURE, _PLACE = "UsdPreviewSurface", "UsdUVTexture", "UsdTransform2d"
_UNREAD = ("displacement",)
_GRAY = (0.18, 0.18, 0.18)  # diffuseColor where none is given
_CHANNELS: dict[str, Callable[[Channels], Image]] = {"g": Channels.green, "b": Channels.blue}
Triple = tuple[float, float, float]


@dataclass
class Materials:
    """The materials of a stage, each read once."""

    stage: Stage
    _known: dict[str, Material] = field(default_factory=dict)

    def of(self, bound: Any) -> Material:
        """Return the material of a binding; grey without one."""
        material = bound.ComputeBoundMaterial()[0]
        path = str(material.GetPath()) if material else ""
        if path not in self._known:
            self._known[path] = self._read(material) if material else Material("default")
        return self._known[path]

    def _read(self, material: Any) -> Material:
        prim, name = material.GetPrim(), str(material.GetPrim().GetName())
        shader = material.ComputeSurfaceSource()[0]
        if not shader or shader.GetShaderId() != _PREVIEW:
            self.stage.lose("shaders other than UsdPreviewSurface", prim)
            return Material(name)
        try:
            return check_material(_Surface(self.stage, shader, prim).material(name))
        except InputError as error:
            raise InputError(f"material {name}: {error}", self.stage.path) from None


@dataclass
class _Surface:
    """A preview surface: its shader, and the prim of its material."""

    stage: Stage
    shader: Any
    prim: Any

    def material(self, name: str) -> Material:
        """Return what it looks like."""
        for lost in _UNREAD:
            if self._attribute(lost) is not None and self._value(lost, 0.0) != 0.0:
                self.stage.lose(lost, self.prim)
        base, roughness = self.color("diffuseColor", _GRAY), self.data("roughness", 0.5)
        look: dict[str, Any]
        if self._value("useSpecularWorkflow", 0):
            glossy = self.color("specularColor", (0.0, 0.0, 0.0))
            look = {"reflectance": base, "glossy": glossy, "roughness": roughness}
        else:
            lobe = normal_reflectance(max(float(self._value("ior", USUAL_INDEX)), 1.0))
            look = metallic_gloss(base, self.data("metallic", 0.0), lobe, roughness)._asdict()
        coat = self.data("clearcoat", 0.0)
        if not is_black(coat):
            look |= {"coat": coat, "coat_roughness": self.data("clearcoatRoughness", 0.01)}
        if normal := self._texture("normal", Channels.data):
            look["relief"] = NormalMap(normal)
        emission = self.color("emissiveColor", (0.0, 0.0, 0.0))
        if not is_black(emission):
            look["emission"] = emission
        return Material(name, alpha=self.opacity(), **look)

    def color(self, name: str, default: Triple) -> Triple | Texture:
        """Return a colour, or a texture of colours."""
        if self._node(name):
            return self._texture(name, Channels.image) or (GREY, GREY, GREY)
        red, green, blue = self._value(name, default)
        return float(red), float(green), float(blue)

    def data(self, name: str, default: float) -> float | Texture:
        """Return a number, or a texture of numbers."""
        if found := self._node(name):
            texture = self._texture(name, _CHANNELS.get(found[1], Channels.data))
            return default if texture is None else texture
        return float(self._value(name, default))

    def opacity(self) -> float:
        """Return the opacity, of a texture its mean, cut off where there is a threshold."""
        threshold = float(self._value("opacityThreshold", 0.0))
        paint = self.data("opacity", 1.0)
        opacity = mean_number(paint)
        if isinstance(paint, Texture):
            self.stage.lose("variation of opacity", self.prim)
        return float(opacity >= threshold) if threshold > 0.0 else opacity

    def _attribute(self, name: str) -> Any:
        """Return the attribute that gives an input its value; None if there is none."""
        given = self.shader.GetInput(name)
        found = UsdShade.Utils.GetValueProducingAttributes(given) if given else ()
        return found[0] if found else None

    def _value(self, name: str, default: Any) -> Any:
        """Return the value of an input that no texture feeds."""
        attribute = self._attribute(name)
        is_fed = attribute is None or self._node(name)
        return default if is_fed else self.stage.value(attribute, default)

    def _node(self, name: str) -> tuple[Any, str] | None:
        attribute = self._attribute(name)
        node = UsdShade.Shader(attribute.GetPrim()) if attribute is not None else None
        if not node or node.GetShaderId() != _TEXTURE:
            return None
        return node, attribute.GetName().rpartition(":")[2]

    def _texture(self, name: str, channel: Callable[[Channels], Image]) -> Texture | None:
        """Return the texture of an input; None if it cannot be read, which is noted."""
        found = self._node(name)
        if found is None:
            return None
        value = self.stage.value
        file = found[0].GetInput("file")
        try:
            image = channel(read_image(self.stage, value(file.GetAttr()) if file else None))
        except InputError as error:
            if self.stage.options.missing_textures == "error":
                raise extended(error, OR_WITHOUT) from None
            self.stage.lose("unreadable textures, with grey in their place,", self.prim)
            return None
        scale, offset = self._placement(found[0])
        factor = (1.0, 1.0, 1.0)
        if channel is Channels.image and found[0].GetInput("scale"):
            red, green, blue, _ = value(found[0].GetInput("scale").GetAttr(), (1, 1, 1, 1))
            factor = float(red), float(green), float(blue)
        wrap = found[0].GetInput("wrapS")
        clamp = bool(wrap) and value(wrap.GetAttr()) == "clamp"
        return Texture(image, scale, offset, clamp, factor)

    def _placement(self, node: Any) -> tuple[tuple[float, float], tuple[float, float]]:
        given = node.GetInput("st")
        found = UsdShade.Utils.GetValueProducingAttributes(given) if given else ()
        place = UsdShade.Shader(found[0].GetPrim()) if found else None
        if not place or place.GetShaderId() != _PLACE:
            return (1.0, 1.0), (0.0, 0.0)

        def of(name: str, default: Any) -> Any:
            attribute = place.GetInput(name)
            return self.stage.value(attribute.GetAttr(), default) if attribute else default

        if of("rotation", 0.0):
            self.stage.lose("rotation of textures", self.prim)
        (s, t), (u, v) = of("scale", (1.0, 1.0)), of("translation", (0.0, 0.0))
        return (float(s), float(t)), (float(u), float(v))
