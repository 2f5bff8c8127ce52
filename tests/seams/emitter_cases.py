"""A floor under one emitter of every kind, and what emitters send, as arrays."""

import math
from functools import cache

import numpy as np
from helpers.scenes import quad

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.kernels.core import rng, vec
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.core.passes import Hit, SurfaceInteraction
from photonmap.kernels.lights import kinds, triangle
from photonmap.kernels.lights.emission import emit_photon
from photonmap.kernels.lights.environment import cell_of_normal

SKY = "environment"
"""A dome with a map, which is a kind of its own here."""
SUN = "disc"
"""A sun that is a disc, large for this test."""
EMITTERS = (*kinds.KINDS, SKY, SUN)
PHOTONS = 200_000
UP = (0.0, 1.0, 0.0)


def lamp_table():
    """Relative intensities over polar angles and azimuths, uneven in both."""
    polar, azimuth = np.linspace(0.0, np.pi, 37)[:, None], np.linspace(0.0, 2.0 * np.pi, 73)
    return 0.2 + np.cos(polar / 2.0) ** 4 * (1.5 + np.sin(azimuth + 0.3) * np.sin(polar))


def make_scene(sky, angle):
    """Return the scene; `sky` is a light, the dome or the map, `angle` of the sun's disc."""
    corners = [(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)]
    floor = quad(*corners, pm.Material("floor", 0.5), "floor")
    lamp = pm.Mesh([(-0.3, 1.1, 0.2), (0.4, 1.0, -0.5), (0.5, 1.2, 0.3)], [[0, 1, 2]],
                   pm.Material("lamp", 0.0, 2.0), "lamp")  # fmt: skip
    lights = [
        pm.PointLight((0.3, 0.6, -0.2), 0.7),
        pm.SpotLight((-0.2, 0.9, 0.1), (0.1, 0.0, 0.2), 3.0, 15.0, 40.0),
        pm.DirectionalLight((0.4, -1.0, 0.3), 1.5, angle=angle),
        pm.PhotometricLight(
            (0.1, 0.5, 0.3), lamp_table(), 0.9, direction=(0.3, -1.0, 0.1), azimuth=(0.5, 0.2, -1.0)
        ),
        sky,
    ]
    return pm.Scene([floor, lamp], lights, name="every emitter")


@cache
def compiled(emitter):
    """Return (scene, its compiled arrays, the number of an emitter)."""
    texels = np.random.default_rng(8).uniform(0.05, 1.0, (6, 12, 3))
    texels[1, 4] = 20.0
    sky = pm.EnvironmentLight(texels, rotation=30.0) if emitter == SKY else pm.DomeLight(0.4)
    scene = make_scene(sky, 40.0 if emitter == SUN else 0.0)
    arrays = compile_scene(scene, pm.Bands.parse("1"))
    kind = {SKY: "dome", SUN: "directional"}.get(emitter, emitter)
    found = np.flatnonzero(arrays.lights.kind == kinds.NUMBERS[kind])
    assert len(found), f"no light of kind {kind!r}; add one to make_scene in {__file__}"
    return scene, arrays, int(found[0])


@kernel
def _emit_all(geometry, lights, key, origins, directions, flux):
    state = rng.stream(key, 0, 0)
    for i in range(len(flux)):
        a, state = rng.draw(state)
        b, state = rng.draw(state)
        c, state = rng.draw(state)
        d, state = rng.draw(state)
        origin, direction = emit_photon(geometry, lights, (a, b), (c, d), 1.0, flux[i])
        origins[i, 0], origins[i, 1], origins[i, 2] = origin
        directions[i, 0], directions[i, 1], directions[i, 2] = direction


def emit(emitter, key=21):
    """Return origins and directions, (n, 3), and flux, (n,), of photons of one emitter alone."""
    _, arrays, number = compiled(emitter)
    alone = (np.arange(len(arrays.lights.kind)) >= number).astype(float)
    origins, directions = np.empty((2, PHOTONS, 3))
    flux = np.empty((PHOTONS, 1), np.float32)
    _emit_all(
        arrays.geometry, arrays.lights._replace(cdf=alone), np.uint64(key),
        origins, directions, flux,
    )  # fmt: skip
    return origins, directions, flux[:, 0].astype(float)


