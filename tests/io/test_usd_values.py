"""Values that USD stages state, against its specification and closed forms."""

import math
import struct
import zlib
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from helpers.usd_stages import READER, light, load_stage, painted, triangle
from hypothesis import given, settings
from hypothesis import strategies as st

import photonmap as pm
from photonmap.io.png import write_png
from photonmap.scene.images import Image, decode_srgb, write_image
from photonmap.scene.textures import Texture

CONNECTED = "color3f inputs:diffuseColor.connect = </paint/image.outputs:rgb>"
DECODED = float(decode_srgb(np.array(128 / 255)))
ROUGH = "float inputs:roughness.connect = </paint/image.outputs:{}>"


@pytest.fixture
def load(tmp_path):
    return partial(load_stage, tmp_path)


def image(more="", file="wood.png"):
    """A texture that lies on `st`, and its reader."""
    return f"""def Shader "image" {{
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./{file}@
            float2 inputs:st.connect = </paint/reader.outputs:result>
            float3 outputs:rgb
            float outputs:r
            float outputs:g
            float outputs:a
            {more}
        }}{READER}"""


def plain_png(texels, path):
    """Write an image that does not state its encoding."""
    height, width = texels.shape[:2]
    kind = 2 if texels.ndim == 3 else 0
    head = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    rows = b"".join(b"\0" + row.tobytes() for row in texels)
    parts = [(b"IHDR", head), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    chunks = [
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in parts
    ]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))


def ordered(*moves):
    """Transformations of a prim, as (kind, value)."""
    lines = [f"float3 xformOp:{kind} = {value}" for kind, value in moves]
    names = ", ".join(f'"xformOp:{kind}"' for kind, _ in moves)
    return "\n".join([*lines, f"uniform token[] xformOpOrder = [{names}]"])


@pytest.mark.parametrize("up", "YZ")
@pytest.mark.parametrize("kind", ["DomeLight", "DomeLight_1"])
@pytest.mark.parametrize("pole", ["", "scene", "Y", "Z"])
def test_poles_of_skies(load, tmp_path, up, kind, pole):
    """The top row of a map is its pole; the middle of `DomeLight_1` about z looks along -y."""
    sky = np.zeros((8, 16, 3), np.float32)
    sky[0], sky[3:5, 7:9, 2] = 1.0, 1.0
    write_image(sky, tmp_path / "sky.exr")
    more = f'uniform token poleAxis = "{pole}"' if pole and kind == "DomeLight_1" else ""
    text = light(kind, f"asset inputs:texture:file = @sky.exr@\n{more}")
    (found,) = load(text, f'upAxis = "{up}"').lights
    usual = up if kind == "DomeLight_1" and pole in ("", "scene") else pole or "Y"
    axis = "Y" if kind == "DomeLight" else usual
    row, column = np.unravel_index(np.argmax(found.image[..., 0]), found.image.shape[:2])
    is_up = axis == up
    assert (row == 0) == is_up
    if is_up:
        assert found.rotation == pytest.approx(180.0)  # the middle looks along +z of the scene
    assert column >= 0


def test_tinted_skies_and_other_formats(load, tmp_path):
    write_image(np.full((2, 4, 3), 0.5, np.float32), tmp_path / "sky.exr")
    file = "asset inputs:texture:file = @sky.exr@\n"
    (sky,) = load(light("DomeLight", file + "color3f inputs:color = (1, 2, 3)")).lights
    np.testing.assert_allclose(sky.scale * sky.image[0, 0], [0.5, 1.0, 1.5], rtol=1e-6)
    with pytest.raises(pm.InputError, match="format angular; convert it to latlong"):
        load(light("DomeLight", file + 'token inputs:texture:format = "angular"'), name="b.usda")


@pytest.mark.parametrize("scale", [0.1, 1.0, 3.0])
def test_points_below_a_scale(load, scale):
    """A sphere of radius r and radiance L has an intensity of L π r²."""
    ball = "float inputs:intensity = 1000\nfloat inputs:radius = 0.5\nbool treatAsPoint = 1\n"
    ball += ordered(("scale", (scale,) * 3))
    (point,) = load(light("SphereLight", ball)).lights
    assert point.intensity[0] == pytest.approx(1000.0 * math.pi * (0.5 * scale) ** 2, rel=1e-6)
    whole = light("SphereLight", ball + "\nbool inputs:normalize = 1")
    assert load(whole, name="b.usda").lights[0].intensity[0] == pytest.approx(250.0)


