"""The Cornell box with its measured spectra, from few bands and from many."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.spectra.names import colour_science
from photonmap.spectra.observer import observer


@pytest.fixture(scope="module")
def images():
    scene = pm.scenes.cornell_box_measured()
    return {n: pm.render(scene, bands=n, size=(24, 24), passes=8, seed=5) for n in (3, 6, 81)}


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
    assert result.radiance.shape == (24, 24, 81)
    np.testing.assert_array_equal(
        result.radiance, (result.emission + result.direct) + result.indirect
    )
    assert all(np.isfinite(image).all() and (image >= 0).all() for image in result.errors.values())
