"""Renders without rendering: radiances in bands, for sensors to look at."""

import numpy as np

import photonmap as pm

ONE_BAND = "550:550:20"
"""A camera of one channel."""


def flat(levels, camera=ONE_BAND, size=(8, 8)):
    """Return a render in a camera's own bands, of one radiance a channel in all pixels."""
    width, height = size
    image = np.broadcast_to(np.asarray(levels, np.float32), (height, width, len(levels)))
    return render_of(image.copy(), camera)


def render_of(image, bands=ONE_BAND, **record):
    """Return a render of an image (H, W, N)."""
    return pm.Result({"radiance": np.float32(image)}, {}, pm.Bands.parse(bands), record)


def ideal(**changes):
    """Return a sensor without noise but shot noise, whose white level is 10 000 electrons."""
    values = {
        "camera": ONE_BAND,
        "full_well": 1e4,
        "read_noise": 0.0,
        "dark_current": 0.0,
        "time": 1.0,
    }
    return pm.Sensor(**values | changes)


def scaled(sensor, electrons):
    """Return a sensor by which radiance 1 gives so many electrons in its time, on the average."""
    from dataclasses import replace

    from photonmap.capture.expose import find_response

    once = float(find_response(sensor).electrons.mean()) * sensor.time
    return replace(sensor, scale=sensor.scale * electrons / once)