def test_suns_and_cylinders(load):
    wide = "float inputs:angle = 240\nfloat inputs:intensity = 1"
    with pytest.warns(pm.SceneWarning, match="angles of suns above 90 degrees of 'lamp'"):
        (sun,) = load(light("DistantLight", wide)).lights
    assert sun.irradiance[0] == pytest.approx(math.pi * (2.0 - math.sin(math.radians(120)) ** 2))
    (sun,) = load(light("DistantLight", "float inputs:angle = 2"), name="b.usda").lights
    assert sun.angle == 2.0
    tube = "float inputs:radius = 0.25\nfloat inputs:length = 4\nbool inputs:normalize = 1"
    lamp = next(m for m in load(light("CylinderLight", tube), name="c.usda").meshes
                if m.name == "lamp")  # fmt: skip
    assert np.ptp(lamp.vertices, axis=0) == pytest.approx([4.0, 0.5, 0.5])
    assert lamp.material.emission[0] == pytest.approx(1.0 / (2.0 * math.pi * 0.25 * 4.0), rel=1e-4)


@pytest.mark.parametrize(
    ("space", "shape", "value"),
    [
        ("raw", (2, 2, 3), 128 / 255),
        ("sRGB", (2, 2), DECODED),
        ("auto", (2, 2, 3), DECODED),
        ("auto", (2, 2), 128 / 255),
    ],
)
def test_encodings_of_textures(load, tmp_path, space, shape, value):
    plain_png(np.full(shape, 128, np.uint8), tmp_path / "wood.png")
    look = painted(CONNECTED, image(f'token inputs:sourceColorSpace = "{space}"'))
    material = load(look).meshes[0].material
    assert material.reflectance.mean == pytest.approx((value,) * 3, abs=1e-5)
    rough = load(painted(ROUGH.format("r"), image(f'token inputs:sourceColorSpace = "{space}"')),
                 name="b.usda").meshes[0].material  # fmt: skip
    assert rough.roughness == pytest.approx(value, abs=1e-5)


def test_scale_and_bias_of_numbers_and_colours(load, tmp_path):
    write_png(np.full((2, 2, 3), 128, np.uint8), tmp_path / "wood.png")
    raw = 'token inputs:sourceColorSpace = "raw"\n'
    half = raw + "float4 inputs:scale = (0.5, 0.5, 0.5, 0.5)\n"
    material = load(painted(ROUGH.format("g"), image(half))).meshes[0].material
    assert material.roughness == pytest.approx(0.5 * 128 / 255)
    both = half + "float4 inputs:bias = (0.1, 0.2, -1, 0)"
    with pytest.warns(pm.SceneWarning, match="values of textures below 0"):
        material = load(painted(CONNECTED, image(both)), name="b.usda").meshes[0].material
    value = 0.5 * 128 / 255
    assert material.reflectance.mean == pytest.approx((value + 0.1, value + 0.2, 0.0), abs=1e-6)


def test_channels_of_textures(load, tmp_path):
    rgba = np.array([[[64, 0, 0, 64], [192, 0, 0, 192]]], np.uint8)  # alpha has multiplied red
    write_image(rgba.astype(np.float32) / 255, tmp_path / "wood.exr", "RGBA")
    inputs = "float inputs:opacity.connect = </paint/image.outputs:a>\n" + ROUGH.format("r")
    inputs += '\ntoken inputs:opacityMode = "presence"'
    material = load(painted(inputs, image(file="wood.exr"))).meshes[0].material
    np.testing.assert_allclose(material.alpha.values[0, :, 0], [64 / 255, 192 / 255], atol=1e-6)
    assert material.roughness == 1.0
    cut = inputs + "\nfloat inputs:opacityThreshold = 0.5"
    material = load(painted(cut, image(file="wood.exr")), name="b.usda").meshes[0].material
    assert material.alpha.values.ravel().tolist() == [0.0, 1.0]


