"""OFF files: the worked example of a reader."""

import numpy as np
import pytest
import trimesh

from photonmap.errors import InputError, SceneWarning
from photonmap.io.readers.registry import ReadOptions, find_reader, read_file
from photonmap.io.readers.scene_file import load_scene
from photonmap.scene.material import Material

SQUARE = "4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"


@pytest.fixture
def read(tmp_path):
    """Write a file and read its one mesh."""

    def read(data, name="a.off"):
        (tmp_path / name).write_bytes(data if isinstance(data, bytes) else data.encode())
        (mesh,) = read_file(tmp_path / name).meshes
        return mesh

    return read


def area(mesh):
    """The vector area of a mesh, (3,)."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return np.cross(b - a, c - a).sum(axis=0) / 2


@pytest.mark.parametrize(
    "text",
    [
        "OFF\n" + SQUARE,
        "OFF " + SQUARE,
        "\ufeffOFF # text\r\n# more\r\n\r\n" + SQUARE.replace("\n", "\r\n"),
        "OFF\n" + SQUARE.replace("4 1 0", "4 1"),
    ],
)
def test_a_square(read, text):
    mesh = read(text)
    assert (mesh.name, mesh.material) == ("a", Material("default"))
    assert mesh.faces.shape == (2, 3)
    np.testing.assert_array_equal(area(mesh), [0, 0, 1])


def test_a_concave_polygon_and_unused_vertices(read):
    mesh = read("OFF\n6 1 0\n9 9 9\n0 0 0\n2 0 0\n2 2 0\n1 0.5 0\n0 2 0\n5 1 2 3 4 5\n")
    assert len(mesh.vertices) == 5
    np.testing.assert_allclose(area(mesh), [0, 0, 2.5])


def test_what_trimesh_exports(read):
    shape = trimesh.creation.icosphere(2)
    mesh = read(shape.export(file_type="off", digits=17))
    np.testing.assert_array_equal(mesh.vertices, shape.vertices)
    np.testing.assert_array_equal(mesh.faces, shape.faces)


def test_faces_without_area_are_counted(read):
    with pytest.warns(SceneWarning, match=r"a\.off: not simulated: 1 faces without area$"):
        read("OFF\n" + SQUARE.replace("4 1 0", "4 2 0") + "4 0 1 1 0\n")


def test_edges_and_points_are_counted(read):
    text = "OFF\n" + SQUARE.replace("4 1 0", "4 4 0") + "2 0 1 9 9 9\n0\n1 3\n"
    message = r"a\.off: not simulated: 3 faces of fewer than three corners$"
    with pytest.warns(SceneWarning, match=message):
        mesh = read(text)
    assert mesh.colors.tolist() == [[[0.5] * 3]] * 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", ": is empty"),
        ("# nothing\n", ": does not begin with OFF or COFF"),
        ("\nSTOFF\n" + SQUARE, ":2: does not begin with OFF or COFF; export it as one of them"),
        ("OFF BINARY\n" + SQUARE, ":1: 'BINARY' is not a line of counts; write those of vertices"),
        ("OFF\n", ": ends after its header; export it again"),
        ("OFF\n4 -1 0\n", ":2: '4 -1 0' is not a line of counts"),
        ("OFF\n" + SQUARE[:-10], ": is truncated: it announces 4 vertices and 1 faces"),
        ("OFF\n" + SQUARE + "# end\n3 0 1 2\n", ":9: '3 0 1 2' follows the last face; correct"),
        ("OFF\n" + SQUARE.replace("1 1 0", "1 x 0"), ":5: '1 x 0' is not a vertex; write three"),
        ("OFF\n" + SQUARE.replace("1 1 0", "1 nan 0"), ":5: '1 nan 0' is not a vertex"),
        ("OFF\n" + SQUARE.replace("1 1 0", "1 1e31 0"), r":5: .* finite numbers up to 1e\+30"),
        ("OFF\n" + SQUARE.replace("1 1 0", "1 1"), ":5: '1 1' is not a vertex"),
        ("OFF\n" + SQUARE.replace("4 0 1 2 3", "-2 0 1"), ":7: '-2 0 1' is not a face; write 3"),
        ("OFF\n" + SQUARE.replace("4 0 1 2 3", "2 0 1"), ": has no triangles; export"),
        ("OFF\n" + SQUARE.replace("4 0 1 2 3", "4 0 1 2"), ":7: '4 0 1 2' is not a face"),
        ("OFF\n" + SQUARE.replace("2 3", "2 4"), ":7: .* do not exist; number them 0 to 3"),
        ("OFF\n" + SQUARE.replace("2 3", "2 -3"), ":7: .* do not exist; number them 0 to 3"),
        ("OFF\n4 0 0\n" + SQUARE[6:-10], ": has no triangles; export"),
    ],
)
def test_errors_name_file_line_value_and_remedy(read, text, message):
    with pytest.raises(InputError, match=r"a\.off" + message) as caught:
        read(text)
    assert "\n" not in str(caught.value)


def test_it_is_found_by_its_suffix_alone(read, tmp_path):
    read("OFF\n" + SQUARE, "room.OFF")
    assert find_reader(tmp_path / "room.OFF").__module__.endswith(".off")
    (tmp_path / "room.toml").write_text('mesh = "room.OFF"\n[material.default]\nmirror = 0.25\n')
    scene = load_scene(tmp_path / "room.toml")
    assert scene.name == "room"
    assert scene.meshes[0].material == Material("default", mirror=0.25)
    assert find_reader(tmp_path / "room.OFF")(tmp_path / "room.OFF", ReadOptions()).name == "room"
