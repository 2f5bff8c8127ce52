"""Highlights of previews: compressed, not clipped, and of the same hue."""

import numpy as np

from photonmap.results.preview import with_highlights


def grey(values):
    return np.repeat(np.asarray(values, np.float64)[:, None, None], 3, axis=2)


def test_highlights_are_compressed():
    values = np.linspace(0.0, 25.0, 50001)
    shown = with_highlights(grey(values))[:, 0, 0]
    np.testing.assert_array_equal(shown[values <= 0.5], values[values <= 0.5])
    slopes = np.diff(shown) / np.diff(values)
    assert (slopes > 0.0).all()
    assert np.abs(np.diff(slopes)).max() < 0.01, "no edge where compression begins"
    np.testing.assert_allclose(shown[-1], 1.0, atol=1e-4)


def test_hues_stay():
    image = np.array([[[8.0, 2.0, 1.0], [0.3, 0.2, -0.1], [0.0, 0.0, 0.0]]])
    shown = with_highlights(image)
    np.testing.assert_allclose(shown[0, 0] / shown[0, 0, 0], [1.0, 0.25, 0.125])
    assert 0.5 < shown[0, 0, 0] < 1.0
    np.testing.assert_array_equal(shown[0, 1:], image[0, 1:])
