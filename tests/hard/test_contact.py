"""Contact and grazing: things that touch, and rays along walls and through edges."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from cases import assert_mean, assert_same, means, means_of, rendered
from helpers.scenes import GREY, closed_box, quad

import photonmap as pm

BOX = pm.scenes.cornell_box()
FLOOR = quad((-2, 0, -2), (-2, 0, 2), (2, 0, 2), (2, 0, -2), GREY, "floor")
WHITE = pm.DomeLight(1.0)
LAMP = pm.PointLight((1.0, 2.0, 1.5), 5.0)
HIDDEN = pytest.mark.filterwarnings(
    "ignore:lights? .* sends? nothing into the view",
    "ignore:no photon was found for",
)
"""For scenes of which little is lit."""
VIEW = pm.Camera((1, 1.5, 3), (0, 0.2, 0), fov=35)


def body(shape, height, smooth=False):
    """A thing of size 1 whose lowest point is at a height."""
    mesh = {
        "cube": trimesh.creation.box((1, 1, 1)),
        "ball": trimesh.creation.icosphere(subdivisions=2, radius=0.5),
        "cylinder": trimesh.creation.cylinder(0.5, 1.0, sections=24),
    }[shape]
    normals = mesh.vertices if smooth else None
    lift = [0, height - mesh.vertices[:, 1].min(), 0]
    return pm.Mesh(mesh.vertices + lift, mesh.faces, GREY, shape, normals)


@pytest.mark.parametrize(
    ("shape", "height"), [("cube", 0.0), ("cylinder", 1e-7), ("cube", -1e-7), ("ball", -1e-7)]
)
def test_a_body_that_rests_on_a_floor(shape, height):
    """However near it is, its light is that of the path tracer."""
    scene = pm.Scene([FLOOR, body(shape, height)], [LAMP], VIEW)
    values, wanted = (means(scene, "indirect", method=method) for method in ("photon", "path"))
    assert_same(values, wanted, slack=0.01)


@pytest.mark.parametrize("height", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5])
def test_a_light_near_a_wall(height):
    """E = I h / (d² + h²)^(3/2), at pixels' centres away from below the light."""
    camera = pm.Camera((0.0, 1.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), fov=60)
    scene = pm.Scene([FLOOR], [pm.PointLight((0.1, height, 0.05), 1.0)], camera)
    result = rendered(scene, pixel="center", size=(16, 16))
    reach = np.tan(np.radians(30.0)) * (2.0 * np.arange(16) - 15.0) / 16.0
    squared = (reach[None, :] - 0.1) ** 2 + (reach[:, None] - 0.05) ** 2
    wanted = height / (squared + height**2) ** 1.5 / np.pi
    np.testing.assert_allclose(result.shading[..., 0], wanted, rtol=1e-3)


@HIDDEN
@pytest.mark.parametrize("height", [1e-5, 1e-7, 0.0, -1e-7])
def test_a_light_that_touches_a_wall(height):
    """Its light is sound, wherever rounding puts it, and none passes through the wall."""
    scene = pm.Scene([FLOOR, body("cube", 0.0)], [pm.PointLight((0.9, height, 0.3), 1.0)], VIEW)
    rendered(scene, size=(24, 24))


@HIDDEN
@pytest.mark.parametrize("height", [1e-2, 1e-5, 1e-7, 0.0])
@pytest.mark.parametrize("up", [True, False])
def test_a_lamp_on_a_wall(height, up):
    """A panel that shines up, or at the floor from so near; in the plane of the floor too."""
    panel = quad((-1, height, -1), (1, height, -1), (1, height, 1), (-1, height, 1),
                 pm.Material("lamp", 0.2, 1.0), "lamp")  # fmt: skip
    if up:
        panel = replace(panel, faces=panel.faces[:, ::-1])
    result = rendered(pm.Scene([FLOOR, body("cube", 0.0), panel], camera=VIEW), size=(24, 24))
    if height:
        assert bool(result.emission.any()) is up


@HIDDEN
@pytest.mark.parametrize("depth", [0.0, 1e-7, -1e-7, 1e-3])
def test_a_camera_on_a_surface(depth):
    camera = pm.Camera((0.9, depth, 0.3), (0.0, 0.3, 0.0), fov=80)
    rendered(pm.Scene([FLOOR, body("cube", 0.0)], [LAMP], camera))


@HIDDEN
def test_a_camera_in_a_solid_sees_its_dark_inside():
    camera = pm.Camera((0.1, 0.4, 0.2), (1.0, 0.5, 0.0), fov=80)
    scene = pm.Scene([FLOOR, body("cube", 1e-3)], [LAMP], camera)
    result = rendered(scene)
    assert (result.coverage == 1.0).all()
    assert not result.shading.any()


@HIDDEN
def test_a_camera_in_a_lamp_sees_its_dark_inside():
    lamp = closed_box(pm.Material("lamp", 0.5, 3.0), -0.2, 0.2, "lamp")
    lamp = replace(lamp, faces=lamp.faces[:, ::-1])
    camera = pm.Camera((0.1, 0.05, 0.0), (1.0, 0.5, 0.0), fov=80)
    result = rendered(pm.Scene([closed_box(GREY), lamp], camera=camera))
    assert not result.radiance.any()
    assert not result.shading.any()


def test_a_camera_within_a_glowing_room_sees_it_all():
    camera = pm.Camera((0.999999, 0.0, 0.0), (-1.0, 0.3, 0.0), fov=120)
    scene = pm.Scene([closed_box(pm.Material("wall", 0.5, 1.0))], camera=camera)
    assert_mean(means(scene), 2.0 * np.ones(2), slack=5e-3)


