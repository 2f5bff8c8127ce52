"""Files that OBJ, MTL and TOML files refer to: spectra as CSV, images as OpenEXR."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.errors import InputError, naming, warn
from photonmap.kernels.core.color import LUMINANCE
from photonmap.runtime.wording import shown
from photonmap.scene.images import write_image
from photonmap.scene.parameters import File
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture
from photonmap.spectra.curves import EXTRAPOLATE, Color, Spectrum

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

        Parameters
        ----------
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

        Parameters
        ----------
        label : whose it is
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
