"""Render a scene: the algorithm's table of contents.

scene → compile → passes: [photons → radiosity cache → camera pass → irradiance sharing] → moments
→ stop → buffers, standard errors, run record
"""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import closing, nullcontext
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import DEFAULT, Omission, in_order, kept_in
from photonmap.compile.effects import EffectPlan, leave_out, plan_effects
from photonmap.compile.lights.probabilities import downweight_hidden
from photonmap.compile.scene_arrays import (
    CompiledScene,
    compile_scene,
    describe_run,
)
from photonmap.compile.spectral_columns import (
    SpectralColumns,
    carry,
    choose_columns,
    count_distinct,
)
from photonmap.errors import listening, naming_file
from photonmap.film.bias import BiasProbe
from photonmap.film.budget import refuse_omitted
from photonmap.film.illuminations import IlluminationMoments, IlluminationProbes, Mix
from photonmap.film.light_filter import FILTERED, LightFilter
from photonmap.film.light_groups import LightGroups
from photonmap.integrators.adaptive_sampling import AdaptiveSampling
from photonmap.integrators.base import Integrator, PassSetup, stream_key
from photonmap.integrators.choice import check_unbiased, make_integrator
from photonmap.integrators.first_hits import first_hit_buffers
from photonmap.integrators.kernel_warmup import compile_kernels, is_compiled
from photonmap.integrators.memory_estimate import Work
from photonmap.integrators.missing_light import (
    find_hidden_lights,
    warn_of_empty_image,
    warn_of_few_photons,
    warn_of_lost_caustics,
    warn_of_truncated_paths,
)
from photonmap.integrators.render_loop import RenderLoop
from photonmap.integrators.shared_work import SharedScene, SharedWork
from photonmap.io.scene_source import SceneSource
from photonmap.kernels.core.passes import Film, View
from photonmap.kernels.core.streams import Domain
from photonmap.results.record import (
    Clock,
    describe_measured_sets,
    describe_seconds,
    describe_versions,
)
from photonmap.results.result import Result
from photonmap.runtime.checkpoint import Checkpoint
from photonmap.runtime.options import taking_keywords_of
from photonmap.runtime.progress import Progress, Silent, Watching
from photonmap.runtime.storage import Storage, check_memory
from photonmap.runtime.workers import Workers
from photonmap.scene.scene import Scene, check_scene
from photonmap.settings import Options, Settings, Views
from photonmap.spectra.photometry import describe_luminance, warn_of_luminance
from photonmap.spectra.projection import default_method


@taking_keywords_of(Options)
def render(scene: Scene | str | PathLike[str], options: Options) -> Result:
    """Render a scene into ground-truth buffers with standard errors.

    Parameters
    ----------
    scene : meshes, lights, camera; or the file of a scene, see `photonmap.load_scene`
    options : see `photonmap.settings.Options`

    Returns
    -------
    Result. Ctrl-C ends the passes early: those that are complete count, and the record says so.

    Raises
    ------
    InputError : the scene or an option cannot be rendered, or the checkpoint is of another render
    KeyboardInterrupt : Ctrl-C before the first pass was complete
    """
    if isinstance(scene, str | PathLike):
        return render_file(SceneSource(os.fspath(scene)), options)
    return render_scene(check_scene(scene), options)


@taking_keywords_of(Views)
def render_views(scene: Scene | str | PathLike[str], options: Views) -> Iterator[Result]:
    """Render a scene once for each of several cameras, at less than the cost of so many renders.

    The views share what does not depend on the camera: the file that is read, the compiled scene,
    and the photons, cells and caustic maps of each pass, as far as they fit into memory. Each
    result is that of `render` for the camera and the seed, bit for bit, with errors of its own; see
    docs/guide.md on how errors of different views are correlated.

    Parameters
    ----------
    scene : meshes, lights, cameras; or the file of a scene, see `photonmap.load_scene`
    options : see `photonmap.settings.Views`

    Returns
    -------
    Iterator of results, one a camera, in their order: a view is rendered when its result is asked
    for, and one at a time is in memory. Options hold for each view by itself: its passes, its
    error, its seconds. With a checkpoint FILE.checkpoint, view k has FILE-k.checkpoint, from 0.
    After Ctrl-C the view under way is the last.

    Raises
    ------
    InputError : there are no cameras, one is not valid, or as `render`
    KeyboardInterrupt : as `render`
    """
    Settings.of(options)  # what cannot be done is refused at once
    if isinstance(scene, str | PathLike):
        scene = SceneSource(os.fspath(scene)).load()
    return _render_each(check_scene(scene).seen_by_each(options.cameras), options)


