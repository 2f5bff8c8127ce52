"""USD stages: meshes, preview surfaces, lights and cameras, with y up."""

import math
import random
import sys
import warnings
from functools import partial

import numpy as np
import pytest
from helpers.usd_stages import READER, light, load_stage, painted, surface, triangle
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import photonmap as pm
from photonmap.io.png import write_png
from photonmap.scene.images import decode_srgb
from photonmap.scene.photometric import mean_over_directions, save_ies


@pytest.fixture
def load(tmp_path):
    return partial(load_stage, tmp_path)


def test_z_up_becomes_y_up(load):
    moved = "double3 xformOp:translate = (1, 2, 3)\n"
    moved += 'uniform token[] xformOpOrder = ["xformOp:translate"]'
    (mesh,) = load(triangle(moved), 'upAxis = "Z"').meshes
    np.testing.assert_allclose(mesh.vertices, [[1, 3, -2], [2, 3, -2], [1, 3, -3]])
    (mesh,) = load(triangle(moved), 'upAxis = "Y"', "b.usda").meshes
    np.testing.assert_allclose(mesh.vertices, [[1, 2, 3], [2, 2, 3], [1, 3, 3]])


def test_values_of_corners_faces_and_vertices(load):
    text = """def Mesh "m" {
        int[] faceVertexCounts = [4, 3]
        int[] faceVertexIndices = [0, 1, 2, 3, 0, 2, 4]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)]
        uniform token subdivisionScheme = "none"
        normal3f[] normals = [(0, 0, 1), (0, 1, 0)] (interpolation = "uniform")
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "faceVarying")
        int[] primvars:st:indices = [0, 1, 2, 3, 0, 2, 1]
        color3f[] primvars:displayColor = [(0.1, 0.2, 0.3)] (interpolation = "constant")
    }"""
    (mesh,) = load(text).meshes
    assert len(mesh.faces) == 3
    corners = mesh.vertices[mesh.faces[2]].tolist()
    assert corners == [[0, 0, 0], [1, 1, 0], [0, 0, 1]]
    assert mesh.normals[mesh.faces[2]].tolist() == [[0, 1, 0]] * 3
    assert mesh.uv[mesh.faces[2]].tolist() == [[0, 0], [1, 1], [1, 0]]
    np.testing.assert_allclose(mesh.colors, np.tile([0.1, 0.2, 0.3], (len(mesh.vertices), 1)))


def test_left_handed_faces_are_reversed(load):
    (mesh,) = load(triangle('uniform token orientation = "leftHanded"')).meshes
    a, b, c = mesh.vertices[mesh.faces[0]]
    assert np.cross(b - a, c - a)[2] == -1.0


def test_subsets_have_materials_of_their_own(load):
    text = (
        surface("color3f inputs:diffuseColor = (0.5, 0, 0)")
        + """def Mesh "m" {
        int[] faceVertexCounts = [3, 3]
        int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        uniform token subdivisionScheme = "none"
        def GeomSubset "half" (prepend apiSchemas = ["MaterialBindingAPI"]) {
            uniform token elementType = "face"
            uniform token familyName = "materialBind"
            int[] indices = [1]
            rel material:binding = </paint>
        }
    }"""
    )
    plain, red = load(text).meshes
    assert (plain.material.name, red.material.name) == ("default", "paint")
    assert red.vertices[red.faces[0]].tolist() == [[0, 0, 0], [1, 1, 0], [0, 1, 0]]
    with pytest.warns(pm.SceneWarning, match="materials of parts other than faces of 'half'"):
        (plain,) = load(text.replace('"face"', '"point"'), name="b.usda").meshes


