"""What a command does when its terminal or reader goes away: signals, and streams that are lost.

Ctrl-C, and the signals that end a program as it does: SIGTERM, and SIGHUP of a lost terminal.
"""

from __future__ import annotations

import errno
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, TextIO, cast

from photonmap.errors import visible

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
def answering_interrupts(answer: Callable[[], None] = lambda: None) -> Iterator[None]:
    """Call a function at Ctrl-C, by default none: where it would only lose work that is done.

    Outside the main thread, Python delivers no Ctrl-C.
    """
    if not _in_main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, lambda number, frame: answer())
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


_STDERR = 2
_NOBODY_READS = (errno.EPIPE, errno.EIO)
"""The pipe was closed, or the terminal is gone."""


class _Tolerant:
    """A text stream that no write fails on: after an error, what is written is dropped.

    Control characters and the like are shown, but for line ends and tabs, unless it `draws`.
    """

    def __init__(self, stream: TextIO | None, draws: bool = False) -> None:
        self._stream = stream or open(os.devnull, "w")  # noqa: PTH123, SIM115
        self._draws = draws
        self.error: OSError | None = None

    def write(self, text: str) -> int:
        """Write a text."""
        try:
            return self._stream.write(text if self._draws else visible(text, "\n\t"))
        except OSError as error:
            self._drop(error)
            return len(text)

    def flush(self) -> None:
        """Write what is buffered."""
        try:
            self._stream.flush()
        except OSError as error:
            self._drop(error)

    def _drop(self, error: OSError) -> None:
        """Let what is still buffered go nowhere: Python would fail on it at its end."""
        self.error = self.error or error
        with suppress(OSError), open(os.devnull, "w") as nowhere:  # noqa: PTH123
            os.dup2(nowhere.fileno(), self._stream.fileno())

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def tolerant(stream: TextIO | None) -> TextIO:
    """Return a stream on which no write fails; None is one that goes nowhere."""
    return cast(TextIO, stream if isinstance(stream, _Tolerant) else _Tolerant(stream))


def drawing(stream: TextIO | None) -> TextIO:
    """Return a stream on which no write fails and nothing is escaped: that of a progress bar."""
    bare = stream._stream if isinstance(stream, _Tolerant) else stream
    return cast(TextIO, _Tolerant(bare, draws=True))


@contextmanager
def quiet_libraries() -> Iterator[None]:
    """Let what libraries in C print on standard error go nowhere: errors are told by exceptions."""
    try:
        before = os.dup(_STDERR)
    except OSError:  # it is closed
        yield
        return
    tolerant(sys.stderr).flush()
    try:
        with open(os.devnull, "w") as nowhere:  # noqa: PTH123
            os.dup2(nowhere.fileno(), _STDERR)
        yield
    finally:
        os.dup2(before, _STDERR)
        os.close(before)


@contextmanager
def tolerant_output() -> Iterator[None]:
    """Let writing to standard output and standard error never fail in this context.

    It ends with an `OSError` if standard output was lost though somebody reads it: the disk is
    full.
    """
    before = sys.stdout, sys.stderr
    out, err = _Tolerant(sys.stdout), _Tolerant(sys.stderr)
    sys.stdout, sys.stderr = cast(TextIO, out), cast(TextIO, err)
    try:
        yield
    finally:
        out.flush()
        err.flush()
        sys.stdout, sys.stderr = before
    if out.error is not None and out.error.errno not in _NOBODY_READS:
        raise OSError(f"standard output was lost: {out.error.strerror}")
