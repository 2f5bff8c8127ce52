"""Generated scenes of data sets, built once per process: tests must not change them."""

from functools import cache

import numpy as np

from photonmap.dataset.models.materials import reflectance_of
from photonmap.dataset.report.diversity import appearance_of
from photonmap.dataset.scenes.build import build_unlit_scene, draw_illumination

_built = cache(build_unlit_scene)


def unlit(name, seed=0, materials="lambertian"):
    """A scene with its emitters off."""
    return _built(name, seed, materials)


def lit(name, seed=0, illumination="white"):
    """What `build_scene` returns."""
    return unlit(name, seed).lit(draw_illumination(name, seed, illumination))


@cache
def appearance(name, seed=0):
    """What the camera of a scene sees, without its light."""
    return appearance_of(lit(name, seed))


def mean_reflectance(objects):
    """The mean over the area of all surfaces but emitters."""
    parts = [p for obj in objects for p in obj.parts if not p.light_group]
    areas = np.array([p.shape.area for p in parts])
    return areas @ [reflectance_of(p.material) for p in parts] / areas.sum()
