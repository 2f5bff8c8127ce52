"""Small renders over every effect, light, material, pixel mode, method and way to run.

Each case is a function that returns a `Result`; `ALL` lists them by name.
"""

from dataclasses import replace

import numpy as np
import trimesh

import photonmap as pm
from photonmap.buffers import DEFAULT
from photonmap.spectra.fluorophores import named

SMALL = {"bands": 3, "size": (16, 12), "passes": 4, "photons": 2000, "threads": 2, "seed": 11}
SMALL["buffers"] = DEFAULT
"""The buffers that every scene has; `tests/results/test_buffers.py` is about those of gloss"""
GREY = pm.Material("grey", 0.5)


def ball(material, smooth=True, center=(0.0, -0.2, 0.0), radius=0.45, uv=False):
    """A ball of 320 triangles."""
    sphere = trimesh.creation.icosphere(subdivisions=2, radius=radius)
    normals = sphere.vertices / radius if smooth else None
    coordinates = sphere.vertices[:, :2] if uv else None
    vertices = sphere.vertices + np.array(center)
    return pm.Mesh(vertices, sphere.faces, material, "ball", normals, coordinates)


def box_with(*meshes, lights=()):
    """The Cornell box with more in it."""
    box = pm.scenes.cornell_box()
    return pm.Scene([*box.meshes, *meshes], list(lights), box.camera)


def from_aside(*meshes):
    """The Cornell box, seen so that no pixel centre lies on an edge, where rounding decides."""
    scene = box_with(*meshes)
    x, y, z = scene.camera.origin
    return replace(scene, camera=replace(scene.camera, origin=(x + 0.013, y + 0.007, z)))


def texture(rows=6, columns=8, channels=3, low=0.05):
    """A smooth pattern of known texels, 8-bit."""
    grid = np.arange(rows * columns * channels).reshape(rows, columns, channels)
    return pm.Texture.of((255 * np.clip(np.sin(grid) ** 2, low, 1.0)).astype(np.uint8))


def painted(alpha=1.0, emission=0.0):
    """A textured ball in the box."""
    return box_with(ball(pm.Material("paint", texture(), emission, alpha=alpha), uv=True))


def open_floor(*lights):
    """A floor and a ball under what shines from outside."""
    floor = pm.Mesh(
        [[-2, -0.7, -2], [-2, -0.7, 2], [2, -0.7, 2], [2, -0.7, -2]], [[0, 1, 2], [0, 2, 3]], GREY
    )
    camera = pm.Camera((0.5, 1.0, 3.0), (0.0, -0.2, 0.0))
    return pm.Scene([floor, ball(pm.Material("red", (0.7, 0.2, 0.1)))], list(lights), camera)


def sky_map():
    """A sky with a bright patch."""
    texels = np.linspace(0.1, 0.6, 8 * 16 * 3).reshape(8, 16, 3)
    texels[2, 5] = 30.0
    return pm.EnvironmentLight(texels, rotation=25.0)


def every_light():
    """All kinds of lights that are no surface, but the sky's."""
    return [
        pm.PointLight((0.2, 0.1, 0.3), (1.0, 0.8, 0.6), name="bulb"),
        pm.SpotLight((0.3, 0.8, 0.5), (-0.2, -1.0, -0.2), 3.0, name="spot"),
        pm.DirectionalLight((0.1, -1.0, -1.3), 0.7, name="sun"),
    ]


def many_lamps():
    """More emitters than are all looked at for each point."""
    places = np.random.default_rng(5).uniform(-0.8, 0.8, (24, 3))
    return box_with(lights=[pm.PointLight(tuple(place), 0.05) for place in places])


def facing_mirrors():
    """A ball between two parallel mirrors."""
    sheet = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    mirror = pm.Material.polished(mirror=(0.95, 0.9, 0.85))
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    back = pm.Mesh(sheet + (0, 0, -1), faces, mirror, "back")
    front = pm.Mesh(sheet + (0, 0, 1.5), faces[:, ::-1], mirror, "front")
    light = pm.PointLight((0.7, 0.6, 0.2), 2.0)
    lamp = ball(pm.Material("lamp", 0.3, (0.4, 0.3, 0.2)), center=(0.2, 0.0, 0.1), radius=0.3)
    return pm.Scene([back, front, lamp], [light], pm.Camera((0.1, 0.2, 1.2), (0, 0, -1), fov=60.0))


def render(scene, **settings):
    """Render a case with what it changes of `SMALL`."""
    return pm.render(scene, **{**SMALL, **settings})


def resumed(folder):
    """Two passes, a break, and two more."""
    scene, file = box_with(ball(GREY)), folder / "state.checkpoint"
    render(scene, passes=2, checkpoint=file)
    return render(scene, passes=4, checkpoint=file, resume=True)


def merged(**settings):
    """Two seeds as one run."""
    scene = box_with(ball(pm.Material("coat", 0.4, mirror=0.3)))
    return pm.merge([render(scene, seed=seed, **settings) for seed in (1, 2)])


def dyed():
    """Walls with dyes, one black, and a coated ball with a dye."""
    box, ball_dye = pm.scenes.cornell_box(), named("rhodamine 6g")
    dyes = {"left": named("coumarin 6"), "back": named("fluorescein")}
    walls = [
        replace(m, material=pm.Material(m.name, 0.04 * (m.name == "left"), fluorescence=dye))
        if (dye := dyes.get(m.name))
        else m
        for m in box.meshes
    ]
    coated = ball(pm.Material("coat", 0.03, coat=1.0, fluorescence=ball_dye))
    return pm.Scene([*walls, coated], camera=box.camera)


