"""Scenes that Mitsuba 3 renders, and photonmap from the same files, to the same picture.

Runs where Mitsuba can be imported (`pip install 'photonmap[bench]'`).
"""

import json
import subprocess
import sys

import numpy as np
import pytest
from helpers.mitsuba_files import write_files
from helpers.mitsuba_scenes import CASES

import photonmap as pm

pytest.importorskip("mitsuba")
pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore::photonmap.errors.SceneWarning")]
SIZE = 48, 32
BLOCK = 8
SAMPLES, RENDERS, PASSES = 256, 4, 24
LARGEST_DIFFERENCE = 0.005
"""Of the mean over the image."""
BLOCK_DIFFERENCES = {
    "envmap": 0.08,  # whose texels Mitsuba interpolates
    "envmap about y": 0.08,
    "rough gold": 0.06,  # of which Mitsuba loses more light at grazing angles
}
"""Of blocks of pixels, by the mean over the image; 0.05 for all other scenes."""
SERVER = """
import json, sys
import mitsuba as mi
import numpy as np
mi.set_variant("scalar_rgb")
for line in sys.stdin:
    file, samples, renders = json.loads(line)
    scene = mi.load_file(file)
    images = [np.array(mi.render(scene, spp=samples, seed=seed)) for seed in range(renders)]
    np.save(file + ".npy", images)
    print(flush=True)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scenes")
    write_files(folder)
    return folder


@pytest.fixture(scope="module")
def render_there():
    """Return the images that Mitsuba renders of a file, in a process of its own."""
    with subprocess.Popen(
        [sys.executable, "-c", SERVER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:

        def render(file):
            process.stdin.write(json.dumps([str(file), SAMPLES, RENDERS]) + "\n")
            process.stdin.flush()
            while process.stdout.readline().strip():  # its warnings
                pass
            return np.load(f"{file}.npy").astype(np.float64)

        yield render
        process.stdin.close()


def blocks(image):
    width, height = (size // BLOCK for size in SIZE)
    return image.reshape(height, BLOCK, width, BLOCK, 3).mean(axis=(1, 3))


@pytest.mark.parametrize("case", CASES)
def test_pictures_agree(case, folder, render_there):
    file = folder / f"{case}.xml"
    file.write_text(CASES[case])
    theirs = render_there(file)
    ours = pm.render(pm.load_scene(file), bands="rgb", size=SIZE, passes=PASSES)
    means = theirs.mean(axis=(1, 2, 3))
    mean = means.mean()
    own = np.sqrt(np.square(ours.standard_error("radiance"), dtype=np.float64).sum())
    error = np.hypot(own / ours.radiance.size, means.std(ddof=1) / np.sqrt(RENDERS)) / mean
    assert error < 0.3 * LARGEST_DIFFERENCE
    assert abs(ours.radiance.mean(dtype=np.float64) / mean - 1.0) < LARGEST_DIFFERENCE + 2.0 * error
    difference = blocks(ours.radiance.astype(np.float64)) - blocks(theirs.mean(axis=0))
    assert np.abs(difference).max() < BLOCK_DIFFERENCES.get(case, 0.05) * mean
