"""The types that users see: strict mypy and pyright accept what the README shows and what works."""

import json
import os
import subprocess
import sys

import pytest
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


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A user's folder, with the package laid out beside it as a wheel installs it."""
    folder = tmp_path_factory.mktemp("user")
    package = folder / "site" / "photonmap"
    package.mkdir(parents=True)
    for part in [*(ROOT / "photonmap").iterdir(), ROOT / "kernels", ROOT / "scenes"]:
        (package / part.name).symlink_to(part)
    settings = {
        "typeCheckingMode": "strict",
        "extraPaths": ["site"],
        "include": ["mine.py"],
        "reportUnusedExpression": False,
    }
    (folder / "pyrightconfig.json").write_text(json.dumps(settings))
    return folder


def mypy():
    cache = ROOT / ".mypy_cache" / "user"
    return ["mypy", "--strict", "--follow-imports=silent", "--config-file=", f"--cache-dir={cache}"]


def pyright():
    pytest.importorskip("pyright")
    return ["pyright", "--pythonpath", sys.executable]


@pytest.fixture(scope="module", params=[mypy, pyright], ids=lambda tool: tool.__name__)
def check(request, folder):
    """Check the types of a user's module; return the mistakes found, or nothing."""
    command = [sys.executable, "-m", *request.param()]

    def run(text):
        (folder / "mine.py").write_text(text)
        files = ["mine.py"] if request.param is mypy else []
        done = subprocess.run(
            [*command, *files],
            cwd=folder,
            env=os.environ | {"MYPYPATH": str(folder / "site")},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.stdout, done.stderr
        return done.stdout if done.returncode else ""

    return run


def test_snippets_of_the_readme(check):
    [(_, text, _)] = blocks(ROOT / "README.md")
    assert check(text) == ""


def test_uses(check):
    assert check(USES) == ""


def test_mistakes_are_found(check):
    found = check(WRONG)
    assert "size" in found
    assert '"render"' in found or "reportArgumentType" in found
