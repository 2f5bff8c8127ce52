"""The command line: `python -m photonmap SCENE [options]`, or the name of another command."""

from __future__ import annotations

import argparse
import sys
import warnings
from importlib import import_module
from typing import Any, TextIO

from photonmap.errors import InputError, SceneWarning

BAD_INPUT, INTERRUPTED = 2, 130
"""Exit codes."""

DEFAULT = "render"
"""The command where the first argument names none."""
COMMANDS = ("convert", "dataset", "evaluate", "info", "merge", "sensors", "split", "study")
"""The other commands: each a module here with HELP, add_arguments and run, which returns an exit
code, or None for 0."""


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> Any:
        raise InputError(f"{message} (see {self.prog} --help)")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Returns
    -------
    0; 1 where part of a data set or an evaluation failed; 2 for bad input; 130 for Ctrl-C before
    the first pass
    """
    warnings.showwarning = _show_warning
    try:
        return _dispatch(sys.argv[1:] if arguments is None else arguments)
    except InputError as error:
        print(f"photonmap: error: {error}", file=sys.stderr)
        return BAD_INPUT
    except (OSError, MemoryError) as error:
        print(f"photonmap: error: {error or 'out of memory'}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("photonmap: interrupted; nothing written", file=sys.stderr)
        return INTERRUPTED


def _dispatch(arguments: list[str]) -> int:
    """Run the command that the first argument names, or render; return the exit code."""
    name = arguments[0] if arguments and arguments[0] in COMMANDS else DEFAULT
    command = import_module(f"photonmap.commands.{name}")
    rest = arguments if name == DEFAULT else arguments[1:]
    return command.run(parser_of(name).parse_args(rest)) or 0


def parser_of(name: str) -> argparse.ArgumentParser:
    """Return the parser of a command."""
    command = import_module(f"photonmap.commands.{name}")
    parser = _Parser(
        prog="python -m photonmap" + f" {name}" * (name != DEFAULT),
        description=command.HELP,
        allow_abbrev=False,
    )
    if name == DEFAULT:
        others = ", ".join(f"{parser.prog} {other} --help" for other in COMMANDS)
        parser.epilog = (
            "Writes FILE.exr (all buffers), FILE.png (preview) and FILE.json (run record). Other "
            f"commands: {others}."
        )
    command.add_arguments(parser)
    return parser


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    prefix = "warning" if issubclass(category, SceneWarning) else category.__name__
    print(f"photonmap: {prefix}: {message}", file=sys.stderr)
