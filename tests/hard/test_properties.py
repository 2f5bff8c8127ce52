"""Properties of random small scenes: what light must do whatever the scene.

`make fuzz` draws more of them, from any seed.
"""

import os
from dataclasses import replace

import hypothesis
import numpy as np
import pytest
from cases import SMALLEST, assert_same, means, means_of, rendered
from helpers.marks import slow
from helpers.scenes import closed_box, quad
from hypothesis import strategies as st
from hypothesis.internal.conjecture import providers

import photonmap as pm

# Examples would else depend on what was imported before: constants of those modules are tried too.
providers._get_local_constants = lambda: NO_CONSTANTS
NO_CONSTANTS = providers.Constants()

EXAMPLES = os.environ.get("PHOTONMAP_EXAMPLES")
"""Of each property; without it, a few, and with slow tests 145 in all, more of those that take few
renders."""
FEW = 2
SEED = os.environ.get("PHOTONMAP_SEED")
"""Of the examples; without one, they are always the same."""
pytestmark = pytest.mark.filterwarnings("ignore::photonmap.SceneWarning")

albedos = st.tuples(*(st.floats(0.0, 0.9) for _ in range(3)))
inside = st.tuples(*(st.floats(-0.8, 0.8) for _ in range(3)))
colors = st.tuples(*(st.floats(0.1, 2.0) for _ in range(3)))


@st.composite
def boxes(draw, number):
    """A box within the room, apart from its walls."""
    center, half = draw(inside), draw(st.tuples(*(st.floats(0.05, 0.3) for _ in range(3))))
    box = closed_box(pm.Material(f"box {number}", draw(albedos)), name=f"box {number}")
    return replace(box, vertices=0.6 * np.array(center) + box.vertices * half)


@st.composite
def lamps(draw, number):
    """A panel below the ceiling, or a point."""
    x, y, z = draw(inside)
    color = draw(colors)
    if draw(st.booleans()):
        return pm.PointLight((x, y, z), color, f"light {number}")
    corners = 0.15 * np.array([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)])
    material = pm.Material(f"light {number}", 0.3, color)
    return quad(*(corners + [x, 0.9 + 0.02 * number, z]), material, f"light {number}")


@st.composite
def scenes(draw):
    """A closed room with up to three boxes and two lights, seen from a corner of it.

    From below the lamps: in their plane a camera sees their backs alone, lit by walls on which the
    lamps' light ends amid a cell.
    """
    room = closed_box(pm.Material("room", draw(albedos)), name="room")
    things = [draw(boxes(number)) for number in range(draw(st.integers(0, 3)))]
    lights = [draw(lamps(number)) for number in range(draw(st.integers(1, 2)))]
    origin = draw(st.sampled_from([(0.9, 0.8, 0.9), (-0.9, 0.5, 0.9), (0.1, -0.9, -0.9)]))
    camera = pm.Camera(origin, tuple(0.3 * np.array(draw(inside))), fov=draw(st.floats(30, 100)))
    panels = [light for light in lights if isinstance(light, pm.Mesh)]
    points = [light for light in lights if isinstance(light, pm.PointLight)]
    return pm.Scene([room, *things, *panels], points, camera)


def one_by_one(scene):
    """Give a scene with each of its lights alone; the other lamps are there, but dark."""

    def lit(name):
        meshes = [
            mesh
            if mesh.name == name
            else replace(mesh, material=replace(mesh.material, emission=0.0))
            for mesh in scene.meshes
        ]
        return replace(
            scene, meshes=meshes, lights=[light for light in scene.lights if light.name == name]
        )

    lamps = [mesh for mesh in scene.meshes if np.any(mesh.material.emission)]
    return [lit(light.name) for light in [*lamps, *scene.lights]]


def moved(scene, matrix):
    """Return a scene, its lights and its camera under a linear map."""
    matrix = np.asarray(matrix, float)
    flip = -1 if np.linalg.det(matrix) < 0 else 1

    def place(point):
        return tuple(matrix @ point)

    meshes = [
        replace(mesh, vertices=mesh.vertices @ matrix.T, faces=mesh.faces[:, ::flip])
        for mesh in scene.meshes
    ]
    lights = [replace(light, position=place(light.position)) for light in scene.lights]
    camera = scene.camera
    camera = replace(camera, **{name: place(getattr(camera, name))
                                for name in ("origin", "target", "up")})  # fmt: skip
    return replace(scene, meshes=meshes, lights=lights, camera=camera)