def grid(count):
    """A wall of count × count squares at z = 0."""
    ticks = np.linspace(-1.0, 1.0, count + 1)
    x, y = np.meshgrid(ticks, ticks)
    index = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)])
    vertices = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    return pm.Mesh(vertices, faces.reshape(-1, 3), GREY, "wall")


@pytest.mark.parametrize("shift", [0.0, 0.25])
def test_rays_through_edges_and_vertices(shift):
    """All pixels' centres fall on vertices of a wall, or all on edges: few rays may pass, 2%."""
    fov = 2.0 * np.degrees(np.arctan(0.5))
    camera = pm.Camera((shift / 8, 0.0, 2.0), (shift / 8, 0.0, 0.0), fov=fov)
    scene = pm.Scene([grid(32)], [WHITE], camera)
    result = rendered(scene, pixel="center", size=(16, 16))
    assert (result.coverage == 1.0).mean() >= 0.98


def test_rays_along_walls():
    """A camera in the plane of a wall, looking along it and over it."""
    wall = quad((0, 0, -2), (0, 0, 2), (0, 2, 2), (0, 2, -2), GREY, "wall")
    camera = pm.Camera((0.0, 0.5, 3.0), (0.0, 0.5, 0.0), fov=40)
    for pixel, size in (("center", (17, 17)), ("box", (16, 16))):
        rendered(pm.Scene([FLOOR, wall], [LAMP, WHITE], camera), pixel=pixel, size=size)


@pytest.mark.parametrize("shape", ["ball", "cylinder"])
def test_smooth_normals_at_grazing_light(shape):
    """Where the light grazes few large facets, both methods agree on what the normals say."""
    light = pm.PointLight((0.75, 0.02, 0.0), 1.0)
    scene = pm.Scene([FLOOR, body(shape, 0.0, smooth=True)], [light], VIEW)
    # Few paths come near the light, and bring most of what it sends there.
    values, wanted = (
        means_of(scene, method=method, passes=passes)
        for method, passes in (("photon", 2), ("path", 20))
    )
    for buffer in ("direct", "indirect"):
        assert_same(values[buffer], wanted[buffer], slack=0.02)


@HIDDEN
@pytest.mark.parametrize("degrees", [1.0, 0.01])
def test_two_walls_that_meet_at_a_small_angle(degrees):
    """The light that enters a wedge is that of the path tracer, reflected to and fro."""
    rise = np.tan(np.radians(degrees))
    white = pm.Material("white", 0.9)
    low = quad((0, 0, -1), (0, 0, 1), (1, 0, 1), (1, 0, -1), white, "low")
    high = quad((0, 0, -1), (1, rise, -1), (1, rise, 1), (0, 0, 1), white, "high")
    camera = pm.Camera((1.5, rise / 2, 0.0), (0.0, rise / 2, 0.0), fov=2 * degrees)
    scene = pm.Scene([low, high], [WHITE], camera)
    values, wanted = (means(scene, method=method) for method in ("photon", "path"))
    assert_same(values, wanted, slack=0.01)


def pit(lid):
    """A shaft of 1 × 1 × 1000, open or closed above."""
    shaft = trimesh.creation.box(bounds=[[-0.5, -1000.0, -0.5], [0.5, 0.0, 0.5]])
    faces = shaft.faces[:, ::-1]
    if not lid:
        faces = faces[shaft.face_normals[:, 1] < 0.5]
    return shaft.vertices, faces


def test_a_pit_of_a_thousand_widths_that_is_closed_and_glows():
    """A furnace of any shape: L = Le / (1 - ρ)."""
    mesh = pm.Mesh(*pit(True), pm.Material("wall", 0.5, 1.0), "pit")
    camera = pm.Camera((0.1, -500.0, 0.2), (0.0, -900.0, 0.0), (1, 0, 0), fov=90)
    assert_mean(means(pm.Scene([mesh], camera=camera)), 2.0 * np.ones(2), slack=5e-3)


@HIDDEN
@pytest.mark.parametrize("height", [3.0, -1.0])
def test_a_pit_of_a_thousand_widths_under_the_sky(height):
    """Of a million photons one falls in, so paths take their place."""
    mesh = pm.Mesh(*pit(False), pm.Material("wall", 0.8), "pit")
    camera = pm.Camera((0.1, height, 0.2), (0.0, -900.0, 0.0), (1, 0, 0), fov=20)
    scene = pm.Scene([mesh], [WHITE], camera)
    values = means(scene, "indirect")
    assert_same(values, means(scene, "indirect", method="path"), slack=0.02)


@HIDDEN
@pytest.mark.parametrize("thickness", [1e-5, 1e-3])
def test_a_closed_box_in_a_lit_room_stays_black(thickness):
    """Grey inside, standing on the room's floor; of walls of any thickness. Not one ray leaks."""
    low, high = np.array([-0.9, -1.0, 0.5]), np.array([-0.5, -0.6, 0.9])
    inner = trimesh.creation.box(bounds=[low + thickness, high - thickness])
    outer = trimesh.creation.box(bounds=[low, high])
    walls = [pm.Mesh(inner.vertices, inner.faces[:, ::-1], GREY, "inside")]
    if thickness:
        walls.append(pm.Mesh(outer.vertices, outer.faces, GREY, "outside"))
    camera = pm.Camera((-0.7, -0.8, 0.7), (-0.6, -0.9, 0.55), fov=120)
    scene = replace(BOX, meshes=[*BOX.meshes, *walls], camera=camera)
    result = rendered(scene, size=(32, 32), photons=20000, passes=8)
    assert not result.radiance.any()
    assert not result.shading.any()
