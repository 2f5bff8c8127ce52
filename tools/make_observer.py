"""Write photonmap/data/observer.csv: the CIE 1931 observer, D65 and a basis of reflectances.

    python tools/make_observer.py

needs colour-science and SciPy. The tables come from colour-science. The basis is the smoothest
one that fulfils I. Mallett and C. Yuksel, "Spectral Primary Decomposition for Rendering with
sRGB Reflectance", EGSR 2019: three curves that are nowhere negative, add up to 1 and have the
colours (1, 0, 0), (0, 1, 0) and (0, 0, 1) under D65.
"""

from pathlib import Path
from typing import Any

import colour
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space
from scipy.optimize import nnls

from photonmap.spectra.curves import integrate_products
from photonmap.spectra.observer import observer_from_table

FILE = Path(__file__).parents[1] / "photonmap" / "data" / "observer.csv"
DIGITS = 8
HEADER = f"""\
# CIE 1931 2 degree standard observer and CIE standard illuminant D65 (relative power):
# from colour-science {colour.__version__} (https://www.colour-science.org), BSD-3-Clause.
# red, green, blue: reflectances computed by tools/make_observer.py, MIT.
# wavelength_nm,x_bar,y_bar,z_bar,d65,red,green,blue
"""

Floats = NDArray[Any]


def tabulated() -> Floats:
    """Return colour-science's λ (nm), x̄, ȳ, z̄ and D65 from 380 to 780 nm: (81, 5)."""
    wavelengths = np.arange(380.0, 781.0, 5.0)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    d65 = colour.SDS_ILLUMINANTS["D65"]
    columns = [table.values[np.isin(table.wavelengths, wavelengths)] for table in (observer, d65)]
    return np.column_stack([wavelengths, *columns])


def basis(table: Floats) -> Floats:
    """Return the smoothest red, green and blue reflectances, rounded: (81, 3) in [0, 1].

    Least is the sum of squared second differences, over curves that continue as their mirror
    images beyond both ends: where the eye hardly sees, they level off.
    """
    n = len(table)
    unit = np.eye(n)
    eye = observer_from_table(np.column_stack([table, unit]))
    to_rgb = integrate_products(eye.wavelengths, eye.matching, eye.wavelengths, eye.basis * eye.d65)
    bend = np.diff(np.pad(unit, ((1, 1), (0, 0)), mode="edge"), 2, axis=0)
    adds_up = np.tile(unit, 3)
    colours = np.kron(np.eye(3), to_rgb)[:6]  # blue's follow: white is (1, 1, 1)
    curves = smallest(
        np.kron(np.eye(3), bend),
        np.vstack([adds_up, colours]),
        np.concatenate([np.ones(n), np.eye(3)[:2].ravel()]),
    ).reshape(3, n)
    # Round the running sums: then the curves still add up to 1, and none falls below 0.
    sums = np.round(np.cumsum(curves, axis=0), DIGITS)
    return np.round(np.diff(sums, axis=0, prepend=0.0), DIGITS).T


def smallest(rows: Floats, constraints: Floats, targets: Floats) -> Floats:
    """Return the x ≥ 0 with constraints · x = targets for which |rows · x| is least.

    The equalities are eliminated by x = x₀ + Z y, and what remains is a least-distance problem,
    solved in finitely many steps through its dual: C. Lawson and R. Hanson, "Solving Least
    Squares Problems", 1974, chapter 23.
    """
    start = np.linalg.lstsq(constraints, targets)[0]
    free = null_space(constraints)
    q, r = np.linalg.qr(rows @ free)
    shift = q.T @ (rows @ start)
    normals = np.linalg.solve(r.T, free.T).T
    dual = np.vstack([normals.T, normals @ shift - start])
    aim = np.append(np.zeros(len(r)), 1.0)
    residual = dual @ nnls(dual, aim, maxiter=100 * len(start))[0] - aim
    distance = -residual[:-1] / residual[-1]
    return start + free @ np.linalg.solve(r, distance - shift)


def main() -> None:
    """Write the file."""
    table = tabulated()
    with FILE.open("w", encoding="utf-8", newline="\n") as out:
        out.write(HEADER)
        for row, curves in zip(table, basis(table), strict=True):
            numbers = [f"{v:.12g}" for v in row] + [f"{v:.{DIGITS}f}" for v in curves]
            out.write(",".join(numbers) + "\n")


if __name__ == "__main__":
    main()
