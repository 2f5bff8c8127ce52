"""Emitters and sensors of Mitsuba as lights and cameras."""

import math

import numpy as np
import pytest

from photonmap.compile.camera import camera_rays
from photonmap.errors import InputError, SceneWarning
from photonmap.scene.images import write_image
from photonmap.scene.lights import (
    DirectionalLight,
    DomeLight,
    EnvironmentLight,
    PhotometricLight,
    PointLight,
    SpotLight,
)

BALL = '<shape type="sphere"/>'
AIMED = '<transform name="to_world"><lookat origin="1 2 3" target="1 2 0" up="0 1 0"/></transform>'
FILM = """<film type="hdrfilm"><integer name="width" value="60"/>
<integer name="height" value="30"/></film>"""


@pytest.fixture
def light_of(load):
    def light_of(kind, inside="", **options):
        return load(f'{BALL}<emitter type="{kind}">{inside}</emitter>', **options).lights[0]

    return light_of


@pytest.fixture
def camera_of(load):
    def camera_of(kind, inside="", film=FILM):
        return load(f'{BALL}<sensor type="{kind}" id="eye">{inside}{film}</sensor>').camera

    return camera_of


def test_points(light_of):
    red = '<rgb name="intensity" value="3 2 1"/>'
    at = light_of("point", red + '<point name="position" value="1 2 3"/>')
    assert at == light_of("point", red + AIMED) == PointLight((1, 2, 3), (3.0, 2.0, 1.0))
    assert light_of("point").intensity == (1.0, 1.0, 1.0)


def test_suns(light_of):
    bright = '<float name="irradiance" value="4"/>'
    sun = light_of("directional", bright + '<vector name="direction" value="1 -2 0"/>')
    assert sun == DirectionalLight((1.0, -2.0, 0.0), (4.0, 4.0, 4.0))
    assert light_of("directional", AIMED).direction == pytest.approx((0.0, 0.0, -1.0))


def test_domes(light_of):
    dome = light_of("constant", '<rgb name="radiance" value="3 2 1"/>')
    assert dome == DomeLight((3.0, 2.0, 1.0))


def test_spots(light_of):
    """The intensity falls linearly with the angle, from 18 to 24 degrees."""
    bright = '<float name="intensity" value="8"/>'
    spot = light_of("spot", AIMED + bright + '<float name="cutoff_angle" value="24"/>')
    assert isinstance(spot, PhotometricLight)
    assert spot.position == (1.0, 2.0, 3.0)
    assert spot.direction == pytest.approx((0.0, 0.0, -1.0))
    profile = spot.emitter().profile.intensity[:, 0] * spot.intensity[0]
    expected = np.zeros(181)
    expected[:19] = 8.0
    expected[19:24] = 8.0 * np.arange(5, 0, -1) / 6.0
    np.testing.assert_allclose(profile, expected, rtol=1e-5)


def test_spots_of_narrow_edges(light_of):
    angles = '<float name="cutoff_angle" value="24"/><float name="beam_width" value="23"/>'
    spot = light_of("spot", AIMED + angles)
    assert isinstance(spot, SpotLight)
    assert (spot.inner, spot.outer) == (23.0, 24.0)
    assert spot.emitter().axis == pytest.approx((0.0, 0.0, -1.0))


def test_names_of_lights(load):
    lights = load(BALL + '<emitter type="point" id="lamp"/><emitter type="point"/>' * 1).lights
    assert [light.name for light in lights] == ["lamp", ""]


@pytest.fixture
def sky(tmp_path):
    """A map whose colours are directions: red x, green y, blue z, each from 0 to 1."""
    rows, columns = (np.mgrid[0:64, 0:128] + 0.5) / 64.0 * np.pi
    across = np.sin(rows)
    directions = [across * np.sin(columns), np.cos(rows), -across * np.cos(columns)]
    write_image((0.5 * np.stack(directions, axis=-1) + 0.5).astype(np.float32), tmp_path / "a.exr")


def seen_in(light, direction):
    """Return the direction that the colour of a map stands for, in which photonmap shows it."""
    x, y, z = direction / np.linalg.norm(direction)
    height = len(light.image)
    turned = math.atan2(x, -z) + math.radians(light.rotation)
    column = int((turned / (2.0 * math.pi) + 0.5) % 1.0 * 2 * height)
    return 2.0 * light.image[int(math.acos(y) / math.pi * height), column] - 1.0


@pytest.mark.usefixtures("sky")
@pytest.mark.parametrize(
    ("steps", "matrix", "resampled"),
    [
        ("", np.eye(3), False),
        ('<rotate y="1" angle="90"/>', [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], False),
        ('<scale value="3"/><translate x="2"/>', np.eye(3), False),
        ('<rotate x="1" angle="90"/>', [[1, 0, 0], [0, 0, -1], [0, 1, 0]], True),
        ('<scale x="-1"/>', np.diag([-1, 1, 1]), True),
    ],
)
def test_environment_maps(light_of, steps, matrix, resampled):
    """Mitsuba's map shows +y above, -z at its edges and +x in its first quarter."""
    where = f'<transform name="to_world">{steps}</transform>'
    file = '<string name="filename" value="a.exr"/><float name="scale" value="2"/>'
    light = light_of("envmap", file + where)
    assert isinstance(light, EnvironmentLight)
    assert light.scale == 2.0
    assert (light.rotation == 180.0) == (resampled or "y" not in steps)
    for direction in np.random.default_rng(2).normal(size=(20, 3)):
        local = np.linalg.solve(matrix, direction / np.linalg.norm(direction))
        np.testing.assert_allclose(seen_in(light, direction), local, atol=0.06)


