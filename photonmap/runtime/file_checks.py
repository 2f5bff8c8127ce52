"""Check that files can be written before the work that fills them."""

import tempfile
from os import PathLike
from pathlib import Path

from photonmap.errors import InputError

FULL = ("No space left", "MB are free there", "quota exceeded")
"""What the messages of a full disk have in them, OpenEXR's among them."""


def check_writable(folder: Path, wanted: Path) -> None:
    """Check that a folder can be written to, or made; the error names the wanted file.

    Raises
    ------
    InputError : it cannot
    """
    nearest = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    try:
        with tempfile.TemporaryFile(dir=nearest):  # permissions alone do not suffice
            pass
    except OSError as error:
        reason = error.strerror or error
        message = f"cannot write to the folder {nearest} ({reason}); choose another"
        raise InputError(message, wanted) from None


def check_output_folder(path: str | PathLike[str], contents: str) -> Path:
    """Check that a folder can be written to, or made; return its path.

    Parameters
    ----------
    contents : what the folder is for, as in "the data set"

    Raises
    ------
    InputError : it is a file, or it cannot be written to
    """
    folder = Path(path)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"this is a file; choose a folder for {contents}", folder)
    check_writable(folder, folder)
    return folder