@kernel
def _sample_all(geometry, lights, emitter, points, ns, key, directions, columns):
    state = rng.stream(key, 1, emitter)
    hit = Hit(0, 0.0, 0.0, 1.0)
    for i in range(len(points)):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        point = vec.row(points, i)
        surface = SurfaceInteraction(point, point, ns, ns, 0, hit, (0.0, -1.0, 0.0), 0)
        sample = kinds.sample_towards(geometry, lights, emitter, surface, u, v)
        columns[i, 0], columns[i, 1], columns[i, 2] = sample.weight, sample.pdf, sample.length
        columns[i, 3] = kinds.importance(geometry, lights, emitter, point, ns)
        columns[i, 4] = math.sqrt(vec.dot(sample.segment, sample.segment))
        if lights.kind[emitter] == kinds.TRIANGLE:
            segment, direction = sample.segment, sample.direction
            columns[i, 5] = triangle.pdf(geometry, lights, emitter, segment, direction)
        directions[i, 0], directions[i, 1], directions[i, 2] = sample.direction


class Samples:
    """Light samples of an emitter at points of the floor.

    Parameters
    ----------
    directions : (n, 3), towards the emitter
    weight, pdf, length : of `LightSample`
    importance : of the emitter there
    distance : to what was sampled
    ray_pdf : of a triangle, the density for a ray that hits it there
    """

    def __init__(self, emitter, points, ns=UP, key=22):
        _, arrays, number = compiled(emitter)
        self.directions, columns = np.empty((len(points), 3)), np.zeros((len(points), 6))
        _sample_all(
            arrays.geometry, arrays.lights, number, np.ascontiguousarray(points), ns,
            np.uint64(key), self.directions, columns,
        )  # fmt: skip
        self.weight, self.pdf, self.length, self.importance, self.distance, self.ray_pdf = columns.T
        self.cosine = np.maximum(self.directions @ np.array(ns), 0.0)
        self._lights, self._geometry, self._emitter = arrays.lights, arrays.geometry, number
        self._is_map, self._ns = emitter == SKY, ns

    @property
    def irradiance(self):
        """Of an estimate, in the kernels' units."""
        return self.weight * self.cosine * self.emission

    @property
    def emission(self):
        """Of the emitter in the samples' directions."""
        lights = self._lights
        if self._is_map:
            texels = lights.environment.texels.astype(float) @ lights.environment.basis[:, 0]
            return texels[self._texels]
        return float(lights.spectra[lights.spectrum[self._emitter], 0])

    @property
    def _texels(self):
        """Rows and columns of the map: from +y down, the middle at -z, right of it towards +x."""
        environment, (x, y, z) = self._lights.environment, self.directions.T
        rows, columns = environment.columns.shape
        turn = (0.5 + np.arctan2(x, -z) / (2.0 * np.pi) + environment.rotation) % 1.0
        row = np.minimum((np.arccos(np.clip(y, -1.0, 1.0)) / np.pi * rows).astype(int), rows - 1)
        return row, np.minimum((turn * columns).astype(int), columns - 1)

    @property
    def true_pdf(self):
        """The density, per steradian, of points spread evenly over a triangle; of the sky, by the
        cosine, or by what CDFs say of texels and evenly over each."""
        lights = self._lights
        if self._is_map:
            environment = lights.environment
            probabilities = texel_probabilities(environment, cell_of_normal(self._ns))
            bands = -np.diff(environment.cosines)[:, None]
            areas = bands * 2.0 * np.pi / environment.columns.shape[1]
            return (probabilities / areas)[self._texels]
        if lights.kind[self._emitter] == kinds.DOME:
            return self.cosine / np.pi
        normal = self._geometry.normals[lights.triangle[self._emitter]].astype(float)
        facing = -self.directions @ normal
        return self.distance**2 / (facing * lights.area[self._emitter])


def texel_probabilities(environment, cell):
    """Return the probabilities of texels towards a cell of normals, (H, W), from all CDFs."""
    height, width = environment.columns.shape
    rows, columns = np.arange(height) * 16 // height, np.arange(width) * 32 // width
    blocks = np.diff(environment.block_rows[cell], prepend=0.0)[:, None]
    blocks = blocks * np.diff(environment.block_columns[cell], prepend=0.0, axis=1)
    within = _steps(environment.rows, rows)[columns].T * _steps(environment.columns, columns)
    return blocks[rows[:, None], columns] * within


def _steps(cdfs, parts):
    """Return the steps of CDFs that begin anew with each part."""
    before = np.concatenate([np.zeros((len(cdfs), 1)), cdfs[:, :-1]], axis=1)
    before[:, np.diff(parts, prepend=-1) > 0] = 0.0
    return cdfs - before


def floor_of(emitter):
    """Return (height, half of the width) of the floor, in the kernels' units."""
    _, arrays, _ = compiled(emitter)
    corners = arrays.geometry.vertices[arrays.geometry.triangles[0]]
    return float(corners[0, 1]), float(corners[:, 0].max())
