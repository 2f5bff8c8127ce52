"""Threads that run a kernel over ranges of items, and stop between ranges on Ctrl-C."""

import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import AbstractContextManager
from typing import Any, Self

from photonmap.runtime.terminal import answering_interrupts

AUTO = "auto"
"""In place of a number of processes: as many as are fastest."""
POLL = 0.1
"""Seconds between checks for Ctrl-C."""


def default_threads() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Workers:
    """A pool of threads, as many as processors by default, for kernels that release the GIL."""

    def __init__(self, threads: int | None = None) -> None:
        self.threads = int(threads or default_threads())
        self._pool = ThreadPoolExecutor(self.threads)
        self._stop = threading.Event()

    def __enter__(self) -> Self:
        """Return the pool itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Drop what has not begun, wait for what has."""
        self._pool.shutdown(cancel_futures=True)

    def holding_interrupts(self) -> AbstractContextManager[None]:
        """Let Ctrl-C interrupt `map` alone, where no array is left half-changed.

        A second Ctrl-C interrupts at once.
        """

        def hold() -> None:
            if self._stop.is_set():
                raise KeyboardInterrupt
            self._stop.set()

        return answering_interrupts(hold)

    def map(self, task: Callable[[int], Any], count: int, uninterrupted: bool = False) -> list[Any]:
        """Return [task(0), …, task(count - 1)], or raise `KeyboardInterrupt` on Ctrl-C.

        On that or an error, tasks that have not begun are dropped and the ones under way are waited
        for, so no kernel touches an array that the caller gives up. If uninterrupted, a held Ctrl-C
        is left to the next call.
        """
        results: list[Any] = [None] * count
        left, dropped = iter(range(count)), threading.Event()

        # A future for each task would cost as much as a thousand rays, one after the other.
        def work() -> None:
            try:
                for index in left:
                    if dropped.is_set():
                        return
                    results[index] = task(index)
            except BaseException:
                dropped.set()
                raise

        futures = [self._pool.submit(work) for _ in range(min(self.threads, count))]
        try:
            for future in futures:
                while not wait([future], POLL).done:
                    self._check(uninterrupted)
                future.result()
            self._check(uninterrupted)
            return results
        except BaseException:
            dropped.set()
            for future in futures:
                future.cancel()
            wait(futures)
            raise

    def ranges(
        self, task: Callable[[int, int], Any], items: int, size: int, uninterrupted: bool = False
    ) -> list[Any]:
        """Return task(first, last) over consecutive ranges of at most `size` items, as `map`.

        Ranges depend on the numbers given alone, never on the number of threads.
        """
        return self.map(
            lambda index: task(index * size, min((index + 1) * size, items)),
            -(-items // size),
            uninterrupted,
        )

    def _check(self, uninterrupted: bool) -> None:
        if self._stop.is_set() and not uninterrupted:
            raise KeyboardInterrupt
