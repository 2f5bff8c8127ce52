"""The one exception for bad input, and the one channel for warnings."""

import sys
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
        self.names_file = path is not None
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


@contextmanager
def naming_file(path: str | PathLike[str] | None) -> Iterator[None]:
    """Prefix an `InputError` that names no file with this one, if there is one."""
    try:
        yield
    except InputError as error:
        if path is None or error.names_file:
            raise
        raise InputError(str(error), path) from None


class SceneWarning(UserWarning):
    """Something in the input that was corrected, ignored or not simulated."""


_listeners: list[list[str]] = []
_owners: list[str] = []


def warn(message: str) -> None:
    """Issue a `SceneWarning`, also to everyone who listens."""
    message = " ".join(message.split())
    for messages in _listeners:
        messages.append(message)
    warnings.warn(": ".join([*_owners, message]), SceneWarning, stacklevel=_level_of_caller())


def _level_of_caller() -> int:
    """Return the stack level at which `warn` is seen to be called by code outside the package."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back and frame.f_globals.get("__name__", "").startswith("photonmap."):
        level, frame = level + 1, frame.f_back
    return level


@contextmanager
def naming_in_warnings(owner: str) -> Iterator[None]:
    """Prefix the warnings of this context with the name of what they are about, but for records."""
    _owners.append(owner)
    try:
        yield
    finally:
        _owners.pop()


@contextmanager
def listening() -> Iterator[list[str]]:
    """Collect the messages of all warnings issued in this context, for the run record."""
    messages: list[str] = []
    _listeners.append(messages)
    try:
        yield messages
    finally:
        _listeners[:] = [other for other in _listeners if other is not messages]
