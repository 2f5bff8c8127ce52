"""Check that files can be written before the work that fills them."""

import tempfile
from os import PathLike
from pathlib import Path

from photonmap.errors import InputError


def check_writable(folder: Path, wanted: Path) -> None:
    """Check that a folder can be written to; the error names the wanted file.

    Raises
    ------
    InputError : it cannot
    """
    try:
        with tempfile.TemporaryFile(dir=folder):  # permissions alone do not suffice
            pass
    except OSError as error:
        reason = error.strerror or error
        message = f"cannot write to the folder {folder} ({reason}); choose another"
        raise InputError(message, wanted) from None


def check_output_folder(path: str | PathLike[str], contents: str) -> Path:
    """Check that a folder can be written to, or created where it is missing; return its path.

    Parameters
    ----------
    contents : what the folder is for, as in "the data set"

    Raises
    ------
    InputError : it is a file, or its parent is missing, or it cannot be written to
    """
    folder = Path(path)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"this is a file; choose a folder for {contents}", folder)
    parent = folder if folder.is_dir() else folder.parent
    if not parent.is_dir():
        raise InputError(f"the folder {parent} does not exist; create it", folder)
    check_writable(parent, folder)
    return folder
