"""N spectral bands: their sensitivities, colours turned into band values, and back to sRGB."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.spectra import (
    Color,
    Spectrum,
    integrate_products,
    observer,
    radiance_to_rgb,
    reflectance_to_rgb,
)

Floats = NDArray[np.float64]

MOST = 256  # bands
_WANTED = f"bands must be 'rgb' or a number from 1 to {MOST}; got {{}}"
_CUT = 8.0  # σ from the centre, where a Gaussian has fallen to 1e-14 of its peak and is set to 0


@dataclass(frozen=True)
class Bands:
    """What the last axis of every buffer counts: N Gaussian bands, or red, green and blue.

    The band value of a spectrum f is ∫ f ρ dλ / ∫ ρ dλ over the band's sensitivity ρ.

    Gaussian bands divide the range into N equal bins; each is centred on its bin, has a quarter
    of the bin as σ, and is cut to the range. With `Bands.rgb()` there are no wavelengths: the
    three values are linear sRGB. Equal and hashed by value; all arrays are read-only.

    Parameters
    ----------
    count : N, 1 to 256
    limits : the range (low, high), nm, within 380 to 780; None for RGB

    Raises
    ------
    InputError
        if the number or the range is not of this kind
    """

    count: int
    limits: tuple[float, float] | None

    def __post_init__(self) -> None:
        """Check number and range."""
        if not 1 <= self.count <= MOST:
            raise InputError(_WANTED.format(self.count))
        if self.limits is None:
            if self.count != 3:
                raise InputError(f"RGB has 3 bands, not {self.count}")
            return
        low, high = self.limits
        if not 380.0 <= low < high <= 780.0:
            raise InputError(
                "the range of the bands must lie within 380 to 780 nm, the lower end first; "
                f"got {low:g} to {high:g}"
            )
        if high - low < self.count:
            raise InputError(
                f"{self.count} bands in {low:g} to {high:g} nm are narrower than 1 nm; "
                "use fewer bands or a wider range"
            )

    @classmethod
    def rgb(cls) -> Bands:
        """Return red, green and blue, taken as they stand."""
        return cls(3, None)

    @classmethod
    def gaussian(cls, n: int, low: float = 400.0, high: float = 700.0) -> Bands:
        """Return `n` Gaussian bands that divide `low` to `high` (nm) equally."""
        return cls(n, (float(low), float(high)))

    @classmethod
    def parse(cls, text: str | int | Bands) -> Bands:
        """Return what a user asked for: "rgb", or a number of Gaussian bands.

        Raises
        ------
        InputError
            for anything else
        """
        if isinstance(text, Bands):
            return text
        if str(text).strip().lower() == "rgb":
            return cls.rgb()
        try:
            number = int(str(text))
        except ValueError:
            raise InputError(_WANTED.format(repr(text))) from None
        return cls.gaussian(number)

    @classmethod
    def from_description(cls, description: dict[str, Any]) -> Bands:
        """Rebuild bands from what `describe` returned, bit for bit.

        Raises
        ------
        InputError
            if it is no such description
        """
        try:
            if description["kind"] == "rgb":
                return cls.rgb()
            low, high = description["range_nm"]
            return cls.gaussian(len(description["names"]), low, high)
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"the record does not describe bands ({error}); render again"
            ) from None

    def describe(self) -> dict[str, Any]:
        """Return a JSON-able record: kind, names, centroids_nm, sigma_nm, range_nm.

        The last three are None for RGB.
        """
        centroids = self.centroids
        return {
            "kind": "rgb" if self.limits is None else "gaussian",
            "names": list(self.names),
            "centroids_nm": None if centroids is None else centroids.tolist(),
            "sigma_nm": self.sigma,
            "range_nm": None if self.limits is None else list(self.limits),
        }

    @property
    def sigma(self) -> float | None:
        """Standard deviation of each Gaussian before the cut, nm; None for RGB."""
        return None if self.limits is None else (self.limits[1] - self.limits[0]) / self.count / 4.0

    @property
    def wavelengths(self) -> Floats | None:
        """(M,) float64, nm, where the sensitivities are sampled; None for RGB."""
        return None if self.limits is None else self._curves[0]

    @property
    def sensitivities(self) -> Floats | None:
        """(N, M) float64, nm⁻¹, linear between samples, each of integral 1; None for RGB."""
        return None if self.limits is None else self._curves[1]

    @cached_property
    def centroids(self) -> Floats | None:
        """(N,) float64, nm, the mean wavelength of each sensitivity; None for RGB."""
        if self.limits is None:
            return None
        ends = np.array(self.limits)
        return _read_only(self.average(Spectrum(ends, ends)))  # of f(λ) = λ

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Return what reports call the bands: R, G, B or the centroids, as in "550.0nm"."""
        if self.centroids is None:
            return ("R", "G", "B")
        return tuple(f"{centroid:.1f}nm" for centroid in self.centroids)

    def average(self, spectrum: Spectrum) -> Floats:
        """Return ∫ f ρ dλ for each sensitivity ρ, exactly: (N,) float64, in the unit of f.

        Raises
        ------
        InputError
            for RGB, which has no sensitivities
        """
        return self._averages(spectrum.wavelengths, spectrum.values[None])[0]

    def reflectance(self, color: Color) -> Floats:
        """Return the band values of a reflectance: (N,) float64.

        A triple is upsampled, and taken as it stands in RGB; there a `Spectrum` becomes its
        linear sRGB under D65, clipped to [0, 1].

        Raises
        ------
        InputError
            if it is no colour
        """
        if not isinstance(color, Spectrum):
            return self._mix(color, self.reflectance_basis)
        if self.limits is None:
            return np.clip(reflectance_to_rgb(color), 0.0, 1.0)
        return self.average(color)

    def emission(self, color: Color) -> Floats:
        """Return the band values of a radiance or another amount of light: (N,) float64.

        A triple is upsampled times D65, and taken as it stands in RGB; there a `Spectrum`
        becomes its linear sRGB, and 0 where that is negative.

        Raises
        ------
        InputError
            if it is no colour
        """
        if not isinstance(color, Spectrum):
            return self._mix(color, self.emission_basis)
        if self.limits is None:
            return np.maximum(radiance_to_rgb(color), 0.0)
        return self.average(color)

    @cached_property
    def reflectance_basis(self) -> Floats:
        """(3, N) float64: linear sRGB @ this = band reflectances, for any (..., 3) array."""
        if self.limits is None:
            return _read_only(np.eye(3))
        eye = observer()
        return _read_only(self._averages(eye.wavelengths, eye.basis))

    @cached_property
    def emission_basis(self) -> Floats:
        """(3, N) float64: linear sRGB @ this = band radiances, for any (..., 3) array.

        It is the product of the bands of the reflectance and of D65, as a render multiplies
        them: a lamp and a surface under D65 that have one RGB have one value in every band. The
        average of `upsample_emission`, the product of the curves, differs where bands are wide.
        """
        if self.limits is None:
            return _read_only(np.eye(3))
        eye = observer()
        return _read_only(self.reflectance_basis * self._averages(eye.wavelengths, eye.d65[None]))

    @cached_property
    def rgb_matrix(self) -> Floats:
        """(3, N) float64: this @ band radiances = linear sRGB; the identity for RGB.

        Bands are interpolated linearly between their centroids and integrated with the colour
        matching functions. The smallest correction (in the sum of squares) then returns RGB
        emission, and with it RGB surfaces under D65, to its RGB: exactly for N ≥ 3; for fewer
        bands white exactly, the rest as well as they can.
        """
        if self.centroids is None:
            return _read_only(np.eye(3))
        eye = observer()
        direct = integrate_products(
            eye.wavelengths, eye.matching, self.centroids, np.eye(self.count)
        )
        return _read_only(direct + _correction(self.emission_basis.T, direct))

    @cached_property
    def _curves(self) -> tuple[Floats, Floats]:
        """Wavelengths (M,) and normalised sensitivities (N, M), or `InputError` for RGB."""
        if self.limits is None or self.sigma is None:
            raise InputError("RGB has no sensitivities; choose a number of bands")
        low, high = self.limits
        steps = 2 * int(np.ceil(max(8.0, (high - low) / self.count / 2.0)))  # 1 nm, σ/4 or less
        wavelengths = np.linspace(low, high, self.count * steps + 1)
        centres = wavelengths[steps // 2 :: steps, None]
        z = np.minimum(np.abs(wavelengths - centres) / self.sigma, _CUT)
        curves = np.where(z < _CUT, np.exp(-0.5 * z * z), 0.0)
        curves /= np.trapezoid(curves, wavelengths)[:, None]
        return _read_only(wavelengths), _read_only(curves)

    def _averages(self, wavelengths: Floats, curves: Floats) -> Floats:
        """Return the band values (C, N) of `curves` (C, K) over `wavelengths` (K,)."""
        return integrate_products(*self._curves, wavelengths, curves).T

    def _mix(self, color: Any, basis: Floats) -> Floats:
        """Return the band values (N,) of a number, the same in all bands, or of a triple."""
        try:
            values = np.asarray(color, dtype=np.float64)
        except (TypeError, ValueError):
            values = np.empty(0)
        if values.shape in ((), (3,)) and np.isfinite(values).all():
            return values @ basis if values.shape else np.full(self.count, values)
        raise InputError(
            f"a colour is a number, three for linear RGB, or a Spectrum; got {color!r}"
        )


def _read_only(array: Floats) -> Floats:
    """Return the array, now locked."""
    array.setflags(write=False)
    return array


def _correction(emission: Floats, direct: Floats) -> Floats:
    """Return the least C (3, N) for which (direct + C) @ emission is the identity.

    White is met first, by a row vector along it; the rest at right angles to it, but for directions
    that the bands hardly see, as where all of them lie within the red.

    Parameters
    ----------
    emission : (N, 3) band radiances of red, green and blue
    direct : (3, N)
    """
    missing = np.eye(3) - direct @ emission
    white = emission.sum(axis=1)
    to_white = np.outer(missing.sum(axis=1), white / (white @ white))
    missing -= to_white @ emission
    others = np.linalg.qr(white[:, None], mode="complete")[0][:, 1:].T
    return to_white + missing @ np.linalg.pinv(others @ emission, rcond=0.02) @ others
