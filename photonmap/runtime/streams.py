"""Standard streams whose reader may go away without the work being lost."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO, cast

_NOBODY_READS = (errno.EPIPE, errno.EIO)
"""The pipe was closed, or the terminal is gone."""


class _Tolerant:
    """A text stream that no write fails on: after the first error, what is written is dropped.

    Parameters
    ----------
    stream : what it writes to; None for nowhere
    """

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream or open(os.devnull, "w")  # noqa: PTH123, SIM115
        self.error: OSError | None = None

    def write(self, text: str) -> int:
        """Write a text."""
        try:
            return self._stream.write(text)
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


@contextmanager
def tolerant_output() -> Iterator[None]:
    """Let writing to standard output and standard error never fail in this context.

    Raises
    ------
    OSError : at its end, if standard output was lost though somebody reads it: the disk is full
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
