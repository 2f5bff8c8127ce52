"""Tables that take long to compute, kept on disk for all processes."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from functools import cache, wraps
from pathlib import Path
from typing import ParamSpec, cast

import numpy as np
from numpy.typing import NDArray

Table = NDArray[np.float64]
Values = ParamSpec("Values")
MOST = 1000  # Tables in a folder: further ones stay in memory alone


def kept_on_disk(
    folder: Callable[[], Path],
) -> Callable[[Callable[Values, Table]], Callable[Values, Table]]:
    """Have each table computed once for all processes: it is kept by the values it is made from.

    These are numbers and texts. What cannot be read is computed again, and what cannot be written
    is kept in memory alone.

    Parameters
    ----------
    folder : returns where tables are kept; its name has to tell apart all else that they depend on
    """

    def decorate(compute: Callable[Values, Table]) -> Callable[Values, Table]:
        @wraps(compute)
        def find(*arguments: Values.args, **named: Values.kwargs) -> Table:
            digest = hashlib.sha256(repr((arguments, sorted(named.items()))).encode())
            file = folder() / f"{compute.__name__}-{digest.hexdigest()[:16]}.npy"
            with suppress(OSError, ValueError, EOFError):
                return cast(Table, np.load(file))
            table = compute(*arguments, **named)
            with suppress(OSError):
                file.parent.mkdir(parents=True, exist_ok=True)
                if len(list(file.parent.iterdir())) < MOST:
                    part = file.with_suffix(f".{os.getpid()}")
                    try:
                        with part.open("wb") as draft:
                            np.save(draft, table)
                        part.replace(file)  # whole or not at all
                    finally:
                        part.unlink(missing_ok=True)
            return table

        return cast(Callable[Values, Table], cache(find))

    return decorate
