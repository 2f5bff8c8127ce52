"""Three variants of kernels serve all scenes; each is compiled ahead, on a few triangles."""

import subprocess
import sys
from dataclasses import replace

import numba
import numpy as np
import pytest
import trimesh

import photonmap as pm
from photonmap.compile.scene_arrays import VARIANTS, compile_scene, variant_of
from photonmap.integrators.kernel_warmup import _setup, _smallest
from photonmap.integrators.missing_light import find_hidden_lights
from photonmap.integrators.photon_mapping.photon_tracer import PhotonTracer
from photonmap.kernels.core.streams import Domain
from photonmap.runtime.workers import Workers
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()
IMAGE = pm.Texture.of(np.linspace(0.1, 0.9, 4 * 4 * 3).reshape(4, 4, 3))
GREY = pm.Texture.of(np.linspace(0.1, 0.9, 4 * 4).reshape(4, 4))
BRUSH = pm.AnisotropyMap(IMAGE)
GLASS = pm.Material.glass()
METAL = pm.Material.metal()
ABSORBING = {"attenuation_color": (0.9, 0.8, 0.7), "attenuation_distance": 0.5}
MATERIALS = {
    "painted": [pm.Material(reflectance=IMAGE)],
    "shining": [pm.Material(emission=IMAGE)],
    "holes": [pm.Material(alpha=GREY)],
    "relief": [pm.Material(relief=pm.BumpMap(GREY))],
    "plaster": [pm.Material(diffuse_roughness=0.5)],
    "mirror coat": [pm.Material(mirror=0.3)],
    "plastic": [pm.Material.plastic()],
    "plastic by image": [pm.Material(glossy=0.04, roughness=GREY)],
    "coat": [pm.Material(coat=GREY)],
    "coat by image": [pm.Material(coat=0.5, coat_roughness=GREY)],
    "coat with relief": [pm.Material(coat=0.5, coat_relief=pm.BumpMap(GREY))],
    "sheen": [pm.Material(sheen=0.5)],
    "sheen by image": [pm.Material(sheen=IMAGE)],
    "brushed": [replace(METAL, anisotropy=0.5)],
    "both metals": [replace(METAL, roughness=r, glossy_edge=(0.9, 0.7, 0.5)) for r in (0.2, 0.6)],
    "polished metal": [replace(METAL, roughness=0.0)],
    "glass": [GLASS],
    "frosted glass": [replace(GLASS, roughness=0.4)],
    "brushed glass by image": [replace(GLASS, anisotropy=0.5, anisotropy_map=BRUSH)],
    "stained glass": [replace(GLASS, tint=IMAGE)],
    "glass by image": [replace(GLASS, reflectance=0.4, transmission=GREY)],
    "window": [pm.Material.pane()],
    "absorbing": [replace(GLASS, **ABSORBING)],
    "flint": [replace(GLASS, abbe=30.0)],
    "all of it": [
        replace(GLASS, roughness=0.3, abbe=30.0, **ABSORBING),
        replace(GLASS, reflectance=0.4, tint=IMAGE, transmission=GREY),
        replace(METAL, anisotropy=0.5, glossy_edge=(0.9, 0.7, 0.5)),
        pm.Material(reflectance=IMAGE, glossy=0.04, roughness=GREY, coat=0.5, alpha=0.7),
        pm.Material.pane(),
    ],
}
TEXTURED = ("painted", "holes", "relief")
LIGHTS = [
    pm.SpotLight((0.3, 0.8, 0.5), (-0.2, -1.0, -0.2), 3.0),
    pm.DirectionalLight((0.1, -1.0, -1.3), 0.7),
    pm.PhotometricLight((0.0, 0.6, 0.0), np.array([[4.0, 4.0], [1.0, 2.0], [0.0, 0.0]]), 0.7),
    pm.EnvironmentLight(np.linspace(0.1, 0.6, 40 * 80 * 3).reshape(40, 80, 3)),
    *(pm.PointLight((0.1 * place, 0.1, 0.3), 0.3) for place in range(8)),
]
LENS = pm.Lens(1.0, 0.01)


def balls(materials):
    """Balls of these materials side by side in the Cornell box."""
    box = pm.scenes.cornell_box()
    sphere = trimesh.creation.icosphere(subdivisions=1, radius=0.15)
    meshes = [
        pm.Mesh(
            sphere.vertices + (0.35 * place - 0.7, 0.0, 0.0),
            sphere.faces,
            replace(material, name=f"material {place}"),
            f"ball {place}",
            uv=sphere.vertices[:, :2],
        )
        for place, material in enumerate(materials)
    ]
    return pm.Scene([*box.meshes, *meshes], camera=box.camera)


