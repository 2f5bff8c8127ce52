"""A TOML file with a way back to the lines of its keys."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from photonmap.errors import InputError
from photonmap.messages import shown, suggest


@dataclass(frozen=True)
class Toml:
    """A parsed file.

    Parameters
    ----------
    path : the file
    text : what it holds
    sections : the same, parsed
    """

    path: Path
    text: str
    sections: dict[str, Any]

    def line(self, *names: str | int) -> int | None:
        """Find the line of the section or key that this way of names leads to.

        A number, from 0, counts the sections `[[NAME]]` of the name before it.
        """
        at, last = 0, ""
        for name in names:
            if isinstance(name, int):
                start = self._header(last, name)
            else:
                pattern = rf"(?<![\w-]){re.escape(name)}[\"']?[ \t]*[=.\]]"
                start, last = self._find(pattern, at), name
            if start is None:
                return None
            at = start + len(last)
        return self.text.count("\n", 0, at) + 1

    def _find(self, pattern: str, at: int) -> int | None:
        """Find where a pattern begins, from a place on, outside of comments."""
        found = re.compile(pattern).finditer(self.text, at)
        return next((m.start() for m in found if not self._is_comment(m.start())), None)

    def _header(self, name: str, index: int) -> int | None:
        """Find a section `[[NAME]]`, or else where the array of that name is written out."""
        pattern = rf"^[ \t]*\[\[[ \t]*[\"']?{re.escape(name)}[\"']?[ \t]*\]\]"
        found = [match.end() - 2 for match in re.finditer(pattern, self.text, re.MULTILINE)]
        if index < len(found):
            return found[index] - len(name)
        return self._find(rf"(?<![\w-]){re.escape(name)}[ \t]*=", 0)

    def _is_comment(self, at: int) -> bool:
        return "#" in self.text[self.text.rfind("\n", 0, at) + 1 : at]

    def error(self, message: str, *names: str | int) -> InputError:
        """Say what is wrong with the section or key that this way of names leads to."""
        return InputError(message, self.path, self.line(*names))

    def check_known(self, known: Collection[str], kind: str, *way: str | int) -> None:
        """Raise `InputError` if a section's key, or a section, is not among the known ones."""
        section: Any = self.sections
        for step in way:
            section = section[step]
        for name in section:
            if name not in known:
                message = f"{kind} {shown(name)} is not known; {suggest(name, known)}"
                raise self.error(message, *way, name)


def as_text(value: Any) -> str:
    """Write a TOML value as a colour's text."""
    numbers = value if isinstance(value, list) else [value]
    if isinstance(value, str):
        return value
    if len(numbers) not in (1, 3) or any(type(number) not in (int, float) for number in numbers):
        raise InputError(f"{shown(value)} is no colour; write a number, three, or a text")
    return repr(value) if value is numbers[0] else "rgb:" + ",".join(map(repr, numbers))


def read_toml(path: Path) -> Toml:
    """Read a TOML file; a missing one counts as empty.

    Raises
    ------
    InputError : the file cannot be read, or is no TOML
    """
    text = _read_text(path)
    try:
        return Toml(path, text, tomllib.loads(text))
    except (ValueError, RecursionError) as error:
        reason, _, place = str(error).partition(" (at ")
        found = re.match(r"line (\d+)", place)
        line = int(found[1]) if found else len(text.splitlines()) if place else None
        raise InputError(f"is not valid TOML: {reason}; mend it", path, line) from None


def _read_text(path: Path) -> str:
    """Read UTF-8; a missing file counts as empty."""
    try:
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        return ""
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror}); check the file", path) from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise InputError("is not in UTF-8; save it so", path, line) from None
