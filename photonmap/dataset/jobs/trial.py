"""Whether a process for each core is faster than one for all: tried at the start of a set."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Generator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photonmap.dataset.jobs.agenda import Agenda, seconds_of
from photonmap.dataset.jobs.render_image import Task, render_image
from photonmap.dataset.jobs.schedule import LOCAL, connect, distribute, has_dask, run_tasks
from photonmap.runtime.workers import default_threads

if TYPE_CHECKING:
    from distributed import Client

_WARM = 2
"""Images that this process renders first; the last of them is the measure."""
_START = 10.0
"""Seconds that processes may take to start."""
_WORTH_TRYING = 10.0
"""How many times as long as the trial the rest must take."""
_WORTH_IT = 1.1
"""How many times as fast as one process many must be."""
_FREE = 0.8
"""Part of the free memory that processes may fill."""
_TINY = (16, 12)
"""Size of an image by which a process loads its kernels."""


def run_fastest(agenda: Agenda, log: Callable[[str], None]) -> Generator[tuple[Any, Any]]:
    """Run the tasks of an agenda as `run_tasks` does, in as many processes as are fastest here.

    This process renders the first images with all processors. If the rest takes long enough, so
    many others as there are processors, or as memory allows, render the last of them again, at
    once and on their share of the processors. If they are faster, they render the rest. The arrays
    do not depend on it.

    Parameters
    ----------
    log : called with what was measured
    """
    alone, rendered = run_tasks(agenda), 0
    for task, result in alone:
        yield task, result
        rendered += isinstance(result, dict)
        workers = _workers_in_memory() if rendered >= _WARM and has_dask() else 1
        if workers > 1 and isinstance(result, dict) and _is_worth_trying(agenda, workers, result):
            break
    else:
        return
    with connect(LOCAL, workers) as client:
        threads = default_threads() // workers
        gain = _measure(client, replace(task, threads=threads), seconds_of(result))
        faster = gain >= _WORTH_IT
        log(
            f"{workers} processes are {gain:.2f} times as fast as one: "
            + (f"{workers} render the rest" if faster else "one goes on")
        )
        if faster:
            rest = (replace(each, threads=threads) for each in agenda)
            yield from distribute(client, render_image, rest, workers)
            return
    yield from alone


def _workers_in_memory() -> int:
    """Return how many processes as large as this one have processors and memory."""
    import resource

    import psutil

    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return max(min(default_threads(), int(_FREE * psutil.virtual_memory().available / used)), 1)


def _is_worth_trying(agenda: Agenda, workers: int, entry: dict[str, Any]) -> bool:
    """Return whether the rest takes much longer than a trial does."""
    trial = _START + workers * seconds_of(entry)
    return agenda.seconds_left > _WORTH_TRYING * trial


def _measure(client: Client, task: Task, alone: float) -> float:
    """Return how many times as many images the workers render as this process, in the same time.

    Each renders the task, all at once; their images are thrown away.

    Parameters
    ----------
    alone : seconds that the image took here
    """
    workers = list(client.scheduler_info(n_workers=-1)["workers"])
    tiny = replace(task.job, common=replace(task.job.common, size=_TINY))
    for job in (tiny, task.job):
        with tempfile.TemporaryDirectory(prefix="photonmap-") as made:
            sent = []
            for number, worker in enumerate(workers):
                folder = Path(made) / str(number)
                folder.mkdir()
                copy = replace(task, job=job, folder=str(folder))
                sent.append(client.submit(render_image, copy, workers=[worker], pure=False))
            entries = client.gather(sent)
    spent = [seconds_of(entry) for entry in entries]
    return len(spent) * alone / (sum(spent) / len(spent))
