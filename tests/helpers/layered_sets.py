"""A data set of known layers, written as renders are."""

from dataclasses import dataclass

import numpy as np

import photonmap as pm
from photonmap.dataset.files.derived_buffers import as_rgb, with_derived
from photonmap.dataset.files.image_files import write_image
from photonmap.dataset.files.manifest import FORMAT, write_head, write_lines

SIZE = 24, 32
COUNT = 4
"""Bands of the data set"""


@dataclass
class Layers:
    """What the truth of an image is, (H, W, N)."""

    name: str
    reflectance: np.ndarray
    shading: np.ndarray


def make_layers(scene, light, noise=0.0):
    """Vertical stripes of six materials under light that falls off downwards, stronger to one side
    in the second light."""
    rng = np.random.default_rng(scene)
    colors = rng.uniform(0.1, 0.9, (6, COUNT))
    stripe = np.arange(SIZE[1]) * len(colors) // SIZE[1]
    reflectance = np.broadcast_to(colors[stripe], (*SIZE, COUNT))
    fall = np.linspace(2.0, 1.0, SIZE[0])[:, None, None]
    color = np.array([1.0, 1.0, 1.0, 1.0] if light == "white" else [1.6, 1.2, 0.8, 0.4])
    shading = fall * color * np.ones((*SIZE, 1))
    shading = shading * (1.0 + noise * rng.standard_normal((*SIZE, 1)))
    return Layers(f"scene-{scene}-{light}", reflectance, shading)


def write_layers(folder, layers, error):
    """Write an image; its first pixel is a lamp."""
    direct = (layers.reflectance * layers.shading).astype(np.float32)
    emission = np.zeros_like(direct)
    emission[0, 0] = 50.0
    materials = np.arange(SIZE[1]) * 6 // SIZE[1] + 1
    ones = np.ones(SIZE, np.float32)
    shading = layers.shading.astype(np.float32)
    buffers = {
        "radiance": emission + direct,
        "emission": emission,
        "direct": direct,
        "indirect": np.zeros_like(direct),
        "reflectance": layers.reflectance.astype(np.float32),
        "shading": shading,
        "coverage": ones,
        "distance": ones,
        "normal": np.zeros((*SIZE, 3), np.float32),
        "object_id": np.ones(SIZE, np.uint32),
        "material_id": np.broadcast_to(materials, SIZE).astype(np.uint32),
        "unresolved": np.zeros(SIZE, bool),
    }
    errors = {"shading": error * shading, "reflectance": np.zeros_like(shading)} if error else {}
    record = {"passes": 16, "arguments": {"pixel": "center"}}  # so that no edge grazes a pixel
    result = with_derived(pm.Result(buffers, errors, pm.Bands.parse(COUNT), record))
    (folder / layers.name).mkdir(parents=True)
    write_image(folder / layers.name, result, as_rgb(result), ["exr"], full=True)


def write_set(folder, scenes=(0, 1, 2), lights=("white", "colored"), error=0.0, noise=0.0):
    """Write a data set; return the layers of its images by name."""
    made, entries = {}, []
    for scene in scenes:
        for light in lights:
            layers = make_layers(scene, light, noise)
            write_layers(folder, layers, error)
            made[layers.name] = layers
            job = {"seed": 0, "view": {"name": "", "yaw": 0.0}}
            entries.append(
                {
                    "name": layers.name,
                    "geometry": f"scene-{scene}",
                    "job": job,
                    "files": {},
                    "lights": {},
                }
            )
    write_head(folder, {"format": FORMAT, "images": list(made)}, made)
    write_lines(folder, entries)
    return made
