"""Where images are rendered: in this process, in several of this machine, or on a cluster."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from photonmap.dataset.produce import Task, produce
from photonmap.errors import InputError, warn

if TYPE_CHECKING:
    from distributed import Client

LOCAL = "local"
MOST_WORKERS = 1024
_CONNECT = 10.0
"""Seconds to reach a scheduler."""
_POLL, _PATIENCE = 1.0, 60.0
"""Seconds between looks at the workers, and without any before the rest is given up."""
_DESERTED = "the scheduler has no workers; start some, and go on with --resume"

Outcome = tuple[Task, dict[str, Any] | str]
"""A task, and its entry or why it failed."""


def check_scheduler(scheduler: str, workers: int) -> None:
    """Check that images can be rendered there.

    Raises
    ------
    InputError : a number of workers out of range, or an address without dask
    """
    if not 1 <= workers <= MOST_WORKERS:
        raise InputError(f"workers {workers} must be a whole number from 1 to {MOST_WORKERS}")
    if scheduler != LOCAL and not _has_dask():
        raise InputError(
            f"scheduler {scheduler!r} needs dask: pip install 'photonmap[cluster]'; or choose local"
        )


def run_tasks(tasks: Sequence[Task], scheduler: str = LOCAL, workers: int = 1) -> Iterator[Outcome]:
    """Render images; yield each as it is done or has failed.

    With one local worker, or without dask, that is in this process, image by image. Otherwise
    dask.distributed renders them; the images of a worker that dies go to another one, and fail
    when four have died of them.

    Raises
    ------
    InputError : the scheduler cannot be reached
    """
    if not tasks:
        return
    if scheduler == LOCAL and (workers == 1 or not _has_dask()):
        if workers > 1:
            warn(f"{workers} workers need dask: pip install 'photonmap[cluster]'; one renders now")
        yield from map(_attempt, tasks)
        return
    with _connect(scheduler, workers) as client:
        yield from _distribute(client, tasks, scheduler, workers)


def _has_dask() -> bool:
    return find_spec("distributed") is not None


def _attempt(task: Task) -> Outcome:
    """Render an image in this process; whatever goes wrong is of this image alone."""
    try:
        return task, produce(task)
    except Exception as error:
        return task, _reason(error)


def _distribute(
    client: Client, tasks: Sequence[Task], scheduler: str, workers: int
) -> Iterator[Outcome]:
    """Render images by dask.distributed."""
    from distributed import wait

    if scheduler == LOCAL:
        threads = max((os.cpu_count() or 1) // workers, 1)
        tasks = [replace(task, threads=threads) for task in tasks]
    futures = {client.submit(produce, task, pure=False): task for task in tasks}
    seen = time.monotonic()
    while futures:
        try:
            done = wait(list(futures), timeout=_POLL, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            done = set()
        for future in done:
            error = future.exception()
            yield futures.pop(future), future.result() if error is None else _reason(error)
        if done or client.scheduler_info()["workers"]:
            seen = time.monotonic()
        elif time.monotonic() - seen > _PATIENCE:
            yield from ((task, _DESERTED) for task in futures.values())
            return


@contextmanager
def _connect(scheduler: str, workers: int) -> Iterator[Client]:
    """Start worker processes of this machine, or reach a scheduler."""
    from distributed import Client, LocalCluster

    if scheduler == LOCAL:
        with (
            LocalCluster(
                n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=":0"
            ) as cluster,
            Client(cluster) as client,
        ):
            yield client
        return
    try:
        client = Client(scheduler, timeout=_CONNECT)
    except (OSError, ValueError, TimeoutError) as error:
        reason = " ".join(str(error).split()) or "no answer"
        raise InputError(
            f"scheduler {scheduler!r} cannot be reached ({reason}); check the address, as in "
            f"tcp://host:8786"
        ) from None
    with client:
        yield client


def _reason(error: BaseException) -> str:
    """Tell an error in one line."""
    text = " ".join(str(error).split()) or "no reason given"
    return text if isinstance(error, InputError) else f"{type(error).__name__}: {text}"
