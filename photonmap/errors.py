"""The one exception for bad input, and the one channel for warnings."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike


class InputError(ValueError):
    """Input that cannot be rendered, described in one line: file, line, value and remedy.

    Parameters
    ----------
    message : what is wrong and what to do about it, one line
    path : the file at fault, if any
    line : its line, counted from 1, if it is known
    """

    def __init__(
        self, message: str, path: str | PathLike[str] | None = None, line: int | None = None
    ) -> None:
        location = "" if path is None else f"{path}: " if line is None else f"{path}:{line}: "
        super().__init__(location + " ".join(message.split()))


@contextmanager
def naming(
    owner: str, path: str | PathLike[str] | None = None, line: int | None = None
) -> Iterator[None]:
    """Prefix an `InputError` with the name of what is at fault, its file and line."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{owner}: {error}", path, line) from None


class SceneWarning(UserWarning):
    """Something in the input that was corrected, ignored or not simulated."""


_listeners: list[list[str]] = []


def warn(message: str) -> None:
    """Issue a `SceneWarning`, also to everyone who listens."""
    message = " ".join(message.split())
    for messages in _listeners:
        messages.append(message)
    warnings.warn(message, SceneWarning, stacklevel=3)


@contextmanager
def listening() -> Iterator[list[str]]:
    """Collect the messages of all warnings issued in this context, for the run record."""
    messages: list[str] = []
    _listeners.append(messages)
    try:
        yield messages
    finally:
        _listeners[:] = [other for other in _listeners if other is not messages]
