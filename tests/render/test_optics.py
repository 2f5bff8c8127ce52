"""Mirrors and glass: Snell and Fresnel, white furnaces, lenses, and the path tracer."""

import math

import numpy as np
import pytest
import trimesh
from scipy import stats

import photonmap as pm
from photonmap.kernels.core import fresnel, vec

BOX = pm.scenes.cornell_box()
NO_INDIRECT = "direct,specular,transmission,caustics"
"""Of scenes whose caustics are looked at alone: no gather ray is traced."""


def ball(center, radius, material, name="ball", subdivisions=4):
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
    detail = 5 if kind in ("glass", "diamond") else 4  # fewer triangles keep light for ever
    scene = pm.Scene(
        [ball([0, 0, 0], 1.0, FURNACES[kind], subdivisions=detail)],
        [pm.DomeLight(1.0)],
        pm.Camera((0, 0, 3.0), (0, 0, 0), fov=30),
    )
    result = pm.render(scene, bands=3, size=(16, 16), passes=8, photons=2000, method=method, seed=1)
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
    result = pm.render(scene, bands="rgb", size=(8, 8), passes=32, seed=2)
    bounce = 0.04
    through = (0.96 * 0.8) ** 2 / (1.0 - bounce**2)
    assert result.emission.mean() == pytest.approx(through, rel=0.01)


def test_a_mirror_shows_what_is_before_it_and_a_corridor_says_what_it_cuts():
    mirrors = [plane(50.0, y, pm.Material.polished("m", 1.0), f"m{y}") for y in (-1.0, 1.0)]
    scene = pm.Scene(mirrors, [pm.PointLight((0, 0, 9))], pm.Camera((0, 0, 0), (0.02, 1, 0), fov=5))
    with pytest.warns(
        pm.SceneWarning,
        match="256 successive reflections, as .* or in round glass .* vertex normals",
    ):
        result = pm.render(scene, bands="rgb", size=(4, 4), passes=2, method="path")
    assert any("256 successive reflections" in text for text in result.record["warnings"])


def test_paths_that_find_no_caustics_say_so():
    floor, mirror = plane(1.0, 0.0, pm.Material("floor", 0.5)), pm.Material.polished("m", 1.0)
    meshes = [floor, ball((0, 1, 0), 0.2, mirror, subdivisions=1)]
    camera, settings = pm.Camera((0, 3, 3), (0, 0, 0)), {"size": 4, "passes": 1, "method": "path"}
    pm.render(pm.Scene(meshes, [pm.DomeLight()], camera), **settings)
    bulb = [pm.PointLight((0, 3, 0))]
    with pytest.warns(pm.SceneWarning, match="finds no caustics of points, spots and suns"):
        pm.render(pm.Scene(meshes, bulb, camera), **settings)
    rough = pm.Material.glass("rough", roughness=0.5)
    pm.render(
        pm.Scene([floor, ball((0, 1, 0), 0.2, rough, subdivisions=1)], bulb, camera), **settings
    )


@pytest.fixture(scope="module")
def balls():
    meshes = [mesh for mesh in BOX.meshes if "box" not in mesh.name]
    mirror = ball([-0.4, -0.65, -0.3], 0.35, pm.Material.polished("mirror", 0.9), "mirror")
    glass = ball([0.4, -0.65, 0.2], 0.35, pm.Material.glass("glass"), "glass")
    coat = pm.Material("coat", 0.4, mirror=0.3)
    back = next(m for m in meshes if m.name == "back")
    meshes = [m for m in meshes if m is not back]
    coated = pm.Mesh(back.vertices, back.faces, coat, "back")
    return pm.Scene([*meshes, coated, mirror, glass], [], BOX.camera)


@pytest.fixture(scope="module")
def rendered(balls):
    settings = {"bands": "rgb", "size": (32, 32), "pixel": "center"}
    return {
        "photon": pm.render(balls, passes=12, seed=3, **settings),
        "path": pm.render(balls, passes=120, seed=2, method="path", **settings),
    }


@pytest.mark.parametrize("name", ["direct", "indirect", "caustics", "residual", "shading"])
def test_photons_agree_with_paths(rendered, name):
    """Means of 8 × 8 blocks; paths find caustics at random."""
    blocks = {}
    for method, result in rendered.items():
        image = result.buffers[name].astype(float).reshape(4, 8, 4, 8, 3)
        spread = result.standard_error(name).astype(float).reshape(4, 8, 4, 8, 3)
        blocks[method] = image.mean(axis=(1, 3)), np.sqrt((spread**2).sum(axis=(1, 3))) / 64
    (ours, our_error), (truth, error) = blocks["photon"], blocks["path"]
    scale = 0.01 * truth.mean()  # the radius of the disks is not 0 yet
    z = (ours - truth) / np.sqrt(our_error**2 + error**2 + scale**2)
    assert np.abs(z).max() < stats.norm.isf(1e-3 / z.size)
    if name in ("indirect", "caustics"):  # photons are shared by pixels
        our_error = rendered["photon"].block_error(name).astype(float)
    noise = np.sqrt((our_error**2).sum() + (error**2).sum()) / truth.size
    assert abs(ours.mean() - truth.mean()) <= 0.02 * truth.mean() + 3.0 * noise


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


