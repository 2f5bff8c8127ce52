"""Files, functions and parameter lists stay small; wheels hold every package."""

import tomllib
from functools import cache

from helpers.source import ROOT, functions, lines_of_code, modules, parameters

MOST_LINES = 600
"""Lines of a file"""
MOST_CODE = 40
"""Lines of a function's body without docstring, comments and empty lines"""
MOST_PARAMETERS = 8
"""Parameters of a function"""
SOURCES = ("photonmap", "kernels", "tests", "benchmarks", "examples", "tools")

DATA = {"photonmap.data": "photonmap/data", "photonmap.scenes": "scenes"}
"""Packages of files, and their folders"""


FILES = sorted(path for name in SOURCES for path in (ROOT / name).rglob("*.py"))


def relative(path):
    return path.relative_to(ROOT).as_posix()


@cache
def every_function():
    """Return each function by its file and name, with its file and syntax tree."""
    return [
        (f"{relative(path)} {name}", path, function)
        for path in FILES
        for name, function in functions(path)
    ]


def test_files():
    lines = {relative(path): len(path.read_text("utf-8").splitlines()) for path in FILES}
    assert not [name for name, count in lines.items() if count > MOST_LINES]


def test_functions():
    found = every_function()
    assert not [name for name, path, tree in found if lines_of_code(path, tree) > MOST_CODE]


def test_parameters():
    found = every_function()
    assert not [name for name, _, tree in found if len(parameters(tree)) > MOST_PARAMETERS]


def test_every_package_is_in_the_wheel():
    with (ROOT / "pyproject.toml").open("rb") as file:
        setup = tomllib.load(file)["tool"]["setuptools"]
    packages = sorted(name for name, path in modules().items() if path.name == "__init__.py")
    assert sorted(setup["packages"]) == sorted([*packages, *DATA])
    for package, folder in DATA.items():
        assert (ROOT / folder).is_dir()
        assert package in setup["package-data"]
