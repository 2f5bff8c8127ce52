"""Optics: the critical angle, glass that touches or hides, facing mirrors, and focused light."""

import numpy as np
import pytest
import trimesh
from cases import assert_mean, assert_same, means, rendered
from helpers.marks import slow
from helpers.scenes import GREY, balls_in_box, closed_box, quad

import photonmap as pm
from photonmap.integrators.photon_mapping import caustics
from photonmap.kernels.core import fresnel

WHITE = pm.DomeLight(1.0)
GLASS = pm.Material.glass()
MIRROR = pm.Material.polished()
CUT = pytest.mark.filterwarnings(
    "ignore:.*successive reflections",
    "ignore:[0-9]* of [0-9]* photons were truncated",
    "ignore:method path finds no caustics",
)
"""For light that stays in glass, or between mirrors."""


def ball(radius, material, name="ball", center=(0, 0, 0), smooth=True):
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    normals = mesh.vertices / radius if smooth else None
    return pm.Mesh(mesh.vertices + center, mesh.faces, material, name, normals)


def cube(material, low, high, name="cube"):
    mesh = trimesh.creation.box(bounds=[low, high])
    return pm.Mesh(mesh.vertices, mesh.faces, material, name)


@pytest.mark.parametrize("ior", [1.000001, 1.33, 1.5, 2.4, 100.0])
@pytest.mark.parametrize("step", [-1e-6, -1e-12, 0.0, 1e-12, 1e-6])
def test_at_the_critical_angle(ior, step):
    """Reflectance rises to 1 and stays there, and the refracted ray does not come back."""
    angle = np.arcsin(1.0 / ior) + step
    reflectance = fresnel.fresnel(np.cos(angle), ior)
    assert 0.0 <= reflectance <= 1.0
    if step > 1e-9:
        assert reflectance == 1.0
    out = fresnel.refracted((np.sin(angle), -np.cos(angle), 0.0), (0.0, 1.0, 0.0), ior)
    assert np.isfinite(out).all()
    assert out[1] <= 1e-12


@CUT
@pytest.mark.parametrize("step", [-1e-6, 1e-6])
def test_a_prism_seen_at_the_critical_angle(step):
    """From within glass, a face shows the sky up to the critical angle, and the inside beyond."""
    angle = np.arcsin(1.0 / 1.5) + step
    camera = pm.Camera((0, 0.5, 0), (np.sin(angle), 0.5 + np.cos(angle), 0), (0, 0, 1), fov=1e-5)
    scene = pm.Scene([cube(GLASS, (-9, 0, -9), (9, 1, 9))], [WHITE], camera)
    rendered(scene)


HALF = cube(GLASS, (-1, -1, -1), (0, 1, 1), "half")
SHELLS = {
    "ball": [ball(1.0, GLASS)],
    "nested": [ball(1.0, GLASS), ball(0.5, pm.Material.glass("diamond", 2.4), "core")],
    "hollow": [
        ball(1.0, GLASS),
        pm.Mesh(0.9 * ball(1.0, GLASS).vertices, ball(1.0, GLASS).faces[:, ::-1], GLASS, "hole"),
    ],
    "apart": [
        cube(GLASS, (-1, -1, -1), (-1e-3, 1, 1), "one"),
        cube(GLASS, (1e-3, -1, -1), (1, 1, 1), "other"),
    ],
    "touching": [HALF, pm.Mesh(HALF.vertices * [-1, 1, 1], HALF.faces[:, ::-1], GLASS, "other")],
    "mirror in glass": [ball(1.0, GLASS), ball(0.5, MIRROR, "core")],
    "vacuum": [ball(1.0, pm.Material.glass("v", 1.000001))],
    "lighter": [ball(1.0, pm.Material.glass("l", 0.999999))],
}  # fmt: skip


@CUT
@pytest.mark.parametrize("name", SHELLS)
def test_what_absorbs_nothing_is_invisible_under_a_white_sky(name):
    """A sky of 1 seen through, past and in it is 1: 2% may stay in flat glass for ever."""
    scene = pm.Scene(SHELLS[name], [WHITE], pm.Camera((0.5, 0.7, 5), (0, 0, 0), fov=40))
    slack = 0.02 if name in ("apart", "touching", "hollow") else 1e-3
    assert_mean(means(scene), np.ones(2), slack=slack)


