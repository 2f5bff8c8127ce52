"""What the page reads is what was written, to within half a standard error."""

import base64
import zlib

import numpy as np

from photonmap.viewer.packing import find_scale, pack_errors, pack_numbers, pack_values

H, W, N = 7, 11, 3


def unpack(text, shape, kind):
    """Do in Python what the page does."""
    height, width, bands = shape
    kind = np.dtype(kind)
    raw = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8)
    planes = raw.reshape(bands, kind.itemsize, height, width).astype(np.uint32)
    change = sum(planes[:, byte] << (8 * byte) for byte in range(kind.itemsize))
    return np.cumsum(change, axis=-1).astype(kind).transpose(1, 2, 0)


def values(text, scale, shape=(H, W, N)):
    return np.ldexp(unpack(text, shape, np.uint16).view(np.float16).astype(np.float64), -scale)


def test_values_are_rounded_to_half_of_their_error():
    rng = np.random.default_rng(0)
    image = (10.0 ** rng.uniform(-3, 2, (H, W, N))).astype(np.float32)
    image[0, 0] = 0.0
    image[1] *= -1.0
    error = (np.abs(image) * 10.0 ** rng.uniform(-6, -0.5, image.shape)).astype(np.float32)
    scale = find_scale(image)
    off = np.abs(values(pack_values(image, error, scale), scale) - image)
    assert (off <= np.maximum(0.5 * error, np.abs(image) * 2.0**-11)).all()
    assert (off > 0.1 * error).any(), "bits were dropped"


def test_noise_is_not_stored():
    image = np.random.default_rng(4).normal(1.0, 0.05, (64, 64, N)).astype(np.float32)
    packed = pack_values(image, np.full_like(image, 0.05), 0)
    assert len(packed) < 0.65 * len(pack_values(image, None, 0))


def test_values_without_errors_keep_the_bits_of_half_floats():
    image = np.random.default_rng(1).normal(size=(H, W)).astype(np.float32) * 1e7
    image[2, 3], image[3, 3] = np.nan, np.inf
    scale = find_scale(image)
    back = values(pack_values(image, None, scale), scale, (H, W, 1))[..., 0]
    finite = np.where(np.isfinite(image), image, 0.0)
    np.testing.assert_allclose(back, finite, rtol=2.0**-11, atol=np.abs(finite).max() * 1e-9)


def test_errors_keep_their_order_of_magnitude_to_an_eighth():
    error = (10.0 ** np.random.default_rng(2).uniform(-8, 3, (H, W, N))).astype(np.float32)
    error[0, 0], error[0, 1] = 0.0, np.inf
    text, first = pack_errors(error)
    codes = unpack(text, (H, W, N), np.uint8).astype(np.int64)
    assert (codes[0, 0] == 0).all()
    assert (codes[0, 1] == 255).all()
    octave, quarter = np.divmod(codes + first, 4)
    back = 2.0**octave * (1.0 + (quarter + 0.5) / 4.0)
    inside = np.ones(error.shape[:2], bool)
    inside[0, :2] = False
    np.testing.assert_allclose(back[inside], error[inside], rtol=0.125)


def test_an_image_of_zeros():
    zeros = np.zeros((H, W, N), np.float32)
    assert find_scale(zeros) == 0
    assert not values(pack_values(zeros, zeros, 0), 0).any()
    text, _ = pack_errors(zeros)
    assert not unpack(text, zeros.shape, np.uint8).any()


def test_numbers():
    ids = np.random.default_rng(3).integers(0, 300, (H, W)).astype(np.uint32)
    ids[0, 0] = 1 << 20
    back = unpack(pack_numbers(ids), (H, W, 1), np.uint16)[..., 0]
    assert back[0, 0] == 0
    np.testing.assert_array_equal(back.flat[1:], ids.flat[1:])
