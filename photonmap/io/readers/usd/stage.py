"""An opened USD stage: its values as it begins, and the one door to the files that it names."""

from __future__ import annotations

import glob
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers import decoding
from photonmap.io.readers.registry import ReadOptions
from photonmap.runtime.bounds import Budget
from photonmap.runtime.files import allowed_folder, is_below, named_file, named_image, outside
from photonmap.runtime.wording import shown
from photonmap.scene.image_headers import named_space
from photonmap.scene.images import OUTSIDE, Channels, read_channels
from photonmap.scene.photometric import Table, parse_ies, read_ies
from photonmap.spectra.curves import Floats
from photonmap.spectra.rgb_spaces import decode_linear, to_srgb

if find_spec("pxr") is not None:
    from pxr import Ar, Sdf, Tf, Usd, UsdGeom, UsdShade

MOST_LAYERS = 1000  # Files that a stage may be composed of
_DAMAGED = "is not a USD stage, or is damaged{}; export it again"
_PARSING = re.compile(r":(\d+):\d+: (?:parse error .*?|(.*?)) at '(.*)'(?: in <.*>)?$", re.M)
"""What USD says of a text file: the line, the reason unless it names rules of a grammar, and where
"""
_TEMPLATE = "templateAssetPath"  # The one name of files that is text in USD's metadata
_UDIM, _FIRST = "<UDIM>", 1001  # What stands for the number of a tile, and that at u = v = 0
_MOST_TEXELS = 1 << 30  # Values of all tiles together, with those between them
_HEADER = 4096  # Bytes of an image file, among which its encoding is stated
UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""From z up to y up."""


@dataclass
class Stage:
    """An opened stage."""

    path: Path  # its file
    stage: Any  # of pxr
    has_clips: bool  # whether its files name value clips
    options: ReadOptions  # a user's choices
    losses: decoding.Losses  # takes what is not simulated
    _names: dict[str, int] = field(default_factory=dict)

    @cached_property
    def budget(self) -> Budget:
        """What its prims take: packed arrays may be long, and prims shown often."""
        return Budget(self.path)

    def lose(self, what: str, prim: Any) -> None:
        """Note what is not simulated."""
        decoding.note_loss(self.losses, what, prim.GetName())

    @cached_property
    def moves(self) -> bool:
        """Whether its files state values at several times."""
        layers = self.stage.GetUsedLayers()
        times = {time for layer in layers for time in layer.ListAllTimeSamples()}
        return self.has_clips or len(times) > 1

    @cached_property
    def time(self) -> float:
        """When the stage begins, at which it is read."""
        return float(self.stage.GetStartTimeCode())

    @property
    def is_z_up(self) -> bool:
        """Whether z is up in the stage; y is in the scene."""
        return bool(UsdGeom.GetStageUpAxis(self.stage) == UsdGeom.Tokens.z)

    def matrix(self, prim: Any) -> Floats:
        """Return the matrix of a prim, 4×4, from its coordinates to those of the scene."""
        moved = UsdGeom.Imageable(prim).ComputeLocalToWorldTransform(self.time)
        matrix = np.array(moved, np.float64).T
        return UPRIGHT @ matrix if self.is_z_up else matrix

    def note_motion(self, prim: Any) -> None:
        """Note a prim that moves, or appears; what its attributes do is noted as they are read."""
        if not self.moves:
            return
        item = UsdGeom.Imageable(prim)
        moves = UsdGeom.Xformable(prim)
        if (moves and moves.TransformMightBeTimeVarying()) or (
            item and item.GetVisibilityAttr().ValueMightBeTimeVarying()
        ):
            self.lose("animation", prim)

    def value(self, attribute: Any, default: Any = None) -> Any:
        """Return what an attribute holds when the stage begins; what feeds it is not simulated."""
        if not attribute:
            return default
        if attribute.HasAuthoredConnections():
            self.lose(f"what feeds {attribute.GetName()}", attribute.GetPrim())
        if self.moves and attribute.GetNumTimeSamples() > 1:
            self.lose("animation", attribute.GetPrim())
        found = attribute.Get(self.time)
        return default if found is None else found

    def color(self, attribute: Any, default: Any, most: float = math.inf) -> Any:
        """Return a colour in linear sRGB, up to a largest value."""
        found = self.value(attribute, default)
        return self.linear_srgb(attribute, found, most) if attribute else found

    def linear_srgb(self, attribute: Any, colors: Any, most: float) -> Any:
        """Return colours, (..., 3), of an attribute in linear sRGB, clipped to its gamut."""
        if attribute.GetRoleName() != Sdf.ValueRoleNames.Color:
            return colors
        prim, name = attribute.GetPrim(), color_space(attribute)
        space = named_space(name)
        if space.lost or space.refused:
            self.lose(f"colour space {shown(name)}, which is not known,", prim)
            return colors
        matrix = None if space.primaries is None else to_srgb(space.primaries)
        if matrix is None and space.transfer in (None, decode_linear):
            return colors
        values = np.asarray(colors, np.float64)
        linear = np.sign(values) * (space.transfer or decode_linear)(np.abs(values))
        linear = linear if matrix is None else linear @ matrix.T
        kept = np.clip(linear, 0.0, max(most, values.max(initial=0.0)))
        if not np.allclose(kept, linear, rtol=0.0, atol=OUTSIDE * np.abs(linear).max(initial=0.0)):
            self.lose("colours outside sRGB, which are clipped,", prim)
        return kept

    def input(self, shader: Any, name: str, default: Any = None) -> Any:
        """Return the value of a shader's input, which its material may give."""
        given = shader.GetInput(name)
        found = UsdShade.Utils.GetValueProducingAttributes(given) if given else ()
        return self.value(found[0], default) if found else default

    def name(self, prim: Any) -> str:
        """Return the name of a prim, with a number where another has it."""
        wanted = name = str(prim.GetName())
        while name in self._names:
            self._names[wanted] += 1
            name = f"{wanted}_{self._names[wanted]}"
        self._names[name] = 1
        return name

    def image(self, asset: Any) -> tuple[Channels, bytes]:
        """Return the image of an asset, which may lie in a package, and how its file begins."""
        name = getattr(asset, "resolvedPath", "") or getattr(asset, "path", "")
        if _UDIM in name:
            message = f"{shown(Path(name).name)} is a set of UDIM tiles, which are not read here"
            raise InputError(f"{message}; bake them into one image")
        if not Ar.IsPackageRelativePath(name):
            file = named_image(self.path.parent, name)
            channels = read_channels(file)
            with file.open("rb") as opened:
                return channels, opened.read(_HEADER)
        inside, data = self._packed(asset, name)
        channels = decoding.read_embedded(data, f"image{inside.suffix}")
        return channels, bytes(data[:_HEADER])

    def tiles(self, asset: Any) -> tuple[Channels, bytes, tuple[int, int]]:
        """Return the image of an asset, how its file begins, and its tiles along u and v.

        UDIM tiles become one image, black where there is none; of those in packages see `image`.
        """
        name = getattr(asset, "resolvedPath", "") or getattr(asset, "path", "")
        if _UDIM not in name or Ar.IsPackageRelativePath(name):
            return *self.image(asset), (1, 1)
        pattern = named_file(self.path.parent, name)
        before, after = pattern.name.split(_UDIM, 1)
        wanted = f"{glob.escape(before)}1[0-9][0-9][0-9]{glob.escape(after)}"
        files = [named_file(each.parent, each.name) for each in pattern.parent.glob(wanted)]
        if not files:
            raise InputError(f"{shown(pattern.name)} has no tiles; correct its name")
        read = {int(file.name[len(before) :][:4]) - _FIRST: read_channels(file) for file in files}
        first = read[min(read)]
        columns, rows = (1 + max(n % 10 for n in read)), (1 + max(n // 10 for n in read))
        height, width, count = first.pixels.shape
        if min(read) < 0 or columns * rows * first.pixels.size > _MOST_TEXELS:
            raise InputError(f"{shown(pattern.name)} has tiles too far apart; bake them into one")
        whole = np.zeros((rows, height, columns, width, count), first.pixels.dtype)
        for number, tile in read.items():
            if tile.pixels.shape != first.pixels.shape or tile.pixels.dtype != whole.dtype:
                message = f"{shown(pattern.name)} has tiles of different sizes or types"
                raise InputError(f"{message}; make them alike")
            whole[rows - 1 - number // 10, :, number % 10] = tile.pixels
        pixels = whole.reshape(rows * height, columns * width, count)
        with first.path.open("rb") as opened:
            return replace(first, pixels=pixels), opened.read(_HEADER), (columns, rows)

    def photometry(self, asset: Any) -> Table:
        """Return the table of an IES file, which may lie in a package."""
        name = getattr(asset, "resolvedPath", "") or getattr(asset, "path", "")
        if not Ar.IsPackageRelativePath(name):
            return read_ies(named_image(self.path.parent, name))
        inside, data = self._packed(asset, name)
        return parse_ies(bytes(data).decode("latin-1"), inside)

    def _packed(self, asset: Any, name: str) -> tuple[Path, Any]:
        """Return the name of a file in a package, and its bytes."""
        named_file(self.path.parent, Ar.SplitPackageRelativePathOuter(name)[0])
        refuse_outside(self.path, asset.path, name)
        inside = Path(Ar.SplitPackageRelativePathInner(name)[1])
        found = Ar.ResolvedPath(asset.resolvedPath)  # USD looks up other names elsewhere, too
        data = Ar.GetResolver().OpenAsset(found) if found else None
        if data is None:
            raise InputError(f"{shown(str(inside))} is not in the package; export it again")
        return inside, data.GetBuffer()


def color_space(attribute: Any) -> str:
    """Return the space that a colour, or else the nearest prim above it, states; "" for none."""
    name, prim = str(attribute.GetColorSpace()), attribute.GetPrim()
    while not name and prim:
        if "ColorSpaceAPI" in prim.GetAppliedSchemas():
            name = str(prim.GetAttribute("colorSpace:name").Get() or "")
        prim = prim.GetParent()
    return name


def open_stage(path: Path, losses: decoding.Losses) -> tuple[Any, bool]:
    """Return a stage, and whether it has value clips; nothing outside of its folder is opened.

    USD opens what layers name when it composes them. So names are followed before that, with its
    own resolver: sublayers, references and payloads, in whatever variant, and value clips.
    """
    root = _open_layer(path, str(path))
    if root is None:
        raise InputError(_DAMAGED.format(""), path)
    layers, waiting = {root.realPath: root, str(path): root}, [root]
    has_clips = False
    while waiting:
        layer = waiting.pop()
        for name in _clips(layer):
            has_clips = True
            _find(path, layer, name)
        for name in filter(None, layer.GetCompositionAssetDependencies()):  # "": the layer itself
            found = _find(path, layer, name)
            if found in layers:
                continue
            layers[found] = below = _open_layer(path, found)
            if below is None:
                decoding.note_loss(losses, f"{shown(name)}, which does not exist,", path.name)
            else:
                waiting.append(below)
            if len(layers) > MOST_LAYERS:
                raise InputError(f"is composed of more than {MOST_LAYERS} files; merge them", path)
    stage = Usd.Stage.Open(root)
    check_layers(path, stage)
    return stage, has_clips


def check_layers(path: Path, stage: Any) -> None:
    """Refuse a stage that USD has composed of a file outside of the scene's folder after all."""
    for layer in stage.GetUsedLayers():
        if not layer.anonymous:
            refuse_outside(path, layer.realPath, layer.realPath)


def refuse_outside(scene: Path, name: str, found: str) -> None:
    """Refuse a name by which USD finds a file, or a package, outside of the scene's folder."""
    outer = Ar.SplitPackageRelativePathOuter(found)[0]
    file, root = Path(str(Ar.GetResolver().Resolve(outer)) or outer), allowed_folder(scene)
    if file.is_absolute() and not is_below(file, root):  # A relative one does not exist
        raise InputError(f"{shown(name)} {outside(root)}", scene)


def _find(scene: Path, layer: Any, name: str) -> str:
    """Return what USD opens by a name in a layer, if it may."""
    if Sdf.VariableExpression.IsExpression(name):
        raise InputError(f"{shown(name)} is an expression; name the file itself", scene)
    found = str(Sdf.ComputeAssetPathRelativeToLayer(layer, name))
    refuse_outside(scene, name, found)
    return found


def _open_layer(scene: Path, found: str) -> Any:
    """Open a layer; None where there is no such file."""
    held, wrong = Sdf.Layer.Find(found), None
    try:
        if held and not held.dirty:  # of an earlier stage; the file may have changed
            held.Reload(force=True)
        layer = Sdf.Layer.FindOrOpen(found)
    except Tf.ErrorException as error:
        layer, wrong = None, _PARSING.search(str(error))
    if layer is None and Ar.GetResolver().Resolve(found):
        reason = f": {wrong[2]}" if wrong and wrong[2] else ""
        message = _DAMAGED.format(f"{reason} at {shown(wrong[3])}" if wrong else "")
        line = int(wrong[1]) if wrong else None
        if found == str(scene):
            raise InputError(message, scene, line)
        raise InputError(f"{shown(found)}{f':{line}' if line else ''} {message}", scene)
    return layer


def _clips(layer: Any) -> Iterator[str]:
    """Yield the names of the value clips of a layer, and of their manifests."""
    waiting = list(layer.rootPrims)
    while waiting:
        prim = waiting.pop()
        waiting += prim.nameChildren
        for variants in prim.variantSets.values():
            waiting += [variant.primSpec for variant in variants.variants.values()]
        for clips in (prim.GetInfo("clips") if prim.HasInfo("clips") else {}).values():
            for key, value in clips.items():
                names = value if key == "assetPaths" else [value]
                for each in names:
                    name = getattr(each, "path", each)
                    if name and (isinstance(each, Sdf.AssetPath) or key == _TEMPLATE):
                        yield name
