"""Scenes that differ in the spectra of their lights alone, as one: light is additive.

That scene shines with all their lights. Its light groups are the lights that belong together in
each of the scenes; the light of a scene is that of groups times a factor in each band.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.scene.lights import Light
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene
from photonmap.scene.textures import is_black
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Floats, Spectrum

_ARRAYS = ("vertices", "faces", "normals", "uv", "colors", "tangents")
_CLOSE = 1e-6  # by how much factors of lights of one group differ, relative to them
MOST_UNEVEN = 3.0
"""How many times as large as for another light the ratio may be of a light's power in two scenes
that are rendered as one."""
_Share = tuple[str, Floats] | None
"""Of a light in a scene: the group that it is in, and factors (N,); None where it is off."""


@dataclass(frozen=True)
class Illuminations:
    """Several scenes as one.

    Parameters
    ----------
    scene : with all their lights, as bright as in the scene that has most of them times the root
        of the fraction of scenes where they are on, so that none is much noisier than others
    shares : by light group of the scene, what it is in each of the scenes
    """

    scene: Scene
    shares: dict[str, list[_Share]]

    def factors(
        self, number: int, own: Sequence[str], groups: Sequence[str]
    ) -> NDArray[np.float32]:
        """Return by what light of groups is multiplied for each group of a scene, (G, H, N).

        Parameters
        ----------
        number : of the scene among them
        own : its G light groups; ("",) for all together
        groups : the H groups of all
        """
        bands = max(len(share[1]) for each in self.shares.values() for share in each if share)
        factors = np.zeros((len(own), len(groups), bands), np.float32)
        for column, group in enumerate(groups):
            if (share := self.shares[group][number]) is not None:
                factors[own.index(share[0]) if len(own) > 1 else 0, column] = share[1]
        return factors


def gather(scenes: Sequence[Scene], bands: Bands) -> list[list[int]]:
    """Return the numbers of scenes that `combine` can render together, in sets, in their order."""
    sets: list[list[int]] = []
    for number, scene in enumerate(scenes):
        for found in sets:
            if combine([*(scenes[each] for each in found), scene], bands) is not None:
                found.append(number)
                break
        else:
            sets.append([number])
    return sets


def combine(scenes: Sequence[Scene], bands: Bands) -> Illuminations | None:
    """Return scenes as one, if they differ in the spectra of their lights alone; else None.

    One of them has all the lights that others have, and these share their power much as there:
    samples are divided among lights as in that one, and would be noisy for others. None too where
    surfaces fluoresce, which mixes bands, or colours of lights are images.
    """
    meshes = [scene.meshes for scene in scenes]
    if len({*map(len, meshes)}) > 1 or any(s.camera != scenes[0].camera for s in scenes):
        return None
    union = _Union(bands, scenes)
    materials: dict[tuple[int, ...], Material] = {}
    made_meshes, lights = [], []
    for same in zip(*meshes, strict=True):
        owners = [mesh.material for mesh in same]
        if not all(_is_alike(same[0], mesh) for mesh in same) or owners[0].fluorescence:
            return None
        key = tuple(map(id, owners))
        if key not in materials:
            materials[key] = union.add(owners, "emission", [each.name for each in owners])
        made_meshes.append(replace(same[0], material=materials[key]))
    kinds = [[_unlit(light) for light in scene.lights] for scene in scenes]
    for kind in {each: None for of_scene in kinds for each in of_scene}:
        if kind.color_attribute is None or any(of_scene.count(kind) > 1 for of_scene in kinds):
            return None
        alike = [
            scene.lights[of_scene.index(kind)] if kind in of_scene else kind
            for scene, of_scene in zip(scenes, kinds, strict=True)
        ]
        names = [light.group or light.name or light.kind for light in alike]
        lights.append(union.add(alike, kind.color_attribute, names))
    scene = replace(scenes[0], meshes=made_meshes, lights=lights)
    return Illuminations(scene, union.shares) if union.shares and not union.fails else None


class _Union:
    """Collects the lights of scenes as those of one."""

    def __init__(self, bands: Bands, scenes: Sequence[Scene]) -> None:
        self._bands = bands
        self.shares: dict[str, list[_Share]] = {}
        lit = [[not is_black(m.material.emission) for m in scene.meshes] for scene in scenes]
        counts = [sum(each) + len(s.lights) for each, s in zip(lit, scenes, strict=True)]
        self._lead = counts.index(max(counts))
        self._ratios: list[list[float]] = [[] for _ in scenes]
        self._misfit = False  # whether a colour is no spectrum, or the lead lacks a light

    @property
    def fails(self) -> bool:
        """Whether one render does not serve all scenes."""
        uneven = (max(each) / min(each) > MOST_UNEVEN for each in self._ratios if each)
        return self._misfit or any(uneven)

    def add(self, same: Sequence[Any], attribute: str, names: Sequence[str]) -> Any:
        """Return what emits with the mean of its colours in all scenes, in a group of those alike.

        The names are those of the groups to which it belongs in each.
        """
        paints = [getattr(each, attribute) for each in same]
        lit = [number for number, paint in enumerate(paints) if not is_black(paint)]
        if not lit:
            return same[0]
        if self._lead not in lit or not all(isinstance(paints[k], Spectrum) for k in lit):
            self._misfit = True
            return same[0]
        emission = {number: self._bands.emission(paints[number]) for number in lit}
        ratios = {k: emission[k].mean() / emission[self._lead].mean() for k in lit}
        for number, ratio in ratios.items():
            self._ratios[number].append(ratio)
        often = math.sqrt(len(lit) / len(paints))
        mean = _mean([paints[number] * (often / ratio) for number, ratio in ratios.items()])
        whole, shares = self._bands.emission(mean), list[_Share]()
        for number, name in enumerate(names):
            own = emission.get(number, np.zeros(len(whole)))
            self._misfit |= bool((own[whole <= 0.0] > 0.0).any())
            factor = np.divide(own, whole, where=whole > 0.0, out=np.zeros(len(whole)))
            shares.append((name, factor) if number in lit else None)
        group = self._group_of(shares)
        named = {"name" if isinstance(same[0], Material) else "group": group}
        return replace(same[0], **{attribute: mean}, **named)

    def _group_of(self, shares: list[_Share]) -> str:
        """Return the group of lights that have these shares, a new one for the first of them."""

        def agree(one: _Share, other: _Share) -> bool:
            if one is None or other is None:
                return one is other
            return one[0] == other[0] and np.allclose(one[1], other[1], rtol=_CLOSE, atol=0.0)

        for group, known in self.shares.items():
            if all(map(agree, known, shares)):
                return group
        name = " or ".join(dict.fromkeys(share[0] for share in shares if share))
        group = name if name not in self.shares else f"{name} ({len(self.shares)})"
        self.shares[group] = shares
        return group


def _is_alike(mesh: Mesh, other: Mesh) -> bool:
    """Return whether meshes differ in the names and the emission of their materials alone."""
    if mesh is other:
        return True
    pairs = [(getattr(mesh, name), getattr(other, name)) for name in _ARRAYS]
    same = all(
        a is b or (a is not None and b is not None and np.array_equal(a, b)) for a, b in pairs
    )
    plain = [replace(each.material, name="", emission=0.0) for each in (mesh, other)]
    return same and mesh.name == other.name and plain[0] == plain[1]


def _unlit(light: Light) -> Light:
    """Return a light without its colour, name and group."""
    attribute = light.color_attribute
    black: dict[str, Any] = {} if attribute is None else {attribute: 0.0}
    return replace(light, name="", group="", **black)  # type: ignore[type-var]


def _mean(spectra: Sequence[Spectrum]) -> Spectrum:
    grid = np.unique(np.concatenate([each.wavelengths for each in spectra]))
    values = np.mean([each(grid) for each in spectra], axis=0)
    return Spectrum(grid, values, any(each.extrapolate for each in spectra))
