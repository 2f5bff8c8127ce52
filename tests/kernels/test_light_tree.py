"""Choices among lights have the probabilities that they claim, and beat those by power."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers.comparisons import assert_within
from helpers.passes import setup_of
from scipy import stats

import photonmap as pm
from photonmap.compile.lights import emitters
from photonmap.compile.scene_arrays import compile_scene
from photonmap.integrators.choice import make_integrator
from photonmap.kernels.core import rng
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.lights.selection import (
    SCRATCH,
    select_emitter,
    selection_probability,
    weigh_emitters,
)
from photonmap.runtime.workers import Workers
from photonmap.spectra.bands import Bands

SAMPLES = 40_000


@kernel
def count_choices(geometry, lights, point, ns, n, cdf, counts, worst):
    state = rng.stream(12, 0, 0)
    weigh_emitters(geometry, lights, point, ns, cdf)
    for _ in range(n):
        u, state = rng.draw(state)
        emitter, probability, u = select_emitter(lights, point, ns, cdf, u)
        counts[emitter] += 1
        if emitter >= 0:
            other = selection_probability(geometry, lights, emitter, point, ns)
            worst[0] = max(worst[0], abs(probability / other - 1.0))
        worst[1] = max(worst[1], u)


@kernel
def count_strata(geometry, lights, point, ns, n, cdf, counts, strata):
    weigh_emitters(geometry, lights, point, ns, cdf)
    for i in range(n):
        emitter, _, u = select_emitter(lights, point, ns, cdf, (i + 0.5) / n)
        if emitter >= 0:
            counts[emitter] += 1
            strata[emitter, int(4.0 * u)] += 1


@pytest.fixture(scope="module")
def many(cornell):
    """The Cornell box with its lamp, 20 points, 5 spots and a sun."""
    random = np.random.default_rng(4)
    places = random.uniform((-0.8, 0.35, -0.8), 0.8, (25, 3))
    color = random.uniform(0.02, 1.0, (25, 3))
    points = [pm.PointLight(tuple(p), tuple(c)) for p, c in zip(places, color, strict=True)]
    spots = [
        pm.SpotLight(tuple(p), tuple(-p), tuple(c), inner=20.0, outer=40.0)
        for p, c in zip(places[20:], color, strict=False)
    ]
    sun = pm.DirectionalLight((0.0, -0.3, -1.0), (0.5, 0.5, 0.5))
    return pm.Scene(cornell.meshes, [*points[:20], *spots, sun], cornell.camera, "many lights")


@pytest.fixture(scope="module")
def few(many):
    """Its lamp with 2 points, a spot, the sun and a dome: too few for a tree."""
    return replace(many, lights=[*many.lights[:2], *many.lights[-2:], pm.DomeLight(0.1)])


@pytest.fixture(scope="module")
def crowd(many):
    """700 points: a tree of three levels."""
    places = np.random.default_rng(6).uniform((-0.8, 0.35, -0.8), 0.8, (700, 3))
    return replace(many, lights=[pm.PointLight(tuple(place), 1.0) for place in places])


@pytest.mark.parametrize("lights", ["few", "many", "crowd"])
def test_choices_have_their_probabilities(lights, request):
    """χ² at p > 1e-3 for each of 4 places; emitters of no probability are never chosen."""
    compiled = compile_scene(request.getfixturevalue(lights), Bands.parse("rgb"), 1.0)
    geometry, lights = compiled.geometry, compiled.lights
    random, cdf = np.random.default_rng(5), np.empty(SCRATCH)
    for _ in range(4):
        point, ns = random.uniform(-0.3, 0.3, 3), random.normal(size=3)
        ns /= np.linalg.norm(ns)
        at = tuple(point), tuple(ns)
        counts, worst = np.zeros(len(lights.kind) + 1), np.zeros(2)
        count_choices(geometry, lights, *at, SAMPLES, cdf, counts, worst)
        assert worst[0] < 1e-9
        assert worst[1] < 1.0
        emitters = range(len(lights.kind))
        probabilities = [selection_probability(geometry, lights, i, *at) for i in emitters]
        probabilities = np.append(probabilities, max(1.0 - sum(probabilities), 0.0))
        assert not counts[probabilities == 0.0].any()
        common = probabilities * SAMPLES > 10.0
        rest = np.array([counts[~common].sum()]), np.array([probabilities[~common].sum() * SAMPLES])
        seen = np.append(counts[common], rest[0])
        wanted = np.append(probabilities[common] * SAMPLES, max(rest[1][0], 1e-9))
        assert stats.chisquare(seen, wanted * seen.sum() / wanted.sum()).pvalue > 1e-3


@pytest.mark.parametrize("lights", ["few", "many"])
def test_stratified_numbers_stay_stratified(lights, request):
    """Of evenly spaced numbers each emitter gets its share, and evenly spaced ones again."""
    compiled = compile_scene(request.getfixturevalue(lights), Bands.parse("rgb"), 1.0)
    geometry, lights, at = compiled.geometry, compiled.lights, ((0.1, -0.2, 0.2), (0.0, 1.0, 0.0))
    emitters, n = range(len(lights.kind)), 4096
    counts, strata = np.zeros(len(emitters)), np.zeros((len(emitters), 4))
    count_strata(geometry, lights, *at, n, np.empty(SCRATCH), counts, strata)
    shares = [selection_probability(geometry, lights, i, *at) for i in emitters]
    assert np.count_nonzero(counts) > 3
    assert np.abs(counts - n * np.array(shares)).max() <= 1.0
    assert np.abs(strata - counts[:, None] / 4).max() <= 1.0


def test_no_light_that_shines_on_a_point_has_no_chance(many):
    """Wherever a light is in front of a surface and shines there, the tree may choose it."""
    compiled = compile_scene(many, Bands.parse("rgb"), 1.0)
    geometry, lights = compiled.geometry, compiled.lights
    random = np.random.default_rng(6)
    for emitter in np.flatnonzero(np.isin(lights.kind, (1, 3))):
        for _ in range(20):
            point, ns = random.uniform(-0.5, 0.5, 3), random.normal(size=3)
            ns /= np.linalg.norm(ns)
            step = point - lights.position[emitter]
            lit = -step @ ns > 0.0
            if lights.kind[emitter] == 3:
                cosine = lights.axis[emitter] @ step / np.linalg.norm(step)
                lit &= cosine > lights.parameters[emitter, 1]
            if lit:
                at = tuple(point), tuple(ns)
                assert selection_probability(geometry, lights, emitter, *at) > 0.0


def test_no_triangle_that_shines_on_a_point_has_no_chance(cornell):
    """The same of the triangles of a sphere and of a rod, from near, from far and from inside."""
    meshes = [trimesh.creation.icosphere(2, 0.3), trimesh.creation.cylinder(0.01, 2.0, sections=16)]
    glow = pm.Material("glow", 0.0, emission=1.0)
    lamps = [pm.Mesh(m.vertices, m.faces, glow, f"lamp {i}") for i, m in enumerate(meshes)]
    compiled = compile_scene(pm.Scene(lamps, [], cornell.camera, "lamps"), Bands.parse("rgb"), 1.0)
    geometry, lights = compiled.geometry, compiled.lights
    assert lights.tree is not None
    corners = geometry.vertices.astype(float)[geometry.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    random, seen = np.random.default_rng(7), 0
    for point in random.normal(size=(60, 3)) * np.geomspace(0.02, 20.0, 60)[:, None]:
        ns = random.normal(size=3)
        ns /= np.linalg.norm(ns)
        in_front = ((point - corners[:, 0]) * normals).sum(axis=1) > 1e-9
        above = ((corners - point) @ ns).max(axis=1) > 1e-9
        for emitter in np.flatnonzero((in_front & above)[lights.triangle]):
            at = tuple(point), tuple(ns)
            assert selection_probability(geometry, lights, emitter, *at) > 0.0
            seen += 1
    assert seen > 1000


def test_the_tree_changes_the_error_alone(many, monkeypatch):
    """Direct light of points agrees with the choice by power, at less than half its error."""
    walls = [mesh for mesh in many.meshes if mesh.name != "light"]
    many = pm.Scene(walls, many.lights[:20], many.camera, "points")
    options = {"bands": "rgb", "size": (20, 20), "passes": 12, "effects": "emission,direct"}
    tree = pm.render(many, **options)
    monkeypatch.setattr(emitters, "grow_tree", lambda *_: None)
    power = pm.render(many, **options, seed=1)
    error = np.hypot(tree.standard_error("direct"), power.standard_error("direct"))
    assert_within(tree.direct, power.direct, error, sigmas=6.0)
    ratio = np.square(tree.standard_error("direct")).sum()
    ratio /= np.square(power.standard_error("direct")).sum()
    assert ratio < 0.25


@pytest.mark.parametrize(("lights", "has_tree"), [("few", False), ("many", True)])
def test_few_lights_need_no_tree(lights, has_tree, request):
    """Nor as many light samples in small passes."""
    compiled = compile_scene(request.getfixturevalue(lights), Bands.parse("rgb"))
    assert (compiled.lights.tree is not None) == has_tree
    with Workers(1) as workers:
        integrator = make_integrator("photon", setup_of(compiled, workers))
        assert integrator.many_lights == has_tree
