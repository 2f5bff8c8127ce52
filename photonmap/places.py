"""Whether files can be written to a folder, asked before the work that fills them."""

import tempfile
from pathlib import Path

from photonmap.errors import InputError


def check_writable(folder: Path, wanted: Path) -> None:
    """Check that a folder can be written to; the error names what is wanted there.

    Raises
    ------
    InputError : it cannot
    """
    try:
        with tempfile.TemporaryFile(dir=folder):  # permissions alone do not tell
            pass
    except OSError as error:
        reason = error.strerror or error
        message = f"cannot write to the folder {folder} ({reason}); choose another"
        raise InputError(message, wanted) from None