def _render_each(views: list[Scene], options: Views) -> Iterator[Result]:
    with SharedWork(options.threads, Settings.of(options).memory) as shared:
        for number, scene in enumerate(views):
            own = options
            if options.checkpoint is not None:
                file = Path(options.checkpoint)
                file = file.with_name(f"{file.stem}-{number}{file.suffix}")
                own = replace(options, checkpoint=file)
            result = render_scene(scene, own, shared=shared)
            yield result
            if result.record["interrupted"]:
                return


def render_scene(
    scene: Scene,
    options: Options,
    announce: Announce | None = None,
    shared: SharedScene | None = None,
) -> Result:
    """Render a scene; `announce` and what is `shared` are as of `render_file`."""
    settings, clock = Settings.of(options), Clock()
    work = shared if isinstance(shared, SharedWork) else None
    pool = Workers(settings.threads) if work is None else nullcontext(work.workers)
    with listening() as messages, pool as workers, closing(shown_progress(options, settings)):
        plan = compile_and_plan(scene, settings, shared)
        clock.lap("load")
        if announce is not None:
            announce(scene, plan)
        load_kernels(plan, settings, clock, workers)
        run = start_run(plan, settings, workers, work)
        take_passes(scene, run)
        return as_result(scene, run, clock, messages)


def shown_progress(options: Options, settings: Settings) -> Any:
    """Return the progress that is to be closed after a render."""
    return settings.progress if options.progress is True else Silent()


def load_kernels(plan: RenderPlan, settings: Settings, clock: Clock, workers: Workers) -> None:
    """Compile the kernels that a scene needs, if they are not known."""
    known = is_compiled(plan.scene, settings.integrator)
    settings.progress.stage("compile" if known else "first compile")
    if not known:
        compile_kernels(plan.scene, settings.bands, workers, settings.integrator)
    clock.lap("compile")


def take_passes(scene: Scene, run: Run) -> None:
    """Take passes until the budget is spent.

    Photons → radiosity cache → camera pass → irradiance sharing → moments → stop?
    """
    run.settings.progress.stage("render")
    with run.workers.holding_interrupts():
        run.loop.run(_watched(scene, run))
    warn_of_truncated_paths(run.integrator, run.moments.whole)
    run.loop.warn_of_missed_goal()


def as_result(scene: Scene, run: Run, clock: Clock, messages: list[str]) -> Result:
    """Return what passes have given, with the run record."""
    passes = describe_passes(run)
    images = assemble_images(run)
    clock.lap("render")
    photons = run.integrator.counters.photon_seconds
    saving = run.loop.saving if run.loop.saves else None
    record = {
        **describe_plan(scene, run),
        "effects": run.plan.effects.describe(run.integrator.effect_seconds),
        **passes,
        "unresolved": int(images.unresolved.sum()),
        "seconds": describe_seconds(clock.seconds, run.loop.earlier, photons, saving),
        "warnings": messages,
    }
    bands = run.settings.bands
    return Result(images.buffers, images.errors, bands, record, images.block_errors)


def render_file(
    source: SceneSource,
    options: Options,
    announce: Announce | None = None,
    shared: SharedWork | None = None,
) -> Result:
    """Load a scene and render it; its record has the seconds and the warnings of loading too.

    Parameters
    ----------
    announce : called with the scene and how it will be simulated, before the passes begin
    shared : by renders that follow each other; None for nothing

    Raises
    ------
    InputError, KeyboardInterrupt : as `SceneSource.load` and `render`
    """
    start = time.perf_counter()
    Settings.of(options)  # what cannot be done is refused before a large file is read
    with listening() as messages:
        if not isinstance(options.progress, bool | None):
            options.progress.stage("load")
        scene = source.load() if shared is None else shared.load(source)
        loading = time.perf_counter() - start
        result = render_scene(scene, options, announce, shared)
    result.record["warnings"] = messages
    result.record["seconds"]["load"] += loading
    return result