def sunlit_room():
    """The Cornell box with a portal, and a sun."""
    scene = balls([pm.Material("opening", 0.0, portal=True)])
    return replace(scene, lights=[pm.DirectionalLight((0.0, -1.0, -1.0))])


def through_a_lens():
    """The Cornell box in many lights."""
    box = pm.scenes.cornell_box()
    return pm.Scene(box.meshes, LIGHTS, replace(box.camera, lens=LENS))


PLAIN = {"box": pm.scenes.cornell_box(), "sun": sunlit_room(), "lights": through_a_lens()}
SCENES = PLAIN | {name: balls(materials) for name, materials in MATERIALS.items()}


def kinds_of(compiled):
    """What kernels are compiled for."""
    return numba.typeof(compiled.arrays), numba.typeof(compiled.film_camera(8, 8))


@pytest.fixture(scope="module", params=VARIANTS)
def small(request):
    return request.param, _smallest(request.param)


def test_few_kernels_serve_all_scenes():
    """Else the largest kernel would be compiled once ahead, and once more in the first pass."""
    ahead = {name: kinds_of(compile_scene(_smallest(name), RGB)) for name in VARIANTS}
    for name, scene in SCENES.items():
        compiled = compile_scene(scene, RGB)
        is_plain = name in PLAIN or name == "shining"
        wanted = "plain" if is_plain else "textured" if name in TEXTURED else "full"
        assert variant_of(compiled) == wanted, name
        assert kinds_of(compiled) == ahead[wanted], name


def test_photons_hit_the_triangle(small):
    """Else paths would take their place, and the cache's kernels be compiled in the first pass."""
    with Workers(1) as workers:
        assert not PhotonTracer(_setup(small[1], RGB, workers)).traces_paths_instead


def test_nothing_is_said_of_lights_that_stand_in(small):
    """They all light the triangle that is in view."""
    with Workers(1) as workers:
        setup = _setup(small[1], RGB, workers)
    assert variant_of(setup.compiled) == small[0]
    key = setup.key(0, Domain.LIGHT_VISIBILITY)
    assert find_hidden_lights(setup.compiled, setup.view, key) == []


LATE = """
import sys
import trimesh
from numba.core.registry import CPUDispatcher
import photonmap as pm
from photonmap.integrators import kernel_warmup
from photonmap.runtime.workers import Workers
from photonmap.spectra.bands import Bands

def called():
    return {
        (module, name): set(kernel.overloads)
        for module in list(sys.modules) if module.startswith("photonmap.kernels")
        for name, kernel in vars(sys.modules[module]).items() if isinstance(kernel, CPUDispatcher)
    }

box = pm.scenes.cornell_box()
colors = [(0.2, 0.5, 0.5), (0.7, 0.3, 0.3), (0.1, 0.4, 0.4)]
coloured = [
    pm.Mesh(mesh.vertices, mesh.faces, pm.Material(f"paint {number}", color), mesh.name)
    for number, (mesh, color) in enumerate(zip(box.meshes, colors))
]
shape = trimesh.creation.icosphere(1, 0.3)
balls = [
    pm.Mesh(shape.vertices + [x, 0.0, 0.0], shape.faces, look, f"ball {x}")
    for x, look in ((-0.4, pm.Material.glass()), (0.4, pm.Material.polished()))
]
lamp, fill = pm.PointLight((0.1, 0.4, 0.2), 0.2), pm.PointLight((-0.1, 0.2, 0.3), 0.1)
"""
RENDERS = """
plain = [
    (pm.Scene(coloured, [lamp], box.camera), {"bands": "rgb"}),  # bands are merged
    (pm.Scene(box.meshes, [lamp, fill], box.camera), {"per_light": True}),
]
full = [(pm.Scene([*box.meshes, *balls], camera=box.camera), {"bands": "rgb"})]
for variant, renders in (("plain", plain), ("full", full)):
    with Workers(1) as workers:
        kernel_warmup._compile_all(kernel_warmup._smallest(variant), Bands.rgb(), workers, "photon")
    ahead = called()
    for scene, settings in renders:
        pm.render(scene, size=8, passes=4, seed=1, threads=1, **settings)
    print([at for at, overloads in called().items() if overloads - ahead.get(at, set())])
"""


def test_a_render_calls_no_kernel_that_was_not_called_ahead():
    """It would be compiled in a pass or after, without a word; in a process of its own.

    After 4 passes light is filtered.
    """
    command = [sys.executable, "-c", LATE + RENDERS]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    assert run.stdout.split("\n")[-3:-1] == ["[]", "[]"]