def painted(scene, change):
    """Return a scene whose colours went through a function of arrays (3,)."""

    def paint(color, light):
        return tuple(map(float, change(np.array(np.broadcast_to(color, 3), float), light)))

    meshes = [
        replace(
            mesh,
            material=replace(
                mesh.material,
                reflectance=paint(mesh.material.reflectance, False),
                emission=paint(mesh.material.emission, True),
            ),
        )
        for mesh in scene.meshes
    ]
    lights = [replace(light, intensity=paint(light.intensity, True)) for light in scene.lights]
    return replace(scene, meshes=meshes, lights=lights)


def property_of_scenes(examples):
    """Run a test over a few random scenes, and over so many where there is time."""
    counts = [int(EXAMPLES)] if EXAMPLES else [FEW, *slow(examples)]

    def configure(check):
        @pytest.mark.parametrize("count", counts)
        def test(count):
            configured = hypothesis.settings(
                max_examples=count,
                derandomize=SEED is None,
                database=None,
                deadline=None,
                suppress_health_check=list(hypothesis.HealthCheck),
                phases=[hypothesis.Phase.generate],
            )(hypothesis.given(scenes())(check))
            (configured if SEED is None else hypothesis.seed(int(SEED))(configured))()

        test.__name__, test.__doc__ = check.__name__, check.__doc__
        return test

    return configure


SETTINGS = {"bands": "rgb", "size": (10, 10)}


@property_of_scenes(15)
def test_photons_agree_with_paths(scene):
    """Cells of as many photons as a render's own leave 3% of indirect light in doubt, at most."""
    photons = means_of(scene, photons=1 << 14, **SETTINGS)
    paths = means_of(scene, method="path", passes=8, **SETTINGS)  # rare paths matter in dark bands
    for buffer in ("direct", "indirect"):
        assert_same(photons[buffer], paths[buffer], slack=0.03)


@property_of_scenes(25)
def test_light_is_linear_in_power(scene):
    bright = painted(scene, lambda color, light: 1000.0 * color if light else color)
    one, other = rendered(scene, **SETTINGS), rendered(bright, **SETTINGS)
    for name in ("radiance", "shading"):
        values, wanted = other.buffers[name], 1000.0 * one.buffers[name]
        np.testing.assert_allclose(values, wanted, rtol=1e-4, atol=SMALLEST)


@property_of_scenes(15)
def test_light_is_the_sum_over_lights(scene):
    whole = means(scene, **SETTINGS)
    each = sum(means(one, **SETTINGS) for one in one_by_one(scene))
    assert_same(whole, each, slack=0.03)


@property_of_scenes(25)
def test_light_by_light_the_parts_add_up(scene):
    result = rendered(scene, per_light=True, **SETTINGS)
    for name in ("direct", "indirect", "shading"):
        total = sum(split[name].astype(float) for split in result.per_light.values())
        np.testing.assert_allclose(total, result.buffers[name], rtol=1e-5, atol=1e-12)


@property_of_scenes(15)
def test_a_quarter_turn_and_a_mirror_image_look_alike(scene):
    """In one: x and z are exchanged, as by a quarter turn after a mirror image."""
    exchanged = moved(scene, [[0, 0, 1], [0, 1, 0], [1, 0, 0]])
    values, wanted = (means(s, "shading", **SETTINGS) for s in (exchanged, scene))
    assert_same(values, wanted, slack=0.03)


@property_of_scenes(25)
def test_bands_know_nothing_of_each_other(scene):
    order = [2, 0, 1]
    one = rendered(scene, **SETTINGS)
    other = rendered(painted(scene, lambda color, light: color[order]), **SETTINGS)
    for name in ("radiance", "shading", "reflectance"):
        np.testing.assert_allclose(
            other.buffers[name], one.buffers[name][..., order], rtol=1e-3, atol=1e-6
        )


@property_of_scenes(25)
def test_more_reflectance_means_more_light(scene):
    whiter = painted(scene, lambda color, light: color if light else 0.5 + 0.5 * color)
    values, more = (means(s, "shading", **SETTINGS) for s in (scene, whiter))
    assert (more.mean(axis=0) >= 0.97 * values.mean(axis=0)).all()
