"""Data sets of ground truth: scenes built from a seed, relit, recoloured, rendered, read.

>>> from photonmap import dataset
>>> for image in dataset.open("out/set"):
...     image["shading"], image["reflectance"], image.rgb["radiance"]
"""

from photonmap.dataset.files.reader import Dataset, Image, open_dataset
from photonmap.dataset.files.shard_reader import open_shards

open = open_dataset

__all__ = ["Dataset", "Image", "open", "open_shards"]
