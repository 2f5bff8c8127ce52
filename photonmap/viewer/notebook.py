"""A render in a notebook whose picture gets better in place."""

from __future__ import annotations

from os import PathLike
from typing import Any

from photonmap.buffers import names_where, row_of
from photonmap.errors import InputError
from photonmap.io.png import encode_png
from photonmap.render import render
from photonmap.results.preview import as_bytes
from photonmap.results.result import Result
from photonmap.runtime.wording import shown, suggest
from photonmap.scene.scene import Scene

SIZE, SECONDS = (320, 240), 20.0
"""Default settings of a preview."""
_BUDGETS = {"passes", "seconds", "error"}


def preview(scene: Scene | str | PathLike[str], buffer: str = "radiance", **options: Any) -> Result:
    """Render in a notebook, where the picture gets better in place; interrupt it when it will do.

    Parameters
    ----------
    scene : see `photonmap.render`
    buffer : which one is shown; any with bands
    options : of `photonmap.render`; by default 320 × 240 pixels and 20 seconds

    Returns
    -------
    the result, as `photonmap.render` returns it

    Raises
    ------
    InputError : IPython is not installed, or as `photonmap.render` says
    """
    try:
        from IPython.display import Image, display
    except ImportError:
        raise InputError(
            "pm.preview shows pictures in a notebook and needs IPython: pip install ipython"
        ) from None
    row = row_of(buffer)
    if row is None or not row.is_banded:
        known = suggest(buffer, names_where(is_banded=True))
        raise InputError(f"buffer {shown(buffer)} has no bands that could be shown; {known}")
    place = None

    def show(result: Result) -> None:
        nonlocal place
        picture = Image(data=picture_of(result, buffer))
        if place is None:
            place = display(picture, display_id=True)
        else:
            place.update(picture)

    given = {"size": SIZE, **options}
    if not _BUDGETS & options.keys():
        given["seconds"] = SECONDS
    result = render(scene, watch=show, **given)
    show(result)
    return result


def picture_of(result: Result, buffer: str) -> bytes:
    """Return a buffer as PNG, light at the exposure of the preview.

    Raises
    ------
    ValueError : there is no such buffer, or it has no bands
    """
    image = result.rgb(buffer)
    is_light = buffer != "reflectance" and "radiance" in result.buffers
    return encode_png(as_bytes(image, result.exposure if is_light else 1.0))
