"""Data sets of ground truth: scenes built from a seed, relit, recoloured, rendered, read.

>>> from photonmap import dataset
>>> for image in dataset.open("out/set"):
...     image["shading"], image["reflectance"], image.rgb["radiance"]
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from photonmap.dataset.files.reader import Dataset, Image, open_dataset
from photonmap.dataset.files.shard_reader import open_shards

if TYPE_CHECKING:
    from photonmap.results.result import Result
    from photonmap.scene.scene import Scene

open = open_dataset

__all__ = ["Dataset", "Image", "open", "open_shards", "with_derived"]


def with_derived(result: Result, scene: Scene) -> Result:
    """Return a render with the buffers that data sets add: masks, and the colours of its light.

    Parameters
    ----------
    result : of `photonmap.render`, with all buffers
    scene : that was rendered, with its camera

    Raises
    ------
    InputError : the scene has no camera
    """
    from photonmap.dataset.files import derived_buffers

    return derived_buffers.with_derived(result, scene)
