"""How many electrons light gives in each channel of a camera, and what colours they stand for."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from photonmap.capture.sensor import Sensor
from photonmap.errors import InputError
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import EXTRAPOLATE
from photonmap.spectra.projection import choose_projection
from photonmap.spectra.sensitivities import read_sensors, table_of
from photonmap.spectra.sensitivities import sensor as clean

Floats = NDArray[np.float64]

_HC = 6.62607015e-34 * 299792458.0
"""J·m: the energy of a photon times its wavelength."""
_NM, _UM = 1e-9, 1e-6


@dataclass(frozen=True, eq=False)
class Response:
    """A camera's channels.

    Parameters
    ----------
    bands : its sensitivities, of integral 1
    electrons : (C,) per second for radiance 1 in the channel, in the unit of the image
    """

    bands: Bands
    electrons: Floats


def find_response(sensor: Sensor) -> Response:
    """Return the channels of a sensor's camera.

    On the axis, irradiance is π L / (4 N²) with the f-number N, and the electrons of a pixel of
    area A are A ∫ E(λ) η(λ) λ / (h c) dλ per second. The quantum efficiency η is the sensitivity
    over λ, scaled so that its peak over all channels is the sensor's.

    Raises
    ------
    InputError : there is no such camera, or it has no sensitivities
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
