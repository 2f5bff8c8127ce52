"""What a render needs, what is refused, and where its arrays lie."""

import mmap
import tempfile
from dataclasses import replace

import numpy as np
import pytest

from photonmap.errors import InputError
from photonmap.integrators.memory_estimate import Work
from photonmap.runtime import storage
from photonmap.runtime.options import read_memory
from photonmap.runtime.storage import RAM, Storage, check_memory

LEAST = Work(pixels=10, bands=1, photons=10, triangles=10)
LARGE = Work(8192 * 8192, 31, 100_000, 36)


def test_estimate_grows_with_everything():
    least = sum(LEAST.need)
    for bigger in ({"pixels": 10**7}, {"bands": 256, "photons": 10**6}, {"triangles": 10**7}):
        assert sum(replace(LEAST, **bigger).need) > least + 10**8
    for bigger in ({"specular": True}, {"per_light": True}):
        assert replace(LARGE, **bigger).need.always > LARGE.need.always
    assert (
        replace(LARGE, unbiased=True).need.arrays > LARGE.need.arrays + LARGE.pixels * 31 * 32 - 1
    )
    assert replace(LARGE, buffers=["radiance"]).need.arrays < 0.8 * LARGE.need.arrays


@pytest.fixture
def two_gigabytes(monkeypatch):
    class Free:
        available = 2.0e9

    monkeypatch.setattr("psutil.virtual_memory", lambda: Free)


@pytest.mark.usefixtures("two_gigabytes")
def test_refusal_names_both_numbers():
    assert check_memory(Work(256 * 256, 6, 100_000, 36).need) == RAM
    with pytest.raises(InputError, match=r"needs about \d+\.\d GB and 2\.0 GB are free.*memory="):
        check_memory(LARGE.need)


@pytest.mark.usefixtures("two_gigabytes")
@pytest.mark.parametrize("room", [1e9, 1e13])
def test_above_the_limit_the_disk_is_asked(monkeypatch, tmp_path, room):
    class Disk:
        free = room

    monkeypatch.setattr("shutil.disk_usage", lambda folder: Disk)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("photonmap.runtime.storage.is_in_ram", lambda folder: False)
    small = replace(LARGE, pixels=4096**2)
    assert check_memory(LEAST.need, limit=1e9) == RAM
    if room > 1e12:
        assert check_memory(small.need, limit=1e9).mapped
        with pytest.raises(InputError, match=r"GB of RAM and 2\.0 GB are free"):
            check_memory(LARGE.need, limit=1e9)
    else:
        with pytest.raises(InputError, match=f"GB in {tmp_path} and 1.0 GB are free"):
            check_memory(small.need, limit=1e9)


@pytest.mark.usefixtures("two_gigabytes")
def test_scratch_files_in_ram_count_as_ram(monkeypatch):
    monkeypatch.setattr("photonmap.runtime.storage.is_in_ram", lambda folder: True)
    with pytest.raises(InputError, match="GB of RAM"):
        check_memory(replace(LARGE, pixels=4096**2).need, limit=1e9)


def test_the_file_system_of_a_folder(monkeypatch, tmp_path):
    class Part:
        mountpoint, fstype = str(tmp_path), "tmpfs"

    monkeypatch.setattr("psutil.disk_partitions", lambda all: [Part])
    assert storage.is_in_ram(tmp_path)
    assert storage.is_in_ram(tmp_path / "below")
    assert not storage.is_in_ram(tmp_path.parent)


def test_mapped_arrays_are_plain_and_have_no_file(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    array = Storage(mapped=True).zeros((3, 4), np.float64)
    assert type(array) is np.ndarray
    assert isinstance(array.base, mmap.mmap)
    assert array.flags.carray
    assert not array.any()
    assert not list(tmp_path.iterdir())
    array += 1.0
    assert Storage(mapped=True).zeros((0, 4)).shape == (0, 4)


def test_no_folder_for_scratch_files(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none"))
    with pytest.raises(InputError, match="set TMPDIR to a folder on another disk"):
        Storage(mapped=True).zeros(5)


def test_amounts_of_memory():
    assert read_memory("4G") == 4 << 30
    assert read_memory("1.5m") == 1.5 * 2**20
    assert read_memory("1000") == 1000
    for text in ("", "G", "4 apples", "4GB"):
        with pytest.raises(InputError, match="write it as 4G or 512M"):
            read_memory(text)
