"""What is varied, and how far: each sweep has a share of the seconds."""

from __future__ import annotations

from dataclasses import dataclass, replace

from photonmap.bands import Bands
from photonmap.budget import LEAST_PHOTONS
from photonmap.errors import InputError
from photonmap.memory import Work, check_memory
from photonmap.study.color import MANY
from photonmap.study.measure import Study
from photonmap.study.metrics import counted_pixels
from photonmap.study.point import Settings
from photonmap.study.reference import Reference

SHARES = {
    "reference": 0.22,
    "passes": 0.2,
    "path": 0.11,
    "bands": 0.24,
    "photons": 0.06,
    "resolution": 0.07,
    "choices": 0.1,
}
"""Of the seconds of rendering."""

_PILOT = 8  # passes that tell the pace
_LEAST, _MOST = 4, 1 << 14  # passes of a point whose number is chosen by the pace
_DOUBLINGS = 3  # of the number of passes, at least
_PATH_SEEDS = 1000  # after those of photon mapping


@dataclass(frozen=True)
class Extent:
    """How far sweeps go.

    Parameters
    ----------
    seconds : of rendering, in all
    bands : as the renderer takes them; `MANY` among them
    photons : factors on the usual number in a pass
    sides : factors on the image's width and height
    divisors : of the number of passes of the sweep of bands
    repeats : of renders whose seconds are compared with each other, taking turns
    forced : force all effects on, too
    """

    seconds: float
    bands: tuple[str, ...] = ("rgb", "3", "6", "9", "31", MANY)
    photons: tuple[float, ...] = (1 / 16, 1 / 4, 1, 4, 16)
    sides: tuple[float, ...] = (1 / 4, 1 / 2, 1, 2)
    divisors: tuple[int, ...] = (4, 1)
    repeats: int = 2
    forced: bool = True

    @classmethod
    def quick(cls, seconds: float) -> Extent:
        """Return a small one."""
        few = ("3", "6", MANY)
        return cls(seconds, few, (1 / 4, 1, 4), (1 / 2, 1), (2, 1), 1, forced=False)

    def without_rgb(self) -> Extent:
        """Return it without the bands that have no range."""
        return replace(self, bands=tuple(label for label in self.bands if label != "rgb"))

    def share(self, sweep: str) -> float:
        """Return the seconds of a sweep."""
        return SHARES[sweep] * self.seconds


def check_largest(study: Study, extent: Extent) -> None:
    """Check before the sweeps that the largest of their renders fit into memory.

    Raises
    ------
    InputError
        if not
    """
    pixels = study.base.size[0] * study.base.size[1]
    usual = max(pixels, LEAST_PHOTONS)
    few = Bands.parse(study.base.bands).count
    larger = max(extent.sides) ** 2
    for size, bands, photons in (
        (pixels, int(MANY), usual),
        (round(pixels * larger), few, round(usual * larger)),
        (pixels, few, round(usual * max(extent.photons))),
    ):
        check_memory(Work(size, bands, photons, study.faces))


def run_sweeps(study: Study, extent: Extent) -> None:
    """Measure the reference, then sweep by sweep.

    Parameters
    ----------
    study : takes in the points
    extent : how far to go

    Raises
    ------
    InputError
        if no pixel counts, so that there is no error to speak of
    KeyboardInterrupt
        at Ctrl-C; the study keeps its points
    """
    pilot, _ = study.render(replace(study.base, passes=_PILOT))
    if pilot.record["interrupted"]:
        raise KeyboardInterrupt
    if not counted_pixels(pilot).any():
        raise InputError(
            f"{study.name}: no pixel shows surfaces alone that do not emit: there is no error to "
            f"study; point the camera at some"
        )
    pace = pilot.record["seconds"]["render"] / _PILOT
    for sweep, run in (
        ("reference", _reference),
        ("passes", _passes),
        ("path", _path),
        ("bands", _bands),
        ("photons", _photons),
        ("resolution", _resolution),
        ("choices", _choices),
    ):
        study.tell(f"{study.spent / extent.seconds:4.0%} {sweep}")
        run(study, extent, pace)


def _reference(study: Study, extent: Extent, pace: float) -> None:
    """Render twice, as long as their share allows; an interrupted second half will do."""
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
    """Double the passes, each time with a seed of its own, while the next fits in the share."""
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
    """Render many bands, then fewer with the same seed, for some numbers of passes."""
    labels = [label for label in dict.fromkeys((*extent.bands, study.base.bands)) if label != MANY]
    cost = sum(_relative_cost(label) for label in (*labels, MANY))
    runs = sum(1 / divisor for divisor in extent.divisors)
    most = _affordable(extent.share("bands") / (cost * runs * extent.repeats), pace)
    for passes in sorted({max(most // divisor, _LEAST) for divisor in extent.divisors}):
        settings = replace(study.base, passes=passes)
        truth = study.measure("bands", called(MANY), replace(settings, bands=MANY))
        for label in labels:
            study.measure("bands", called(label), replace(settings, bands=label), truth)
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
    """Sample pixels' centres; force all effects on; leave out each that the scene calls for."""
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


def called(bands: str) -> str:
    """Return bands with a noun where they are but a number."""
    return f"{bands} bands" if bands.isdecimal() else bands


def _affordable(seconds: float, pace: float) -> int:
    return int(min(max(seconds / pace, _LEAST), _MOST))


def _relative_cost(bands: str) -> float:
    """Estimate what a pass takes, relative to 6 bands, to plan by."""
    return 1.0 + max(int(bands) - 6, 0) / 60.0 if bands.isdecimal() else 1.0
