"""Shapes of Mitsuba as meshes: where transformations put them, their size, sides and uv."""

import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.mitsuba_files import serialized
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from photonmap.errors import InputError, SceneWarning

CORNER = np.array([1.0, 1.0, 1.0])
FIXTURE = [HealthCheck.function_scoped_fixture]


@pytest.fixture
def corner(load):
    """Return where a transformation puts the corner (1, 1, 1) of a cube; faces start there."""

    def corner(steps, **options):
        moved = f'<transform name="to_world">{steps}</transform>'
        mesh = load(f'<shape type="cube">{moved}</shape>', **options).meshes[0]
        plain = load('<shape type="cube"/>').meshes[0]
        at = np.flatnonzero((plain.vertices == CORNER).all(axis=1))[0]
        return mesh.vertices[at]

    return corner


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        ("", [1, 1, 1]),
        ('<translate x="1" z="-3"/>', [2, 1, -2]),
        ('<translate value="1, 2,3"/>', [2, 3, 4]),
        ('<scale x="2"/>', [2, 1, 1]),
        ('<scale value="3"/><translate y="1"/>', [3, 4, 3]),
        ('<translate y="1"/><scale value="3"/>', [3, 6, 3]),
        ('<rotate z="1" angle="90"/>', [-1, 1, 1]),
        ('<rotate x="1" angle="-90"/>', [1, 1, -1]),
        ('<matrix value="1 0 0 5 0 2 0 6 0 0 3 7 0 0 0 1"/>', [6, 8, 10]),
        ('<matrix value="0 1 0 2 0 0 0 0 3"/>', [1, 2, 3]),
        ('<lookat origin="1 2 3" target="1 2 9" up="0 1 0"/>', [2, 3, 4]),
        ('<lookat origin="0, 0, 0" target="5, 0, 0" up="0, 0, 1"/>', [1, 1, 1]),
        ('<lookat origin="0 0 0" target="0 -5 0" up="0 0 1"/>', [1, -1, 1]),
    ],
)
def test_steps(corner, steps, expected):
    np.testing.assert_allclose(corner(steps), expected, atol=1e-12)


def test_a_turn_about_any_axis(corner):
    axis = np.array([0.3, -0.5, 0.8])
    turn = Rotation.from_rotvec(np.radians(72.0) * axis / np.linalg.norm(axis))
    steps = '<rotate x=".3" y="-.5" z=".8" angle="72"/>'
    with pytest.warns(SceneWarning, match="<rotate> about an axis .* unit length of 'cube in line"):
        at = corner(steps)
    np.testing.assert_allclose(at, turn.apply(CORNER), atol=1e-12)
    np.testing.assert_allclose(corner(steps, version="0.6.0"), at)  # which normalises it


def test_a_view_without_up_is_a_turn(corner):
    at = corner('<lookat origin="0 0 0" target="1 2 -2"/>')
    assert np.linalg.norm(at) == pytest.approx(np.sqrt(3.0))
    assert at @ [1, 2, -2] == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        ('<shear x="1"/>', "<shear> is not a transformation; give translate, rotate"),
        ('<rotate angle="3"/>', "the axis of a rotation is 0"),
        ('<rotate x="1"/>', "<rotate> lacks angle"),
        ('<translate x="a"/>', "'a' is not a number"),
        ('<scale x="0"/>', "flattens everything"),
        ('<matrix value="1 2"/>', "a matrix has 2 numbers"),
        ('<matrix value="1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1"/>', "is not affine"),
        (3 * '<scale value="1e300"/>', "is not affine"),
        ('<lookat origin="0 0 1" target="0 0 0" up="0 0 1"/>', "up is parallel to the view"),
        ('<lookat origin="0 0 1" target="0 0 1"/>', "target and origin are the same"),
    ],
)
def test_steps_that_are_not_valid(corner, steps, message):
    with pytest.raises(InputError, match=f"scene.xml:1: .*{message}"):
        corner(steps)


