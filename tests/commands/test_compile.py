"""Kernels compiled ahead, for levels of processors."""

import sys

import llvmlite.binding as llvm
import pytest

from photonmap.commands import main as cli
from photonmap.compile import scene_arrays
from photonmap.kernels.core import code_cache


def test_levels_are_known_by_their_features():
    """Of 64-bit x86, each level has a name of LLVM's; a processor of the last decade has one."""
    here = llvm.get_process_triple().partition("-")[0]
    if here != "x86_64":
        pytest.skip(f"{here} has one level")
    known = llvm.get_host_cpu_features()
    for features in code_cache._LEVELS[here].values():
        assert set(features.split()) <= set(known)
    if known["avx2"]:
        assert code_cache.levels()[-1] == "x86-64-v3"


@pytest.mark.slow
def test_what_is_compiled_ahead_is_found(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    monkeypatch.setenv("PYTHONPATH", ":".join(sys.path))
    leanest = {"plain": scene_arrays.VARIANTS["plain"]}  # the others would take minutes
    monkeypatch.setattr(scene_arrays, "VARIANTS", leanest)
    assert cli.main(["compile", "--output", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == ["1/2", "2/2"]
    assert any((tmp_path / "code").glob("camera_pass*.nbc"))
