"""What a render returns: its buffers, what follows from them, and a picture to look at."""

import inspect
import struct
import zlib

import numpy as np
import pytest

import photonmap as pm
from photonmap.errors import InputError
from photonmap.film.variance_smoothing import PRIORS, smooth_error
from photonmap.io.png import encode_png
from photonmap.results.result import Result
from photonmap.spectra.bands import Bands
from photonmap.spectra.color_text import emission
from photonmap.spectra.observer import observer, upsample_reflectance

H, W = 4, 5
LUMINANCE = observer().rgb_to_xyz[1]
LIGHT = ("radiance", "emission", "direct", "indirect", "shading")
BANDED = (*LIGHT, "reflectance")
FLAT = {
    "coverage": ((), np.float32),
    "depth": ((), np.float32),
    "unresolved": ((), np.bool_),
    "normal": ((3,), np.float32),
    "object_id": ((), np.uint32),
    "material_id": ((), np.uint32),
}
BANDS = [Bands.rgb(), *map(Bands.gaussian, (1, 2, 3, 6, 31)), Bands.box(4)]
every = pytest.mark.parametrize("bands", BANDS, ids=lambda b: f"{b.kind}-{b.count}")


def make(bands=BANDS[0], **changed):
    rng = np.random.default_rng(bands.count)
    buffers = {name: rng.random((H, W, bands.count), np.float32) for name in BANDED}
    buffers |= {n: np.ones((H, W, *shape), kind) for n, (shape, kind) in FLAT.items()}
    errors = {name: 0.1 * buffers[name] for name in LIGHT}
    return Result(buffers | changed, errors, bands, {"seed": 1})


def lit_by(light, bands):
    """Return a result in which a white surface is lit by a light, which the record knows."""
    values = bands.emission(emission(light))
    image = np.broadcast_to(values.astype(np.float32), (H, W, bands.count))
    record = {"white": (values / values.mean()).tolist(), "scene": {"spectra": True}}
    return Result({"radiance": image, "emission": 0.0 * image}, {}, bands, record)


@pytest.mark.parametrize("light", ["1", "D65", "D50", "A", "rgb:.4,.5,.6"])
@every
def test_a_white_surface_is_white_under_the_light_of_the_scene(bands, light):
    result = lit_by(light, bands)
    red, green, blue = np.moveaxis(result.rgb(), -1, 0)
    np.testing.assert_allclose(red, green, rtol=1e-6)
    np.testing.assert_allclose(blue, green, rtol=1e-6)
    assert (np.ptp(result.preview().astype(int), axis=-1) == 0).all()
    np.testing.assert_allclose(result.xyz()[..., 1], result.rgb() @ LUMINANCE, rtol=1e-5)


def test_another_white_may_be_chosen():
    result = lit_by("A", Bands.gaussian(6))
    asis = result.rgb(white="D65")[0, 0]
    np.testing.assert_allclose(asis, result.projection().matrix @ result.radiance[0, 0], rtol=1e-6)
    assert asis[0] > 1.5 * asis[1] > 4.0 * asis[2]
    np.testing.assert_allclose(result.rgb(white="A"), result.rgb(), rtol=1e-6)
    np.testing.assert_allclose(result.rgb(white=pm.emission("A")), result.rgb(), rtol=1e-6)
    without = Result(result.buffers, {}, result.bands, {"scene": {"spectra": True}})
    np.testing.assert_array_equal(without.rgb()[0, 0], asis)
    with pytest.raises(InputError, match="there is no light 'D66'"):
        result.rgb(white="D66")
    assert (result.preview(white="D65") != result.preview()).any()


def picture(radiance, emission=0.0):
    """Return a result of these (h, w) values in all three channels."""
    radiance = np.atleast_2d(np.asarray(radiance, np.float32))
    emission = np.broadcast_to(np.asarray(emission, np.float32), radiance.shape)
    images = {"radiance": radiance, "emission": emission}
    images = {name: np.repeat(image[..., None], 3, axis=-1) for name, image in images.items()}
    return Result(images, {}, Bands.rgb(), {})


@pytest.mark.parametrize("name", [*BANDED, *FLAT])
def test_every_buffer_is_an_attribute(name):
    result = make()
    assert getattr(result, name) is result.buffers[name]
    assert inspect.getdoc(getattr(Result, name)).startswith("(H, W")
    rest = result.select(result.buffers.keys() - {name})
    assert not hasattr(rest, name)
    with pytest.raises(AttributeError, match=f"'{name}' was not among the buffers written; "):
        getattr(rest, name)


def test_size_is_width_and_height_whatever_was_written():
    result = make()
    assert result.size == (W, H)
    assert result.select(["object_id"]).size == (W, H)
    assert repr(result.select(["depth"])) == "<Result 5 × 4, RGB: depth>"


@pytest.mark.parametrize(
    "method",
    ["rgb", "xyz", "luminance", "plot", "select"]
    + ["standard_error", "block_mean", "block_error", "bias"],
)
def test_a_wrong_name_is_one_kind_of_error_in_every_method(method):
    with pytest.raises(InputError, match="'glow'"):
        getattr(make(), method)("glow")


