"""A measured point: the settings of a render, its time, and its errors."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field

from photonmap.settings import Options
from photonmap.study.color_error import ColorError
from photonmap.study.error_maps import ErrorMap
from photonmap.study.metrics import BUFFERS


@dataclass(frozen=True, kw_only=True)
class Settings(Options):
    """The options of a render, those that a study varies as they are written."""

    bands: str = "6"
    size: tuple[int, int] = (128, 128)
    passes: int = 16
    effects: str = "auto"


@dataclass(frozen=True)
class Point:
    """A measured render.

    Parameters
    ----------
    sweep : the sweep that it belongs to
    label : what distinguishes it within the sweep
    settings : of the render; `passes` is the number that was completed
    wall : wall-clock seconds of rendering, without loading and compiling
    processor : processor seconds of rendering, over all threads
    seconds : the time to use, by one of these two clocks
    rays : number of rays; None where they are not counted
    photons : number of photons emitted in all passes
    stated : relative errors by buffer, as the render states them; nan after a single pass
    true : relative errors by buffer, against the reference; empty if it does not fit
    mean_difference : relative difference of mean radiance from the reference; nan if it does not
        fit
    mean_error : relative standard error of mean radiance; nan except for path tracing, whose
        pixels are independent
    color : colour errors against many bands; None without a render of those
    picture : the image as a data URI
    error_map : map of the errors; None without an estimate
    """

    sweep: str
    label: str
    settings: Settings
    wall: float
    processor: float
    seconds: float
    rays: int | None
    photons: int
    stated: dict[str, float]
    true: dict[str, float] = field(default_factory=dict)
    mean_difference: float = math.nan
    mean_error: float = math.nan
    color: ColorError | None = None
    picture: str = ""
    error_map: ErrorMap | None = None

    def row(self) -> dict[str, object]:
        """Return the point as a row of the table, by `COLUMNS`; unknown values are empty."""
        settings = self.settings
        row: dict[str, object] = {
            "sweep": self.sweep,
            "label": self.label,
            "method": settings.method,
            "bands": settings.bands,
            "width": settings.size[0],
            "height": settings.size[1],
            "pixel": settings.pixel,
            "photons_per_pass": settings.photons,
            "passes": settings.passes,
            "effects": settings.effects,
            "seed": settings.seed,
            "seconds": self.seconds,
            "wall_seconds": self.wall,
            "processor_seconds": self.processor,
            "rays": self.rays,
            "photons": self.photons,
            "mean_difference": self.mean_difference,
            "mean_error": self.mean_error,
        }
        row |= {f"stated_{buffer}": self.stated.get(buffer) for buffer in BUFFERS}
        row |= {f"true_{buffer}": self.true.get(buffer) for buffer in BUFFERS}
        color = asdict(self.color) if self.color else {}
        row |= {column: color.get(name) for column, name in _COLOR_COLUMNS.items()}
        return {name: _cell(row[name]) for name in COLUMNS}


_COLOR_COLUMNS = {
    "delta_e_mean": "delta_mean",
    "delta_e_p95": "delta_p95",
    "delta_e_indirect_mean": "indirect_mean",
    "delta_e_indirect_p95": "indirect_p95",
    "spectral_luminance": "luminance",
    "spectral_radiance": "radiance",
    "spectral_shading": "shading",
    "spectral_indirect": "indirect",
}

COLUMNS = (
    *("sweep", "label", "method", "bands", "width", "height", "pixel", "photons_per_pass"),
    *(
        "passes",
        "effects",
        "seed",
        "seconds",
        "wall_seconds",
        "processor_seconds",
        "rays",
        "photons",
    ),
    *(f"stated_{buffer}" for buffer in BUFFERS),
    *(f"true_{buffer}" for buffer in BUFFERS),
    *("mean_difference", "mean_error"),
    *_COLOR_COLUMNS,
)
"""Columns of the table; errors and differences are fractions, not percent."""


def _cell(value: object) -> object:
    """Return a number to six digits, and an empty cell for None and nan."""
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return "" if value is None else value
