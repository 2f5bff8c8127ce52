"""A table of an experiment, as the page, CSV and LaTeX show it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple


class Cell(NamedTuple):
    """A figure of a table."""

    value: float | None
    """None where there is none"""
    note: str = ""
    """small print, such as an interval"""


@dataclass(frozen=True)
class Table:
    """A table of an experiment.

    Parameters
    ----------
    name : of its files and its anchor on the page
    title : above it
    meaning : what it shows and how it was measured
    heads : of the columns, that of the rows' names first
    rows : name and figures, as many as `heads` asks for
    findings : sentences on what it shows, computed from it
    """

    name: str
    title: str
    meaning: str
    heads: Sequence[str]
    rows: Sequence[tuple[str, Sequence[Cell]]]
    findings: Sequence[str] = ()
