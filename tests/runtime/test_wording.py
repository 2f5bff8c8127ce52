"""Which name is suggested in place of one that is not known; who hears warnings, whose they are."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from photonmap.errors import SceneWarning, listening, naming_in_warnings, only_heard, warn
from photonmap.runtime.wording import shown, suggest

CAMERAS = ["CIE 1931 2 Degree Standard Observer", "Nikon 5100 (NPL)", "Sigma SDMerill (NPL)"]


@pytest.mark.parametrize(
    ("name", "known", "meant"),
    [
        ("studdy", ["dataset", "study"], "study"),
        ("GREEEN", ["red", "Green"], "Green"),
        ("D56", ["D50", "D55", "D65", "D75"], "D65"),  # rather two digits swapped than one wrong
        ("nikon", CAMERAS, "Nikon 5100 (NPL)"),
        ("nikkon", CAMERAS, "Nikon 5100 (NPL)"),
        ("sdmerrill", CAMERAS, "Sigma SDMerill (NPL)"),
    ],
)
def test_the_nearest_name(name, known, meant):
    assert suggest(name, known) == f"did you mean {meant!r}?"


def test_without_one_that_is_near():
    assert suggest("x", ["abc", "def"]) == "choose from 'abc', 'def'"
    assert suggest("x", []) == "correct the name"


def test_backslashes_stay_single():
    assert shown("C:\\art\n") == "'C:\\art\\n'"


def test_each_thread_hears_and_names_its_own_warnings():
    """As an image is written while the next one is rendered."""

    def write():
        with naming_in_warnings("one"), only_heard(), listening() as messages:
            warn("b")
        return messages

    def render():
        with naming_in_warnings("two"), listening() as messages, ThreadPoolExecutor(1) as pool:
            warn("a")
            assert pool.submit(write).result() == ["b"]
            warn("c")
        return messages

    with pytest.warns(SceneWarning) as issued:
        messages = render()
    assert messages == ["a", "c"]
    assert [str(each.message) for each in issued] == ["two: a", "two: c"]
