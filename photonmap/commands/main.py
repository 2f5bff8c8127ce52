"""The command line: `python -m photonmap SCENE [options]`, or the name of another command."""

from __future__ import annotations

import argparse
import atexit
import errno
import re
import sys
import textwrap
import warnings
from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from photonmap.commands import BAD_INPUT, INTERRUPTED
from photonmap.errors import InputError, SceneWarning, visible
from photonmap.runtime.bounds import lacking
from photonmap.runtime.terminal import end_by, other_signals_as_ctrl_c, tolerant, tolerant_output
from photonmap.runtime.wording import suggest
from photonmap.runtime.writing import too_long

DEFAULT = "render"
"""The command where the first argument names none."""
COMMANDS = (
    "compile", "convert", "dataset", "evaluate", "info", "inspect", "merge", "sensor", "sensors",
    "split", "study",
)  # fmt: skip
"""The other commands: each a module here with HELP, add_arguments and run, which returns one of
`photonmap.commands`, or None."""
_WIDTH = 80  # columns of the first lines of the help
_BY_SIGNAL = 128  # what shells add to the number of the signal that ended a program


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    describe: Callable[[], str] | None = None
    """Makes the description, where that takes the imports of all commands."""

    def format_help(self) -> str:
        if self.describe is not None:
            self.description = self.describe()
        return super().format_help()

    def error(self, message: str) -> Any:
        unknown = re.match(r"unrecognized arguments: (--[^\s=]+)", message)
        if unknown:
            known = (name for name in self._option_string_actions if name.startswith("--"))
            meant = suggest(unknown[1], known)
            message = f"there is no option {unknown[1]}; {meant}" if "?" in meant else message
        raise InputError(f"{message} (see {self.prog} --help)")


def run_program() -> NoReturn:
    """Run the command line as a program, which ends by the signal that interrupted it."""
    codes: list[int] = []
    atexit.register(_end, codes)  # before all others, and so called after them
    codes.append(main())
    sys.exit(codes[0])


def _end(codes: list[int]) -> None:
    if codes and codes[0] > _BY_SIGNAL:
        end_by(codes[0] - _BY_SIGNAL)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return its exit code.

    0; 1 where part of a data set or an evaluation failed; 2 for bad input; 130 after Ctrl-C, 143
    after SIGTERM, whether there were complete passes to write or not.
    """
    warnings.showwarning = _show_warning
    with other_signals_as_ctrl_c() as received:
        code = _run(sys.argv[1:] if arguments is None else arguments)
    return _BY_SIGNAL + received.number if code == INTERRUPTED else code


def _run(arguments: list[str]) -> int:
    """Run a command; turn what it raises into a line on stderr and an exit code."""
    try:
        with tolerant_output():
            return _dispatch(arguments)
    except (InputError, OSError) as error:
        _print(f"error: {_in_words(error)}")
        return BAD_INPUT
    except MemoryError as error:
        _print(f"error: needs {lacking(error)}; close other programs, or ask for less")
        return BAD_INPUT
    except KeyboardInterrupt:
        _print("interrupted; nothing written")
        return INTERRUPTED


def _in_words(error: Exception) -> str:
    """Return what an error says, of the system's own for names in our words."""
    if isinstance(error, OSError) and error.errno == errno.ENAMETOOLONG:
        return too_long(str(error.filename or "a file"))
    return str(error)


def _print(line: str) -> None:
    print(f"photonmap: {visible(line)}", file=tolerant(sys.stderr))


def _dispatch(arguments: list[str]) -> int:
    """Run the command that the first argument names, or render; return the exit code."""
    name = arguments[0] if arguments and arguments[0] in COMMANDS else DEFAULT
    if name == DEFAULT and arguments:
        _check_scene(arguments[0])
    command = import_module(f"photonmap.commands.{name}")
    rest = arguments if name == DEFAULT else arguments[1:]
    return command.run(parser_of(name).parse_args(_join_negative(rest))) or 0


def _join_negative(arguments: list[str]) -> list[str]:
    """Join options with values that begin with a sign, as argparse wants: --origin=-1,2,3."""
    joined: list[str] = []
    for word in arguments:
        follows_option = joined and re.fullmatch(r"--[\w-]+", joined[-1])
        if follows_option and re.fullmatch(r"-(\.?\d.*|[xyz])", word):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def _check_scene(word: str) -> None:
    """Refuse a first argument that can be neither a command, an option nor a file of a scene."""
    if re.fullmatch(r"\w+", word) and not Path(word).exists():
        meant = suggest(word, (*COMMANDS, DEFAULT))
        if meant == suggest(DEFAULT, [DEFAULT]):
            meant = "to render, name the scene alone"
        raise InputError(
            f"there is no command {word!r}; {meant} (a scene is a file, as in room.obj)"
        )


def parser_of(name: str) -> argparse.ArgumentParser:
    """Return the parser of a command."""
    command = import_module(f"photonmap.commands.{name}")
    parser = _Parser(
        prog="python -m photonmap" + f" {name}" * (name != DEFAULT),
        description=command.HELP,
        allow_abbrev=False,
    )
    if name == DEFAULT:
        parser.usage = f"{parser.prog} SCENE [options]\n       {parser.prog} COMMAND [options]"
        parser.formatter_class = argparse.RawDescriptionHelpFormatter
        parser.describe = partial(_describe, command.HELP, parser.prog)
    command.add_arguments(parser)
    return parser


def _describe(summary: str, program: str) -> str:
    """Return what the first screen of the help says: commands, scenes and examples."""
    from photonmap.io.readers.registry import scene_suffixes

    others = {name: import_module(f"photonmap.commands.{name}").HELP for name in COMMANDS}
    commands = "\n".join(f"  {name:<9}{text}" for name, text in others.items())
    suffixes = ", ".join(scene_suffixes())
    return f"""{textwrap.fill(summary, _WIDTH)}
Writes FILE.exr (all buffers; or .nc, .hdf5, .hdr), FILE.png (preview) and FILE.json (run record).

commands (COMMAND --help lists the options of each):
{commands}

scenes:
  {suffixes}

examples:
  {program} room.obj --bands 6 --error 0.02 --output out/room.exr
  {program} part.stl --up z --size 800x600 --seconds 60"""


def _show_warning(message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
    prefix = "warning" if issubclass(category, SceneWarning) else category.__name__
    _print(f"{prefix}: {message}")
