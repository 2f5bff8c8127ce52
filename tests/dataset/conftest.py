"""Images of these tests are small and noisy."""

import pytest

from photonmap.dataset.jobs import schedule


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
