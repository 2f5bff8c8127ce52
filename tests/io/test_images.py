import numpy as np
import pytest

from photonmap.errors import InputError
from photonmap.io.readers.obj.mtl import MapOptions, parse_map
from photonmap.scene.images import Image, decode_srgb, read_mask, read_texture


@pytest.fixture
def write(tmp_path):
    """Write pixels with OpenImageIO."""
    oiio = pytest.importorskip("OpenImageIO")

    def write(name, pixels, kind="uint8", channels=None, **attributes):
        height, width, count = pixels.shape
        spec = oiio.ImageSpec(width, height, count, kind)
        spec.attribute("oiio:UnassociatedAlpha", 1)
        if channels:
            spec.channelnames = channels
        for key, value in attributes.items():
            setattr(spec, key, value)
        path = tmp_path / name
        file = oiio.ImageOutput.create(str(path))
        assert file.open(str(path), spec), file.geterror()
        assert file.write_image(np.ascontiguousarray(pixels)), file.geterror()
        file.close()
        return path

    return write


def some(channels, kind=np.uint8, height=5, width=7):
    """Pixels that differ, in rows, columns and channels."""
    shape = (height, width, channels)
    if kind is np.float32:
        return np.random.default_rng(3).random(shape, np.float32) * 4
    return np.random.default_rng(3).integers(0, np.iinfo(kind).max, shape, kind, True)


def everything(image):
    """All pixels, linear."""
    return image.linear(slice(None), slice(None))


# --- textures -----------------------------------------------------------------------------


def test_srgb_is_that_of_the_standard():
    encoded = np.array([0, 0.04045, 0.5, 1])
    np.testing.assert_allclose(decode_srgb(encoded), [0, 0.0031308, 0.21404114, 1], rtol=1e-4)
    both_sides = decode_srgb(np.nextafter(0.04045, [0, 1]))
    assert both_sides[1] == pytest.approx(both_sides[0], rel=1e-5)


@pytest.mark.parametrize("suffix", ["png", "tif", "bmp", "tga"])
def test_bytes_stay_bytes_and_the_top_row_is_first(write, suffix):
    pixels = some(3)
    image = read_texture(write(f"a.{suffix}", pixels))
    assert (image.texels.dtype, image.srgb) == (np.uint8, True)
    assert image.texels.flags["C_CONTIGUOUS"]
    np.testing.assert_array_equal(image.texels, pixels)
    expected = decode_srgb(pixels / 255).astype(np.float32)
    np.testing.assert_array_equal(everything(image), expected)
    np.testing.assert_array_equal(image.linear([4, 0], [6, 1]), expected[[4, 0], [6, 1]])
    assert image.linear(0, 0).shape == (3,)
    assert image.linear(0, 0).dtype == np.float32


def test_linear_bytes(write):
    image = read_texture(write("a.png", some(3)), linear=True)
    assert (image.texels.dtype, image.srgb) == (np.uint8, False)
    np.testing.assert_array_equal(everything(image), (some(3) / 255).astype(np.float32))


@pytest.mark.parametrize("suffix", ["png", "tif"])
@pytest.mark.parametrize("linear", [False, True])
def test_sixteen_bits(write, suffix, linear):
    pixels = some(3, np.uint16)
    image = read_texture(write(f"a.{suffix}", pixels, "uint16"), linear)
    assert image.texels.dtype == np.float32
    expected = pixels / 65535 if linear else decode_srgb(pixels / 65535)
    np.testing.assert_allclose(everything(image), expected, rtol=2e-6)


@pytest.mark.parametrize("linear", [False, True])
def test_floats_are_linear(write, linear):
    pixels = some(3, np.float32)
    np.testing.assert_array_equal(read_texture(write("a.exr", pixels, "float")).texels, pixels)
    half = read_texture(write("b.exr", pixels, "half"), linear)
    assert (half.texels.dtype, half.srgb) == (np.float32, False)
    np.testing.assert_array_equal(half.texels, pixels.astype(np.float16))
    shared = read_texture(write("a.hdr", pixels, "float"), linear)
    np.testing.assert_allclose(shared.texels, pixels, atol=pixels.max() / 128)
    np.testing.assert_array_equal(everything(shared), shared.texels)


