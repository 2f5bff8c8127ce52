"""The command `python -m photonmap sensor`: a render as a camera would have recorded it."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from photonmap.commands import shared
from photonmap.errors import InputError, naming

if TYPE_CHECKING:
    from photonmap.capture.photo import Photo
    from photonmap.capture.sensor import Sensor

HELP = "Simulate a photo of a render: raw files with noise, developed images, noise-free truth."

_LARGEST_SEED = 2**63 - 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command: those of `photonmap.Sensor`, and its files."""
    from photonmap.capture.sensor import GROUPS, OPTIONS

    text = "renders in any bands, with radiance among their buffers"
    parser.add_argument("images", nargs="+", metavar="IMAGE.exr", help=text)
    text = "values of options that are not given here; keys are their names, with _ for -"
    shared.add_value(parser, "sensor", "FILE.toml", text)
    for title in GROUPS:
        group = parser.add_argument_group(title)
        for option in OPTIONS.values():
            if option.group == title:
                text = option.default_text or f"{option.default}"
                shared.add_option(group, replace(option, default=None, default_text=text))
    files = parser.add_argument_group("files")
    text = "seed of the noise of the first image; each further image adds 1"
    shared.add_value(
        files, "seed", "N", text, read=shared.whole_number(0, _LARGEST_SEED), default=0
    )
    text = "folder to write to; several images have one folder each in it"
    usual = "IMAGE-sensor beside each image"
    more = {"default_text": usual, "short": "o", "read": shared.file_name}
    shared.add_value(files, "output", "FOLDER", text, **more)
    shared.add_quiet(parser)


def run(options: argparse.Namespace) -> None:
    """Expose the sensor to each image and write its photo."""
    from photonmap.capture.expose import expose, find_response
    from photonmap.capture.photo import save_photo
    from photonmap.results.result import load_result
    from photonmap.runtime.writing import check_output_folder

    sensor = _sensor(options)
    find_response(sensor)  # which would name an image for what is wrong with the camera
    folders = _folders([Path(image) for image in options.images], options.output)
    for folder in folders.values():
        check_output_folder(folder, "the photo")
    for number, (image, folder) in enumerate(folders.items()):
        result = load_result(image)
        with naming(str(image)):
            photo = expose(result, sensor, options.seed + number)
        written = save_photo(photo, folder)
        shared.say(options, _describe(image, photo), *written)


def _folders(images: list[Path], output: str | None) -> dict[Path, Path]:
    """Return the folder of each image's photo, called after it, or where names agree its folder."""
    if output is None:
        return {image: image.with_name(f"{image.stem}-sensor") for image in images}
    if len(images) == 1:
        return {images[0]: Path(output)}
    by_stem = len({image.stem for image in images}) == len(images)
    folders = {
        image: Path(output) / (image.stem if by_stem else image.resolve().parent.name)
        for image in images
    }
    if len(set(folders.values())) < len(images):
        raise InputError(
            "two images are of one name and folder; give each once, or leave out --output"
        )
    return folders


def _sensor(options: argparse.Namespace) -> Sensor:
    """Return the sensor of the file, if there is one, with what the options change."""
    from photonmap.capture.sensor import OPTIONS, Sensor, load_sensor

    given = {name: getattr(options, name) for name in OPTIONS if getattr(options, name) is not None}
    if not options.sensor:
        return Sensor(**given)
    if Path(options.sensor).suffix.lower() != ".toml":
        problem = f"--sensor {options.sensor!r} is not a FILE.toml"
        raise InputError(f"{problem}; name cameras by --camera")
    return replace(load_sensor(options.sensor), **given)


def _describe(image: Path, photo: Photo) -> str:
    record = photo.record
    return (
        f"{image}: {record['time_s']:.4g} s at f/{record['sensor']['aperture']:g}, "
        f"ISO {record['sensor']['iso']:g}; {record['gain_dn_per_electron']:.4g} numbers per "
        f"electron, black {record['black']:.6g}, white {record['white']}; "
        f"{record['saturated']:.2%} saturated"
    )
