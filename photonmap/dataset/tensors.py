"""A view of a data set for PyTorch; this module needs it, and is imported where it is there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

if TYPE_CHECKING:
    from photonmap.dataset.reader import Dataset


class Tensors(torch.utils.data.Dataset):
    """Dicts of tensors, bands first; it can be sent to a loader's processes. See `Dataset.torch`.

    Parameters
    ----------
    dataset : that has the images
    names : of the arrays
    rgb : those in linear sRGB
    transform : is given each dict, and returns what is yielded
    """

    def __init__(
        self,
        dataset: Dataset,
        names: Sequence[str],
        rgb: bool,
        transform: Callable[[dict[str, Any]], Any] | None,
    ) -> None:
        self._dataset, self._names, self._rgb = dataset, tuple(names), rgb
        self._transform = transform

    def __len__(self) -> int:
        return len(self._dataset)

    def __getitem__(self, index: int) -> Any:
        if not 0 <= index < len(self):
            raise IndexError(index)
        image = self._dataset[index]
        source = image.rgb if self._rgb else image
        item = {name: _as_tensor(source[name]) for name in self._names}
        return item if self._transform is None else self._transform(item)


def _as_tensor(array: Any) -> torch.Tensor:
    """Return an image as (C, H, W), in a type that tensors have."""
    signed = array.astype(np.int64) if array.dtype == np.uint32 else array
    first = signed[None] if signed.ndim == 2 else np.moveaxis(signed, -1, 0)
    return torch.from_numpy(np.ascontiguousarray(first))
