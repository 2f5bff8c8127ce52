"""Write what TOML scenes hold, and files they and MTL name: spectra as CSV, images as OpenEXR."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
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
from photonmap.scene.parameters import Colored, File, Numbers, Parameter, Part, Whole, parameters_of
from photonmap.scene.scene import check_names
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture
from photonmap.spectra.curves import EXTRAPOLATE, Color, Spectrum


def write_materials(changes: Mapping[str, Mapping[str, Any]], assets: Assets) -> Iterator[str]:
    """Yield the lines that give materials attributes.

    changes : by the name of a material, values by attribute
    """
    parameters = parameters_of(Material)
    for name, values in changes.items():
        yield f"[material.{_text(name)}]"
        for attribute, value in values.items():
            parameter = parameters[attribute]
            text = _value(parameter, value, assets, f"{name} {attribute}")
            yield f"{parameter.key or attribute} = {text}"
        yield ""


def write_cameras(cameras: Sequence[Camera], assets: Assets) -> Iterator[str]:
    """Yield the lines that describe cameras."""
    if len(cameras) > 1:
        check_names(cameras)
    for camera in cameras:
        yield "[camera]" if len(cameras) == 1 else "[[camera]]"
        yield from _camera_keys(camera, assets)
        yield ""


def write_lights(lights: Sequence[Light], assets: Assets) -> Iterator[str]:
    """Yield the lines that describe lights."""
    for light in lights:
        yield "[[light]]"
        yield f'type = "{light.kind}"'
        yield from _light_keys(light, assets)
        yield ""


def _camera_keys(camera: Camera, assets: Assets) -> Iterator[str]:
    is_pinhole = camera.projection is None and camera.height is None
    for attribute, parameter in parameters_of(Camera).items():
        value = getattr(camera, attribute)
        if value not in (None, "") and (attribute != "fov" or is_pinhole):
            text = _value(parameter, value, assets, camera.name or attribute)
            yield f"{attribute} = {text}"


def _table(part: Part, value: Any, assets: Assets, label: str) -> str:
    pairs = [f"type = {_text(value.kind)}"] * (len(part.kinds) > 1)
    for attribute, parameter in parameters_of(type(value)).items():
        if (held := getattr(value, attribute)) is not None:
            text = _value(parameter, held, assets, label)
            pairs.append(f"{parameter.key or attribute} = {text}")
    return f"{{ {', '.join(pairs)} }}"


def _value(parameter: Parameter, value: Any, assets: Assets, label: str) -> str:
    match parameter:
        case Part():
            return _table(parameter, value, assets, label)
        case Colored():
            return _text(assets.color(value, label))
        case File():
            return _text(assets.file(parameter, value, label))
        case Whole() | Numbers(each=Whole()):
            return json.dumps(value)
    return _text(value)


def _light_keys(light: Light, assets: Assets) -> Iterator[str]:
    for attribute, parameter in parameters_of(type(light)).items():
        value = getattr(light, attribute)
        if isinstance(parameter, Colored | File) or value != "":
            is_color = isinstance(parameter, Colored)
            label = f"light {light.name!r}" if is_color else light.name or light.kind
            yield f"{parameter.key or attribute} = {_value(parameter, value, assets, label)}"


def _text(value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, float | int):
        return repr(float(value))
    return f"[{', '.join(repr(float(number)) for number in value)}]"


_LUMINANCE = np.array(LUMINANCE, np.float32)


def check_name(name: str) -> None:
    """Refuse names that OBJ and MTL files cannot hold."""
    if name != " ".join(name.split()) or not name.isprintable() or re.search(r" #|^#|\\", name):
        raise InputError(f"the name {shown(name)} cannot be written; use letters and digits")


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
            path = self._path(label, ".exr")
            write_image(texels, path)
            self._known[key] = self._name(path)
        (u, v), (du, dv) = texture.scale, texture.offset
        clamp = "-clamp on " if texture.clamp else ""
        return f"-s {u!r} {v!r} 1 -o {du!r} {dv!r} 0 {clamp}{self._known[key]}"

    def file(self, parameter: File, value: Any, label: str) -> str:
        """Write what a light keeps in a file, as its parameter declares; return the file's name."""
        path = self._path(label, parameter.suffix)
        with naming(label):
            parameter.save(value, path)
        return self._name(path)

    def _path(self, label: str, suffix: str) -> Path:
        """Return a free file name like a label."""
        stem = re.sub(r"[^\w.]+", "_", label, flags=re.ASCII).strip("_.") or "file"
        path, count = self.folder / f"{stem}{suffix}", 1
        while path.exists():
            count += 1
            path = self.folder / f"{stem}_{count}{suffix}"
        return path

    def _name(self, path: Path) -> str:
        return f"{self.folder.name}/{path.name}"
