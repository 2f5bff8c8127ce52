"""Materials as kernels take them: diffuse albedos, mirrors and glass, band by band."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from photonmap.bands import Bands
from photonmap.errors import InputError, naming, warn
from photonmap.kernels import records
from photonmap.messages import listed
from photonmap.scene import Material
from photonmap.spectra.curves import LARGEST_REFLECTANCE
from photonmap.textures import Paint, Texture, mean_color

Floats = NDArray[np.float64]


def collect_matter(
    materials: list[Material], bands: Bands
) -> tuple[records.Materials, records.Optics | None, Floats]:
    """Return what M materials do with light; None for the smooth part where there is none.

    Textures count with their mean. Where diffuse and mirror reflectance add up to more than 1,
    anywhere on a texture, both are scaled, with a warning; the last array, (M,), is what they
    were divided by.

    Raises
    ------
    InputError
        if a reflectance or tint is outside [0, 1], or an index of refraction is not above 0
    """
    reflectance = np.stack([_part(m, "reflectance", m.reflectance, bands) for m in materials])
    mirror = np.stack([_part(m, "mirror", m.mirror, bands) for m in materials])
    tint = np.stack([_part(m, "tint", m.tint, bands) for m in materials])
    ior = np.array([_ior(material) for material in materials])
    for index, material in enumerate(materials):
        if ior[index] > 0.0 and (reflectance[index].any() or mirror[index].any()):
            raise InputError(
                f"material {material.name!r} is glass; set its reflectance and mirror to 0"
            )
    shrink = _bound(materials, reflectance, mirror)
    matter = records.Materials(reflectance.astype(np.float32))
    kind = np.select(
        [ior > 0.0, mirror.any(axis=1)], [records.GLASS, records.MIRROR], default=0
    ).astype(np.uint8)
    if not kind.any():
        return matter, None, shrink
    polished, dull = mirror.mean(axis=1), reflectance.mean(axis=1)
    chance = np.where(kind == records.MIRROR, polished / np.maximum(polished + dull, 1e-300), 0.0)
    chance[kind == records.GLASS] = 1.0
    optics = records.Optics(kind, mirror.astype(np.float32), ior, tint.astype(np.float32), chance)
    return matter, optics, shrink


def _part(material: Material, name: str, color: Paint, bands: Bands) -> Floats:
    """Return the bands of one of a material's reflectances, (N,), cut to 1."""
    with naming(f"material {material.name!r}: {name}"):
        values = bands.reflectance(mean_color(color))
    bad = ~((values >= 0.0) & (values <= LARGEST_REFLECTANCE))
    if bad.any():
        band = bands.names[int(np.argmax(bad))]
        raise InputError(
            f"material {material.name!r}: {name} is {values[bad][0]:.6g} in band {band}; "
            "it lies between 0 and 1"
        )
    return np.minimum(values, 1.0)


def _ior(material: Material) -> float:
    """Return the index of refraction, 0 for what is no glass."""
    if material.ior is None:
        return 0.0
    if not (isinstance(material.ior, int | float) and 0.0 < material.ior < math.inf):
        raise InputError(
            f"material {material.name!r}: ior is {material.ior!r}; it is a number above 0, as 1.5"
        )
    return float(material.ior)


def _bound(materials: list[Material], reflectance: Floats, mirror: Floats) -> Floats:
    """Scale rows that reflect more than they receive, in place, and say so: return divisors."""
    most = (reflectance + mirror).max(axis=1)
    for index, material in enumerate(materials):
        if isinstance(material.reflectance, Texture):
            largest = min(material.reflectance.largest, 1.0)
            most[index] = largest + mirror[index].max()
    excess = most > LARGEST_REFLECTANCE
    if excess.any():
        names = [material.name for material, much in zip(materials, excess, strict=True) if much]
        warn(f"reflectance and mirror add up to more than 1, and are scaled, in {listed(names)}")
    factor = np.maximum(most, 1.0)[:, None]
    reflectance /= factor
    mirror /= factor
    return factor[:, 0]
