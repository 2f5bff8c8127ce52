"""The description of a study on its page: settings, machine, reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from photonmap.study.machine import MAX_BACKGROUND_LOAD
from photonmap.study.measure import Study
from photonmap.study.metrics import BUFFERS
from photonmap.study.sweeps import Extent, bands_label


@dataclass(frozen=True)
class About:
    """Texts that describe a study.

    Parameters
    ----------
    title, subtitle : the scene, and how it was rendered
    base : label of the bands that sweeps start from
    interrupted : whether Ctrl-C ended the study
    pairs : names and values of settings and of the machine
    why : reason why each effect is on or off, by name
    clock : how seconds were measured
    repeats : how often renders were repeated whose times are compared
    """

    title: str
    subtitle: str
    base: str
    interrupted: bool
    pairs: list[tuple[str, str]]
    why: dict[str, str]
    clock: str
    repeats: str


def describe_study(
    study: Study, extent: Extent, interrupted: bool, machine: dict[str, Any], others: float
) -> About:
    """Describe a study that has its reference.

    Parameters
    ----------
    study, extent : the study, and how far its sweeps went
    interrupted : whether Ctrl-C ended the study
    machine : as `describe_machine` returns it
    others : fraction of the processors that other programs took
    """
    width, height = study.base.size
    record = study.record
    triangles = record["scene"]["triangles"]
    bands, clock = bands_label(study.base.bands), _clock(study, others)
    pairs = [
        ("scene", f"{study.name}, {triangles} triangles"),
        ("image", f"{width}×{height}, {study.base.pixel} pixels, {bands}, seed {study.base.seed}"),
        ("photons per pass", str(record["arguments"]["photons"])),
        ("effects", ", ".join(name for name, e in record["effects"].items() if e["on"])),
        ("reference", _reference(study)),
        ("rendering", f"{study.spent:.0f} s of {extent.seconds:.0f} s allowed"),
        ("threads", f"{record['arguments']['threads']} of {machine['processors']} processors"),
        ("machine", f"{machine['processor']}, {machine['system']}"),
        ("clock", clock),
        ("versions", ", ".join(f"{name} {v}" for name, v in machine["versions"].items())),
    ]
    repeats = f"{extent.repeats} run{'s' * (extent.repeats > 1)}"
    why = {name: effect["why"] for name, effect in record["effects"].items()}
    subtitle = f"{width}×{height} pixels, {bands} unless stated, {triangles} triangles; " + (
        f"{machine['processor']}, {record['arguments']['threads']} threads"
    )
    return About(study.name, subtitle, bands, interrupted, pairs, why, clock, repeats)


def _reference(study: Study) -> str:
    """Return how the reference was rendered, and its own errors."""
    reference = study.reference
    assert reference is not None
    errors = ", ".join(f"{name} {100 * reference.own_error(name):.2g}%" for name in BUFFERS)
    return (
        f"photon mapping, {reference.passes} passes in two halves, {reference.seconds:.0f} s; "
        f"its own error: {errors}"
    )


def _clock(study: Study, others: float) -> str:
    """Return which clock seconds are by, and why."""
    load = f"other programs took {others:.0%} of the processors"
    if others <= MAX_BACKGROUND_LOAD:
        return f"wall-clock time, without loading and compiling; {load}"
    longer = study.spent * study.record["arguments"]["threads"] / study.processor
    return (
        f"processor time divided by threads, without loading and compiling, as {load}; "
        f"wall-clock time was {longer:.1f} times as long"
    )
