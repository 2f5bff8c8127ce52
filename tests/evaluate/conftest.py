"""Data sets that several files of tests share."""

import pytest
from helpers.layered_sets import write_set


@pytest.fixture(scope="session")
def known(tmp_path_factory):
    """The folder of a data set of three scenes in two lights, and its layers by name."""
    folder = tmp_path_factory.mktemp("sets") / "known"
    folder.mkdir()
    return folder, write_set(folder)
