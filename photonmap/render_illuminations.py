"""Render scenes that differ in the spectra of their lights alone, at about the cost of one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace

import numpy as np

from photonmap.compile.effects import Effect
from photonmap.compile.illuminations import combine
from photonmap.compile.scene_arrays import CompiledScene, compile_arrays
from photonmap.compile.spectral_columns import SpectralColumns
from photonmap.errors import InputError, listening, only_heard
from photonmap.film.illuminations import Mix
from photonmap.integrators.shared_work import SharedScene
from photonmap.render import (
    RenderPlan,
    as_result,
    compile_and_plan,
    load_kernels,
    shown_progress,
    start_run,
    take_passes,
)
from photonmap.results.record import Clock
from photonmap.results.result import Result
from photonmap.runtime.workers import Workers
from photonmap.scene.scene import Scene
from photonmap.settings import Options, Settings
from photonmap.spectra.bands import Bands


def render_illuminations(scenes: Sequence[Scene], options: Options) -> Iterator[Result]:
    """Render scenes that differ in the spectra of their lights alone, at about the cost of one.

    Each result has the errors and the bias of its own light, and passes go on until the worst of
    the errors meets the goal. All have the same noise, up to the spectra and shares of lights.

    Parameters
    ----------
    scenes : that `photonmap.compile.illuminations.combine` makes one of
    options : of the render, without a checkpoint

    Raises
    ------
    InputError, KeyboardInterrupt : as `render`
    """
    settings, clock = Settings.of(options), Clock()
    union = combine(scenes, settings.bands)
    if union is None or settings.checkpoint is not None:
        raise InputError("scenes differ in more than the spectra of lights, or have a checkpoint")
    with Workers(settings.threads) as workers, closing(shown_progress(options, settings)):
        with only_heard():  # those of `scenes`
            split = replace(settings, per_light=True)
            plan = compile_and_plan(union.scene, split, None, len(scenes))
        plans = [_plan_part(scene, settings, plan) for scene in scenes]
        clock.lap("load")
        load_kernels(plan, settings, clock, workers)
        mixes = [
            Mix(own.columns, union.factors(number, own.columns.groups, plan.columns.groups))
            for number, (own, _) in enumerate(plans)
        ]
        with listening() as messages:
            run = start_run(plan, settings, workers, mixes=mixes)
            take_passes(union.scene, run)
        for number, (scene, (own, heard)) in enumerate(zip(scenes, plans, strict=True)):
            with listening() as further:
                result = as_result(scene, run.of_part(number, own), clock, further)
            result.record["warnings"] = [*heard, *messages, *further]
            yield result


def _plan_part(scene: Scene, settings: Settings, whole: RenderPlan) -> tuple[RenderPlan, list[str]]:
    """Return how one of the illuminations of a whole is simulated, and the warnings of it."""

    class Same(SharedScene):
        def compile(self, scene: Scene, bands: Bands, aspect: float) -> CompiledScene:
            compiled, other = compile_arrays(scene, bands, aspect), whole.scene
            hashes = compiled.hashes
            same = replace(
                compiled, geometry=other.geometry, embree=other.embree, power=other.power
            )
            same.hashes = hashes
            return same

    with listening() as messages:
        plan = compile_and_plan(scene, settings, Same())
    bands = settings.bands.count
    columns = SpectralColumns(np.arange(bands), plan.columns.groups)
    apart = Effect(False, "bands of illuminations that are rendered together differ")
    effects = replace(plan.effects, effects={**plan.effects.effects, "band_merging": apart})
    fingerprint = {**plan.fingerprint, "illuminations": whole.fingerprint["lights"]}
    plan = replace(
        plan, columns=columns, effects=effects, fingerprint=fingerprint, storage=whole.storage
    )
    return plan, messages
