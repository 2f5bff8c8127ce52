"""Expose a sensor to a render."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.capture.demosaic import choose_method
from photonmap.capture.mosaic import Pattern, read_mosaic, sample
from photonmap.capture.noise import digitise
from photonmap.capture.optics import spread, vignette
from photonmap.capture.photo import Photo
from photonmap.capture.response import Response, find_colors, find_response
from photonmap.capture.sensor import Sensor
from photonmap.errors import InputError, warn
from photonmap.results.result import Result, check_result
from photonmap.runtime.wording import shown
from photonmap.spectra.observer import adapt_to_d65, observer

Floats = NDArray[np.float64]

_LARGEST_SEED = 2**64 - 1
_DIGITS = 8
_MOST_NEGATIVE = 0.01
"""Share of the camera's values below 0, for want of bands, up to which nothing is said."""


def expose(result: Result, sensor: Sensor | None = None, seed: int = 0) -> Photo:
    """Return what a sensor records of a render's radiance.

    Light passes the lens (vignetting, point spread) and the filters of the mosaic, becomes
    electrons with their noise, and is turned into numbers. The same arguments give the same photo.

    Parameters
    ----------
    result : with `radiance`, (H, W, N), in any bands
    sensor : `Sensor()` by default
    seed : of the noise

    Raises
    ------
    InputError : the image has no radiance or no light, is smaller than the mosaic, or the sensor
        cannot be
    """
    check_result(result)
    sensor = Sensor() if sensor is None else sensor
    if not isinstance(sensor, Sensor):
        raise InputError(f"{shown(sensor)} is not a sensor; give a photonmap.Sensor(camera=…)")
    if not (isinstance(seed, int) and 0 <= seed <= _LARGEST_SEED):
        raise InputError(f"seed {seed} must be a whole number from 0 to {_LARGEST_SEED}")
    if "radiance" not in result.buffers:
        raise InputError("the image has no radiance; render it with all buffers")
    response = find_response(sensor)
    pattern = _check_pattern(sensor, response, result.size)
    seen = _see(result, response)
    negative = float((seen < 0.0).mean())
    if negative > _MOST_NEGATIVE:
        warn(f"{negative:.1%} of the camera's values are below 0, and become 0; render more bands")
    rates = _rates(seen, result, sensor, response)
    time = sensor.time
    if time is None:
        time = _choose_time(sample(rates, pattern), result.buffers.get("emission"), sensor)
    if sensor.dark_current * time >= min(sensor.saturation, sensor.full_well):
        raise InputError(
            f"in {time:.4g} s the dark current alone fills the pixels; choose a shorter time, or "
            "less dark current"
        )
    electrons = rates * time
    raw = digitise(sample(electrons, pattern), sensor, time, seed)
    record = {
        "sensor": sensor.describe(),
        "seed": seed,
        "channels": list(response.bands.names),
        "sensitivities": response.bands.describe(),
        "mosaic": None if pattern is None else pattern.tolist(),
        "negative": round(negative, _DIGITS),
        **_describe_exposure(sensor, response, time, raw),
        **_describe_colors(result, response),
    }
    return Photo(raw, (electrons / sensor.saturation).astype(np.float32), record)


def _check_pattern(sensor: Sensor, response: Response, size: tuple[int, int]) -> Pattern | None:
    pattern = read_mosaic(sensor.mosaic, response.bands.names)
    if pattern is None:
        return None
    choose_method(sensor.demosaic, pattern)
    (rows, columns), (width, height) = pattern.shape, size
    if height < rows or width < columns:
        raise InputError(
            f"the image of {width}x{height} pixels is smaller than the mosaic of {columns}x{rows}"
        )
    return pattern


def _see(result: Result, response: Response) -> Floats:
    """Return the radiance in the camera's channels: (H, W, C) float64."""
    seen = result.to_sensor(response.bands).astype(np.float64)
    if not np.isfinite(seen).all():
        raise InputError("the radiance of the image is not finite everywhere; render it again")
    return seen


def _rates(seen: Floats, result: Result, sensor: Sensor, response: Response) -> Floats:
    """Return the electrons per second that light gives behind the lens: (H, W, C) float64."""
    rates = np.maximum(seen, 0.0) * response.electrons
    falloff = vignette(sensor.vignetting, result.size, result.record.get("camera", {}))
    return spread(rates * falloff[..., None], sensor.psf)


def _choose_time(rates: Floats, emission: NDArray[Any] | None, sensor: Sensor) -> float:
    """Return the time in which the percentile of the lit pixels reaches its level.

    Pixels that emit do not count, unless no others are lit: as in previews.
    """
    lit = rates[rates > 0.0]
    if emission is not None:
        reflecting = rates[~emission.any(axis=-1)]
        reflecting = reflecting[reflecting > 0.0]
        lit = reflecting if reflecting.size else lit
    if not lit.size:
        raise InputError("the image is black, and no exposure can be chosen; give a time")
    bright = float(np.percentile(lit, sensor.percentile))
    return sensor.level * min(sensor.saturation, sensor.full_well) / bright


def _describe_exposure(
    sensor: Sensor, response: Response, time: float, raw: NDArray[np.uint16]
) -> dict[str, Any]:
    """Return the constants that turn numbers into electrons and radiance."""
    dark = sensor.dark_current * time
    reached = min(1.0, sensor.full_well / sensor.saturation)
    white = sensor.black + int(reached * (sensor.white - sensor.black))
    return {
        "time_s": time,
        "black": sensor.black + sensor.gain * dark,
        "white": sensor.white,
        "saturates_at": reached,
        "dark_electrons": dark,
        "gain_dn_per_electron": sensor.gain,
        "electrons_at_white": sensor.saturation,
        "electrons_per_radiance": (response.electrons * time).tolist(),
        "saturated": round(float((raw >= white).mean()), _DIGITS),
        "black_clipped": round(float((raw == 0).mean()), _DIGITS),
    }


def _describe_colors(result: Result, response: Response) -> dict[str, Any]:
    """Return the white in the camera's colours, and matrices from them.

    The white is all lights of the scene together, where the render's record has it; else D65.
    """
    to_srgb, to_xyz = find_colors(response, "rgb"), find_colors(response, "xyz")
    white = result.record.get("white")
    if white is None:
        eye = observer()
        values = response.bands.average_all(eye.wavelengths, eye.d65[None])[0]
        adapt = np.eye(3)
    else:
        values = result.projection(response.bands).matrix @ np.array(white)
        adapt = adapt_to_d65(to_srgb @ (values * response.electrons))
    neutral = np.maximum(values * response.electrons, 1e-6 * response.electrons.max())
    return {
        "neutral": (neutral / neutral.max()).tolist(),
        "to_srgb": (adapt @ to_srgb).tolist(),
        "to_xyz": to_xyz.tolist(),
    }
