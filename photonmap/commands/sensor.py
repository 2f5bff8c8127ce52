"""The command `python -m photonmap sensor`: a render as a camera would have recorded it."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from photonmap.commands.arguments import whole_number
from photonmap.commands.options import add_option, add_quiet
from photonmap.errors import InputError, naming

if TYPE_CHECKING:
    from photonmap.capture.photo import Photo
    from photonmap.capture.sensor import Sensor

HELP = "Expose a camera's sensor to a render: raw files with noise, developed images, the truth."

_LARGEST_SEED = 2**63 - 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command: those of `photonmap.Sensor`, and its files."""
    from photonmap.capture.sensor import GROUPS, OPTIONS

    parser.add_argument(
        "image", metavar="IMAGE.exr", help="a render in any bands, with radiance among its buffers"
    )
    parser.add_argument(
        "--sensor",
        metavar="FILE.toml",
        help="what is not given here, by the names of these options with _ for -",
    )
    for title in GROUPS:
        group = parser.add_argument_group(title)
        for option in OPTIONS.values():
            if option.group == title:
                text = option.default_text or f"{option.default}"
                add_option(group, replace(option, default=None, default_text=text))
    files = parser.add_argument_group("files")
    files.add_argument(
        "--seed",
        type=whole_number(0, _LARGEST_SEED),
        default=0,
        metavar="N",
        help="seed of the noise (default: 0)",
    )
    files.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        help="where to write (default: IMAGE-sensor, beside the image)",
    )
    add_quiet(parser)


def run(options: argparse.Namespace) -> None:
    """Expose the sensor and write the photo.

    Raises
    ------
    InputError
        if the image cannot be read, an option is not permitted, or the folder cannot be written to
    """
    from photonmap.capture.expose import expose
    from photonmap.capture.files import save_photo
    from photonmap.results.result import load_result
    from photonmap.runtime.file_checks import check_output_folder

    sensor = _sensor(options)
    image = Path(options.image)
    folder = options.output or image.with_name(f"{image.stem}-sensor")
    check_output_folder(folder, "the photo")
    result = load_result(image)
    with naming(str(image)):
        photo = expose(result, sensor, options.seed)
    written = save_photo(photo, folder)
    if not options.quiet:
        _report(photo)
        for path in written:
            print(path)


def _sensor(options: argparse.Namespace) -> Sensor:
    """Return the sensor of the file, if there is one, with what the options change."""
    from photonmap.capture.sensor import OPTIONS, Sensor, load_sensor

    given = {name: getattr(options, name) for name in OPTIONS if getattr(options, name) is not None}
    if not options.sensor:
        return Sensor(**given)
    if Path(options.sensor).suffix.lower() != ".toml":
        raise InputError(
            f"--sensor {options.sensor!r} is not a FILE.toml; name cameras by --camera"
        )
    return replace(load_sensor(options.sensor), **given)


def _report(photo: Photo) -> None:
    record = photo.record
    print(
        f"{record['time_s']:.4g} s at f/{record['sensor']['aperture']:g}, "
        f"ISO {record['sensor']['iso']:g}; {record['gain_dn_per_electron']:.4g} numbers per "
        f"electron, black {record['black']:.6g}, white {record['white']}; "
        f"{record['saturated']:.2%} saturated"
    )