def test_a_map_that_is_not_twice_as_wide_is_resampled(light_of, tmp_path):
    """Linearly between the middles of texels: a bright row has no dark ones beside it."""
    rows = np.array([0.25, 0.25, 9, 0, 0, 1, 0.5, 0.25, 0.25, 0.25], np.float32)
    write_image(np.tile(rows[:, None, None], (1, 30, 3)), tmp_path / "a.exr")
    light = light_of("envmap", '<string name="filename" value="a.exr"/>')
    assert light.image.shape == (15, 30, 3)
    wanted = np.interp((np.arange(15) + 0.5) / 1.5 - 0.5, np.arange(10), rows)
    np.testing.assert_allclose(
        light.image, np.tile(wanted[:, None, None], (1, 30, 3)), rtol=1e-5, atol=1e-6
    )


def corner_rays(camera):
    """Return origins and directions at the centres of the corner pixels of 60 × 30, by depth."""
    rays = camera_rays(camera, (60, 30))[[0, 0, -1, -1], [0, -1, 0, -1]]
    origins, directions = rays[:, :3], rays[:, 3:]
    return origins, directions / np.abs(directions[:, 2:])


def expected_rays(half_width, center=(0.0, 0.0)):
    """Return the same for a view along -z, with x to the right."""
    x, y = half_width * 59 / 60, 0.5 * half_width * 29 / 30
    corners = np.array([[-x, y], [x, y], [-x, -y], [x, -y]])
    return np.column_stack([corners + center, np.full(4, -1.0)])


@pytest.mark.parametrize(
    ("inside", "half_width"),
    [
        ('<float name="fov" value="50"/>', math.tan(math.radians(25.0))),
        (
            '<float name="fov" value="50"/><string name="fov_axis" value="y"/>',
            2.0 * math.tan(math.radians(25.0)),
        ),
        (
            '<float name="fov" value="50"/><string name="fov_axis" value="larger"/>',
            math.tan(math.radians(25.0)),
        ),
        (
            '<float name="fov" value="50"/><string name="fov_axis" value="smaller"/>',
            2.0 * math.tan(math.radians(25.0)),
        ),
        (
            '<float name="fov" value="50"/><string name="fov_axis" value="diagonal"/>',
            math.tan(math.radians(25.0)) * 2.0 / math.sqrt(5.0),
        ),
        ("", math.hypot(18.0, 12.0) / 50.0 * 2.0 / math.sqrt(5.0)),
        (
            '<string name="focal_length" value="24mm"/>',
            math.hypot(18.0, 12.0) / 24.0 * 2.0 / math.sqrt(5.0),
        ),
    ],
)
def test_perspective_cameras(camera_of, inside, half_width):
    camera = camera_of("perspective", AIMED + inside)
    origins, directions = corner_rays(camera)
    assert camera.name == "eye"
    np.testing.assert_allclose(origins, [[1, 2, 3]] * 4)
    np.testing.assert_allclose(directions, expected_rays(half_width), rtol=1e-6)


def test_a_principal_point(camera_of):
    """Offsets of 0.2 and -0.1 show more of what lies to the right and above."""
    inside = """<float name="fov" value="90"/><float name="principal_point_offset_x" value=".2"/>
<float name="principal_point_offset_y" value="-.1"/>"""
    _, directions = corner_rays(camera_of("perspective", AIMED + inside))
    np.testing.assert_allclose(directions, expected_rays(1.0, (0.4, 0.1)), rtol=1e-6)


def test_lenses(camera_of):
    inside = """<float name="fov" value="90"/><float name="aperture_radius" value=".2"/>
<float name="focus_distance" value="4"/>"""
    camera = camera_of("thinlens", AIMED + inside)
    assert (camera.lens.radius, camera.lens.focus) == (0.2, 4.0)
    assert camera.fov == pytest.approx(math.degrees(2.0 * math.atan(0.5)))


def test_orthographic_cameras(camera_of):
    """Without a scale, the picture is 2 wide."""
    scaled = AIMED.replace("<lookat", '<scale x="3" y="3"/><lookat')
    origins, directions = corner_rays(camera_of("orthographic", scaled))
    np.testing.assert_allclose(directions, [[0, 0, -1]] * 4, atol=1e-12)
    x, y = 3.0 * 59 / 60, 1.5 * 29 / 30
    corners = np.array([[-x, y, 0], [x, y, 0], [-x, -y, 0], [x, -y, 0]])
    np.testing.assert_allclose(origins - [1, 2, 3], corners, rtol=1e-6)


