"""Few bands against 81: the measured Cornell box, and plates whose errors the curves tell."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.munsell import munsell
from photonmap.spectra.names import colour_science
from photonmap.spectra.names import light as named_light
from photonmap.spectra.observer import observer


@pytest.fixture(scope="module")
def images():
    scene = pm.scenes.cornell_box_measured()
    return {n: pm.render(scene, bands=n, size=(16, 16), passes=6, seed=5) for n in (3, 6, 81)}


def difference(ours, truth):
    """Return the mean ΔE2000, white being D65 as bright as the wall in the lamp's light."""
    white = np.percentile(truth @ observer().rgb_to_xyz[1], 99.0)
    with colour_science() as colour:
        labs = [colour.XYZ_to_Lab(rgb / white @ observer().rgb_to_xyz.T) for rgb in (ours, truth)]
        return colour.delta_E(*labs, method="CIE 2000").mean()


@pytest.mark.parametrize("buffer", ["radiance", "indirect"])
def test_six_bands_show_the_box_more_truly_than_three(images, buffer):
    truth = images[81].rgb(buffer, white="D65")
    three, six = (difference(images[n].rgb(buffer, white="D65"), truth) for n in (3, 6))
    assert six < 0.6 * three
    assert six < 1.2


def test_cameras_see_the_same_from_six_bands_and_from_many(images):
    camera = pm.Bands.sensors([pm.Spectrum([400, at, 700], [0, 1, 0]) for at in (450, 540, 610)])
    truth = images[81].to_sensor(camera)
    off = {n: np.abs(images[n].to_sensor(camera) - truth).mean() / truth.mean() for n in (3, 6)}
    assert off[6] < 0.02
    assert off[6] < off[3]


def test_every_band_of_81_adds_up(images):
    result = images[81]
    assert result.radiance.shape == (16, 16, 81)
    np.testing.assert_array_equal(
        result.radiance, (result.emission + result.direct) + result.indirect
    )
    assert all(np.isfinite(image).all() and (image >= 0).all() for image in result.errors.values())


CHIPS = "2.5YR 7/12", "2.5BG 6/10"
SQUARE = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]]) / 2.0
FACES = [[0, 2, 1], [0, 3, 2]]


def plates():
    """Two facing plates of strongly coloured chips.

    The lamp lies below the low plate's plane, so that light comes to it by the high one alone.

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
