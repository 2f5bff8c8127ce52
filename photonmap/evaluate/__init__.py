"""The bench of intrinsic-image methods: metrics, intervals and methods on data sets of photonmap.

>>> from photonmap import evaluate
>>> evaluate.lmse(truth, estimate, mask)
"""

from photonmap.evaluate.bench.metric_list import METRICS
from photonmap.evaluate.bench.predictions import predictions
from photonmap.evaluate.bench.run import evaluate_dataset
from photonmap.evaluate.bench.scores import Evaluation
from photonmap.evaluate.intervals import Interval, paired_test, scene_interval, truth_interval
from photonmap.evaluate.methods.method import Estimate, Method, View
from photonmap.evaluate.methods.registry import find_method, method_names
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
    "METRICS",
    "AngularSummary",
    "Estimate",
    "Evaluation",
    "Interval",
    "Method",
    "OrdinalPairs",
    "View",
    "albedo_chromaticity",
    "albedo_intensity",
    "albedo_texture",
    "angular_error",
    "angular_error_map",
    "delta_e",
    "dssim",
    "evaluate_dataset",
    "find_method",
    "lmse",
    "lmse_mit",
    "method_names",
    "ordinal_pairs",
    "paired_test",
    "predictions",
    "scene_interval",
    "si_lmse",
    "si_mse",
    "summarise_angles",
    "truth_interval",
    "whdr",
]
