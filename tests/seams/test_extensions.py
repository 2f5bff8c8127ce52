"""What an outsider adds by the contracts of docs/extending.md, in a copy, takes so many places.

A BSDF, a light, a buffer, a reader and an integrator are added all at once; then one program
renders with them, and compares with closed forms.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

NEW_FILES = {
    "kernels/bsdf/chalk.py": '''
"""Half of Lambert's law."""

from photonmap.kernels.bsdf.cover import covered
from photonmap.kernels.bsdf.lambert import cosine_pdf, lobe_at, sample_cosine
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.warp import INV_PI

IS_NARROW = False


@jit
def evaluate(scattering, base, surface, wi, cover, values):
    for band in range(len(values)):
        rho = scattering.parameters[base.material, 0] * values[band]
        values[band] = covered(cover, 0.0, rho, rho * INV_PI)


@jit
def sample(scattering, base, surface, u, v):
    return sample_cosine(surface, u, v)


@jit
def pdf(scattering, base, surface, wi):
    return cosine_pdf(surface, wi)
''',
    "kernels/lights/lantern.py": '''
"""A point that shines up and down: 3 cos² of the angle to the vertical."""

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights.point import importance_at, sample_position
from photonmap.kernels.lights.samples import NOWHERE, LightSample, NoParameters, PhotonStart

Parameters = NoParameters


@jit
def _relative(w):
    return 3.0 * w[1] * w[1]


@jit
def importance(geometry, lights, emitter, at, ns):
    position = vec.row(lights.position, emitter)
    away = _relative(vec.normalize(vec.sub(at, position)))
    return away * importance_at(position, at, ns) * warp.uniform_sphere_pdf()


@jit
def sample_towards(geometry, lights, emitter, surface, u, v):
    sample = sample_position(vec.row(lights.position, emitter), surface)
    weight = sample.weight * _relative(sample.direction)
    return LightSample(sample.segment, 1.0, sample.direction, weight, 0.0, NOWHERE)


@jit
def emit(geometry, lights, emitter, position, direction):
    w = warp.uniform_sphere(direction[0], direction[1])
    weight = _relative(w) / warp.uniform_sphere_pdf()
    return PhotonStart(weight, NOWHERE, vec.row(lights.position, emitter), w)


@jit
def emitted(geometry, lights, emitter, start, direction):
    return _relative(direction), warp.uniform_sphere_pdf()
''',
    "photonmap/io/readers/plain.py": '''
"""A triangle on each line."""

import numpy as np

from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene

SUFFIXES = (".plain",)


def read(path, options):
    corners = np.loadtxt(path, ndmin=2).reshape(-1, 3)
    faces = np.arange(len(corners)).reshape(-1, 3)
    return Scene([Mesh(corners, faces, Material("default"))], name=path.stem)
''',
    "photonmap/integrators/twice.py": '''
"""Path tracing of twice the light."""

from photonmap.integrators.path import PathIntegrator


class TwiceIntegrator(PathIntegrator):
    def estimate(self, index, wider=0):
        estimate = super().estimate(index, wider)
        for name in ("direct", "indirect", "emission"):
            getattr(estimate.pixels, name)[:] *= 2.0
        return estimate
