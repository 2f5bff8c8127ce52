"""The one exception for bad input, the one channel for warnings, and what makes text safe."""

import json
import re
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from os import PathLike

_HIDDEN = re.compile(
    "[\x00-\x1f\x7f-\x9f"  # control characters, ESC among them, and line ends
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # what turns the direction of writing
    "\u200b\u2028\u2029\u2060-\u2065\u206a-\u206f\ufeff\U000e0000-\U000e007f"  # line ends, unseen
    "\ud800-\udfff]"  # halves of characters, which cannot be written
)
_LONGEST = 4000  # Characters of a message


def visible(text: str, kept: str = "") -> str:
    r"""Return a text that a terminal shows as it is: control characters and the like as JSON's.

    Also what turns the direction of writing, or is not seen, becomes an escape, as `\u202e`; but
    not the characters `kept`. Everything from a file passes here before it is printed.
    """

    def escaped(found: re.Match[str]) -> str:
        character = found[0]
        if character in kept:
            return character
        return "\\u007f" if character == "\x7f" else json.dumps(character)[1:-1]

    return _HIDDEN.sub(escaped, text)


def _one_line(message: str) -> str:
    """Return a message on one line that shows what it holds, cut off if it is very long."""
    line = visible(" ".join(message[: 4 * _LONGEST].split()))
    return line if len(line) <= _LONGEST else line[:_LONGEST] + "..."


Line = int | Callable[[], int | None] | None
"""A line of a file, or what finds it; None where it is not known."""


class InputError(ValueError):
    """Input that cannot be rendered, described in one line: file, line, value and remedy.

    Parameters
    ----------
    message : what is wrong and what to do about it, one line
    path : the file at fault, if any
    line : its line, counted from 1, if it is known; or what finds it, where that takes time
    """

    def __init__(
        self, message: str, path: str | PathLike[str] | None = None, line: Line = None
    ) -> None:
        line = line() if callable(line) else line
        self.names_file = path is not None
        place = "" if path is None else f"{path}: " if line is None else f"{path}:{line}: "
        super().__init__(visible(place) + _one_line(message))


@contextmanager
def naming(
    owner: str, path: str | PathLike[str] | None = None, line: Line = None
) -> Iterator[None]:
    """Prefix an `InputError` with the name of what is at fault, its file and line."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{visible(owner)}: {error}", path, line) from None


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


class _Heard(threading.local):
    """Who listens to the warnings of a thread, and what they are about."""

    def __init__(self) -> None:
        self.listeners: list[list[str]] = []
        self.owners: list[str] = []
        self.issues = True


_heard = _Heard()


def warn(message: str) -> None:
    """Issue a `SceneWarning`, also to everyone who listens."""
    message = _one_line(message)
    for messages in _heard.listeners:
        messages.append(message)
    if _heard.issues:
        text = ": ".join([*_heard.owners, message])
        warnings.warn(text, SceneWarning, stacklevel=_level_of_caller())


def repeat(messages: Iterable[str]) -> None:
    """Tell everyone who listens of warnings that were issued before, and are true again."""
    for each in _heard.listeners:
        each.extend(messages)


def _level_of_caller() -> int:
    """Return the stack level at which `warn` is seen to be called by code outside the package."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back and frame.f_globals.get("__name__", "").startswith("photonmap."):
        level, frame = level + 1, frame.f_back
    return level


@contextmanager
def naming_in_warnings(owner: str) -> Iterator[None]:
    """Prefix the warnings of this context with the name of what they are about, but for records."""
    _heard.owners.append(visible(owner))
    try:
        yield
    finally:
        _heard.owners.pop()


@contextmanager
def only_heard() -> Iterator[None]:
    """Issue no warning of this context; only who listens hears them."""
    before, _heard.issues = _heard.issues, False
    try:
        yield
    finally:
        _heard.issues = before


@contextmanager
def listening() -> Iterator[list[str]]:
    """Collect the messages of all warnings issued in this context, for the run record."""
    messages: list[str] = []
    _heard.listeners.append(messages)
    try:
        yield messages
    finally:
        others = [other for other in _heard.listeners if other is not messages]
        _heard.listeners[:] = others