def test_preview_surfaces(load):
    inputs = """color3f inputs:diffuseColor = (0.6, 0.4, 0)
        float inputs:metallic = 0.5
        float inputs:roughness = 0.3
        float inputs:ior = 1.5
        float inputs:opacity = 0.75
        token inputs:opacityMode = "presence"
        float inputs:clearcoat = 0.5
        float inputs:clearcoatRoughness = 0.125
        color3f inputs:emissiveColor = (1, 2, 3)"""
    material = load(painted(inputs)).meshes[0].material
    assert material.reflectance == pytest.approx((0.3, 0.2, 0.0))
    assert material.glossy == pytest.approx((0.32, 0.22, 0.02))
    assert (material.roughness, material.alpha) == pytest.approx((0.3, 0.75))
    assert (material.coat, material.coat_roughness) == (0.5, 0.125)
    assert material.emission == (1.0, 2.0, 3.0)


def test_specular_workflow_and_cutoff(load):
    inputs = """color3f inputs:diffuseColor = (0.5, 0.5, 0.5)
        int inputs:useSpecularWorkflow = 1
        color3f inputs:specularColor = (0.25, 0.5, 0.125)
        float inputs:opacity = 0.25
        float inputs:opacityThreshold = 0.5"""
    material = load(painted(inputs)).meshes[0].material
    assert material.glossy == (0.25, 0.5, 0.125)
    assert material.alpha == 0.0


def test_textures(load, tmp_path):
    write_png(np.array([[[255, 0, 0], [0, 64, 255]]], np.uint8), tmp_path / "wood.png")
    texture = """def Shader "image" {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./wood.png@
            float4 inputs:scale = (0.5, 1, 1, 1)
            float2 inputs:st.connect = </paint/place.outputs:result>
            token inputs:wrapS = "repeat"
            token inputs:wrapT = "repeat"
            float3 outputs:rgb
            float outputs:g
        }
        def Shader "place" {
            uniform token info:id = "UsdTransform2d"
            float2 inputs:scale = (2, 3)
            float2 inputs:translation = (0.25, 0)
            float2 inputs:in.connect = </paint/reader.outputs:result>
            float2 outputs:result
        }"""
    inputs = """color3f inputs:diffuseColor.connect = </paint/image.outputs:rgb>
        float inputs:roughness.connect = </paint/image.outputs:g>"""
    material = load(painted(inputs, texture + READER)).meshes[0].material
    color, roughness = material.reflectance, material.roughness
    assert (color.scale, color.offset, color.factor) == ((2, 3), (0.25, 0), (0.5, 1, 1))
    assert color.mean[0] == pytest.approx(0.25)
    assert roughness.mean[0] == pytest.approx(0.5 * decode_srgb(64 / 255), abs=1e-4)


def test_lights_that_have_a_size_are_meshes(load):
    text = light("RectLight", "float inputs:width = 2\nfloat inputs:height = 0.5\n"
                 "float inputs:intensity = 3\nfloat inputs:exposure = 1")  # fmt: skip
    lamp = next(mesh for mesh in load(text).meshes if mesh.name == "lamp")
    a, b, c = lamp.vertices[lamp.faces[0]]
    assert np.cross(b - a, c - a) == pytest.approx([0, 0, -1])
    assert np.ptp(lamp.vertices, axis=0) == pytest.approx([2, 0.5, 0])
    assert lamp.material.emission == (6.0, 6.0, 6.0)
    text = light("DiskLight", "float inputs:radius = 2\nbool inputs:normalize = 1")
    lamp = next(mesh for mesh in load(text, name="b.usda").meshes if mesh.name == "lamp")
    assert lamp.material.emission[0] == pytest.approx(1.0 / (4.0 * math.pi), rel=1e-3)


@pytest.mark.parametrize(
    ("kind", "more", "color"),
    [
        ("DistantLight", "bool inputs:normalize = 1\nfloat inputs:intensity = 5", 5.0),
        (
            "DistantLight",
            "float inputs:angle = 2\nfloat inputs:intensity = 5",
            5.0 * math.pi * math.sin(math.radians(1.0)) ** 2,
        ),
        ("SphereLight", "float inputs:radius = 0\nbool inputs:normalize = 1", 0.25),
        ("SphereLight", "float inputs:radius = 2\nbool treatAsPoint = 1", 4.0 * math.pi),
        ("DomeLight", "float inputs:intensity = 0.5", 0.5),
    ],
)
def test_suns_points_and_skies(load, kind, more, color):
    (found,) = load(light(kind, more)).lights
    assert found.color == pytest.approx((color,) * 3)
    if kind == "DistantLight":
        assert found.direction == pytest.approx((0, 0, -1))