@pytest.mark.parametrize(
    ("name", "channels", "kind"),
    [("a.png", 1, "uint8"), ("a.png", 2, "uint8"), ("a.png", 4, "uint8"), ("a.tga", 4, "uint8")]
    + [("a.png", 2, "uint16"), ("a.exr", 1, "float"), ("a.exr", 4, "float")],
)
def test_grey_is_repeated_and_alpha_left_out(write, name, channels, kind):
    """In OpenEXR alpha has multiplied colours, which are divided by it."""
    pixels = some(channels, {"float": np.float32}.get(kind) or np.dtype(kind).type)
    names = {1: ("Y",), 2: ("Y", "A"), 4: ("R", "G", "B", "A")}[channels]
    image = read_texture(write(name, pixels, kind, names), linear=True)
    colors = pixels[..., :1].repeat(3, 2) if channels < 3 else pixels[..., :3]
    largest = 1 if kind == "float" else np.iinfo(kind).max
    if kind == "float" and channels == 4:
        largest = pixels[..., 3:]
    np.testing.assert_allclose(everything(image), colors / largest, rtol=1e-6)


def test_channels_are_found_by_name(write):
    pixels = some(5, np.float32)
    pixels[..., 3] = 1
    path = write("a.exr", pixels, "float", ("Z", "B", "G", "A", "R"))
    np.testing.assert_array_equal(read_texture(path).texels, pixels[..., [4, 2, 1]])


def test_bytes_take_a_quarter_of_the_memory(write):
    image = read_texture(write("a.png", np.zeros((2048, 64, 4), np.uint8)))
    assert image.texels.nbytes == 2048 * 64 * 3
    assert isinstance(image, Image)
    assert image.texels.base is None


# --- masks --------------------------------------------------------------------------------


def test_mask_is_the_alpha(write):
    for channels in (2, 4):
        mask = read_mask(write("a.png", some(channels)))
        assert (mask.shape, mask.dtype) == ((5, 7), np.float32)
        np.testing.assert_allclose(mask, some(channels)[..., -1] / 255, rtol=1e-6)
    deep = some(4, np.uint16)
    mask = read_mask(write("a.png", deep, "uint16"))
    np.testing.assert_allclose(mask, deep[..., 3] / 65535, rtol=1e-6)


def test_mask_without_alpha_is_the_luminance(write):
    weights = [0.2126, 0.7152, 0.0722]
    path = write("a.png", some(3))
    np.testing.assert_allclose(read_mask(path), decode_srgb(some(3) / 255) @ weights, rtol=1e-5)
    np.testing.assert_allclose(read_mask(path, linear=True), some(3) / 255 @ weights, rtol=1e-5)
    grey = write("g.png", np.array([[[0], [255]]], np.uint8))
    np.testing.assert_allclose(read_mask(grey), [[0, 1]], rtol=1e-6)
    floats = write("a.exr", some(3, np.float32), "float")
    np.testing.assert_allclose(read_mask(floats), some(3, np.float32) @ weights, rtol=1e-5)


# --- errors -------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, -0.5])
@pytest.mark.parametrize("read", [read_texture, read_mask])
def test_bad_values_name_their_pixel(write, read, value):
    pixels = some(3, np.float32)
    pixels[3, 6, 1] = value
    path = write("a.exr", pixels, "float")
    with pytest.raises(InputError, match=rf"a\.exr: pixel in row 3, column 6 has {value:g}; save"):
        read(path)


def test_bad_alpha(write):
    pixels = some(4, np.float32)
    pixels[1, 2, 3] = -1
    path = write("a.exr", pixels, "float")
    for read in (read_texture, read_mask):
        with pytest.raises(InputError, match="row 1, column 2 has -1"):
            read(path)


def test_no_file(tmp_path):
    with pytest.raises(InputError, match=r"none\.png: cannot be read \(No such file"):
        read_texture(tmp_path / "none.png")
    with pytest.raises(InputError, match="is a directory"):
        read_texture(tmp_path)


