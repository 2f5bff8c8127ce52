"""Where images are rendered: in this process, in several of this machine, or on a cluster."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from photonmap.dataset.produce import produce
from photonmap.errors import InputError, warn

if TYPE_CHECKING:
    from distributed import Client, Future

LOCAL = "local"
MOST_WORKERS = 1024
_CONNECT = 10.0
"""Seconds to reach a scheduler, or a worker that has an entry."""
_POLL, _PATIENCE = 1.0, 60.0
"""Seconds between looks at the workers, and without any before the rest is given up."""
_BATCH = 1000
"""Images that are sent to the scheduler at once."""
_GOES_ON = object()
_DESERTED = "the scheduler has no workers; start some, and go on with --resume"
_LOST = "the scheduler is gone; start it again, and go on with --resume"


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


def run_tasks(
    tasks: Sequence[Any],
    scheduler: str = LOCAL,
    workers: int = 1,
    work: Callable[[Any], Any] | None = None,
) -> Iterator[tuple[Any, Any]]:
    """Render images; yield each as it is done or has failed: with its entry, or the reason.

    With one local worker, or without dask, that is in this process, image by image. Otherwise
    dask.distributed renders them; the images of a worker that dies go to another one, and fail
    when four have died of them.

    Parameters
    ----------
    tasks : dataclasses with a field `threads`, of `photonmap.dataset.produce.Task` if not of others
    scheduler, workers : as `check_scheduler` passed them
    work : renders one of them; `produce` if left out

    Raises
    ------
    InputError : the scheduler cannot be reached
    """
    work = work or produce
    if not tasks:
        return
    if scheduler == LOCAL and (workers == 1 or not _has_dask()):
        if workers > 1:
            warn(f"{workers} workers need dask: pip install 'photonmap[cluster]'; one renders now")
        yield from ((task, _attempt(work, task)) for task in tasks)
        return
    if scheduler == LOCAL:
        threads = max((os.cpu_count() or 1) // workers, 1)
        tasks = [replace(task, threads=threads) for task in tasks]
    with _connect(scheduler, workers) as client:
        yield from _distribute(client, work, tasks, workers)


def _has_dask() -> bool:
    return find_spec("distributed") is not None


def _attempt(work: Callable[[Any], Any], task: Any) -> Any:
    """Render an image in this process; whatever goes wrong is of this image alone."""
    try:
        return work(task)
    except Exception as error:
        return _reason(error)


def _distribute(
    client: Client, work: Callable[[Any], Any], tasks: Sequence[Any], workers: int
) -> Iterator[tuple[Any, Any]]:
    """Render images by dask.distributed; `workers` are those that this machine is to have."""
    ended: SimpleQueue[Future] = SimpleQueue()
    sent = client.map(work, tasks, pure=False, batch_size=_BATCH)
    futures = dict(zip(sent, tasks, strict=True))
    for future in futures:
        future.add_done_callback(ended.put)
    seen = time.monotonic()
    while futures:
        try:
            future = ended.get(timeout=_POLL)
        except Empty:
            if _count_workers(client, workers):
                seen = time.monotonic()
            elif time.monotonic() - seen > _PATIENCE:
                yield from ((task, _DESERTED) for task in futures.values())
                return
            continue
        seen = time.monotonic()
        result = _collect(future)
        if result is _GOES_ON:
            future.add_done_callback(ended.put)
        else:
            yield futures.pop(future), result


def _collect(future: Future) -> Any:
    """Return an image's entry, or why it failed; or that its entry was lost with its worker."""
    if future.cancelled():
        return _LOST
    if future.status == "error":
        return _reason(future.exception())
    try:
        return future.result(timeout=_CONNECT)
    except TimeoutError:
        return _GOES_ON


def _count_workers(client: Client, wanted: int) -> int:
    """Return how many workers there are; start those of this machine anew that are given up.

    A local cluster looks for a worker 15 s after it died, and drops it where it is not there just
    then, also if it has come back since, died again, and is being started again.
    """
    try:
        count = len(client.nthreads())
    except OSError:
        return 0
    if client.cluster is not None and count < wanted:
        client.cluster.scale(wanted)
    return count


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
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # told by `_LOST`
    with client:
        yield client


def _reason(error: BaseException) -> str:
    """Tell an error in one line."""
    text = " ".join(str(error).split()) or "no reason given"
    return text if isinstance(error, InputError) else f"{type(error).__name__}: {text}"
