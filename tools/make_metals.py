"""Write photonmap/data/metals.csv: reflectances of metals from their indices of refraction.

    python tools/make_metals.py FOLDER

FOLDER holds NAME.eta.spd and NAME.k.spd, wavelength (nm) and value in each row, as the folder
`data/ior` of Mitsuba does (collected by luxpop.com from published measurements). Those that cover
400 to 700 nm are converted.
"""

import sys
from pathlib import Path

import numpy as np

from photonmap.spectra.curves import VISIBLE
from photonmap.spectra.metals import SHIPPED

STEP, DIGITS = 10.0, 4


def main(folder: Path) -> None:
    """Write the file."""
    grid = np.arange(380.0, 781.0, STEP)
    columns = {"wavelength": grid}
    for file in sorted(folder.glob("*.eta.spd")):
        name = file.name.removesuffix(".eta.spd")
        eta, k = (np.loadtxt(folder / f"{name}.{part}.spd") for part in ("eta", "k"))
        covers = [each[0, 0] <= VISIBLE[0] and each[-1, 0] >= VISIBLE[1] for each in (eta, k)]
        if all(covers):
            index = np.interp(grid, *eta.T) + 1j * np.interp(grid, *k.T)
            columns[name] = np.round(np.abs((index - 1.0) / (index + 1.0)) ** 2, DIGITS)
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(f"{value:g}" for value in row) for row in rows)]
    SHIPPED.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
