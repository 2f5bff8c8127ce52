"""Cameras and lights at the nodes of glTF files."""

import math
from contextlib import nullcontext

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from photonmap.errors import InputError, SceneWarning
from photonmap.io.readers.scene_file import load_scene
from photonmap.scene.lights import DirectionalLight, PointLight, SpotLight

pytestmark = pytest.mark.usefixtures("silence")
LIGHTS = "KHR_lights_punctual"
QUATERNION = Rotation.from_euler("xyz", [0.3, -1.1, 2.0]).as_quat()
MOVE = np.array([3.0, -2.0, 5.0])


@pytest.fixture
def scene_of(tmp_path, build):
    """Load a triangle with cameras and lights at nodes."""

    def scene_of(nodes, cameras=(), lights=(), toml=None):
        build.primitive()
        build.tree["nodes"] += nodes
        children = {child for node in nodes for child in node.get("children", ())}
        build.tree["scenes"][0]["nodes"] += sorted({*range(1, 1 + len(nodes))} - children)
        build.tree["cameras"] = list(cameras)
        build.tree["extensions"] = {LIGHTS: {"lights": list(lights)}}
        (tmp_path / "a.glb").write_bytes(build.glb())
        if toml:
            (tmp_path / "a.toml").write_text(toml)
        return load_scene(tmp_path / "a.glb")

    return scene_of


def shining(light=0, **node):
    return {**node, "extensions": {LIGHTS: {"light": light}}}


def projected(matrix, projection, point, size):
    """Project as glTF 2.0 says (3.10.3): by the inverse of the node's matrix, then to the film."""
    clip = projection @ np.linalg.inv(matrix) @ [*point, 1.0]
    x, y = clip[:2] / clip[3]
    return (0.5 + 0.5 * x) * size[0], (0.5 - 0.5 * y) * size[1]


def shown_at(camera, point, size):
    """Project as the record of a render says."""
    record = camera.describe(*size)
    at = np.linalg.inv(record["camera_to_world_opencv"]) @ [*point, 1.0]
    depth = at[2] if record["kind"] == "pinhole" else 1.0
    x, y, _ = np.array(record["intrinsics"]) @ [at[0] / depth, at[1] / depth, 1.0]
    return x, y


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_cameras_show_what_gltf_says(scene_of, kind, scale):
    size, yfov, ymag = (64, 48), 0.8, 2.5
    aspect = size[0] / size[1]
    lens = {"yfov": yfov, "znear": 0.1, "zfar": 100.0 / scale}
    focal = 1.0 / math.tan(yfov / 2)
    projection = np.array([[focal / aspect, 0, 0, 0], [0, focal, 0, 0], [0] * 4, [0, 0, -1.0, 0]])
    if kind == "orthographic":
        lens = {"xmag": ymag * aspect, "ymag": ymag, "znear": 0.1, "zfar": 100.0 / scale}
        projection = np.diag([1.0 / (ymag * aspect), 1.0 / ymag, 0.0, 1.0])
    nodes = [
        {"translation": MOVE.tolist(), "scale": [scale] * 3, "children": [2]},
        {"rotation": QUATERNION.tolist(), "camera": 0, "name": "eye"},
    ]
    scene = scene_of(nodes, [{"type": kind, kind: lens}])
    matrix = np.eye(4)
    matrix[:3, :3] = scale * Rotation.from_quat(QUATERNION).as_matrix()
    matrix[:3, 3] = MOVE
    assert scene.camera.name == "eye"
    for local in ([0.2, -0.1, -3.0], [-1.0, 0.8, -6.0]):
        point = (matrix @ [*local, 1.0])[:3]
        expected = projected(matrix, projection, point, size)
        assert shown_at(scene.camera, point, size) == pytest.approx(expected, rel=1e-6)