def test_normal_maps(load, tmp_path):
    write_png(np.full((2, 2, 3), (255, 64, 255), np.uint8), tmp_path / "wood.png")
    inputs = "normal3f inputs:normal.connect = </paint/image.outputs:rgb>"
    raw = 'token inputs:sourceColorSpace = "raw"\n'
    scaled = raw + "float4 inputs:scale = (2, {}, 2, 1)\nfloat4 inputs:bias = (-1, {}, -1, 0)"
    usual = load(painted(inputs, image(scaled.format(2, -1)))).meshes[0].material.relief.texture
    assert usual.values[0, 0].tolist() == [255, 64, 255]
    text = painted(inputs, image(scaled.format(-2, 1)))
    turned = load(text, name="b.usda").meshes[0].material.relief.texture
    np.testing.assert_allclose(turned.values[0, 0], [1.0, 1.0 - 64 / 255, 1.0], atol=1e-6)
    with pytest.warns(pm.SceneWarning, match="sRGB of normal maps.*without scale and bias"):
        load(painted(inputs, image()), name="c.usda")


COORDINATES = """texCoord2f[] primvars:st = [(0, 0), (1, 0), (0, 1)] (interpolation = "vertex")
    texCoord2f[] primvars:st1 = [(0, 0.5), (0.5, 0), (2, 3)] (interpolation = "vertex")
    rel material:binding = </paint>"""


def looked_up(load, tmp_path, more, reader="st", place="", name="a.usda"):
    """Return the mesh with a texture that lies on named coordinates."""
    write_png(np.array([[[0, 0, 0], [255, 255, 255]]], np.uint8), tmp_path / "wood.png")
    inside = image(more).replace('varname = "st"', f'varname = "{reader}"') + place
    if place:
        inside = inside.replace("reader.outputs:result", "place.outputs:result", 1)
    text = painted(CONNECTED, inside).split("def Mesh")[0] + triangle(COORDINATES)
    return load(text, name=name).meshes[0]


def test_the_coordinates_that_a_reader_names(load, tmp_path):
    assert looked_up(load, tmp_path, "").uv.tolist() == [[0, 0], [1, 0], [0, 1]]
    second = looked_up(load, tmp_path, "", "st1", name="b.usda")
    assert second.uv.tolist() == [[0, 0.5], [0.5, 0], [2, 3]]
    with pytest.warns(pm.SceneWarning, match="texture coordinates 'st9', which are missing"):
        looked_up(load, tmp_path, "", "st9", name="c.usda")


def test_udim_tiles(load, tmp_path):
    """1001 at u and v of 0 to 1, 1002 to its right, 1011 above; at (1, 1) there is none."""
    for number, value in ((1001, 51), (1002, 102), (1011, 255)):
        write_png(np.full((4, 2, 3), value, np.uint8), tmp_path / f"wood.{number}.png")
    raw = 'token inputs:sourceColorSpace = "raw"'
    far = COORDINATES.replace("(0, 1)]", "(3, 3)]")
    text = painted(CONNECTED, image(raw, "wood.<UDIM>.png")).split("def Mesh")[0] + triangle(far)
    texture = load(text).meshes[0].material.reflectance
    places = [(0.5, 0.5), (1.5, 0.5), (0.5, 1.5), (1.5, 1.5), (2.5, 0.5)]
    values = [value_at(texture, u, v) for u, v in places]
    assert values == pytest.approx([0.2, 0.4, 1.0, 0.0, 0.0], abs=1e-6)
    write_png(np.zeros((2, 2, 3), np.uint8), tmp_path / "wood.1003.png")
    with pytest.raises(pm.InputError, match="has tiles of different sizes or types; make them"):
        load(text, name="b.usda")
    with pytest.raises(pm.InputError, match=r"'oak\.<UDIM>\.png' has no tiles; correct its name"):
        load(text.replace("wood.<", "oak.<"), name="c.usda")