MOVED = '<transform name="to_world"><scale x="2" y="3" z="4"/><translate x="5"/></transform>'
QUAD = (
    "v 0 0 0\nv 1 0 0\nv 1 1 .5\nv 0 1 0\nvt 0 .25\nvt 1 .25\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
)
PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
property float u
property float v
element face 1
property list uchar int vertex_indices
end_header
0 0 0 0 .25
1 0 0 1 .25
0 1 0 0 1
3 0 1 2
"""
BODY = trimesh.creation.box((1, 2, 3))


def crosses(mesh):
    """Return twice the vector areas of triangles."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def area(mesh):
    return 0.5 * np.linalg.norm(crosses(mesh), axis=1).sum()


def faces_along(mesh, outwards):
    """Check that triangles, and normals of vertices, face along the vectors at their places."""
    centers = mesh.vertices[mesh.faces].mean(axis=1)
    assert ((crosses(mesh) * outwards(centers)).sum(axis=1) > 0.0).all()
    if mesh.normals is not None:
        assert ((mesh.normals * outwards(mesh.vertices)).sum(axis=1) > 0.0).all()


def from_axis(points):
    return points * [1.0, 1.0, 0.0]


@pytest.mark.parametrize(
    ("kind", "true", "bound", "outwards"),
    [
        ("rectangle", 4.0, 1e-12, lambda at: at * 0.0 + [0.0, 0.0, 1.0]),
        ("cube", 24.0, 1e-12, lambda at: at),
        ("sphere", 4.0 * math.pi, 5.1e-4, lambda at: at),
        ("disk", math.pi, 3e-5, lambda at: at * 0.0 + [0.0, 0.0, 1.0]),
        ("cylinder", 2.0 * math.pi, 3e-5, from_axis),
    ],
)
def test_areas_and_sides(load, kind, true, bound, outwards):
    white = '<bsdf type="twosided"><bsdf type="diffuse"/></bsdf>'
    changes = (
        "",
        '<boolean name="flip_normals" value="true"/>',
        '<transform name="to_world"><scale x="-1"/></transform>',
    )
    plain, flipped, mirrored = load(
        "".join(f'<shape type="{kind}">{white}{change}</shape>' for change in changes)
    ).meshes
    for mesh in (plain, flipped, mirrored):
        assert true * (1.0 - bound) <= area(mesh) <= true * (1.0 + 1e-12)
        assert (np.linalg.norm(crosses(mesh), axis=1) > 0.0).all()
    faces_along(plain, outwards)
    faces_along(flipped, lambda at: -outwards(at))
    faces_along(mirrored, lambda at: -outwards(at) if kind == "sphere" else outwards(at))


PLATE = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"
FILES = {
    "bare.obj": PLATE + "f 1 2 3 4\n",
    "smooth.obj": PLATE + "vn 0 0 1\nf 1//1 2//1 3//1 4//1\n",
    "behind.obj": PLATE + "vn 0 0 -1\nf 1//1 2//1 3//1 4//1\n",
}


