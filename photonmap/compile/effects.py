"""The plan of effects: which a scene calls for, and why; and scenes without what it leaves out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.scene_arrays import CompiledScene
from photonmap.errors import InputError
from photonmap.kernels.bsdf.models import LAMBERTIAN, NARROW
from photonmap.kernels.core import records
from photonmap.kernels.lights.kinds import numbers_where
from photonmap.runtime.options import read_list
from photonmap.runtime.wording import suggest
from photonmap.spectra.curves import Floats

_REASONS = {
    "emission": ("area lights or a sky can be seen", "no area light or sky can be seen"),
    "direct": ("there are lights", ""),
    "soft_shadows": ("lights have an area", "all lights are points or suns: shadows are sharp"),
    "indirect": ("surfaces may see each other", ""),
    "caustics": (
        "mirrors, glass or metal send light to diffuse surfaces", "no surface is diffuse",
    ),
    "specular": ("there are mirrors or glass", "there is no mirror or glass"),
    "glossy": ("some surfaces are glossy, or have a sheen", "no surface is glossy"),
    "non_lambertian": (
        "some diffuse surfaces do not obey Lambert's law",
        "all diffuse reflection obeys Lambert's law",
    ),
    "fluorescence": ("surfaces send out light in other bands", "no surface fluoresces"),
    "transmission": ("there is glass", "there is no glass"),
    "media": (
        "glass absorbs light inside, or lies beside other glass",
        "all glass is clear and lies in air",
    ),
    "dispersion": (
        "the index of glass depends on wavelength", "no index depends on wavelength",
    ),
    "alpha": ("surfaces have holes or are partly transparent", "no surface is cut out"),
    "environment": ("the sky is a map", "the sky is not a map"),
    "textures": ("surfaces have textures", "no surface has a texture"),
    "relief": ("normal maps or bump maps turn normals", "no image turns normals"),
    "band_merging": ("{bands} bands have {distinct} different spectra", "all bands differ"),
}  # fmt: skip
"""Why each effect is on, and why it is off"""
EFFECTS = tuple(_REASONS)
_NEVER_FORCED = (
    "media", "dispersion", "alpha", "environment", "textures", "relief", "glossy", "non_lambertian",
    "fluorescence",
)  # fmt: skip

MOST_CHECKS = 1 << 28
"""Products of vertices and planes, beyond which a scene is not checked for being convex."""


@dataclass(frozen=True)
class Effect:
    """Whether an effect is simulated, and the reason."""

    on: bool
    why: str


def called_for(compiled: CompiledScene, distinct: int, bands: int) -> dict[str, Effect]:
    """Return what a scene calls for, in the order of `EFFECTS`."""
    calls = {**_of_lights(compiled), **_of_surfaces(compiled), **_of_images(compiled)}
    calls |= {"direct": True, "indirect": True, "band_merging": distinct < bands}
    called = {
        name: Effect(bool(calls[name]), reasons[0 if calls[name] else 1])
        for name, reasons in _REASONS.items()
    }
    merging = called["band_merging"]
    why = merging.why.format(bands=bands, distinct=distinct)
    called |= {"indirect": _indirect(compiled), "band_merging": replace(merging, why=why)}
    if compiled.fluorescence is not None and not called["fluorescence"].on:
        called["fluorescence"] = Effect(False, "no band excites it, or none sees what it sends out")
    if not _kinds(compiled).any():
        called["caustics"] = Effect(False, _REASONS["specular"][1])
    return called


def _part(record: object, *names: str) -> Any:
    """Return a part of a record, or a part of that; None where one is missing."""
    for name in names:
        record = getattr(record, name, None)
    return record


def _of_lights(compiled: CompiledScene) -> dict[str, object]:
    has_area = np.isin(compiled.lights.kind, numbers_where(has_area=True)).any()
    is_map = compiled.lights.environment is not None
    return {"emission": has_area, "soft_shadows": has_area, "environment": is_map}


def _of_surfaces(compiled: CompiledScene) -> dict[str, object]:
    kinds, alpha = _kinds(compiled), _part(compiled, "specular", "alpha")
    models, below = (_part(compiled, "scattering", name) for name in ("model", "below"))
    media = _part(compiled, "specular", "media")
    is_narrow = models is not None and np.isin(models, NARROW).any()
    is_lambertian = below is None or np.isin(below, (LAMBERTIAN, *NARROW)).all()
    is_mixed = media is not None and (media.of_side != sides_in_air(compiled)).any()
    return {
        "caustics": kinds.any() and _is_rough(compiled),
        "specular": ((kinds != 0) & (kinds != records.METAL)).any(),
        "glossy": is_narrow or (alpha is not None and alpha.any()),
        "non_lambertian": not is_lambertian,
        "fluorescence": compiled.fluorescence is not None and compiled.fluorescence.matrix.any(),
        "transmission": compiled.is_thin.any() or (kinds == records.GLASS).any(),
        "media": is_mixed or (media is not None and len(media.absorption) > 0),
        "dispersion": _part(media, "dispersion") is not None,
    }


def _kinds(compiled: CompiledScene) -> NDArray[np.uint8]:
    """Return which specular lobe each material has; none without any."""
    return np.zeros(0, np.uint8) if compiled.specular is None else compiled.specular.kind


def sides_in_air(compiled: CompiledScene) -> NDArray[np.int32]:
    """Return `Media.of_side` as it is where all glass lies in air."""
    geometry, specular = compiled.geometry, compiled.specular
    of_side = np.full((len(geometry.material), 2), -1, np.int32)
    if specular is not None:
        glass = specular.kind[geometry.material] == records.GLASS
        of_side[glass, 1] = geometry.material[glass]
    return of_side


def _of_images(compiled: CompiledScene) -> dict[str, object]:
    alpha = compiled.geometry.alpha
    textures = (
        ("textures",), ("lights", "emission_textures"), ("scattering", "maps"),
        ("scattering", "sheens", "maps"), ("specular", "maps"), ("specular", "glass", "maps"),
        ("fluorescence", "maps"),
    )  # fmt: skip
    reliefs = ("geometry", "relief"), ("scattering", "coats", "relief")
    return {
        "alpha": alpha is not None and ((alpha.value < 1.0) | (alpha.image >= 0)).any(),
        "textures": any(_part(compiled, *names) is not None for names in textures),
        "relief": any(_part(compiled, *names) is not None for names in reliefs),
    }


def _is_rough(compiled: CompiledScene) -> bool:
    """Return whether a surface reflects otherwise than a mirror or glass."""
    scattering = compiled.scattering
    glossy = scattering is not None and np.isin(scattering.model, NARROW).any()
    diffuse = compiled.fluorescence is not None or compiled.materials.reflectance.any()
    return bool(glossy or diffuse)


def _indirect(compiled: CompiledScene) -> Effect:
    """Decide whether light can go from surface to surface."""
    specular = compiled.specular
    if specular is None and not _is_rough(compiled):
        return Effect(False, "every surface is black")
    if _is_flat(compiled.geometry):
        return Effect(False, "all surfaces lie in one plane: none sees another")
    triangles, vertices = len(compiled.geometry.triangles), len(compiled.geometry.vertices)
    if triangles * vertices > MOST_CHECKS:
        return Effect(True, "too many triangles to check whether surfaces see each other")
    whole = specular is None and compiled.geometry.alpha is None
    if whole and _is_closed_and_convex(compiled.geometry) and not _lit_inside(compiled):
        return Effect(False, "one closed convex body: no surface sees another from outside")
    return Effect(True, _REASONS["indirect"][0])


def _is_flat(geometry: records.Geometry) -> bool:
    """Return whether all vertices lie in the plane of the first triangle, to the last digit.

    And all triangles: what stands on it may be lower than a digit of the scene's size.
    """
    corner = geometry.vertices[geometry.triangles[0, 0]].astype(np.float64)
    normal = geometry.normals[0].astype(np.float64)
    heights = (geometry.vertices - corner) @ normal
    parallel = np.abs(geometry.normals @ normal) > 1.0 - 1e-6
    return bool(np.abs(heights).max() <= 1e-7 and parallel.all())


def _heights(geometry: records.Geometry, points: NDArray[np.float32]) -> Floats:
    """Return the heights of points over each triangle's plane, at most over triangles: (P,)."""
    corners = geometry.vertices[geometry.triangles[:, 0]].astype(np.float64)
    normals = geometry.normals.astype(np.float64)
    levels = (corners * normals).sum(axis=1)
    most = np.full(len(points), -np.inf)
    for start in range(0, len(normals), 4096):
        part = slice(start, start + 4096)
        np.maximum(most, (points @ normals[part].T - levels[part]).max(axis=1), out=most)
    return most