def through_ball(ior, incidence, slope, distance):
    """Trace rays in a plane through the middle of a unit ball, with Snell's and Fresnel's laws.

    The axis runs along the light, from 0 at the ball's centre. Rays arrive under these angles to
    the surface, and spread by `slope` from the axis. Returns how far from the axis those that
    leave at the second surface meet a plane, infinite if they do not, and their transmission.
    """
    beyond = np.arcsin(np.sin(incidence) / ior)
    exit_angle = 2.0 * beyond - incidence + slope  # at the centre, from the axis to the exit
    turned = 2.0 * (incidence - beyond) - slope  # towards the axis, by both refractions
    away = np.tan(turned) * (distance - np.cos(exit_angle))
    at = np.where(turned < 0.5 * math.pi, np.abs(np.sin(exit_angle) - away), np.inf)
    s = np.sin(incidence - beyond) / np.sin(incidence + beyond)
    p = np.tan(incidence - beyond) / np.tan(incidence + beyond)
    return at, (1.0 - 0.5 * (s * s + p * p)) ** 2


def rays_of_sun(rays=200_000):
    """Give rays of equal flux through the unit ball: incidence, slope, flux of all."""
    height = np.sqrt((np.arange(rays) + 0.5) / rays)
    return np.arcsin(height), np.zeros(rays), math.pi


def rays_of_point(distance, rays=200_000):
    """Give rays of equal flux from a point so far from the centre."""
    cap = 1.0 - math.sqrt(1.0 - 1.0 / distance**2)
    slope = np.arccos(1.0 - cap * (np.arange(rays) + 0.5) / rays)
    return np.arcsin(distance * np.sin(slope)), slope, 2.0 * math.pi * cap


def encircled(light, distance, half, radii, **settings):
    """Return the flux of caustics that a glass ball casts on a plane, within radii.

    The camera hangs below the ball and looks straight down, so that pixels are equal areas.
    """
    meshes = [
        ball([0, 0, 0], 1.0, pm.Material.glass(), subdivisions=5),
        plane(1.15 * half, -distance, pm.Material("plane", 0.5)),
    ]
    eye, side = -1.02, 64
    fov = math.degrees(2.0 * math.atan(half / (distance + eye)))
    camera = pm.Camera((0, eye, 0), (0, -distance, 0), (0, 0, -1), fov)
    scene = pm.Scene(meshes, [light], camera)
    few = {"bands": 1, "size": side, "photons": 20_000, "effects": NO_INDIRECT}
    result = pm.render(scene, **few, **settings)
    flux = result.caustics[..., 0] / 0.5 * math.pi * (2.0 * half / side) ** 2
    fine = ((np.arange(8 * side) + 0.5) / (4 * side) - 1.0) * half
    away = np.hypot(fine[:, None], fine).reshape(side, 8, side, 8)
    return np.array([(flux * (away <= radius).mean(axis=(1, 3))).sum() for radius in radii])


def test_rays_through_a_ball_meet_at_its_focus():
    """f = n R / (2 (n - 1)), and 1 / f = 1 / a + 1 / b; nothing is lost but by reflection."""
    near = np.array([1e-4])
    for ior in (1.4, 1.5, 1.9):
        focus = 0.5 * ior / (ior - 1.0)
        at, transmission = through_ball(ior, np.arcsin(near), 0.0 * near, focus)
        assert at[0] < 1e-9
        normal = ((ior - 1.0) / (ior + 1.0)) ** 2
        assert transmission[0] == pytest.approx((1.0 - normal) ** 2, rel=1e-6)
        image = 1.0 / (1.0 / focus - 1.0 / 9.0)
        assert through_ball(ior, np.arcsin(9.0 * np.sin(near)), near, image)[0][0] < 1e-8