def test_maps_of_skies_look_along_z(load, tmp_path):
    """As OpenEXR has it, +x lies to the left of the middle."""
    write_png(np.zeros((2, 4, 3), np.uint8), tmp_path / "sky.png")
    (sky,) = load(light("DomeLight", "asset inputs:texture:file = @sky.png@")).lights
    assert (sky.kind, sky.rotation) == ("environment", 180.0)


def test_packages_hold_their_textures(load, tmp_path):
    from pxr import UsdUtils

    write_png(np.full((2, 2, 3), 255, np.uint8), tmp_path / "wood.png")
    texture = """def Shader "image" {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./wood.png@
            float2 inputs:st.connect = </paint/reader.outputs:result>
            float3 outputs:rgb
        }"""
    inputs = "color3f inputs:diffuseColor.connect = </paint/image.outputs:rgb>"
    load(painted(inputs, texture + READER))
    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "a.usda"), str(tmp_path / "a.usdz"))
    (tmp_path / "wood.png").unlink()
    (mesh,) = pm.load_scene(tmp_path / "a.usdz").meshes
    assert mesh.material.reflectance.mean == pytest.approx((1.0, 1.0, 1.0))


def test_cones_of_points(load):
    more = "float inputs:radius = 0\nfloat inputs:shaping:cone:angle = 30\n"
    more += "float inputs:shaping:cone:softness = 0.5\nbool inputs:normalize = 1"
    with pytest.warns(pm.SceneWarning, match="falloff of soft cones"):
        (spot,) = load(light("SphereLight", more, 'prepend apiSchemas = ["ShapingAPI"]')).lights
    assert (spot.kind, spot.inner, spot.outer) == ("spot", 15.0, 30.0)
    assert spot.target == pytest.approx((0, 0, -1))


SHAPING = 'prepend apiSchemas = ["ShapingAPI"]'
POINT = "float inputs:radius = 0.5\nbool treatAsPoint = 1\nfloat inputs:intensity = 4\n"
FILE = POINT + "asset inputs:shaping:ies:file = @a.ies@\nfloat inputs:shaping:cone:angle = 180\n"


def intensity_along(light, direction):
    """Look the table of a light up: azimuths go from its own towards azimuth × axis."""
    axis, first = np.array(light.direction), np.array(light.azimuth)
    z = axis @ direction / np.linalg.norm(axis)
    side = np.cross(first, axis) / np.linalg.norm(first)
    x, y = first @ direction / np.linalg.norm(first), side @ direction / np.linalg.norm(axis)
    table = light.table / mean_over_directions(light.table)
    i = round(math.degrees(math.acos(min(max(z, -1.0), 1.0))))
    return light.intensity[0] * table[i, round(math.degrees(math.atan2(y, x))) % 360]


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_ies_files_of_points(load, tmp_path, mirror):
    """Polar angles begin at -z, azimuths at -x and go to -y, as in USD's hdEmbree."""
    across = [1.0, 0.5, 0.0, 0.0, 1.0]  # at azimuths of 0, 90, ...
    save_ies(np.array([[1.0], [2.0], [3.0]]) + across, tmp_path / "a.ies")
    turned = "float3 xformOp:rotateXYZ = (10, 20, 30)\n"
    turned += f"float3 xformOp:scale = ({2 * mirror}, 2, 2)\n"
    turned += 'uniform token[] xformOpOrder = ["xformOp:rotateXYZ", "xformOp:scale"]'
    (lamp,) = load(light("SphereLight", FILE + turned, SHAPING)).lights
    matrix = Rotation.from_euler("xyz", (10, 20, 30), degrees=True).as_matrix()
    for theta, phi in ((5, 0), (30, 0), (60, 90), (120, 45), (90, 270)):
        t, p = np.radians([theta, phi])
        local = [-np.sin(t) * np.cos(p), -np.sin(t) * np.sin(p), -np.cos(t)]
        expected = 4.0 * math.pi * (1.0 + theta / 90.0 + np.interp(phi, range(0, 361, 90), across))
        direction = matrix @ (local * np.array([mirror, 1.0, 1.0]))
        assert intensity_along(lamp, direction) == pytest.approx(expected, rel=1e-5)