@dataclass(frozen=True)
class RenderPlan:
    """A compiled scene, and how it is simulated.

    Parameters
    ----------
    scene : after disabled effects are removed, in the bands of the render
    pass_scene : the same in the spectral columns that passes carry
    effects : which are simulated
    columns : the spectral columns
    kept : names of the buffers to be kept
    storage : where large arrays lie
    fingerprint : what decides the arrays
    light_luminance : of each light by the bands, and the exact one
    """

    scene: CompiledScene
    pass_scene: CompiledScene
    effects: EffectPlan
    columns: SpectralColumns
    kept: frozenset[str]
    storage: Storage
    fingerprint: dict[str, Any]
    light_luminance: list[dict[str, Any]]


Announce = Callable[[Scene, RenderPlan], None]
Sums = tuple[LightGroups, BiasProbe]
"""What passes add up to"""


@dataclass(frozen=True)
class Run:
    """A render under way.

    Parameters
    ----------
    plan, settings : what is rendered, and how
    workers : share the work of a pass
    hidden_lights : names of the lights that seem to send nothing into the view
    integrator : runs passes
    moments : what the passes add up to
    loop : takes passes into the moments until the budget is spent
    parts : moments and probes of each illumination
    """

    plan: RenderPlan
    settings: Settings
    workers: Workers
    hidden_lights: list[str]
    integrator: Integrator
    moments: LightGroups
    loop: RenderLoop
    parts: Sequence[Sums]

    def of_part(self, number: int, plan: RenderPlan) -> Run:
        """Return the run that took the same passes under one of the illuminations alone."""
        moments, probe = self.parts[number]
        loop = self.loop.of_part(moments, probe)
        return replace(self, plan=plan, hidden_lights=[], moments=moments, loop=loop)


@dataclass(frozen=True)
class Images:
    """What a render gives: (H, W) or (H, W, N) arrays by buffer; errors of blocks by block.

    Parameters
    ----------
    buffers, errors, block_errors : those to be kept, and their standard errors
    unresolved : (P,) bool: pixels for whose indirect light no photon was found
    """

    buffers: dict[str, NDArray[Any]]
    errors: dict[str, NDArray[Any]]
    block_errors: dict[str, NDArray[Any]]
    unresolved: NDArray[np.bool_]


def compile_and_plan(
    scene: Scene, settings: Settings, shared: SharedScene | None = None, illuminations: int = 0
) -> RenderPlan:
    """Compile a scene into arrays, and decide on effects, spectral columns and storage.

    The arrays of a scene that was compiled for another view are `shared`. If it stands for several
    illuminations, their number decides on memory, and no bands are merged, as they differ.

    Raises
    ------
    InputError : the scene cannot be rendered as it is asked for, or needs too much memory
    """
    film, bands, passes = settings.film, settings.bands, settings.budget.passes
    faces = sum(len(mesh.faces) for mesh in scene.meshes)
    unbiased, buffers = settings.unbiased, settings.buffers or DEFAULT
    least = Work(
        settings.pixels, 1, settings.photons, faces, passes, unbiased=unbiased, buffers=buffers
    )
    check_memory(least.need, settings.memory)  # refused before time is spent on compiling
    compiled = (shared.compile if shared else compile_scene)(scene, bands, film.width / film.height)
    fingerprint = describe_run(compiled, bands, film, settings.deciding)
    effects = plan_effects(compiled, settings.effects, count_distinct(compiled), bands.count)
    simulated = leave_out(compiled, effects)
    merges = effects.on("band_merging") and not illuminations
    with naming_file(scene.lights_file or scene.file):
        columns = choose_columns(simulated, merges, settings.per_light)
    pass_scene = carry(simulated, columns)
    has_specular = simulated.specular is not None and simulated.specular.kind.any()
    has_specular = bool(has_specular or simulated.is_thin.any())
    kept = settings.buffers or kept_in(effects.on("glossy"), has_specular)
    work = replace(
        least,
        bands=max(illuminations, 1) * (columns.count + settings.per_light * columns.distinct),
        specular=pass_scene.has_residual,
        fluorescent=pass_scene.fluorescence is not None,
        per_light=settings.per_light,
        filtered=settings.filter_light,
        buffers=kept,
    )
    storage = check_memory(work.need, settings.memory)
    check_unbiased(unbiased, compiled.specular is not None, pass_scene.specular is not None)
    warn_of_lost_caustics(settings.method, simulated, effects)
    lacking: dict[Omission, bool] = {
        "without mirrors, glass or rough surfaces": not pass_scene.has_residual,
        "without fluorescent surfaces": pass_scene.fluorescence is None,
    }
    refuse_omitted(settings.budget.goal, kept, [why for why, is_so in lacking.items() if is_so])
    method = default_method(bool(compiled.counts["spectra"]))
    lights = describe_luminance(bands, scene.light_colors, method)
    warn_of_luminance([light for light in lights if light["lines"]])
    return RenderPlan(simulated, pass_scene, effects, columns, kept, storage, fingerprint, lights)


