"""One thread for linear algebra: the order of its sums, and so scores, depend on their number."""

from __future__ import annotations

from contextlib import AbstractContextManager
from importlib import import_module
from typing import Any

from photonmap.errors import InputError


def one_thread() -> AbstractContextManager[Any]:
    """Return a context in which NumPy's and SciPy's linear algebra runs in one thread.

    Raises
    ------
    InputError : without threadpoolctl, which limits them
    """
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        message = "evaluate needs threadpoolctl: pip install 'photonmap[evaluate]'"
        raise InputError(message) from None
    import_module("scipy.linalg")  # limits reach only libraries that are loaded
    return threadpool_limits(1)