def test_ies_files_are_scaled_normalised_cut_and_focused(load, tmp_path):
    save_ies([[3.0, 3.0], [1.0, 1.0]], tmp_path / "a.ies")
    whole = 4.0 * math.pi * 0.25  # of the radiance 4 and the radius 0.5

    def along(more, theta, name):
        (lamp,) = load(light("SphereLight", FILE + more, SHAPING), name=name).lights
        t = math.radians(theta)
        return intensity_along(lamp, [-math.sin(t), 0.0, -math.cos(t)]) / whole

    scaled = "float inputs:shaping:ies:angleScale = {}"
    assert along(scaled.format(0.5), 60, "b.usda") == pytest.approx(3.0 - 2.0 * 120 / 180)
    assert along(scaled.format(-0.5), 150, "c.usda") == pytest.approx(3.0 - 2.0 * 120 / 180)
    assert along(scaled.format(0.5), 95, "d.usda") == 0.0
    even = along("bool inputs:shaping:ies:normalize = 1", 90, "e.usda")
    assert even == pytest.approx(1.0 / (4.0 * math.pi), rel=1e-6)  # 2 is the mean of the file
    cone = "float inputs:shaping:cone:angle = 60\nfloat inputs:shaping:cone:softness = 0.5"
    found = [along(cone, theta, f"f{theta}.usda") for theta in (30, 40, 61)]
    step = (1 / 3) ** 2 * (3 - 2 / 3)
    assert found == pytest.approx([3.0 - 1 / 3, (3.0 - 4 / 9) * (1.0 - step), 0.0])
    focused = "float inputs:shaping:focus = 3\n"
    assert along(focused, 60, "g.usda") == pytest.approx((3.0 - 2 / 3) / 8.0)
    tinted = focused + "color3f inputs:shaping:focusTint = (0.5, 0.5, 0.5)"
    assert along(tinted, 60, "h.usda") == pytest.approx((3.0 - 2 / 3) * (0.5 + 0.5 / 8.0))


def test_what_ies_files_lose_is_named(load, tmp_path):
    with pytest.warns(pm.SceneWarning, match=r"an IES file \(.*a\.ies.*\) of 'lamp'"):
        (lamp,) = load(light("SphereLight", FILE, SHAPING)).lights
    assert lamp.kind == "point"
    save_ies(np.ones((3, 3)), tmp_path / "a.ies")
    uneven = 'float3 xformOp:scale = (1, 2, 1)\nuniform token[] xformOpOrder = ["xformOp:scale"]'
    with pytest.warns(pm.SceneWarning, match="uneven scale or shear of cones and IES files"):
        load(light("SphereLight", FILE + uneven, SHAPING), name="b.usda")


AP1_TO_SRGB = [
    [1.70505, -0.62179, -0.08326],
    [-0.13026, 1.14080, -0.01055],
    [-0.02400, -0.12897, 1.15297],
]
"""As the Academy's transforms have it, with Bradford's adaptation."""