def plaster():
    """Rough walls around a mirror ball, in which rough surfaces are seen."""
    box = pm.scenes.cornell_box()
    walls = [replace(m, material=replace(m.material, diffuse_roughness=0.8)) for m in box.meshes]
    polished = ball(pm.Material.polished(mirror=0.9))
    return pm.Scene([*walls, polished], camera=box.camera)


def rough_chains():
    """A ball of frosted glass before one of nearly smooth metal."""
    frosted = ball(pm.Material.glass(tint=(0.95, 0.97, 0.9), roughness=0.5), radius=0.35)
    metal = pm.Material.metal("gold", (0.95, 0.8, 0.5), 0.2)
    return box_with(frosted, ball(metal, center=(0.4, 0.3, -0.4), radius=0.3))


def downlight():
    """A table of intensities that narrow downwards."""
    table = np.array([[4.0, 4.0], [1.0, 2.0], [0.0, 0.0]])
    return pm.PhotometricLight((0.0, 0.6, 0.0), table, 0.7)


def drawing():
    """The box by parallel rays."""
    box = pm.scenes.cornell_box()
    return replace(box, camera=replace(box.camera, height=1.8))


def seen_through(**camera):
    """The box by a camera of another kind."""
    box = pm.scenes.cornell_box()
    values = {"fov": pm.Camera.fov, **camera} if "projection" in camera else camera
    return replace(box, camera=replace(box.camera, **values))


INTRINSICS = pm.Intrinsics(900.0, (640, 480), distortion=(-0.1, 0.02, 0.001, -0.002, 0.003))
COAT = pm.Material("coat", (0.5, 0.3, 0.2), mirror=0.4)
GLASS = pm.Material.glass(ior=1.5, tint=(0.95, 0.97, 0.9))
CORNELL = box_with

ALL = {
    "box": lambda folder: render(CORNELL()),
    "box-center": lambda folder: render(from_aside(), pixel="center"),
    "box-path": lambda folder: render(CORNELL(), method="path"),
    "box-path-center": lambda folder: render(from_aside(), method="path", pixel="center"),
    "box-rgb-all-effects": lambda folder: render(CORNELL(), bands="rgb", effects="all"),
    "box-31-bands": lambda folder: render(CORNELL(), bands=31, passes=2),
    "smooth-normals": lambda folder: render(box_with(ball(GREY))),
    "grey-merged-bands": lambda folder: render(open_floor(pm.DomeLight()), bands=4),
    "adaptive": lambda folder: render(box_with(ball(GREY)), passes=16),
    "even": lambda folder: render(box_with(ball(GREY)), passes=10, adaptive=False),
    "coat": lambda folder: render(box_with(ball(COAT))),
    "coat-center": lambda folder: render(from_aside(ball(COAT)), pixel="center"),
    "glass-point-light": lambda folder: render(box_with(ball(GLASS), lights=every_light()[:1])),
    "glass-path": lambda folder: render(box_with(ball(GLASS)), method="path"),
    "facing-mirrors": lambda folder: render(facing_mirrors()),
    "lights": lambda folder: render(box_with(ball(GREY), lights=every_light())),
    "many-lights": lambda folder: render(many_lamps()),
    "dome": lambda folder: render(open_floor(pm.DomeLight((0.5, 0.7, 1.0)))),
    "environment": lambda folder: render(open_floor(sky_map())),
    "environment-path": lambda folder: render(open_floor(sky_map()), method="path"),
    "sun": lambda folder: render(open_floor(pm.DirectionalLight((0.3, -1.0, -0.4)))),
    "texture": lambda folder: render(painted()),
    "rough-diffuse": lambda folder: render(plaster()),
    "rough-diffuse-path": lambda folder: render(plaster(), method="path"),
    "fluorescent": lambda folder: render(dyed(), bands=5, passes=8),
    "photometric": lambda folder: render(box_with(lights=[downlight()])),
    "glossy": lambda folder: render(box_with(ball(pm.Material.plastic(roughness=0.4)))),
    "rough-chains": lambda folder: render(rough_chains()),
    "rough-chains-path": lambda folder: render(rough_chains(), method="path"),
    "orthographic": lambda folder: render(drawing(), buffers=(*DEFAULT, "specular_reflectance")),
    "lens": lambda folder: render(seen_through(lens=pm.Lens(3.4, 0.1, blades=5))),
    "lens-path-center": lambda folder: render(
        seen_through(lens=pm.Lens(3.4, 0.1)), method="path", pixel="center"
    ),
    "distorted": lambda folder: render(seen_through(projection=INTRINSICS)),
    "fisheye": lambda folder: render(seen_through(projection=pm.Fisheye(50.0))),
    "panorama": lambda folder: render(seen_through(projection=pm.Panorama())),
    "alpha": lambda folder: render(painted(alpha=texture(channels=1, low=0.0))),
    "emission-texture": lambda folder: render(painted(emission=texture())),
    "per-light": lambda folder: render(
        box_with(ball(GREY), lights=every_light()), per_light=True, bands=2
    ),
    "per-light-coat": lambda folder: render(
        box_with(ball(COAT), lights=every_light()[:1]), per_light=True, bands=2
    ),
    "some-effects": lambda folder: render(box_with(ball(COAT)), effects="emission,direct,specular"),
    "some-buffers": lambda folder: render(CORNELL(), buffers=("indirect", "normal", "passes")),
    "memory": lambda folder: render(box_with(ball(COAT)), memory=1e6),
    "resumed": resumed,
    "merged": lambda folder: merged(),
    "merged-per-light": lambda folder: merged(per_light=True, bands=2),
}
"""Functions of a folder for files, by name."""