def _is_closed_and_convex(geometry: records.Geometry) -> bool:
    """Return whether two triangles pass every edge in opposite directions, and no plane cuts it."""
    _, same = np.unique(geometry.vertices, axis=0, return_inverse=True)
    corners = same.ravel()[geometry.triangles].astype(np.int64)
    starts, ends = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    forth, back = np.sort(starts * len(same) + ends), np.sort(ends * len(same) + starts)
    is_closed = (np.diff(forth) > 0).all() and np.array_equal(forth, back)
    return bool(is_closed and not (_heights(geometry, geometry.vertices) > 1e-7).any())


def _lit_inside(compiled: CompiledScene) -> bool:
    """Return whether a point light may lie within, or the camera does."""
    lights = compiled.lights
    points = lights.position[np.isin(lights.kind, numbers_where(has_place=True, has_area=False))]
    if compiled.camera.eye is None:
        return True  # camera rays may start anywhere
    camera = (np.array(compiled.camera.eye) - compiled.center) / compiled.size
    points = np.concatenate([points, camera[None]])
    return bool((_heights(compiled.geometry, points) <= 1e-7).any())


@dataclass(frozen=True)
class EffectPlan:
    """All effects by name, in the order of `EFFECTS`.

    `partial` says that some which the scene calls for were left out on request.
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
    """Return "auto", "all" or a set of names; the error about another suggests the nearest."""
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
    """Decide what is simulated: "auto", "all", or the names of those to simulate alone.

    `distinct` of all bands differ.
    """
    called = called_for(compiled, distinct, bands)
    if wanted == "auto":
        return EffectPlan(called)
    if wanted == "all":
        forced = {
            name: effect if effect.on else Effect(True, f"forced, though {effect.why}")
            for name, effect in called.items()
        }
        forced |= {name: called[name] for name in _NEVER_FORCED}
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
        sky, spectra = lights.environment, lights.spectra.copy()
        spectra[sky.row] = 0.0
        dark = sky._replace(basis=np.zeros_like(sky.basis))
        lights = lights._replace(environment=dark, spectra=spectra)
    textures = compiled.textures
    fluorescence = compiled.fluorescence if plan.on("fluorescence") else None
    if not plan.on("textures"):
        textures, lights = None, lights._replace(emission_textures=None)
        fluorescence = fluorescence and fluorescence._replace(maps=None)
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
        fluorescence=fluorescence,
    )


def _leave_out_holes(alpha: records.Alpha | None, plan: EffectPlan) -> records.Alpha | None:
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


def _leave_out_specular(compiled: CompiledScene, plan: EffectPlan) -> records.Specular | None:
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
        return records.Specular(*black, np.zeros(0), None, no_dip, None, None, none[:0], None)
    by_kind = {records.GLASS: plan.on("transmission"), records.MIRROR: plan.on("specular")}
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
        glass=_even(specular.glass, plan),
    )
    return specular if specular.kind.any() else None


def _even(fraction: records.GlassFraction | None, plan: EffectPlan) -> records.GlassFraction | None:
    """Return the fractions of glass, of textures the mean where they are left out."""
    if fraction is None or plan.on("textures"):
        return fraction
    return fraction._replace(image=np.full_like(fraction.image, -1), maps=None)


def _leave_out_media(
    compiled: CompiledScene, media: records.Media | None, plan: EffectPlan
) -> records.Media | None:
    """Return the media that are simulated; None where glass is clear and lies in air."""
    if media is None or not (plan.on("media") or plan.on("dispersion")):
        return None
    if not plan.on("media"):
        media = media._replace(of_side=sides_in_air(compiled), absorption=media.absorption[:0])
    return media if plan.on("dispersion") else media._replace(dispersion=None)


def _leave_out_scattering(
    scattering: records.Scattering | None, plan: EffectPlan
) -> records.Scattering | None:
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
        sheens = sheens._replace(maps=None, basis=sheens.basis[:0])
    below = _simulated(scattering.below, plan)
    model = _simulated(scattering.model, plan) if plan.on("glossy") else below
    maps = scattering.maps if plan.on("textures") and plan.on("glossy") else None
    anisotropy = scattering.anisotropy if plan.on("glossy") else None
    glass = _even(scattering.glass, plan)
    scattering = scattering._replace(
        model=model,
        maps=maps,
        anisotropy=anisotropy,
        coats=coats,
        glass=glass,
        below=below,
        sheens=sheens,
    )
    return scattering if model.any() else None


def _simulated(model: NDArray[np.uint8], plan: EffectPlan) -> NDArray[np.uint8]:
    """Return BSDF models of which those left out are Lambertian."""
    kept = np.where(np.isin(model, NARROW), plan.on("glossy"), plan.on("non_lambertian"))
    return np.where(kept, model, LAMBERTIAN).astype(np.uint8)
