"""Docstrings as the site shows them: sections "Parameters", "Returns", "Raises" become lists.

An extension of griffe, which reads the docstrings for mkdocstrings. Ours give what a parameter is
where numpydoc has its type, because the signature has the type.
"""

from __future__ import annotations

import inspect
import re
from typing import Any

import griffe

_SECTION = re.compile(r"^(?P<title>[A-Z]\w+)\n-{3,}\n", re.M)
_ENTRY = re.compile(r"^(?P<name>[\w*][^:\n]*?) : ", re.M)


class Lists(griffe.Extension):
    """Rewrites the docstring of everything that is documented."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrite one docstring."""
        if obj.docstring is not None:
            obj.docstring.value = as_markdown(obj.docstring.value)


def as_markdown(docstring: str) -> str:
    r"""Return a docstring with its sections as titles in bold and lists.

    Examples
    --------
    >>> as_markdown("Say it.\n\nParameters\n----------\nname : of whom\n    or of what")
    'Say it.\n\n**Parameters**\n\n- `name`: of whom\n    or of what\n'
    """
    text, *rest = _SECTION.split(inspect.cleandoc(docstring))
    for title, body in zip(rest[::2], rest[1::2], strict=True):
        text += f"**{title}**\n\n{_listed(title, body)}\n"
    return text


def _listed(title: str, body: str) -> str:
    """Return the body of a section."""
    if title == "Examples":
        return f"```python\n{body.strip()}\n```\n"
    body = _ENTRY.sub(r"- `\g<name>`: ", body.strip())
    if title == "Raises":
        body = re.sub(r"^(\w+)\n +", r"- `\1`: ", body, flags=re.M)
    return body + "\n"
