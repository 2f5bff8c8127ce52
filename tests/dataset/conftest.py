"""Images of these tests are small and noisy."""

import sys
from importlib import import_module

import pytest

from photonmap.dataset.jobs import schedule

PASSES = 8


@pytest.fixture(autouse=True, scope="module")
def few_passes():
    """Let renders stop at their error after half as many passes as else, which take most time."""
    import_module("photonmap.dataset.jobs.render_image")  # with the number that others have
    ours = [module for name, module in sys.modules.items() if name.startswith("photonmap.")]
    with pytest.MonkeyPatch.context() as patch:
        for module in ours:
            if "LEAST_PASSES" in vars(module):
                patch.setattr(module, "LEAST_PASSES", PASSES)
        yield


@pytest.fixture
def workers_in_threads(monkeypatch):
    """Let workers be threads of this process: each of their own would start Python for seconds."""
    distributed = pytest.importorskip("distributed")

    def start(workers):
        return distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=False, dashboard_address=":0"
        )

    monkeypatch.setattr(schedule, "start_local_cluster", start)
    return start
