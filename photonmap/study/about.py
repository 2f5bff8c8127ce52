"""What the page says of a study beside its points: settings, machine, reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from photonmap.study.measure import Study
from photonmap.study.metrics import BUFFERS
from photonmap.study.sweeps import Extent, called

_DISTURBED = 0.1  # share of the machine from which on seconds are doubtful


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
    """

    title: str
    subtitle: str
    base: str
    interrupted: bool
    pairs: list[tuple[str, str]]
    why: dict[str, str]


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
    bands = called(study.base.bands)
    pairs = [
        ("scene", f"{study.name}, {triangles} triangles"),
        ("image", f"{width}×{height}, {study.base.pixel} pixels, {bands}, seed {study.base.seed}"),
        ("photons in a pass", str(record["arguments"]["photons"])),
        ("effects", ", ".join(name for name, e in record["effects"].items() if e["on"])),
        ("reference", _reference(study)),
        ("rendering", f"{study.spent:.0f} s of {extent.seconds:.0f} s allowed"),
        ("threads", f"{record['arguments']['threads']} of {machine['processors']} processors"),
        ("machine", f"{machine['processor']}, {machine['system']}"),
        ("taken by other programs", f"{others:.0%} of the machine{_doubt(others)}"),
        ("versions", ", ".join(f"{name} {v}" for name, v in machine["versions"].items())),
    ]
    why = {name: effect["why"] for name, effect in record["effects"].items()}
    subtitle = f"{width}×{height} pixels, {bands} unless stated, {triangles} triangles; " + (
        f"{machine['processor']}, {record['arguments']['threads']} threads"
    )
    return About(study.name, subtitle, bands, interrupted, pairs, why)


def _reference(study: Study) -> str:
    reference = study.reference
    assert reference is not None
    errors = ", ".join(f"{name} {100 * reference.own_error(name):.2g}%" for name in BUFFERS)
    return (
        f"photon mapping, {reference.passes} passes in two halves, {reference.seconds:.0f} s; "
        f"its own error: {errors}"
    )


def _doubt(others: float) -> str:
    return ": seconds are too long, ratios rough" if others > _DISTURBED else ""
