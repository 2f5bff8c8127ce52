"""Render a scene: the algorithm's table of contents.

scene → prepare → passes: [photons → irradiance store → camera pass → sharing] → moments
→ buffers, standard errors, run record
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any, Literal

import numpy as np

from photonmap.accumulate import Accumulator
from photonmap.bands import Bands
from photonmap.budget import CEILING, LEAST_PHOTONS, Budget
from photonmap.columns import Columns, carry, choose_columns, count_distinct
from photonmap.compiling import compile_kernels, is_compiled
from photonmap.effects import EffectPlan, leave_out, parse_effects, plan_effects
from photonmap.errors import InputError, listening, warn
from photonmap.first_hits import first_hit_buffers
from photonmap.hidden_lights import warn_of_hidden_lights
from photonmap.kernels.beyond import MOST_SMOOTH
from photonmap.kernels.records import Film
from photonmap.ledger import Ledger
from photonmap.memory import check_memory
from photonmap.output import BUFFERS
from photonmap.passes import MAX_BOUNCES, PROBE, Passes, stream_key
from photonmap.prepare import Prepared, prepare
from photonmap.progress import Progress, Silent
from photonmap.record import describe_camera, describe_measured_sets, describe_versions
from photonmap.result import Result
from photonmap.scene import Scene
from photonmap.workers import Workers

LARGEST_SIDE = 1 << 16
MOST_PHOTONS = 1 << 32
MOST_THREADS = 1024

FEW_CUTS = 1e-5
"""Share of photons that may be cut before a warning is due: less than errors can show."""


def render(
    scene: Scene,
    *,
    bands: Bands | int | str = 6,
    size: tuple[int, int] = (512, 512),
    pixel: Literal["box", "center"] = "box",
    passes: int | None = None,
    seconds: float | None = None,
    error: float | None = None,
    photons: int | None = None,
    seed: int = 0,
    threads: int | None = None,
    method: Literal["photon", "path"] = "photon",
    effects: str | Iterable[str] = "auto",
    per_light: bool = False,
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
        A render that aims at an error stops after an hour anyway.
    photons : emitted in each pass; None takes one for each pixel, 16384 at least
    seed : with the same passes, the same arrays bit for bit, for any number of threads
    threads : None takes every processor
    method : photon mapping, or the plain "path" tracer that arbitrates
    effects : "auto" simulates what the scene calls for, "all" everything, and a list of names, or
        names separated by commas, those alone: see `photonmap.effects`
    per_light : split direct, indirect, caustics and shading by groups of lights too
    progress : is told how far the render is

    Returns
    -------
    Result. Ctrl-C ends the passes early: what is done is returned, and the record says so.

    Raises
    ------
    InputError : input that cannot be rendered
    KeyboardInterrupt : Ctrl-C before the first pass was complete
    """
    start = time.perf_counter()
    progress = progress or Silent()
    bands, budget = Bands.parse(bands), Budget.choose(passes, seconds, error)
    wanted = parse_effects(effects)
    film = _film(size, pixel)
    pixels = film.width * film.height
    photons = max(pixels, LEAST_PHOTONS) if photons is None else photons
    _check_numbers(photons, seed, threads, method)
    faces = sum(len(mesh.faces) for mesh in scene.meshes)
    check_memory(pixels, 1, photons, faces)

    with listening() as told, Workers(threads) as workers:
        prepared = prepare(scene, bands, film.width / film.height)
        plan, columns, prepared = _plan(prepared, wanted, bands.count, per_light)
        carried = carry(prepared, columns)
        carried_and_whole = columns.count + per_light * columns.distinct
        check_memory(pixels, carried_and_whole, photons, faces, carried.optics is not None)
        loaded = time.perf_counter()
        progress.stage("compile" if is_compiled(prepared, method) else "first compile")
        compile_kernels(prepared, bands, workers, method)
        compiled = time.perf_counter()
        progress.stage("render")
        warn_of_hidden_lights(prepared, film, stream_key(seed, 0, PROBE))
        run = Passes(carried, film, columns.count, photons, seed, workers, method, plan)
        moments = Ledger(columns, pixels, workers, carried.optics is not None)
        with workers.holding_interrupts():
            interrupted = _run_passes(run, moments, budget, progress)
        _warn_of_cuts(run, moments.whole, budget, time.perf_counter() - compiled)
        outcome = _outcome(run, moments.whole)
        flat, errors = _finish(prepared, film, run, moments, workers)
        rendering = time.perf_counter() - compiled

    record = {
        "scene": {"name": scene.name, **prepared.counts},
        "arguments": {
            "size": [film.width, film.height],
            "pixel": pixel,
            "budget": {name: value for name, value in asdict(budget).items() if value},
            "photons": photons,
            "seed": seed,
            "threads": workers.threads,
            "method": method,
            "effects": wanted if isinstance(wanted, str) else sorted(wanted),
            "per_light": per_light,
        },
        "effects": plan.describe(run.effect_seconds),
        "partial": plan.partial,
        "light_groups": list(columns.groups) if per_light else [],
        "bands": bands.describe(),
        "camera": {"framed": scene.camera is None, **describe_camera(prepared.camera, film)},
        "measured_sets": describe_measured_sets(),
        "versions": describe_versions(),
        **outcome,
        "interrupted": interrupted,
        "seconds": {
            "load": loaded - start,
            "compile": compiled - loaded,
            "photons": run.photon_seconds,
            "camera": rendering - run.photon_seconds,
            "render": rendering,
        },
        "warnings": told,
    }
    return Result(_images(flat, film), _images(errors, film), bands, record)


