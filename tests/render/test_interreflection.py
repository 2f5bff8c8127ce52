"""Two facing plates of strongly coloured chips: rendered bands are as wrong as curves say."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.munsell import munsell
from photonmap.spectra.names import light as named_light

CHIPS = "2.5YR 7/12", "2.5BG 6/10"
SQUARE = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]]) / 2.0
FACES = [[0, 2, 1], [0, 3, 2]]


def plates():
    """The lamp lies below the low plate's plane, so that light comes to it by the high one alone.

    The plates are far apart: what goes to and fro once more is little.
    """
    low, high = (pm.Material(name, munsell(name)) for name in CHIPS)
    return pm.Scene(
        [
            pm.Mesh(SQUARE, FACES, low, "low"),
            pm.Mesh(SQUARE + [0.0, 2.0, 0.0], FACES, high, "high"),
        ],
        [pm.PointLight((2.0, -0.2, 0.0), named_light("D65"))],
        pm.Camera((0.0, 1.9, 0.01), (0.0, 0.0, 0.0), fov=20.0),
    )


@pytest.fixture(scope="module")
def seen():
    """Mean indirect light of the low plate for each number of bands, and the 81-band result."""
    scene = plates()
    results = {n: pm.render(scene, bands=n, size=(24, 24), passes=6, seed=3) for n in (3, 6, 9, 81)}
    for result in results.values():
        assert (result.object_id == 1).all()
        assert not result.direct.any()
        assert (result.indirect > 0.0).any()
    return results


@pytest.mark.parametrize("n", [3, 6, 9])
def test_rendered_interreflection_is_off_by_what_the_curves_tell(seen, n):
    bands = Bands.gaussian(n)
    grid = np.arange(400.0, 700.5, 0.5)
    light = named_light("D65")
    first, second = map(munsell, CHIPS)
    truth = bands.average(Spectrum(grid, light(grid) * first(grid) * second(grid)))
    product = bands.average(light) * bands.average(first) * bands.average(second)
    predicted = np.linalg.norm(product - truth) / np.linalg.norm(truth)

    ours = seen[n].indirect.mean(axis=(0, 1), dtype=np.float64)
    fine = seen[81].to_sensor(bands, "indirect").mean(axis=(0, 1), dtype=np.float64)
    measured = np.linalg.norm(ours - fine) / np.linalg.norm(fine)
    assert predicted > {3: 0.1, 6: 0.02, 9: 0.005}[n]
    assert measured == pytest.approx(predicted, rel=0.1)
