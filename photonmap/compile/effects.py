"""The plan of effects: every one on or off, and why; and scenes without what it leaves out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.scene_arrays import CompiledScene
from photonmap.compile.scene_demands import EFFECTS, Effect, called_for, sides_in_air
from photonmap.errors import InputError
from photonmap.kernels.bsdf.models import LAMBERTIAN, NARROW
from photonmap.kernels.core.records import (
    GLASS,
    MIRROR,
    Alpha,
    Environment,
    GlassShare,
    Lights,
    Media,
    Scattering,
    Specular,
)
from photonmap.runtime.options import read_list
from photonmap.runtime.wording import suggest


@dataclass(frozen=True)
class EffectPlan:
    """All effects by name.

    Parameters
    ----------
    effects : in the order of `EFFECTS`
    partial : some effects that the scene calls for were left out on request
    """

    effects: dict[str, Effect]
    partial: bool = False

    def on(self, name: str) -> bool:
        """Return whether an effect is simulated."""
        return self.effects[name].on

    def describe(self, seconds: dict[str, float]) -> dict[str, dict[str, object]]:
        """Return the JSON-able record: name to on, why, seconds (None where not timed apart)."""
        return {
            name: {"on": effect.on, "why": effect.why, "seconds": seconds.get(name)}
            for name, effect in self.effects.items()
        }


def parse_effects(wanted: str | Iterable[str]) -> str | frozenset[str]:
    """Return "auto", "all" or a set of names.

    Raises
    ------
    InputError
        if a name is not known, with the nearest one
    """
    names = read_list(wanted)
    if names in (["auto"], ["all"]):
        return names[0]
    for name in names:
        if name not in EFFECTS:
            raise InputError(f"there is no effect {name!r}; {suggest(name, EFFECTS)}")
    return frozenset(names)


def plan_effects(
    compiled: CompiledScene, wanted: str | frozenset[str], distinct: int, bands: int
) -> EffectPlan:
    """Decide what is simulated.

    Parameters
    ----------
    compiled : the scene
    wanted : "auto", "all", or the names of those to simulate alone
    distinct : different bands of the scene
    bands : all of them
    """
    called = called_for(compiled, distinct, bands)
    if wanted == "auto":
        return EffectPlan(called)
    if wanted == "all":
        forced = {
            name: Effect(True, effect.why if effect.on else f"forced, though {effect.why}")
            for name, effect in called.items()
        }
        for name in (
            "media",
            "dispersion",
            "alpha",
            "environment",
            "textures",
            "relief",
            "glossy",
            "non_lambertian",
        ):
            if not called[name].on:
                forced[name] = called[name]
        forced["band_merging"] = Effect(False, "every band is traced on its own")
        return EffectPlan(forced)
    assert not isinstance(wanted, str)
    chosen = {
        name: effect if name in wanted or not effect.on else Effect(False, "left out on request")
        for name, effect in called.items()
    }
    partial = any(called[name].on != chosen[name].on for name in EFFECTS if name != "band_merging")
    return EffectPlan(chosen, partial)


def leave_out(compiled: CompiledScene, plan: EffectPlan) -> CompiledScene:
    """Return the scene without what a plan leaves out.

    Mirrors, glass and the sky turn black, textures become their mean (of the strength of
    anisotropy, the largest), reliefs flat, cut-outs opaque, glossy surfaces and those with a sheen
    their bare base, and other BSDFs Lambertian. What is forced on gets its code, though nothing
    calls for it.
    """
    lights, geometry = compiled.lights, compiled.geometry
    if lights.environment is not None and not plan.on("environment"):
        lights = _darken_sky(lights, lights.environment)
    textures = compiled.textures
    if not plan.on("textures"):
        textures, lights = None, lights._replace(emission_textures=None)
    return replace(
        compiled,
        geometry=geometry._replace(
            alpha=_leave_out_holes(geometry.alpha, plan),
            relief=geometry.relief if plan.on("relief") else None,
        ),
        lights=lights,
        specular=_leave_out_specular(compiled, plan),
        textures=textures,
        scattering=_leave_out_scattering(compiled.scattering, plan),
    )


def _darken_sky(lights: Lights, environment: Environment) -> Lights:
    """Return the lights with a black sky."""
    spectra = lights.spectra.copy()
    spectra[environment.row] = 0.0
    dark = environment._replace(basis=np.zeros_like(environment.basis))
    return lights._replace(environment=dark, spectra=spectra)


def _leave_out_holes(alpha: Alpha | None, plan: EffectPlan) -> Alpha | None:
    """Return the opacities that are simulated; None where all surfaces are opaque."""
    if alpha is None:
        return None
    if not plan.on("transmission"):
        alpha = alpha._replace(panes=None)
    elif alpha.panes is not None and not plan.on("textures"):
        none = np.full_like(alpha.panes.image, -1)
        alpha = alpha._replace(panes=alpha.panes._replace(image=none, maps=None))
    if plan.on("alpha"):
        return alpha
    whole, none = np.ones_like(alpha.value), np.full_like(alpha.image, -1)
    return None if alpha.panes is None else alpha._replace(value=whole, image=none)


def _leave_out_specular(compiled: CompiledScene, plan: EffectPlan) -> Specular | None:
    """Return the specular lobes that are simulated; None where there is none."""
    specular = compiled.specular
    if specular is None:
        if not plan.on("specular"):
            return None
        count = len(compiled.materials.reflectance)
        none = np.zeros_like(compiled.materials.reflectance)
        kind = np.zeros(count, np.uint8)
        black = kind, none, np.zeros(count), none.copy(), np.zeros(count)
        no_dip = np.zeros((count, 0, 0), np.float32)
        return Specular(*black, np.zeros(0), None, no_dip, None, None, none[:0], None)
    by_kind = {GLASS: plan.on("transmission"), MIRROR: plan.on("specular")}
    kept = np.array([by_kind.get(kind, True) for kind in specular.kind.tolist()])
    kept = np.where(compiled.is_thin, plan.on("transmission"), kept)
    alpha = specular.alpha
    if len(alpha):
        kept = np.where(alpha > 0.0, kept & plan.on("glossy"), kept)
        alpha = np.where(kept, alpha, 0.0)
    has_rough = bool(alpha.any())
    specular = specular._replace(
        kind=np.where(kept, specular.kind, 0).astype(np.uint8),
        probability=np.where(kept, specular.probability, 0.0),
        alpha=alpha if has_rough else np.zeros(0),
        anisotropy=specular.anisotropy if has_rough else None,
        media=_leave_out_media(compiled, specular.media, plan),
        maps=specular.maps if plan.on("textures") else None,
        share=_even(specular.share, plan),
    )
    return specular if specular.kind.any() else None


def _even(share: GlassShare | None, plan: EffectPlan) -> GlassShare | None:
    """Return the fractions of glass, of textures the mean where they are left out."""
    if share is None or plan.on("textures"):
        return share
    return share._replace(image=np.full_like(share.image, -1), maps=None)


def _leave_out_media(
    compiled: CompiledScene, media: Media | None, plan: EffectPlan
) -> Media | None:
    """Return the media that are simulated; None where glass is clear and lies in air."""
    if media is None or not (plan.on("media") or plan.on("dispersion")):
        return None
    if not plan.on("media"):
        media = media._replace(of_side=sides_in_air(compiled), absorption=media.absorption[:0])
    return media if plan.on("dispersion") else media._replace(dispersion=None)


def _leave_out_scattering(scattering: Scattering | None, plan: EffectPlan) -> Scattering | None:
    """Return the BSDFs that are simulated; None where all are Lambertian or specular."""
    if scattering is None:
        return None
    coats, sheens = scattering.coats, scattering.sheens
    if not plan.on("glossy"):
        coats = sheens = None
    if coats is not None:
        coats = coats._replace(
            maps=coats.maps if plan.on("textures") else None,
            relief=coats.relief if plan.on("relief") else None,
        )
    if sheens is not None and not plan.on("textures"):
        sheens = sheens._replace(maps=None)
    below = _simulated(scattering.below, plan)
    model = _simulated(scattering.model, plan) if plan.on("glossy") else below
    maps = scattering.maps if plan.on("textures") and plan.on("glossy") else None
    anisotropy = scattering.anisotropy if plan.on("glossy") else None
    share = _even(scattering.share, plan)
    scattering = scattering._replace(
        model=model,
        maps=maps,
        anisotropy=anisotropy,
        coats=coats,
        share=share,
        below=below,
        sheens=sheens,
    )
    return scattering if model.any() else None


def _simulated(model: NDArray[np.uint8], plan: EffectPlan) -> NDArray[np.uint8]:
    """Return BSDF models of which those left out are Lambertian."""
    kept = np.where(np.isin(model, NARROW), plan.on("glossy"), plan.on("non_lambertian"))
    return np.where(kept, model, LAMBERTIAN).astype(np.uint8)
