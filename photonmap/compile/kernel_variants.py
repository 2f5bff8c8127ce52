"""Variants of kernels: for which scenes they are compiled.

A record that a scene lacks is absent, and kernels find out at run time. That costs next to nothing
where it is about lights, up to 3% where surfaces lack images, and more where they lack lobes: so
there are kernels without these. docs/performance.md has the measurements.
"""

from photonmap.kernels.core.records import SceneArrays

_LOBES = frozenset({"specular", "scattering"})
VARIANTS: dict[str, frozenset[str]] = {
    "plain": _LOBES | {"textures", "alpha", "relief"},
    "textured": _LOBES,
    "full": frozenset(),
}
"""Records of the scene and its geometry that each is compiled without, the leanest first."""


def variant_of(scene: SceneArrays) -> str:
    """Return the first variant that has all that a scene has."""
    holders = scene, scene.geometry
    there = {
        name
        for name in VARIANTS["plain"]
        if any(getattr(holder, name, None) is not None for holder in holders)
    }
    return next(name for name, without in VARIANTS.items() if not there & without)
