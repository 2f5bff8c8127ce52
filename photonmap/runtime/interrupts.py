"""Ctrl-C, and the signals that end a program as it does: SIGTERM, and SIGHUP of a lost terminal."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_LIKE_CTRL_C = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Received:
    """The signal that interrupts: SIGINT until another one arrives."""

    number = signal.SIGINT


@contextmanager
def other_signals_as_ctrl_c() -> Iterator[Received]:
    """Let SIGTERM and SIGHUP do in this context what Ctrl-C does at the moment they arrive.

    But those that are ignored when it begins, as SIGHUP is under `nohup`, remain so.
    """
    received = Received()

    def interrupt(number: int, frame: FrameType | None) -> None:
        received.number = signal.Signals(number)
        handler = signal.getsignal(signal.SIGINT)
        (handler if callable(handler) else signal.default_int_handler)(number, frame)

    if not _in_main_thread():
        yield received
        return
    before = {number: signal.getsignal(number) for number in _LIKE_CTRL_C}
    taken = [number for number, handler in before.items() if handler != signal.SIG_IGN]
    for number in taken:
        signal.signal(number, interrupt)
    try:
        yield received
    finally:
        for number in taken:
            signal.signal(number, before[number])


@contextmanager
def ignoring_interrupts() -> Iterator[None]:
    """Ignore Ctrl-C where it would only lose work that is done."""
    if not _in_main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, lambda number, frame: None)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def end_by(number: int) -> None:
    """End this process by a signal, as if that had not been handled.

    Only so does a shell end the loop that the process ran in.
    """
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)


def _in_main_thread() -> bool:
    """Return whether this is the thread to which Python delivers signals."""
    return threading.current_thread() is threading.main_thread()
