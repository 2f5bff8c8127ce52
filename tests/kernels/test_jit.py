"""Kernels run without the JIT, and compile in few steps."""

import os
import pickle
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numba
import numpy as np
import pytest
from helpers.source import modules
from numba.core.itanium_mangler import mangle_type

from photonmap.kernels.core import linking
from photonmap.kernels.core.records import Materials

ROOT = Path(__file__).parents[2]

TINY = """
import numpy as np, photonmap as pm
room = pm.scenes.cornell_box()
room.lights.append(pm.PointLight((0.2, 0.1, 0.3), (1.0, 1.0, 1.0)))
for method in ("photon", "path"):
    for pixel in ("box", "center"):
        with np.errstate(over="ignore"):
            result = pm.render(room, bands="rgb", size=(4, 3), passes=2, photons=20, seed=4,
                               method=method, pixel=pixel, threads=1)
        print(" ".join(f"{v:.5e}" for v in result.radiance.ravel()))
"""


THEIRS = """
import numba
import numpy as np
from photonmap.kernels.core.jit import jit, kernel

@jit
def rounded(x, y):
    return np.round(x, 1) + y

@kernel
def ours(x, y):
    return rounded(x, y)

@numba.njit
def theirs(x, y):
    return np.round(x, 1) + y

print(ours(3.11, 1.0), theirs(7.0, 8.0))
"""


def run(code, cwd=ROOT, **environment):
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code],
        capture_output=True,
        text=True,
        cwd=cwd,
        env={**os.environ, **environment},
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_plain_python_gives_the_same_pictures():
    compiled = np.array(run(TINY).split(), float)
    plain = np.array(run(TINY, NUMBA_DISABLE_JIT="1").split(), float)
    np.testing.assert_allclose(plain, compiled, rtol=2e-4)


def test_numba_goes_on_in_anyones_code(tmp_path):
    """NumPy's functions, compiled as parts of a kernel, are linked into other functions too."""
    (tmp_path / "theirs.py").write_text(THEIRS)
    options = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": f"{tmp_path}:{ROOT}"}
    assert run("import theirs", tmp_path, **options).split() == ["4.1", "15.0"]


def test_kernels_take_fewer_steps_than_other_functions():
    """With this Numba: it would also work in full, in twice the time."""
    assert linking.IS_KNOWN


def test_types_of_records_are_the_same_in_every_process():
    """Their hash is not, which is kept, but not saved: the cache is found by types from a file."""
    box = numba.typeof(Materials(np.ones((2, 3), np.float32)))
    other = numba.typeof(Materials(np.ones((2, 3), np.float64)))
    code = "import pickle, sys; kind = pickle.load(sys.stdin.buffer); print({kind: 7}[kind], %s)"
    there = "hash(kind) == hash(kind.key)"
    hash(box)
    done = subprocess.run(
        [sys.executable, "-c", code % there],
        input=pickle.dumps(box),
        capture_output=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONHASHSEED": "1"},
        check=True,
    )
    assert done.stdout.split() == [b"7", b"True"]
    assert mangle_type(box) != mangle_type(other)
    assert len(mangle_type(box)) < 64


@pytest.mark.slow
def test_fewer_steps_give_the_same_bits(tmp_path):
    in_full = "from photonmap.kernels.core import linking; linking.IS_KNOWN = False\n"
    assert run(in_full + TINY, NUMBA_CACHE_DIR=str(tmp_path)) == run(TINY)


def test_the_package_calls_kernels_alone():
    """Functions that kernels link in would be compiled in every process that calls them."""
    rooms = (name for name in modules() if not name.startswith("photonmap.kernels"))
    for name in sorted({*rooms} - {"photonmap.__main__", "photonmap.dataset.files.torch_dataset"}):
        found = vars(import_module(name)).values()
        assert not [each for each in found if type(each).__name__ == "_Inner"], name
