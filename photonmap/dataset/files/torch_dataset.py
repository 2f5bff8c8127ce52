"""The images of a data set as a PyTorch data set; imported only where PyTorch is installed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch


class TensorDataset(torch.utils.data.Dataset):
    """Images as dicts of tensors, bands first; can be pickled for a loader's worker processes.

    The parameters are those of `photonmap.dataset.Dataset.torch`.
    """

    def __init__(
        self, images: Sequence[Any], names: Sequence[str], rgb: bool, transform: Any
    ) -> None:
        self._images, self._names = images, tuple(names)
        self._rgb, self._transform = rgb, transform

    def __len__(self) -> int:
        return len(self._images)

    def __getitem__(self, index: int) -> Any:
        if not 0 <= index < len(self):
            raise IndexError(index)
        image = self._images[index]
        item = {
            name: _as_tensor(image.rgb[name] if self._rgb and name in image.rgb else image[name])
            for name in self._names
        }
        return item if self._transform is None else self._transform(item)


def _as_tensor(array: Any) -> torch.Tensor:
    """Return an image as (C, H, W); uint32, which PyTorch hardly supports, becomes int64."""
    signed = array.astype(np.int64) if array.dtype == np.uint32 else array
    first = signed[None] if signed.ndim == 2 else np.moveaxis(signed, -1, 0)
    return torch.from_numpy(np.ascontiguousarray(first))
