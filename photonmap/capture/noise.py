"""From expected electrons to the numbers of a raw file: shot, dark and read noise, rounding.

The linear model of the EMVA Standard 1288, release 4.0 (2021), section 2: with gain K in numbers
per electron, the variance of a pixel is K² (mean electrons + read noise²) + 1/12.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.capture.sensor import Sensor

Floats = NDArray[np.float64]

_SHOT, _READ, _GAIN, _OFFSET = range(4)
"""Uses of random numbers."""
_MOST = 1e12
"""Expected electrons above which a pixel is full anyway."""


def digitise(electrons: Floats, sensor: Sensor, time: float, seed: int) -> NDArray[np.uint16]:
    """Return what the converter gives for expected electrons, in the same shape.

    Parameters
    ----------
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