def test_buffers_of_data_sets_are_told_from_those_of_a_render():
    for name, more in (("illuminant", ", or take result.illuminant"), ("valid", "")):
        message = f"'{name}' is a buffer of data sets; dataset.with_derived adds it{more}$"
        with pytest.raises(InputError, match=message):
            make().rgb(name)


def test_a_selection_shares_memory_and_takes_the_errors_along():
    result = make()
    part = result.select(["depth", "direct"])
    assert list(part.buffers) == ["depth", "direct"]
    assert part.errors == {"direct": result.errors["direct"]}
    assert part.direct is result.direct
    for names, message in ([["direct", "glow"], "'glow' was not"], [[], "no buffer was chosen"]):
        with pytest.raises(InputError, match=message):
            result.select(names)


def test_a_standard_error_is_given_or_its_absence_explained():
    result = make()
    steady = smooth_error(result.errors["direct"], result.direct, 2, PRIORS["direct"])
    np.testing.assert_array_equal(result.standard_error("direct"), steady)
    once = Result(result.buffers, {}, result.bands, {})
    for source, name, message in (
        (result, "depth", "'depth' has no standard error; 'radiance', 'emission', 'direct', "),
        (result, "glow", "'glow' was not among the buffers written; choose from 'radiance', "),
        (once, "direct", "a single pass has no standard errors; render with 2 passes or more"),
    ):
        for ask in (source.standard_error, source.degrees_of_freedom):
            with pytest.raises(ValueError, match=message):
                ask(name)


@every
def test_the_residual_of_lambertian_surfaces_is_zero(bands):
    residual = make(bands).residual
    assert residual.shape == (H, W, bands.count)
    assert residual.dtype == np.float32
    assert not residual.any()


@every
def test_shading_is_its_mean_times_the_colour_of_the_light(bands):
    shading = make(bands).shading
    shading[0] = 0.0
    shading[1] *= np.float32(1e-40)  # denormal: divides as well as any
    shading[2, :, 1:] = 0.0  # light in one band only
    result = make(bands, shading=shading)
    mean, colour = result.scalar_shading, result.illuminant
    assert (mean.shape, mean.dtype) == ((H, W), np.float32)
    assert (colour.shape, colour.dtype) == ((H, W, bands.count), np.float32)
    assert colour.mask[0].all()
    assert not colour.mask[1:].any()
    assert not colour.data[0].any()
    np.testing.assert_allclose(colour[1:].mean(axis=-1), 1.0, rtol=1e-6)
    np.testing.assert_allclose(mean[2:, :, None] * colour.data[2:], shading[2:], rtol=1e-6)


@every
def test_colours_come_from_the_matrix_of_the_bands(bands):
    result = make(bands)
    for name in LIGHT:
        rgb = result.rgb(name)
        assert (rgb.shape, rgb.dtype) == ((H, W, 3), np.float32)
        np.testing.assert_allclose(
            rgb, result.buffers[name] @ result.projection().matrix.T, rtol=1e-6
        )
    if bands.is_rgb:
        np.testing.assert_array_equal(result.rgb(), result.radiance)


@every
def test_a_perfect_diffuser_is_white_and_greys_keep_their_value(bands):
    grey = np.full((H, W, bands.count), 0.25, np.float32)
    np.testing.assert_allclose(make(bands, reflectance=grey).rgb("reflectance"), 0.25, rtol=1e-6)


def test_a_red_surface_is_red():
    bands = Bands.gaussian(31)
    red = bands.average(upsample_reflectance((0.8, 0.1, 0.1))).astype(np.float32)
    image = np.broadcast_to(red, (H, W, bands.count))
    r, g, b = make(bands, reflectance=image).rgb("reflectance")[0, 0]
    assert r > 0.6 > 0.2 > max(g, b)


def test_light_beyond_float32_is_cut_and_only_bands_have_a_colour():
    huge = np.full((H, W, 6), np.finfo(np.float32).max)
    rgb = make(Bands.gaussian(6), radiance=huge).rgb()
    assert rgb[0, 0, 0] == np.finfo(np.float32).max
    assert np.isfinite(rgb).all()
    for name, message in {
        "glow": "'glow' was not among",
        "depth": "'depth' has no bands",
        "normal": "'normal' has no bands",
    }.items():
        with pytest.raises(ValueError, match=message):
            make().rgb(name)


def test_a_preview_sets_the_99th_percentile_of_lit_pixels_to_four_fifths():
    values = np.linspace(0.01, 1.0, 100)  # its 99th percentile is 0.9901
    for scale in (1e-30, 1.0, 1e30):
        result = picture(scale * values)
        assert result.exposure * scale == pytest.approx(0.8 / 0.9901)
    coded = [255.0 * (1.055 * v ** (1 / 2.4) - 0.055) for v in (0.8 * values / 0.9901)[10:]]
    np.testing.assert_array_equal(result.preview()[0, 10:, 1], np.rint(coded))


