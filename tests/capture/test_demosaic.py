"""Demosaicing reproduces constants and linear ramps, keeps what was measured, and is unbiased."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.capture.mosaic import demosaic, read_mosaic, sample, tile

RGB = ("red", "green", "blue")
XTRANS = "GBGGRG/RGRBGB/GBGGRG/GRGGBG/BGBRGR/GRGGBG"
PATTERNS = {
    "RGGB": ("RGGB", RGB),
    "GRBG": ("GRBG", RGB),
    "BGGR": ("BGGR", RGB),
    "xtrans": (XTRANS, RGB),
    "nine": ("123456789", tuple(f"{i}nm" for i in range(9))),
    "six": ("1,2,3/4,5,6", tuple(f"{i}nm" for i in range(6))),
    "stripes": ("1,2", ("a", "b")),
}
each_pattern = pytest.mark.parametrize("name", PATTERNS)


def ramps(channels, height=17, width=22):
    """Return a plane of its own in each channel."""
    rng = np.random.Generator(np.random.PCG64(1))
    y, x = np.mgrid[:height, :width]
    a, b, c = rng.standard_normal((3, channels))
    return a + b * x[..., None] / 10 + c * y[..., None] / 10


def run(name, image, method="auto"):
    text, names = PATTERNS[name]
    pattern = read_mosaic(text, names)
    return demosaic(sample(image, pattern), pattern, len(names), method)


@each_pattern
@pytest.mark.parametrize("method", ["auto", "bilinear"])
def test_constants(name, method):
    image = np.broadcast_to(
        np.arange(1.0, 1 + len(PATTERNS[name][1])), (13, 14, len(PATTERNS[name][1]))
    )
    np.testing.assert_allclose(
        run(name, image, method), image, rtol=1e-9
    ) if method == "bilinear" else None
    inside = (slice(2, -2), slice(2, -2))
    np.testing.assert_allclose(run(name, image, method)[inside], image[inside], rtol=1e-9)


@each_pattern
def test_ramps_up_to_the_edges(name):
    image = ramps(len(PATTERNS[name][1]))
    np.testing.assert_allclose(run(name, image, "bilinear"), image, atol=1e-6)


@pytest.mark.parametrize("name", ["RGGB", "GRBG", "BGGR"])
def test_ramps_by_malvar(name):
    image = ramps(3)
    inside = (slice(2, -2), slice(2, -2))
    np.testing.assert_allclose(run(name, image, "malvar")[inside], image[inside], atol=1e-12)


@each_pattern
@pytest.mark.parametrize("method", ["auto", "bilinear"])
def test_measured_values_are_kept(name, method):
    text, names = PATTERNS[name]
    pattern = read_mosaic(text, names)
    image = np.random.Generator(np.random.PCG64(2)).random((12, 18, len(names)))
    mosaic = sample(image, pattern)
    found = demosaic(mosaic, pattern, len(names), method)
    chosen = tile(pattern, 12, 18)[..., None]
    np.testing.assert_array_equal(np.take_along_axis(found, chosen, axis=2)[..., 0], mosaic)


def test_bilinear_is_bilinear():
    """In the interior of a Bayer mosaic: means of the two or four nearest."""
    pattern = read_mosaic("RGGB", RGB)
    mosaic = np.random.Generator(np.random.PCG64(3)).random((12, 12))
    found = demosaic(mosaic, pattern, 3, "bilinear")
    red = mosaic[4:7:2, 4:7:2]
    assert found[5, 5, 0] == pytest.approx(red.mean(), abs=1e-5)
    assert found[4, 5, 0] == pytest.approx(red[0].mean(), abs=1e-5)
    green = [mosaic[3, 4], mosaic[5, 4], mosaic[4, 3], mosaic[4, 5]]
    assert found[4, 4, 1] == pytest.approx(np.mean(green), abs=1e-5)


def test_malvar_beats_bilinear_where_channels_go_together():
    """On a grey pattern of smooth waves, as the paper claims of natural images."""
    y, x = np.mgrid[:64, :64]
    grey = 0.5 + 0.25 * np.sin(0.9 * x + 0.3 * y) + 0.2 * np.cos(0.8 * y)
    image = np.repeat(grey[..., None], 3, axis=2)
    inside = (slice(2, -2), slice(2, -2))
    errors = {
        method: np.sqrt(np.mean((run("RGGB", image, method) - image)[inside] ** 2))
        for method in ("bilinear", "malvar")
    }
    assert errors["malvar"] < 0.6 * errors["bilinear"]


def test_patterns():
    assert read_mosaic("auto", RGB).tolist() == [[0, 1], [1, 2]]
    assert read_mosaic("RG/GB", RGB).tolist() == [[0, 1], [1, 2]]
    assert read_mosaic("none", RGB) is None
    assert read_mosaic("auto", ("550nm",)) is None
    assert read_mosaic("auto", tuple("abcdef")).tolist() == [[0, 1, 2], [3, 4, 5], [0, 1, 2]]
    assert read_mosaic("1,2,3/4,5,6", tuple("abcdef")).tolist() == [[0, 1, 2], [3, 4, 5]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("RGB", "not a square"),
        ("RG/B", "different lengths"),
        ("RGGX", "names X, but the camera has"),
        ("RGGR", "leaves out 'blue'"),
        ("1,2/3,17", "names 17"),
        ("", "different lengths"),
        ("R,/G,B", "different lengths"),
        ("/".join(["RGGB" * 5] * 2), "more than 16"),
    ],
)
def test_bad_patterns(text, message):
    with pytest.raises(pm.InputError, match=message) as caught:
        read_mosaic(text, RGB)
    assert "\n" not in str(caught.value)


def test_malvar_needs_bayer():
    result = pm.Result({"radiance": np.ones((8, 8, 9), np.float32)}, {}, pm.Bands.parse(9), {})
    with pytest.raises(pm.InputError, match="choose bilinear"):
        pm.expose(result, pm.Sensor(camera="9", demosaic="malvar"))
