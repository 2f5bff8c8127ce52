"""What a scene calls for: every effect on or off, and why."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.kernels.records import DOME, GLASS, POINT, SPOT, TRIANGLE, Geometry, Optics
from photonmap.messages import suggest
from photonmap.prepare import Prepared

EFFECTS = (
    "emission",
    "direct",
    "soft_shadows",
    "indirect",
    "caustics",
    "specular",
    "transmission",
    "alpha",
    "environment",
    "textures",
    "band_merging",
)

MOST_CHECKS = 1 << 28
"""Products of vertices and planes, beyond which a scene is not checked for being convex."""


@dataclass(frozen=True)
class Effect:
    """Whether an effect is simulated, and the reason."""

    on: bool
    why: str


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
        """Tell whether an effect is simulated."""
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
    names = wanted.split(",") if isinstance(wanted, str) else list(wanted)
    names = [name.strip() for name in names]
    if names in (["auto"], ["all"]):
        return names[0]
    for name in names:
        if name not in EFFECTS:
            raise InputError(f"there is no effect {name!r}; {suggest(name, EFFECTS)}")
    return frozenset(names)


def plan_effects(
    prepared: Prepared, wanted: str | frozenset[str], distinct: int, bands: int
) -> EffectPlan:
    """Decide what is simulated.

    Parameters
    ----------
    prepared : the scene
    wanted : "auto", "all", or the names of those to simulate alone
    distinct : different bands of the scene
    bands : all of them
    """
    called = _called_for(prepared, distinct, bands)
    if wanted == "auto":
        return EffectPlan(called)
    if wanted == "all":
        forced = {
            name: Effect(True, effect.why if effect.on else f"forced, though {effect.why}")
            for name, effect in called.items()
        }
        for name in ("alpha", "environment", "textures"):
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


def leave_out(prepared: Prepared, plan: EffectPlan) -> Prepared:
    """Return the scene without the mirrors, the glass and the sky that a plan leaves out.

    They turn black. Textures become their mean, cut-outs whole. What is forced on gets its code,
    though nothing calls for it.
    """
    lights, optics = prepared.lights, prepared.optics
    if lights.environment is not None and not plan.on("environment"):
        dark = np.zeros_like(lights.environment.basis)
        spectra = lights.spectra.copy()
        spectra[lights.spectrum[lights.dome]] = 0.0
        sky = lights.environment._replace(basis=dark)
        lights = lights._replace(environment=sky, spectra=spectra)
    textures, geometry = prepared.textures, prepared.geometry
    if not plan.on("textures"):
        textures, lights = None, lights._replace(glow=None)
    if not plan.on("alpha"):
        geometry = geometry._replace(alpha=None)
    if optics is None and plan.on("specular"):
        count = len(prepared.materials.reflectance)
        none = np.zeros_like(prepared.materials.reflectance)
        kind = np.zeros(count, np.uint8)
        optics = Optics(kind, none, np.zeros(count), none.copy(), np.zeros(count))
    elif optics is not None:
        kept = np.where(optics.kind == GLASS, plan.on("transmission"), plan.on("specular"))
        optics = optics._replace(
            kind=np.where(kept, optics.kind, 0).astype(np.uint8),
            chance=np.where(kept, optics.chance, 0.0),
        )
        if not optics.kind.any():
            optics = None
    return replace(prepared, geometry=geometry, lights=lights, optics=optics, textures=textures)


def _called_for(prepared: Prepared, distinct: int, bands: int) -> dict[str, Effect]:
    kinds = prepared.lights.kind
    area = np.isin(kinds, (TRIANGLE, DOME))
    optics = prepared.optics
    smooth = np.zeros(0, np.uint8) if optics is None else optics.kind
    indirect = _indirect(prepared)
    dull = prepared.materials.reflectance.any()
    return {
        "emission": _if(area.any(), "lamps or a sky can be seen", "no lamp or sky can be seen"),
        "direct": Effect(True, "there are lights"),
        "soft_shadows": _if(
            area.any(), "lamps have an area", "all lights are points or suns: shadows are sharp"
        ),
        "indirect": indirect,
        "caustics": _if(
            bool(smooth.any()) and bool(dull),
            "mirrors or glass send light to diffuse surfaces",
            "there is no mirror or glass" if not smooth.any() else "no surface is diffuse",
        ),
        "specular": _if(smooth.any(), "there are mirrors or glass", "there is no mirror or glass"),
        "transmission": _if((smooth == GLASS).any(), "there is glass", "there is no glass"),
        "alpha": _if(
            prepared.geometry.alpha is not None,
            "surfaces have holes or are partly there",
            "no surface is cut out",
        ),
        "environment": _if(
            prepared.lights.environment is not None, "the sky is a map", "the sky is no map"
        ),
        "textures": _if(
            prepared.textures is not None or prepared.lights.glow is not None,
            "surfaces have textures",
            "no surface has a texture",
        ),
        "band_merging": _if(
            distinct < bands,
            f"{bands} bands have {distinct} different spectra",
            "all bands differ",
        ),
    }


def _if(condition: object, yes: str, no: str) -> Effect:
    return Effect(bool(condition), yes if condition else no)


def _indirect(prepared: Prepared) -> Effect:
    """Decide whether light can go from surface to surface."""
    optics = prepared.optics
    if optics is None and not prepared.materials.reflectance.any():
        return Effect(False, "every surface is black")
    if _is_flat(prepared.geometry):
        return Effect(False, "all surfaces lie in one plane: none sees another")
    triangles, vertices = len(prepared.geometry.triangles), len(prepared.geometry.vertices)
    if triangles * vertices > MOST_CHECKS:
        return Effect(True, "too many triangles to check whether surfaces see each other")
    whole = optics is None and prepared.geometry.alpha is None
    if whole and _is_convex(prepared.geometry) and not _lit_inside(prepared):
        return Effect(False, "one closed convex body: no surface sees another from outside")
    return Effect(True, "surfaces may see each other")


def _is_flat(geometry: Geometry) -> bool:
    """Tell whether all vertices lie in the plane of the first triangle, to the last digit.

    And all triangles: what stands on it may be lower than a digit of the scene's size.
    """
    corner = geometry.vertices[geometry.triangles[0, 0]].astype(np.float64)
    normal = geometry.normals[0].astype(np.float64)
    heights = (geometry.vertices - corner) @ normal
    parallel = np.abs(geometry.normals @ normal) > 1.0 - 1e-6
    return bool(np.abs(heights).max() <= 1e-7 and parallel.all())


def _is_convex(geometry: Geometry) -> bool:
    """Tell whether the triangles are one closed surface that no plane of theirs cuts."""
    return _is_closed(geometry) and not (_heights(geometry, geometry.vertices) > 1e-7).any()


def _heights(geometry: Geometry, points: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the heights of points over each triangle's plane, at most over triangles: (P,)."""
    corners = geometry.vertices[geometry.triangles[:, 0]].astype(np.float64)
    normals = geometry.normals.astype(np.float64)
    levels = (corners * normals).sum(axis=1)
    most = np.full(len(points), -np.inf)
    for start in range(0, len(normals), 4096):
        part = slice(start, start + 4096)
        np.maximum(most, (points @ normals[part].T - levels[part]).max(axis=1), out=most)
    return most


def _is_closed(geometry: Geometry) -> bool:
    """Tell whether every edge belongs to two triangles, which pass it in opposite directions."""
    _, same = np.unique(geometry.vertices, axis=0, return_inverse=True)
    corners = same.ravel()[geometry.triangles].astype(np.int64)
    starts, ends = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    forth, back = np.sort(starts * len(same) + ends), np.sort(ends * len(same) + starts)
    return bool((np.diff(forth) > 0).all() and np.array_equal(forth, back))


def _lit_inside(prepared: Prepared) -> bool:
    """Tell whether a point light may lie within, or the camera does."""
    lights = prepared.lights
    points = lights.position[np.isin(lights.kind, (POINT, SPOT))]
    camera = (np.array(prepared.camera.origin) - prepared.center) / prepared.size
    points = np.concatenate([points, camera[None]])
    return bool((_heights(prepared.geometry, points) <= 1e-7).any())
