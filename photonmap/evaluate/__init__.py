"""The bench of intrinsic-image methods: metrics, intervals and methods on data sets of photonmap.

>>> from photonmap import evaluate
>>> evaluate.lmse(truth, estimate, mask)
"""

from photonmap.evaluate.bench.measure import METRICS
from photonmap.evaluate.bench.predictions import predictions
from photonmap.evaluate.bench.run import evaluate_dataset
from photonmap.evaluate.bench.scores import Evaluation
from photonmap.evaluate.intervals import Interval, paired_test, scene_interval, truth_interval
from photonmap.evaluate.methods.method import Estimate, Method, View, find_method, method_names
from photonmap.evaluate.metrics.angular import (
    AngularSummary,
    angular_error,
    angular_error_map,
    summarise_angles,
)
from photonmap.evaluate.metrics.reflectance import (
    OrdinalPairs,
    albedo_chromaticity,
    albedo_intensity,
    albedo_texture,
    delta_e,
    ordinal_pairs,
    whdr,
)
from photonmap.evaluate.metrics.scaled import dssim, lmse, lmse_mit, si_lmse, si_mse

__all__ = [
    "METRICS", "AngularSummary", "Estimate", "Evaluation", "Interval", "Method", "OrdinalPairs",
    "View", "albedo_chromaticity", "albedo_intensity", "albedo_texture", "angular_error",
    "angular_error_map", "delta_e", "dssim", "evaluate_dataset", "find_method", "lmse", "lmse_mit",
    "method_names", "ordinal_pairs", "paired_test", "predictions", "scene_interval", "si_lmse",
    "si_mse", "summarise_angles", "truth_interval", "whdr",
]  # fmt: skip