@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=FIXTURE)
@given(
    st.sampled_from(["rectangle", "disk", "sphere", "cube", "cylinder", *FILES]),
    st.tuples(*[st.floats(-180.0, 180.0)] * 3),
    st.tuples(*[st.floats(0.5, 1.5) | st.floats(-1.5, -0.5)] * 3),
    st.floats(-0.5, 0.5),
    st.booleans(),
    st.booleans(),
)
def test_the_side_that_emits(load, kind, angles, scale, shear, is_flipped, is_flat):
    """Along Mitsuba's normals, whatever the transformation: compared with 3.9 in 352 cases.

    Normals of vertices, and of shapes with formulas, are transformed as normals are; spheres are
    turned inside out by what mirrors, and so are faces without normals, which are wound anew.
    """
    sheared = np.diag(scale) + [[0.0, shear, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    matrix = Rotation.from_euler("xyz", angles, degrees=True).as_matrix() @ sheared
    steps = f'<matrix value="{" ".join(map(repr, matrix.ravel().tolist()))}"/>'
    file = f'<string name="filename" value="{kind}"/>' if kind in FILES else ""
    flags = f'<boolean name="flip_normals" value="{str(is_flipped).lower()}"/>'
    flags += '<boolean name="face_normals" value="true"/>' * (is_flat and kind in (*FILES, "cube"))
    (mesh,) = load(
        f'<shape type="{"obj" if file else kind}">{file}{flags}<transform name="to_world">{steps}'
        '</transform><emitter type="area"/></shape>',
        files=FILES,
    ).meshes
    local = {
        "sphere": lambda at: at,
        "cube": lambda at: at * (abs(at) > 0.9),
        "cylinder": from_axis,
    }
    outwards = local.get(kind, lambda at: at * 0.0 + [0.0, 0.0, 1.0])
    sign = -1.0 if is_flipped else 1.0
    if kind == "sphere" or kind == "bare.obj" or (kind in FILES and is_flat):
        sign *= np.sign(np.linalg.det(matrix))
    elif kind == "behind.obj":
        sign = -sign
    turned = np.linalg.inv(matrix)
    faces_along(mesh, lambda at: sign * outwards(at @ turned.T) @ turned)


def test_instances_keep_the_side_that_emits(load):
    mirror = '<transform name="to_world"><scale x="-1"/></transform>'
    bare = f'<shape type="obj"><string name="filename" value="bare.obj"/>{mirror}</shape>'
    (mesh,) = load(
        f'<shape type="shapegroup" id="g">{bare}</shape>'
        f'<shape type="instance"><ref id="g"/>{mirror}</shape>',
        files=FILES,
    ).meshes
    faces_along(mesh, lambda at: at * 0.0 - [0.0, 0.0, 1.0])


def test_a_moved_sphere(load):
    inside = '<point name="center" x="1" y="0" z="0"/><float name="radius" value=".5"/>'
    ball = load(f'<shape type="sphere" id="ball">{inside}{MOVED}</shape>').meshes[0]
    assert ball.name == "ball"
    local = (ball.vertices - [5.0, 0.0, 0.0]) / [2.0, 3.0, 4.0] - [1.0, 0.0, 0.0]
    np.testing.assert_allclose(np.linalg.norm(local, axis=1), 0.5, rtol=1e-12)
    gradient = local / [2.0, 3.0, 4.0]
    gradient /= np.linalg.norm(gradient, axis=1, keepdims=True)
    np.testing.assert_allclose(ball.normals, gradient, atol=1e-9)


def test_a_cylinder_between_points(load):
    inside = '<point name="p0" value="1 1 1"/><point name="p1" value="1 4 5"/>'
    tube = load(f'<shape type="cylinder">{inside}<float name="radius" value="2"/></shape>').meshes[
        0
    ]
    axis = np.array([0.0, 0.6, 0.8])
    along = (tube.vertices - 1.0) @ axis
    np.testing.assert_allclose(np.unique(np.round(along, 9)), [0.0, 5.0])
    away = tube.vertices - 1.0 - np.outer(along, axis)
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), 2.0)
    np.testing.assert_allclose(tube.normals, away / 2.0, atol=1e-9)
    assert area(tube) == pytest.approx(2.0 * math.pi * 2.0 * 5.0, rel=3e-5)


def uv_at(mesh, place):
    """Return the texture coordinates of the vertices at a place."""
    at = np.linalg.norm(mesh.vertices - place, axis=1) < 1e-9
    assert at.any()
    return mesh.uv[at]


def test_texture_coordinates(load):
    """Mitsuba's v runs downwards, ours upwards."""
    square, ball, plate, tube = load(
        "".join(f'<shape type="{kind}"/>' for kind in ("rectangle", "sphere", "disk", "cylinder"))
    ).meshes
    np.testing.assert_allclose(uv_at(square, [-1, -1, 0]), [[0, 1]])
    np.testing.assert_allclose(uv_at(square, [1, 1, 0]), [[1, 0]])
    np.testing.assert_allclose(uv_at(ball, [0, 1, 0]), [[0.25, 0.5]])
    assert (uv_at(ball, [0, 0, 1])[:, 1] == 1.0).all()
    np.testing.assert_allclose(uv_at(plate, [0, 1, 0]), [[1, 0.75]])
    np.testing.assert_allclose(uv_at(tube, [0, 1, 1]), [[0.25, 0]])


