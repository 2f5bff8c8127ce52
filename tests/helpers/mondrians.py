"""Mondrians, images of few reflectances in a smooth light, and methods run on them."""

import numpy as np

from photonmap import evaluate
from photonmap.evaluate.methods.method import View, find_method

SIZE = 24, 30
ALL = np.ones(SIZE, bool)
COLORS = np.array([(0.6, 0.3, 0.2), (0.2, 0.5, 0.3), (0.3, 0.25, 0.7)])


def run(name, image, mask=ALL, relit=(), **settings):
    """Return the estimate of a method with its defaults but for some settings."""
    method = find_method(name)
    return method.estimate(View("image", image, mask, relit), **{**method.defaults, **settings})


def stripes(colors, times=1):
    """Return vertical stripes of reflectance, (H, W, C), all colours some times over."""
    columns = np.arange(SIZE[1]) * times * len(colors) // SIZE[1] % len(colors)
    return np.broadcast_to(np.asarray(colors)[columns], (*SIZE, len(colors[0])))


def mondrian(colors=COLORS, times=1):
    """Return the reflectance of stripes, and light (H, W) that falls off downwards to a half."""
    light = np.broadcast_to(np.linspace(1.0, 0.5, SIZE[0])[:, None], SIZE)
    return stripes(colors, times), light


def errors(found, reflectance, shading, mask=None):
    """Return the si-MSE of reflectance and that of shading, whose bands are averaged."""
    grey = found.shading if found.shading.ndim == 2 else found.shading.mean(axis=-1)
    return evaluate.si_mse(reflectance, found.reflectance, mask), evaluate.si_mse(
        shading, grey, mask
    )
