"""Read the options of texture maps in MTL files.

After D. Ramey, L. Rose and L. Tyerman, "MTL material format (Lightwave, OBJ)", 1995.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from photonmap.errors import InputError
from photonmap.runtime.wording import shown, suggest

Triple = tuple[float, float, float]

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_TRIPLES = {"-s": 1.0, "-o": 0.0, "-t": 0.0}
"""Options of one to three numbers, and the default of those left out."""
_NUMBERS = {"-mm": (0.0, 1.0), "-bm": (1.0,), "-boost": (0.0,), "-texres": ()}
"""Options of numbers, and the values at which they change nothing; `-texres` never does."""
_SWITCHES = {"-clamp": "off", "-blendu": "on", "-blendv": "on", "-cc": "off"}
_SIDES = ("front", "back", "top", "bottom", "left", "right")
_WORDS = {
    "-imfchan": ("r", "g", "b", "m", "l", "z"),
    "-type": ("sphere", *(f"cube_{side}" for side in _SIDES)),
}
OPTIONS = (*_TRIPLES, *_NUMBERS, *_SWITCHES, *_WORDS)


@dataclass(frozen=True)
class MapOptions:
    """How a texture lies on a surface.

    The texture is looked up at `scale` · (u, v, w) + `offset`.

    Parameters
    ----------
    scale : `-s`
    offset : `-o`
    clamp : `-clamp`, the texture ends at the unit square; otherwise it repeats
    bump : `-bm`, by which heights are multiplied
    ignored : options that would change the picture but are not simulated, such as "-mm"
    """

    scale: Triple = (1.0, 1.0, 1.0)
    offset: Triple = (0.0, 0.0, 0.0)
    clamp: bool = False
    bump: float = 1.0
    ignored: tuple[str, ...] = ()


def parse_map(words: str | Sequence[str]) -> tuple[MapOptions, str]:
    """Read what follows `map_Kd` and similar keywords.

    Parameters
    ----------
    words : options and a file name; given as one text, the name keeps its spaces

    Returns
    -------
    the options, and the file name

    Raises
    ------
    InputError : an option is unknown or lacks its arguments, or no file is named; file and
        line are the caller's to add
    """
    text = (words if isinstance(words, str) else " ".join(words)).strip()
    triples = {option: (default,) * 3 for option, default in _TRIPLES.items()}
    clamp, bump = False, 1.0
    ignored: dict[str, None] = {}
    while text.startswith("-"):
        option, text = _pop(text)
        if option not in OPTIONS:
            message = f"option {shown(option)} is not known"
            raise InputError(f"{message}; {suggest(option, OPTIONS)}")
        if option in _TRIPLES:
            triples[option], text = _read_triple(option, text)
            changes = option == "-t" and any(triples[option])
        elif option in _NUMBERS:
            numbers, text = _read_numbers(option, text)
            changes = numbers != _NUMBERS[option]
        else:
            word, text = _read_word(option, text)
            changes = word != _SWITCHES.get(option)
        if option == "-clamp":
            clamp = word == "on"
        elif option == "-bm":
            bump = numbers[0]
        elif changes:
            ignored[option] = None
        else:
            ignored.pop(option, None)
    if not text:
        raise InputError("names no file; write one after the options")
    return MapOptions(triples["-s"], triples["-o"], clamp, bump, tuple(ignored)), text


def _pop(text: str) -> tuple[str, str]:
    """Split a text at its first word."""
    word, *rest = text.split(maxsplit=1)
    return word, rest[0] if rest else ""


def _pop_number(option: str, text: str) -> tuple[float | None, str]:
    """Split a text at its first word if that is a number."""
    word, rest = _pop(text) if text else ("", "")
    if not _NUMBER.fullmatch(word):
        return None, text
    if not math.isfinite(float(word)):
        raise InputError(f"{option} {shown(word)} is too large; write a smaller number")
    return float(word), rest


def _read_triple(option: str, text: str) -> tuple[Triple, str]:
    """Read one to three numbers."""
    numbers: list[float] = []
    while len(numbers) < 3:
        number, text = _pop_number(option, text)
        if number is None:
            break
        numbers.append(number)
    if not numbers:
        raise _lacks(option, "one to three numbers", text)
    first, second, third = (*numbers, *([_TRIPLES[option]] * (3 - len(numbers))))
    return (first, second, third), text


def _read_numbers(option: str, text: str) -> tuple[tuple[float, ...], str]:
    """Read as many numbers as the option has."""
    numbers: list[float] = []
    count = max(len(_NUMBERS[option]), 1)
    for _ in range(count):
        number, rest = _pop_number(option, text)
        if number is None:
            raise _lacks(option, f"{count} number{'s' * (count > 1)}", text)
        numbers.append(number)
        text = rest
    return tuple(numbers), text


def _read_word(option: str, text: str) -> tuple[str, str]:
    """Read a word that is among those of the option."""
    known = ("on", "off") if option in _SWITCHES else _WORDS[option]
    word, rest = _pop(text) if text else ("", "")
    if word.lower() not in known:
        raise _lacks(option, f"{', '.join(known[:-1])} or {known[-1]}", text)
    return word.lower(), rest


def _lacks(option: str, needed: str, text: str) -> InputError:
    found = shown(_pop(text)[0]) if text else "nothing"
    return InputError(f"{option} is followed by {found}; write {needed} after it")
