"""The error of N bands for chips with a dye, after light went to and fro between two of them."""

from __future__ import annotations

import numpy as np

from photonmap.sensors.interreflection import DARK, ErrorRow, check_sensitivities
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum, SpectrumSet, resample
from photonmap.spectra.fluorescence import Fluorescence, Fluorophore, quanta_out, reradiation
from photonmap.spectra.projection import hat_averages

_CHIPS = 60  # Reflectances of which all pairs are tested


def fluorescent_errors(
    reflectances: SpectrumSet,
    illuminant: Spectrum,
    bands: Bands,
    dye: Fluorophore,
    bounces: int,
    label: str | None = None,
    dark: float = DARK,
) -> list[ErrorRow]:
    """Measure the errors after 1 to `bounces` bounces, at most 2, as `interreflection_errors` does.

    The chips, at most 60, have the dye, and reflect less by what it takes up. Exact light is ∫ ρ_k
    (r₂ + Φ) (r₁ + Φ) e over 1 nm steps, with the dye's Donaldson matrix Φ and all wavelengths from
    280 nm, also those that bands do not see; bands have (R₂ + F) (R₁ + F) E of `reradiation`.

    Parameters
    ----------
    reflectances : C curves; outer values hold beyond
    illuminant : e, any unit; likewise
    bands : N sensitivities
    dye : of all chips
    bounces : 1 or more
    label : name of the bands in the result; N if None
    dark : pairs with ‖t‖ < dark · ‖E‖ do not count after 2 bounces
    """
    check_sensitivities(bands)
    seen, weights = hat_averages(bands)
    grid = np.arange(min(280.0, seen[0]), max(800.0, seen[-1]) + 0.5)
    averages = np.zeros((bands.count, len(grid)))
    averages[:, np.searchsorted(grid, seen)] = weights
    some = slice(None, None, -(-len(reflectances) // _CHIPS))
    names = reflectances.names[some]
    taken = dye.excitation(grid) if isinstance(dye, Fluorescence) else quanta_out(dye, grid)
    chips = resample(grid, reflectances.wavelengths, reflectances.values[some]) * (1.0 - taken)
    phi, matrix, banded = dye.matrix(grid, grid), reradiation(dye, bands), chips @ averages.T
    light = illuminant(grid)
    exact, found = light[None], (averages @ light)[None]
    white, rows = float(np.linalg.norm(found)), list[ErrorRow]()
    for bounce in range(1, min(bounces, 2) + 1):
        exact = (exact[:, None] * chips + (exact @ phi.T)[:, None]).reshape(-1, len(grid))
        found = (found[:, None] * banded + (found @ matrix.T)[:, None]).reshape(-1, bands.count)
        truth = exact @ averages.T
        size = np.linalg.norm(truth, axis=1)
        errors = np.linalg.norm(found - truth, axis=1) / size
        bright = size >= (dark * white if bounce > 1 else 0.0)
        worst = int(np.where(bright, errors, -1.0).argmax())
        pair = tuple(names[at] for at in np.unravel_index(worst, (len(names),) * bounce))
        shares = float(errors[bright].mean()), float(errors[worst]), pair, float(bright.mean())
        rows.append(ErrorRow(label or str(bands.count), bands.count, bounce, *shares))
    return rows
