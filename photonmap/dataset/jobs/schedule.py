"""Schedule jobs: in this process, in several processes of this machine, or on a cluster."""

from __future__ import annotations

import asyncio
import logging
import tempfile
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from itertools import chain, islice
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from photonmap.dataset.jobs.costs import Agenda, seconds_of
from photonmap.dataset.jobs.render_image import Task, by_image, hear_workers, render_image
from photonmap.errors import InputError, warn
from photonmap.runtime.workers import AUTO, default_threads
from photonmap.runtime.writing import WriteError

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster

LOCAL = "local"
MAX_WORKERS = 1024
"""Largest number of local worker processes."""
_CONNECT = 10.0
"""Seconds to wait for a connection to a scheduler, or to the worker that holds a result."""
_POLL, _PATIENCE = 1.0, 60.0
"""Seconds between checks for workers, and without any before the remaining jobs fail."""
_LAST = 0.5  # seconds to wait for what is left of a local worker after Ctrl-C
_RERUNNING = object()
"""Stands for a result that was lost with its worker; the scheduler runs the job again."""
_NO_WORKERS = "the scheduler has no workers; start some, and continue with --resume"
_SCHEDULER_GONE = "the scheduler is gone; start it again, and continue with --resume"


def check_scheduler(scheduler: str, workers: int | str) -> None:
    """Check that the number of workers is in range, and that a scheduler's dask is there."""
    if workers != AUTO and not 1 <= int(workers) <= MAX_WORKERS:
        raise InputError(f"workers {workers} must be a whole number from 1 to {MAX_WORKERS}")
    if scheduler != LOCAL and not has_dask():
        raise InputError(
            f"scheduler {scheduler!r} needs dask: pip install 'photonmap[cluster]'; or choose local"
        )


def run_tasks(
    tasks: Iterable[Any],
    scheduler: str = LOCAL,
    workers: int = 1,
    work: Callable[[Any], Any] | None = None,
) -> Generator[tuple[Any, Any]]:
    """Run tasks; yield each when it has finished, with its result, or failed, with the reason.

    One local worker, or a machine without dask, runs them in this process, one by one. Otherwise
    dask.distributed runs them; the tasks of a worker that dies go to another one, and a task fails
    after four workers have died of it.

    Parameters
    ----------
    tasks : dataclasses with a field `threads`, by default `render_image.Task`; each is taken when
        it is begun
    scheduler, workers : checked by `check_scheduler`
    work : runs one task; `render_image` by default
    """
    work, left = work or render_image, iter(tasks)
    first = next(left, None)
    if first is None:
        return
    left = chain([first], left)
    if scheduler == LOCAL and (workers == 1 or not has_dask()):
        if workers > 1:
            warn(f"{workers} workers need dask: pip install 'photonmap[cluster]'; using one")
        yield from ((task, _attempt(work, task)) for task in left)
        return
    if scheduler == LOCAL:
        threads = max(default_threads() // workers, 1)
        left = (replace(task, threads=threads) for task in left)
    with connect(scheduler, workers) as client:
        yield from distribute(client, work, left, workers)


def has_dask() -> bool:
    """Return whether dask.distributed is installed."""
    return find_spec("distributed") is not None


def _attempt(work: Callable[[Any], Any], task: Any) -> Any:
    """Run a task in this process; an error fails this task alone."""
    try:
        return work(task)
    except Exception as error:
        return _reason(error)


def distribute(
    client: Client, work: Callable[[Any], Any], tasks: Iterable[Any], workers: int
) -> Generator[tuple[Any, Any]]:
    """Run tasks by dask.distributed, each taken when handed out; keep `workers` processes alive."""
    ended: SimpleQueue[Future] = SimpleQueue()
    futures: dict[Future, Any] = {}
    left, seen = iter(tasks), time.monotonic()
    at_once, counted = _count_at_once(client), seen
    while True:
        if time.monotonic() - counted > _POLL:
            at_once, counted = _count_at_once(client), time.monotonic()
        for task in islice(left, max(at_once - len(futures), 0)):
            future = client.submit(work, task, pure=False)
            futures[future] = task
            future.add_done_callback(ended.put)
        if not futures:
            return
        try:
            future = ended.get(timeout=_POLL)
        except Empty:
            if _count_workers(client, workers):
                seen = time.monotonic()
            elif time.monotonic() - seen > _PATIENCE:
                yield from ((task, _NO_WORKERS) for task in (*futures.values(), *left))
                return
            continue
        seen = time.monotonic()
        result = _collect(future)
        if result is _RERUNNING:
            future.add_done_callback(ended.put)
            continue
        yield futures.pop(future), result
        if result is _SCHEDULER_GONE:
            yield from ((task, result) for task in (*futures.values(), *left))
            return


def _count_at_once(client: Client) -> int:
    """Return how many tasks to hand out: one for each thread of the workers, at least one.

    The others wait here. A worker would keep one that it has no thread for, however long it is at
    another, while others are idle; and what is learnt from the first decides on their order.
    """
    try:
        return max(sum(client.nthreads().values()), 1)
    except OSError:
        return 1


def _collect(future: Future) -> Any:
    """Return the result of a task, the reason of its failure, or `_RERUNNING`."""
    if future.cancelled():
        return _SCHEDULER_GONE
    if future.status == "error":
        return _reason(future.exception())
    try:
        return future.result(timeout=_CONNECT)
    except TimeoutError:
        return _RERUNNING


def _count_workers(client: Client, wanted: int) -> int:
    """Return the number of workers; restart local ones that the cluster has given up.

    A local cluster looks for a worker 15 s after it died and drops it if it is absent at that
    moment, even if it has come back, died again and is being restarted.
    """
    try:
        count = len(client.nthreads())
    except OSError:
        return 0
    if client.cluster is not None and count < wanted:
        client.cluster.scale(wanted)
    return count


def start_local_cluster(workers: int) -> LocalCluster:
    """Return a cluster of single-threaded worker processes of this machine."""
    from distributed import LocalCluster

    return LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=":0"
    )


