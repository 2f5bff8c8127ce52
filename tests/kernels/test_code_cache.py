"""Machine code is found again where nothing that it reaches was edited, and where it is whole."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from photonmap.kernels.core import code_cache

ROOT = Path(__file__).parents[2]
CALLER = """
import math
from photonmap.kernels.core import warp
from photonmap.kernels.core.jit import kernel

@kernel
def pdf_times_pi():
    return warp.cosine_hemisphere_pdf(1.0) * math.pi
"""
CALLS = """
import json, os, resource, sys
from contextlib import redirect_stderr
from io import StringIO
import numba
from numba.core.registry import cpu_target
from numba.np import arraymath, linalg, npyimpl, polynomial, random

cpu_target.typing_context.refresh()

for line in sys.stdin:
    folder, environment = json.loads(line)
    if child := os.fork():
        if os.waitpid(child, 0)[1]:
            sys.exit("the call failed")
        continue
    os.environ.update(environment)
    numba.config.reload_config()
    cpu_target.target_context.init()  # of the processor that is named
    if limit := environment.get("FILE_LIMIT"):
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(limit), int(limit)))
    os.chdir(folder)
    sys.path.insert(0, folder)
    with redirect_stderr(StringIO()) as messages:
        from caller import pdf_times_pi
        value = pdf_times_pi()
    found = sum(pdf_times_pi.stats.cache_hits.values()) == 1
    print(json.dumps([value, found, messages.getvalue()]), flush=True)
    os._exit(0)
"""
"""Calls the kernel of each folder that it reads in a process of its own, into which Numba was
imported before, with all that compiling needs."""


@pytest.fixture(scope="module")
def call():
    """Call the kernel in a process of its own; return its value, whether it was found, messages."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    with subprocess.Popen(
        [sys.executable, "-c", CALLS],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=kept,
    ) as process:

        def answer(checkout, **environment):
            places = {"NUMBA_CACHE_DIR": str(checkout / "cache"), **environment}
            print(json.dumps([str(checkout), places]), file=process.stdin, flush=True)
            return tuple(json.loads(process.stdout.readline()))

        yield answer
        process.stdin.close()


@pytest.fixture(scope="module")
def compiled(call, tmp_path_factory):
    """A checkout of kernels whose caller was compiled."""
    folder = tmp_path_factory.mktemp("compiled") / "checkout"
    ignored = shutil.ignore_patterns("__pycache__", "compiled")
    shutil.copytree(ROOT / "kernels", folder / "kernels", ignore=ignored)
    (folder / "photonmap").mkdir()
    for name in ("__init__.py", "version.py"):
        shutil.copy(ROOT / "photonmap" / name, folder / "photonmap")
    (folder / "caller.py").write_text(CALLER)
    assert call(folder) == (1.0, False, "")
    return folder


@pytest.fixture
def checkout(compiled, tmp_path):
    return shutil.copytree(compiled, tmp_path / "checkout")


def edit(source, before, after):
    text = source.read_text()
    assert before in text
    source.write_text(text.replace(before, after))


def test_edits_are_noticed_where_they_matter(call, checkout):
    """Numba itself would keep a caller's old code where its callee was edited (numba #1833)."""
    edit(checkout / "kernels" / "film" / "moments.py", "import math\n", "import math\n\n")
    assert call(checkout) == (1.0, True, "")
    edit(checkout / "kernels/core/warp.py", "INV_PI = 1.0 / math.pi", "INV_PI = 2.0 / math.pi")
    assert call(checkout) == (2.0, False, "")


def test_code_comes_with_the_package(call, checkout):
    shutil.move(checkout / "cache" / "code", checkout / "kernels" / "compiled")
    assert call(checkout) == (1.0, True, "")
    assert not (checkout / "cache" / "code").exists()


def test_damaged_files_are_written_anew(call, checkout):
    for suffix in ("nbi", "nbc"):
        (file,) = (checkout / "cache" / "code").glob(f"caller*.{suffix}")
        file.write_bytes(file.read_bytes()[:-1] + b"?")
        value, found, messages = call(checkout)
        assert (value, found) == (1.0, False)
        assert messages.count("are damaged and will be made anew") == 1
    assert call(checkout) == (1.0, True, "")


def test_kernels_stay_in_memory_where_no_file_takes_them(call, checkout):
    """One warning says so, nothing is left behind, and once there is room they are kept."""
    folder = checkout / "cache" / "code"
    shutil.rmtree(folder)
    for limit in ("100", "5000"):  # bytes: too few for the index, and for the code
        value, found, messages = call(checkout, FILE_LIMIT=limit)
        assert (value, found) == (1.0, False)
        assert messages.count("cannot be kept in") == 1
        assert not list(folder.glob("*.tmp.*")) + list(folder.glob("*.nbc"))
    assert call(checkout) == (1.0, False, "")
    assert call(checkout) == (1.0, True, "")
    (checkout / "file").touch()
    value, found, messages = call(checkout, NUMBA_CACHE_DIR=str(checkout / "file" / "cache"))
    assert (value, found) == (1.0, False)
    assert messages.count("set NUMBA_CACHE_DIR to another folder") == 1


def test_processors_have_code_of_their_own_or_of_their_level(call, checkout):
    options = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    assert call(checkout, **options) == (1.0, False, "")
    if not code_cache.levels():
        pytest.skip("this processor has no level that is known")
    shutil.rmtree(checkout / "cache")
    options["NUMBA_CPU_NAME"] = code_cache.levels()[-1]
    assert call(checkout, **options) == (1.0, False, "")
    assert call(checkout) == (1.0, True, "")


PICTURE = (
    "import hashlib, photonmap as pm;"
    "r = pm.render(pm.scenes.cornell_box(), bands=2, size=(8, 8), passes=2, photons=500, seed=1);"
    "print(hashlib.sha256(b''.join(a.tobytes() for a in r.buffers.values())).hexdigest())"
)


@pytest.mark.slow
def test_bits_are_the_same_on_all_processors():
    """Nothing is contracted or reordered."""
    pictures = [
        subprocess.run(
            [sys.executable, "-W", "ignore", "-c", PICTURE],
            capture_output=True,
            text=True,
            cwd=ROOT,
            env={**os.environ, **options},
            check=True,
        ).stdout
        for options in (
            {},
            {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""},
            {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": ""},
        )
    ]
    assert len(set(pictures)) == 1
