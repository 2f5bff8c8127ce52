"""Client of `mitsuba_server`."""

from __future__ import annotations

import json
import os
import re
import subprocess
import tempfile
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.options import Options

SERVER = Path(__file__).with_name("mitsuba_server.py")
LLVM, SCALAR = "llvm_ad_rgb", "scalar_rgb"
"""Variants of Mitsuba: compiled for vectors, and scalar C++."""
LLVM_PLACES = ("*/libLLVM*.so*", "llvm-*/lib/libLLVM*.so*")
"""Patterns below /usr/lib: Dr.Jit takes what it finds first, even if it is too old for it."""
OLDEST_LLVM = 17
"""With 15 and 16, it ends on processors with vectors of 512 bits."""
UNLIMITED, ONLY_LAMPS, ONE_BOUNCE = -1, 1, 2
"""Maximum path depths."""
DENOISE = "denoise"
"""In place of a depth: an image that was rendered is filtered by Open Image Denoise."""


class Mitsuba:
    """A running Mitsuba; `reason` says why there is none.

    Parameters
    ----------
    interpreter : a Python with Mitsuba 3
    threads : number of render threads
    case : one of the server's cases, or the file of a scene; None for the plain Cornell box
    variant : LLVM or SCALAR
    size : width and height of a case; 256 by default
    """

    reason = ""
    processor = 0.0
    """Seconds of processor time that the last render took."""

    def __init__(
        self,
        interpreter: str,
        threads: int,
        case: str | None = None,
        variant: str = LLVM,
        size: int | None = None,
    ) -> None:
        self.variant = variant
        self._folder = tempfile.TemporaryDirectory()
        self._image = Path(self._folder.name) / "image.npy"
        self._errors = Path(self._folder.name) / "stderr"
        environment = dict(os.environ)
        if "DRJIT_LIBLLVM_PATH" not in environment and (library := find_llvm()):
            environment["DRJIT_LIBLLVM_PATH"] = library
        with self._errors.open("w") as errors:
            self._process = subprocess.Popen(
                [
                    interpreter,
                    str(SERVER),
                    variant,
                    str(threads),
                    *([case] if case else []),
                    *([str(size)] if size else []),
                ],
                env=environment,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
            )
        hello = self._answer()
        self.version = hello.get("version", "")
        self.threads = hello.get("threads", 0)
        if not hello:
            last = self._errors.read_text().strip().splitlines()
            self.reason = (
                f"Mitsuba did not start in {interpreter}: {last[-1] if last else 'no message'}"
            )

    def __enter__(self) -> Self:
        """Return the client itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """End the server."""
        self._process.communicate()
        self._folder.cleanup()

    def render(
        self, samples: int, seed: int, depth: int = UNLIMITED
    ) -> tuple[NDArray[np.float32], float]:
        """Return (H, W, 3) radiance from so many samples per pixel, and the seconds it took."""
        return self._ask(depth, samples, seed)

    def denoise(self, image: NDArray[np.float32], samples: int) -> NDArray[np.float32]:
        """Return an image of so many samples per pixel without its noise."""
        np.save(self._image, image.astype(np.float32))
        return self._ask(DENOISE, samples, 1)[0]

    def _ask(self, depth: int | str, samples: int, seed: int) -> tuple[NDArray[np.float32], float]:
        """Return the image that the server makes, and the seconds it took."""
        file = self._image
        assert self._process.stdin is not None
        self._process.stdin.write(f"{depth} {samples} {seed} {file}\n")
        self._process.stdin.flush()
        answer = self._answer()
        if not answer:
            raise RuntimeError(f"Mitsuba ended: {self._errors.read_text()}")
        self.processor = answer["processor"]
        return np.load(file), answer["seconds"]

    def _answer(self) -> dict[str, Any]:
        """Return the next line that the server prints, {} if it has ended."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        return json.loads(line) if line else {}


def start_mitsuba(
    options: Options, scene: Path | str | None = None, size: int | None = None
) -> Mitsuba | str:
    """Return Mitsuba, compiled for vectors if that runs here; or the reason why there is none.

    Parameters
    ----------
    scene : a file, or one of the server's cases, with its size; None for the plain Cornell box
    """
    for variant in (LLVM, SCALAR):
        other = Mitsuba(options.mitsuba, options.threads, scene and str(scene), variant, size)
        if not other.reason:
            try:
                other.render(1, 0)
            except (RuntimeError, BrokenPipeError):
                other.reason = f"Mitsuba's {variant} ended in {options.mitsuba}"
            else:
                return other
        other.__exit__()
    return other.reason


def find_llvm() -> str:
    """Return the newest LLVM library that Dr.Jit can load, or ""."""
    found = [file for place in LLVM_PLACES for file in sorted(Path("/usr/lib").glob(place))]
    newest = max(found, key=_version, default=Path())
    return str(newest) if _version(newest) >= OLDEST_LLVM else ""


def _version(library: Path) -> int:
    number = re.search(r"\d+", library.name)
    return int(number[0]) if number else 0
