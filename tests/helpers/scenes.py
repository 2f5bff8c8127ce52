"""Cameras, materials and shapes that many tests build scenes of."""

import numpy as np
import trimesh

import photonmap as pm

CAMERA = pm.Camera(origin=(0.0, 0.0, 3.9), target=(0.0, 0.0, 0.0), fov=39.3077)
GREY = pm.Material("grey", 0.5)


def quad(a, b, c, d, material=GREY, name="quad"):
    """A parallelogram whose front is seen counter-clockwise."""
    return pm.Mesh(np.array([a, b, c, d], float), [[0, 1, 2], [0, 2, 3]], material, name)


def closed_box(material, low=-1.0, high=1.0, name="walls"):
    """A cube whose front faces look inwards."""
    box = trimesh.creation.box(bounds=[[low] * 3, [high] * 3])
    return pm.Mesh(box.vertices, box.faces[:, ::-1], material, name)


def ball(material, center=(0.0, -0.4, -0.3), radius=0.5, subdivisions=2, name="ball"):
    """A ball with texture coordinates, and no normals of its own."""
    sphere = trimesh.creation.icosphere(subdivisions, radius)
    uv = 0.5 + 0.5 / radius * sphere.vertices[:, :2]
    return pm.Mesh(sphere.vertices + center, sphere.faces, material, name, uv=uv)


def ball_room(*materials, lights=(), walls=GREY):
    """A closed box with a lamp, and up to four balls, each in a quarter of the image."""
    glow, x = pm.Material("lamp", 0.0, 5.0), 0.8
    lamp = quad((-x, 0.9, -x), (x, 0.9, -x), (x, 0.9, x), (-x, 0.9, x), glow, "lamp")
    places = [(0.37 * x, 0.37 * y, -0.2) for y in (1, -1) for x in (-1, 1)]
    balls = [
        ball(material, place, 0.35, name=f"ball {number}")
        for number, (material, place) in enumerate(zip(materials, places, strict=False))
    ]
    camera = pm.Camera((0.0, 0.0, 0.95), (0.0, 0.0, -1.0), fov=65.0)
    return pm.Scene([closed_box(walls), lamp, *balls], list(lights), camera)


def closed_tetrahedron(material, name="walls"):
    """A room around the unit cube, of so few triangles that it needs no light tree if it emits."""
    corners = 3.0 * np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
    faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
    return pm.Mesh(corners, np.array(faces)[:, ::-1], material, name)


def balls_in_box():
    """The Cornell box with a mirror and a ball of glass in it, both of few triangles."""
    box = pm.scenes.cornell_box()
    shape = trimesh.creation.icosphere(subdivisions=2, radius=0.35)
    looks = {"mirror": pm.Material.polished(), "glass": pm.Material.glass()}
    balls = [
        pm.Mesh(shape.vertices + [x, -0.65, 0.0], shape.faces, look, name, shape.vertices / 0.35)
        for x, (name, look) in zip((-0.4, 0.4), looks.items(), strict=True)
    ]
    walls = [mesh for mesh in box.meshes if not mesh.name.endswith("_box")]
    return pm.Scene([*walls, *balls], camera=box.camera)


def sky(height=8, seed=0):
    """A map whose texels differ, some of them black, one bright."""
    texels = np.random.default_rng(seed).random((height, 2 * height, 3)) ** 4
    texels[1:3, 2:5] = 0.0
    texels[2, 6] = 30.0
    return texels
