"""A view of a data set for PyTorch, where that is installed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from photonmap.errors import InputError

if TYPE_CHECKING:
    from photonmap.dataset.reader import Dataset


def as_torch(
    dataset: Dataset,
    names: Sequence[str],
    rgb: bool,
    transform: Callable[[dict[str, Any]], Any] | None,
) -> Any:
    """Return a map-style `torch.utils.data.Dataset`; see `Dataset.torch`."""
    if find_spec("torch") is None:
        raise InputError("tensors need torch: pip install torch")
    import torch
    from torch.utils.data import Dataset as TorchDataset

    class Tensors(TorchDataset):
        def __len__(self) -> int:
            return len(dataset)

        def __getitem__(self, index: int) -> Any:
            if not 0 <= index < len(dataset):
                raise IndexError(index)
            image = dataset[index]
            source = image.rgb if rgb else image
            arrays = {name: np.ascontiguousarray(channels_first(source[name])) for name in names}
            item = {name: torch.from_numpy(array) for name, array in arrays.items()}
            return item if transform is None else transform(item)

    return Tensors()


def channels_first(array: Any) -> Any:
    """Return an image as (C, H, W), in a type that tensors have."""
    signed = array.astype(np.int64) if array.dtype == np.uint32 else array
    return signed[None] if signed.ndim == 2 else np.moveaxis(signed, -1, 0)
