"""The wording of messages: values, lists of names, and suggestions for misspelt names."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Sequence
from dataclasses import fields
from itertools import islice
from typing import Any

from photonmap.errors import visible

_LENGTH = 60
"""Characters of a text that are shown."""
_CHOICES = 12
"""Names that are listed where none is near."""
_NEAR = 0.5
"""Similarity from which on a name may have been meant, by `difflib`."""
_NEAR_WORD = 0.75
"""Similarity to one word of a name from which on that may have been meant."""


def shown(value: object) -> str:
    """Return a value quoted, truncated to a readable length; backslashes of a text stay single."""
    if isinstance(value, str) and len(value) > _LENGTH:
        value = value[:_LENGTH] + "..."
    try:
        text = repr(value)
    except ValueError:
        return "a number of thousands of digits"
    text = text.replace("\\\\", "\\") if isinstance(value, str) else text
    return text if len(text) <= 2 * _LENGTH else text[:_LENGTH] + "..."


def brief(described: Any) -> str:
    """Return the repr of a dataclass with arrays as their shapes, as in "<64×128×3 array>"."""
    values = ((each.name, getattr(described, each.name)) for each in fields(described))
    inside = ", ".join(f"{name}={_brief_value(value)}" for name, value in values)
    return f"{type(described).__name__}({inside})"


def _brief_value(value: Any) -> str:
    shape = getattr(value, "shape", None)
    return repr(value) if shape is None else f"<{'×'.join(map(str, shape))} array>"


def listed(names: Iterable[str], limit: int = 8) -> str:
    """Return names quoted, the first few of them."""
    return enumerated([shown(name) for name in names], limit)


def enumerated(texts: Collection[str], limit: int = 8) -> str:
    """Return texts as a terminal may show them, the first few of them."""
    more = f" and {len(texts) - limit} more" if len(texts) > limit else ""
    return ", ".join(map(visible, islice(texts, limit))) + more


def suggest(name: object, known: Iterable[str]) -> str:
    """Return the question whether the nearest known name was meant, or which there are."""
    candidates = {candidate[:_LENGTH].lower(): candidate for candidate in list(known)[:1000]}
    nearest = _nearest(name[:_LENGTH].lower(), candidates) if isinstance(name, str) else None
    if nearest is not None:
        return f"did you mean {shown(candidates[nearest])}?"
    choice = listed(candidates.values(), _CHOICES)
    return f"choose from {choice}" if candidates else "correct the name"


def _nearest(name: str, candidates: Iterable[str]) -> str | None:
    """Return the candidate most alike as a whole, or else in a word of it; None if none is near.

    Of several that are equally near, one with the same letters in another order, or else the last
    by the alphabet: for "D66" that is "D65", not "D60".
    """
    for has_words, least in ((False, _NEAR), (True, _NEAR_WORD)):
        parts = {each: each.split() if has_words else [each] for each in candidates}
        scores = {
            candidate: max((_likeness(name, word) for word in words), default=0.0)
            for candidate, words in parts.items()
        }
        best = max(scores.values(), default=0.0)
        if best >= least:
            tied = [candidate for candidate, score in scores.items() if score == best]
            return max(tied, key=lambda each: (_likeness(sorted(name), sorted(each)), each))
    return None


def _likeness(one: Sequence[str], other: Sequence[str]) -> float:
    """Return the similarity of two texts or lists of letters, by `difflib`, from 0 to 1."""
    return difflib.SequenceMatcher(a=other, b=one).ratio()