@pytest.mark.parametrize("ior", [1.000001, *slow(0.999999)])
def test_glass_like_air_is_invisible(ior):
    """A grey room seen through it looks as it does without it."""
    room, camera = closed_box(GREY), pm.Camera((0.3, 0.2, 0.9), (0, -0.5, -1), fov=60)
    light = pm.PointLight((0.2, 0.8, 0.3), 1.0)
    plain = pm.Scene([room], [light], camera)
    through = pm.Scene([room, ball(0.3, pm.Material.glass("air", ior))], [light], camera)
    settings = {"photons": 4000, "size": (16, 16)}
    assert_same(means(through, **settings), means(plain, **settings), slack=0.03)


def walls(material):
    """A corridor of two walls, open at its ends."""
    return [quad((-20, y, -20), (-20, y, 20), (20, y, 20), (20, y, -20), material, f"wall {y}")
            for y in (-1.0, 1.0)]  # fmt: skip


@CUT
@pytest.mark.parametrize("method", ["photon", "path"])
def test_a_mirror_corridor(method):
    """White mirrors: where the sky is seen at all, it is 1."""
    camera = pm.Camera((0, 0.3, 0), (0.5, 1.0, 0.1), fov=50)
    result = rendered(pm.Scene(walls(MIRROR), [WHITE], camera), method=method, size=(16, 16))
    np.testing.assert_allclose(result.radiance, 1.0, rtol=1e-5)


@pytest.mark.parametrize("method", ["photon", "path"])
def test_a_mirror_that_faces_itself(method):
    """A camera that looks straight at one of two mirrors is warned: it sees mirrors for ever."""
    camera = pm.Camera((0, 0, 0), (0, 1, 0), (1, 0, 0), fov=1)
    with pytest.warns(pm.SceneWarning, match="more than 256 successive reflections"):
        result = rendered(pm.Scene(walls(MIRROR), [WHITE], camera), method=method)
    assert not result.shading.any()


@CUT
def test_the_inside_of_a_mirror_bowl():
    """Paths run along its wall in ever so many small steps."""
    lamp, bowl = pm.PointLight((0.1, 0.2, 0.1), 1.0), ball(1.0, MIRROR, "bowl")
    low = bowl.vertices[bowl.faces][:, :, 1].max(axis=1) < 0.0
    bowl = pm.Mesh(bowl.vertices, bowl.faces[low], MIRROR, "bowl", bowl.normals)
    rendered(pm.Scene([bowl, ball(0.2, GREY, "core")], [lamp],
                      pm.Camera((0.0, 0.1, 0.9), (0, -1.0, 0.3), fov=90)))  # fmt: skip


def test_a_caustic_focused_on_a_point():
    """A paraboloid under a sun at its zenith: all light it gets is in the caustic at its focus."""
    ticks = np.linspace(-1.0, 1.0, 65)
    x, z = np.meshgrid(ticks, ticks)
    vertices = np.stack([x.ravel(), 0.25 * (x.ravel() ** 2 + z.ravel() ** 2), z.ravel()], axis=1)
    normals = np.stack([-0.5 * x.ravel(), np.ones(x.size), -0.5 * z.ravel()], axis=1)
    index = np.arange(65 * 65).reshape(65, 65)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    dish = pm.Mesh(vertices, faces, MIRROR, "dish", normals)
    target = quad(*(0.05 * np.array([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)]) + [0, 1, 0]),
                  pm.Material("target", 0.5), "target")  # fmt: skip
    width = 2e-3  # of the view, which holds all of the focus: a ten thousandth of the dish
    fov = 2 * np.degrees(np.arctan(width))
    camera = pm.Camera((0.0, 0.5, 0.0), (0, 1, 0), (1, 0, 0), fov=fov)
    scene = pm.Scene([dish, target], [pm.DirectionalLight((0, -1, 0), 1.0)], camera)
    images = np.array([rendered(scene, seed=seed, size=(16, 16), photons=8000).caustics
                       for seed in range(6)], float)  # fmt: skip
    flux = np.pi / 0.5 * width**2 * images.mean(axis=(1, 2))
    assert_mean(flux, np.full(2, 4.0 - 0.01), slack=0.02)


