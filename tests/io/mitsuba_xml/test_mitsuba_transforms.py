"""Transformations of Mitsuba, by what they make of points."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from photonmap.errors import InputError

CORNER = np.array([1.0, 1.0, 1.0])


@pytest.fixture
def corner(load):
    """Return where a transformation puts the corner (1, 1, 1) of a cube; faces start there."""

    def corner(steps):
        mesh = load(
            f'<shape type="cube"><transform name="to_world">{steps}</transform></shape>'
        ).meshes[0]
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
        ('<rotate x="7" angle="-90"/>', [1, 1, -1]),
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
    np.testing.assert_allclose(corner(steps), turn.apply(CORNER), atol=1e-12)


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
