"""One measured point: what was chosen, what it took, what came out."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field

from photonmap.study.color import ColorError
from photonmap.study.metrics import BUFFERS
from photonmap.study.pictures import ErrorMap


@dataclass(frozen=True)
class Settings:
    """What a user can choose, as `photonmap.render` takes it; `bands` as it is written."""

    method: str = "photon"
    bands: str = "6"
    size: tuple[int, int] = (128, 128)
    pixel: str = "box"
    photons: int | None = None
    passes: int = 16
    effects: str = "auto"
    seed: int = 0


@dataclass(frozen=True)
class Point:
    """A render that was measured.

    Parameters
    ----------
    sweep : to which it belongs
    label : what is special about it there, in a few words
    settings : of the render; `passes` are those that were done
    wall : seconds of rendering, without loading and compiling
    processor : seconds of all processors together
    seconds : those that count, by one of these two clocks
    rays : cast; None where they are not counted
    photons : emitted in all passes
    stated : relative errors by buffer, as the render states them; nan after a single pass
    true : relative errors by buffer, against the reference; empty where none fits
    mean_difference : of mean radiance from the reference's, a part; nan where none fits
    mean_error : its standard error; nan but for path tracing, whose pixels are independent
    color : against many bands of the same seed and passes; None where there is no such render
    picture : data URI
    error_map : where it is off
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
        """Return the point as a row of the table: all of `COLUMNS`; what is not known is empty."""
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
"""Of the table: errors and differences are parts of 1, ΔE2000 as it is."""


def _cell(value: object) -> object:
    """Return a number to six digits; nothing for None and nan."""
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return "" if value is None else value
