"""Several sets of bands compared: errors after interreflection, and of colours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from photonmap.sensors.color_error import ColorRow, color_errors
from photonmap.sensors.interreflection import DARK, ErrorRow, interreflection_errors
from photonmap.sensors.sampling import STEP
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum, SpectrumSet


@dataclass(frozen=True)
class Comparison:
    """Errors of sets of bands, in the order of the sets.

    Parameters
    ----------
    by_bounce : after each number of bounces
    direct_and_indirect : of both together, after 2 bounces; none of a study of one bounce
    colors : ΔE2000, after up to 2 bounces
    """

    by_bounce: list[ErrorRow] = field(default_factory=list)
    direct_and_indirect: list[ErrorRow] = field(default_factory=list)
    colors: list[ColorRow] = field(default_factory=list)


def compare_bands(
    bands: Mapping[str, Bands],
    reflectances: SpectrumSet,
    illuminant: Spectrum,
    bounces: int,
    dark: float = DARK,
    step: float = STEP,
) -> Comparison:
    """Measure the errors of sets of bands.

    Parameters
    ----------
    bands : by the name under which results list them
    reflectances, illuminant : see `interreflection_errors`
    bounces : the largest number of them
    dark : fraction of the light below which a pair of reflectances is left out
    step : distance between samples of the curves, nm

    Raises
    ------
    InputError : a curve does not cover the bands
    """
    found = Comparison()
    for label, sensors in bands.items():

        def errors_after(
            count: int, direct_too: bool = False, sensors: Bands = sensors, label: str = label
        ) -> ErrorRow:
            return interreflection_errors(
                reflectances,
                illuminant,
                sensors,
                count,
                dark=dark,
                direct_too=direct_too,
                label=label,
                step=step,
            )

        found.by_bounce.extend(errors_after(count) for count in range(1, bounces + 1))
        if bounces >= 2:
            found.direct_and_indirect.append(errors_after(2, direct_too=True))
        found.colors.extend(color_errors(reflectances, illuminant, sensors, label, bounces))
    return found