def test_an_obj_file(load):
    """All of it is one shape, whatever its materials; normals are computed, and v is as it is."""
    file = '<string name="filename" value="quad.obj"/>'
    flat = '<boolean name="face_normals" value="true"/>'
    smooth, hard, turned = load(
        f'<shape type="obj">{file}</shape><shape type="obj">{file}{flat}</shape>'
        f'<shape type="obj">{file}<boolean name="flip_tex_coords" value="false"/></shape>',
        files={"quad.obj": "mtllib none.mtl\nusemtl none\n" + QUAD},
    ).meshes
    assert hard.normals is None
    np.testing.assert_allclose(uv_at(smooth, [0, 0, 0]), [[0, 0.25]])
    np.testing.assert_allclose(uv_at(turned, [0, 0, 0]), [[0, 0.75]])
    sides = crosses(hard) / np.linalg.norm(crosses(hard), axis=1, keepdims=True)
    first = int(np.argmin(np.linalg.norm(smooth.vertices, axis=1)))
    angles = math.acos(2.0 / math.sqrt(4.5)), math.acos(2.0 / math.sqrt(4.5))
    expected = angles[0] * sides[0] + angles[1] * sides[1]
    np.testing.assert_allclose(
        smooth.normals[first], expected / np.linalg.norm(expected), atol=1e-9
    )


def test_a_file_that_many_shapes_name_is_read_once(load, monkeypatch):
    files, read, whole = {"a.obj": QUAD, "a.serialized": WHOLE}, [], Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read.append(path.name) or whole(path))
    shapes = [
        f'<shape type="{name[2:]}"><string name="filename" value="{name}"/></shape>'
        for name in files
    ]
    assert len(load("".join(shapes) * 3, files=files).meshes) == 6
    assert [name for name in read if name in files] == [*files]


def test_a_ply_file(load):
    file = '<string name="filename" value="a.ply"/>'
    plain, turned = load(
        f'<shape type="ply">{file}</shape>'
        f'<shape type="ply">{file}<boolean name="flip_tex_coords" value="true"/></shape>',
        files={"a.ply": PLY},
    ).meshes
    np.testing.assert_allclose(uv_at(plain, [0, 0, 0]), [[0, 0.75]])
    np.testing.assert_allclose(uv_at(turned, [0, 0, 0]), [[0, 0.25]])
    np.testing.assert_allclose(plain.normals, [[0, 0, 1]] * 3)


@pytest.mark.parametrize(("version", "double"), [(3, False), (4, False), (4, True)])
def test_a_serialized_file(load, version, double):
    other = trimesh.creation.icosphere(subdivisions=1)
    data = serialized([(BODY, BODY.vertices[:, :2]), (other, None)], version, double)
    shapes = "".join(
        '<shape type="serialized"><string name="filename" value="a.serialized"/>'
        f'<integer name="shape_index" value="{index}"/></shape>'
        for index in (0, 1)
    )
    box, ball = load(shapes, files={"a.serialized": data}).meshes
    np.testing.assert_allclose(box.vertices, BODY.vertices, rtol=1e-6)
    np.testing.assert_array_equal(box.faces, BODY.faces)
    np.testing.assert_allclose(box.uv, BODY.vertices[:, :2] * [1, -1] + [0, 1], rtol=1e-6)
    assert area(ball) == pytest.approx(other.area, rel=1e-6)


WHOLE = serialized([(BODY, None), (BODY, None)])


@pytest.mark.parametrize(
    ("data", "index", "message"),
    [
        (WHOLE, 2, "a.serialized: has 2 meshes, counted from 0, and not number 2"),
        (b"abc", 0, "a.serialized: is damaged"),
        (b"\x1c\x04\x09" + WHOLE[3:], 0, "is not a .serialized file of version 3 or 4"),
        (WHOLE[:60], 0, "is damaged: its meshes are not complete"),
        (WHOLE[:9] + b"zzzz" + WHOLE[13:], 0, "is damaged"),
        (WHOLE, 0.5, "shape_index 0.5 is not a whole number"),
    ],
)
def test_damaged_serialized_files(load, data, index, message):
    shape = (
        '<shape type="serialized"><string name="filename" value="a.serialized"/>'
        f'<integer name="shape_index" value="{index}"/></shape>'
    )
    with pytest.raises(InputError, match=message):
        load(shape, files={"a.serialized": data})


