"""Learn the priors of SIRFS from a data set: python -m photonmap.evaluate.methods.sirfs_learn SET.

Prints what `sirfs_priors.json` holds. The set must not share a scene with those that are evaluated.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from photonmap.dataset.files.reader import Image
from photonmap.evaluate.bench.images import load_truth, open_finished
from photonmap.evaluate.methods import sirfs
from photonmap.evaluate.methods.method import FLOOR
from photonmap.evaluate.metrics.arrays import Floats, Mask

_EVERY = 7  # One of so many differences is kept
_RIDGE = 1e-2  # Added to variances of light, of which few examples are seen


def learn_priors(folder: Path) -> sirfs.Priors:
    """Return the priors of the scenes of a finished data set, in linear sRGB."""
    colors, steps, bends, lights = [], [], [], []
    for image in open_finished(folder):
        truth = load_truth(image, "rgb")
        reflectance = np.log(np.maximum(truth.reflectance, FLOOR))
        colors.append(reflectance[truth.mask])
        steps.append(_differences(reflectance, truth.mask))
        surface = sirfs.Surface(_depth(image, truth.mask))
        curvature = sirfs.BEND * surface.curvature().reshape(*truth.mask.shape, 1)
        bends.append(_differences(curvature, truth.mask)[:, 0])
        shading = np.log(np.maximum(truth.radiance, FLOOR))[truth.mask] - colors[-1]
        basis = sirfs.harmonics(_normals(image)[truth.mask])
        lights.append(np.linalg.lstsq(basis, shading)[0])
    edges = np.concatenate(steps)
    spread = _spread(edges)
    values = np.concatenate(colors)
    brightness = values.mean(axis=1, keepdims=True)
    edge_weights = sirfs.learn_mixture(
        (sirfs.whitened(edges, spread) ** 2).sum(axis=1), edges.shape[1]
    )
    bend_weights = sirfs.learn_mixture(np.concatenate(bends) ** 2, 1)
    return sirfs.Priors(
        edge_weights.tolist(),
        bend_weights.tolist(),
        list(spread),
        [float(brightness.mean()), *_spread(values)],
        *_light(np.array(lights)),
    )


def _differences(image: Floats, mask: Mask) -> Floats:
    """Return a sample of the differences of (H, W, C) in windows of 5×5."""
    found = [
        (image[other] - image[one])[mask[one] & mask[other]] for one, other in sirfs.windows(mask)
    ]
    return np.asarray(np.concatenate(found)[::_EVERY])


def _spread(colors: Floats) -> tuple[float, float]:
    """Return the standard deviations of brightness and of deviations from it, (K, C)."""
    mean = colors.mean(axis=1, keepdims=True)
    return float(mean.std()), float((colors - mean).std())


def _light(lights: Floats) -> tuple[list[float], list[list[float]], list[float]]:
    """Return mean, precision and the deviation of bands of coefficients (K, 9, C)."""
    means = lights.mean(axis=2)
    covariance = np.cov(means.T) + _RIDGE * np.eye(means.shape[1])
    deviation = np.sqrt(((lights - means[..., None]) ** 2).mean(axis=(0, 2)) + _RIDGE)
    return means.mean(axis=0).tolist(), np.linalg.inv(covariance).tolist(), deviation.tolist()


def _depth(image: Image, mask: Mask) -> Floats:
    """Return the depth towards the camera in pixels of the mean distance, 0 outside of a mask."""
    depth = np.asarray(image["depth"], np.float64)
    middle = float(depth[mask].mean())
    focal = float(image.entry["camera"]["intrinsics"][0][0])
    return np.asarray(np.where(mask, (middle - depth) * focal / middle, 0.0))


def _normals(image: Image) -> Floats:
    """Return the normals (H, W, 3): right, down, towards the camera."""
    axes = np.array(image.entry["camera"]["camera_to_world"])[:3, :3]
    seen = np.asarray(image["normal"], np.float64) @ axes
    return np.asarray(seen * (1.0, -1.0, 1.0))


if __name__ == "__main__":
    print(sirfs.as_json(learn_priors(Path(sys.argv[1]))))
