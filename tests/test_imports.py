"""Imports go one way: kernels know only NumPy, Numba and each other."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FOUNDATION = {"numpy", "numba", "llvmlite", "embreex", "platformdirs", "photonmap.kernels"}
TOUCH_KERNELS = {
    "accumulate", "bias", "block_errors", "caustics", "cells", "chances", "columns", "compiling",
    "cuts", "effects", "emitters", "environment", "fingerprint", "first_hits", "focus",
    "hidden_lights", "landing", "ledger", "light_tree", "matter", "openness", "passes", "prepare",
    "record", "render", "settings", "survey", "textures", "triangles",
}  # fmt: skip


def imports(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module


@pytest.mark.parametrize("path", sorted((ROOT / "kernels").glob("*.py")), ids=lambda p: p.name)
def test_kernels_stand_alone(path):
    for name in imports(path):
        known = name.split(".")[0] in sys.stdlib_module_names
        assert known or name in FOUNDATION or name.split(".")[0] in FOUNDATION or (
            name.startswith("photonmap.kernels.")
        ), f"{path.name} imports {name}"  # fmt: skip


def test_few_modules_touch_kernels():
    users = {
        path.stem
        for path in (ROOT / "photonmap").rglob("*.py")
        if any(name.startswith("photonmap.kernels") for name in imports(path))
    }
    assert users == TOUCH_KERNELS


def test_importing_the_package_and_help_are_light():
    code = (
        "import sys, photonmap, photonmap.cli; photonmap.Scene; photonmap.load_scene;"
        "heavy = {'numba', 'scipy', 'trimesh', 'OpenImageIO', 'rich', 'colour', 'jinja2'};"
        "heavy &= set(sys.modules);"
        "sys.exit(str(heavy) if heavy else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_functions_are_not_hidden_by_their_modules():
    code = (
        "import photonmap as pm, photonmap.render, photonmap.merge;"
        "from photonmap.render import render; assert pm.render is render;"
        "assert callable(pm.merge)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_public_names():
    import photonmap

    for name in photonmap.__all__:
        assert getattr(photonmap, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'Sceen'"):
        _ = photonmap.Sceen