@pytest.mark.parametrize(
    ("radiance", "emission", "exposure", "preview"),
    [
        ([0.0, 0.0], 0.0, 1.0, [0, 0]),  # all black
        ([0.0, 0.0], [0.0, 1.0], 1.0, [0, 0]),
        ([2.0, 2.0], 1.0, 0.4, [231, 231]),  # all emissive
        ([4.0, 0.0], [4.0, 0.0], 0.2, [231, 0]),  # a lamp in the void
        ([1.0, 100.0], [0.0, 100.0], 0.8, [231, 255]),  # a lamp does not count
        ([5.0] + 999 * [0.0], 0.0, 0.16, [231] + 999 * [0]),  # nor does the void
        ([1e-45], 0.0, 0.8 / np.float64(np.float32(1e-45)), [231]),
        ([-1.0], 0.0, 1.0, [0]),
        ([np.nan, 1.0], 0.0, 0.8, [0, 231]),
    ],
)
def test_previews_of_odd_images(radiance, emission, exposure, preview):
    result = picture(radiance, emission)
    image = result.preview()
    assert result.exposure == pytest.approx(exposure, rel=1e-6)
    assert (image.shape, image.dtype) == ((1, len(radiance), 3), np.uint8)
    np.testing.assert_array_equal(image[0], np.repeat(np.array(preview)[:, None], 3, axis=1))


def test_a_preview_does_without_emission():
    both = picture([1.0, 100.0], [0.0, 100.0])
    assert both.select(["radiance"]).exposure == pytest.approx(0.8 / 99.01)


def test_jupyter_shows_the_preview_where_there_is_one():
    result = picture(np.random.default_rng(1).random((7, 3)))
    assert result._repr_png_() == encode_png(result.preview())
    assert make().select(["depth"])._repr_png_() is None


def test_a_png_is_what_its_standard_says():
    image = np.random.default_rng(1).integers(0, 256, (3, 2, 3), np.uint8)
    data = encode_png(image)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    chunks, at = {}, 8
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind, content = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        assert struct.unpack_from(">I", data, at + 8 + length) == (zlib.crc32(kind + content),)
        chunks[kind], at = content, at + 12 + length
    assert list(chunks) == [b"IHDR", b"sRGB", b"IDAT", b"IEND"]
    lines = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(3, -1)
    np.testing.assert_array_equal(lines[:, 0], 2)
    np.testing.assert_array_equal(
        lines[:, 1:].cumsum(axis=0, dtype=np.uint8).reshape(3, 2, 3), image
    )


def test_images_of_one_result_have_one_size():
    with pytest.raises(InputError, match=r"'shading' has shape \(5, 5, 3\), not \(4, 5, 3\)"):
        make(shading=np.zeros((5, 5, 3), np.float32))
    with pytest.raises(InputError, match=r"'direct' has shape \(4, 5, 2\)"):
        make(direct=np.zeros((H, W, 2), np.float32))


IMAGE = np.zeros((H, W, 3), np.float32)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"buffers": {"radiance": 3}}, r"buffer 'radiance' has shape \(\), not \(H, W\) or"),
        ({"buffers": {"radiance": [[1], [1, 2]]}}, "'radiance' has lines of different lengths"),
        ({"buffers": {"radiance": 1j * IMAGE}}, "'radiance' is of type complex64; give real"),
        ({"buffers": {"radiance": [["a"]]}}, "'radiance' is of type <U1; give real numbers"),
        ({"buffers": [IMAGE]}, "go by no names; give arrays in a dictionary"),
        ({"errors": None}, "errors None go by no names"),
        ({"errors": {"mine": IMAGE}}, r"error 'mine' has shape \(4, 5, 3\), not \(4, 5\)"),
        ({"errors": {"radiance": IMAGE[1:]}}, r"error 'radiance' .* not \(4, 5, 3\)"),
        ({"block_errors": {"radiance": IMAGE}}, r"block error 'radiance' .* not \(1, 1, 3\)"),
        ({"bands": 3}, r"bands 3 are no photonmap.Bands; take Bands.parse"),
        ({"record": None}, "record None is no dictionary"),
        ({"record": {"of": {1}}}, r"the record has \{1\}, which JSON cannot hold"),
    ],
)
def test_what_does_not_go_together_is_refused(changed, message):
    buffers = {"radiance": IMAGE, "mine": IMAGE[..., 0]}
    right = {"buffers": buffers, "errors": {}, "bands": Bands.rgb(), "record": {}}
    with pytest.raises(InputError, match=message):
        Result(**right | changed)


def test_lists_and_numpys_numbers_are_taken_as_they_are_meant(tmp_path):
    record = {"exposed": np.float32(0.5), "white": np.ones(3), "of": [np.int64(2)]}
    result = Result({"radiance": IMAGE.tolist()}, {}, Bands.rgb(), record)
    np.testing.assert_array_equal(result.radiance, IMAGE)
    result.save(tmp_path / "mine.exr")
    again = pm.load_result(tmp_path / "mine.exr").record
    assert again == {"exposed": 0.5, "white": [1.0, 1.0, 1.0], "of": [2]}
