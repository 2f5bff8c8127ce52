"""Curves over wavelength, one or many: their checks, exact resampling, products and integrals."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError
from photonmap.runtime.wording import brief, suggest

Floats = NDArray[np.float64]

VISIBLE = (400.0, 700.0)  # Range that every curve must cover, nm

TAIL = 1e-3
"""Share of a sensitivity at either end where a curve need not be known: its outer value holds."""

EXTRAPOLATE = "extrapolate:"  # Prefix of a curve whose outer values extend beyond its samples

FILES = (".csv", ".txt", ".tsv", ".spd", ".rfl")  # Suffixes of files with curves

LARGEST_REFLECTANCE = 1.001  # Largest reflectance that may be a rounded 1; more is a mistake


@dataclass(frozen=True, eq=False, repr=False)
class Spectrum:
    """A curve over wavelength: linear between its samples, and unknown outside of them.

    Equal by value; the arrays are read-only copies.

    Parameters
    ----------
    wavelengths : (M,) float64, nm, strictly increasing, M ≥ 2
    values : (M,) float64, in the unit of what is described: 1, or W·m⁻²·sr⁻¹
    extrapolate : whether the outer values extend to all wavelengths beyond the samples

    Raises
    ------
    InputError : the arrays are not of this kind, or the wavelengths seem to be in another unit
    """

    wavelengths: Floats
    values: Floats
    extrapolate: bool = False

    if TYPE_CHECKING:

        def __init__(
            self, wavelengths: ArrayLike, values: ArrayLike, extrapolate: bool = False
        ) -> None:
            """Take array-likes."""

    def __repr__(self) -> str:
        (first, last), values = self.wavelengths[[0, -1]], self.values
        span = f"{values.min():.3g} to {values.max():.3g} at {first:g} to {last:g} nm"
        return f"<Spectrum {span}, {len(values)} samples>"

    def __post_init__(self) -> None:
        """Copy the array-likes, check them and make them read-only."""
        for attribute in ("wavelengths", "values"):
            try:
                array = np.array(getattr(self, attribute), dtype=np.float64) + 0.0  # no -0.0
            except (TypeError, ValueError):
                raise InputError(f"a spectrum's {attribute} must be a row of numbers") from None
            object.__setattr__(self, attribute, array)
            array.setflags(write=False)
        _check_samples(self.wavelengths, self.values)
        check_wavelengths(self.wavelengths)

    @classmethod
    def sample(
        cls, function: Callable[[Floats], Floats], low: float = 380.0, high: float = 780.0
    ) -> Spectrum:
        """Sample a function of the wavelength (nm), called once with an array, in steps of 1 nm."""
        wavelengths = np.linspace(low, high, max(2, round(high - low) + 1))
        return cls(wavelengths, np.broadcast_to(function(wavelengths), wavelengths.shape))

    def __call__(self, wavelengths: Floats) -> Floats:
        """Return the values at `wavelengths` (nm), in their shape; the outer ones beyond."""
        return np.interp(wavelengths, self.wavelengths, self.values)

    def __mul__(self, factor: float) -> Spectrum:
        """Return the curve with all values multiplied."""
        return replace(self, values=self.values * float(factor))

    __rmul__ = __mul__

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Spectrum):
            return NotImplemented
        return (
            np.array_equal(self.wavelengths, other.wavelengths)
            and np.array_equal(self.values, other.values)
            and self.extrapolate == other.extrapolate
        )

    def __hash__(self) -> int:
        return hash((self.wavelengths.tobytes(), self.values.tobytes(), self.extrapolate))

    def check_covers(self, low: float, high: float) -> None:
        """Raise `InputError`, saying what is missing, unless `low` to `high` (nm) is known."""
        if not self.extrapolate:
            check_covers(self.wavelengths, low, high)


Color = float | tuple[float, float, float] | Spectrum
"""A number is a constant spectrum, a triple is linear sRGB, a `Spectrum` is itself."""


@dataclass(frozen=True, eq=False, repr=False)
class SpectrumSet:
    """Many curves over the same wavelengths, by name.

    Parameters
    ----------
    wavelengths : (K,) float64, nm, strictly increasing, K ≥ 2
    values : (C, K) float64
    names : C of them; of two with one name the first is found

    Raises
    ------
    InputError : the arrays do not fit together, or a curve is not a spectrum
    """

    wavelengths: Floats
    values: Floats
    names: tuple[str, ...]

    __repr__ = brief

    if TYPE_CHECKING:

        def __init__(
            self, wavelengths: ArrayLike, values: ArrayLike, names: tuple[str, ...]
        ) -> None:
            """Take array-likes."""

    def __post_init__(self) -> None:
        """Check what all curves share, and that every value is finite."""
        shape = np.shape(self.values)
        if len(shape) != 2 or shape != (len(self.names), len(self.wavelengths)) or not shape[0]:
            raise InputError(
                f"{len(self.names)} curves over {len(self.wavelengths)} wavelengths need values of "
                f"shape ({len(self.names)}, {len(self.wavelengths)}), and at least one curve; "
                f"got shape {shape}"
            )
        object.__setattr__(self, "wavelengths", np.asarray(self.wavelengths, np.float64))
        object.__setattr__(self, "values", np.asarray(self.values, np.float64))
        bad = np.flatnonzero(~np.isfinite(self.values).all(axis=1))
        _ = self[int(bad[0]) if bad.size else 0]

    def __len__(self) -> int:
        return len(self.names)

    def __iter__(self) -> Iterator[Spectrum]:
        return (self[index] for index in range(len(self)))

    def __getitem__(self, key: int | str) -> Spectrum:
        """Return the curve of this index or name.

        Raises
        ------
        InputError : there is none of this name; the error suggests the nearest
        """
        if isinstance(key, str):
            if key not in self.names:
                raise InputError(f"there is no curve {key!r}; {suggest(key, self.names)}")
            key = self.names.index(key)
        return Spectrum(self.wavelengths, self.values[key])

    def held(self, low: float, high: float) -> SpectrumSet:
        """Return the curves with their outer values also at `low` and `high` (nm), beyond them."""
        wavelengths = merge_grids(self.wavelengths, np.array([low, high]))
        return SpectrumSet(
            wavelengths, resample(wavelengths, self.wavelengths, self.values), self.names
        )

    def at(self, wavelengths: Floats) -> Floats:
        """Return all curves at `wavelengths` (M,), nm, increasing: (C, M) float64.

        Raises
        ------
        InputError : the curves do not cover them
        """
        check_covers(self.wavelengths, wavelengths[0], wavelengths[-1])
        return resample(wavelengths, self.wavelengths, self.values)


def check_reflectance(wavelengths: Floats, values: Floats) -> None:
    """Raise `InputError` unless a curve lies in [0, 1]; rounding may lift it a little above."""
    bad = np.flatnonzero(~((values >= 0.0) & (values <= LARGEST_REFLECTANCE)))
    if bad.size:
        percent = ": divide percent by 100" if 2.0 < values.max() <= 110.0 else ""
        raise InputError(
            f"reflectance is {values[bad[0]]:.6g} at {wavelengths[bad[0]]:g} nm; "
            f"it must lie between 0 and 1{percent}"
        )


def check_emission(wavelengths: Floats, values: Floats) -> None:
    """Raise `InputError` if a curve is negative somewhere."""
    if (lowest := int(np.argmin(values))) >= 0 and values[lowest] < 0.0:
        raise InputError(
            f"emission is {values[lowest]:.6g} at {wavelengths[lowest]:g} nm; "
            "light cannot be negative"
        )


HELD = f"'{EXTRAPOLATE}' before the name, Spectrum(…, extrapolate=True) in code"
"""How a user asks that the outer values of a curve hold beyond its samples."""


def check_covers(wavelengths: Floats, low: float, high: float, held: str = HELD) -> None:
    """Raise `InputError`, saying what is missing, unless samples cover `low` to `high` (nm)."""
    first, last = wavelengths[0], wavelengths[-1]
    if first <= low and last >= high:
        return
    below = [f"{low:g}-{min(first, high):g}"] if first > low else []
    above = [f"{max(last, low):g}-{high:g}"] if last < high else []
    missing = " and ".join(below + above)
    narrow = "choose bands within what it covers, give a curve that covers more, or "
    raise InputError(
        f"the curve covers {first:g}-{last:g} nm, but {low:g}-{high:g} nm is needed: {missing} nm "
        f"is missing; {'' if (low, high) == VISIBLE else narrow}extend the outer values: {held}"
    )


def without_tails(curve: Spectrum) -> tuple[float, float]:
    """Return the range, nm, beyond either end of which a sensitivity has at most `TAIL` of it."""
    area = np.diff(curve.wavelengths) * 0.5 * (curve.values[1:] + curve.values[:-1])
    passed = np.concatenate([[0.0], np.cumsum(area)]) / area.sum()
    first = np.searchsorted(passed, TAIL, side="right") - 1
    last = np.searchsorted(passed, 1.0 - TAIL)
    return float(curve.wavelengths[first]), float(curve.wavelengths[last])


def check_wavelengths(wavelengths: Floats) -> None:
    """Raise `InputError` unless wavelengths increase and can be nanometres of light."""
    falls = np.flatnonzero(np.diff(wavelengths) <= 0)
    if falls.size:
        before, after = wavelengths[falls[0] : falls[0] + 2]
        raise InputError(
            f"wavelengths must increase, but {after:g} follows {before:g}; "
            "sort the samples and keep one for each wavelength"
        )
    first, last = wavelengths[0], wavelengths[-1]
    units = (
        (last < 1e-3, "metres", "multiply by 1e9"),
        (last < 100.0, "micrometres", "multiply by 1000"),
        (first > 3000.0, "ångströms", "divide by 10"),
    )
    for found, unit, remedy in units:
        if found:
            raise InputError(
                f"wavelengths must be in nm; {first:g} to {last:g} look like {unit}: {remedy}"
            )


def _check_samples(wavelengths: Floats, values: Floats) -> None:
    """Raise `InputError` unless the samples define a curve."""
    if wavelengths.ndim != 1 or wavelengths.shape != values.shape:
        raise InputError(
            "a spectrum needs one row of wavelengths and one value for each; "
            f"got shapes {wavelengths.shape} and {values.shape}"
        )
    if len(wavelengths) < 2:
        raise InputError("a spectrum needs at least 2 samples; for a constant one give a number")
    if not (np.isfinite(wavelengths).all() and np.isfinite(values).all()):
        raise InputError("a spectrum's wavelengths and values must be finite; correct them")


def resample(at: Floats, wavelengths: Floats, curves: Floats) -> Floats:
    """Return piecewise-linear `curves` (C, K) over `wavelengths` (K,) at `at` (M,): (C, M)."""
    return np.array([np.interp(at, wavelengths, curve) for curve in curves])


def read_only(array: Floats) -> Floats:
    """Return the array, now locked against changes."""
    array.setflags(write=False)
    return array


def merge_grids(a: Floats, b: Floats) -> Floats:
    """Return the values of both, increasing; the first call of `np.union1d` takes 8 ms."""
    both = np.sort(np.concatenate([a, b]))
    return both[np.append(True, np.diff(both) > 0.0)]


def integrate_products(
    wavelengths: Floats, weights: Floats, nodes: Floats, curves: Floats
) -> Floats:
    """Integrate each weight, (W, M), times each curve, (C, K), over the weights' range: (W, C).

    Both are linear between their samples; the curves are constant outside of theirs. On the merged
    grid their product is quadratic, and Simpson's rule is exact. `nodes`, (K,), are the curves'
    wavelengths.
    """
    grid, before, after = product_weights(wavelengths, weights, nodes)
    g = resample(grid, nodes, curves)
    g0, g1 = g[:, :-1], g[:, 1:]
    return before @ (2.0 * g0 + g1).T + after @ (g0 + 2.0 * g1).T


def product_weights(
    wavelengths: Floats, weights: Floats, nodes: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return the merged grid, (M,), of `integrate_products`, and weights of its steps.

    They are (W, M - 1), of 2 g + g' and of g + 2 g', with g and g' a curve where a step begins and
    ends.
    """
    inside = nodes[(nodes > wavelengths[0]) & (nodes < wavelengths[-1])]
    grid = merge_grids(wavelengths, inside)
    f = resample(grid, wavelengths, weights)
    return grid, f[:, :-1] * np.diff(grid) / 6.0, f[:, 1:] * np.diff(grid) / 6.0