def test_coordinates_are_scaled_rotated_and_moved(load, tmp_path):
    place = """
        def Shader "place" {
            uniform token info:id = "UsdTransform2d"
            float2 inputs:in.connect = </paint/reader.outputs:result>
            float2 inputs:scale = (2, 3)
            float inputs:rotation = 90
            float2 inputs:translation = (0.25, 0.5)
            float2 outputs:result
        }"""
    wrap = 'token inputs:wrapS = "repeat"\ntoken inputs:wrapT = "repeat"'
    mesh = looked_up(load, tmp_path, wrap, place=place)
    np.testing.assert_allclose(mesh.uv, [[0.25, 0.5], [0.25, 2.5], [-2.75, 0.5]], atol=1e-12)
    texture = mesh.material.reflectance
    assert (texture.scale, texture.offset) == ((1.0, 1.0), (0.0, 0.0))


def value_at(texture, u, v):
    """Look a texture up bilinearly at one place."""
    texels = texture.image.linear(slice(None), slice(None))[..., 0]
    place = np.array([u, v]) * texture.scale + texture.offset
    at = (
        np.array([1.0 - place[1], place[0]])
        if texture.clamps[1]
        else np.array([-place[1], place[0]])
    )
    at = at * texels.shape - 0.5
    low = np.floor(at).astype(int)
    weight, total = at - low, 0.0
    for row, column in np.ndindex(2, 2):
        index = low + (row, column)
        for axis, is_clamped in enumerate(texture.clamps[::-1]):
            size = texels.shape[axis]
            index[axis] = np.clip(index[axis], 0, size - 1) if is_clamped else index[axis] % size
        part = np.where((row, column), weight, 1.0 - weight).prod()
        total += part * texels[tuple(index)]
    return total * texture.factor[0]


WRAPS = ("black", "clamp", "repeat", "mirror")


def reference(texels, modes, u, v):
    """Return the texel of whose centre there are coordinates; 0 for black."""
    rows, columns = texels.shape
    found = []
    for place, size, mode in ((u, columns, modes[0]), (v, rows, modes[1])):
        index = math.floor(place * size)
        tile, inside = divmod(index, size)
        if mode == "black" and tile:
            return 0.0
        if mode == "clamp":
            inside = min(max(index, 0), size - 1)
        found.append(size - 1 - inside if mode == "mirror" and tile % 2 else inside)
    return texels[rows - 1 - found[1], found[0]]


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(WRAPS), st.sampled_from(WRAPS), st.integers(1, 4), st.integers(1, 4),
    st.integers(-9, 9), st.integers(-9, 9), st.integers(0, 1000),
)  # fmt: skip
def test_wrap_modes_of_each_direction(across, up, columns, rows, i, j, seed):
    """At the centres of texels, of whatever copy, interpolation does not matter."""
    from photonmap.io.readers.usd.materials import wrapped

    texels = np.random.default_rng(seed).random((rows, columns), np.float32)
    u, v = (i + 0.5) / columns, (j + 0.5) / rows
    modes, low, high = (across, up), np.full(2, -10.0), np.full(2, 10.0)
    texture = wrapped(Texture(Image(texels[..., None], False)), modes, low, high)
    assert value_at(texture, u, v) == pytest.approx(reference(texels, modes, u, v), abs=1e-5)


def test_wrap_modes_of_stages(load, tmp_path):
    """Without any, a texture is black beyond the unit square; within, its edges are kept."""
    wrap = 'token inputs:wrapS = "{}"\ntoken inputs:wrapT = "{}"'
    texture = looked_up(load, tmp_path, wrap.format("mirror", "clamp"), "st1").material.reflectance
    assert texture.clamps == (False, True)
    assert texture.scale == (0.5, 1.0)
    black = looked_up(load, tmp_path, "", "st1", name="b.usda").material.reflectance
    assert [value_at(black, u, 0.5) for u in (0.75, 1.25, 2.0)] == pytest.approx(
        [1, 0, 0], abs=1e-5
    )
    within = looked_up(load, tmp_path, "", name="c.usda").material.reflectance
    assert within.image.texels.shape == (1, 2, 3)
    assert within.clamp is True


