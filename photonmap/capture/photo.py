"""A photo: raw numbers, what they were before noise, how they are developed, and its files."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.capture.mosaic import Pattern, demosaic, initials
from photonmap.errors import InputError
from photonmap.io.dng import Negative, encode_dng
from photonmap.io.png import encode_png
from photonmap.kernels.core.color import LUMINANCE
from photonmap.results.files import write_json
from photonmap.results.preview import as_bytes
from photonmap.runtime.writing import check_output_folder, drafts_beside
from photonmap.scene.images import write_image
from photonmap.spectra.observer import observer

Image = NDArray[np.float32]

_FADES = 0.8  # Fraction of saturation from which on colours are not trusted
RAW, DEMOSAICED = "raw", "demosaiced"
"""Images of 16 bits: PNG of one channel or of three, TIFF of other numbers."""
DNG, SRGB, TRUTH, RECORD = "raw.dng", "srgb.png", "truth.npz", "sensor.json"
_SUFFIXES = (".png", ".tif")
_FULL = 65535


@dataclass(eq=False)
class Photo:
    """What a sensor recorded of a render. H, W and C are height, width and the number of channels.

    Parameters
    ----------
    raw : (H, W) uint16 of a mosaic, (H, W, C) without one; the numbers of the converter
    truth : (H, W, C) float32: what all channels of all pixels would give without noise, saturation
        and rounding; 0 is no light, 1 the white level
    record : JSON-able: sensor, channels, mosaic, exposure, black and white level, colours
    """

    raw: NDArray[np.uint16]
    truth: Image
    record: dict[str, Any]

    def __repr__(self) -> str:
        height, width, channels = self.truth.shape
        return f"<Photo {width} × {height}, {channels} channels, {self.record['time_s']:.3g} s>"

    @property
    def pattern(self) -> Pattern | None:
        """The channel of each filter of the mosaic, from 0; None without a mosaic."""
        rows = self.record["mosaic"]
        return None if rows is None else np.array(rows, np.intp)

    @property
    def linear(self) -> Image:
        """The raw numbers less black and the mean dark signal, 1 at the white level, as `raw`."""
        black, white = self.record["black"], self.record["white"]
        return ((self.raw - black) / (white - black)).astype(np.float32)

    @cached_property
    def demosaiced(self) -> Image:
        """(H, W, C) float32 in the unit of `truth`, which it estimates: the camera's colours."""
        pattern, linear = self.pattern, self.linear
        if pattern is None:
            return linear
        method = self.record["sensor"]["demosaic"]
        channels = self.truth.shape[2]
        return demosaic(linear.astype(np.float64), pattern, channels, method).astype(np.float32)

    def rgb(self, image: Image | None = None) -> Image:
        """Return an image in linear sRGB: (H, W, 3) float32; `demosaiced` by default.

        White-balanced, by the record's matrix; where a channel saturates, colour fades to white.

        image : (H, W, C) in the camera's colours, such as `truth`
        """
        camera = self.demosaiced if image is None else image
        neutral = np.array(self.record["neutral"])
        full = camera.max(axis=-1, keepdims=True) / self.record["saturates_at"]
        fade = np.clip((full - _FADES) / (1.0 - _FADES), 0.0, 1.0)
        balanced = camera / neutral
        balanced += fade**2 * (3.0 - 2.0 * fade) * (balanced.max(axis=-1, keepdims=True) - balanced)
        return (balanced * neutral @ np.array(self.record["to_srgb"]).T).astype(np.float32)

    @cached_property
    def srgb(self) -> NDArray[np.uint8]:
        """(H, W, 3) uint8 sRGB: `rgb`, in which a white at the white level is 1, compressed.

        The compression is equation 4 of E. Reinhard et al., "Photographic tone reproduction for
        digital images", SIGGRAPH 2002, without its key: the largest luminance becomes 1, and an
        image that has none above 1 stays as it is.
        """
        image = self.rgb().astype(np.float64)
        white = np.array(self.record["to_srgb"]) @ np.array(self.record["neutral"])
        image /= float(np.array(LUMINANCE) @ white)
        luminance = np.maximum(image @ np.array(LUMINANCE), 0.0)
        most = max(float(luminance.max(initial=0.0)), 1.0)
        scale = (1.0 + luminance / most**2) / (1.0 + luminance)
        return as_bytes(image * scale[..., None], 1.0)


