"""What processes say while they render, heard in the process that asked for the images."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from typing import TYPE_CHECKING

from photonmap.runtime.progress import STAGES, Silent

if TYPE_CHECKING:
    from distributed import Client

Log = Callable[[str], None]
_TOPIC = "photonmap"
"""Of what workers send."""

_listeners: list[Log] = []


class SpokenStages(Silent):
    """Says where kernels are compiled, which may take a minute; else nothing."""

    def stage(self, name: str) -> None:
        """Say so."""
        if name == "first compile":
            say(STAGES[name])


def say(line: str) -> None:
    """Say a line to who listens in this process, or from a worker of dask to its client."""
    for listener in _listeners:
        listener(line)
    if not _listeners and find_spec("distributed") is not None:
        from distributed import get_worker

        with suppress(ValueError):  # this is no worker
            get_worker().log_event(_TOPIC, line)


@contextmanager
def hearing(log: Log) -> Iterator[None]:
    """Call `log` with every line that is said in this context, once each."""
    heard = set[str]()

    def hear(line: str) -> None:
        if line not in heard:
            heard.add(line)
            log(line)

    _listeners.append(hear)
    try:
        yield
    finally:
        _listeners.remove(hear)


def hear_workers(client: Client) -> None:
    """Say here what the workers of a client say."""
    client.subscribe_topic(_TOPIC, lambda event: say(event[1]))
