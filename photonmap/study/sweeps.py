"""The sweeps: which options are varied, how far, and for how many seconds."""

from __future__ import annotations

from dataclasses import dataclass, replace

from photonmap.errors import InputError
from photonmap.film.budget import usual_photons
from photonmap.integrators.memory_estimate import Work
from photonmap.runtime.storage import check_memory
from photonmap.spectra.bands import Bands
from photonmap.study.errors import REFERENCE_BANDS, Reference, counted_pixels
from photonmap.study.measure import Settings, Study

SHARES = {
    "reference": 0.22, "passes": 0.2, "path": 0.11, "bands": 0.24, "photons": 0.06,
    "resolution": 0.07, "choices": 0.1,
}  # fmt: skip
"""Fraction of the seconds of rendering that each sweep gets."""

_PILOT = 8  # passes from which the time per pass is estimated
_LEAST, _MOST = 4, 1 << 14  # limits of numbers of passes that are chosen by time
_DOUBLINGS = 3  # least number of times that passes are doubled
_PATH_SEEDS = 1000  # offset of the seeds from those of photon mapping


@dataclass(frozen=True)
class Extent:
    """How far the sweeps go."""

    seconds: float  # of rendering, in all
    # as the renderer takes them; `REFERENCE_BANDS` among them
    bands: tuple[str, ...] = ("rgb", "3", "6", "9", "31", REFERENCE_BANDS)
    # factors of the default number of photons in a pass
    photons: tuple[float, ...] = (1 / 16, 1 / 4, 1, 4, 16)
    sides: tuple[float, ...] = (1 / 4, 1 / 2, 1, 2)  # factors of the image's width and height
    divisors: tuple[int, ...] = (4, 1)  # of the number of passes in the sweep of bands
    repeats: int = 2  # number of times that renders are timed whose times are compared, in turns
    forced: bool = True  # also render with all effects forced on

    @classmethod
    def quick(cls, seconds: float) -> Extent:
        """Return a small extent."""
        few = ("3", "6", REFERENCE_BANDS)
        return cls(seconds, few, (1 / 4, 1, 4), (1 / 2, 1), (2, 1), 1, forced=False)

    def without_rgb(self) -> Extent:
        """Return the extent without RGB, to which a range of wavelengths does not apply."""
        return replace(self, bands=tuple(label for label in self.bands if label != "rgb"))

    def share(self, sweep: str) -> float:
        """Return the seconds of a sweep."""
        return SHARES[sweep] * self.seconds


def check_largest(study: Study, extent: Extent) -> None:
    """Check, before the sweeps, that the largest renders fit into memory."""
    pixels = study.base.size[0] * study.base.size[1]
    usual = usual_photons(pixels)
    few = Bands.parse(study.base.bands).count
    larger = max(extent.sides) ** 2
    for size, bands, photons in (
        (pixels, int(REFERENCE_BANDS), usual),
        (round(pixels * larger), few, round(usual * larger)),
        (pixels, few, round(usual * max(extent.photons))),
    ):
        check_memory(Work(size, bands, photons, study.faces).need)


def run_sweeps(study: Study, extent: Extent) -> None:
    """Render the reference, then run sweep by sweep.

    Parameters
    ----------
    study : keeps the points
    extent : how far the sweeps go
    """
    pilot, _ = study.render(replace(study.base, passes=_PILOT))
    if pilot.record["interrupted"]:
        raise KeyboardInterrupt
    if not counted_pixels(pilot).any():
        problem = (
            "no pixel is covered by surfaces that do not emit, so there are no errors to measure"
        )
        raise InputError(f"{study.name}: {problem}; point the camera at such surfaces")
    pace = pilot.record["seconds"]["render"] / _PILOT
    runs = (_reference, _passes, _path, _bands, _photons, _resolution, _choices)
    for sweep, run in zip(SHARES, runs, strict=True):
        study.log(f"{min(study.spent / extent.seconds, 1.0):4.0%} {sweep}")
        run(study, extent, pace)


def _reference(study: Study, extent: Extent, pace: float) -> None:
    """Render both halves, as long as their share allows; the second may be interrupted."""
    passes = _affordable(extent.share("reference") / 2.0, pace)
    halves = []
    for half in (1, 2):
        settings = replace(study.base, passes=passes, seed=study.base.seed + half)
        halves.append(study.render(settings)[0])
        if half == 1 and halves[0].record["interrupted"]:
            raise KeyboardInterrupt
    study.reference = Reference(halves[0], halves[1])
    if halves[1].record["interrupted"]:
        raise KeyboardInterrupt


