"""Images of these tests are small and noisy."""

from importlib import import_module

import pytest

from photonmap.dataset.jobs import schedule

PASSES = 8
HOLDERS = (
    "film.budget", "film.forecast", "integrators.render_loop", "integrators.pass_samples",
    "integrators.path_truncation", "dataset.jobs.render_image",
)  # fmt: skip
"""All modules that have the least number of passes; imported before it changes, not while it is
another."""


@pytest.fixture(autouse=True, scope="module")
def few_passes():
    """Let renders stop at their error after half as many passes as else, which take most time."""
    modules = [import_module(f"photonmap.{name}") for name in HOLDERS]
    with pytest.MonkeyPatch.context() as patch:
        for module in modules:
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
