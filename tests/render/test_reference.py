"""Agreement with another renderer on the common Cornell box."""

from pathlib import Path

import numpy as np
import pytest

import photonmap as pm

BLOCKS = Path(__file__).parents[1] / "data" / "cornell_blocks.csv"


@pytest.mark.parametrize("part", ["direct", "indirect"])
@pytest.mark.parametrize("method", ["photon", "path"])
def test_cornell_box(cornell_renders, method, part):
    """Block means agree within their own standard errors and 1%, the whole within 0.5%."""
    reference = np.loadtxt(BLOCKS, delimiter=",").reshape(16, 16, 2, 3)
    truth = reference[:, :, 0 if part == "direct" else 1]
    result = cornell_renders[method]
    sees_lamp = result.emission.any(axis=2, keepdims=True)
    image = np.where(sees_lamp, 0.0, getattr(result, part)).astype(float)
    side = len(image) // 16
    shape = 16, side, 16, side
    blocks = image.reshape(*shape, 3).mean(axis=(1, 3))
    noise = np.where(sees_lamp, 0.0, result.standard_error(part)).astype(float)
    error = np.sqrt((noise**2).reshape(*shape, 3).sum(axis=(1, 3))) / side**2
    whole = blocks.sum(axis=(0, 1)) / truth.sum(axis=(0, 1))
    np.testing.assert_allclose(whole, 1.0, atol=0.005 if method == "photon" else 0.01)
    # The lamp's outline falls on other pixels at half the resolution: leave its blocks out.
    lamp = sees_lamp.reshape(shape).any(axis=(1, 3))
    lamp[1:4] = True
    deviation = np.abs(blocks - truth) - 0.01 * truth - 1e-4
    # Neighbours share their indirect light: the noise of a block is that of few pixels.
    allowed = 4.5 * error * (8.0 if method == "photon" else 1.0)
    assert (deviation[~lamp] < allowed[~lamp]).all()


@pytest.fixture(scope="module")
def cornell_renders(cornell):
    return {
        method: pm.render(cornell, bands="rgb", size=size, passes=passes, method=method)
        for method, size, passes in (("photon", 128, 8), ("path", 64, 64))
    }


def test_methods_agree_through_a_door():
    """The second room is lit by interreflection alone."""
    scene = pm.scenes.two_rooms()
    photon = pm.render(scene, bands="rgb", size=(24, 24), passes=16, seed=1)
    path = pm.render(scene, bands="rgb", size=(24, 24), passes=120, method="path", seed=2)
    assert photon.direct.mean() < 0.4 * photon.radiance.mean()
    mean = photon.radiance.mean(axis=(0, 1), dtype=float)
    truth = path.radiance.mean(axis=(0, 1), dtype=float)
    error = np.sqrt((path.standard_error("radiance").astype(float) ** 2).sum(axis=(0, 1))) / 576
    assert (np.abs(mean - truth) < 4.0 * error + 0.01 * truth).all()
