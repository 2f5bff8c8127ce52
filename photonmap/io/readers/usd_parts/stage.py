"""A USD stage: opened within its folder; its matrices with y up; and what is lost."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Ar, Sdf, Tf, Usd, UsdGeom, UsdLux

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Losses, note_loss, read_embedded
from photonmap.io.readers.registry import ReadOptions
from photonmap.runtime.named_files import named_file, named_image
from photonmap.runtime.wording import shown
from photonmap.scene.images import Channels, read_channels

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

    def matrix(self, prim: Any) -> NDArray[np.float64]:
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


def radiance_of(stage: Stage, light: Any) -> NDArray[np.float64]:
    """Return intensity · 2^exposure · colour of a light, (3,), before any normalisation."""
    color = np.array(stage.value(light.GetColorAttr(), (1.0, 1.0, 1.0)), np.float64)
    if stage.value(light.GetEnableColorTemperatureAttr(), False):
        kelvin = stage.value(light.GetColorTemperatureAttr(), 6500.0)
        warmth = [UsdLux.BlackbodyTemperatureAsRgb(each) for each in (kelvin, WHITE)]
        color = color * np.array(warmth[0], np.float64) / warmth[1]
    exposure = stage.value(light.GetExposureAttr(), 0.0)
    factor = stage.value(light.GetIntensityAttr(), 1.0) * 2.0**exposure
    amount: NDArray[np.float64] = factor * color * stage.value(light.GetDiffuseAttr(), 1.0)
    if not (np.isfinite(amount).all() and (amount >= 0.0).all() and math.isfinite(factor)):
        raise InputError(f"light {light.GetPrim().GetName()} is negative or not finite; correct it")
    return amount
