"""N spectral bands: their sensitivities, and colours turned into band values."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import Any, Literal

import numpy as np

from photonmap.errors import InputError, naming_file
from photonmap.runtime.wording import listed, shown
from photonmap.spectra.curves import (
    VISIBLE,
    Color,
    Floats,
    Spectrum,
    check_emission,
    check_reflectance,
    integrate_products,
    read_only,
    without_tails,
)
from photonmap.spectra.observer import observer, radiance_to_rgb, reflectance_to_rgb
from photonmap.spectra.sensitivities import (
    ENDS,
    MOST,
    STEPS,
    Limits,
    boxes,
    gaussians,
    read_sensors,
    sensor,
    stepped,
    table_of,
)

_TABLES = (300.0, 780.0)  # Where tables of light end, nm
_WANTED = (
    f"bands must be 'rgb', a number from 1 to {MOST}, 'best:N', 'box:N', '400:700:10', a FILE.csv "
    "of sensitivities, or the name of an observer or camera; got {}"
)


@dataclass(frozen=True, repr=False)
class Bands:
    """The spectral axis of every buffer: N sensors, or red, green and blue.

    The band value of a spectrum f is ∫ f ρ dλ / ∫ ρ dλ over the band's sensitivity ρ. With
    `Bands.rgb()` there are no wavelengths: the three values are linear sRGB. Made by `rgb`,
    `gaussian`, `box`, `steps`, `sensors` or `parse`. Equal and hashed by value; all arrays are
    read-only.

    Parameters
    ----------
    kind : "rgb", "gaussian", "box" or "sensors"
    names : what reports call the N bands: R, G, B, their centroids as in "550.0nm", or channels
    sensitivities : N curves of integral 1, nm⁻¹, zero beyond their samples; none for RGB
    limits : the range (low, high), nm; None for RGB
    sigma : standard deviation of each Gaussian before it is truncated to the range, nm
    """

    kind: Literal["rgb", "gaussian", "box", "sensors"]
    names: tuple[str, ...]
    sensitivities: tuple[Spectrum, ...] = ()
    limits: Limits | None = None
    sigma: float | None = None

    def __repr__(self) -> str:
        return f"<Bands {self.kind}: {listed(self.names)}>"

    @classmethod
    def rgb(cls) -> Bands:
        """Return red, green and blue, taken as they stand."""
        return cls("rgb", ("R", "G", "B"))

    @classmethod
    def gaussian(
        cls, n: int, low: float = VISIBLE[0], high: float = VISIBLE[1], sigma: float | None = None
    ) -> Bands:
        """Return `n` Gaussian bands, centred on the equal bins that divide `low` to `high`.

        Parameters
        ----------
        n : 1 to 256
        low, high : nm, within 280 to 800; the curves are truncated there
        sigma : standard deviation, nm; a quarter of the bin by default

        Raises
        ------
        InputError : the number, the range or σ is out of bounds
        """
        curves, sigma = gaussians(n, low, high, sigma)
        return cls._of("gaussian", curves, None, (float(low), float(high)), sigma)

    @classmethod
    def box(cls, n: int, low: float = VISIBLE[0], high: float = VISIBLE[1]) -> Bands:
        """Return `n` equal bins that divide `low` to `high` (nm), each of constant sensitivity.

        Raises
        ------
        InputError : as for `gaussian`
        """
        curves = boxes(n, low, high)
        return cls._of("box", curves, None, (float(low), float(high)))

    @classmethod
    def sensors(
        cls,
        curves: Sequence[Spectrum],
        names: Sequence[str] | None = None,
        limits: Limits | None = None,
    ) -> Bands:
        """Return one band a sensitivity curve, in any unit.

        Dips below 0 by up to 2% of the peak are measurement noise, and become 0.

        Parameters
        ----------
        curves : 1 to 256
        names : of the channels; their centroids by default
        limits : the range (nm) that the curves are truncated to; by default the one they cover

        Raises
        ------
        InputError : a curve is negative, sees nothing within the range, or does not cover it (400
            to 700 nm without one)
        """
        if not 1 <= len(curves) <= MOST:
            raise InputError(f"there must be 1 to {MOST} sensors; got {len(curves)}")
        labels = (
            list(names) if names is not None else [f"sensor {k + 1}" for k in range(len(curves))]
        )
        if len(labels) != len(curves):
            raise InputError(f"{len(curves)} sensors need as many names; got {len(labels)}")
        kept = [sensor(curve, label, limits) for curve, label in zip(curves, labels, strict=True)]
        ends = [curve.wavelengths[[0, -1]] for curve in kept]
        low, high = float(min(end[0] for end in ends)), float(max(end[1] for end in ends))
        return cls._of("sensors", kept, names, limits or (low, high))

    @classmethod
    def steps(cls, first: float, last: float, step: float) -> Bands:
        """Return Gaussian bands of means first, first + step, … last (nm), to the last digit.

        Each has a σ of a quarter of the step, and is truncated half a step from its mean.

        Raises
        ------
        InputError : a band leaves 280 to 800 nm, or steps do not lead from the first to the last
        """
        curves, low, high = stepped(first, last, step)
        names = [f"{curve.wavelengths[len(curve.wavelengths) // 2]:g}nm" for curve in curves]
        return cls._of("sensors", curves, names, (low, high))

    @classmethod
    def _of(
        cls,
        kind: Literal["gaussian", "box", "sensors"],
        curves: Sequence[Spectrum],
        names: Sequence[str] | None,
        limits: Limits,
        sigma: float | None = None,
    ) -> Bands:
        """Normalise the curves to an integral of 1."""
        unit = tuple(
            curve * float(1.0 / np.trapezoid(curve.values, curve.wavelengths)) for curve in curves
        )
        bands = cls(kind, tuple(names or ()), unit, limits, sigma)
        if names is None:
            assert bands.centroids is not None
            bands = cls(kind, tuple(f"{at:.1f}nm" for at in bands.centroids), unit, limits, sigma)
        return bands

    @classmethod
    def parse(cls, text: str | int | PathLike[str] | Bands, limits: Limits | None = None) -> Bands:
        """Return the bands that a user asked for.

        Parameters
        ----------
        text : "rgb", a number of Gaussian bands, "best:N", "box:N", "400:700:10" for bands from
            400 to 700 nm in steps of 10, a FILE.csv with a wavelength (nm) and one sensitivity a
            sensor in each row, or the name by which colour-science knows an observer or camera
        limits : the range (low, high), nm; by default 400 to 700, or what the file covers

        Raises
        ------
        InputError : for anything else
        """
        if isinstance(text, Bands):
            return text
        if isinstance(text, bool) or not isinstance(text, str | PathLike | float | int | np.number):
            raise InputError(_WANTED.format(shown(text)))
        body = str(text).strip()
        if body.lower() == "rgb" or STEPS.fullmatch(body):
            if limits is not None:
                raise InputError(f"{body} takes no range; leave it out or choose a number of bands")
            return cls.steps(*map(float, body.split(":"))) if ":" in body else cls.rgb()
        if re.fullmatch(r"\d{3,}:\d{3,}", body):
            raise InputError(f"bands {body} lack a step; write {body}:10 for bands 10 nm apart")
        kind, _, number = body.rpartition(":")
        makers: dict[str, Callable[..., Bands]] = {"": cls.gaussian, "box": cls.box}
        if kind in makers and number.strip().lstrip("+-").replace(".", "", 1).isdecimal():
            try:
                count = int(number)
            except ValueError:
                raise InputError(_WANTED.format(shown(text))) from None
            return makers[kind](count, *(limits or VISIBLE))
        return cls._named(body, limits)

    @classmethod
    def _named(cls, body: str, limits: Limits | None) -> Bands:
        """Return the sensors of a file or of a name."""
        path = table_of(body)
        try:
            channels, curves = read_sensors(body)
        except InputError as error:
            if path is not None:
                raise
            raise InputError(f"{_WANTED.format(shown(body))}: {error}") from None
        with naming_file(path):
            return cls.sensors(curves, channels, limits)

    @classmethod
    def from_description(cls, description: dict[str, Any]) -> Bands:
        """Rebuild bands from what `describe` returned, bit for bit.

        Raises
        ------
        InputError : it is not such a description
        """
        try:
            kind, names = description["kind"], description["names"]
            if kind == "rgb":
                return cls.rgb()
            low, high = description["range_nm"]
            if kind == "gaussian":
                return cls.gaussian(len(names), low, high, description["sigma_nm"])
            if kind == "box":
                return cls.box(len(names), low, high)
            curves = tuple(Spectrum(*curve) for curve in description["sensitivities"])
            return cls("sensors", tuple(names), curves, (low, high))
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"the record does not describe bands ({error}); render again"
            ) from None

    def describe(self) -> dict[str, Any]:
        """Return a JSON-able record: kind, names, centroids_nm, sigma_nm, range_nm.

        What does not apply is None. Bands of the kind "sensors" add `sensitivities`: a row of
        wavelengths (nm) and one of values (nm⁻¹) each.
        """
        centroids = self.centroids
        description = {
            "kind": self.kind,
            "names": list(self.names),
            "centroids_nm": None if centroids is None else centroids.tolist(),
            "sigma_nm": self.sigma,
            "range_nm": None if self.limits is None else list(self.limits),
        }
        if self.kind == "sensors":
            description["sensitivities"] = [
                [curve.wavelengths.tolist(), curve.values.tolist()] for curve in self.sensitivities
            ]
        return description

    @property
    def count(self) -> int:
        """N."""
        return len(self.names) if not self.sensitivities else len(self.sensitivities)

    @property
    def is_rgb(self) -> bool:
        """Whether the three values are linear sRGB, without wavelengths."""
        return self.kind == "rgb"

    @cached_property
    def centroids(self) -> Floats | None:
        """(N,) float64, nm, the mean wavelength of each sensitivity; None for RGB."""
        if self.limits is None:
            return None
        ends = np.array(self.limits)
        return self.average(Spectrum(ends, ends))  # of f(λ) = λ

    def average(self, spectrum: Spectrum) -> Floats:
        """Return ∫ f ρ dλ for each sensitivity ρ, exactly: (N,) float64, read-only, in f's unit.

        Raises
        ------
        InputError : for RGB, which has no sensitivities
        """
        if spectrum not in self._averages:
            values = self.average_all(spectrum.wavelengths, spectrum.values[None])[0]
            self._averages[spectrum] = read_only(values)
        return self._averages[spectrum]

    @cached_property
    def _averages(self) -> dict[Spectrum, Floats]:
        """What was averaged before: scenes under several lights share their reflectances."""
        return {}

    def average_all(self, wavelengths: Floats, curves: Floats) -> Floats:
        """Return the band values (C, N) of `curves` (C, K) over `wavelengths` (K,), nm.

        As `average`; where a band extends beyond them, curves keep their outer values.
        """
        if self.is_rgb:
            raise InputError("RGB has no sensitivities; choose a number of bands")
        return np.concatenate(
            [
                integrate_products(band.wavelengths, band.values[None], wavelengths, curves)
                for band in self.sensitivities
            ]
        ).T

    def reflectance(self, color: Color) -> Floats:
        """Return the band values of a reflectance: (N,) float64.

        A triple is upsampled, or used unchanged in RGB, where a `Spectrum` becomes its linear sRGB
        under D65, clipped to [0, 1].

        Raises
        ------
        InputError : it is not a colour, or a curve outside [0, 1], or one that does not cover 400
            to 700 nm and what the bands see but for a thousandth at either end
        """
        if not isinstance(color, Spectrum):
            return self._mix(color, self.reflectance_basis)
        self._check_covered(color)
        check_reflectance(color.wavelengths, color.values)
        if self.is_rgb:
            return np.clip(reflectance_to_rgb(color), 0.0, 1.0)
        return self.average(color)

    def emission(self, color: Color) -> Floats:
        """Return the band values of a radiance or another amount of light: (N,) float64.

        A triple is upsampled times D65, or used unchanged in RGB, where a `Spectrum` becomes its
        linear sRGB, or 0 where that is negative.

        Raises
        ------
        InputError : it is not a colour, or a curve below 0, or one that does not cover 400 to 700
            nm and what the bands see but for a thousandth at either end
        """
        if not isinstance(color, Spectrum):
            return self._mix(color, self.emission_basis)
        self._check_covered(color)
        check_emission(color.wavelengths, color.values)
        if self.is_rgb:
            return np.maximum(radiance_to_rgb(color), 0.0)
        return self.average(color)

    @cached_property
    def reflectance_basis(self) -> Floats:
        """(3, N) float64: linear sRGB @ this = band reflectances, for any (..., 3) array."""
        if self.is_rgb:
            return read_only(np.eye(3))
        eye = observer()
        return read_only(self.average_all(eye.wavelengths, eye.basis))

    @cached_property
    def emission_basis(self) -> Floats:
        """(3, N) float64: linear sRGB @ this = band radiances, for any (..., 3) array.

        It is the product of the bands of the reflectance and of D65, as a render multiplies
        them: a light and a surface under D65 of the same RGB have the same value in every band. The
        average of `upsample_emission`, the product of the curves, differs where bands are wide.
        """
        if self.is_rgb:
            return read_only(np.eye(3))
        eye = observer()
        return read_only(self.reflectance_basis * self.average_all(eye.wavelengths, eye.d65[None]))

    @cached_property
    def _needed(self) -> Limits:
        """The range, nm, that curves must cover: 400 to 700, and `seen_range` of every band."""
        ends = np.array([VISIBLE, *map(seen_range, self.sensitivities)])
        return float(ends[:, 0].min()), float(ends[:, 1].max())

    def _check_covered(self, color: Spectrum) -> None:
        if not color.wavelengths[0] <= self._needed[0] < self._needed[1] <= color.wavelengths[-1]:
            low, high = self.limits or VISIBLE
            color.check_covers(*_within_tables(min(low, VISIBLE[0]), max(high, VISIBLE[1])))

    def _mix(self, color: Any, basis: Floats) -> Floats:
        """Return the band values (N,) of a number, the same in all bands, or of a triple."""
        try:
            values = np.asarray(color, dtype=np.float64)
        except (TypeError, ValueError):
            values = np.empty(0)
        if values.shape in ((), (3,)) and np.isfinite(values).all():
            return values @ basis if values.shape else np.full(self.count, values)
        raise InputError(
            "a colour is a number, three numbers of linear RGB, or a Spectrum, as "
            f"photonmap.reflectance and photonmap.emission make it from a text; got {shown(color)}"
        )


def seen_range(sensitivity: Spectrum) -> Limits:
    """Return the range, nm, that curves must cover for a band: all but its tails.

    Of a band that reaches a little beyond 300 to 780 nm, that: tables of light end there.
    """
    return _within_tables(*without_tails(sensitivity))


def _within_tables(low: float, high: float) -> Limits:
    return (
        _TABLES[0] if ENDS[0] <= low < _TABLES[0] else low,
        _TABLES[1] if _TABLES[1] < high <= ENDS[1] else high,
    )
