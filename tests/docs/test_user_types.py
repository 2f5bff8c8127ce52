"""The types that users see: strict mypy and pyright accept what the README shows and what works."""

import json
import os
import re
import subprocess
import sys

import pytest
from helpers.marks import slow
from helpers.source import ROOT
from test_docs import blocks

USES = """
import numpy as np

import photonmap as pm

triangle = pm.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], pm.Material("paint", 0.5))
same = pm.Mesh(np.eye(3), np.array([[0, 1, 2]]), pm.Material.metal("tin", (0.9, 0.8, 0.7), 0.3))
chalk = pm.Material("chalk", pm.reflectance("munsell:N 5"), diffuse_roughness=0.6)
curve = pm.Spectrum([400, 700], [0.2, 0.4])
lights: list[pm.Light] = [pm.PointLight((0, 1, 0), 2), pm.DomeLight((1, 1, 0.9)),
                          pm.SpotLight((0, 1, 0), (0, 0, 0), pm.emission("planck:2856 15"))]
sky = pm.EnvironmentLight(np.ones((2, 4, 3)))
camera = pm.Camera((0, 0, 3), (0, 0, 0), fov=30, lens=pm.Lens(3, 0.1))
scene = pm.Scene([triangle, same], lights, camera, up=(0, 0, 1))
box = pm.scenes.cornell_box()
result: pm.Result = pm.render(scene, bands=pm.Bands.gaussian(3), error="indirect:0.1", memory=1e9)
mean: float = float(result.direct.mean() + result.rgb("shading", white="D65").mean())
version: str = pm.__version__
lux: float = float(result.illuminance().max() / result.luminance().max())
pm.save_scene(box, "box.obj")
pm.merge([result, pm.load_result("other.exr")]).save("both.exr", buffers=["radiance"])
"""
WRONG = """
import photonmap as pm

pm.render(pm.scenes.cornell_box(), size="big")
"""


NOT_SHOWN = ("colour", "dask", "distributed", "matplotlib", "numba", "pandas", "rich", "xarray")
"""Packages that the code imports, and of which no type occurs in what users call; mypy would take
four times as long to analyse them."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A user's folder of modules, with the package laid out beside it as a wheel installs it."""
    folder = tmp_path_factory.mktemp("user")
    package = folder / "site" / "photonmap"
    package.mkdir(parents=True)
    for part in [*(ROOT / "photonmap").iterdir(), ROOT / "kernels", ROOT / "scenes"]:
        (package / part.name).symlink_to(part)
    [(_, readme, _)] = blocks(ROOT / "README.md")
    for name, text in (("readme", readme), ("uses", USES), ("wrong", WRONG)):
        (folder / f"{name}.py").write_text(text)
    skipped = ",".join(f"{name}.*" for name in NOT_SHOWN)
    (folder / "mypy.ini").write_text(f"[mypy]\n[mypy-{skipped}]\nfollow_imports = skip\n")
    settings = {
        "typeCheckingMode": "strict",
        "extraPaths": ["site"],
        "include": ["*.py"],
        "reportUnusedExpression": False,
    }
    (folder / "pyrightconfig.json").write_text(json.dumps(settings))
    return folder


def mypy():
    cache = f"--cache-dir={ROOT / '.mypy_cache' / 'user'}"
    return [
        "mypy",
        "--strict",
        "--follow-imports=silent",
        cache,
        "readme.py",
        "uses.py",
        "wrong.py",
    ]


def pyright():
    pytest.importorskip("pyright")
    return ["pyright", "--pythonpath", sys.executable]


@pytest.mark.parametrize("tool", [mypy, *slow(pyright)], ids=lambda tool: tool.__name__)
def test_users_see_types(folder, tool):
    """What the README shows and what works is accepted, and a mistake is found."""
    done = subprocess.run(
        [sys.executable, "-m", *tool()],
        cwd=folder,
        env=os.environ | {"MYPYPATH": str(folder / "site")},
        capture_output=True,
        text=True,
        check=False,
    )
    text = done.stdout
    found = [line for line in text.splitlines() if re.search(r"\.py:.* (error|warning): ", line)]
    assert found, text + done.stderr
    assert all("wrong.py:" in line for line in found), text
    assert "size" in text
    assert '"render"' in text or "reportArgumentType" in text
