"""The arguments of a render, checked once."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from photonmap.bands import Bands
from photonmap.budget import LEAST_PHOTONS, Budget
from photonmap.effects import parse_effects
from photonmap.errors import InputError
from photonmap.kernels.records import Film
from photonmap.output import BUFFERS, check_buffers

LARGEST_SIDE = 1 << 16
MOST_PHOTONS = 1 << 32
MOST_THREADS = 1024

Method = Literal["photon", "path"]
Pixel = Literal["box", "center"]


@dataclass(frozen=True)
class Settings:
    """What `photonmap.render` was asked for beside the scene; names as there."""

    bands: Bands
    film: Film
    budget: Budget
    photons: int
    seed: int
    threads: int | None
    method: Method
    effects: str | frozenset[str]
    per_light: bool
    adaptive: bool
    buffers: frozenset[str]
    memory: float | None

    @classmethod
    def check(
        cls,
        bands: Bands | int | str,
        size: tuple[int, int],
        pixel: Pixel,
        budget: Budget,
        photons: int | None,
        seed: int,
        threads: int | None,
        method: Method,
        effects: str | Iterable[str],
        per_light: bool,
        adaptive: bool = True,
        buffers: Iterable[str] | None = None,
        memory: float | None = None,
    ) -> Settings:
        """Check all arguments, and fill in the number of photons.

        Raises
        ------
        InputError : one that is out of its range, or not known
        """
        bands, effects = Bands.parse(bands), parse_effects(effects)
        film = _film(size, pixel)
        if photons is None:
            photons = max(film.width * film.height, LEAST_PHOTONS)
        _check_numbers(photons, seed, threads)
        check_buffers(buffers)
        if memory is not None and not 0.0 < memory < math.inf:
            raise InputError(f"memory {memory} must be a number of bytes above 0")
        if method not in ("photon", "path"):
            raise InputError(f"method {method!r} is neither 'photon' nor 'path'")
        kept = frozenset(BUFFERS if buffers is None else buffers)
        return cls(
            bands, film, budget, photons, seed, threads, method, effects, per_light, adaptive,
            kept, memory,
        )  # fmt: skip

    @property
    def focuses(self) -> bool:
        """Whether sampling goes where the error is; the path tracer stays plain."""
        return self.adaptive and self.method == "photon"

    @property
    def pixels(self) -> int:
        """P."""
        return self.film.width * self.film.height

    @property
    def deciding(self) -> dict[str, Any]:
        """What decides the arrays beside scene, bands and size, JSON-able."""
        effects = self.effects
        return {
            "pixel": "box" if self.film.jitter else "center",
            "photons": int(self.photons),
            "seed": int(self.seed),
            "method": self.method,
            "effects": effects if isinstance(effects, str) else ",".join(sorted(effects)),
            "per_light": bool(self.per_light),
            "adaptive": bool(self.adaptive),
        }

    def describe(self, threads: int) -> dict[str, Any]:
        """Return the JSON-able record of the arguments; `threads` that there were."""
        effects = self.effects
        return {
            "size": [self.film.width, self.film.height],
            "budget": self.budget.describe(),
            "threads": threads,
            **self.deciding,
            "effects": effects if isinstance(effects, str) else sorted(effects),
        }


def check_size(size: tuple[int, int]) -> None:
    """Raise `InputError` for an image without pixels, or with too many."""
    width, height = size
    if not all(isinstance(side, int | np.integer) for side in size) or min(size) < 1:
        raise InputError(f"size {width}x{height} must be whole pixels, 1x1 at least")
    if max(size) > LARGEST_SIDE:
        raise InputError(f"size {width}x{height} is too large: {LARGEST_SIDE} a side at most")


def _film(size: tuple[int, int], pixel: str) -> Film:
    check_size(size)
    width, height = size
    if pixel not in ("box", "center"):
        raise InputError(f"pixel {pixel!r} is neither 'box' nor 'center'")
    return Film(int(width), int(height), pixel == "box")


def _check_numbers(photons: int, seed: int, threads: int | None) -> None:
    for name, value, low, high in (
        ("photons", photons, 0, MOST_PHOTONS),
        ("seed", seed, 0, 2**63 - 1),
        ("threads", 1 if threads is None else threads, 1, MOST_THREADS),
    ):
        if not isinstance(value, int | np.integer) or not low <= value <= high:
            raise InputError(f"{name} {value} must be a whole number from {low} to {high}")
