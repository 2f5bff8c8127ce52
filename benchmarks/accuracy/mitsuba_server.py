"""Mitsuba 3 as a child process: `python mitsuba_server.py VARIANT THREADS [CASE [SIZE] | FILE]`.

It knows nothing of photonmap. It renders Mitsuba's own Cornell box in the way the reference was
made, or a case in which an object or the light is replaced: SIZE×SIZE, box filter, independent
sampler, path tracer without a depth limit (Russian roulette from depth 5), two-sided surfaces. It
prints one JSON line when it is ready. Then, for each line `DEPTH SAMPLES SEED FILE` on stdin, it
renders, writes FILE and prints {"seconds": …, "processor": …}. With DEPTH "denoise" it renders
albedo and normals alone, with up to 16 samples, and Open Image Denoise (`pyoidn`) filters the image
that FILE holds.

FILE.xml is any other scene, and so is FILE.json, as `mitsuba_export` writes it: a dictionary for
`mi.load_dict` in which {"look_at": […]} stands for a transformation, and {"array": FILE.npy} for a
bitmap.
"""

import json
import sys
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

SIZE = 256
FEATURE_SAMPLES = 16


def ball(x, y, z, bsdf):
    """Return a sphere of radius 0.35."""
    return {"type": "sphere", "center": [x, y, z], "radius": 0.35, "bsdf": bsdf}


MIRROR = {"type": "conductor", "material": "none", "specular_reflectance": 0.9}
GLASS = {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}
ROUGH = {"distribution": "ggx", "alpha": 0.01}
ROUGH_METAL = {"type": "roughconductor", "material": "none", **ROUGH}
ROUGH_GLASS = {**GLASS, "type": "roughdielectric", **ROUGH}


def grey(value):
    """Return a colour."""
    return {"type": "rgb", "value": value}


def sky():
    """Return the 8 × 16 map of `benchmarks.accuracy.matter`, rotated as Mitsuba needs it."""
    rows, columns = np.mgrid[0:8, 0:16]
    texels = np.stack([rows + 1.0, columns + 1.0, 9.0 - rows], axis=-1) / 8.0
    texels = np.roll(texels, 8, axis=1)
    return np.repeat(np.repeat(texels, 64, axis=0), 64, axis=1).astype(np.float32)


def things(case):
    """Return what a case adds to the room without its boxes; a light replaces the room's own."""
    if case == "spot":
        aim = mi.ScalarTransform4f().look_at([0.3, 0.8, 0.5], [-0.2, -1, -0.2], [0, 0, 1])
        return {
            "lamp": {
                "type": "spot",
                "intensity": grey(2.0),
                "cutoff_angle": 40.0,
                "beam_width": 39.9,
                "to_world": aim,
            }
        }
    return {
        "mirror": {"thing": ball(-0.3, -0.65, -0.2, {"type": "twosided", "bsdf": MIRROR})},
        "glass": {"thing": ball(0.3, -0.65, 0.1, GLASS)},
        "rough-glass": {"thing": ball(0.3, -0.65, 0.1, ROUGH_GLASS)},
        "rough-metal": {
            "thing": ball(-0.3, -0.65, -0.2, {"type": "twosided", "bsdf": ROUGH_METAL})
        },
        "both": {
            "thing": ball(-0.4, -0.65, -0.3, {"type": "twosided", "bsdf": MIRROR}),
            "other": ball(0.4, -0.65, 0.2, GLASS),
        },
        "point": {"lamp": {"type": "point", "position": [0.3, 0.2, 0.4], "intensity": grey(1.0)}},
        "sun": {
            "lamp": {"type": "directional", "direction": [0.3, -0.5, -1.0], "irradiance": grey(2.0)}
        },
        "dome": {"lamp": {"type": "constant", "radiance": grey(1.0)}},
        "sky": {"lamp": {"type": "envmap", "bitmap": mi.Bitmap(sky())}},
    }[case]


def make_scene(case=None, size=SIZE):
    """Return the Cornell box, or a case, as a dictionary for `mi.load_dict`."""
    scene = mi.cornell_box()
    if case:
        added = things(case)
        left_out = ["small-box", "large-box"] + ["light"] * ("lamp" in added)
        scene = {name: thing for name, thing in scene.items() if name not in left_out} | added
    film = scene["sensor"]["film"]
    film["width"], film["height"], film["rfilter"] = size, size, {"type": "box"}
    scene["sensor"]["sampler"] = {"type": "independent"}
    for name in ("white", "red", "green"):
        scene[name] = {"type": "twosided", "bsdf": scene[name]}
    del scene["integrator"]
    return scene


def load_scene(node):
    """Return a dictionary read from JSON with Mitsuba's own objects in it."""
    if not isinstance(node, dict):
        return node
    if "look_at" in node:
        origin, target, up = node["look_at"]
        return mi.ScalarTransform4f().look_at(origin=origin, target=target, up=up)
    if "array" in node:
        return mi.Bitmap(np.load(node["array"]))
    return {name: load_scene(part) for name, part in node.items()}


def denoise(image, features):
    """Return an image without its noise; `features` are its albedo and normals, (H, W, 6)."""
    import pyoidn

    return pyoidn.denoise(image, albedo=features[..., :3], normal=features[..., 3:], hdr=True)


def main():
    """Render on request until stdin ends."""
    mi.set_variant(sys.argv[1])
    import drjit as dr

    dr.set_thread_count(int(sys.argv[2]))
    if sys.argv[-1].endswith(".xml"):
        scene = mi.load_file(sys.argv[-1])
    elif sys.argv[-1].endswith(".json"):
        scene = mi.load_dict(load_scene(json.loads(Path(sys.argv[-1]).read_text())))
    else:
        scene = mi.load_dict(make_scene(*sys.argv[3:4], *map(int, sys.argv[4:])))
    integrators = {
        str(depth): {"type": "path", "max_depth": depth, "rr_depth": 5} for depth in (-1, 1, 2)
    }
    integrators["features"] = {"type": "aov", "aovs": "albedo:albedo,normal:sh_normal"}
    integrators = {name: mi.load_dict(each) for name, each in integrators.items()}

    def render(name, samples, seed):
        return np.array(mi.render(scene, integrator=integrators[name], spp=samples, seed=seed))

    print(json.dumps({"version": mi.__version__, "threads": dr.thread_count()}), flush=True)
    for line in sys.stdin:
        depth, samples, seed, file = line.split()
        start, processor = time.perf_counter(), time.process_time()
        samples, seed = int(samples), int(seed)
        if depth == "denoise":
            features = render("features", min(samples, FEATURE_SAMPLES), seed)
            image = denoise(np.load(file), features)
        else:
            image = render(depth, samples, seed)
        seconds, processor = time.perf_counter() - start, time.process_time() - processor
        np.save(file, image)
        print(json.dumps({"seconds": seconds, "processor": processor}), flush=True)


if __name__ == "__main__":
    main()
