"""The command `python -m photonmap sensors`: what a number of bands costs."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING

from photonmap.commands import shared
from photonmap.errors import InputError

if TYPE_CHECKING:
    from photonmap.sensors.comparison import Comparison
    from photonmap.spectra.bands import Bands
    from photonmap.spectra.curves import Spectrum, SpectrumSet

HELP = "Measure the error of N spectral bands after interreflection, over a set of reflectances."

_MOST_BOUNCES = 16
_STEPS = (0.1, 20.0)  # permitted distances between samples of the curves, nm


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    curves = parser.add_argument_group("spectra")
    sets = curves.add_mutually_exclusive_group()
    usual = "$PHOTONMAP_MUNSELL, or the recovered ones shipped"
    shared.add_value(sets, "munsell", "PATH", "measured Munsell chips", default_text=usual)
    shared.add_value(sets, "reflectances", "FILE.csv", "another set of reflectances")
    shared.add_value(curves, "illuminant", "TEXT", "colour of the light", default="D65")
    shared.add_range(shared.add_group(parser, "bands", _BANDS))
    shared.add_group(parser, "study", _STUDY)
    shared.add_group(parser, "files", _FILES)


_BANDS: list[shared.Row] = [
    ("bands", "LIST",
     "bands to compare, separated by commas: N, best:N, box:N, FILE.csv, or the name of a camera "
     "or observer", {"default": "3,6,9"}),
]  # fmt: skip
_STUDY: list[shared.Row] = [
    ("bounces", "N", "largest number of bounces; colours and Eq. 4 are studied after 2 at most",
     {"read": shared.whole_number(1, _MOST_BOUNCES), "default": 4}),
    ("dark", "PERCENT",
     "from 2 bounces on, leave out pairs of reflectances that reflect less of the light than this",
     {"read": shared.number(0.0, 100.0, "%"), "default": 4.0, "default_text": "4"}),
    ("step", "NM", "distance between samples of the curves, nm; 0.5 is as good as exact",
     {"read": shared.number(*_STEPS, " nm"), "default": 5.0, "default_text": "5"}),
    ("fluorescence", "DYE",
     "also study chips with a dye: a fluorophore by name, or the FILE of a Donaldson matrix; the "
     "outer values of reflectances then hold beyond them", {}),
    ("best", None,
     "also find the best Gaussians for 1 to 31 bands, after 2 bounces whatever --bounces",
     {"default": False}),
]  # fmt: skip
_FILES: list[shared.Row] = [
    ("csv", "FILE.csv",
     "write the errors here, with the columns bands, bounces, mean_percent, max_percent", {}),
    ("plot", "FILE", "draw the errors: .png, .svg or .pdf; needs matplotlib", {}),
]  # fmt: skip


def run(options: argparse.Namespace) -> None:
    """Measure, print the tables and write the files."""
    from photonmap.report.plots import check_plot
    from photonmap.runtime.writing import check_file
    from photonmap.sensors.comparison import compare_bands
    from photonmap.sensors.report import write_errors, write_plot
    from photonmap.spectra.sensitivities import ENDS

    if options.csv:
        check_file(options.csv)
    if options.plot:
        check_plot(options.plot)
    bands = _bands(options.bands, options.range)
    reflectances, source = _reflectances(options)
    if options.fluorescence:  # is excited beyond what chips were measured in
        reflectances = reflectances.held(*ENDS)
    illuminant = _illuminant(options.illuminant)
    found = compare_bands(
        bands, reflectances, illuminant, options.bounces, options.dark / 100.0, options.step
    )
    _print(options, f"{len(reflectances)} reflectances, {source}", found)
    if options.fluorescence:
        _print_fluorescent(options, bands, reflectances, illuminant)
    if options.csv:
        write_errors(options.csv, found.by_bounce)
    if options.plot:
        write_plot(options.plot, found.by_bounce, found.colors)
    if options.best:
        _print_best(options, reflectances, illuminant)


def _print(options: argparse.Namespace, reflectances: str, found: Comparison) -> None:
    """Print the tables: two of one bounce alone, otherwise three."""
    from photonmap.sensors.report import color_table, error_table

    light = f"illuminant {options.illuminant}"
    print(f"{reflectances}; {light}; curves sampled every {options.step:g} nm")
    several = f"; from 2 bounces on, of pairs that reflect at least {options.dark:g}% of the light"
    print(f"\nError within the bands{several if options.bounces > 1 else ''}")
    print(error_table(found.by_bounce))
    if found.direct_and_indirect:
        print("\nEq. 4 as written (direct + indirect), all pairs")
        print(error_table(found.direct_and_indirect))
    print("\nΔE2000 after projection to sRGB")
    print(color_table(found.colors))


def _print_fluorescent(
    options: argparse.Namespace,
    bands: dict[str, Bands],
    reflectances: SpectrumSet,
    illuminant: Spectrum,
) -> None:
    """Print the errors of chips with a dye."""
    from pathlib import Path

    from photonmap.sensors.fluorescent import fluorescent_errors
    from photonmap.sensors.report import error_table
    from photonmap.spectra.fluorescence import as_fluorophores
    from photonmap.spectra.fluorophores import read_fluorophores

    (dye,) = as_fluorophores(read_fluorophores(options.fluorescence, Path()))
    rows = []
    for label, sensors in bands.items():
        rows += fluorescent_errors(
            reflectances, illuminant, sensors, dye, options.bounces, label, options.dark / 100.0
        )
    print(f"\nError within the bands of chips with {options.fluorescence}, after up to 2 bounces")
    print(error_table(rows))


def _print_best(
    options: argparse.Namespace, reflectances: SpectrumSet, illuminant: Spectrum
) -> None:
    """Print what each number of Gaussian bands reaches, as it is found."""
    from photonmap.sensors.comparison import best_bands
    from photonmap.sensors.report import best_line
    from photonmap.spectra.curves import VISIBLE

    print("\nGaussian bands with σ of a quarter of the bin, then with the best σ, then spread too;")
    print("mean errors within the bands, and mean ΔE2000 after 2 bounces and regression")
    print(best_line())
    within = options.range or VISIBLE
    for row in best_bands(reflectances, illuminant, within, options.dark / 100.0, options.step):
        print(best_line(row), flush=True)


def _bands(text: str, within: tuple[float, float] | None) -> dict[str, Bands]:
    """Return the sets of bands in a list, by their names in it."""
    from photonmap.spectra.bands import Bands

    found = {}
    for label in map(str.strip, text.split(",")):
        if label.lower() == "rgb":
            raise InputError("rgb has no sensitivities to study; give a number of bands, as in 3")
        found[label] = Bands.parse(label, within)
    return found


def _reflectances(options: argparse.Namespace) -> tuple[SpectrumSet, str]:
    """Return the set to study, and where it comes from."""
    if options.reflectances:
        from photonmap.spectra.curves import LARGEST_REFLECTANCE
        from photonmap.spectra.tables import read_table

        table = read_table(options.reflectances, 0.0, LARGEST_REFLECTANCE, "reflectance")
        return table, options.reflectances
    from photonmap.spectra.munsell import VARIABLE, munsell_set

    source = options.munsell or os.environ.get(VARIABLE)
    return munsell_set(source), source or "Munsell chips recovered from the renotation"


def _illuminant(text: str) -> Spectrum:
    """Return the spectrum of a light by its name."""
    from photonmap.spectra.color_text import emission
    from photonmap.spectra.observer import emission_spectrum

    light = emission_spectrum(emission(text))
    if not light.values.any():
        raise InputError(f"the illuminant {text!r} emits nothing; choose another")
    return light
