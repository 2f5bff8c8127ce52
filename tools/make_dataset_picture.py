"""Draw seeds of procedural scenes side by side: those of docs/dataset.png, or of your choice.

python tools/make_dataset_picture.py [OUT.png] [--scenes LIST] [--seeds N] [--across N]
    [--illumination NAME] [--width PIXELS] [--passes N]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import photonmap as pm
from photonmap.dataset.files.derived_buffers import as_rgb, with_derived
from photonmap.dataset.files.image_files import previews
from photonmap.dataset.scenes.build import build_scene
from photonmap.io.png import write_png

OUT = Path(__file__).parents[1] / "docs" / "dataset.png"
GAP = 3
"""Space between pictures, pixels; four times as much between scenes."""

Bytes = NDArray[np.uint8]


def picture(name: str, seed: int, illumination: str, size: tuple[int, int], passes: int) -> Bytes:
    """Return the preview of a scene, (H, W, 3)."""
    scene = build_scene(name, seed, illumination)
    result = pm.render(scene, bands=6, size=size, passes=passes, seed=seed)
    result = with_derived(result, scene)
    return previews(result, as_rgb(result, "srgb"))["radiance"]


def sheet(pictures: list[Bytes], across: int) -> Bytes:
    """Return pictures of one size in rows, (H, W, 3), on white."""
    height, width, _ = pictures[0].shape
    rows = -(-len(pictures) // across)
    made = np.full((rows * (height + GAP) - GAP, across * (width + GAP) - GAP, 3), 255, np.uint8)
    for index, each in enumerate(pictures):
        top, left = index // across * (height + GAP), index % across * (width + GAP)
        made[top : top + height, left : left + width] = each
    return made


def main() -> None:
    """Read the arguments, render, and write the picture."""
    parser = argparse.ArgumentParser(description="Draw seeds of scenes side by side.")
    parser.add_argument("out", nargs="?", type=Path, default=OUT)
    parser.add_argument("--scenes", default="living_room,kitchen")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--across", type=int, default=10)
    parser.add_argument("--illumination", default="white")
    parser.add_argument("--width", type=int, default=104)
    parser.add_argument("--passes", type=int, default=16)
    given = parser.parse_args()
    size, sheets = (given.width, round(0.75 * given.width)), list[Bytes]()
    for name in given.scenes.split(","):
        seeds = range(given.seeds)
        shown = [picture(name, s, given.illumination, size, given.passes) for s in seeds]
        sheets.append(sheet(shown, min(given.across, given.seeds)))
    space = np.full((4 * GAP, sheets[0].shape[1], 3), 255, np.uint8)
    stacked = [part for each in sheets for part in (each, space)][:-1]
    write_png(np.concatenate(stacked), given.out)


if __name__ == "__main__":
    main()
