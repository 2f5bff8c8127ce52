"""Data sets that several files of tests share."""

import pytest
from helpers.layered_sets import write_set

from photonmap.evaluate import intervals


@pytest.fixture(scope="session")
def known(tmp_path_factory):
    """The folder of a data set of three scenes in two lights, and its layers by name."""
    folder = tmp_path_factory.mktemp("sets") / "known"
    folder.mkdir()
    return folder, write_set(folder)


@pytest.fixture(autouse=True, scope="module")
def few_resamples(request):
    """Let a tenth of the usual samples of scenes make an interval, but where that is tested."""
    with pytest.MonkeyPatch.context() as patch:
        if request.path.stem != "test_intervals":
            patch.setattr(intervals, "RESAMPLES", 199)
        yield
