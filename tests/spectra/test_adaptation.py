"""Von Kries' adaptation in CAT16, against colour-science and its own definition."""

import numpy as np
import pytest

from photonmap.spectra.color_text import emission
from photonmap.spectra.names import colour_science
from photonmap.spectra.observer import adapt_to_d65, emission_spectrum, observer, radiance_to_rgb

TO_XYZ = observer().rgb_to_xyz


def rgb_of(text):
    return radiance_to_rgb(emission_spectrum(emission(text)))


@pytest.mark.parametrize("light", ["1", "D50", "A", "planck:20000", "FL2", "rgb:.9,1,.8"])
def test_as_colour_science(light):
    white = rgb_of(light)
    with colour_science() as colour:
        xyz, d65 = TO_XYZ @ white, TO_XYZ.sum(axis=1)
        wanted = colour.adaptation.matrix_chromatic_adaptation_VonKries(
            xyz / xyz[1], d65, transform="CAT16"
        )
    matrix = adapt_to_d65(white)
    np.testing.assert_allclose(TO_XYZ @ matrix @ np.linalg.inv(TO_XYZ), wanted, atol=1e-12)
    np.testing.assert_allclose(matrix @ white, (TO_XYZ @ white)[1], rtol=1e-12)
    np.testing.assert_allclose(adapt_to_d65(7.0 * white), matrix, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("light", ["D65", "0", "planck:1800", "HPS", "rgb:1,0,0", "rgb:0,0,1"])
def test_d65_and_what_is_no_white_change_nothing(light):
    np.testing.assert_allclose(adapt_to_d65(rgb_of(light)), np.eye(3), atol=1e-12)
