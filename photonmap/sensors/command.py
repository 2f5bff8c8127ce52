"""The command `python -m photonmap sensors`: what a number of bands costs."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING

from photonmap.arguments import limits
from photonmap.errors import InputError

if TYPE_CHECKING:
    from photonmap.bands import Bands
    from photonmap.sensors.color_error import ColorRow
    from photonmap.sensors.interreflection import ErrorRow
    from photonmap.spectra.curves import Spectrum, SpectrumSet

HELP = "how far N bands are off after interreflection, over a set of reflectances"

_MOST_BOUNCES = 16
_STEPS = (0.1, 20.0)  # nm


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    curves = parser.add_argument_group("spectra")
    sets = curves.add_mutually_exclusive_group()
    sets.add_argument(
        "--munsell",
        metavar="PATH",
        help="measured Munsell chips (default: $PHOTONMAP_MUNSELL, or the recovered ones shipped)",
    )
    sets.add_argument("--reflectances", metavar="FILE.csv", help="any other set of reflectances")
    curves.add_argument("--illuminant", default="D65", metavar="TEXT", help="default D65")
    bands = parser.add_argument_group("bands")
    bands.add_argument(
        "--bands",
        default="3,6,9",
        metavar="LIST",
        help="separated by commas: N, box:N, FILE.csv, or a camera's name (default 3,6,9)",
    )
    bands.add_argument("--range", type=limits, metavar="LOW:HIGH", help="nm, default 400:700")
    study = parser.add_argument_group("study")
    study.add_argument("--bounces", type=_bounces, default=4, metavar="N", help="default 4")
    study.add_argument(
        "--dark",
        type=_percent,
        default=4.0,
        metavar="PERCENT",
        help="leave out pairs that keep less of the light, from 2 bounces on (default 4)",
    )
    study.add_argument(
        "--step",
        type=_step,
        default=5.0,
        metavar="NM",
        help="between samples of the curves (default 5; 0.5 is as good as exact)",
    )
    study.add_argument(
        "--best", action="store_true", help="find the best Gaussians for 1 to 31 bands too"
    )
    files = parser.add_argument_group("files")
    files.add_argument("--csv", metavar="FILE.csv", help="bands,bounces,mean_percent,max_percent")
    files.add_argument("--plot", metavar="FILE", help=".png, .svg or .pdf; needs matplotlib")


def run(options: argparse.Namespace) -> None:
    """Measure, print the tables and write the files.

    Raises
    ------
    InputError
        if an option is none, a curve does not cover the bands, or a file cannot be written
    """
    from photonmap.sensors.plot import check_plot, write_plot
    from photonmap.sensors.report import check_file, write_csv

    if options.csv:
        check_file(options.csv)
    if options.plot:
        check_plot(options.plot)
    bands = _bands(options.bands, options.range)
    reflectances, source = _reflectances(options)
    illuminant = _illuminant(options.illuminant)
    errors, both, colors = _measure(options, bands, reflectances, illuminant)
    _print(options, f"{len(reflectances)} reflectances, {source}", errors, both, colors)
    if options.csv:
        write_csv(options.csv, errors)
    if options.plot:
        write_plot(options.plot, errors, colors)
    if options.best:
        _print_best(options, reflectances, illuminant)


def _measure(
    options: argparse.Namespace,
    bands: dict[str, Bands],
    reflectances: SpectrumSet,
    illuminant: Spectrum,
) -> tuple[list[ErrorRow], list[ErrorRow], list[ColorRow]]:
    """Return errors for each bounce, those of direct and indirect light, and those of colours."""
    from photonmap.sensors.color_error import color_errors
    from photonmap.sensors.interreflection import interreflection_errors

    errors, both, colors = [], [], []
    for label, sensors in bands.items():

        def errors_after(
            bounces: int, direct_too: bool = False, sensors: Bands = sensors, label: str = label
        ) -> ErrorRow:
            dark = options.dark / 100.0
            return interreflection_errors(
                reflectances, illuminant, sensors, bounces, dark, direct_too, label, options.step
            )

        errors += [errors_after(bounces) for bounces in range(1, options.bounces + 1)]
        both.append(errors_after(2, direct_too=True))
        colors += color_errors(reflectances, illuminant, sensors, label)
    return errors, both, colors


def _print(
    options: argparse.Namespace,
    what: str,
    errors: list[ErrorRow],
    both: list[ErrorRow],
    colors: list[ColorRow],
) -> None:
    """Print the three tables."""
    from photonmap.sensors.report import color_table, error_table

    print(f"{what}; illuminant {options.illuminant}; curves sampled every {options.step:g} nm")
    print(f"\nError within the bands; from 2 bounces on, of pairs that keep {options.dark:g}%")
    print(error_table(errors))
    print("\nEq. 4 as written (direct + indirect), all pairs")
    print(error_table(both))
    print("\nΔE2000 after projection to sRGB")
    print(color_table(colors))


def _print_best(
    options: argparse.Namespace, reflectances: SpectrumSet, illuminant: Spectrum
) -> None:
    """Print what each number of Gaussian bands reaches, as it is found."""
    from photonmap.sensors.best import best_bands
    from photonmap.sensors.report import best_line
    from photonmap.spectra.curves import VISIBLE

    print("\nGaussian bands with σ of a quarter of the bin, then with the best σ, then spread too;")
    print("mean errors within the bands, and mean ΔE2000 after 2 bounces and regression")
    print(best_line())
    within = options.range or VISIBLE
    for row in best_bands(reflectances, illuminant, within, options.dark / 100.0, options.step):
        print(best_line(row), flush=True)


def _bands(text: str, within: tuple[float, float] | None) -> dict[str, Bands]:
    """Return the bands of a list, by what they are called there."""
    from photonmap.bands import Bands

    found = {}
    for label in map(str.strip, text.split(",")):
        if label.lower() == "rgb":
            raise InputError("rgb has no sensitivities to study; give a number of bands, as in 3")
        found[label] = Bands.parse(label, within)
    return found


def _reflectances(options: argparse.Namespace) -> tuple[SpectrumSet, str]:
    """Return the set to study, and where it is from."""
    if options.reflectances:
        from photonmap.readers.tables import read_table
        from photonmap.spectra.curves import LARGEST_REFLECTANCE

        table = read_table(options.reflectances, 0.0, LARGEST_REFLECTANCE, "reflectance")
        return table, options.reflectances
    from photonmap.spectra.munsell import VARIABLE, munsell_set

    source = options.munsell or os.environ.get(VARIABLE)
    return munsell_set(source), source or "Munsell chips recovered from the renotation"


def _illuminant(text: str) -> Spectrum:
    """Return the light that a text names."""
    from photonmap.spectra.observer import emission_spectrum
    from photonmap.spectra.text import emission

    light = emission_spectrum(emission(text))
    if not light.values.any():
        raise InputError(f"the illuminant {text!r} is dark; give one that shines")
    return light


def _number(text: str, low: float, high: float, unit: str = "") -> float:
    """Read a number within limits."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not low <= value <= high:
        raise argparse.ArgumentTypeError(f"{text!r} is not from {low:g} to {high:g}{unit}")
    return value


def _bounces(text: str) -> int:
    if not text.strip().isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number of bounces")
    return int(_number(text, 1, _MOST_BOUNCES))


def _percent(text: str) -> float:
    return _number(text, 0.0, 100.0, "%")


def _step(text: str) -> float:
    return _number(text, *_STEPS, " nm")