def _expect_ends() -> None:
    """Let no one warn of workers that are gone, or slow to go."""
    for each in ("distributed.nanny", "distributed.scheduler"):
        logging.getLogger(each).setLevel(logging.ERROR)


async def _kill_workers(cluster: LocalCluster) -> None:
    """End the processes of a local cluster without waiting for what they are at."""
    nannies = list(cluster.workers.values())
    for nanny in nannies:
        nanny.auto_restart = False
        if nanny.process is not None and nanny.process.process is not None:
            await nanny.process.process.kill()
    await asyncio.gather(*(nanny.close(timeout=_LAST) for nanny in nannies))


@contextmanager
def connect(scheduler: str, workers: int) -> Iterator[Client]:
    """Start local worker processes, or connect to a scheduler.

    After Ctrl-C local workers are killed at once, as their images would be thrown away. A client
    that is the default one stays so where connecting fails, and others wait for it.
    """
    from distributed import Client

    if scheduler == LOCAL:
        with start_local_cluster(workers) as cluster, Client(cluster) as client:
            hear_workers(client)
            try:
                yield client
                _expect_ends()
            except BaseException:
                _expect_ends()
                cluster.sync(_kill_workers, cluster)
                raise
        return
    try:
        client = Client(scheduler, timeout=_CONNECT, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        reason = " ".join(str(error).split()) or "no answer"
        problem = f"scheduler {scheduler!r} cannot be reached ({reason})"
        raise InputError(f"{problem}; check the address, such as tcp://host:8786") from None
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # `_SCHEDULER_GONE` says it
    with client:
        hear_workers(client)
        yield client


def _reason(error: BaseException) -> str:
    """Return an error as one line."""
    text = " ".join(str(error).split()) or "no reason given"
    return text if isinstance(error, InputError | WriteError) else f"{type(error).__name__}: {text}"


_WARM = 2  # images that this process renders first; the last of them is the measure
_START = 10.0  # seconds that processes may take to start
_WORTH_TRYING = 10.0  # how many times as long as the trial the rest must take
_WORTH_IT = 1.1  # how many times as fast as one process many must be
_FREE = 0.8  # part of the free memory that processes may fill
_TINY = (16, 12)  # size of an image by which a process loads its kernels


def run_fastest(agenda: Agenda, log: Callable[[str], None]) -> Generator[tuple[Any, Any]]:
    """Run the tasks of an agenda as `run_tasks` does, in as many processes as are fastest here.

    This process renders the first images with all processors. If the rest takes long enough, so
    many others as there are processors, or as memory allows, render the last of them again, at
    once and on their share of the processors. If they are faster, they render the rest. The arrays
    do not depend on it. `log` is called with what was measured.
    """
    alone, rendered = run_tasks(agenda), 0
    for task, result in alone:
        yield task, result
        rendered += isinstance(result, dict)
        workers = _workers_in_memory() if rendered >= _WARM and has_dask() else 1
        if workers > 1 and isinstance(result, dict):
            trial = _START + workers * _seconds(task, result)
            if agenda.seconds_left > _WORTH_TRYING * trial:
                break
    else:
        return
    with connect(LOCAL, workers) as client:
        threads = default_threads() // workers
        gain = _measure(client, replace(task, threads=threads), _seconds(task, result))
        faster = gain >= _WORTH_IT
        verdict = f"{workers} render the rest" if faster else "one goes on"
        log(f"{workers} processes are {gain:.2f} times as fast as one: {verdict}")
        if faster:
            rest = (replace(each, threads=threads) for each in agenda)
            yield from distribute(client, render_image, rest, workers)
            return
    yield from alone


def _seconds(task: Task, result: dict[str, Any]) -> float:
    """Return the seconds that the images of a task took, without compilation."""
    entries = by_image(task, result).values()
    return sum(seconds_of(entry) for entry in entries if isinstance(entry, dict))


def _workers_in_memory() -> int:
    """Return how many processes as large as this one have processors and memory."""
    import resource

    import psutil

    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return max(min(default_threads(), int(_FREE * psutil.virtual_memory().available / used)), 1)


def _measure(client: Client, task: Task, alone: float) -> float:
    """Return how many times as fast workers render at once as this process, `alone` s an image."""
    workers = list(client.scheduler_info(n_workers=-1)["workers"])
    for part in (task.at_size(_TINY), task):
        with tempfile.TemporaryDirectory(prefix="photonmap-") as made:
            sent = []
            for number, worker in enumerate(workers):
                folder = Path(made) / str(number)
                folder.mkdir()
                copy = replace(part, folder=str(folder))
                sent.append(client.submit(render_image, copy, workers=[worker], pure=False))
            results = client.gather(sent)
    spent = [_seconds(task, result) for result in results]
    return len(spent) * alone / (sum(spent) / len(spent))