@pytest.mark.parametrize(
    ("light", "rays", "distance", "half", "radii"),
    [
        (pm.DirectionalLight((0, -1, 0)), rays_of_sun(), 1.5, 1.05, (0.05, 0.1, 0.2, 0.4, 1.0)),
        (pm.PointLight((0, 3, 0)), rays_of_point(3.0), 2.0, 1.6, (0.1, 0.2, 0.4, 0.8, 1.5)),
    ],
    ids=["sun", "point"],
)
def test_a_ball_lens_focuses_light(light, rays, distance, half, radii):
    """Within radii as rays through both surfaces alone; outside the last, the ball reflects."""
    incidence, slope, flux = rays
    at, transmission = through_ball(1.5, incidence, slope, distance)
    wanted = np.array([transmission[at <= radius].sum() for radius in radii]) * flux / len(at)
    found = encircled(light, distance, half, radii, passes=8, seed=1)
    assert found[-1] == pytest.approx(wanted[-1], rel=0.02)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=0.03 * wanted[-1])


def test_the_sun_through_a_slab():
    """Of what parallel surfaces reflect to and fro, (1 - R) / (1 + R) gets through."""
    box = trimesh.creation.box((4, 0.2, 4))
    meshes = [
        pm.Mesh.from_trimesh(box, pm.Material.glass("slab", 1.5), "slab"),
        plane(2.0, -1.1, pm.Material("plane", 0.5)),
    ]
    camera = pm.Camera((0, -0.2, 0), (0, -1.1, 0), (0, 0, -1), 126)
    scene = pm.Scene(meshes, [pm.DirectionalLight((0, -1, 0), 2.0)], camera)
    settings = {"bands": "rgb", "size": 64, "passes": 16, "seed": 5, "effects": NO_INDIRECT}
    result = pm.render(scene, **settings)
    assert not result.direct.any()
    irradiance = result.caustics / 0.5 * math.pi
    through = (1.0 - 0.04) / (1.0 + 0.04)
    assert irradiance.mean() == pytest.approx(2.0 * through, rel=0.01)


def colored_sky(height=32):
    """Give a map of radiances between 0.5 and 1.5."""
    return pm.EnvironmentLight(
        np.random.default_rng(8).uniform(0.5, 1.5, (height, 2 * height, 3)).astype(np.float32)
    )


def texels(direction, shape):
    """Return rows and columns at which directions, (..., 3), look, as the guide tells."""
    x, y, z = np.moveaxis(direction, -1, 0)
    row = np.arctan2(np.hypot(x, z), y) / math.pi * shape[0]
    column = (0.5 + np.arctan2(x, -z) / (2.0 * math.pi)) % 1.0 * shape[1]
    return np.stack([row, column], axis=-1)


def camera_rays(side, fov):
    """Return unit directions through the centres of pixels, along -z, (side, side, 3)."""
    across = ((np.arange(side) + 0.5) / side * 2.0 - 1.0) * math.tan(math.radians(fov) / 2.0)
    x, y = np.meshgrid(across, -across)
    return np.stack([x, y, np.full_like(x, -1.0)], axis=-1) / np.sqrt(1 + x * x + y * y)[..., None]


def normals_seen(shape, rays):
    """Return the normals that rays from (0, 0, 4) meet on a unit ball, or on a plane."""
    if shape == "flat":
        return np.broadcast_to([0.6, 0.0, 0.8], rays.shape), np.ones(rays.shape[:2], bool)
    along = -4.0 * rays[..., 2]
    root = along**2 - 15.0
    distance = along - np.sqrt(np.maximum(root, 0.0))
    normal = [0.0, 0.0, 4.0] + distance[..., None] * rays
    return normal, (root > 0.0) & (-(normal * rays).sum(axis=-1) > 0.3)


@pytest.mark.parametrize("shape", ["flat", "ball"])
def test_the_sky_in_a_mirror(shape):
    """Each pixel is the texel in the mirrored direction, but at the borders of texels."""
    silver, sky, side = pm.Material.polished("silver", 0.9), colored_sky(), 48
    mirror = ball([0, 0, 0], 1.0, silver, subdivisions=6)
    if shape == "flat":
        corners = np.array([[-8, -9, 6], [8, -9, -6], [8, 9, -6], [-8, 9, 6.0]])
        mirror = pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], silver, "mirror")
    scene = pm.Scene([mirror], [sky], pm.Camera((0, 0, 4), (0, 0, 0), fov=25))
    result = pm.render(scene, bands="rgb", size=(side, side), pixel="center", passes=2)
    rays = camera_rays(side, 25)
    normal, sure = normals_seen(shape, rays)
    away = rays - 2.0 * (rays * normal).sum(axis=-1, keepdims=True) * normal
    place = texels(away, sky.image.shape)
    sure &= (np.abs(place - np.rint(place)) > 0.02).all(axis=-1)
    row, column = np.moveaxis(place.astype(int), -1, 0)
    assert sure.mean() > 0.5
    assert len(np.unique(place[sure].astype(int), axis=0)) >= 20
    wanted = 0.9 * sky.image[row, column]
    np.testing.assert_allclose(result.emission[sure], wanted[sure], rtol=1e-5)