def start_run(
    plan: RenderPlan,
    settings: Settings,
    workers: Workers,
    shared: SharedWork | None = None,
    mixes: Sequence[Mix] = (),
) -> Run:
    """Prepare the passes, their moments and the loop over them, from the checkpoint if resumed.

    Photons are `shared` by views that need the same. There are moments for each of the
    illuminations that are mixed, if there are any.

    Raises
    ------
    InputError : the checkpoint is damaged, or of a different render
    """
    integrator, hidden = _make_integrator(plan, settings, workers, shared)
    adapts = settings.adaptive and integrator.adapts
    filtered = [name for name in FILTERED if why_unfiltered(name, plan, settings) is None]
    film, storage = settings.film, plan.storage
    surfaces = (lambda: integrator.surfaces) if filtered else None
    light_filter = LightFilter(filtered, film, workers, surfaces, storage) if surfaces else None
    parts = [
        _make_sums(plan, settings, workers, integrator, each, light_filter)
        for each in [mix.columns for mix in mixes] or [plan.columns]
    ]
    moments, probe = _as_one(integrator, parts, mixes) if mixes else parts[0]
    file = settings.checkpoint
    loop = RenderLoop(
        integrator,
        moments,
        settings.budget,
        probe,
        AdaptiveSampling(film, plan.columns, storage, surfaces) if adapts else None,
        settings.pass_samples,
        None if file is None else Checkpoint(file, plan.fingerprint),
        settings.resume,
    )
    return Run(plan, settings, workers, hidden, integrator, moments, loop, parts)


def _make_integrator(
    plan: RenderPlan, settings: Settings, workers: Workers, shared: SharedWork | None
) -> tuple[Integrator, list[str]]:
    """Return what runs passes, and the lights that seem hidden, which it rarely samples."""
    film = settings.film
    view = View(plan.scene.film_camera(film.width, film.height), film)
    key = stream_key(settings.seed, 0, Domain.LIGHT_VISIBILITY)
    hidden = find_hidden_lights(plan.scene, view, key)
    lights = downweight_hidden(plan.pass_scene.lights, plan.pass_scene.light_names, hidden)
    setup = PassSetup(
        replace(plan.pass_scene, lights=lights),
        film,
        plan.columns.count,
        settings.photons,
        settings.seed,
        workers,
        plan.effects,
        plan.storage,
        shared=shared,
        light=_describe_light(plan, hidden),
    )
    return make_integrator(settings.integrator, setup), hidden


def _make_sums(
    plan: RenderPlan,
    settings: Settings,
    workers: Workers,
    integrator: Integrator,
    columns: SpectralColumns,
    light_filter: LightFilter | None,
) -> Sums:
    moments = LightGroups(
        columns,
        settings.film,
        workers,
        plan.pass_scene.has_residual,
        plan.storage,
        plan.pass_scene.fluorescence is not None,
        integrator.adapts,
        light_filter,
    )
    return moments, BiasProbe(integrator, settings.film, columns)


def why_unfiltered(name: str, plan: RenderPlan, settings: Settings) -> str | None:
    """Return why direct or indirect light is not filtered; None if it is."""
    cases = {
        "it was turned off": not settings.filter_light,
        "path tracing and renders without bias share nothing": settings.integrator != "photon",
        f"there is no {name} light": not plan.effects.on(name),
        "all shadows are sharp": name == "direct" and not plan.effects.on("soft_shadows"),
    }
    return next((why for why, is_so in cases.items() if is_so), None)


def _as_one(integrator: Integrator, parts: Sequence[Sums], mixes: Sequence[Mix]) -> Any:
    """Return moments and probe of all illuminations, as the render loop takes them."""
    moments = IlluminationMoments([moments for moments, _ in parts], mixes)
    return moments, IlluminationProbes(integrator, [probe for _, probe in parts], moments)


