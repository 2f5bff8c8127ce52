"""The types that users see: mypy --strict accepts what the README shows and what else works."""

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
pm.save_scene(box, "box.obj")
pm.merge([result, pm.load_result("other.exr")]).save("both.exr", buffers=["radiance"])
"""
WRONG = """
import photonmap as pm

pm.render(pm.scenes.cornell_box(), size="big")
"""


@pytest.fixture(scope="module")
def check(tmp_path_factory):
    """Run mypy --strict on a user's module, with the package laid out as a wheel installs it."""
    folder = tmp_path_factory.mktemp("user")
    package = folder / "site" / "photonmap"
    package.mkdir(parents=True)
    for part in [*(ROOT / "photonmap").iterdir(), ROOT / "kernels", ROOT / "scenes"]:
        (package / part.name).symlink_to(part)
    options = [
        "--strict", "--follow-imports=silent", "--config-file=",
        f"--cache-dir={ROOT / '.mypy_cache' / 'user'}",
    ]  # fmt: skip

    def run(text):
        (folder / "mine.py").write_text(text)
        done = subprocess.run(
            [sys.executable, "-m", "mypy", *options, "mine.py"],
            cwd=folder,
            env=os.environ | {"MYPYPATH": str(package.parent)},
            capture_output=True,
            text=True,
            check=False,
        )
        return done.stdout

    return run


def test_snippets_of_the_readme(check):
    [(_, text, _)] = blocks(ROOT / "README.md")
    assert check(text).startswith("Success"), check(text)


def test_uses(check):
    assert check(USES).startswith("Success"), check(USES)


def test_mistakes_are_found(check):
    assert '"size" to "render" has incompatible type "str"' in check(WRONG)
