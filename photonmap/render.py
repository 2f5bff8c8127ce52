"""Render a scene: the algorithm's table of contents.

scene → prepare → passes: [photons → irradiance store → camera pass → sharing] → moments
→ buffers, standard errors, run record
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.accumulate import Accumulator
from photonmap.bands import Bands
from photonmap.bias import BiasProbe
from photonmap.budget import CEILING, Budget
from photonmap.chances import choose_seldom
from photonmap.checkpoint import Checkpoint, check_checkpoint
from photonmap.columns import Columns, carry, choose_columns, count_distinct
from photonmap.compiling import compile_kernels, is_compiled
from photonmap.cuts import SMALLEST_SHARE
from photonmap.effects import EffectPlan, leave_out, plan_effects
from photonmap.errors import InputError, listening, warn
from photonmap.fingerprint import describe_run
from photonmap.first_hits import AT_CENTRES, first_hit_buffers
from photonmap.focus import Focus
from photonmap.hidden_lights import warn_of_hidden_lights
from photonmap.kernels.beyond import MOST_SMOOTH
from photonmap.kernels.records import Film
from photonmap.landing import warn_of_few_photons
from photonmap.ledger import Ledger
from photonmap.memory import Work, check_memory
from photonmap.output import OF_SMOOTH, in_order
from photonmap.passes import MAX_BOUNCES, PROBE, Passes, stream_key
from photonmap.prepare import Prepared, prepare
from photonmap.progress import Progress, Silent
from photonmap.record import describe_camera, describe_measured_sets, describe_versions
from photonmap.result import Result
from photonmap.rounds import Rounds
from photonmap.scene import Scene
from photonmap.settings import Method, Pixel, Settings
from photonmap.storage import Storage
from photonmap.workers import Workers

FEW_CHAINS = 1e-4
"""Share of pixels that may miss the end of a chain of reflections before a warning is due."""


def render(
    scene: Scene,
    *,
    bands: Bands | int | str = 6,
    size: tuple[int, int] = (512, 512),
    pixel: Pixel = "box",
    passes: int | None = None,
    seconds: float | None = None,
    error: float | str | None = None,
    photons: int | None = None,
    seed: int = 0,
    threads: int | None = None,
    method: Method = "photon",
    effects: str | Iterable[str] = "auto",
    per_light: bool = False,
    adaptive: bool = True,
    buffers: Iterable[str] | None = None,
    memory: float | None = None,
    checkpoint: str | PathLike[str] | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Result:
    """Render a scene into ground-truth buffers with standard errors.

    Parameters
    ----------
    scene : meshes, lights, camera
    bands : N Gaussian bands over 400-700 nm, "rgb", or `Bands`
    size : (width, height), pixels
    pixel : samples cover the pixel ("box"), or all pass through its centre ("center")
    passes, seconds, error : the budget, one of them at most; error 0.02 if none is given.
        A render that aims at an error stops after an hour anyway. An error may be of a buffer,
        "indirect:0.01", and a percentile over pixels and bands, "indirect:p95:0.01".
    photons : emitted in each pass; None takes one for each pixel, 16384 at least
    seed : with the same passes, the same arrays bit for bit, for any number of threads
    threads : None takes every processor
    method : photon mapping, or the plain "path" tracer that arbitrates
    effects : "auto" simulates what the scene calls for, "all" everything, and a list of names, or
        names separated by commas, those alone: see `photonmap.effects`
    per_light : split direct, indirect, caustics and shading by groups of lights too
    adaptive : after 8 passes, take more samples where these were noisy, and fewer elsewhere
    buffers : names of those to keep, with their errors; None for all. Fewer take less memory.
    memory : bytes of RAM above which the large arrays, those of the result too, lie in files
        without names in the folder for temporary files (TMPDIR); with the same numbers in them
    checkpoint : file to which the state is saved every minute and in the end
    resume : go on from the checkpoint as if there had been no break; the budget counts earlier
        passes and seconds. Where there is no such file, a warning says so.
    progress : is told how far the render is

    Returns
    -------
    Result. Ctrl-C ends the passes early: what is done is returned, and the record says so.

    Raises
    ------
    InputError : input that cannot be rendered, or a checkpoint that cannot be gone on from
    KeyboardInterrupt : Ctrl-C before the first pass was complete
    """
    start = time.perf_counter()
    budget = Budget.choose(passes, seconds, error)
    settings = Settings.check(
        bands, size, pixel, budget, photons, seed, threads, method, effects, per_light, adaptive,
        None if buffers is None else list(buffers), memory,
    )  # fmt: skip
    file = _checkpoint_file(checkpoint, resume)
    progress = progress or Silent()
    with listening() as told, Workers(threads) as workers:
        job = _set_up(scene, settings)
        loaded = time.perf_counter()
        progress.stage("compile" if is_compiled(job.whole, method) else "first compile")
        compile_kernels(job.whole, settings.bands, workers, method)
        compiled = time.perf_counter()
        progress.stage("render")
        hidden = warn_of_hidden_lights(job.whole, settings.film, stream_key(seed, 0, PROBE))
        run, moments = _begin(job, settings, workers, hidden)
        saved = None if file is None else Checkpoint(file, job.fingerprint)
        probe = BiasProbe(run, settings.film, job.columns)
        focus = Focus(settings.film, job.columns, job.storage) if settings.focuses else None
        rounds = Rounds(run, moments, budget, probe, focus, saved, resume)
        with workers.holding_interrupts():
            rounds.go(progress)
        _warn_of_cuts(run, moments.whole, budget, rounds.elapsed)
        outcome = _describe_passes(run, moments.whole, rounds)
        flat, errors, unresolved = _finish(job, settings, run, moments, workers)
        if set(hidden) != set(job.whole.light_names):
            warn_of_few_photons(unresolved)
        ended = time.perf_counter()

    record = {
        **_describe_job(scene, job, settings, workers.threads),
        "effects": job.plan.describe(run.effect_seconds),
        **outcome,
        "unresolved": int(unresolved.sum()),
        "seconds": _describe_seconds(run, rounds, start, loaded, compiled, ended),
        "warnings": told,
    }
    film = settings.film
    blocks = moments.block_errors(job.whole.power, settings.buffers)
    return Result(_images(flat, film), _images(errors, film), settings.bands, record, blocks)


@dataclass(frozen=True)
class Job:
    """A scene, and how it is simulated."""

    whole: Prepared
    """the scene without what is left out, in its bands"""
    carried: Prepared
    """the same in the columns that passes carry"""
    plan: EffectPlan
    columns: Columns
    storage: Storage
    fingerprint: dict[str, Any]


def _checkpoint_file(path: str | PathLike[str] | None, resume: bool) -> Path | None:
    """Check where the checkpoint is to be; say so if there is none yet to go on from."""
    if path is None:
        if resume:
            raise InputError("resume needs the checkpoint to go on from: name its file")
        return None
    return check_checkpoint(path)


def _set_up(scene: Scene, settings: Settings) -> Job:
    """Check the scene, and decide on effects and columns."""
    film, bands = settings.film, settings.bands
    faces = sum(len(mesh.faces) for mesh in scene.meshes)
    work = Work(settings.pixels, 1, settings.photons, faces, buffers=settings.buffers)
    check_memory(work, settings.memory)
    prepared = prepare(scene, bands, film.width / film.height)
    fingerprint = describe_run(prepared, bands, film, settings.deciding)
    plan = plan_effects(prepared, settings.effects, count_distinct(prepared), bands.count)
    whole = leave_out(prepared, plan)
    columns = choose_columns(whole, plan.on("band_merging"), settings.per_light)
    carried = carry(whole, columns)
    count = columns.count + settings.per_light * columns.distinct
    smooth = carried.optics is not None
    work = replace(work, bands=count, smooth=smooth, split=settings.per_light)
    storage = check_memory(work, settings.memory)
    if not smooth:
        _check_smooth_asked(settings)
    return Job(whole, carried, plan, columns, storage, fingerprint)


def _check_smooth_asked(settings: Settings) -> None:
    """Check that more is asked for than what only scenes with mirrors or glass have."""
    goal, kept = settings.budget.goal, settings.buffers
    if goal is not None and goal.buffer in OF_SMOOTH:
        raise InputError(
            f"error {goal}: without mirrors and glass {goal.buffer} is exactly 0; "
            f"aim at another buffer"
        )
    if kept <= {*OF_SMOOTH, "covariance"}:
        raise InputError(
            f"buffers {', '.join(sorted(kept))}: without mirrors and glass there may be none of "
            f"them; ask for another buffer too"
        )


def _begin(
    job: Job, settings: Settings, workers: Workers, hidden: list[str]
) -> tuple[Passes, Ledger]:
    """Return what runs the passes, and the moments into which they are taken.

    Lights that seem hidden are chosen seldom.
    """
    columns, method = job.columns, settings.method
    lights = choose_seldom(job.carried.lights, job.carried.light_names, hidden)
    run = Passes(
        replace(job.carried, lights=lights),
        settings.film,
        columns.count,
        settings.photons,
        settings.seed,
        workers,
        method,
        job.plan,
        job.storage,
    )
    smooth = job.carried.optics is not None
    return run, Ledger(columns, settings.film, workers, smooth, job.storage)


def _warn_of_cuts(run: Passes, moments: Accumulator, budget: Budget, elapsed: float) -> None:
    missing = "surfaces reflect nearly everything, and light is missing from indirect"
    if run.cut > SMALLEST_SHARE * run.photons:
        warn(f"{run.cut} of {run.photons} photons were cut after {MAX_BOUNCES} bounces: {missing}")
    share = run.share_of_paths_cut()
    if share > SMALLEST_SHARE:
        warn(f"about {100 * share:.2g}% of paths are cut after {MAX_BOUNCES} bounces: {missing}")
    chains = moments.cut()
    if chains > FEW_CHAINS * len(moments.counts):
        warn(
            f"{chains} pixels see chains of more than {MOST_SMOOTH} reflections, as between facing "
            f"mirrors: what is beyond is missing"
        )
    if budget.goal is not None and elapsed >= 0.9 * CEILING:
        warn(f"stopped after {CEILING:.0f} s, before the error {budget.goal} was reached")


def _describe_job(scene: Scene, job: Job, settings: Settings, threads: int) -> dict[str, Any]:
    """Return what the record says of scene and arguments."""
    camera = describe_camera(job.whole.camera, settings.film)
    return {
        "scene": {"name": scene.name, **job.whole.counts},
        "arguments": settings.describe(threads),
        "partial": job.plan.partial,
        "light_groups": list(job.columns.groups) if settings.per_light else [],
        "bands": settings.bands.describe(),
        "camera": {"framed": scene.camera is None, **camera},
        "measured_sets": describe_measured_sets(),
        "versions": describe_versions(),
        "fingerprint": job.fingerprint,
    }


def _describe_passes(run: Passes, moments: Accumulator, rounds: Rounds) -> dict[str, Any]:
    """Return what the record says of the passes."""
    error, bias = moments.error(lit=run.stores > 0), rounds.bias
    known = math.isfinite(error)
    return {
        "passes": moments.count,
        "photons": run.photons,
        "photons_stored": run.stores,
        "rays": run.rays,
        "error": math.hypot(error, bias or 0.0) if known else None,
        "standard_error": error if known else None,
        "bias": bias,
        "goal": rounds.describe_goal(),
        "interrupted": rounds.interrupted,
        "resumed": rounds.resumed,
        "predicted_seconds": rounds.predicted,
    }


def _describe_seconds(
    run: Passes, rounds: Rounds, start: float, loaded: float, compiled: float, ended: float
) -> dict[str, float]:
    """Return the seconds of each stage; those of rendering are of earlier runs too."""
    rendering = rounds.earlier + ended - compiled
    saving = {"checkpoint": rounds.saving} if rounds.saves else {}
    return {
        "load": loaded - start,
        "compile": compiled - loaded,
        "photons": run.photon_seconds,
        "camera": rendering - run.photon_seconds - rounds.saving,
        **saving,
        "render": rendering,
    }


def _finish(
    job: Job, settings: Settings, run: Passes, moments: Ledger, workers: Workers
) -> tuple[dict[str, Any], dict[str, Any], NDArray[np.bool_]]:
    """Return the buffers to keep, in the order of `BUFFERS`, and their errors, one row a pixel.

    And which pixels are unresolved, (P,), kept or not.
    """
    kept = settings.buffers
    light, errors = moments.finish(job.whole.power, kept)
    unresolved = moments.whole.unresolved() & (run.stores > 0)
    rest = {"unresolved": unresolved, "passes": moments.whole.counts}
    if not kept.isdisjoint(AT_CENTRES):
        rest |= first_hit_buffers(job.whole, settings.film, workers, job.storage)
    flat = {**light, **{name: values for name, values in rest.items() if name in kept}}
    return in_order(flat), errors, unresolved


def _images(flat: dict[str, Any], film: Film) -> dict[str, Any]:
    """Give arrays of one row a pixel the shape of the image."""
    return {
        name: values.reshape(film.height, film.width, *values.shape[1:])
        for name, values in flat.items()
    }
