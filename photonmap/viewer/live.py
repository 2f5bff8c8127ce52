"""A render watched while it gets better: in place in a notebook, or in the viewer tev."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from photonmap.buffers import names_where, row_of
from photonmap.errors import InputError, warn
from photonmap.io.png import encode_png
from photonmap.results.preview import as_bytes
from photonmap.runtime.wording import shown, suggest

if TYPE_CHECKING:
    from photonmap.results.result import Result
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
    from photonmap.render import render

    try:
        from IPython.display import Image, display
    except ImportError:
        problem = "pm.preview shows pictures in a notebook and needs IPython"
        raise InputError(f"{problem}: pip install ipython") from None
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
    """Return a buffer as PNG, light at the exposure of the preview."""
    image = result.rgb(buffer)
    is_light = buffer != "reflectance" and "radiance" in result.buffers
    return encode_png(as_bytes(image, result.exposure if is_light else 1.0))


ADDRESS = "localhost:14158"
"""Where tev listens by default."""
_SHOWN = ("radiance", "direct", "indirect", "shading", "reflectance")


class Tev:
    """Sends buffers in linear sRGB to HOST:PORT; see `--view`. Where no tev runs, it warns once.

    `name` is what tev calls the image.
    """

    def __init__(self, name: str, address: str = ADDRESS) -> None:
        try:
            import tevclient
        except ImportError:
            raise InputError("--view needs tevclient: pip install 'photonmap[view]'") from None
        host, _, port = address.rpartition(":")
        if not host or not port.isdecimal() or not 0 < int(port) < 1 << 16:
            raise InputError(f"--view {address} must be HOST:PORT, as in {ADDRESS}")
        self._name, self._address = name, address
        self._client = tevclient.Ipc(host, int(port))
        self._reachable, self._channels = True, list[str]()
        try:
            self._client.__enter__()
        except OSError as error:
            self._give_up(error)

    def __call__(self, result: Result) -> None:
        """Show a result, in place of the last one."""
        if not self._reachable:
            return
        images = {name: result.rgb(name) for name in _SHOWN if name in result}
        layers = {"" if name == "radiance" else f"{name}.": rgb for name, rgb in images.items()}
        channels = [f"{layer}{channel}" for layer in layers for channel in "RGB"]
        pixels = np.concatenate([*layers.values()], axis=-1)
        try:
            if channels != self._channels:
                self._client.create_image(self._name, *result.size, channels)
                self._channels = channels
            self._client.update_image(self._name, pixels, channels)
        except OSError as error:
            self._give_up(error)

    def close(self) -> None:
        """End the connection; tev keeps the image."""
        self._client.__exit__(None, None, None)

    def _give_up(self, error: OSError) -> None:
        self._reachable = False
        self.close()
        reason = error.strerror or error
        warn(f"tev cannot be reached at {self._address} ({reason}); rendering without it")
