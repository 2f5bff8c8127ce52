"""The files that a data set is made from: copied into it, or named by it and found again."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from photonmap.capture.sensor import Sensor
from photonmap.dataset.files.inputs import CURVES, SENSOR, kept_as, role_of_light
from photonmap.dataset.jobs.job_scene import describe_inputs, digest_of
from photonmap.dataset.jobs.plan import CommonSettings, Job
from photonmap.errors import InputError
from photonmap.results.record import describe_measured_sets
from photonmap.spectra.sensitivities import table_of

Find = Callable[[Job], Job]
"""Returns a job of the manifest with its files where they are on this machine."""


def copy_inputs(folder: Path, jobs: Sequence[Job], sensor: Sensor | None) -> None:
    """Copy the curves of bands, of RGB, of lights and of a sensor into the folder of a data set.

    Raises
    ------
    OSError : one cannot be copied
    """
    common = jobs[0].common
    texts = {(role, getattr(common, role)) for role in CURVES if common.is_by_content}
    texts |= {(role_of_light(digest), path) for job in jobs for path, digest in job.light_files()}
    if sensor is not None:
        texts.add((SENSOR, sensor.camera))
    for role, text in sorted(texts):
        if (path := table_of(text)) is not None:
            target = folder / kept_as(role, path)
            target.parent.mkdir(parents=True, exist_ok=True)
            if not target.is_file() or target.read_bytes() != path.read_bytes():
                shutil.copyfile(path, target)


def input_finder(folder: Path, scenes: str | os.PathLike[str] | None = None) -> Find:
    """Return what finds the files of the jobs in a data set's manifest.

    Measured sets that are not where the manifest says are those that are chosen now, if they are
    the same.

    Parameters
    ----------
    folder : of the data set
    scenes : folder in which scene files are looked for where the manifest's are not there
    """
    chosen = describe_measured_sets()
    places: dict[str, str] = {}

    def find(job: Job) -> Job:
        job = job.located(folder)
        if not job.is_procedural and not Path(job.scene).is_file():
            if job.content not in places:
                places[job.content] = _find_scene(job, scenes)
            job = replace(job, scene=places[job.content])
        return replace(job, common=_find_sets(job.common, chosen))

    return find


def _find_scene(job: Job, scenes: str | os.PathLike[str] | None) -> str:
    """Return the scene file of a job's content, or raise an `InputError`."""
    name = Path(job.scene).name
    if scenes is None:
        raise InputError(f"the scene {name} is not there; say where with --scenes DIR")
    for path in sorted(Path(scenes).rglob(name)):
        if path.is_file() and digest_of(path) == job.content:
            return str(path)
    raise InputError(f"holds no scene {name} that the set was made from; choose another", scenes)


def _find_sets(common: CommonSettings, chosen: dict[str, str | None]) -> CommonSettings:
    """Return settings with measured sets that are there, or raise an `InputError`."""
    missing = dict(_missing_sets(common))
    if not missing:
        return common
    if any(chosen[role] is None for role in missing):
        role, name = next((r, n) for r, n in missing.items() if chosen[r] is None)
        raise InputError(f"{name} of {role} is not there; say where with --{role} PATH")
    paths = {role: chosen[role] for role in missing}
    found = replace(
        common,
        munsell=paths.get("munsell", common.munsell),
        illuminants=paths.get("illuminants", common.illuminants),
    )
    if describe_inputs(found).inputs != common.inputs:
        raise InputError(f"{', '.join(missing)}: others than those that the set was made with")
    return found


def _missing_sets(common: CommonSettings) -> Iterator[tuple[str, str]]:
    for role, path in (("munsell", common.munsell), ("illuminants", common.illuminants)):
        if path is not None and not Path(path).exists():
            yield role, Path(path).name
