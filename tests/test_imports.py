"""Imports go one way: down the layers of the package, and down those of the kernels."""

import subprocess
import sys

import numpy as np
import pytest
from helpers.source import imported_modules, imports, modules
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

LAYERS = [
    {"__main__"},
    {"commands"},
    {"evaluate"},
    {"dataset", "inspection", "study", "sensors", "viewer"},
    {"render_illuminations"},
    {"capture", "render", "report"},
    {"settings"},
    {"results"},
    {"integrators"},
    {"film"},
    {"compile"},
    {"io"},
    {"scene"},
    {"spectra"},
    {"buffers"},
    {"runtime"},
    {"errors", "version"},
]
"""Rooms of photonmap; what a room imports stands further down, or in the room itself."""
KERNEL_LAYERS = [
    {"integrators"},
    {"caustics"},
    {"cache"},
    {"film"},
    {"camera"},
    {"lights"},
    {"bsdf"},
    {"geometry"},
    {"core"},
]
KERNEL_USERS = {"compile", "film", "integrators", "render", "results.record", "settings"}
"""Rooms and modules that may import kernels."""
KERNEL_FOUNDATION = {"numpy", "numba", "llvmlite", "embreex", "platformdirs"}
"""What kernels may import beside the standard library."""
DATA = {"data", "scenes"}
"""Packages of files, which any module may read."""
KERNELS = "photonmap.kernels"
KERNEL_CONSTANTS = {"photonmap.kernels.core.color", "photonmap.kernels.core.metals"}
"""Hold constants alone; any module may import them."""
INSIDE = sorted(set(modules()) - {"photonmap"})


def layer_of(room, layers):
    """Return the number of a room's layer, counted from the top."""
    found = [number for number, layer in enumerate(layers) if room in layer]
    assert found, f"{room} belongs to no layer: give it its place in tests/test_imports.py"
    return found[0]


def room_of(module, package):
    """Return the room of a module within a package; "" for the package itself."""
    return module.removeprefix(package).strip(".").partition(".")[0]


def edges(inside, package):
    """Yield pairs of rooms that differ, with the modules of which one imports the other."""
    for module in sorted(modules()):
        for target in sorted(imported_modules(module)):
            if inside(module) and inside(target):
                above, below = room_of(module, package), room_of(target, package)
                if above != below and above and below:
                    yield module, target, above, below


def test_rooms_import_downwards():
    def is_layered(module):
        return room_of(module, "photonmap") not in {"kernels", "", *DATA}

    wrong = [
        f"{module} imports {target}"
        for module, target, above, below in edges(is_layered, "photonmap")
        if layer_of(above, LAYERS) >= layer_of(below, LAYERS)
    ]
    assert not wrong


def test_kernels_import_downwards():
    wrong = [
        f"{module} imports {target}"
        for module, target, above, below in edges(lambda m: m.startswith(KERNELS), KERNELS)
        if layer_of(above, KERNEL_LAYERS) >= layer_of(below, KERNEL_LAYERS)
    ]
    assert not wrong


@pytest.mark.parametrize("module", [name for name in INSIDE if name.startswith(KERNELS)])
def test_kernels_stand_alone(module):
    for name in imports(modules()[module]):
        known = name.partition(".")[0] in sys.stdlib_module_names | KERNEL_FOUNDATION
        assert known or name.startswith(KERNELS), f"{module} imports {name}"


def test_few_rooms_touch_kernels():
    users = {
        module.removeprefix("photonmap.")
        for module in INSIDE
        if not module.startswith(KERNELS)
        and any(t.startswith(KERNELS) for t in imported_modules(module) - KERNEL_CONSTANTS)
    }
    strangers = {
        u for u in users if u not in KERNEL_USERS and u.partition(".")[0] not in KERNEL_USERS
    }
    assert not strangers


def test_no_module_imports_the_front():
    """Public names are for users; inside, they would tie everything to everything."""
    assert not [module for module in INSIDE if "photonmap" in imported_modules(module)]


def test_no_modules_import_each_other():
    number = {name: index for index, name in enumerate(INSIDE)}
    pairs = [(m, t) for m in INSIDE for t in imported_modules(m) if t in number]
    rows, columns = ([number[name] for name in names] for names in zip(*pairs, strict=True))
    graph = csr_array((np.ones(len(pairs)), (rows, columns)), shape=(len(INSIDE),) * 2)
    count, knot = connected_components(graph, directed=True, connection="strong")
    members = [[m for m in INSIDE if knot[number[m]] == index] for index in range(count)]
    assert not [names for names in members if names[1:]]


def test_importing_the_package_and_help_are_light():
    code = (
        "import sys, photonmap, photonmap.commands.main; photonmap.Scene; photonmap.load_scene;"
        "heavy = {'numba', 'scipy', 'trimesh', 'OpenImageIO', 'rich', 'colour', 'jinja2'};"
        "heavy &= set(sys.modules);"
        "sys.exit(str(heavy)) if heavy else None;"
        # Functions are not hidden by modules of their names that are imported after the package.
        "import photonmap as pm, photonmap.render, photonmap.results.merge;"
        "from photonmap.render import render; assert pm.render is render;"
        "assert callable(pm.merge)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_public_names():
    import photonmap

    parts = {"__version__", *photonmap._PARTS}
    assert sorted(photonmap.__all__) == sorted({*photonmap._HOMES, *parts})
    assert {*photonmap._HOMES} <= {
        name.rpartition(".")[2] for name in imports(modules()["photonmap"])
    }
    for name in photonmap.__all__:
        assert getattr(photonmap, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'Sceen'"):
        _ = photonmap.Sceen
