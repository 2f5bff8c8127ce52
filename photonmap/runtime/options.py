"""Lists of options: how each is documented, written on the command line, read and checked.

A list of options is a frozen dataclass whose fields are `option(…)`.
"""

from __future__ import annotations

import functools
import inspect
import sys
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from numbers import Integral, Real
from typing import Any, Concatenate, ParamSpec, TypeVar

from photonmap.errors import InputError
from photonmap.runtime.wording import shown, suggest

LARGEST_SIDE = 1 << 16
"""Largest width and height of an image, pixels."""

P = ParamSpec("P")
R = TypeVar("R")
Subject = TypeVar("Subject")
Options = TypeVar("Options")

_WIDTH = 100
"""Columns of generated documentation."""


@dataclass(frozen=True, kw_only=True)
class Option:
    """How one option is documented, written on the command line, and checked."""

    help: str  # what it does, without a full stop
    name: str = ""  # its keyword in Python
    default: Any = None  # the value where it is left out
    default_text: str = ""  # the default in words, where the value does not say it
    short: str = ""  # letter that stands for its flag on the command line, if any
    written: str = ""  # what is special about it on the command line
    group: str | None = None
    """heading under which the command line lists it; None if it cannot be given there"""
    metavar: str | None = None  # placeholder for its value in help texts
    read: Callable[[str], Any] | None = None  # text on the command line → value
    bare: Any = None  # value of a flag that stands alone, where it may
    choices: tuple[str, ...] = ()  # all permitted values
    whole: tuple[int, int] | None = None  # (least, greatest) permitted whole number
    check: Callable[[Any], Any] | None = None
    """value → the form in which a render uses it; raises `InputError`"""
    decides: bool = False
    """whether the arrays depend on it: it is then in the run record and the fingerprint"""
    commands: tuple[str, ...] = ("render",)  # those that take it

    @property
    def flag(self) -> str:
        """The flag on the command line; of an option that is on by default, to turn it off."""
        return ("--no-" if self.default is True else "--") + self.name.replace("_", "-")

    def checked(self, value: Any) -> Any:
        """Return a value in the form in which a render uses it; others are an `InputError`."""
        if value is None and self.default is None:
            return None
        if isinstance(self.default, bool):
            if value not in (True, False):
                raise InputError(f"{self.name} {shown(value)} is neither True nor False")
            return bool(value)
        if self.choices and value not in self.choices:
            known = " nor ".join(map(repr, self.choices))
            raise InputError(f"{self.name} {shown(value)} is neither {known}")
        if self.whole is not None:
            low, high = self.whole
            whole = isinstance(value, Integral)
            if not (whole and low <= value <= high):
                raise InputError(
                    f"{self.name} {shown(value)} must be a whole number from {low} to {high}"
                )
        return value if self.check is None else self.check(value)


def option(default: Any, help: str, **traits: Any) -> Any:
    """Return the field of a dataclass that is an option; see `Option` for its traits."""
    return field(default=default, metadata={"option": Option(help=help, **traits)})


def list_options(options: Any) -> dict[str, Option]:
    """Return the options that a dataclass lists, by name."""
    return {
        each.name: replace(each.metadata["option"], name=each.name, default=each.default)
        for each in fields(options)
    }


def read_size(text: str) -> tuple[int, int]:
    """Read "640x480", or "512" for a square; another form is an `InputError`."""
    width, cross, height = text.lower().partition("x")
    height = height if cross else width
    if not (width.strip().isdecimal() and height.strip().isdecimal()):
        raise InputError(f"{shown(text)} is not a size; write it as 640x480")
    return int(width), int(height)


def check_bytes(memory: float | str) -> float:
    """Return a number of bytes, also of "4G" or the like; `InputError` unless finite, above 0."""
    count = read_memory(memory) if isinstance(memory, str) else memory
    if not isinstance(count, Real) or not 0.0 < count <= sys.float_info.max:
        raise InputError(f"memory {shown(memory)} must be a number of bytes above 0")
    return float(count)


