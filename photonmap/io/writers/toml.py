"""Write what TOML scenes hold, and files they and MTL name: spectra as CSV, images as OpenEXR."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.errors import InputError, naming, warn
from photonmap.kernels.core.color import LUMINANCE
from photonmap.runtime.wording import shown
from photonmap.scene.camera import Camera
from photonmap.scene.images import write_image
from photonmap.scene.lights import Light
from photonmap.scene.material import Material
from photonmap.scene.parameters import (
    Colored,
    File,
    Fluorescent,
    Numbers,
    Parameter,
    Part,
    Whole,
    parameters_of,
)
from photonmap.scene.scene import Scene, check_names
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture
from photonmap.spectra.curves import EXTRAPOLATE, Color, Spectrum
from photonmap.spectra.fluorescence import DonaldsonMatrix, Fluorophore, as_fluorophores


def write_scene(
    changes: Mapping[str, Mapping[str, Any]],
    cameras: Sequence[Camera],
    lights: Iterable[Light],
    assets: Assets,
) -> list[str]:
    """Return the lines that give materials attributes, and describe cameras and lights.

    changes : by the name of a material, values by attribute
    """
    lines: list[str] = []
    for name, given in changes.items():
        labels = {attribute: f"{name} {attribute}" for attribute in given}
        lines += [f"[material.{_text(name)}]", *_keys(Material, given, assets, labels), ""]
    if len(cameras) > 1:
        check_names(cameras)
    for camera in cameras:
        has_fov = camera.projection is None and camera.height is None
        values = vars(camera) | ({} if has_fov else {"fov": None})
        labels = {attribute: camera.name or attribute for attribute in values}
        header = "[camera]" if len(cameras) == 1 else "[[camera]]"
        lines += [header, *_keys(Camera, values, assets, labels), ""]
    for light in lights:
        values = vars(light)
        labels = dict.fromkeys(values, light.name or light.kind)
        labels[light.color_attribute or ""] = f"light {light.name!r}"
        header = f'[[light]]\ntype = "{light.kind}"'
        lines += [header, *_keys(type(light), values, assets, labels), ""]
    return lines


def _keys(
    described: Any, values: Mapping[str, Any], assets: Assets, labels: Mapping[str, str]
) -> Iterator[str]:
    """Yield the lines of all attributes but those that are None, or an empty text, for none.

    labels : whose each attribute is, after which files are named
    """
    for attribute, parameter in parameters_of(described).items():
        value = values.get(attribute)
        is_empty = isinstance(value, str) and not value and not isinstance(parameter, File)
        if value is not None and not is_empty:
            text = _value(parameter, value, assets, labels[attribute])
            yield f"{parameter.key or attribute} = {text}"


def _value(parameter: Parameter, value: Any, assets: Assets, label: str) -> str:
    match parameter:
        case Part():
            pairs = [f"type = {_text(value.kind)}"] * (len(parameter.kinds) > 1)
            held = vars(value)
            pairs += _keys(type(value), held, assets, dict.fromkeys(held, label))
            return f"{{ {', '.join(pairs)} }}"
        case Fluorescent():
            tables = [_fluorophore(each, assets, label) for each in as_fluorophores(value)]
            return tables[0] if len(tables) == 1 else f"[{', '.join(tables)}]"
        case Colored():
            return _text(assets.color(value, label))
        case File():
            return _text(assets.file(parameter, value, label))
        case Whole() | Numbers(each=Whole()):
            return json.dumps(value)
    return _text(value)


def _fluorophore(each: Fluorophore, assets: Assets, label: str) -> str:
    """Return the table of a fluorophore, whose curves are files."""
    if isinstance(each, DonaldsonMatrix):
        pairs = [f"matrix = {_text(assets.file(_MATRIX, each, label))}"]
    else:
        curves = (("excitation", each.excitation), ("emission", each.emission))
        pairs = [f"{key} = {_text(assets.color(curve, label))}" for key, curve in curves]
        pairs.append(f"quantum_efficiency = {_text(each.quantum_efficiency)}")
    return f"{{ {', '.join([*pairs, *['anti_stokes = true'] * each.anti_stokes])} }}"


def _text(value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, float | int):
        return repr(float(value))
    return f"[{', '.join(repr(float(number)) for number in value)}]"


_LONGEST = 100  # characters of the stem of a file's name
_LUMINANCE = np.array(LUMINANCE, np.float32)
_MATRIX = File(
    "Donaldson matrix", read=DonaldsonMatrix.read, save=DonaldsonMatrix.save, suffix=".npz"
)


def check_name(name: str) -> None:
    """Refuse names that OBJ and MTL files cannot hold."""
    if name != " ".join(name.split()) or not name.isprintable() or re.search(r" #|^#|\\", name):
        raise InputError(f"the name {shown(name)} cannot be written; use letters and digits")


def name_materials(scene: Scene) -> dict[str, Material]:
    """Return all materials that faces use under names that differ: the second is "wall 2"."""
    used = {id(mesh.material): mesh.material for mesh in scene.meshes if len(mesh.faces)}
    named: dict[str, Material] = {}
    for material in used.values():
        wanted = name = material.name or "material"
        count = 1
        while name in named:
            count += 1
            name = f"{wanted} {count}"
        named[name] = material
    return named


class Assets:
    """Writes spectra and images to a folder, each only once.

    As a context manager it removes a folder that nothing was written to.

    Parameters
    ----------
    folder : created if it is missing; files are named relative to the folder that contains it
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(exist_ok=True)
        self.folder = folder
        self._known: dict[Any, str] = {}

    def __enter__(self) -> Assets:
        return self

    def __exit__(self, *error: object) -> None:
        if not any(self.folder.iterdir()):
            self.folder.rmdir()

    def color(self, color: Color, label: str) -> str:
        """Return the text of a colour, as `photonmap.spectra.color_text` reads it.

        label : whose it is; files are named after it
        """
        if isinstance(color, Spectrum):
            if color not in self._known:
                path = self._path(label, ".csv")
                rows = zip(color.wavelengths.tolist(), color.values.tolist(), strict=True)
                path.write_text("".join(f"{nm!r},{value!r}\n" for nm, value in rows))
                self._known[color] = self._name(path)
            return (EXTRAPOLATE if color.extrapolate else "") + self._known[color]
        if isinstance(color, tuple):
            return "rgb:" + ",".join(repr(float(value)) for value in color)
        return repr(float(color))

    def texture(self, texture: Texture, label: str, opacity: bool = False) -> str:
        """Write a texture times its factor; return its options and name, as MTL has them.

        opacity : its luminance counts
        """
        key = id(texture), opacity
        if key not in self._known:
            if isinstance(texture, SpectralTexture):
                warn(f"the spectra of a texture, {label}, are written as their colours under D65")
            linear = texture.image.linear(slice(None), slice(None))
            texels = (linear * np.array(texture.factor)).astype(np.float32)
            if opacity:
                texels = np.repeat((texels @ _LUMINANCE)[..., None], 3, axis=2)
            if texture.nearest or isinstance(texture.clamp, tuple):
                warn(f"{label} is written as a texture that is interpolated, and clamped in both "
                     "directions or none, as MTL has it")  # fmt: skip
            path = self._path(label, ".exr")
            write_image(texels, path)
            self._known[key] = self._name(path)
        (u, v), (du, dv) = texture.scale, texture.offset
        clamp = "-clamp on " if texture.clamp is True else ""
        return f"-s {u!r} {v!r} 1 -o {du!r} {dv!r} 0 {clamp}{self._known[key]}"

    def file(self, parameter: File, value: Any, label: str) -> str:
        """Write what a light keeps in a file, as its parameter declares; return the file's name."""
        path = self._path(label, parameter.suffix)
        with naming(label):
            parameter.save(value, path)
        return self._name(path)

    def _path(self, label: str, suffix: str) -> Path:
        """Return a free file name like a label."""
        stem = re.sub(r"[^\w.]+", "_", label, flags=re.ASCII).strip("_.")[:_LONGEST] or "file"
        path, count = self.folder / f"{stem}{suffix}", 1
        while path.exists():
            count += 1
            path = self.folder / f"{stem}_{count}{suffix}"
        return path

    def _name(self, path: Path) -> str:
        return f"{self.folder.name}/{path.name}"
