"""An image as it would be without interreflection: direct light alone, seen and asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from photonmap.dataset.files.derived_buffers import rgb_method
from photonmap.dataset.files.reader import Image
from photonmap.errors import InputError
from photonmap.evaluate.bench.truth import Truth, white_level
from photonmap.results.result import Result


def in_direct_light(image: Image, truth: Truth, space: str) -> Truth:
    """Return the truth of the same view without indirect light; it has no standard errors.

    The shading is direct / reflectance. Pixels where a band reflects nothing are no longer valid.

    Parameters
    ----------
    truth : of the image, as `photonmap.evaluate.bench.truth.load_truth` returns it for the space

    Raises
    ------
    InputError : some light of the image is not reflected diffusely, or no pixel is left
    """
    found = image.result
    if found.residual[truth.mask].any():
        raise InputError(
            "has surfaces that are not diffuse, so its direct shading is not known; render the set "
            "with --materials lambertian",
            image.folder,
        )
    reflectance = found.reflectance.astype(np.float64)
    mask = truth.mask & (reflectance > 0.0).all(axis=-1)
    if not mask.any():
        raise InputError("has no pixel that reflects all bands; leave it out", image.folder)
    shading = np.divide(found.direct, reflectance, where=mask[..., None],
                        out=np.zeros(reflectance.shape))  # fmt: skip
    light = {"direct": found.direct, "shading": shading.astype(np.float32)}
    if space == "rgb":
        apart = Result(light, {}, found.bands, found.record)
        light = {name: apart.rgb(name, rgb_method(found.bands), "D65") for name in light}
    radiance, seen = (light[name].astype(np.float64) for name in ("direct", "shading"))
    return replace(
        truth,
        radiance=radiance / white_level(radiance, mask),
        shading=seen / white_level(seen, mask),
        mask=mask,
        errors={},
    )