def check_size(size: tuple[int, int] | int) -> tuple[int, int]:
    """Return (width, height) as integers, of two numbers or of the side of a square.

    Anything else, an image without pixels, or one with too many is an `InputError`.
    """
    sides = (size, size) if isinstance(size, Integral) else size
    if not isinstance(sides, Sequence) or len(sides) != 2:
        raise InputError(f"size {shown(size)} is not (width, height), as in (640, 480)")
    width, height = sides
    if not all(isinstance(side, Integral) for side in sides) or min(sides) < 1:
        raise InputError(f"size {width}x{height} must be whole pixels, at least 1x1")
    if max(sides) > LARGEST_SIDE:
        raise InputError(f"size {width}x{height} is too large: at most {LARGEST_SIDE} per side")
    return int(width), int(height)


def read_memory(text: str) -> float:
    """Read "4G" or "512M" into bytes, units powers of 1024; another form is an `InputError`."""
    power = " KMGT".find(text[-1:].upper() or " ")
    try:
        return float(text[:-1] if power > 0 else text) * 1024 ** max(power, 0)
    except ValueError:
        raise InputError(
            f"{shown(text)} is not an amount of memory; write it as 4G or 512M"
        ) from None


def read_list(names: str | Iterable[Any]) -> list[Any]:
    """Return names in a list; of a text, those between its commas; `InputError` for others."""
    if isinstance(names, str):
        return [each.strip() for each in names.split(",")]
    if not isinstance(names, Iterable):
        raise InputError(f"{shown(names)} is no list of names; give them as in ['one', 'two']")
    return list(names)


def taking_keywords_of(
    options: Callable[P, Options],
) -> Callable[[Callable[[Subject, Options], R]], Callable[Concatenate[Subject, P], R]]:
    """Return a decorator by which a function takes each field of a dataclass as a keyword.

    The dataclass lists options. The decorated function has two parameters, and the second is an
    instance of it; names, types and defaults of the fields take its place in the signature, and
    their help texts the place of its line in the documentation.
    """

    def decorate(
        function: Callable[[Subject, Options], R],
    ) -> Callable[Concatenate[Subject, P], R]:
        subject, replaced = inspect.signature(function).parameters.values()
        keywords = inspect.signature(options).parameters.values()
        signature = inspect.signature(function).replace(parameters=[subject, *keywords])

        @functools.wraps(function)
        def wrapper(*args: Any, **given: Any) -> R:
            _check_keywords(function.__name__, given, signature.parameters)
            values = signature.bind(*args, **given).arguments
            return function(values.pop(subject.name), options(**values))  # type: ignore[call-arg]

        wrapper.__signature__ = signature  # type: ignore[attr-defined]
        wrapper.__doc__ = _document(function.__doc__, replaced.name, list_options(options))
        return wrapper

    return decorate


def _check_keywords(owner: str, given: Iterable[str], known: Mapping[str, Any]) -> None:
    """Raise `TypeError` with the keyword that was meant, which Python does from 3.13 on."""
    if unknown := [name for name in given if name not in known]:
        meant = suggest(unknown[0], known)
        raise TypeError(f"{owner} got an unexpected keyword argument {unknown[0]!r}; {meant}")


def _document(text: str | None, replaced: str, options: dict[str, Option]) -> str | None:
    """Return a docstring with a line for each option in place of that for all of them."""
    if text is None:  # python -OO
        return None
    head, _, tail = text.partition(f"    {replaced} : ")
    texts = (
        f"{name} : {each.help}" + f"; default: {each.default_text}" * bool(each.default_text)
        for name, each in options.items()
    )
    lines = [textwrap.fill(text, _WIDTH - 4, subsequent_indent=" " * 4) for text in texts]
    described = textwrap.indent("\n".join(lines), " " * 4)
    return head + described + "\n" + tail.partition("\n")[2]
