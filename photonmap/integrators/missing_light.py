"""Warnings where light is missing: hidden lights, truncated paths, few photons, nothing in view."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.effects import EffectPlan
from photonmap.compile.lights.probabilities import make_cdf, probabilities_of
from photonmap.compile.scene_arrays import CompiledScene
from photonmap.errors import warn
from photonmap.film.moments import Accumulator
from photonmap.integrators.base import Integrator
from photonmap.integrators.photon_mapping.pilot import SMALLEST_FRACTION
from photonmap.kernels.bsdf.specular import LONGEST_CHAIN
from photonmap.kernels.core.passes import MAX_BOUNCES, View
from photonmap.kernels.core.records import GLASS, MIRROR, Lights
from photonmap.kernels.integrators.light_visibility import find_view_points, reaches_view
from photonmap.kernels.lights.kinds import NUMBERS, numbers_where
from photonmap.kernels.lights.selection import SCRATCH
from photonmap.runtime.wording import listed

POINTS = 64
PATHS, FEWEST_PATHS, MOST_PATHS = 256, 16, 1 << 14
"""From a light; where there are many, as few as this; and from all, about."""
BOUNCES = 8
MANY = 0.9
"""Fraction of the pixels that may be unresolved before a warning is due."""
TOLERATED_CHAINS, CHAIN_PASSES = 1e-3, 16
"""Fraction of pixels that may show a truncated specular chain every `CHAIN_PASSES` passes without a
warning: from balls of glass whose normals are interpolated, a few rays never leave."""
_OR_CAMERA = "; or the camera is inside or behind an object"
"""What may keep all light from the view"""


def find_hidden_lights(compiled: CompiledScene, view: View, key: np.uint64) -> list[str]:
    """Return the names of the lights that seem to send nothing into the view; warn of them.

    They are not seen, and none of their probing paths reaches what is. Every light sends up to 256
    paths of up to 8 bounces; each of their vertices is joined to 64 points in view until one
    connection is free. A light that lights the view costs a few rays. Where there are smooth
    surfaces nothing is said: light may come by them, and be seen in them. The key is that of the
    random streams of the paths.
    """
    if compiled.specular is not None:
        return []
    points, normals = np.zeros((POINTS, 3)), np.zeros((POINTS, 3))
    seen = np.zeros(len(compiled.light_names), bool)
    scene = compiled.arrays
    count = find_view_points(scene.geometry, scene.lights, view, key, points, normals, seen)
    points, normals = points[:count], normals[:count]
    if count == 0:
        return []
    emitters: dict[str, list[int]] = {}
    for emitter, name in enumerate(compiled.light_names):
        emitters.setdefault(name, []).append(emitter)
    paths = int(np.clip(MOST_PATHS // len(emitters), FEWEST_PATHS, PATHS))
    hidden = []
    for name, members in emitters.items():
        if seen[members].any():
            continue
        scene = replace(compiled, lights=_only(compiled.lights, np.array(members))).arrays
        if not reaches_view(scene, key, paths, BOUNCES, np.empty(SCRATCH), points, normals):
            hidden.append(name)
    if hidden:
        single = len(hidden) == 1
        who = f"light {hidden[0]!r} sends" if single else f"lights {listed(hidden)} send"
        warn(
            f"{who} nothing into the view: none of {paths} paths from {'it' if single else 'each'} "
            f"reached the view; check {_suspects(compiled, hidden)}"
            f"{_OR_CAMERA if len(hidden) == len(emitters) else ''}"
        )
    return hidden


def _suspects(compiled: CompiledScene, hidden: list[str]) -> str:
    """Return what may keep the light of some lights from the view."""
    its, it_is = ("its", "it is") if len(hidden) == 1 else ("their", "they are")
    lights, materials = compiled.lights, len(compiled.materials.reflectance)
    if lights.portals is not None:
        rows = lights.portals.row[np.isin(compiled.light_names, hidden)]
        if (rows >= 0).all():
            return f"that {its} direction leads through a portal: suns shine through these alone"
    portals = (lights.triangle >= 0) & (lights.spectrum >= materials)  # have a light's spectrum
    if portals.any():
        only = "which let in the sky and suns alone"
        return f"the winding of portals, {only}, and that {it_is} not behind one"
    outside = f"that {it_is} not inside a wall"
    kinds = lights.kind[np.isin(compiled.light_names, hidden)]
    if (kinds == NUMBERS["point"]).all():
        return outside
    what = "winding" if np.isin(kinds, numbers_where(has_area=True)).any() else "direction"
    return f"{its} {what}, and {outside}"


def _only(lights: Lights, members: np.ndarray) -> Lights:
    """Return some emitters of one light alone, chosen in proportion to power."""
    profiles, portals = lights.profiles, lights.portals
    if profiles is not None:
        profiles = profiles._replace(row=profiles.row[members])
    if portals is not None:
        portals = portals._replace(row=portals.row[members])
    return lights._replace(
        kind=lights.kind[members],
        triangle=lights.triangle[members],
        position=lights.position[members],
        axis=lights.axis[members],
        parameters=lights.parameters[members],
        area=lights.area[members],
        spectrum=lights.spectrum[members],
        cdf=make_cdf(probabilities_of(lights.cdf)[members]),
        dome=int(np.argmax(members == lights.dome)) if lights.dome in members else -1,
        profiles=profiles,
        tree=None,
        portals=portals,
    )


def warn_of_empty_image(moments: Accumulator, expects_light: bool) -> None:
    """Warn where the camera sees nothing, or only surfaces to which no light comes.

    Light is expected if direct light is simulated, and a light seems to reach the view.
    """
    if moments.shows_nothing():
        warn("the camera sees nothing; check its origin and target, or give no camera")
    elif expects_light and moments.is_unlit():
        warn(
            "no light reaches what the camera sees: direct and indirect light are 0 everywhere; "
            "check the winding of area lights, where other lights shine, and that the camera is "
            "not inside an object"
        )


def warn_of_few_photons(unresolved: NDArray[np.bool_]) -> None:
    """Warn where photons say nothing about indirect light: in most pixels, (P,), are unresolved."""
    if unresolved.mean() > MANY:
        warn(
            f"no photon was found for the indirect light of {unresolved.sum()} pixels "
            f"(unresolved): the little light that arrives there is missing; use more photons"
        )


def warn_of_truncated_paths(integrator: Integrator, moments: Accumulator) -> None:
    """Warn where light is missing from the passes so far, because paths were truncated."""
    missing = "surfaces reflect nearly everything, and light is missing from indirect"
    truncated, photons = integrator.counters.truncated, integrator.counters.photons
    if truncated > SMALLEST_FRACTION * photons:
        warn(
            f"{truncated} of {photons} photons were truncated after {MAX_BOUNCES} bounces: "
            f"{missing}"
        )
    fraction = integrator.truncated_fraction()
    if fraction > SMALLEST_FRACTION:
        warn(
            f"about {100 * fraction:.2g}% of paths are truncated after {MAX_BOUNCES} bounces: "
            f"{missing}"
        )
    chains = moments.truncated()
    if chains > TOLERATED_CHAINS * len(moments.counts) * max(moments.count / CHAIN_PASSES, 1.0):
        warn(
            f"{chains} pixel{'s show' if chains > 1 else ' shows'} more than {LONGEST_CHAIN} "
            "successive reflections, as between facing mirrors or in round glass of few triangles; "
            "the light at their ends is missing; give such glass vertex normals, or divide it "
            "more finely"
        )


def warn_of_lost_caustics(method: str, compiled: CompiledScene, plan: EffectPlan) -> None:
    """Warn where paths miss caustics: by smooth surfaces, of lights that no ray can hit."""
    specular = compiled.specular
    if method != "path" or specular is None or not plan.on("caustics"):
        return
    is_smooth = np.isin(specular.kind, (MIRROR, GLASS))
    if len(specular.alpha):
        is_smooth &= specular.alpha == 0.0
    can_be_hit = np.isin(compiled.lights.kind, numbers_where(has_area=True))
    if is_smooth.any() and not can_be_hit.all():
        warn(
            "method path finds no caustics of points, spots and suns by mirrors or smooth glass: "
            "they are missing; method photon has them"
        )
