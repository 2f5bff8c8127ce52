"""Fluorescence: what surfaces take up at one wavelength and send out at another.

A Donaldson matrix Φ (nm⁻¹) says how irradiance E becomes radiance that has changed its wavelength:
L(λ) = ∫ Φ(λ, λ′) E(λ′) dλ′ / π, beside ρ(λ) E(λ) / π, which a reflectance ρ sends back: R.
Donaldson, "Spectrophotometry of fluorescent pigments", British Journal of Applied Physics 5(6),
1954; A. Glassner, "Principles of Digital Image Synthesis", 1995, section 17.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from photonmap.errors import InputError, naming_file
from photonmap.runtime.bounds import read_npz
from photonmap.runtime.wording import brief, shown
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import (
    LARGEST_REFLECTANCE,
    Color,
    Floats,
    Spectrum,
    check_reflectance,
    check_wavelengths,
    integrate_products,
    read_only,
)
from photonmap.spectra.observer import emission_spectrum, observer
from photonmap.spectra.projection import hat_averages, smoothest_spectra
from photonmap.spectra.tables import read_arrays, read_table

RANGE: Floats = np.arange(200.0, 1001.0)
"""Wavelengths at which energy is checked, nm."""
_AXES = "excitation (K,), emission (M,) and matrix (M, K)"


@dataclass(frozen=True)
class Fluorescence:
    """A fluorophore by two curves, which are 0 beyond their samples.

    Of each photon that arrives, it takes up the fraction `excitation`, and sends out
    `quantum_efficiency` of these with the spectrum `emission`, whatever their wavelength was
    (Kasha's rule). What would get shorter is lost, so that the yield falls where the curves overlap
    (Vavilov's law), unless `anti_stokes`.

    Parameters
    ----------
    excitation : fraction of the light that the fluorophore takes up, within [0, 1]
    emission : spectrum of the radiant power sent out, in any unit
    quantum_efficiency : photons sent out for each that is taken up, within [0, 1]
    anti_stokes : whether light may also go to shorter wavelengths

    Raises
    ------
    InputError : a curve or number is of another kind or range
    """

    excitation: Spectrum
    emission: Spectrum
    quantum_efficiency: float = 1.0
    anti_stokes: bool = False

    def __post_init__(self) -> None:
        """Check the curves and the number."""
        for name in ("excitation", "emission"):
            if not isinstance(curve := getattr(self, name), Spectrum):
                raise InputError(f"{name} {shown(curve)} is not a curve; give a Spectrum")
            object.__setattr__(self, name, replace(curve, extrapolate=False))
        try:
            check_reflectance(self.excitation.wavelengths, self.excitation.values)
        except InputError as error:
            raise InputError(str(error).replace("reflectance", "excitation", 1)) from None
        lowest = int(np.argmin(self.emission.values))
        if self.emission.values[lowest] < 0.0 or not self.emission.values.any():
            raise InputError(
                f"emission is {self.emission.values[lowest]:.6g} at "
                f"{self.emission.wavelengths[lowest]:g} nm; give 0 or more, and more somewhere"
            )
        efficiency = self.quantum_efficiency
        is_number = isinstance(efficiency, Real) and not isinstance(efficiency, bool)
        if not is_number or not 0.0 <= efficiency <= 1.0:
            raise InputError(
                f"quantum_efficiency is {shown(efficiency)}; give photons sent out for each that "
                "is taken up, from 0 to 1"
            )
        if not self.anti_stokes and self.excitation.values.any():
            self._check_order()
        _check_quanta(self)

    def _check_order(self) -> None:
        """Refuse an emission that lies at shorter wavelengths than all that excites."""
        first, last = _span(self.excitation)
        shortest, longest = _span(self.emission)
        if longest <= first:
            raise InputError(
                f"emission from {shortest:g} to {longest:g} nm is at shorter wavelengths than "
                f"excitation from {first:g} to {last:g} nm, and nothing is sent out; exchange "
                "them, or allow it with anti_stokes"
            )

    def matrix(self, emitted: Floats, exciting: Floats) -> Floats:
        """Return Φ (M, K), nm⁻¹, at wavelengths (M,) that go out and (K,) that come in, nm."""
        curve = self.emission
        photons = integrate_products(
            curve.wavelengths, curve.values[None], curve.wavelengths, curve.wavelengths[None]
        )
        out = self.quantum_efficiency * _within(emitted, curve.wavelengths, curve.values[None])[0]
        taken = self.excitation
        taken_up = _within(exciting, taken.wavelengths, taken.values[None])[0] * exciting
        return _stokes(self, np.outer(out, taken_up) / photons, emitted, exciting)


@dataclass(frozen=True, eq=False, repr=False)
class DonaldsonMatrix:
    """A measured reradiation matrix without its diagonal, which is the material's reflectance.

    It is linear between its samples, and 0 beyond them.

    Parameters
    ----------
    excitation : (K,) float64, nm, increasing
    emission : (M,) float64, nm, increasing
    values : (M, K) float64, nm⁻¹: radiant power sent out per nanometre around an emission, for a
        radiant power of 1 that arrives at an excitation
    anti_stokes : whether light may also go to shorter wavelengths

    Raises
    ------
    InputError : the arrays do not fit together, or a value is negative or not finite; more comes
        out than goes in; or light goes to its own wavelength or a shorter one, unless
        `anti_stokes`. The message names the wavelength
    """

    excitation: Floats
    emission: Floats
    values: Floats
    anti_stokes: bool = False

    __repr__ = brief

    if TYPE_CHECKING:

        def __init__(
            self,
            excitation: ArrayLike,
            emission: ArrayLike,
            values: ArrayLike,
            anti_stokes: bool = False,
        ) -> None:
            """Take array-likes."""

    def __post_init__(self) -> None:
        """Copy the arrays, check them and make them read-only."""
        for name in ("excitation", "emission", "values"):
            try:
                array = np.array(getattr(self, name), np.float64)
            except (TypeError, ValueError):
                raise InputError(f"a Donaldson matrix needs numbers as its {name}") from None
            object.__setattr__(self, name, read_only(array))
        shape = (self.emission.size, self.excitation.size)
        if self.values.shape != shape or self.emission.ndim != 1 or min(shape) < 2:
            raise InputError(
                f"a Donaldson matrix needs {_AXES}, of 2 wavelengths or more each; got "
                f"{self.excitation.shape}, {self.emission.shape} and {self.values.shape}"
            )
        for axis in (self.excitation, self.emission):
            check_wavelengths(axis)
        self._refuse(~((self.values >= 0.0) & (self.values < np.inf)), "give finite values from 0")
        shorter = (self.emission[:, None] <= self.excitation) & (self.values > 0.0)
        if not self.anti_stokes:
            self._refuse(
                shorter,
                "re-emission goes to longer wavelengths: set it to 0 (reflectance is the "
                "material's own), or allow it with anti_stokes",
            )
        _check_quanta(self)

    def _refuse(self, is_wrong: np.ndarray, remedy: str) -> None:
        if is_wrong.any():
            row, column = np.argwhere(is_wrong)[0]
            raise InputError(
                f"a Donaldson matrix has {self.values[row, column]:.6g} from "
                f"{self.excitation[column]:g} to {self.emission[row]:g} nm; {remedy}"
            )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, DonaldsonMatrix) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[object, ...]:
        arrays = (self.excitation, self.emission, self.values)
        return (*(array.tobytes() for array in arrays), self.anti_stokes)

    @classmethod
    def read(cls, path: str | PathLike[str], anti_stokes: bool = False) -> DonaldsonMatrix:
        """Read a file.

        Parameters
        ----------
        path : FILE.npz with `excitation` (K,), `emission` (M,) and `matrix` (M, K); or a table
            whose first row has a word and then the K excitations, and each other row an emission
            and K values
        anti_stokes : whether light may also go to shorter wavelengths

        Raises
        ------
        InputError : it is no such file
        """
        path = Path(path)
        with naming_file(path):
            if path.suffix.lower() == ".npz":
                names = ("excitation", "emission", "matrix")
                arrays = read_arrays(path, lambda _: read_npz(path, lambda _: names), _AXES)
                excitation, emission, values = (arrays[name] for name in names)
                return cls(excitation, emission, values, anti_stokes)
            table = read_table(path, 0.0, kind="re-emission")
            try:
                exciting = [float(name) for name in table.names]
            except ValueError:
                raise InputError(
                    f"the first row names {shown(table.names[0])}, not an excitation in nm; write "
                    "a word, and then the wavelengths"
                ) from None
            return cls(exciting, table.wavelengths, table.values.T, anti_stokes)

    def save(self, path: str | PathLike[str]) -> None:
        """Write FILE.npz, as `read` reads it; `anti_stokes` is not in it."""
        arrays = {"excitation": self.excitation, "emission": self.emission, "matrix": self.values}
        np.savez(Path(path), **arrays)  # type: ignore[arg-type]

    def matrix(self, emitted: Floats, exciting: Floats) -> Floats:
        """Return Φ (M, K), nm⁻¹, at wavelengths (M,) that go out and (K,) that come in, nm."""
        rows = _within(exciting, self.excitation, self.values)
        return _stokes(self, _within(emitted, self.emission, rows.T).T, emitted, exciting)


Fluorophore = Fluorescence | DonaldsonMatrix
Fluorophores = Fluorophore | Sequence[Fluorophore] | None


def as_fluorophores(fluorescence: Fluorophores) -> tuple[Fluorophore, ...]:
    """Return all fluorophores of what a material has: none, one or several."""
    if fluorescence is None:
        return ()
    if isinstance(fluorescence, Fluorescence | DonaldsonMatrix):
        return (fluorescence,)
    return tuple(fluorescence)


def reradiation(fluorescence: Fluorophores, bands: Bands) -> Floats:
    """Return how irradiance by band becomes radiance by band: (N, N) float64.

    Entry [i, j] of F is by which factor irradiance in band j becomes radiance in band i that has
    changed its wavelength: L_i = (ρ_i E_i + Σ_j F[i, j] E_j) / π, for a concentration of 1. It is
    Φ of the dual basis of the bands: of the spectra d_j whose averages over band i are 1 for i = j
    and 0 otherwise. The bands' own curves are such spectra only where they do not overlap; with
    them, energy is added (A. Fichet, L. Belcour and P. Barla, "Non-Orthogonal Reduction for
    Rendering Fluorescent Materials in Non-Spectral Engines", EGSR 2024). Of all dual bases it is
    the smoothest, as for `photonmap.spectra.projection`, under which a constant spectrum remains
    one; small entries may be negative. What the bands do not see neither excites nor is sent out.
    """
    grid, averages, spectra = _bases(bands)
    return averages @ donaldson(fluorescence, grid, grid) @ spectra.T


def donaldson(fluorescence: Fluorophores, emitted: Floats, exciting: Floats) -> Floats:
    """Return Φ (M, K), nm⁻¹, of all fluorophores, at wavelengths out (M,) and in (K,), nm."""
    total = np.zeros((len(emitted), len(exciting)))
    for each in as_fluorophores(fluorescence):
        total += each.matrix(emitted, exciting)
    return total


def reradiation_residual(fluorescence: Fluorophores, bands: Bands, light: Color) -> float:
    """Return the error of `reradiation` for a light, relative to what is sent out in these bands.

    It is ‖F E − T‖ / ‖T‖ for the band values E of the light, and T of what its spectrum excites;
    the light's outer values hold beyond its samples. A surface that sends out nothing has none.
    """
    ((missed, exact),) = reradiation_errors(fluorescence, bands, [light])
    return float(missed / (exact or 1.0))


def reradiation_errors(fluorescence: Fluorophores, bands: Bands, lights: Sequence[Color]) -> Floats:
    """Return ‖F E − T‖ and ‖T‖ of `reradiation_residual` for L lights: (L, 2) float64."""
    averages, matrix = _bases(bands)[1], reradiation(fluorescence, bands)
    exact = averages @ donaldson(fluorescence, _bases(bands)[0], RANGE)
    both = [(exact @ emission_spectrum(each)(RANGE), bands.emission(each)) for each in lights]
    norm = np.linalg.norm
    return np.array([(norm(matrix @ sent - truth), norm(truth)) for truth, sent in both])


def quanta_out(fluorescence: Fluorophores, wavelengths: Floats) -> Floats:
    """Return photons sent out per photon that arrives at wavelengths (K,), nm: (K,) float64.

    Or radiant power per power where that is more, as it may be where light gets shorter.
    """
    total = np.zeros(len(wavelengths))
    for each in as_fluorophores(fluorescence):
        photons, power = _sent_out(each, wavelengths)
        total += np.maximum(photons, power) if each.anti_stokes else photons
    return total


def most_quanta(
    fluorescence: Fluorophores, concentration: float, reflectance: Callable[[Floats], Floats]
) -> tuple[float, float, float, str]:
    """Return at which wavelength, nm, most leaves for what arrives, and how much of it.

    Parameters
    ----------
    fluorescence : what sends out
    concentration : what multiplies it
    reflectance : at wavelengths (K,), nm

    Returns
    -------
    The wavelength, what fluorescence sends out there, what is reflected, and of what these are
    parts: "photon", or "watt" where fluorescence sends out more power than photons
    """
    sent = concentration * quanta_out(fluorescence, RANGE)
    kept = np.where(sent > 1e-6, reflectance(RANGE), 0.0)
    at = int((sent + kept).argmax())
    both = [_sent_out(each, RANGE[[at]]) for each in as_fluorophores(fluorescence)]
    photons, power = np.sum(both, axis=(0, 2))
    unit = "watt" if power > photons else "photon"
    return float(RANGE[at]), float(sent[at]), float(kept[at]), unit


def _sent_out(fluorophore: Fluorophore, wavelengths: Floats) -> tuple[Floats, Floats]:
    """Return photons per photon and power per power that arrive at (K,), nm: (K,) each.

    Sums in steps of 1 nm are too large at steep edges: the integrals of the curves bound them.
    """
    values = fluorophore.matrix(RANGE, wavelengths)
    sums = RANGE @ values / wavelengths, values.sum(axis=0)
    if isinstance(fluorophore, Fluorescence):
        nodes, curve = fluorophore.emission.wavelengths, fluorophore.emission.values[None]
        photons = fluorophore.quantum_efficiency * fluorophore.excitation(wavelengths)
        per_photon = _integrals(nodes, curve, 1.0)[0] / _integrals(nodes, curve, nodes)[0]
        whole = photons, photons * wavelengths * per_photon
    else:
        nodes = fluorophore.emission
        rows = _within(wavelengths, fluorophore.excitation, fluorophore.values).T
        whole = _integrals(nodes, rows, nodes) / wavelengths, _integrals(nodes, rows, 1.0)
    return np.minimum(sums[0], whole[0]), np.minimum(sums[1], whole[1])


def _integrals(nodes: Floats, curves: Floats, weight: Floats | float) -> Floats:
    """Return the integrals (C,) of curves (C, M) times a weight (M,), both linear between nodes."""
    weights = np.broadcast_to(weight, nodes.shape)[None]
    return integrate_products(nodes, curves, nodes, weights)[:, 0]


def _check_quanta(fluorophore: Fluorophore) -> None:
    at, sent, _, unit = most_quanta(fluorophore, 1.0, np.zeros_like)
    if sent > LARGEST_REFLECTANCE:
        raise InputError(
            f"fluorescence sends out {sent:.3g} {unit}s for each that arrives at {at:g} nm; keep "
            "it within 1"
        )


def _span(curve: Spectrum) -> tuple[float, float]:
    """Return from where to where a curve is above a hundredth of its largest value, nm."""
    nodes = curve.wavelengths
    at = np.union1d(nodes, np.linspace(nodes[0], nodes[-1], 2001))
    kept = at[curve(at) > 0.01 * curve.values.max()]
    return float(kept[0]), float(kept[-1])


def _within(at: Floats, nodes: Floats, curves: Floats) -> Floats:
    """Return piecewise-linear curves (C, K), 0 beyond their nodes (K,), at (M,): (C, M)."""
    return np.array([np.interp(at, nodes, curve, 0.0, 0.0) for curve in curves])


def _stokes(of: Fluorophore, values: Floats, emitted: Floats, exciting: Floats) -> Floats:
    return values if of.anti_stokes else np.where(emitted[:, None] > exciting, values, 0.0)


@cache
def _bases(bands: Bands) -> tuple[Floats, Floats, Floats]:
    """Return wavelengths (M,), nm, the weights (N, M) of averages, and the dual basis (N, M).

    Both have 1 nm as their unit, in steps of which the wavelengths are.
    """
    grid, spectra = smoothest_spectra(bands)
    if bands.limits is None:
        return grid, observer().matching, spectra
    low, high = bands.limits
    return grid, hat_averages(bands)[1], spectra * ((grid >= low) & (grid <= high))
