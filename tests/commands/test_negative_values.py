"""Values that begin with a minus sign need no `=`."""

import pytest

from photonmap.commands.main import _join_negative


@pytest.mark.parametrize(
    ("words", "joined"),
    [
        ("a.obj --origin -1,2,3 --size 8x8", "a.obj --origin=-1,2,3 --size 8x8"),
        ("a.obj --target -.5,0,0 --up -z", "a.obj --target=-.5,0,0 --up=-z"),
        ("a.obj --thumbnail -o b.exr --quiet", "a.obj --thumbnail -o b.exr --quiet"),
        ("a.obj --origin=-1,2,3 -1", "a.obj --origin=-1,2,3 -1"),
    ],
)
def test_values_are_joined_with_their_option(words, joined):
    assert _join_negative(words.split()) == joined.split()