def test_all_cameras_can_be_chosen(scene_of):
    lens = {"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}, "name": "lens"}
    places = [{"camera": 0, "name": name} for name in ("left/right", "left/right", "all", "")]
    scene = scene_of([*places, {"name": "none"}], [lens])
    names = [camera.name for camera in scene.every_camera]
    assert names == ["left_right", "left_right_2", "all_3", "lens"]
    assert scene.seen_by("lens").camera.fov == pytest.approx(math.degrees(1.0))


def test_a_camera_beside_the_file_takes_its_place(scene_of):
    lens = {"type": "perspective", "perspective": {"yfov": 1.0}}
    toml = "[camera]\norigin = [0, 0, 3]\ntarget = [0, 0, 0]\n"
    scene = scene_of([{"camera": 0}], [lens], toml=toml)
    assert [camera.origin for camera in scene.every_camera] == [(0.0, 0.0, 3.0)]


def test_lights(scene_of):
    turned = {"rotation": QUATERNION.tolist(), "translation": MOVE.tolist(), "scale": [2, 2, 2]}
    lights = [
        {"type": "point", "color": [1, 0.5, 0], "intensity": 8, "name": "bulb"},
        {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.6}},
        {"type": "spot"},
        {"type": "directional", "intensity": 3},
    ]
    nodes = [shining(0, **turned), *(shining(i, name=f"light {i}", **turned) for i in (1, 2, 3))]
    point, spot, wide, sun = scene_of(nodes, lights=lights).lights
    ahead = Rotation.from_quat(QUATERNION).apply([0, 0, -1])
    assert point == PointLight(tuple(MOVE.tolist()), (8.0, 4.0, 0.0), "bulb")
    assert isinstance(spot, SpotLight)
    assert isinstance(sun, DirectionalLight)
    assert spot.emitter().axis == pytest.approx(tuple(ahead))
    assert (spot.inner, spot.outer) == pytest.approx((math.degrees(0.1), math.degrees(0.6)))
    assert (wide.inner, wide.outer) == pytest.approx((0.0, 45.0))
    assert wide.intensity == (1.0, 1.0, 1.0)
    assert sun.direction == pytest.approx(tuple(ahead))
    assert sun.irradiance == (3.0, 3.0, 3.0)


@pytest.fixture
def blender_scene(scene_of, build):
    """Load a triangle that glows beside a light, from Blender's exporter."""
    build.tree["asset"]["generator"] = "Khronos glTF Blender I/O v4.2.60"
    build.tree["materials"] = [{"name": "glow", "emissiveFactor": [1, 1, 1]}]
    build.primitive(more={"material": 0})
    return lambda light: scene_of([shining()], lights=[light])


@pytest.mark.parametrize("light", [{"type": "spot", "intensity": 543.5}, {"type": "directional"}])
def test_emission_of_blender_is_dim_beside_candela_and_lux(blender_scene, light):
    """Its exporter multiplies lights by 683, but not the strength of what emits."""
    standard = {"intensity": 683.0, **light}
    with pytest.warns(SceneWarning, match=r"emission beside lights in candela.* of 'glow'$"):
        blender_scene(standard)


@pytest.mark.parametrize("light", [{"type": "spot", "intensity": 0.8}, {"type": "directional"}])
def test_emission_of_blender_goes_with_unitless_lights(blender_scene, light):
    assert blender_scene(light).lights


def test_hidden_nodes_show_nothing_but_keep_cameras(scene_of, build):
    """KHR_node_visibility hides meshes and lights, with all below, whatever those say."""
    hide, show = ({"KHR_node_visibility": {"visible": visible}} for visible in (False, True))
    lens = {"type": "perspective", "perspective": {"yfov": 1.0}}
    nodes = [
        {"name": "top", "mesh": 0, "extensions": hide, "children": [2, 3]},
        {"name": "eye", "camera": 0, "mesh": 0, "extensions": show},
        {"name": "bulb", "extensions": {LIGHTS: {"light": 0}}},
        {"name": "seen", "mesh": 0, "extensions": show},
        {"name": "lamp", "extensions": {**show, LIGHTS: {"light": 0}}},
        {"name": "dark", "extensions": {**hide, LIGHTS: {"light": 0}}},
    ]
    build.tree["extensionsRequired"] = ["KHR_node_visibility"]
    scene = scene_of(nodes, [lens], [{"type": "point"}])
    assert [mesh.name for mesh in scene.meshes] == ["part", "seen"]
    assert [light.name for light in scene.lights] == ["lamp"]
    assert [camera.name for camera in scene.every_camera] == ["eye"]


@pytest.mark.parametrize("content", [{"visible": 0}, {"hidden": True}])
def test_a_visibility_that_is_not_understood(scene_of, content):
    with pytest.raises(InputError, match=r'a\.glb: node 1: KHR_node_v.*write {"visible": false}'):
        scene_of([{"extensions": {"KHR_node_visibility": content}}])