@pytest.mark.parametrize("suffix", ["png", "jpg", "exr", "hdr", "tif", "bmp", "tga"])
def test_what_is_no_image(write, tmp_path, capfd, suffix):
    kind = "float" if suffix in ("exr", "hdr") else "uint8"
    pixels = some(3, np.float32 if kind == "float" else np.uint8, 60, 60)
    whole = write(f"whole.{suffix}", pixels, kind).read_bytes()
    path = tmp_path / f"a.{suffix}"
    for data, reason in (
        (b"", "is empty"),
        (b"hello\n" * 40, r"cannot be read as an image \(.+\)"),
    ):
        path.write_bytes(data)
        with pytest.raises(InputError, match=rf"a\.{suffix}: {reason}; save"):
            read_texture(path)
    for end in (10, len(whole) // 2):
        path.write_bytes(whole[:end])
        with pytest.raises(InputError, match=r"cannot be read as an image \(.+\)") as caught:
            read_texture(path)
        assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_damaged_png(write, tmp_path, capfd):
    whole = bytearray(write("a.png", some(3, height=50)).read_bytes())
    whole[len(whole) // 2] ^= 1
    (tmp_path / "a.png").write_bytes(whole)
    with pytest.raises(InputError, match=r"a\.png: .*damaged at byte \d+"):
        read_texture(tmp_path / "a.png")
    assert capfd.readouterr() == ("", "")


def test_channels_that_are_no_color(write):
    path = write("a.exr", some(3, np.float32), "float", ("X", "Y", "Z"))
    with pytest.raises(InputError, match="has the channels 'x', 'y', 'z'; save it as RGB or grey"):
        read_texture(path)


def test_part_of_a_picture(write):
    path = write("a.exr", some(3, np.float32), "float", full_width=20)
    with pytest.raises(InputError, match="holds 7x5 pixels of a larger or smaller picture; save"):
        read_texture(path)


# --- options of maps ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "options", "name"),
    [
        ("wood.png", {}, "wood.png"),
        ("my  old wood.png ", {}, "my  old wood.png"),
        ("-s 2 wood.png", {"scale": (2, 1, 1)}, "wood.png"),
        ("-s 2 -3 wood.png", {"scale": (2, -3, 1)}, "wood.png"),
        ("-s 2 3 4 wood.png", {"scale": (2, 3, 4)}, "wood.png"),
        ("-o .5 wood.png", {"offset": (0.5, 0, 0)}, "wood.png"),
        ("-o -1e-1 +2. 0 a b.png", {"offset": (-0.1, 2, 0)}, "a b.png"),
        ("-s 1 1 1 2", {}, "2"),
        ("-s 2 2.png", {"scale": (2, 1, 1)}, "2.png"),
        ("-s 2 -o 1 -s 3 a", {"scale": (3, 1, 1), "offset": (1, 0, 0)}, "a"),
        ("-clamp on a", {"clamp": True}, "a"),
        ("-clamp on -clamp off a", {}, "a"),
        ("-blendu off -blendv off a", {"ignored": ("-blendu", "-blendv")}, "a"),
        ("-blendu on -blendv on -cc off a", {}, "a"),
        ("-cc on a", {"ignored": ("-cc",)}, "a"),
        ("-mm 0 1 -bm 1 -boost 0 -t 0 0 0 a", {}, "a"),
        ("-mm 0.5 2 a", {"ignored": ("-mm",)}, "a"),
        ("-bm 2 -bm 1 a", {}, "a"),
        ("-bm 0.3 -boost 1 -t 1 a", {"bump": 0.3, "ignored": ("-boost", "-t")}, "a"),
        ("-texres 512 a", {"ignored": ("-texres",)}, "a"),
        ("-imfchan m a", {"ignored": ("-imfchan",)}, "a"),
        ("-type sphere a", {"ignored": ("-type",)}, "a"),
        ("-type cube_top -s 2 a", {"ignored": ("-type",), "scale": (2, 1, 1)}, "a"),
    ],
)
def test_map_options(text, options, name):
    assert parse_map(text) == (MapOptions(**options), name)
    assert parse_map(text.split()) == (MapOptions(**options), " ".join(name.split()))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "names no file; write one"),
        ("-s 1 1 1", "names no file"),
        ("-clamp on", "names no file"),
        ("-s wood.png", "-s is followed by 'wood.png'; write one to three numbers after it"),
        ("-o", "-o is followed by nothing; write one to three"),
        ("-s nan a", "-s is followed by 'nan'"),
        ("-s 1_0 a", "-s is followed by '1_0'"),
        ("-s 1e999 a", "-s '1e999' is too large"),
        ("-mm 0 a", "-mm is followed by 'a'; write 2 numbers"),
        ("-mm 0", "-mm is followed by nothing; write 2 numbers"),
        ("-bm a", "-bm is followed by 'a'; write 1 number after it"),
        ("-clamp wood.png", "-clamp is followed by 'wood.png'; write on or off"),
        ("-blendu 1 a", "-blendu is followed by '1'; write on or off"),
        ("-imfchan x a", "-imfchan is followed by 'x'; write r, g, b, m, l or z"),
        ("-type cube a", "-type is followed by 'cube'; write sphere, cube_front"),
        ("-clmap on a", "option '-clmap' is not known; did you mean '-clamp'"),
    ],
)
def test_wrong_map_options(text, message):
    with pytest.raises(InputError) as caught:
        parse_map(text)
    assert str(caught.value).startswith(message)
