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

    def line(self, *names: str) -> int | None:
        """Find the line of the section or key that this way of names leads to."""
        at = 0
        for name in names:
            pattern = rf"(?<![\w-]){re.escape(name)}[\"']?[ \t]*[=.\]]"
            found = re.compile(pattern).finditer(self.text, at)
            start = next((m.start() for m in found if not self._is_comment(m.start())), None)
            if start is None:
                return None
            at = start + len(name)
        return self.text.count("\n", 0, at) + 1

    def _is_comment(self, at: int) -> bool:
        return "#" in self.text[self.text.rfind("\n", 0, at) + 1 : at]

    def error(self, message: str, *names: str) -> InputError:
        """Say what is wrong with the section or key that this way of names leads to."""
        return InputError(message, self.path, self.line(*names))

    def check_known(self, known: Collection[str], kind: str, *way: str) -> None:
        """Raise `InputError` if a section's key, or a section, is not among the known ones."""
        section = self.sections
        for name in way:
            section = section[name]
        for name in section:
            if name not in known:
                message = f"{kind} {shown(name)} is not known; {suggest(name, known)}"
                raise self.error(message, *way, name)


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