@pytest.mark.parametrize("with_mirror", [False, True])
def test_a_sky_with_a_sun_of_one_pixel(with_mirror):
    """All light comes from one texel of 512: E = L Ω cos θ."""
    texels = np.zeros((16, 32, 3))
    texels[3, 8] = 1e6
    floor = quad((-2, 0, -2), (-2, 0, 2), (2, 0, 2), (2, 0, -2), GREY, "floor")
    meshes = [floor, ball(0.2, MIRROR, center=(1.5, 0.5, 1.5))] if with_mirror else [floor]
    scene = pm.Scene(meshes, [pm.EnvironmentLight(texels)], pm.Camera((0, 2, 0.1), (0, 0, 0)))
    edges = np.pi * np.array([3, 4]) / 16
    projected = np.pi / 16 * 0.5 * (np.cos(edges[0]) ** 2 - np.cos(edges[1]) ** 2)
    values = means(scene, "direct", bands="rgb")
    assert_mean(values, np.full(3, 0.5 / np.pi * 1e6 * projected), slack=2e-3)


@CUT
def test_black_surfaces_and_glass_in_contact():
    """A black floor below balls of glass: chains of smooth surfaces that begin at reflectance 0."""
    black = pm.Material("black", 0.0)
    floor = quad((-2, 0, -2), (-2, 0, 2), (2, 0, 2), (2, 0, -2), black, "floor")
    balls = [ball(0.3, GLASS, f"ball {x}", (x, 0.3, 0)) for x in (-0.6, 0.0, 0.6)]
    balls.append(ball(0.3, MIRROR, "mirror", (0.0, 0.3, 0.6)))
    grey = quad((-2, 0, -2), (2, 0, -2), (2, 2, -2), (-2, 2, -2), GREY, "back")
    scene = pm.Scene([floor, grey, *balls], [pm.PointLight((0.5, 3, 2), 5.0)],
                     pm.Camera((0, 1, 3), (0, 0.2, 0)))  # fmt: skip
    for method in ("photon", "path"):
        rendered(scene, method=method, size=(24, 24), passes=8)


@CUT
@pytest.mark.parametrize("method", ["photon", "path"])
def test_a_black_floor_between_mirrors(method):
    """Gather rays that end on reflectance 0 near a corner go on as paths that carry nothing."""
    shaft = trimesh.creation.box(bounds=[[-0.3, 0, -0.3], [0.3, 3, 0.3]])
    up = shaft.face_normals[:, 1]
    parts = {"floor": (up < -0.5, pm.Material("black", 0.0)), "ceiling": (up > 0.5, GREY),
             "mirror": (np.abs(up) < 0.5, MIRROR)}  # fmt: skip
    meshes = [
        pm.Mesh(shaft.vertices, shaft.faces[chosen], material, name)
        for name, (chosen, material) in parts.items()
    ]
    scene = pm.Scene([*meshes, cube(GREY, (-0.1, 0, -0.1), (0.1, 0.2, 0.1))],
                     [pm.PointLight((0.1, 2.5, 0.1), 5.0)],
                     pm.Camera((0, 0.5, 0.25), (0, 0.05, 0), fov=50))  # fmt: skip
    rendered(scene, method=method, size=(24, 24), passes=8)


@pytest.mark.slow
@CUT
@pytest.mark.parametrize("core", [(0.0, 0.0, 0.0), (3.0, 0.0, 0.0)], ids=["inside", "outside"])
def test_the_pilot_of_a_closed_ball_of_mirrors(core, monkeypatch):
    """Photons that smooth surfaces keep for ever are few before the passes, and in them."""
    monkeypatch.setattr(caustics, "PILOT", 1 << 16)
    totals = []
    trace = caustics.CausticTracer._trace

    def counted(self, index, total, *others):
        totals.append(total)
        return trace(self, index, total, *others)

    monkeypatch.setattr(caustics.CausticTracer, "_trace", counted)
    bowl = ball(1.0, pm.Material.polished(mirror=0.9), "bowl")
    bowl = pm.Mesh(bowl.vertices, bowl.faces[:, ::-1], bowl.material, "bowl", -bowl.normals)
    scene = pm.Scene([bowl, ball(0.05, GREY, "core", core)], [pm.PointLight((0.1, 0.2, 0.3))],
                     pm.Camera((0.3, 0.2, 0.8), (-0.2, -0.1, -1)))  # fmt: skip
    rendered(scene, passes=2)
    pilot, check, *passes = totals[-4:]  # those before compile
    assert caustics.PILOT // 16 <= pilot <= caustics.PILOT // 8
    assert check == pilot // 4
    assert max(passes) <= 2000
    rendered(balls_in_box(), passes=2)
    assert totals[-4] == caustics.PILOT
