"""Render tiny scenes of every kind, so that kernels run with bounds checked, or as plain Python.

`make kernels-checked` does both. Prints the seconds of each scene; an error ends the program.
"""

import time
import warnings
from dataclasses import replace

import numpy as np
import trimesh
from cases import check
from numba import config

import photonmap as pm
from photonmap.integrators.photon_mapping import caustics
from photonmap.scene.images import Image

TINY = {"size": (4, 3), "passes": 2, "photons": 20, "threads": 1, "seed": 4}
GREY = pm.Material("grey", 0.5)
BALL = trimesh.creation.icosphere(subdivisions=1, radius=0.5)


def with_balls(materials, lights=()):
    """The Cornell box with a ball of each material before its camera, from left to right."""
    box, count = pm.scenes.cornell_box(), len(materials)
    balls = []
    for place, material in enumerate(materials):
        center = (1.6 * (place + 0.5) / count - 0.8, 0.0, 0.0)
        vertices = BALL.vertices * min(1.0, 1.5 / count) + center
        ball = pm.Mesh(
            vertices,
            BALL.faces,
            material,
            f"ball {place}",
            normals=BALL.vertices / 0.5,
            uv=BALL.vertices[:, :2],
        )
        balls.append(ball)
    return pm.Scene([*box.meshes, *balls], list(lights), box.camera)


def texture(image):
    return pm.Texture(Image(np.ascontiguousarray(image, np.float32), srgb=False))


IMAGE = texture(np.linspace(0.0, 1.0, 48).reshape(4, 4, 3))
PALETTE = pm.SpectralTexture.from_palette([[0, 1], [1, 0]], [0.2, (0.9, 0.5, 0.1)])
PANE = pm.Material("pane", 0.0, ior=1.5, thin=True)
CHAINED = [
    pm.Material("coat", 0.4, mirror=0.4),
    pm.Material.glass(),
    pm.Material.glass(roughness=0.5),
    replace(pm.Material.glass(tint=IMAGE, roughness=IMAGE), anisotropy=0.5),
    pm.Material("wine", 0.0, ior=1.3, attenuation_color=0.2, attenuation_distance=0.1, abbe=40.0),
    pm.Material("glass in part", 0.4, ior=1.5, transmission=IMAGE),
    pm.Material.pane(tint=(0.9, 0.5, 0.2)),
    replace(PANE, roughness=0.5),
    pm.Material.metal("polished", roughness=0.0),
    replace(pm.Material.metal("narrow", roughness=0.2), glossy_edge=0.9),
]
"""Smooth ones, glass, and what is nearly smooth"""
SCATTERING = [
    pm.Material.metal(),
    replace(pm.Material.metal("brushed", roughness=0.6), anisotropy=0.5, glossy_edge=0.9),
    pm.Material("plaster", 0.5, diffuse_roughness=0.7),
    pm.Material.plastic(roughness=0.4),
    pm.Material("inlay", 0.3, glossy=IMAGE, roughness=IMAGE, relief=pm.NormalMap(IMAGE, 0.5)),
    pm.Material("lacquer", 0.0, glossy=0.8, roughness=0.5, coat=IMAGE),
    pm.Material("felt", 0.3, sheen=IMAGE),
    pm.Material("bumps", 0.4, mirror=0.4, relief=pm.BumpMap(IMAGE, 0.1)),
]
"""Rough ones"""
PAINTED = [
    pm.Material("stripes that glow", IMAGE, IMAGE, alpha=IMAGE),
    pm.Material("woven", PALETTE),
]
"""Images"""


def scenes():
    """All kinds of surfaces, of lights and of cameras, in few scenes: each compiles its kernels."""
    lights = [
        pm.PointLight((0.2, 0.1, 0.3), (1.0, 1.0, 1.0)),
        pm.SpotLight((0.3, 0.8, 0.5), (-0.2, -1, -0.2)),
        pm.DirectionalLight((0.1, -1.0, -0.3)),
    ]
    lamp = pm.PhotometricLight((0.2, 0.1, 0.3), np.ones((3, 4)))
    sky = pm.EnvironmentLight(np.linspace(0.0, 1.0, 24).reshape(2, 4, 3))
    low = pm.Mesh([[-1, 0, -1], [-1, 0, 1], [1, 0, 1]], [[0, 1, 2]], GREY)
    camera = pm.Camera((0.5, 1.0, 2.0), (0, 0, 0))
    lens = replace(camera, lens=pm.Lens(2.0, 0.1, blades=5))
    fisheye = pm.Camera((0.5, 1.0, 2.0), (0, 0, 0), projection=pm.Fisheye(170.0))
    return {
        "lights": with_balls([GREY], lights),
        "mirrors and glass": with_balls(CHAINED, lights[:1]),
        "rough matter": with_balls(SCATTERING, [lamp]),
        "images": with_balls(PAINTED),
        "sky": pm.Scene([low], [sky], camera),
        "dome, through a lens": pm.Scene([low], [pm.DomeLight()], lens),
        "fisheye": pm.Scene([low], lights, fisheye),
    }


def main():
    """Render each scene in all ways."""
    warnings.simplefilter("ignore")
    if config.DISABLE_JIT:
        # Photons that look where smooth surfaces are: as plain Python, all would take an hour.
        caustics.PILOT = caustics.LINGER_PILOT_PHOTONS = 256
    for name, scene in scenes().items():
        start = time.perf_counter()
        for method in ("photon", "path"):
            for pixel in ("box", "center"):
                with np.errstate(over="ignore"):
                    result = pm.render(scene, bands="rgb", method=method, pixel=pixel, **TINY)
                check(result)
        with np.errstate(over="ignore"):
            pm.render(scene, bands=2, per_light=True, **TINY)
        print(f"{name}: {time.perf_counter() - start:.1f} s", flush=True)


if __name__ == "__main__":
    main()
