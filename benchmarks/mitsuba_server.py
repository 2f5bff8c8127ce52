"""Mitsuba 3 as a child process: `python mitsuba_server.py THREADS`, in an interpreter that has it.

Knows nothing of photonmap. It renders Mitsuba's own Cornell box as the reference was made:
256×256, box filter, independent sampler, path tracer without a depth limit (Russian roulette
from depth 5), surfaces two-sided. Prints one JSON line when ready; then, for each line
`DEPTH SAMPLES SEED FILE` on stdin, renders, writes FILE.npy and prints {"seconds": …}.
"""

import json
import sys
import time

import mitsuba as mi
import numpy as np

SIZE = 256


def make_scene():
    """Return the Cornell box as a dictionary for `mi.load_dict`."""
    scene = mi.cornell_box()
    film = scene["sensor"]["film"]
    film["width"], film["height"], film["rfilter"] = SIZE, SIZE, {"type": "box"}
    scene["sensor"]["sampler"] = {"type": "independent"}
    for name in ("white", "red", "green"):
        scene[name] = {"type": "twosided", "bsdf": scene[name]}
    del scene["integrator"]
    return scene


def main():
    """Serve renders until stdin ends."""
    mi.set_variant("llvm_ad_rgb")
    import drjit as dr

    dr.set_thread_count(int(sys.argv[1]))
    scene = mi.load_dict(make_scene())
    integrators = {
        depth: mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 5})
        for depth in (-1, 1, 2)
    }
    print(json.dumps({"version": mi.__version__, "threads": dr.thread_count()}), flush=True)
    for line in sys.stdin:
        depth, samples, seed, file = line.split()
        start = time.perf_counter()
        image = mi.render(
            scene, integrator=integrators[int(depth)], spp=int(samples), seed=int(seed)
        )
        image = np.array(image)
        seconds = time.perf_counter() - start
        np.save(file, image)
        print(json.dumps({"seconds": seconds}), flush=True)


if __name__ == "__main__":
    main()
