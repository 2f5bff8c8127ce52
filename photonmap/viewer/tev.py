"""Images sent to tev, the viewer, as a render goes on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from photonmap.errors import InputError, warn

if TYPE_CHECKING:
    from photonmap.results.result import Result

ADDRESS = "localhost:14158"
"""Where tev listens by default."""
_SHOWN = ("radiance", "direct", "indirect", "shading", "reflectance")


class Tev:
    """Sends buffers in linear sRGB; see `--view`. Where no tev runs, it warns once.

    Parameters
    ----------
    name : what tev calls the image
    address : HOST:PORT

    Raises
    ------
    InputError : tevclient is not installed, or there is no such address
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