def test_several_cameras(load):
    scene = load(BALL + f'<sensor type="perspective" id="a/b">{AIMED}</sensor>' * 1
                 + f'<sensor type="thinlens">{AIMED}<float name="aperture_radius" value="1"/>'
                 '<float name="focus_distance" value="1"/></sensor>')  # fmt: skip
    assert [camera.name for camera in scene.cameras] == ["a_b", "thinlens"]
    assert scene.camera == scene.cameras[0]


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_what_cameras_cut_off_is_named(camera_of, kind):
    """The ball of radius 1 is 3 away, from 2 to 4."""
    away = '<transform name="to_world"><lookat origin="0, 0, 3" target="0, 0, 0" up="0, 1, 0"/>'
    away += '</transform><float name="{}_clip" value="{}"/>'
    assert camera_of(kind, away.format("near", 1.9) + '<float name="far_clip" value="4.1"/>')
    for plane in (("near", 2.5), ("far", 3.5)):
        with pytest.warns(SceneWarning, match="what near_clip and far_clip cut off of 'eye'"):
            camera_of(kind, away.format(*plane))
    with pytest.warns(SceneWarning, match="srf of 'eye'"):
        camera_of(kind, away.format("near", 0.1) + '<spectrum name="srf" value="1"/>')


def test_what_is_not_simulated_of_cameras(camera_of):
    mirrored = AIMED.replace("<lookat", '<scale x="-1"/><lookat')
    crop = FILM.replace("</film>", '<integer name="crop_width" value="3"/></film>')
    with pytest.warns(SceneWarning, match="mirrored view of 'eye'; crop of 'eye'$"):
        camera_of("perspective", mirrored, crop)


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ('<sensor type="irradiancemeter"/>', "a sensor of type 'irradiancemeter' is not simulated"),
        ('<sensor type="perspective"><float name="fov" value="180"/></sensor>', "180 degrees is"),
        (
            '<sensor type="perspective"><string name="fov_axis" value="z"/></sensor>',
            "fov_axis 'z' is not known",
        ),
        (
            '<sensor type="perspective"><string name="focal_length" value="tele"/></sensor>',
            "'tele' is not a number",
        ),
        (
            '<sensor type="thinlens"><float name="aperture_radius" value="1"/></sensor>',
            "aperture_radius is given without focus_distance; add",
        ),
        (
            '<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="0"/>'
            "</film></sensor>",
            "a film of 0x576 is not possible",
        ),
        ('<emitter type="sunsky"/>', "an emitter of type 'sunsky' is not simulated"),
        ('<emitter type="spot"><float name="cutoff_angle" value="-3"/></emitter>', "inner"),
        ('<emitter type="envmap"/>', "emitter 'envmap' lacks filename"),
        (
            '<emitter type="directional"><vector name="direction" value="0"/></emitter>',
            "has no length",
        ),
    ],
)
def test_values_that_are_not_valid(load, inside, message):
    with pytest.raises(InputError, match=f"scene.xml:1: .*{message}"):
        load(BALL + inside)


def test_what_integrators_leave_out_is_named(load):
    shape = '<shape type="sphere"/>'
    load(f'{shape}<integrator type="path"><integer name="max_depth" value="-1"/></integrator>')
    named = r"integrator 'direct' of .*; an end of paths \(max_depth\) of .*; hidden emitters"
    with pytest.warns(SceneWarning, match=named):
        load(
            f'{shape}<integrator type="direct"><integer name="max_depth" value="4"/>'
            '<boolean name="hide_emitters" value="true"/></integrator>'
        )


@pytest.mark.parametrize(
    ("kind", "given"),
    [("directional", "vector name='direction'"), ("point", "point name='position'")],
)
def test_a_light_is_placed_once(load, kind, given):
    turn = '<transform name="to_world"><translate x="1"/></transform>'
    with pytest.raises(InputError, match=r"scene\.xml:1: .* and to_world are both given; keep one"):
        load(f'<emitter type="{kind}"><{given} value="0 0 1"/>{turn}</emitter>')


@pytest.mark.parametrize(
    ("node", "named"),
    [
        ('emitter type="directional"', "the scale of to_world, by which Mitsuba multiplies"),
        ('emitter type="spot"', "shear or uneven scale of its cone"),
        ('sensor type="orthographic"', "shear or uneven scale of the view"),
        ('sensor type="perspective"', "shear or uneven scale of the view"),
    ],
)
def test_scales_that_are_not_simulated_are_named(load, node, named):
    """In 3.9, a directional light of scale 2 is twice as bright, and cones and films stretch."""
    shape, tag = '<shape type="sphere"/>', node.partition(" ")[0]
    for steps in ('<rotate x=".6" y=".8" angle="40"/>', '<translate x="2"/>'):
        load(f'{shape}<{node}><transform name="to_world">{steps}</transform></{tag}>')
    uneven = '<scale x="2" z="2"/><rotate y="1" angle="40"/>'
    with pytest.warns(SceneWarning, match=named):
        load(f'{shape}<{node}><transform name="to_world">{uneven}</transform></{tag}>')
