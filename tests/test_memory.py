import pytest

from photonmap.errors import InputError
from photonmap.memory import check_memory, estimate_memory


def test_estimate_grows_with_everything():
    least = estimate_memory(10, 1, 10, 10)
    for bigger in ((10**7, 1, 10, 10), (10, 256, 10**6, 10), (10, 1, 10, 10**7)):
        assert estimate_memory(*bigger) > least + 10**8


def test_refusal_names_both_numbers(monkeypatch):
    class Free:
        available = 2.0e9

    monkeypatch.setattr("psutil.virtual_memory", lambda: Free)
    check_memory(256 * 256, 6, 100_000, 36)
    with pytest.raises(InputError, match=r"needs about \d+\.\d GB and 2\.0 GB are free"):
        check_memory(8192 * 8192, 31, 100_000, 36)
