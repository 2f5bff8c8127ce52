"""A Cornell box with nearly all matter and lights, which calls for nearly all of the kernels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import trimesh

import photonmap as pm

RADIUS = 0.12


def all_matter() -> pm.Scene:
    """Return the box with a ball of each kind of surface, in light of all kinds."""
    box = pm.scenes.cornell_box()
    ball = trimesh.creation.icosphere(subdivisions=1, radius=RADIUS)
    balls = []
    for place, material in enumerate(_materials()):
        center = (0.25 * (place % 5) - 0.5, 0.3 * (place // 5) - 0.3, 0.0)
        name = f"ball {place}"
        named = replace(material, name=name)
        uv = ball.vertices[:, :2]
        balls.append(pm.Mesh(ball.vertices + center, ball.faces, named, name, uv=uv))
    lights: list[pm.Light] = [
        pm.PointLight((0.2, 0.1, 0.3), 0.3),
        pm.SpotLight((0.3, 0.8, 0.5), (-0.2, -1.0, -0.2), 3.0),
        pm.DirectionalLight((0.1, -1.0, -1.3), 0.7),
        pm.PhotometricLight((0.0, 0.6, 0.0), np.array([[4.0, 4.0], [1.0, 2.0], [0.0, 0.0]]), 0.7),
        pm.EnvironmentLight(np.linspace(0.1, 0.6, 8 * 16 * 3).reshape(8, 16, 3)),
    ]
    return pm.Scene([*box.meshes, *balls], lights, box.camera)


def _materials() -> list[pm.Material]:
    grey = pm.Texture.of(np.linspace(0.1, 0.9, 16).reshape(4, 4))
    image = pm.Texture.of(np.linspace(0.1, 0.9, 48).reshape(4, 4, 3))
    absorbing = replace(
        pm.Material.glass(roughness=0.3),
        attenuation_color=(0.9, 0.8, 0.7),
        attenuation_distance=0.5,
        abbe=30.0,
    )
    rough = pm.Material.metal(roughness=0.5)
    return [
        absorbing,
        replace(pm.Material.glass(ior=1.6), outside=1.33),
        replace(rough, anisotropy=0.5),
        pm.Material.metal(roughness=0.2),
        replace(rough, coat=0.7, coat_roughness=0.2),
        pm.Material.plastic(),
        pm.Material(reflectance=0.4, diffuse_roughness=0.6),
        pm.Material.polished(mirror=0.9),
        pm.Material(reflectance=image, alpha=grey),
        pm.Material(reflectance=0.4, sheen=0.5),
    ]
