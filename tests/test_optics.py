"""Mirrors and glass: Snell and Fresnel, white furnaces, lenses, and the path tracer."""

import math

import numpy as np
import pytest
import trimesh
from scipy import stats

import photonmap as pm
from photonmap.kernels import fresnel, vec

BOX = pm.scenes.cornell_box()


def ball(center, radius, material, name="ball", subdivisions=5):
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    normals = mesh.vertices / radius
    return pm.Mesh(mesh.vertices + center, mesh.faces, material, name, normals)


def plane(size, y, material, name="plane"):
    corners = np.array([[-1, y, -1], [1, y, -1], [1, y, 1], [-1, y, 1]]) * [size, 1, size]
    return pm.Mesh(corners, [[0, 2, 1], [0, 3, 2]], material, name)


@pytest.mark.parametrize("eta", [1 / 1.5, 1.5, 1 / 2.4, 1.0])
def test_refraction_follows_snell(eta):
    for angle in np.linspace(0.0, 89.0, 12):
        theta = math.radians(angle)
        out = fresnel.refracted((math.sin(theta), -math.cos(theta), 0.0), (0.0, 1.0, 0.0), eta)
        assert out[0] == pytest.approx(eta * math.sin(theta), abs=1e-12)
        if eta * math.sin(theta) < 1.0:
            assert vec.dot(out, out) == pytest.approx(1.0, abs=1e-12)
            assert out[1] < 0.0


@pytest.mark.parametrize("ior", [1.33, 1.5, 2.4])
def test_fresnel_has_its_known_values(ior):
    normal = ((ior - 1.0) / (ior + 1.0)) ** 2
    assert fresnel.fresnel(1.0, 1.0 / ior) == pytest.approx(normal, rel=1e-12)
    assert fresnel.fresnel(1.0, ior) == pytest.approx(normal, rel=1e-12)
    brewster = math.atan(ior)  # the parallel part vanishes, the other is sin²(θ - θ')
    beyond = math.asin(math.sin(brewster) / ior)
    wanted = 0.5 * math.sin(brewster - beyond) ** 2
    assert fresnel.fresnel(math.cos(brewster), 1.0 / ior) == pytest.approx(wanted, rel=1e-9)
    critical = math.asin(1.0 / ior)
    assert fresnel.fresnel(math.cos(critical + 1e-6), ior) == 1.0
    assert 0.9 < fresnel.fresnel(math.cos(critical - 1e-6), ior) < 1.0
    assert fresnel.fresnel(1e-9, 1.0 / ior) == pytest.approx(1.0, abs=1e-7)


FURNACES = {
    "mirror": pm.Material.polished("m", 1.0),
    "dim mirror": pm.Material.polished("m", 0.6),
    "glass": pm.Material.glass("g", 1.5),
    "diamond": pm.Material.glass("g", 2.4),
    "thin": pm.Material.glass("g", 1.0),
    "coat": pm.Material("c", 0.5, mirror=0.5),
    "diffuse": pm.Material("d", 1.0),
}


@pytest.mark.parametrize("method", ["photon", "path"])
@pytest.mark.parametrize("kind", FURNACES)
def test_white_furnace(kind, method):
    """Under a sky of radiance 1, a convex body that absorbs nothing cannot be seen."""
    scene = pm.Scene(
        [ball([0, 0, 0], 1.0, FURNACES[kind])],
        [pm.DomeLight(1.0)],
        pm.Camera((0, 0, 3.0), (0, 0, 0), fov=30),
    )
    result = pm.render(
        scene, bands=3, size=(24, 24), passes=12, photons=4000, method=method, seed=1
    )
    inside = result.coverage == 1.0
    wanted = 0.6 if kind == "dim mirror" else 1.0
    assert result.radiance[inside].mean() == pytest.approx(wanted, rel=5e-3)
    smooth = kind not in ("diffuse", "coat")
    assert (result.reflectance[inside] == 0.0).all() == smooth
    if smooth:
        assert not result.shading.any()
        np.testing.assert_array_equal(result.radiance, result.emission)


def test_tint_and_total_reflection_inside_glass():
    """A slab seen straight on: T² tint² / (1 - R² tint²), by the geometric series."""
    slab = pm.Mesh.from_trimesh(
        trimesh.creation.box((4, 4, 0.2)), pm.Material.glass("slab", 1.5, 0.8), "slab"
    )
    lamp = pm.Mesh(
        np.array([[-4, -4, -1], [4, -4, -1], [4, 4, -1], [-4, 4, -1.0]]), [[0, 1, 2], [0, 2, 3]],
        pm.Material("lamp", 0.0, 1.0), "lamp",
    )  # fmt: skip
    camera = pm.Camera((0, 0, 5), (0, 0, 0), fov=0.5)
    scene = pm.Scene([slab, lamp], [], camera)
    result = pm.render(scene, bands="rgb", size=(8, 8), passes=64, seed=2)
    bounce = 0.04
    through = (0.96 * 0.8) ** 2 / (1.0 - bounce**2)
    assert result.emission.mean() == pytest.approx(through, rel=0.01)