SHAPES = {
    "Cylinder": ("double height = 3\ndouble radius = 0.5", 2 * math.pi * 0.5 * 3.5, math.pi * 0.75),
    "Cone": ("double height = 4\ndouble radius = 3", math.pi * 3 * 8, math.pi * 12),
    "Capsule": ("double height = 2\ndouble radius = 1", 8 * math.pi, (2 + 4 / 3) * math.pi),
    "Cylinder_1": (
        "double height = 4\ndouble radiusTop = 1\ndouble radiusBottom = 4",
        math.pi * (1 + 16 + 5 * 5), math.pi * 4 / 3 * 21,
    ),
    "Capsule_1": (  # the larger sphere alone, which holds the other
        "double height = 1\ndouble radiusTop = 1\ndouble radiusBottom = 4",
        64 * math.pi, 256 / 3 * math.pi,
    ),
}  # fmt: skip


@pytest.mark.parametrize("axis", "XYZ")
@pytest.mark.parametrize("kind", SHAPES)
def test_areas_and_volumes_of_shapes(load, kind, axis):
    more, area, volume = SHAPES[kind]
    (mesh,) = load(f'def {kind} "s" {{\n{more}\nuniform token axis = "{axis}"\n}}').meshes
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    crosses = np.cross(b - a, c - a)
    assert 0.5 * np.linalg.norm(crosses, axis=1).sum() == pytest.approx(area, rel=2e-3)
    assert (a * crosses).sum() / 6.0 == pytest.approx(volume, rel=4e-3)  # faces look outwards
    assert ((mesh.normals[mesh.faces].sum(axis=1) * crosses).sum(axis=1) > 0.0).all()
    along = "XYZ".index(axis)
    if kind == "Cone":
        assert mesh.vertices[np.argmax(mesh.vertices[:, along])] == pytest.approx(
            2 * np.eye(3)[along]
        )


@pytest.mark.parametrize(
    ("more", "said"),
    [("double radius = -1", "s: its radius is -1"), ("double radius = 0", "s: it has no area")],
)
def test_shapes_without_size(load, more, said):
    with pytest.raises(pm.InputError, match=said):
        load(f'def Cylinder "s" {{\n{more}\n}}\n' + triangle())


@pytest.mark.parametrize(("axis", "sizes"), [("X", (0, 5, 3)), ("Y", (3, 0, 5)), ("Z", (3, 5, 0))])
def test_planes(load, axis, sizes):
    text = (
        f'def Plane "s" {{\ndouble width = 3\ndouble length = 5\nuniform token axis = "{axis}"\n}}'
    )
    (mesh,) = load(text).meshes
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx(sizes)
    a, b, c = mesh.vertices[mesh.faces[0]]
    assert np.cross(b - a, c - a)["XYZ".index(axis)] > 0.0


INSTANCER = """def PointInstancer "crowd" {{
    rel prototypes = [</crowd/all/part>]
    int[] protoIndices = [{0}]
    point3f[] positions = [{1}]
    {2}
    over "all" {{
        {3}
    }}
}}"""


def test_point_instancers(load):
    """Scale, then rotation, then position, then the instancer; prototypes are not drawn."""
    more = "float3[] scales = [(2, 2, 2), (1, 1, 1), (1, 1, 1)]\n"
    more += "quath[] orientations = [(1, 0, 0, 0), (0.70710677, 0, 0, 0.70710677), (1, 0, 0, 0)]\n"
    more += "int64[] invisibleIds = [2]\n" + ordered(("translate", (0, 0, 5)))
    text = INSTANCER.format("0, 0, 0", "(1, 0, 0), (0, 1, 0), (9, 9, 9)", more, triangle())
    first, second = load(text).meshes
    assert (first.name, second.name) == ("part", "part_2")
    np.testing.assert_allclose(first.vertices, [[1, 0, 5], [3, 0, 5], [1, 2, 5]], atol=1e-3)
    np.testing.assert_allclose(second.vertices, [[0, 1, 5], [0, 2, 5], [-1, 1, 5]], atol=1e-3)


@pytest.mark.parametrize(
    ("indices", "positions", "said"),
    [
        ("0, 3", "(0, 0, 0), (0, 0, 0)", "shows prototype 3, but there are 1"),
        ("0, 0", "(0, 0, 0)", "has 1 positions for 2 instances"),
    ],
)
def test_instancers_whose_lists_do_not_fit(load, indices, positions, said):
    with pytest.raises(pm.InputError, match=said):
        load(INSTANCER.format(indices, positions, "", triangle()))


