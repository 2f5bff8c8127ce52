"""Write the table of a render's options into docs/guide.md, between its markers.

    python tools/make_options.py

The table says what `python -m photonmap --help` says, and how `photonmap.render` names the options.
"""

from __future__ import annotations

from argparse import Action
from pathlib import Path
from typing import Any

from photonmap.commands.main import DEFAULT, parser_of
from photonmap.settings import OPTIONS

GUIDE = Path(__file__).parents[1] / "docs" / "guide.md"
BEGIN, END = "<!-- options -->", "<!-- /options -->"


def options_table() -> str:
    """Return the options of a render in Markdown: command line, keyword in Python, meaning."""
    lines = ["| command line | `pm.render` | meaning |", "|---|---|---|"]
    positional, general, *groups = parser_of(DEFAULT)._action_groups
    for action in (
        each for group in (positional, *groups, general) for each in group._group_actions
    ):
        if action.dest in ("help", "version"):
            continue
        option = OPTIONS.get(action.dest)
        keyword = "" if option is None else _keyword(option.name, option.default)
        text = (action.help or "").replace("%%", "%").replace("|", "\\|")
        lines.append(f"| `{_invocation(action)}` | {keyword} | {text} |")
    lines += [
        f"| | {_keyword(option.name, option.default)} | {option.help} |"
        for option in OPTIONS.values()
        if option.group is None
    ]
    return "\n".join(lines)


def _keyword(name: str, default: Any) -> str:
    """Return a keyword with its default as Python writes it."""
    return f"`{name}={default!r}`".replace("'", '"')


def _invocation(action: Action) -> str:
    """Return how an argument is written: `--size WxH`, `-o, --output FILE`, `SCENE`."""
    flags, metavar = ", ".join(action.option_strings), action.metavar
    if action.choices:
        metavar = "\\|".join(action.choices)
    if action.nargs == 0 or metavar is None:
        return flags
    value = f"[{metavar}]" if action.nargs == "?" else metavar
    return f"{flags} {value}".strip()


def insert(text: str, table: str) -> str:
    """Return a page with the table between its markers."""
    head, _, rest = text.partition(BEGIN)
    _, _, tail = rest.partition(END)
    return f"{head}{BEGIN}\n{table}\n{END}{tail}"


if __name__ == "__main__":
    GUIDE.write_text(insert(GUIDE.read_text(encoding="utf-8"), options_table()), encoding="utf-8")
