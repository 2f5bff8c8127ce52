"""What the page says of a study beside its points: settings, machine, reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from photonmap.study.machine import DISTURBED
from photonmap.study.measure import Study
from photonmap.study.metrics import BUFFERS
from photonmap.study.sweeps import Extent, called


@dataclass(frozen=True)
class About:
    """Texts of the page.

    Parameters
    ----------
    title, subtitle : the scene, and what was rendered
    base : the bands that sweeps start from, as they are called
    interrupted : by Ctrl-C
    pairs : names and values of settings and machine
    why : reasons for effects, by name
    clock : what seconds are
    repeats : of renders that are compared
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
    """Describe a study whose reference is measured.

    Parameters
    ----------
    study, extent : what was done
    interrupted : by Ctrl-C
    machine : as `describe_machine`
    others : share of the processors that other programs took
    """
    width, height = study.base.size
    record = study.record
    triangles = record["scene"]["triangles"]
    bands, clock = called(study.base.bands), _clock(study, others)
    pairs = [
        ("scene", f"{study.name}, {triangles} triangles"),
        ("image", f"{width}×{height}, {study.base.pixel} pixels, {bands}, seed {study.base.seed}"),
        ("photons in a pass", str(record["arguments"]["photons"])),
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
    reference = study.reference
    assert reference is not None
    errors = ", ".join(f"{name} {100 * reference.own_error(name):.2g}%" for name in BUFFERS)
    return (
        f"photon mapping, {reference.passes} passes in two halves, {reference.seconds:.0f} s; "
        f"its own error: {errors}"
    )


def _clock(study: Study, others: float) -> str:
    """Tell which clock counts, and why."""
    taken = f"other programs took {others:.0%} of the machine"
    if others <= DISTURBED:
        return f"by the wall clock, without loading and compiling; {taken}"
    longer = study.spent * study.record["arguments"]["threads"] / study.processor
    return (
        f"processor time over threads, without loading and compiling, as {taken}; "
        f"the wall clock showed {longer:.1f} times as much"
    )