def test_lights_of_one_name_and_that_of_a_material(scene_of, build):
    build.tree["materials"] = [{"name": "lamp", "emissiveFactor": [1, 1, 1]}]
    build.primitive(more={"material": 0})
    scene = scene_of([shining(name="lamp"), shining(name="lamp")], lights=[{"type": "point"}])
    names = [light.name for light in scene.lights]
    assert len({*names, "lamp"}) == 3


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize(
    ("planes", "place", "is_cut"),
    [
        ({"znear": 1.0, "zfar": 6.0}, (0.0, 0.0, 5.0), False),
        ({"znear": 5.5}, (0.0, 0.0, 5.0), True),
        ({"znear": 0.1, "zfar": 4.0}, (0.0, 0.0, 5.0), True),
        ({"znear": 0.1, "zfar": 4.0}, (9.0, 0.0, 5.0), False),
        ({"znear": 5.5}, (0.0, 0.0, -5.0), False),
    ],
)
def test_what_cameras_cut_off_is_named(scene_of, kind, planes, place, is_cut):
    lens = {"yfov": 1.0} if kind == "perspective" else {"xmag": 2.0, "ymag": 2.0}
    camera = {"type": kind, kind: lens | planes}
    said = "what znear and zfar cut off of 'a'"
    with pytest.warns(SceneWarning, match=said) if is_cut else nullcontext():
        scene_of([{"camera": 0, "name": "a", "translation": place}], [camera])


def test_what_is_not_simulated(scene_of):
    lens = {"type": "perspective", "perspective": {"yfov": 1.0}}
    nodes = [{"camera": 0, "name": "a", "scale": [-1, 1, 1]}, shining(name="b")]
    message = "not simulated: mirrored view of 'a'; range of 'b'$"
    with pytest.warns(SceneWarning, match=message):
        scene_of(nodes, [lens], [{"type": "point", "range": 5.0}])


@pytest.mark.parametrize("inner", [0.6, 0.6000001])
def test_a_hard_spot_may_have_equal_angles(scene_of, inner):
    cone = {"innerConeAngle": inner, "outerConeAngle": 0.6}
    (spot,) = scene_of([shining()], lights=[{"type": "spot", "spot": cone}]).lights
    assert spot.inner == spot.outer


def test_an_inner_cone_beyond_the_outer_one_is_lowered_with_a_warning(scene_of):
    cone = {"innerConeAngle": 0.7, "outerConeAngle": 0.6}
    with pytest.warns(SceneWarning, match="not simulated: innerConeAngle above outerConeAngle of"):
        (spot,) = scene_of([shining()], lights=[{"type": "spot", "spot": cone}]).lights
    assert spot.inner == spot.outer == pytest.approx(math.degrees(0.6))


@pytest.mark.parametrize(
    ("node", "camera", "light", "message"),
    [
        ({"camera": 1}, {"type": "perspective"}, {}, "names cameras 1, but has 1"),
        ({"camera": 0}, {"type": "wide"}, {}, "a camera of type 'wide' is unknown; export it"),
        ({"camera": 0}, {"type": "perspective", "perspective": {}}, {}, "yfov None is not a num"),
        (
            {"camera": 0},
            {"type": "perspective", "perspective": {"yfov": 4}},
            {},
            "camera fov 229.* is not",
        ),
        (
            {"camera": 0, "scale": [0, 0, 0]},
            {"type": "perspective", "perspective": {"yfov": 1}},
            {},
            "its scale is 0, so it has no direction; correct the scale",
        ),
        (shining(1), {}, {}, "names light 1, but has 1"),
        (shining(True), {}, {}, "names light True, but has 1"),
        (shining(0), {}, {"type": "area"}, "a light of type 'area' is unknown"),
        (shining(0), {}, {"type": "point", "intensity": -1}, "intensity -1 is not a number of at"),
        (shining(0), {}, {"type": "point", "color": [1, 2]}, "color .* is not three numbers"),
        (shining(0), {}, {"type": "spot", "spot": {"outerConeAngle": 4}}, "outer 229.* is not"),
    ],
)
def test_what_is_refused(scene_of, node, camera, light, message):
    with pytest.raises(InputError, match=rf"a\.glb: .*{message}"):
        scene_of([{"name": "n", **node}], [camera], [light])
