"""Which files Python opens, by its audit events; what libraries open by themselves is not seen."""

import os
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

import photonmap as pm

_opened, _watchers = [], []
SYSTEM = "/dev/null", "/proc", "/sys", "/usr/share", str(Path.home() / ".cache")
"""What libraries read when they are imported, or of the machine"""


def _note(event, arguments):
    if event == "open" and _watchers and isinstance(arguments[0], str | bytes | os.PathLike):
        _opened.append(os.path.realpath(os.fsdecode(arguments[0])))


sys.addaudithook(_note)  # for as long as Python runs


@contextmanager
def opening_only_in(folder):
    """Assert that only files in a folder, temporary ones, Python's and photonmap's are opened."""
    ours = Path(pm.__file__).parents[1], os.environ.get("NUMBA_CACHE_DIR", folder)
    places = folder, tempfile.gettempdir(), sys.prefix, sys.base_prefix, *ours, *SYSTEM
    inside = tuple(os.path.realpath(place) + end for place in places for end in ("", os.sep))
    _opened.clear()
    _watchers.append(folder)
    try:
        yield
    finally:
        _watchers.pop()
        strays = [path for path in _opened if not (path in inside or path.startswith(inside[1::2]))]
        assert not strays, f"opened outside: {strays}"
