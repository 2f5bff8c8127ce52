"""Write photonmap/data/munsell.npz: Munsell chips recovered from the renotation data.

    python tools/make_munsell.py

needs colour-science, whose tables of the renotation and of H. Otsu et al. (2018) it uses
(BSD-3-Clause). The chips are those of the "real" renotation from value 2, and the greys N 2 to N 9,
that paint could have: their recovered reflectance is nowhere from 400 to 700 nm below 3%, which is
what the surface of the paint itself sends back.
"""

import numpy as np

from photonmap.errors import InputError
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.munsell import SHIPPED, canonical, recover
from photonmap.spectra.names import colour_science

DIGITS = 5
LEAST = 0.03


def notations() -> list[str]:
    """Return the greys, then the chips by value, hue and chroma as the renotation lists them."""
    with colour_science() as colour:
        real = colour.MUNSELL_COLOURS["Munsell Colours Real"]
    chips = [f"{hue} {value}/{chroma}" for (hue, value, chroma), _ in real if float(value) >= 2]
    return [canonical(name) for name in [*(f"N {value}" for value in range(2, 10)), *chips]]


def main() -> None:
    """Write the file."""
    chips: dict[str, Spectrum] = {}
    for name in notations():
        try:
            chip = recover(name)
        except InputError:
            continue
        if chip(np.arange(400.0, 701.0, 10.0)).min() >= LEAST:
            chips[name] = chip
    values = np.round([chip.values for chip in chips.values()], DIGITS).astype(np.float32)
    wavelengths = next(iter(chips.values())).wavelengths
    np.savez_compressed(SHIPPED, R=values, wavelength=wavelengths, label=np.array(list(chips)))


if __name__ == "__main__":
    main()
