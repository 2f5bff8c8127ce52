"""Tables kept on disk: computed once for all processes, and anew where a file is of no use."""

import inspect

import numpy as np
import pytest

from photonmap.compile import table_cache
from photonmap.compile.surfaces.glossy import lobe_albedos
from photonmap.compile.table_cache import kept_on_disk
from photonmap.runtime import kept_tables


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(table_cache, "_folder", lambda: tmp_path / "tables")
    return tmp_path / "tables"


@pytest.fixture
def computed():
    return []


@pytest.fixture
def table(computed):
    """Return a function whose memory is that of a new process each time."""

    def squares(first, last=None):
        computed.append((first, last))
        return np.arange(first, 5.0) ** 2 / 3.0

    return lambda *numbers: kept_on_disk(squares)(*numbers)


def test_computed_once_for_all_processes(folder, table, computed):
    first, again = table(0.1), table(0.1)
    np.testing.assert_array_equal(first, again)
    assert computed == [(0.1, None)]
    assert len(list(folder.iterdir())) == 1


def test_each_value_has_a_table_of_its_own(folder, table, computed):
    for numbers in ((0.1,), (np.nextafter(0.1, 1.0).item(),), (0.1, 2.0), (0.1, None)):
        assert table(*numbers)[0] == numbers[0] ** 2 / 3.0
    assert len(computed) == len(list(folder.iterdir())) == 4


@pytest.mark.parametrize("left", [0, 40, 130])
def test_a_damaged_table_is_computed_anew(folder, table, computed, left):
    whole = table(0.1)
    [file] = folder.iterdir()
    file.write_bytes(file.read_bytes()[:left])
    np.testing.assert_array_equal(table(0.1), whole)
    np.testing.assert_array_equal(table(0.1), whole)
    assert len(computed) == 2


def test_no_folder_is_no_reason_to_stop(folder, table):
    folder.write_text("a file")
    assert table(1.0)[0] == pytest.approx(1.0 / 3.0)


def test_no_more_than_a_number_of_files(folder, table, monkeypatch):
    monkeypatch.setattr(kept_tables, "MOST", 2)
    for number in range(4):
        table(float(number))
    assert len(list(folder.iterdir())) == 2


def test_tables_from_disk_are_the_same_bits(folder):
    compute = inspect.unwrap(lobe_albedos)
    kept_on_disk(compute)(0.25)
    assert len(list(folder.iterdir())) == 1
    assert kept_on_disk(compute)(0.25).tobytes() == compute(0.25).tobytes()