def _describe_light(plan: RenderPlan, hidden: list[str]) -> Hashable:
    """Return what decides the photons of all passes: all that decides the arrays but the camera."""
    deciding = {name: value for name, value in plan.fingerprint.items() if name != "camera"}
    simulated = [name for name, effect in plan.effects.effects.items() if effect.on]
    return json.dumps([deciding, simulated, hidden])


def assemble_images(run: Run) -> Images:
    """Return the buffers to be kept, in their usual order, with their standard errors.

    Warns where photons were too few to resolve the image, and where it shows nothing.
    """
    plan, film, kept = run.plan, run.settings.film, run.plan.kept
    moments, power = run.moments, run.plan.scene.power
    light, errors = moments.finish(power, kept)
    unresolved = moments.whole.unresolved() & run.integrator.stores_photons
    rest = {"unresolved": unresolved, "passes": moments.whole.counts}
    rest |= first_hit_buffers(plan.scene, film, run.workers, kept, plan.storage)
    buffers = in_order(light | {name: rows for name, rows in rest.items() if name in kept})
    if some_shine := set(run.hidden_lights) != set(plan.scene.light_names):
        warn_of_few_photons(unresolved)
    warn_of_empty_image(moments.whole, some_shine and plan.effects.on("direct"))
    blocks = moments.block_errors(power, kept)
    return Images(_as_images(buffers, film), _as_images(errors, film), blocks, unresolved)


def _watched(scene: Scene, run: Run) -> Progress:
    """Return the progress that a run reports to, which shows images too if that is asked for."""
    settings, watch = run.settings, run.settings.watch

    def snapshot(passes: int) -> Result:
        light, _ = run.moments.finish(run.plan.scene.power, run.plan.kept)
        shown = min(passes, run.moments.whole.count)
        record = {**describe_plan(scene, run), "passes": shown}
        return Result(_as_images(in_order(light), settings.film), {}, settings.bands, record)

    return Watching(settings.progress, watch, snapshot) if watch else settings.progress


def _as_images(rows: dict[str, NDArray[Any]], film: Film) -> dict[str, NDArray[Any]]:
    """Give arrays of one row per pixel, (P, …), the shape of the image, (H, W, …)."""
    return {
        name: values.reshape(film.height, film.width, *values.shape[1:])
        for name, values in rows.items()
    }


def describe_plan(scene: Scene, run: Run) -> dict[str, Any]:
    """Return what the record says of scene and options."""
    plan, settings = run.plan, run.settings
    film = settings.film
    camera = plan.scene.camera.describe(film.width, film.height)
    return {
        "scene": {"name": scene.name, **plan.scene.counts},
        "objects": plan.scene.object_names,
        "materials": plan.scene.material_names,
        "arguments": settings.describe(run.workers.threads),
        "partial": plan.effects.partial,
        "light_groups": list(plan.columns.groups) if settings.per_light else [],
        "bands": settings.bands.describe(),
        "camera": {"framed": scene.camera is None, **camera},
        "white": plan.scene.white.tolist(),
        "light_luminance": plan.light_luminance,
        "group_whites": plan.scene.group_whites if settings.per_light else {},
        "measured_sets": describe_measured_sets(),
        "versions": describe_versions(),
        "fingerprint": plan.fingerprint,
    }


def describe_filter(run: Run) -> dict[str, Any]:
    """Return what the record says of filtered light."""
    filters, described = run.moments.describe_filters(), {}
    for name in FILTERED:
        if name in filters:
            described[name] = {"on": True, **filters[name]}
        else:
            why = why_unfiltered(name, run.plan, run.settings)
            why = why or "passes are few, or no flat pixel has noise"
            described[name] = {"on": False, "why": why}
    return described


def describe_passes(run: Run) -> dict[str, Any]:
    """Return what the record says of the passes."""
    integrator, loop, moments = run.integrator, run.loop, run.moments.filtered
    error, bias = moments.error(lit=integrator.stores_photons), loop.bias
    known = math.isfinite(error) and moments.states_error(integrator.stores_photons)
    return {
        "passes": moments.count,
        "pass_samples": loop.pass_samples,
        **integrator.counters.describe(),
        "light_filter": describe_filter(run),
        "error": math.hypot(error, bias or 0.0) if known else None,
        "standard_error": error if known else None,
        "bias": bias,
        "bias_blocks": loop.describe_bias_blocks(run.plan.scene.power),
        "goal": loop.describe_goal(),
        "interrupted": loop.interrupted,
        "resumed": loop.resumed,
        "predicted_seconds": loop.predicted,
    }
