"""Write the flow between views of a data set: stereo pairs, and neighbours on trajectories."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from os import PathLike
from pathlib import Path

import numpy as np

from photonmap.dataset.files.flow import Eye, Flow, Target, find_targets, flow_of
from photonmap.dataset.files.inside import inside
from photonmap.dataset.files.manifest import locked
from photonmap.dataset.files.reader import Dataset, Image, open_dataset
from photonmap.dataset.jobs.job_scene import input_finder, make_scene
from photonmap.dataset.jobs.plan import Job
from photonmap.dataset.jobs.render_image import select_measured_sets
from photonmap.dataset.scenes.views import SIDES, View
from photonmap.errors import InputError
from photonmap.integrators.look import Onlooker
from photonmap.runtime.writing import replacing
from photonmap.scene.camera import Camera
from photonmap.scene.projections import RayMap

FOLDER = "flow"
"""Folder of a data set with one file for each pair of views."""
_SAME = 1e-4
"""By how much of its distance a surface may stand in front of a point and still be the same."""


def write_flows(
    folder: str | PathLike[str],
    log: Callable[[str], None] = lambda line: None,
    scenes: str | PathLike[str] | None = None,
) -> list[Path]:
    """Write flow/SCENE-FIRST-to-SECOND.npz for every pair of views, both ways.

    Pairs are the cameras of a stereo pair, and consecutive frames of a trajectory. Rays test what
    is hidden; the light does not matter, so there is one file for all lights. A file has `flow`,
    `valid`, `inside` and `visible` as `photonmap.dataset.files.flow.Flow` has them, and
    `disparity` for stereo pairs.

    Parameters
    ----------
    folder : of the data set
    log : called with a line for each pair
    scenes : folder in which scene files are looked for that are not where the manifest says

    Raises
    ------
    InputError : the folder holds no data set, no views make a pair, or a scene cannot be built
    OSError : a file cannot be written
    """
    images = open_dataset(folder)
    pairs = dict(find_pairs(images))
    if not pairs:
        remedy = "give a [[view]] a baseline, or add a [[trajectory]]"
        raise InputError(f"has no stereo pairs and no trajectories; {remedy}", folder)
    if any("distance" not in image for pair in pairs.values() for image in pair):
        raise InputError("holds no distance, which flow needs; add it to --buffers", folder)
    place, find = inside(folder, FOLDER), input_finder(Path(folder), scenes)
    written = []
    with locked(Path(folder)):
        place.mkdir(exist_ok=True)
        known: dict[str, Onlooker] = {}
        for name, (first, second) in pairs.items():
            if first.geometry not in known:
                job = find(Job.from_description(second.entry["job"]))
                select_measured_sets(job)
                known = {first.geometry: Onlooker(make_scene(job))}
            written.append(inside(place, f"{name}.npz", is_part=True))
            _save(flow_by_rays(first, second, known[first.geometry]), written[-1])
            log(f"{len(written)}/{len(pairs)} {name}")
    return written


def find_pairs(images: Dataset) -> Iterator[tuple[str, tuple[Image, Image]]]:
    """Yield names and images of all pairs of views, both ways, whatever the light."""
    by_view: dict[tuple[str, View], Image] = {}
    for image in images:
        view = View(**image.entry["job"]["view"])
        by_view.setdefault((image.geometry, view), image)
    for (geometry, view), image in by_view.items():
        for other in _partners(view):
            if (geometry, other) in by_view:
                name = f"{geometry}-{view.name}-to-{other.name}".replace(" ", "_")
                yield name, (image, by_view[geometry, other])


def _partners(view: View) -> Iterator[View]:
    """Yield the views that make pairs with a view: its other side, and the frames beside it."""
    if view.side:
        side = SIDES[1 - SIDES.index(view.side)]
        yield replace(view, side=side, name=view.name.removesuffix(view.side) + side)
    if view.path:
        for step in (-1, 1):
            if 0 <= view.frame + step < view.frames:
                yield replace(view, frame=view.frame + step).renamed()


def flow_by_rays(first: Image, second: Image, onlooker: Onlooker) -> Flow:
    """Return the flow between two images of an onlooker's scene; rays test what hides."""
    here, there = (
        Eye.of(each.entry["camera"], each["distance"].shape[::-1]) for each in (first, second)
    )
    target = find_targets(here, there, first["distance"])
    return flow_of(here, there, target, find_visible(target, here, there, onlooker))


def find_visible(target: Target, here: Eye, there: Eye, onlooker: Onlooker) -> np.ndarray:
    """Return which points rays from the second camera reach."""
    ways = np.where(target.valid[..., None], target.points - there.origin, there.axes[2])
    length = np.linalg.norm(ways, axis=-1)
    origins = np.broadcast_to(there.origin, ways.shape)
    camera = Camera(
        tuple(there.origin.tolist()),
        tuple((there.origin + there.axes[2]).tolist()),
        up=tuple((-there.axes[1]).tolist()),
        projection=RayMap(np.concatenate([origins, ways], axis=-1)),
    )
    met = onlooker.see(camera, here.size, ("distance",))["distance"]
    return target.inside & ~((met > 0.0) & (met < (1.0 - _SAME) * length))


def _save(flow: Flow, path: Path) -> None:
    arrays = {name: getattr(flow, name) for name in ("flow", "valid", "inside", "visible")}
    if flow.is_rectified:
        arrays["disparity"] = flow.disparity
    with replacing(path) as part:
        np.savez_compressed(part, **arrays)
