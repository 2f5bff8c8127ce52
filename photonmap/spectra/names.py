"""Curves that colour-science has by name: lights, chart patches, observers and cameras.

Importing colour-science takes two seconds, so it is imported when a name is looked up for the first
time; the curves of lights and patches are then kept on disk.
"""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from photonmap.errors import InputError
from photonmap.runtime.kept_tables import kept_on_disk
from photonmap.runtime.wording import suggest
from photonmap.spectra.curves import Floats, Spectrum
from photonmap.spectra.observer import normalise_luminance

_HOTTEST, _COLDEST = 1e6, 300.0  # K; in between, there is some light at all of 400 to 700 nm
DAYLIGHT = (4000.0, 25000.0)
"""Correlated colour temperatures for which CIE 15 defines phases of daylight, K."""


@contextmanager
def colour_science() -> Iterator[Any]:
    """Yield colour-science with its warnings of missing parts and aligned grids silenced."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour

        yield colour


@cache
def _folder() -> Path:
    """Return where curves are kept: it is named by the code that makes them."""
    code = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:16]
    made_by = f"{code}-{version('colour-science')}-{np.__version__}"
    user_folder = os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_dir("photonmap")
    return Path(user_folder) / f"curves-{made_by}"


_kept = kept_on_disk(lambda: _folder())


def light(name: str) -> Spectrum:
    """Return a CIE illuminant or light source, scaled to Y = 1.

    Names are spelled as in colour-science, in any case; F1 to F12 stand for FL1 to FL12. The error
    about an unknown one suggests the nearest, as for the other kinds.
    """
    return normalise_luminance(Spectrum(*_light(name)))


def patch(name: str) -> Spectrum:
    """Return the reflectance of a ColorChecker patch (BabelColor's average of 30 charts).

    "white 9.5 (.05 D)" is "white 9.5" too.
    """
    return Spectrum(*_patch(name))


def sensors(name: str) -> tuple[tuple[str, Spectrum], ...]:
    """Return the sensitivities of an observer or a camera, each with its channel's name."""
    curves = _find("camera or observer", name, _sensor_sets())
    return tuple(
        (str(label), Spectrum(curves.wavelengths, values))
        for label, values in zip(curves.labels, curves.values.T, strict=True)
    )


def sensor_names() -> list[str]:
    """Return the names of the cameras and observers, as colour-science spells them."""
    return list(dict.fromkeys(_spelled(_sensor_sets().values())))


def planck(kelvin: float) -> Spectrum:
    """Return the light of a black body of 300 to 1e6 K, scaled to Y = 1."""
    if not _COLDEST <= kelvin <= _HOTTEST:
        raise InputError(
            f"a black body of {kelvin:g} K is out of range; write {_COLDEST:g} to {_HOTTEST:g} K"
        )
    return normalise_luminance(Spectrum(*_black_body(kelvin)))


def daylight(kelvin: float) -> Spectrum:
    """Return the CIE phase of daylight of 4000 to 25000 K (correlated), scaled to Y = 1.

    The D series of CIE 15:2018, 4.1.2: S0 + M1 S1 + M2 S2, with M1 and M2 from the chromaticity.
    """
    if not DAYLIGHT[0] <= kelvin <= DAYLIGHT[1]:
        low, high = DAYLIGHT
        raise InputError(f"daylight of {kelvin:g} K is out of range; write {low:g} to {high:g} K")
    return normalise_luminance(Spectrum(*_phase_of_daylight(kelvin)))


@_kept
def _light(name: str) -> Floats:
    return _rows(_find("light", name, _lights()))


@_kept
def _patch(name: str) -> Floats:
    return _rows(_find("reflectance", name, _patches()))


@_kept
def _black_body(kelvin: float) -> Floats:
    with colour_science() as colour:
        return _rows(colour.sd_blackbody(kelvin, colour.SpectralShape(300.0, 1000.0, 1.0)))


@_kept
def _phase_of_daylight(kelvin: float) -> Floats:
    with colour_science() as colour:
        chromaticity = colour.temperature.CCT_to_xy_CIE_D(kelvin)
        shape = colour.SpectralShape(300.0, 780.0, 1.0)
        return _rows(colour.sd_CIE_illuminant_D_series(chromaticity, shape=shape))


@_kept
def daylight_series() -> Floats:
    """Return wavelengths, nm, and the CIE's S0, S1 and S2, whose sums all daylight is, (4, L)."""
    with colour_science() as colour:
        curves = colour.colorimetry.SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES
        rows = [curves[name].values for name in ("S0", "S1", "S2")]
        return np.array([curves["S0"].wavelengths, *rows], np.float64)


@cache
def _lights() -> dict[str, Any]:
    with colour_science() as colour:
        names = {**colour.SDS_LIGHT_SOURCES, **colour.SDS_ILLUMINANTS}
    aliases = {name.replace("FL", "F", 1): name for name in names if name.startswith("FL")}
    return _lower({**names, **{alias: names[name] for alias, name in aliases.items()}})


@cache
def _patches() -> dict[str, Any]:
    with colour_science() as colour:
        names = colour.SDS_COLOURCHECKERS["BabelColor Average"]
    return _lower({**names, **{name.partition(" (")[0]: names[name] for name in names}})


@cache
def _sensor_sets() -> dict[str, Any]:
    with colour_science() as colour:
        return _lower({**colour.MSDS_CAMERA_SENSITIVITIES, **colour.MSDS_CMFS})


def _lower(names: Mapping[str, Any]) -> dict[str, Any]:
    return {name.lower(): names[name] for name in names}


def _find(kind: str, name: str, known: Mapping[str, Any]) -> Any:
    if name.lower() in known:
        return known[name.lower()]
    raise InputError(f"there is no {kind} {name!r}; {suggest(name, _spelled(known.values()))}")


def _spelled(curves: Iterable[Any]) -> list[str]:
    return [curve.name for curve in curves]


def _rows(curve: Any) -> Floats:
    """Return wavelengths and values, (2, L)."""
    return np.array([curve.wavelengths, curve.values], np.float64)
