"""The bench of intrinsic-image methods: metrics, intervals and methods on data sets of photonmap.

>>> from photonmap import evaluate
>>> evaluate.lmse(truth, estimate, mask)
"""

from photonmap.evaluate.metrics.albedo import (
    albedo_chromaticity,
    albedo_intensity,
    albedo_texture,
)
from photonmap.evaluate.metrics.angular import (
    AngularSummary,
    angular_error,
    angular_error_map,
    summarise_angles,
)
from photonmap.evaluate.metrics.color import delta_e
from photonmap.evaluate.metrics.lmse import lmse, lmse_mit
from photonmap.evaluate.metrics.sintel import dssim, si_lmse, si_mse
from photonmap.evaluate.metrics.whdr import OrdinalPairs, ordinal_pairs, whdr

__all__ = [
    "AngularSummary",
    "OrdinalPairs",
    "albedo_chromaticity",
    "albedo_intensity",
    "albedo_texture",
    "angular_error",
    "angular_error_map",
    "delta_e",
    "dssim",
    "lmse",
    "lmse_mit",
    "ordinal_pairs",
    "si_lmse",
    "si_mse",
    "summarise_angles",
    "whdr",
]