def save_photo(photo: Photo, folder: str | PathLike[str]) -> list[Path]:
    """Write a photo into a folder, which is made if it is missing: all of its files or none.

    raw.png has the numbers of the converter, raw.dng the same for mosaics of red, green and blue;
    demosaiced.png is linear, in the camera's colours, between the levels of sensor.json; srgb.png
    is tone-mapped; truth.npz has the noise-free `truth`. Raw and demosaiced images of other than
    one or three channels are .tif.

    Returns
    -------
    The files

    Raises
    ------
    InputError : the folder cannot be written to
    OSError : writing fails
    """
    place = check_output_folder(folder, "the photo")
    size = sum(image.nbytes for image in (photo.raw, photo.demosaiced, photo.truth))
    with drafts_beside(place, size, place if place.is_dir() else place.parent) as part:
        write_photo(photo, part)
        place.mkdir(exist_ok=True)
        for name in (DNG, *(f"{stem}{end}" for stem in (RAW, DEMOSAICED) for end in _SUFFIXES)):
            if not (part / name).exists():
                (place / name).unlink(missing_ok=True)  # of a photo by another sensor
        return [path.replace(place / path.name) for path in sorted(part.iterdir())]


def write_photo(photo: Photo, folder: Path) -> None:
    """Write the files of a photo into a folder that is there."""
    record = dict(photo.record)
    black = record["black"] * (_FULL / record["white"])
    scaled = black + photo.demosaiced * (_FULL - black)
    demosaiced = np.clip(np.rint(scaled), 0, _FULL).astype(np.uint16)
    record["demosaiced"] = {"black": black, "white": float(_FULL)}
    record["files"] = {
        RAW: _write(photo.raw, folder / RAW),
        DEMOSAICED: _write(demosaiced, folder / DEMOSAICED),
    }
    if (negative := _negative(photo)) is not None:
        (folder / DNG).write_bytes(encode_dng(negative))
    (folder / SRGB).write_bytes(encode_png(photo.srgb))
    np.savez_compressed(folder / TRUTH, truth=photo.truth)
    write_json(record, folder / RECORD)


def _write(image: NDArray[np.uint16], stem: Path) -> str:
    """Write an image as PNG, or as TIFF where that cannot hold its channels; return its name."""
    if image.ndim == 2 or image.shape[2] in (1, 3):
        path = stem.with_suffix(".png")
        path.write_bytes(encode_png(image, linear=True))
        return path.name
    path = stem.with_suffix(".tif")
    write_image(image, path)
    return path.name


def _negative(photo: Photo) -> Negative | None:
    """Return a photo as a DNG holds it; None if its mosaic is not of red, green and blue."""
    record, pattern = photo.record, photo.pattern
    letters = initials(record["channels"])
    if pattern is None or letters is None or sorted(letters) != ["B", "G", "R"]:
        return None
    order = [letters.index(letter) for letter in "RGB"]
    to_camera = np.linalg.inv(np.array(record["to_xyz"]))[order]
    eye = observer()
    white = eye.rgb_to_xyz.sum(axis=1)
    neutral = np.array(record["neutral"])[order]
    sensor = record["sensor"]
    return Negative(
        photo.raw,
        np.argsort(order)[pattern],
        record["black"],
        record["white"],
        to_camera / (to_camera @ white / white[1]).max(),
        neutral.tolist(),
        Path(sensor["camera"]).name,
        record["time_s"],
        sensor["aperture"],
        sensor["iso"],
    )


def load_photo(folder: str | PathLike[str]) -> Photo:
    """Read what `save_photo` wrote.

    Raises
    ------
    InputError : the folder holds no photo, or it is damaged
    """
    place = Path(folder)
    if not (place / RECORD).is_file():
        raise InputError(f"has no {RECORD}; name a folder that holds a photo", folder)
    try:
        record = json.loads((place / RECORD).read_text(encoding="utf-8"))
        with np.load(place / TRUTH) as file:
            truth = file["truth"]
        names = record.pop("files")
        raw = _read(place / names[RAW])
        del record["demosaiced"]
        if raw.shape != (*truth.shape[:2], 1 if record["mosaic"] else truth.shape[2]):
            raise ValueError("its images are of different sizes")
    except (OSError, EOFError, ValueError, KeyError) as error:
        raise InputError(f"is damaged ({error}); write it again", folder) from None
    return Photo(raw[..., 0] if record["mosaic"] else raw, truth, record)


def _read(path: Path) -> NDArray[Any]:
    import OpenImageIO

    file = OpenImageIO.ImageInput.open(str(path))
    if file is None:
        raise OSError(f"{path.name}: {OpenImageIO.geterror()}")
    pixels = file.read_image(OpenImageIO.UINT16)
    file.close()
    if pixels is None:
        raise OSError(f"{path.name} cannot be read")
    return pixels