def test_colours_in_the_space_of_prims_or_their_own(load):
    above = """def Xform "all" (prepend apiSchemas = ["ColorSpaceAPI"]) {
        uniform token colorSpace:name = "lin_ap1_scene"
        %s
    }
    """
    colors = 'color3f[] primvars:displayColor = [(0.5, 0.4, 0.3)] (interpolation = "constant")'
    lamp = 'def DistantLight "sun" {\nbool inputs:normalize = 1\nfloat inputs:intensity = 1\n'
    lamp += "color3f inputs:color = (5, 4, 3)%s\n}\n"
    scene = load(above % (triangle(colors) + lamp % "" + lamp.replace("sun", "plain")
                          % '(colorSpace = "lin_rec709_scene")'))  # fmt: skip
    expected = np.array(AP1_TO_SRGB) @ [0.5, 0.4, 0.3]
    np.testing.assert_allclose(scene.meshes[0].colors[0], expected, atol=1e-5)
    np.testing.assert_allclose(scene.lights[0].irradiance, 10.0 * expected, atol=1e-4)
    assert scene.lights[1].irradiance == (5.0, 4.0, 3.0)
    own = '(colorSpace = "srgb_rec709_scene")'
    inputs = f"color3f inputs:diffuseColor = (0.5, 0.5, 0.5) {own}"
    material = load(painted(inputs), name="b.usda").meshes[0].material
    assert material.reflectance == pytest.approx((0.2140411,) * 3)
    pure = colors.replace("(0.5, 0.4, 0.3)", "(0, 1, 0)")
    with pytest.warns(pm.SceneWarning, match="colours outside sRGB, which are clipped, of 'part'"):
        (mesh,) = load(above % triangle(pure), name="c.usda").meshes
    assert mesh.colors[0].tolist() == [0.0, 1.0, 0.0]


def test_spaces_of_textures_are_named(load, tmp_path):
    write_png(np.zeros((2, 2, 3), np.uint8), tmp_path / "wood.png")
    texture = """def Shader "image" {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./wood.png@ (colorSpace = "lin_ap1_scene")
            float2 inputs:st.connect = </paint/reader.outputs:result>
            float3 outputs:rgb
        }"""
    inputs = "color3f inputs:diffuseColor.connect = </paint/image.outputs:rgb>"
    with pytest.warns(pm.SceneWarning, match="colour space 'lin_ap1_scene' of textures"):
        load(painted(inputs, texture + READER))


LOCAL = {
    "Sphere": "double radius = 1", "Cube": "double size = 2", "Cone": "double radius = 1",
    "Cylinder": "double height = 2", "Capsule": "double radius = 1",
}  # fmt: skip


@settings(max_examples=30, deadline=None, derandomize=True,
          suppress_health_check=[HealthCheck.function_scoped_fixture])  # fmt: skip
