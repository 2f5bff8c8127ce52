"""Where tables of surfaces are kept on disk: beside the compiled kernels."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
from llvmlite.binding import get_host_cpu_name

from photonmap.kernels.core.code_cache import source_hash
from photonmap.kernels.core.jit import CACHE_FOLDER
from photonmap.runtime import kept_tables


@cache
def _folder() -> Path:
    """Return where tables are kept: it is named by the code and the processor that make them."""
    made_by = f"{source_hash(Path(__file__).parent)}-{np.__version__}-{get_host_cpu_name()}"
    return CACHE_FOLDER / f"tables-{made_by}"


kept_on_disk = kept_tables.kept_on_disk(lambda: _folder())
