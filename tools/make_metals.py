"""Write photonmap/data/metals.csv: measured indices of refraction of metals.

    python tools/make_metals.py FOLDER

FOLDER is a copy of the database of refractiveindex.info, which is in the public domain (CC0):
https://github.com/polyanskiy/refractiveindex.info-database
"""

import sys
from pathlib import Path

import numpy as np

from photonmap.spectra.metals import SHIPPED

MEASUREMENTS = {
    "Ag": "Johnson",
    "Al": "Rakic",
    "Au": "Johnson",
    "Cr": "Johnson",
    "Cu": "Johnson",
    "Fe": "Johnson",
    "Ni": "Johnson",
    "Ti": "Johnson",
}
"""P. Johnson and R. Christy, Phys. Rev. B 6, 4370 (1972) and 9, 5056 (1974); A. Rakić, Appl. Opt.
34, 4755 (1995)."""
STEP, DIGITS = 10.0, 4


def indices(file: Path) -> np.ndarray:
    """Return wavelengths (nm), n and k of a file's table: (rows, 3)."""
    _, _, table = file.read_text("utf-8").partition("data: |\n")
    rows = [line.split() for line in table.splitlines() if line.startswith(" ")]
    return np.array(rows, float) * [1000.0, 1.0, 1.0]


def main(folder: Path) -> None:
    """Write the file."""
    grid = np.arange(380.0, 781.0, STEP)
    columns = {"wavelength": grid}
    for name, author in MEASUREMENTS.items():
        wavelength, n, k = indices(folder / f"database/data-nk/main/{name}/{author}.yml").T
        columns[f"{name} n"] = np.round(np.interp(grid, wavelength, n), DIGITS)
        columns[f"{name} k"] = np.round(np.interp(grid, wavelength, k), DIGITS)
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(f"{value:g}" for value in row) for row in rows)]
    SHIPPED.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