def test_instancers_of_themselves(load):
    inner = 'def PointInstancer "part" {\nrel prototypes = [</crowd/all/part>]\n'
    inner += "int[] protoIndices = [0]\npoint3f[] positions = [(0, 0, 0)]\n}"
    with pytest.raises(pm.InputError, match="is an instance of itself"):
        load(INSTANCER.format("0", "(0, 0, 0)", "", inner))


def clipped(folder):
    return f"""def Mesh "m" (
    clips = {{
        dictionary default = {{
            string templateAssetPath = "{folder}clip.#.usda"
            double templateStartTime = 1
            double templateEndTime = 1
            double templateStride = 1
            string primPath = "/m"
        }}
    }}
) {{
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points
    uniform token subdivisionScheme = "none"
}}
"""


CLIP = """#usda 1.0
def Mesh "m" {
    point3f[] points.timeSamples = {1: [(0, 0, 0), (2, 0, 0), (0, 2, 0)]}
}
"""
FRAMES = "\nstartTimeCode = 1\nendTimeCode = 1\n"


def test_value_clips_are_read_within_the_folder(load, tmp_path):
    (tmp_path / "clip.1.usda").write_text(CLIP)
    (mesh,) = load(clipped("./"), FRAMES).meshes
    assert mesh.vertices.max() == 2.0


@pytest.mark.parametrize(
    "text",
    [
        clipped("../"),
        clipped("../").replace('string templateAssetPath = "../clip.#.usda"',
                               "asset[] assetPaths = [@../clip.1.usda@]\n"
                               "double2[] active = [(1, 0)]\ndouble2[] times = [(1, 1)]"),
        'def "x" (references = @../part.usda@) {}',
        'def "x" (payload = @../part.usda@) {}',
        'def "x" (variants = {string v = "a"}\nprepend variantSets = "v") {\n'
        'variantSet "v" = {"a" (references = @../part.usda@) {}}\n}',
        'def "x" (references = @`"../part.usda"`@) {}',
        painted(CONNECTED, image(file="../wood.png")),
        painted(CONNECTED, image(file="../wood.<UDIM>.png")),
        painted(CONNECTED, image(file="../pack.usdz[wood.png]")),
        light("DomeLight", "asset inputs:texture:file = @../wood.png@"),
        light("SphereLight", "bool treatAsPoint = 1\nasset inputs:shaping:ies:file = @../a.ies@",
              'prepend apiSchemas = ["ShapingAPI"]'),
    ],
)  # fmt: skip
def test_nothing_outside_of_the_folder_is_opened(load, tmp_path, text):
    (tmp_path / "inside").mkdir()
    (tmp_path / "clip.1.usda").write_text(CLIP)
    (tmp_path / "part.usda").write_text('#usda 1.0\n(defaultPrim = "part")\n' + triangle())
    write_png(np.zeros((2, 4, 3), np.uint8), tmp_path / "wood.png")
    said = "lies outside of the folder|is an expression|UDIM"
    with pytest.raises(pm.InputError, match=said):
        load(f"{text}\n{triangle(name='more')}", FRAMES, "inside/a.usda")


def test_the_working_folder_is_not_searched(load, tmp_path, monkeypatch):
    """As USD does for names that do not begin with ./."""
    (tmp_path / "inside").mkdir()
    (tmp_path / "part.usda").write_text('#usda 1.0\n(defaultPrim = "part")\n' + triangle())
    monkeypatch.chdir(tmp_path)
    with pytest.raises(pm.InputError, match=r"'part\.usda' lies outside of the folder"):
        load('def "x" (references = @part.usda@) {}\n' + triangle(), name="inside/a.usda")
    Path("part.usda").unlink()
    with pytest.warns(pm.SceneWarning, match=r"'part\.usda', which does not exist"):
        load('def "x" (references = @part.usda@) {}\n' + triangle(), name="inside/a.usda")


def test_what_cannot_be_composed_is_named(load):
    with pytest.warns(pm.SceneWarning, match="what USD cannot compose of 'x'"):
        load('def "x" (references = </nothing>) {}\n' + triangle())
    assert len(load('def "x" (references = </part>) {}\n' + triangle()).meshes) == 2


