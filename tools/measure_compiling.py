"""Print what compiling costs: `python tools/measure_compiling.py [VARIANT …]`.

Every kernel of each variant and integrator is compiled into an empty cache; processor seconds are
those of one thread, and functions that kernels share count for the first that needs them.
"""

import os
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

os.environ["NUMBA_CACHE_DIR"] = tempfile.mkdtemp()

from numba.core.registry import CPUDispatcher

from photonmap.commands.compile import INTEGRATORS
from photonmap.compile.scene_arrays import VARIANTS
from photonmap.integrators.kernel_warmup import compile_variant
from photonmap.kernels.core.code_cache import KernelCache


def timed(
    compile_one: Callable[..., Any], rows: list[tuple[float, int, str]]
) -> Callable[..., Any]:
    """Return a compiling function that adds a row: seconds, bytes of machine code, kernel."""

    def compile_and_note(kernel: Any, signature: Any) -> Any:
        start, before = time.thread_time(), len(kernel.overloads)
        result = compile_one(kernel, signature)
        if len(kernel.overloads) > before and isinstance(kernel._cache, KernelCache):
            seconds = time.thread_time() - start
            library = list(kernel.overloads.values())[-1].library
            name = f"{kernel.py_func.__module__.rpartition('.')[2]}.{kernel.py_func.__name__}"
            rows.append((seconds, len(library._get_compiled_object()), name))
        return result

    return compile_and_note


def main(variants: list[str]) -> None:
    """Print a table for each variant and integrator."""
    rows: list[tuple[float, int, str]] = []
    CPUDispatcher.compile = timed(CPUDispatcher.compile, rows)
    for variant in variants or VARIANTS:
        for method in INTEGRATORS:
            rows.clear()
            compile_variant(variant, method)
            seconds, size = sum(row[0] for row in rows), sum(row[1] for row in rows)
            print(f"\n{variant}, {method}: {seconds:.1f} s, {size / 1e3:.0f} kB\n")
            print("| kernel | processor s | machine code, kB |\n|---|---|---|")
            for seconds, size, name in sorted(rows, reverse=True):
                print(f"| `{name}` | {seconds:.1f} | {size / 1e3:.0f} |")


if __name__ == "__main__":
    main(sys.argv[1:])