''',
}
"""Of the BSDF, the light, the reader and the integrator; a buffer has none."""

PLACES = {
    "BSDF": [
        ("kernels/bsdf/models.py", "coated, glossy, lambert", "chalk, "),
        ("kernels/bsdf/models.py", '"glossy": glossy}', '"chalk": chalk, '),
        (
            "photonmap/scene/material.py",
            "    diffuse_roughness: Annotated[",
            """    chalk: Annotated[
        float,
        Number("factor", at_least=0.0, at_most=1.0),
        Lobe(0, "chalky {}", "black", model="chalk"),
    ] = 0.0
""",
        ),
    ],
    "light": [
        ("kernels/lights/kinds.py", "photometric, point, spot", "lantern, "),
        (
            "kernels/lights/kinds.py",
            "}  # By the names that lights give them",
            '    "lantern": Kind(lantern, has_place=True, has_area=False),\n',
        ),
        (
            "photonmap/scene/lights.py",
            "@dataclass(frozen=True)\nclass SpotLight",
            """@dataclass(frozen=True)
class LanternLight(Light):
    position: Annotated[Vector, Point()]
    intensity: Annotated[Color, Emission("radiant intensity", "W·sr⁻¹")] = 1.0
    name: _Name = ""
    group: _Name = ""
    kind: ClassVar[str] = "lantern"

    def emitter(self) -> Emitter:
        return Emitter("lantern", lambda radius: 4.0 * np.pi, self.position, cone=-1.0)


""",
        ),
    ],
    "buffer": [
        (
            "photonmap/buffers.py",
            '    Buffer(\n        "specular_reflectance",',
            '    Buffer("facing", "cosine", "ratio", "first hit", "same", ("facing",)),\n',
        ),
        (
            "photonmap/integrators/first_hits.py",
            '@at_centre("depth")',
            """@at_centre("facing")
def _facing(compiled: CompiledScene, hits: FirstHits) -> Array:
    return -np.sum(hits.direction * hits.normal, axis=1)


""",
        ),
    ],
    "reader": [],
    "integrator": [
        (
            "photonmap/integrators/choice.py",
            '    "path": Method(\n',
            '    "twice": Method("twice", "TwiceIntegrator", "twice the light"),\n',
        )
    ],
}
"""Where each is added: a file, what follows there, and what is put before it."""
FILES = {"BSDF": (1, 2), "light": (1, 2), "buffer": (0, 2), "reader": (1, 0), "integrator": (1, 1)}
"""How many new files and edited files each takes."""

PROGRAM = """
import numpy as np
import photonmap as pm
from photonmap.scene.lights import LanternLight
from photonmap.scene.surfaces.layers import name_kind

with open("floor.plain", "w") as file:
    file.write("-2 0 2  2 0 2  2 0 -2\\n-2 0 2  2 0 -2  -2 0 -2\\n")
floor = pm.load_scene("floor.plain").meshes[0]
above = pm.Camera((0, 1, 0), (0, 0, 0), up=(0, 0, -1), height=0.02)
E = 3.0 * 2.0 / 0.5**2  # right below a lantern of 2 W/sr at a height of 0.5

def see(method, material, **options):
    mesh = pm.Mesh(floor.vertices, floor.faces, material)
    lantern = LanternLight((0, 0.5, 0), 2.0)
    return pm.render(
        pm.Scene([mesh], [lantern], above), bands=1, size=4, passes=4, method=method, **options
    )

for method, factor in (("path", 1.0), ("photon", 1.0), ("twice", 2.0)):
    seen = see(method, pm.Material("grey", 0.8))
    np.testing.assert_allclose(seen.radiance, factor * 0.8 * E / np.pi, rtol=2e-3)
assert name_kind(pm.Material("chalk", 0.8, chalk=0.5)) == "chalky diffuse"
for method in ("path", "photon"):
    seen = see(method, pm.Material("chalk", 0.8, chalk=0.5))
    np.testing.assert_allclose(seen.radiance, 0.4 * E / np.pi, rtol=2e-3)
seen = see("path", pm.Material("grey", 0.8), buffers=("radiance", "facing"))
np.testing.assert_allclose(seen.buffers["facing"], 1.0, rtol=1e-5)
"""


@pytest.mark.parametrize("what", PLACES)
def test_an_extension_takes_so_many_files_and_places(what):
    new = {"BSDF": "kernels/bsdf", "light": "kernels/lights", "reader": "photonmap/io"}
    folder = new.get(what, "photonmap/integrators")
    made = [name for name in NEW_FILES if name.startswith(folder)] if what != "buffer" else []
    edited = {path for path, _, _ in PLACES[what]}
    assert (len(made), len(edited)) == FILES[what]
    assert len(PLACES[what]) <= 3
    for path, anchor, _ in PLACES[what]:
        assert (ROOT / path).read_text("utf-8").count(anchor) == 1, (path, anchor)


@pytest.mark.slow
def test_extensions_agree_with_closed_forms(tmp_path):
    copy = tmp_path / "checkout"
    for folder in ("photonmap", "kernels", "scenes"):
        shutil.copytree(ROOT / folder, copy / folder)
    for name, text in NEW_FILES.items():
        (copy / name).write_text(text.lstrip(), "utf-8")
    for path, anchor, text in (place for places in PLACES.values() for place in places):
        code = (copy / path).read_text("utf-8")
        (copy / path).write_text(code.replace(anchor, text + anchor), "utf-8")
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", PROGRAM],
        cwd=copy,
        env=os.environ | {"PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
