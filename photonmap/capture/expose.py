"""Expose a sensor to a render: from radiance to electrons, and by their noise to raw numbers.

Noise is the linear model of the EMVA Standard 1288, release 4.0 (2021), section 2: with gain K in
numbers per electron, the variance of a pixel is K² (mean electrons + read noise²) + 1/12.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.capture.mosaic import Pattern, choose_method, read_mosaic, sample
from photonmap.capture.optics import spread, vignette
from photonmap.capture.photo import Photo
from photonmap.capture.sensor import Sensor
from photonmap.errors import InputError, warn
from photonmap.results.result import Result, check_result
from photonmap.runtime.wording import shown
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import EXTRAPOLATE, Floats
from photonmap.spectra.observer import adapt_to_d65, observer
from photonmap.spectra.projection import choose_projection
from photonmap.spectra.sensitivities import read_sensors, table_of
from photonmap.spectra.sensitivities import sensor as clean

_LARGEST_SEED = 2**64 - 1
_DIGITS = 8
_MOST_NEGATIVE = 0.01
"""Share of the camera's values below 0, from too few bands, up to which there is no warning."""

_HC = 6.62607015e-34 * 299792458.0  # J·m: the energy of a photon times its wavelength
_NM, _UM = 1e-9, 1e-6
_SHOT, _READ, _GAIN, _OFFSET = range(4)  # Uses of random numbers
_MOST = 1e12  # Expected electrons above which a pixel is full anyway


@dataclass(frozen=True, eq=False)
class Response:
    """A camera's channels."""

    bands: Bands  # its sensitivities, of integral 1
    electrons: Floats  # (C,) per second for radiance 1 in the channel, in the unit of the image


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
        is not valid
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
    seen = result.to_sensor(response.bands).astype(np.float64)
    if not np.isfinite(seen).all():
        raise InputError("the radiance of the image is not finite everywhere; render it again")
    negative = float((seen < 0.0).mean())
    if negative > _MOST_NEGATIVE:
        warn(f"{negative:.1%} of the camera's values are below 0, and become 0; render more bands")
    falloff = vignette(sensor.vignetting, result.size, result.record.get("camera", {}))
    rates = spread(np.maximum(seen, 0.0) * response.electrons * falloff[..., None], sensor.psf)
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
    """Return matrices from camera colours, and the white: of all lights of the scene, or D65."""
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


def find_response(sensor: Sensor) -> Response:
    """Return the channels of a sensor's camera.

    On the axis, irradiance is π L / (4 N²) with the f-number N, and the electrons of a pixel of
    area A are A ∫ E(λ) η(λ) λ / (h c) dλ per second. The quantum efficiency η is the sensitivity
    over λ, scaled so that its peak over all channels is the sensor's.
    """
    bands = Bands.parse(sensor.camera)
    if bands.is_rgb:
        raise InputError("camera rgb has no sensitivities; name a camera, or a FILE.csv of them")
    named = ":" not in sensor.camera.removeprefix(EXTRAPOLATE)
    if table_of(sensor.camera) or (bands.kind == "sensors" and named):
        names, read = read_sensors(sensor.camera)
        curves = [clean(curve, name, None) for name, curve in zip(names, read, strict=True)]
    else:  # filters of the same transmittance
        curves = [curve * float(1.0 / curve.values.max()) for curve in bands.sensitivities]
    areas = np.array([np.trapezoid(curve.values, curve.wavelengths) for curve in curves])
    peak = max((curve.values / curve.wavelengths).max() for curve in curves) / _NM
    light = math.pi / (4.0 * sensor.aperture**2) * (sensor.pixel_pitch * _UM) ** 2 * sensor.scale
    per_watt = sensor.quantum_efficiency / (_HC * peak)
    return Response(bands, light * per_watt * areas)


def find_colors(response: Response, target: str) -> Floats:
    """Return the matrix (3, C) from electrons, up to one factor for all, to "rgb" or "xyz".

    The fit of `photonmap.spectra.projection.fit_projection` to Munsell chips under equal energy,
    D65 and A.
    """
    wanted = "rgb" if target == "rgb" else "xyz"
    matrix = choose_projection(response.bands, wanted, "regression").matrix  # type: ignore[arg-type]
    return matrix / response.electrons * response.electrons.max()


def digitise(electrons: Floats, sensor: Sensor, time: float, seed: int) -> NDArray[np.uint16]:
    """Return what the converter gives for expected electrons, in the same shape.

    electrons : expected from light, after filters
    time : exposure time, s: of the dark current
    seed : of shot and read noise; gains and offsets of pixels are those of the specimen
    """
    shape = electrons.shape
    expected = np.minimum(electrons, _MOST)
    if sensor.prnu:
        gains = 1.0 + sensor.prnu * _generator(sensor.specimen, _GAIN).standard_normal(shape)
        expected = expected * np.maximum(gains, 0.0)
    dark = min(sensor.dark_current * time, _MOST)
    held = _generator(seed, _SHOT).poisson(expected + dark).astype(np.float64)
    held = np.minimum(held, sensor.full_well)
    if sensor.dsnu:
        held += sensor.dsnu * _generator(sensor.specimen, _OFFSET).standard_normal(shape)
    if sensor.read_noise:
        held += sensor.read_noise * _generator(seed, _READ).standard_normal(shape)
    numbers = np.rint(sensor.black + sensor.gain * held)
    return np.clip(numbers, 0, sensor.white).astype(np.uint16)


def _generator(seed: int, use: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, use])))