def test_a_mirror_shows_what_is_before_it_and_a_corridor_says_what_it_cuts():
    mirrors = [plane(50.0, y, pm.Material.polished("m", 1.0), f"m{y}") for y in (-1.0, 1.0)]
    scene = pm.Scene(mirrors, [pm.PointLight((0, 0, 9))], pm.Camera((0, 0, 0), (0.1, 1, 0), fov=5))
    with pytest.warns(pm.SceneWarning, match="more than 64 reflections, as between facing mirrors"):
        result = pm.render(scene, bands="rgb", size=(4, 4), passes=2, method="path")
    assert any("64 reflections" in text for text in result.record["warnings"])


@pytest.fixture(scope="module")
def balls():
    meshes = [mesh for mesh in BOX.meshes if "box" not in mesh.name]
    mirror = ball([-0.4, -0.65, -0.3], 0.35, pm.Material.polished("mirror", 0.9), "mirror")
    glass = ball([0.4, -0.65, 0.2], 0.35, pm.Material.glass("glass"), "glass")
    coat = pm.Material("coat", 0.4, mirror=0.3)
    back = [m for m in meshes if m.name == "back"][0]
    meshes = [m for m in meshes if m is not back]
    coated = pm.Mesh(back.vertices, back.faces, coat, "back")
    return pm.Scene([*meshes, coated, mirror, glass], [], BOX.camera)


@pytest.fixture(scope="module")
def rendered(balls):
    settings = {"bands": "rgb", "size": (32, 32), "pixel": "center"}
    return {
        "photon": pm.render(balls, passes=48, seed=3, **settings),
        "path": pm.render(balls, passes=700, seed=4, method="path", **settings),
    }


@pytest.mark.parametrize("name", ["direct", "indirect", "caustics", "residual", "shading"])
def test_photons_agree_with_paths(rendered, name):
    """Means of 8 × 8 blocks; paths find caustics by chance."""
    blocks = {}
    for method, result in rendered.items():
        image = result.buffers[name].astype(float).reshape(4, 8, 4, 8, 3)
        spread = result.standard_error(name).astype(float).reshape(4, 8, 4, 8, 3)
        blocks[method] = image.mean(axis=(1, 3)), np.sqrt((spread**2).sum(axis=(1, 3))) / 64
    (ours, our_error), (truth, error) = blocks["photon"], blocks["path"]
    scale = 0.01 * truth.mean()  # the radius of the disks is not 0 yet
    z = (ours - truth) / np.sqrt(our_error**2 + error**2 + scale**2)
    assert np.abs(z).max() < stats.norm.isf(1e-3 / z.size)
    assert ours.mean() == pytest.approx(truth.mean(), rel=0.02)


def test_buffers_keep_their_meaning(rendered, balls):
    for result in rendered.values():
        r = result.buffers
        np.testing.assert_array_equal(r["radiance"], (r["emission"] + r["direct"]) + r["indirect"])
        lambertian = r["reflectance"] * r["shading"]
        rest = r["radiance"] - r["emission"] - lambertian
        np.testing.assert_allclose(result.residual, rest, atol=2e-6 * r["radiance"].max())
        assert (r["caustics"] <= r["indirect"] * (1 + 1e-6) + 1e-7).all()
        names = [mesh.name for mesh in balls.meshes]
        smooth = np.isin(result.object_id, [names.index(n) + 1 for n in ("mirror", "glass")])
        assert smooth.any()
        for name in ("reflectance", "shading", "caustics"):
            assert name == "caustics" or not r[name][smooth].any()
        plain = ~smooth & (result.object_id != names.index("back") + 1)
        assert not result.residual[plain].any()
        assert result.residual[smooth].any()


def test_errors_and_files_of_smooth_scenes(rendered, tmp_path):
    result = rendered["photon"]
    result.save(tmp_path / "balls.exr")
    again = pm.load_result(tmp_path / "balls.exr")
    for name in ("caustics", "residual"):
        np.testing.assert_array_equal(again.buffers[name], result.buffers[name])
        np.testing.assert_array_equal(again.standard_error(name), result.standard_error(name))


def test_the_same_seed_gives_the_same_bits_for_any_number_of_threads(balls):
    runs = [pm.render(balls, bands=4, size=(16, 16), passes=3, seed=9, threads=n) for n in (1, 2)]
    for name in ("radiance", "caustics", "residual"):
        np.testing.assert_array_equal(runs[0].buffers[name], runs[1].buffers[name])


def test_a_diffuse_scene_has_no_such_buffers():
    result = pm.render(BOX, bands="rgb", size=(8, 8), passes=2)
    assert not {"caustics", "residual"} & set(result.buffers)
    assert not result.residual.any()
    assert not result.caustics.any()


def lens_profile(ior, radius, distance, rays):
    """Trace parallel rays through a ball with Snell's law alone: where they meet a plane."""
    height = radius * np.sqrt((np.arange(rays) + 0.5) / rays)
    inside = np.arcsin(height / radius)
    turned = np.arcsin(height / radius / ior)
    total = 2.0 * (inside - turned)  # the deviation of the two refractions
    exit_angle = 2.0 * turned - inside  # from the axis at the centre, to the point of exit
    x, z = radius * np.sin(-exit_angle), radius * np.cos(exit_angle)
    at = x - np.tan(total) * (distance - z)

    def reflectance(a, b):
        s = (np.sin(a - b) / np.sin(a + b)) ** 2
        p = (np.tan(a - b) / np.tan(a + b)) ** 2
        return 0.5 * (s + p)

    return np.abs(at), (1.0 - reflectance(inside, turned)) ** 2