def test_a_serialized_file_that_announces_too_much(load):
    """It is refused before memory is set aside."""
    import struct
    import zlib

    packed = struct.pack("<I", 0x1000) + b"a\0" + struct.pack("<QQ", 1 << 60, 1 << 60)
    data = struct.pack("<HH", 0x041C, 4) + zlib.compress(packed + bytes(1 << 20))
    shape = '<shape type="serialized"><string name="filename" value="a.serialized"/></shape>'
    with pytest.raises(InputError, match="is damaged"):
        load(shape, files={"a.serialized": data})


def test_instances(load):
    scene = load(f"""<shape type="shapegroup" id="group"><shape type="cube" id="part">
<transform name="to_world"><translate y="1"/></transform></shape></shape>
<shape type="instance"><ref id="group"/>{MOVED}</shape>
<shape type="instance" id="again"><ref id="group"/></shape>""")
    first, second = scene.meshes
    assert (first.name, second.name) == ("instance", "again")
    np.testing.assert_allclose(first.vertices.min(axis=0), [3.0, 0.0, -4.0])
    np.testing.assert_allclose(second.vertices.max(axis=0), [1.0, 2.0, 1.0])


def test_lamps(load):
    red = '<bsdf type="diffuse" id="red"><rgb name="reflectance" value=".8 .1 .1"/></bsdf>'
    light = '<emitter type="area"><rgb name="radiance" value="1 2 3"/></emitter>'
    bare, painted, dark = load(
        f'{red}<shape type="sphere" id="bulb">{light}</shape>'
        f'<shape type="sphere"><ref id="red"/>{light}</shape>'
        '<shape type="cube"><ref id="red"/></shape>'
    ).meshes
    assert (bare.material.name, bare.material.reflectance) == ("bulb", 0.0)
    assert bare.material.emission == painted.material.emission == (1.0, 2.0, 3.0)
    assert painted.material.reflectance == dark.material.reflectance == (0.8, 0.1, 0.1)
    assert painted.material.name != dark.material.name == "red"
    assert dark.material.emission == 0.0


def test_backs_of_open_shapes(load):
    diffuse = '<bsdf type="diffuse"/>'
    load(f'<shape type="rectangle"><bsdf type="twosided">{diffuse}</bsdf></shape>')
    load(f'<shape type="cube">{diffuse}</shape>')
    with pytest.warns(SceneWarning, match="black backs of one-sided surfaces of 'wall'"):
        load(f'<shape type="rectangle" id="wall"><bsdf type="mask">{diffuse}</bsdf></shape>')


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ('"sphere"><float name="radius" value="0"/>', "radius 0 is not above 0"),
        ('"sphere"><float name="radius" value="inf"/>', "'inf' is not a number"),
        ('"sphere"><point name="center" value="1 2"/>', "value '1 2' is not one number or three"),
        ('"cylinder"><point name="p1" x="0" y="0" z="0"/>', "both ends of a cylinder"),
        ('"obj">', "shape 'obj' lacks filename"),
        ('"cube"><boolean name="flip_normals" value="2"/>', "neither true nor false"),
        ('"cube"><emitter type="point"/>', "an emitter of type 'point'; give area"),
        ('"instance">', "give it a <ref>"),
        (
            '"sphere"><float name="radius" value="1"/><float name="radius" value="2"/>',
            "shape has 2 of 'radius'; keep one of them",
        ),
        ('"cube"><bsdf type="diffuse"/><bsdf type="conductor"/>', "shape has 2 of 'bsdf'"),
        ('"cube"><emitter type="area"/><emitter type="area"/>', "shape has 2 of 'emitter'"),
    ],
)
def test_values_that_are_not_valid(load, shape, message):
    with pytest.raises(InputError, match=f"scene.xml:1: .*{message}"):
        load(f"<shape type={shape}</shape>")
