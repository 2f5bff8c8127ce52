"""The unbiased mode: its mean is the path tracer's in every buffer and block, whatever is cached.

Passes are independent, so means over them are compared by Welch's t-test; no seed is used by both
methods, since these share random numbers. All comparisons of a test together reject
equal means wrongly with a probability of 1 in 1000; seeds are fixed.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import trimesh
from helpers.marks import slow
from helpers.passes import independent_means
from helpers.scenes import GREY, sky
from scipy import stats

import photonmap as pm
from photonmap.integrators.photon_mapping.integrator import PhotonIntegrator

BOX = pm.scenes.cornell_box()
SIZE, BLOCK = 16, 8
BUFFERS = ("radiance", "direct", "indirect", "shading", "reflectance")
SIGNIFICANCE = 1e-3
SEED, TRUTH = 0, 100
GROUPS = 24


def block_means(scene, seed, passes, groups=GROUPS, **options):
    """Return the means over blocks of 8×8 pixels and the image, (groups, buffers, blocks + 1, 3).

    Each is of so many passes.
    """
    few = {"bands": "rgb", "size": SIZE, "photons": 4096, "threads": 1}
    render = partial(pm.render, scene)
    return independent_means(render, BUFFERS, _blocks, groups, passes, seed=seed, **few, **options)


def _blocks(image):
    side = SIZE // BLOCK
    parts = image.astype(np.float64).reshape(side, BLOCK, side, BLOCK, 3)
    blocks = parts.mean(axis=(1, 3)).reshape(-1, 3)
    return np.vstack([blocks, blocks.mean(axis=0)])


def differ(first, second):
    """Return whether any of the means differ."""
    rounding = 1e-5 * np.abs(second).mean(axis=0)
    vary = (np.ptp(first, axis=0) > rounding) & (np.ptp(second, axis=0) > rounding)
    p = stats.ttest_ind(first[:, vary], second[:, vary], equal_var=False).pvalue
    return p.min() < SIGNIFICANCE / p.size


def under_a_sky():
    """Return the box, open to a sky, textured in part, with a ball of smooth normals."""
    rng = np.random.default_rng(0)
    checks = pm.Texture.of(rng.uniform(0.1, 0.8, (8, 8, 3)))
    meshes = []
    for number, mesh in enumerate(BOX.meshes):
        if number % 3 == 1 and not np.any(mesh.material.emission):
            uv = np.random.default_rng(1).uniform(size=(len(mesh.vertices), 2))
            mesh = replace(mesh, uv=uv, material=replace(mesh.material, reflectance=checks))
        meshes.append(mesh)
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.3)
    vertices = ball.vertices + [0.1, 0.5, 0.1]
    meshes.append(pm.Mesh(vertices, ball.faces, GREY, "ball", ball.vertex_normals))
    lights = [*BOX.lights, pm.EnvironmentLight(sky())]
    return replace(BOX, meshes=meshes, lights=lights)


def with_material(scene, name, **changes):
    """Return a scene with other materials where meshes have a name that contains this."""
    return replace(
        scene,
        meshes=[
            replace(mesh, material=replace(mesh.material, **changes)) if name in mesh.name else mesh
            for mesh in scene.meshes
        ],
    )


SCENES = {
    "under a sky": under_a_sky(),
    "rough": with_material(under_a_sky(), "back", diffuse_roughness=0.6),
}


@pytest.mark.parametrize("name", ["under a sky", *slow("rough")])
def test_mean_is_exact_whatever_the_cache_holds(name, monkeypatch):
    """Of all indirect light, 2% too much would be found."""
    scene = SCENES[name]
    truth = block_means(scene, TRUTH, 14, method="path")
    run_camera_pass = PhotonIntegrator.run_camera_pass

    def of_wrong_cache(self, index, maps):
        light = maps.cache.radiosity
        wrong = 2.0 * light + light[::-1]  # twice the light, and that of other cells
        cache = maps.cache._replace(radiosity=wrong)
        return run_camera_pass(self, index, maps._replace(cache=cache))

    monkeypatch.setattr(PhotonIntegrator, "run_camera_pass", of_wrong_cache)
    assert not differ(block_means(scene, SEED, 2, unbiased=True), truth)
    assert differ(block_means(scene, SEED, 1, groups=12), truth)


@pytest.mark.parametrize(
    "options",
    [*slow({"pixel": "center"}), {"effects": "emission,direct"}],
    ids=["center", "direct"],
)
def test_mean_is_exact_with_other_options(options):
    truth = block_means(BOX, TRUTH, 10, method="path", **options)
    assert not differ(block_means(BOX, SEED, 1, unbiased=True, **options), truth)


def test_surfaces_that_are_partly_transparent_are_left_unshared():
    scene = with_material(BOX, "box", alpha=0.5)
    truth = block_means(scene, TRUTH, 7, method="path")
    assert not differ(block_means(scene, SEED, 1, unbiased=True), truth)


def test_sharing_takes_noise_away():
    def variance(**options):
        result = pm.render(BOX, bands="rgb", size=32, passes=4, threads=1, **options)
        return np.mean(np.square(result.errors["indirect"], dtype=np.float64))

    assert variance(unbiased=True) < 0.1 * variance(method="path")


def test_intervals_hold():
    results = [
        pm.render(BOX, bands="rgb", size=SIZE, passes=8, seed=seed, unbiased=True)
        for seed in range(5)
    ]
    for name in ("radiance", "indirect", "shading"):
        values = np.stack([result[name] for result in results]).astype(np.float64)
        errors = np.stack([result.standard_error(name) for result in results])
        others = (values.sum(axis=0) - values) / (len(values) - 1.0)
        scale = errors * np.sqrt(1.0 + 1.0 / (len(values) - 1.0))
        held = np.abs(values - others) <= stats.t.ppf(0.975, 7) * scale
        assert 0.93 <= held[errors > 0.0].mean() <= 0.98, name


def test_record_says_that_there_is_no_bias():
    record = pm.render(BOX, bands="rgb", size=8, passes=2, unbiased=True).record
    assert record["arguments"]["unbiased"] is True
    assert record["bias"] == 0.0
    assert record["error"] == record["standard_error"]


def test_threads_do_not_change_the_image():
    images = [
        pm.render(
            BOX, bands="rgb", size=(40, 24), passes=2, unbiased=True, threads=threads
        ).radiance
        for threads in (1, 2)
    ]
    np.testing.assert_array_equal(*images)


def test_what_cannot_be_without_bias_is_refused():
    with pytest.raises(pm.InputError, match="unbiased: method path has no bias"):
        pm.render(BOX, size=8, passes=1, unbiased=True, method="path")
    with pytest.raises(
        pm.InputError, match=r"mirrors and glass have a bias, and there are none; leave out"
    ):
        pm.render(BOX, bands="rgb", size=SIZE, unbiased=True, effects="all")
    with pytest.raises(pm.InputError, match=r"unbiased: mirrors and glass .* method path"):
        pm.render(pm.scenes.cornell_balls(), size=8, passes=1, unbiased=True)


@pytest.mark.slow
def test_mean_is_that_of_path_tracing_to_a_thousandth():
    truth = block_means(BOX, TRUTH, 600, method="path")
    means = block_means(BOX, SEED, 96, unbiased=True)
    assert not differ(means, truth)
    for name in ("indirect", "shading"):
        row = BUFFERS.index(name)
        whole = np.stack([each[:, row, -1].mean(axis=1) for each in (truth, means)])
        error = whole.std(axis=1, ddof=1) / GROUPS**0.5
        assert error.max() <= 1e-3 * whole.mean()
        assert abs(whole[1].mean() - whole[0].mean()) <= 3.0 * np.hypot(*error)


def test_nothing_is_shared_with_the_background():
    """Shading is 0 where nothing is seen."""
    camera = replace(BOX.camera, origin=(0.0, 0.0, 8.0))
    scene = replace(BOX, camera=camera)
    result = pm.render(scene, bands="rgb", size=SIZE, passes=4, unbiased=True)
    unseen = result.coverage == 0.0
    assert 10 < unseen.sum() < unseen.size - 10
    assert not result.shading[unseen].any()
    with pytest.raises(ValueError, match="this render has no bias"):
        result.bias("indirect")