@given(
    st.sampled_from([*LOCAL, "DiskLight", "RectLight"]),
    st.tuples(*[st.floats(-180.0, 180.0)] * 3),
    st.tuples(*[st.floats(0.5, 1.5) | st.floats(-1.5, -0.5)] * 3),
    st.floats(-0.5, 0.5),
    st.booleans(),
)
def test_outsides_stay_outside_under_any_transformation(load, kind, angles, scale, shear, is_left):
    """Of leftHanded shapes, insides; lights shine along what is -z of theirs."""
    sheared = np.diag(scale) + [[0.0, shear, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", angles, degrees=True).as_matrix() @ sheared
    rows = ", ".join(str(tuple(row)) for row in matrix.T.tolist())
    more = f"matrix4d xformOp:transform = ({rows})\n"
    more += 'uniform token[] xformOpOrder = ["xformOp:transform"]\n'
    if kind not in LOCAL:
        mesh = next(each for each in load(light(kind, more)).meshes if each.name == "lamp")
    else:
        more += (
            f'{LOCAL[kind]}\nuniform token orientation = "leftHanded"' if is_left else LOCAL[kind]
        )
        (mesh,) = load(f'def {kind} "s" {{\n{more}\n}}').meshes
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    crosses = np.cross(b - a, c - a)
    if kind not in LOCAL:
        assert (crosses @ np.linalg.inv(matrix[:3, :3])[2] < 0.0).all()
        return
    assert ((a * crosses).sum() > 0.0) != is_left
    if mesh.normals is not None:
        assert ((mesh.normals[mesh.faces].sum(axis=1) * crosses).sum(axis=1) > 0.0).all()


def test_cameras(load):
    camera = """def Camera "view" {
        float focalLength = 20
        float horizontalAperture = 36
        float verticalAperture = 24
        float fStop = 2
        float focusDistance = 5
    }\n"""
    scene = load(camera + triangle())
    assert scene.camera.fov == pytest.approx(2.0 * math.degrees(math.atan(0.6)))
    assert scene.camera.lens.opening == pytest.approx(0.5 * 2.0 / 2.0)
    shifted = camera.replace("float fStop = 2", "float horizontalApertureOffset = 9")
    found = load(shifted + triangle(), name="b.usda").camera.projection
    assert (found.cx / found.size[0], found.cy / found.size[1]) == pytest.approx((0.25, 0.5))


def test_what_is_not_simulated_is_named(load):
    text = triangle('uniform token subdivisionScheme = "catmullClark"').replace(
        'uniform token subdivisionScheme = "none"', "", 1
    )
    with pytest.warns(pm.SceneWarning, match="not simulated: subdivision of 'part'; Points of 'c'"):
        load(text + 'def Points "c" {}')


def test_hidden_prims_and_guides_are_left_out(load):
    hidden = triangle('token visibility = "invisible"', "a") + triangle(
        'uniform token purpose = "guide"', "b"
    )
    assert [mesh.name for mesh in load(hidden + triangle()).meshes] == ["part"]


def test_references_are_followed_within_the_folder(load, tmp_path):
    (tmp_path / "part.usda").write_text('#usda 1.0\n(defaultPrim = "part")\n' + triangle())
    (mesh,) = load('def "other" (references = @./part.usda@) {}').meshes
    assert mesh.name == "other"
    (tmp_path / "inside").mkdir()
    with pytest.raises(pm.InputError, match=r"'\.\./part\.usda' lies outside of the folder"):
        load('def "other" (references = @../part.usda@) {}', name="inside/b.usda")


def test_a_damaged_stage_is_refused(load, tmp_path, capfd):
    with pytest.raises(pm.InputError, match=r"a\.usda:\d: is not a USD stage") as refused:
        load('def Mesh "m" {{{')
    assert "\n" not in str(refused.value)
    broken = 'def Mesh "m" {\n  int[] faceVertexCounts = [3\n  float3[] extent = []\n}'
    with pytest.raises(pm.InputError, match=r"c\.usda:\d: .* damaged at 'float3\[\] extent"):
        load(broken, name="c.usda")
    unclosed = 'def Mesh "m" {\n  int[] faceVertexCounts = [3] }\n'
    with pytest.raises(pm.InputError, match=r"d\.usda:\d: .* damaged: Expected } at 'int\[\] face"):
        load(unclosed, name="d.usda")
    word = 'def Mesh "m" {\n  point3f[] points = [(0, 0, q)]\n}'
    with pytest.raises(
        pm.InputError, match=r"e\.usda:\d: .* parse .* at '\[\(0, 0, q\)\]'; export"
    ):
        load(word, name="e.usda")
    with pytest.raises(pm.InputError, match="its faces have 4 corners, but 3 are given"):
        load(triangle().replace("[3]", "[4]"), name="b.usda")
    assert capfd.readouterr().err == ""


def test_stages_with_changed_digits_are_read_or_refused_in_one_line(load):
    rng, text = random.Random(0), light("RectLight", "float inputs:intensity = 3.5")
    refused = []
    for index in range(40):
        damaged = [*text]
        for at in rng.sample([i for i, letter in enumerate(text) if letter.isdigit()], 2):
            damaged[at] = rng.choice("0123456789-.e(")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                load("".join(damaged), name=f"{index}.usda")
        except pm.InputError as error:
            refused.append(str(error))
    assert 0 < len(refused) < 40
    assert not [line for line in refused if "\n" in line or ".usda" not in line]


def test_without_pxr_the_remedy_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("photonmap.io.readers.usd.find_spec", lambda name: None)
    monkeypatch.setitem(sys.modules, "pxr", None)
    (tmp_path / "a.usda").write_text("#usda 1.0\n")
    with pytest.raises(pm.InputError, match=r"needs usd-core: pip install 'photonmap\[usd\]'"):
        pm.load_scene(tmp_path / "a.usda")