def _passes(study: Study, extent: Extent, pace: float) -> None:
    _double(study, "passes", study.base, extent.share("passes"))


def _path(study: Study, extent: Extent, pace: float) -> None:
    seed = study.base.seed + _PATH_SEEDS
    _double(study, "path", replace(study.base, method="path", seed=seed), extent.share("path"))


def _double(study: Study, sweep: str, settings: Settings, seconds: float) -> None:
    """Double the passes, each time with a new seed, as long as the next render fits."""
    start, passes, took = study.spent, 2, 0.0
    while passes <= _MOST:
        before = study.spent
        enough = passes > 2**_DOUBLINGS
        if enough and before - start + 2.0 * took > seconds:
            return
        seed = settings.seed + 2 + passes.bit_length()
        study.measure(sweep, f"{passes} passes", replace(settings, passes=passes, seed=seed))
        passes, took = 2 * passes, study.spent - before


def _bands(study: Study, extent: Extent, pace: float) -> None:
    """Render many bands, then fewer with the same seed, for each number of passes."""
    every = dict.fromkeys((*extent.bands, study.base.bands))
    labels = [label for label in every if label != REFERENCE_BANDS]
    counts = [int(label) for label in (*labels, REFERENCE_BANDS) if label.isdecimal()]
    # the time of a pass relative to 6 bands, estimated
    cost = len(labels) + 1 + sum(max(count - 6, 0) for count in counts) / 60.0
    runs = sum(1 / divisor for divisor in extent.divisors)
    most = _affordable(extent.share("bands") / (cost * runs * extent.repeats), pace)
    for passes in sorted({max(most // divisor, _LEAST) for divisor in extent.divisors}):
        settings = replace(study.base, passes=passes)
        many = replace(settings, bands=REFERENCE_BANDS)
        truth = study.measure("bands", bands_label(REFERENCE_BANDS), many)
        for label in labels:
            study.measure("bands", bands_label(label), replace(settings, bands=label), truth)
        study.time_again(len(labels) + 1, extent.repeats - 1)


def _photons(study: Study, extent: Extent, pace: float) -> None:
    usual = study.record["arguments"]["photons"]
    passes = _affordable(extent.share("photons") / (2.0 * len(extent.photons)), pace)
    for factor in extent.photons:
        photons = max(round(usual * factor), 1)
        settings = replace(study.base, passes=passes, photons=photons)
        study.measure("photons", f"{photons} photons", settings)


def _resolution(study: Study, extent: Extent, pace: float) -> None:
    pixels = sum(factor**2 for factor in extent.sides)
    passes = _affordable(extent.share("resolution") / pixels, pace)
    for factor in extent.sides:
        width, height = (max(round(side * factor), 1) for side in study.base.size)
        settings = replace(study.base, size=(width, height), passes=passes)
        study.measure("resolution", f"{width}×{height}", settings)


def _choices(study: Study, extent: Extent, pace: float) -> None:
    """Sample pixel centres; force all effects on; switch off each effect that is on."""
    on = effects_on(study)
    count = 2 + extent.forced + len(on)
    passes = _affordable(extent.share("choices") / (1.2 * count * extent.repeats), pace)
    settings, before = replace(study.base, passes=passes), len(study.points)
    study.measure("choices", "as usual", settings)
    study.measure("choices", "center pixels", replace(settings, pixel="center"))
    if extent.forced:
        study.measure("choices", "all effects", replace(settings, effects="all"))
    for name in on:
        if rest := ",".join(other for other in on if other != name):
            study.measure("choices", f"without {name}", replace(settings, effects=rest))
    study.time_again(len(study.points) - before, extent.repeats - 1)


def effects_on(study: Study) -> list[str]:
    """Return the effects that the scene calls for."""
    return [name for name, effect in study.record["effects"].items() if effect["on"]]


def bands_label(bands: str) -> str:
    """Return the bands as a label: "6 bands", or the text itself if it is not a number."""
    return f"{bands} bands" if bands.isdecimal() else bands


def _affordable(seconds: float, pace: float) -> int:
    return int(min(max(seconds / pace, _LEAST), _MOST))
