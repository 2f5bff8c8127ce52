"""Normals by `s` lines of OBJ files."""

import itertools

import numpy as np
import pytest

CORNERS = list(itertools.product((-1, 1), repeat=3))
FACES = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
VERTICES = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)


def cube(*groups):
    """Return a cube whose faces have these `s` lines, as text."""
    faces = (f"{group}f {face}\n" for group, face in zip(groups, FACES, strict=True))
    return VERTICES + "".join(faces)


def normals(mesh):
    """Return the unit normals of corners by the vertex they stand at, each once."""
    found = {}
    for at, normal in zip(mesh.vertices.tolist(), mesh.unit_normals.tolist(), strict=True):
        found.setdefault(tuple(at), set()).add(tuple(np.round(normal, 12)))
    return found


@pytest.mark.parametrize("group", ["1", "2", "Body"])
def test_a_smoothed_cube_has_its_diagonals(read_obj, group):
    (mesh,) = read_obj(cube(f"s {group}\n", *[""] * 5))
    assert len(mesh.vertices) == 8
    np.testing.assert_allclose(mesh.unit_normals, mesh.vertices / np.sqrt(3.0), atol=1e-14)


def test_angles_weigh_so_that_the_division_into_triangles_does_not_matter(read_obj):
    divided = cube(*[""] * 6)
    for face in FACES:
        a, b, c, d = face.split()
        divided = divided.replace(f"f {face}\n", f"f {a} {b} {c}\nf {a} {c} {d}\n")
    (mesh,) = read_obj(divided.replace("f ", "s 1\nf ", 1))
    np.testing.assert_allclose(mesh.unit_normals, mesh.vertices / np.sqrt(3.0), atol=1e-14)


@pytest.mark.parametrize("off", ["s off\n", "s 0\n", "s Off\n", "s\n", ""])
def test_without_a_group_faces_are_flat(read_obj, off):
    (mesh,) = read_obj(cube(off, *[""] * 5))
    assert mesh.normals is None
    (mesh,) = read_obj(cube("s 1\n", off or "s off\n", *[""] * 4))
    assert np.count_nonzero(mesh.normals.any(axis=1)) == 4


def test_groups_meet_at_an_edge(read_obj):
    """Two rings of two faces each: at a vertex each group has the mean of its own faces."""
    (mesh,) = read_obj(cube("s 1\n", "s 2\n", "s 1\n", "s 2\n", "s off\n", ""))
    half = np.round(np.sqrt(0.5), 12)
    assert normals(mesh)[-1.0, -1.0, -1.0] == {(-half, -half, 0.0), (0.0, 0.0, 0.0)}
    assert normals(mesh)[-1.0, 1.0, -1.0] == {(-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)}


def test_normals_of_the_file_are_kept(read_obj):
    text = cube("s 1\n", *[""] * 5).replace("f 1 2 4 3", "f 1//1 2//1 4//1 3//1")
    (mesh,) = read_obj(text.replace("s 1", "vn 0 0 1\ns 1"))
    assert (0.0, 0.0, 1.0) in normals(mesh)[-1.0, -1.0, -1.0]
    half = np.round(np.sqrt(0.5), 12)
    assert (0.0, -half, -half) in normals(mesh)[-1.0, -1.0, -1.0]