def test_glass_as_thin_as_air_is_invisible():
    """Under a sky: the background through it is the same, the floor has the same radiance."""
    floor = plane(1.5, -0.5, pm.Material("floor", 0.7))
    glass = ball([0, 0.1, 0], 0.4, pm.Material.glass("nothing", 1.0), "glass")
    camera = pm.Camera((0, 0.7, 3), (0, -0.1, 0), fov=35)
    settings = {"bands": "rgb", "size": (32, 32), "passes": 16, "pixel": "center"}
    without, seen = (
        pm.render(pm.Scene(meshes, [colored_sky()], camera), seed=seed, **settings)
        for seed, meshes in enumerate([[floor], [floor, glass]])
    )
    assert (seen.object_id == 2).any()
    sky = without.object_id == 0
    assert ((seen.object_id == 2) & sky).any()
    np.testing.assert_allclose(seen.radiance[sky], without.radiance[sky], rtol=1e-5)
    blocks = [image.astype(float).reshape(8, 4, 8, 4, 3) for image in (
        seen.radiance, without.radiance, seen.standard_error("radiance"),
        without.standard_error("radiance"),
    )]  # fmt: skip
    on_floor = ~sky.reshape(8, 4, 8, 4).any(axis=(1, 3))
    found, wanted = (image.mean(axis=(1, 3))[on_floor] for image in blocks[:2])
    error = np.sqrt((blocks[2] ** 2 + blocks[3] ** 2).sum(axis=(1, 3)))[on_floor] / 16
    z = (found - wanted) / np.hypot(error, 0.005 * wanted.mean())
    assert np.abs(z).max() < stats.norm.isf(1e-3 / z.size)
    assert found.mean() == pytest.approx(wanted.mean(), rel=0.01)


def test_a_case_of_air_takes_no_light_from_what_is_narrow():
    """Bars narrower than a caustic disk, under a sky; by disks alone they lack a third of it."""
    bars = [trimesh.creation.box((0.02, 0.02, 1.0)).apply_translation((x, 0.0, 0.0))
            for x in np.linspace(-0.45, 0.45, 13)]  # fmt: skip
    turn = trimesh.transformations.rotation_matrix(np.pi / 2, (0, 1, 0), (0.0, 0.01, 0.0))
    bars = trimesh.util.concatenate(bars + [bar.copy().apply_transform(turn) for bar in bars])
    grid = pm.Mesh(bars.vertices, bars.faces, pm.Material("grid", 0.7), "grid")
    air = trimesh.creation.box((1.1, 0.1, 1.1))
    case = pm.Mesh(air.vertices, air.faces, pm.Material.glass("air", 1.0), "case")
    camera = pm.Camera((0.3, 1.2, 1.5), (0.0, 0.0, 0.0), fov=45)
    wanted, found = (
        pm.render(pm.Scene(meshes, [colored_sky()], camera), bands="rgb", size=(48, 32), passes=8)
        for meshes in [[grid], [grid, case]]
    )
    for seen, light in [
        (found.caustics, wanted.direct),
        (found.indirect - found.caustics, wanted.indirect),
    ]:
        np.testing.assert_allclose(seen.mean((0, 1)), light.mean((0, 1)), rtol=0.04)


@pytest.mark.parametrize("method", ["photon", "path"])
def test_a_lamp_in_still_water_has_no_noise(method):
    """What glass reflects and transmits is followed apart: F of the lamp shows in every sample."""
    water, floor = pm.Material.glass("water", 1.33), pm.Material("floor", 0.0)
    lamp = plane(50.0, 3.0, pm.Material("lamp", 0.0, emission=2.0), "lamp")
    lamp = pm.Mesh(lamp.vertices, np.asarray(lamp.faces)[:, ::-1], lamp.material, "lamp")
    camera = pm.Camera((0.0, 1.0, 0.0), (0.8, 0.0, 0.0), fov=50.0)
    scene = pm.Scene([plane(50.0, 0.0, water), plane(50.0, -1.0, floor, "floor"), lamp], [], camera)
    settings = {"bands": "rgb", "size": (12, 8), "passes": 4, "seed": 1, "pixel": "center"}
    result = pm.render(scene, **settings, method=method)
    reflected = np.vectorize(fresnel.fresnel)(1.0 / result.distance, 1.0 / 1.33)
    np.testing.assert_allclose(result.emission[..., 0], 2.0 * reflected, rtol=1e-5)
    assert (result.errors["emission"] <= 1e-6 * result.emission).all()
