"""Tables that take long to compute, kept on disk beside the compiled kernels."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from functools import cache, wraps
from pathlib import Path
from typing import ParamSpec, cast

import numpy as np
from llvmlite.binding import get_host_cpu_name

from photonmap.kernels.core.code_cache import source_hash
from photonmap.kernels.core.jit import CACHE_FOLDER
from photonmap.spectra.curves import Floats

Numbers = ParamSpec("Numbers")
MOST = 1000  # Tables on disk: further ones stay in memory alone


def kept_on_disk(compute: Callable[Numbers, Floats]) -> Callable[Numbers, Floats]:
    """Compute each table once for all processes: a function of numbers is kept by their values.

    What cannot be read is computed again, and what cannot be written is kept in memory alone.
    """

    @wraps(compute)
    def find(*arguments: Numbers.args, **named: Numbers.kwargs) -> Floats:
        digest = hashlib.sha256(repr((arguments, sorted(named.items()))).encode())
        file = _folder() / f"{compute.__name__}-{digest.hexdigest()[:16]}.npy"
        with suppress(OSError, ValueError, EOFError):
            return cast(Floats, np.load(file))
        table = compute(*arguments, **named)
        with suppress(OSError):
            file.parent.mkdir(parents=True, exist_ok=True)
            if len(list(file.parent.iterdir())) < MOST:
                part = file.with_suffix(f".{os.getpid()}")
                with part.open("wb") as draft:
                    np.save(draft, table)
                part.replace(file)  # whole or not at all
        return table

    return cast(Callable[Numbers, Floats], cache(find))


@cache
def _folder() -> Path:
    """Return where tables are kept: it is named by the code and the processor that make them."""
    made_by = f"{source_hash(Path(__file__).parent)}-{np.__version__}-{get_host_cpu_name()}"
    return CACHE_FOLDER / f"tables-{made_by}"