def _plan(
    prepared: Prepared, wanted: str | frozenset[str], bands: int, per_light: bool
) -> tuple[EffectPlan, Columns, Prepared]:
    """Decide on effects and columns; return both, and the scene without what is left out."""
    plan = plan_effects(prepared, wanted, count_distinct(prepared), bands)
    left = leave_out(prepared, plan)
    return plan, choose_columns(left, plan.on("band_merging"), per_light), left


def _film(size: tuple[int, int], pixel: str) -> Film:
    width, height = size
    if not all(isinstance(side, int | np.integer) for side in size) or min(size) < 1:
        raise InputError(f"size {width}x{height} must be whole pixels, 1x1 at least")
    if max(size) > LARGEST_SIDE:
        raise InputError(f"size {width}x{height} is too large: {LARGEST_SIDE} a side at most")
    if pixel not in ("box", "center"):
        raise InputError(f"pixel {pixel!r} is neither 'box' nor 'center'")
    return Film(int(width), int(height), pixel == "box")


def _check_numbers(photons: int, seed: int, threads: int | None, method: str) -> None:
    for name, value, low, high in (
        ("photons", photons, 0, MOST_PHOTONS),
        ("seed", seed, 0, 2**63 - 1),
        ("threads", 1 if threads is None else threads, 1, MOST_THREADS),
    ):
        if not isinstance(value, int | np.integer) or not low <= value <= high:
            raise InputError(f"{name} {value} must be a whole number from {low} to {high}")
    if method not in ("photon", "path"):
        raise InputError(f"method {method!r} is neither 'photon' nor 'path'")


def _run_passes(run: Passes, moments: Ledger, budget: Budget, progress: Progress) -> bool:
    """Take passes into the moments until the budget is spent; True if Ctrl-C ended them."""
    start = time.perf_counter()
    whole, error, elapsed = moments.whole, np.inf, 0.0
    try:
        while not budget.is_spent(whole.count, error, elapsed):
            moments.add(run.run(whole.count), run.seen)
            error = whole.error()
            elapsed = time.perf_counter() - start
            fraction = budget.fraction(whole.count, error, elapsed)
            progress.update(whole.count, error, fraction, elapsed, run.rays / elapsed)
    except KeyboardInterrupt:
        if whole.count == 0:
            raise
        return True
    return False


def _warn_of_cuts(run: Passes, moments: Accumulator, budget: Budget, elapsed: float) -> None:
    if run.cut > FEW_CUTS * run.photons:
        warn(
            f"{run.cut} of {run.photons} photons were cut after {MAX_BOUNCES} bounces: surfaces "
            f"reflect nearly everything, and light is missing from indirect"
        )
    if chains := moments.cut():
        warn(
            f"{chains} pixels see chains of more than {MOST_SMOOTH} reflections, as between facing "
            f"mirrors: what is beyond is missing"
        )
    if budget.error is not None and elapsed >= 0.9 * CEILING:
        warn(f"stopped after {CEILING:.0f} s, before the error {budget.error} was reached")


def _outcome(run: Passes, moments: Accumulator) -> dict[str, Any]:
    """Return what the record says of the passes."""
    error = moments.error()
    return {
        "passes": moments.count,
        "photons": run.photons,
        "photons_stored": run.stores,
        "rays": run.rays,
        "error": error if math.isfinite(error) else None,
    }


def _finish(
    prepared: Prepared, film: Film, run: Passes, moments: Ledger, workers: Workers
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return all buffers, in the order of `BUFFERS`, and their errors, one row a pixel."""
    light, errors = moments.finish(prepared.power)
    flat = {
        **light,
        "unresolved": moments.whole.unresolved() & (run.stores > 0),
        **first_hit_buffers(prepared, film, workers),
    }
    return {name: flat[name] for name in sorted(flat, key=_place)}, errors


def _place(name: str) -> int:
    """Return where a buffer stands in the order of `BUFFERS`; those of groups come last."""
    return BUFFERS.index(name) if name in BUFFERS else len(BUFFERS)


def _images(flat: dict[str, Any], film: Film) -> dict[str, Any]:
    """Give arrays of one row a pixel the shape of the image."""
    return {
        name: values.reshape(film.height, film.width, *values.shape[1:])
        for name, values in flat.items()
    }
