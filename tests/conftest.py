"""Fixtures shared by the tests, and how tests are shared out to processes that run at once."""

import fcntl
import gc
import importlib
import os
import sys
from contextlib import nullcontext, redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path

# Beside other processes, threads of BLAS mostly wait for each other, and use a core each meanwhile.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from helpers.scenes import closed_box

import photonmap as pm
from photonmap.commands.main import main

# What is imported and collected stays: to look for garbage in it takes a tenth of all time.
gc.disable()

FIRST = ("golden", "study", "render", "hard")
"""Folders of tests that begin"""


def pytest_collection_modifyitems(items):
    """Golden images first: they compile most kernels; then the files that take longest."""
    order = {folder: number for number, folder in enumerate(FIRST)}
    items.sort(key=lambda item: order.get(item.path.parent.name, len(FIRST)))


def pytest_collection_finish():
    """Leave the thousands of tests, and what they import, out of collections of garbage."""
    gc.freeze()
    gc.enable()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Give files to processes whole, so that a module's fixtures are made once; but golden images
    one by one."""
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            folder, _, name = nodeid.partition("::")[0].rpartition("/")
            if folder.endswith("golden"):
                return nodeid
            shared = folder == "tests" or folder.endswith(("study", "dataset/scenes"))
            return folder if shared else name

    config.option.loadscopereorder = False  # by size: golden images came last
    return ByFile(config, log)


@pytest.fixture(scope="session", autouse=True)
def each_kernel_compiled_once():
    """Let a process wait while another compiles the same kernels, and compile its own alone.

    Both cores have work as it is: helpers of each process would start Python and compile the
    functions that kernels share once more.
    """
    if "PYTEST_XDIST_WORKER" not in os.environ:
        yield
        return
    from photonmap.integrators import kernel_warmup

    render = importlib.import_module("photonmap.render")
    compile_kernels = render.compile_kernels

    def wait_and_compile(wanted, bands, workers, method):
        folder = kernel_warmup.CODE_FOLDER
        folder.mkdir(parents=True, exist_ok=True)
        with (folder / kernel_warmup._mark(wanted, method, "lock")).open("a") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            return compile_kernels(wanted, bands, workers, method)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(render, "compile_kernels", wait_and_compile)
        patch.setattr(kernel_warmup, "_aside", lambda *arguments: nullcontext())
        yield


@pytest.fixture(scope="session", autouse=True)
def inner_functions_compiled_once():
    """Keep the code of kernels' inner functions, which tests alone call from Python, in files."""
    jit = sys.modules.get("photonmap.kernels.core.jit")
    if jit is None:
        yield
        return
    wrap = jit._wrapped

    @cache
    def wrap_and_keep(function):
        wrapped = wrap(function)
        wrapped._cache = jit.KernelCache(function.py_func)
        return wrapped

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(jit, "_wrapped", wrap_and_keep)
        yield


FEW_PILOTS = ("bsdf", "camera", "compile", "film", "glass", "hard", "integrators", "render")
"""Folders of tests whose scenes are small, and of which no other test holds the bits"""


@pytest.fixture(scope="module", autouse=True)
def few_pilots(request):
    """Let a quarter of the usual photons look for specular surfaces, before the passes."""
    with pytest.MonkeyPatch.context() as patch:
        if request.path.parent.name in FEW_PILOTS:
            from photonmap.integrators.photon_mapping import caustics

            patch.setattr(caustics, "PILOT", caustics.PILOT // 4)
        yield


@pytest.fixture(scope="session")
def cornell():
    """The Cornell box."""
    return pm.scenes.cornell_box()


@pytest.fixture
def empty_cornell(cornell):
    """The Cornell box without the two blocks: convex, so all that is not lamp sees the lamp."""
    meshes = [mesh for mesh in cornell.meshes if not mesh.name.endswith("_box")]
    return pm.Scene(meshes, camera=cornell.camera, name="empty Cornell box")


@pytest.fixture
def point_cornell(cornell):
    """The Cornell box with a point light for a lamp."""
    meshes = [mesh for mesh in cornell.meshes if mesh.name != "light"]
    light = pm.PointLight((0.0, 0.5, 0.0), (1.0, 0.8, 0.6))
    return pm.Scene(meshes, [light], cornell.camera, "Cornell box with a point light")


@pytest.fixture
def furnace():
    """Make a closed box that emits and reflects, seen from inside."""

    def make(reflectance, emission=1.0):
        material = pm.Material("wall", reflectance, emission)
        camera = pm.Camera((0.3, 0.2, 0.8), (-0.2, -0.1, -1.0), fov=70.0)
        return pm.Scene([closed_box(material)], camera=camera, name="furnace")

    return make


@pytest.fixture(scope="session")
def study_folder(tmp_path_factory):
    """A quick study of the Cornell box, by the real command."""
    folder = tmp_path_factory.mktemp("study") / "box"
    scene = str(Path(pm.scenes.FOLDER) / "cornell_box.obj")
    quick = ["--quick", "--minutes", "0.003", "--size", "16x16", "--output", str(folder)]
    with (
        (folder.parent / "stdout").open("w") as out,
        (folder.parent / "stderr").open("w") as err,
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        assert main(["study", scene, *quick]) == 0
    return folder
