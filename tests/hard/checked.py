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


def with_body(material, lights=(), **mesh):
    """The Cornell box with a ball in it."""
    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.5)
    mesh = {"normals": ball.vertices / 0.5, **mesh}
    box = pm.scenes.cornell_box()
    body = pm.Mesh(ball.vertices, ball.faces, material, "ball", **mesh)
    return pm.Scene([*box.meshes, body], list(lights), box.camera)


def cut_out():
    """A ball that is there in stripes, painted, and that glows."""
    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.5)
    image = np.linspace(0.0, 1.0, 48).reshape(4, 4, 3)
    uv = ball.vertices[:, :2]
    paint = texture(image)
    material = pm.Material("paint", paint, paint, alpha=texture(image[:, ::-1]))
    return with_body(material, uv=uv)


def inlaid():
    """A ball whose gloss varies, and whose normals a map turns."""
    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.5)
    image = np.linspace(0.0, 1.0, 48).reshape(4, 4, 3)
    relief = pm.NormalMap(texture(0.4 + 0.6 * image), 0.5)
    material = pm.Material(
        "inlay", 0.3, glossy=texture(image), roughness=texture(image), relief=relief
    )
    return with_body(material, uv=ball.vertices[:, :2])


def lacquered():
    """Metal below a coat that varies."""
    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.5)
    weight = texture(np.linspace(0.0, 1.0, 48).reshape(4, 4, 3))
    material = pm.Material("car", 0.0, glossy=0.8, roughness=0.5, coat=weight)
    return with_body(material, uv=ball.vertices[:, :2])


def woven():
    """A ball whose texels are spectra, beside one of colours."""
    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.5)
    palette = pm.SpectralTexture.from_palette([[0, 1], [1, 0]], [0.2, (0.9, 0.5, 0.1)])
    woven = with_body(pm.Material("woven", palette), uv=ball.vertices[:, :2])
    image = np.linspace(0.0, 1.0, 12).reshape(2, 2, 3)
    painted = pm.Material("painted", texture(image))
    beside = pm.Mesh(0.3 * ball.vertices + 0.6, ball.faces, painted, uv=ball.vertices[:, :2])
    return pm.Scene([*woven.meshes, beside], [], woven.camera)


def bumpy():
    """A coat over paint, and glass, with bumps."""
    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.5)
    relief = pm.BumpMap(texture(np.linspace(0.0, 1.0, 48).reshape(4, 4, 3)), 0.1)
    coat = pm.Material("coat", 0.4, mirror=0.4, relief=relief)
    return with_body(coat, uv=ball.vertices[:, :2])


def texture(image):
    return pm.Texture(Image(np.ascontiguousarray(image, np.float32), srgb=False))


def scenes():
    """All kinds of surfaces and of lights."""
    lights = [
        pm.PointLight((0.2, 0.1, 0.3), (1.0, 1.0, 1.0)),
        pm.SpotLight((0.3, 0.8, 0.5), (-0.2, -1, -0.2)),
        pm.DirectionalLight((0.1, -1.0, -0.3)),
    ]
    sky = pm.EnvironmentLight(np.linspace(0.0, 1.0, 24).reshape(2, 4, 3))
    low = pm.Mesh([[-1, 0, -1], [-1, 0, 1], [1, 0, 1]], [[0, 1, 2]], GREY)
    camera = pm.Camera((0.5, 1.0, 2.0), (0, 0, 0))
    lens = replace(camera, lens=pm.Lens(2.0, 0.1, blades=5))
    fisheye = pm.Camera((0.5, 1.0, 2.0), (0, 0, 0), projection=pm.Fisheye(170.0))
    lamp = pm.PhotometricLight((0.2, 0.1, 0.3), np.ones((3, 4)))
    wine = pm.Material("wine", 0.0, ior=1.3, attenuation_color=0.2, attenuation_distance=0.1)
    return {
        "mirror": with_body(pm.Material("coat", 0.4, mirror=0.4)),
        "glass": with_body(pm.Material.glass(), lights[:1]),
        "frost": with_body(pm.Material.glass(roughness=0.5), lights[:1]),
        "pane": with_body(pm.Material.pane(tint=(0.9, 0.5, 0.2)), lights),
        "wine": with_body(wine, lights[:1]),
        "lights": with_body(GREY, lights),
        "textures": cut_out(),
        "sky": pm.Scene([low], [sky], camera),
        "dome": pm.Scene([low], [pm.DomeLight()], camera),
        "metal": with_body(pm.Material.metal(), [lamp]),
        "narrow": with_body(pm.Material.metal(roughness=0.2)),
        "plaster": with_body(pm.Material("plaster", 0.5, diffuse_roughness=0.7)),
        "inlay": inlaid(),
        "lacquer": lacquered(),
        "frosted pane": with_body(pm.Material("pane", 0.0, ior=1.5, thin=True, roughness=0.5)),
        "woven": woven(),
        "bumps": bumpy(),
        "lens": pm.Scene([low], lights, lens),
        "fisheye": pm.Scene([low], lights, fisheye),
    }


def main():
    """Render each scene in all ways."""
    warnings.simplefilter("ignore")
    if config.DISABLE_JIT:
        # Photons that look where smooth surfaces are: as plain Python, all would take an hour.
        caustics.PILOT = caustics.SCOUTS = 256
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