def test_files_that_change_are_read_again(load):
    assert load(triangle()).meshes[0].vertices.max() == 1.0
    assert load(triangle().replace("(1, 0, 0)", "(7, 0, 0)")).meshes[0].vertices.max() == 7.0


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("rel light:filters = </part>", "filters of lights"),
        ("bool collection:lightLink:includeRoot = 0", "lights that light some surfaces only"),
        ("bool inputs:shadow:enable = 0", "shadow:enable of lights"),
        ("float inputs:shaping:focus = 2", "shaping:focus of lights"),
        ("asset inputs:shaping:ies:file = @a.ies@", "shaping:ies:file of lights"),
        ("bool treatAsLine = 1", "treatAsLine of lights"),
        ("float inputs:intensity.timeSamples = {1: 1, 2: 3}", "animation of 'lamp'"),
        ("float inputs:specular = 0.5", "multipliers of lights that differ"),
    ],
)
def test_what_lights_have_that_is_not_simulated_is_named(load, more, said):
    with pytest.warns(pm.SceneWarning, match=said):
        load(light("RectLight", more, 'prepend apiSchemas = ["ShadowAPI"]'))


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("float exposure = 1", "exposure of cameras of 'view'"),
        ("float4[] clippingPlanes = [(0, 0, 1, 0)]", "clipping planes of 'view'"),
        ("double shutter:close = 0.5", "motion blur of 'view'"),
        (ordered(("scale", (2, 2, 2))), "scale or mirroring of cameras of 'view'"),
        (ordered(("translate", (0.1, 0.1, 5))) + "\nfloat2 clippingRange = (6, 9)",
         "the clipping range of cameras of 'view'"),
    ],
)  # fmt: skip
def test_what_cameras_have_that_is_not_simulated_is_named(load, more, said):
    with pytest.warns(pm.SceneWarning, match=said):
        load(f'def Camera "view" {{\n{more}\n}}\n' + triangle())


@pytest.mark.parametrize(
    ("inputs", "said"),
    [
        ("float inputs:opacity = 0.5", "what a transparent surface reflects"),
        ("float inputs:displacement = 0.5", "displacement"),
        ('color3f inputs:diffuseColor = (0, 0, 0) (colorSpace = "odd")', "space 'odd', which"),
        ("float inputs:roughness.connect = </paint/odd.outputs:result>", "what feeds roughness"),
    ],
)
def test_what_materials_have_that_is_not_simulated_is_named(load, inputs, said):
    odd = 'def Shader "odd" {\nuniform token info:id = "Odd"\nfloat outputs:result\n}'
    with pytest.warns(pm.SceneWarning, match=said):
        load(painted(inputs, odd))


def test_colours_that_a_reader_names_holes_and_inherited_colours(load):
    colors = 'def Shader "image" {\nuniform token info:id = "UsdPrimvarReader_float3"\n'
    colors += 'string inputs:varname = "dye"\nfloat3 outputs:result\n}'
    connected = "color3f inputs:diffuseColor.connect = </paint/image.outputs:result>"
    dye = "color3f[] primvars:dye = [(0.1, 0.2, 0.3), (0, 0, 0), (1, 1, 1)] "
    dye += '(interpolation = "vertex")\nrel material:binding = </paint>'
    text = painted(connected, colors).split("def Mesh")[0] + triangle(dye)
    np.testing.assert_allclose(load(text).meshes[0].colors[0], [0.1, 0.2, 0.3], atol=1e-6)
    above = 'def Xform "x" {\ncolor3f[] primvars:displayColor = [(0.5, 0, 0)] '
    above += '(interpolation = "constant")\n' + triangle() + 'def Cone "c" {}\n}'
    for mesh in load(above, name="b.usda").meshes:
        assert mesh.colors[0].tolist() == [0.5, 0.0, 0.0]
    holes = triangle("int[] holeIndices = [1]", "m").replace("[3]", "[3, 3]")
    holes = holes.replace("[0, 1, 2]", "[0, 1, 2, 0, 1, 2]")
    assert len(load(holes, name="c.usda").meshes[0].faces) == 1
