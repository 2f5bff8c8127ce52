"""The command `python -m photonmap compile`: all usual kernels at once."""

from __future__ import annotations

import argparse
import os
import time

from photonmap.commands import shared

HELP = "Compile the kernels of all usual scenes ahead of time, for container images and clusters."
INTEGRATORS = "photon", "path"
"""Integrators whose kernels are compiled; those of `--unbiased` are compiled when first used."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    usual = "NUMBA_CACHE_DIR, or the user's cache folder"
    text = "folder for the machine code"
    more = {"default_text": usual, "short": "o", "read": shared.file_name}
    shared.add_value(parser, "output", "FOLDER", text, **more)
    text = "compile for processors of this name or level, such as x86-64-v3"
    shared.add_value(parser, "processor", "NAME", text, default_text="this one")
    shared.add_quiet(parser)


def run(options: argparse.Namespace) -> None:
    """Compile variant by variant, the largest first, several at a time."""
    if options.output is not None:  # all of this before Numba is imported
        os.environ["NUMBA_CACHE_DIR"] = options.output
    if options.processor is not None:
        os.environ |= {"NUMBA_CPU_NAME": options.processor, "NUMBA_CPU_FEATURES": ""}
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from multiprocessing import get_context

    from photonmap.compile.scene_arrays import VARIANTS
    from photonmap.integrators.kernel_warmup import compile_variant, describe_compiled
    from photonmap.runtime.workers import default_threads

    start = time.perf_counter()
    jobs = [(variant, method) for variant in reversed(VARIANTS) for method in INTEGRATORS]
    count = min(default_threads(), len(jobs))
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
        names = {pool.submit(compile_variant, *job): " ".join(job) for job in jobs}
        for number, done in enumerate(as_completed(names), start=1):
            done.result()
            seconds = time.perf_counter() - start
            shared.say(options, f"{number}/{len(jobs)} {names[done]}: {seconds:.0f} s")
    shared.say(options, describe_compiled())
