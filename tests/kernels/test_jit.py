"""Kernels run without the JIT, and an edit anywhere among them is noticed."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

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


CALLER = """
import math
from photonmap.kernels.core import warp
from photonmap.kernels.core.jit import kernel

@kernel
def pdf_times_pi():
    return warp.cosine_hemisphere_pdf(1.0) * math.pi
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


@pytest.fixture
def checkout(tmp_path):
    for name in ("photonmap", "kernels", "scenes"):
        shutil.copytree(
            ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__", "*.nb?")
        )
    return tmp_path


def test_an_edit_of_a_callee_is_noticed(checkout):
    """Numba itself would keep the caller's old machine code (numba #1833)."""
    (checkout / "caller.py").write_text(CALLER)
    code = (
        "import caller; from photonmap.kernels.core import jit;"
        "print(any(jit.CACHE_FOLDER.rglob('*.nbi')), caller.pdf_times_pi())"
    )
    options = {"NUMBA_CACHE_DIR": str(checkout / "cache"), "PYTHONPATH": str(checkout)}
    assert run(code, checkout, **options).split() == ["False", "1.0"]
    assert run(code, checkout, **options).split() == ["True", "1.0"]
    source = checkout / "kernels" / "core" / "warp.py"
    source.write_text(
        source.read_text().replace("INV_PI = 1.0 / math.pi", "INV_PI = 2.0 / math.pi")
    )
    assert run(code, checkout, **options).split() == ["False", "2.0"]


@pytest.mark.slow
def test_a_fresh_cache_gives_the_same_bits(tmp_path):
    code = (
        "import hashlib, photonmap as pm;"
        "r = pm.render(pm.scenes.cornell_box(), bands=2, size=(8, 8), passes=2, photons=500);"
        "print(hashlib.sha256(b''.join(a.tobytes() for a in r.buffers.values())).hexdigest())"
    )
    assert run(code, NUMBA_CACHE_DIR=str(tmp_path)) == run(code)
