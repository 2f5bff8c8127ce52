"""What image files state of their pixels is applied, or named in a warning, or refused."""

import io
import struct

import numpy as np
import pytest
from helpers.image_files import (
    RESOLUTIONS,
    STORED,
    curve_tag,
    icc_profile,
    parametric_tag,
    with_chunks,
    write_image,
    write_radiance,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import photonmap as pm
from photonmap.io.readers.decoding import read_embedded
from photonmap.io.readers.usd.materials import _channel
from photonmap.scene.images import read_channels, read_mask, read_panorama, read_texture
from photonmap.spectra.rgb_spaces import decode_srgb, encode_srgb

FIXTURE = (HealthCheck.function_scoped_fixture,)
AP0 = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)
AP0_TO_SRGB = [
    [2.52169, -1.13413, -0.38756],
    [-0.27648, 1.37272, -0.09624],
    [-0.01538, -0.15298, 1.16835],
]
"""As the Academy's transforms have it, with Bradford's adaptation."""
P3_TO_SRGB = [[1.22494, -0.22494, 0], [-0.04206, 1.04206, 0], [-0.01964, -0.07864, 1.09827]]
"""Of one white, D65."""
ADOBE_UNDER_D50 = [
    [0.60974, 0.20528, 0.14919],
    [0.31111, 0.62567, 0.06322],
    [0.01947, 0.06087, 0.74457],
]
"""XYZ of its primaries in columns, as in its ICC profile."""
SRGB_UNDER_D50 = [
    [0.43607, 0.38515, 0.14307],
    [0.22249, 0.71687, 0.06061],
    [0.01392, 0.09708, 0.71410],
]
XYZ_OF_SRGB = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
COLOR = np.array([0.5, 0.4, 0.3])


def flat(rgb=COLOR, height=2, width=4):
    """A picture of one colour."""
    return np.broadcast_to(np.asarray(rgb, np.float32), (height, width, len(rgb)))


def coded(rgb=COLOR, bits=8):
    """The same in integers, encoded in sRGB, but for alpha in a fourth channel."""
    values = np.array([*encode_srgb(np.asarray(rgb)[:3]), *rgb[3:]])
    kind = np.uint8 if bits == 8 else np.uint16
    return np.rint(flat(values).astype(float) * (2**bits - 1)).astype(kind)


def texels(path, linear=False):
    return read_texture(path, linear).linear(slice(None), slice(None))


# --- orientation --------------------------------------------------------------------------

FILES = ("hdr", "exr", "tif", "png", "jpg")
"""Formats that state an orientation; a JPEG file's pixels are only nearly what was written."""


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=FIXTURE)
@given(
    suffix=st.sampled_from(FILES), number=st.integers(0, 7), half=st.integers(1, 5),
    seed=st.integers(0, 99),
)  # fmt: skip
def test_pictures_are_upright(tmp_path, suffix, number, half, seed):
    """In every orientation, format and size: as textures, data, masks, indices and as skies."""
    height, width = half, 2 * half
    corners = np.random.default_rng(seed).integers(0, 2, (height, width)).astype(np.float32)
    corners[0, 0], corners[-1, -1], corners[0, -1] = 1.0, 0.0, 0.0
    picture = np.repeat(corners[..., None], 3, axis=2)
    path = tmp_path / f"a.{suffix}"
    if suffix == "hdr":
        write_radiance(path, picture, RESOLUTIONS[number])
    else:
        stored = STORED[number + 1](picture)
        if suffix != "exr":
            stored = (stored * 255).astype(np.uint8)
        kind = "float" if suffix == "exr" else "uint8"
        write_image(path, stored, kind, Orientation=number + 1, CompressionQuality=100)
    near = {"atol": 0.3 if suffix == "jpg" else 0.01}
    np.testing.assert_allclose(texels(path), picture, **near)
    np.testing.assert_allclose(read_panorama(path), picture, **near)
    green = read_channels(path).green().linear(slice(None), 0)
    np.testing.assert_array_equal(green[..., 0] > 0.5, corners[:, 0] > 0.5)
    np.testing.assert_allclose(read_mask(path), corners, **near)
    of_usd = _channel(read_channels(path), "r", False).linear(slice(None), slice(None))
    np.testing.assert_allclose(of_usd[..., 0], corners, **near)
    if suffix in ("png", "jpg"):  # of glTF, whose specification has orientations ignored
        as_stored = read_embedded(path.read_bytes(), path.name, as_stored=True).data()
        shown = as_stored.linear(slice(None), slice(None))
        np.testing.assert_allclose(shown, STORED[number + 1](picture), **near)


def test_orientations_are_those_of_pillow(tmp_path):
    pillow, ops = pytest.importorskip("PIL.Image"), pytest.importorskip("PIL.ImageOps")
    pixels = np.random.default_rng(3).integers(0, 255, (3, 5, 3), np.uint8)
    for number in range(1, 9):
        path = write_image(tmp_path / "a.tif", pixels, "uint8", Orientation=number)
        upright = np.asarray(ops.exif_transpose(pillow.open(path)))
        np.testing.assert_array_equal(read_texture(path).texels, upright)


def test_indices_are_upright(tmp_path):
    index = np.arange(6, dtype=np.uint8).reshape(2, 3)
    path = write_image(tmp_path / "a.png", STORED[6](index)[..., None], "uint8", Orientation=6)
    palette = [(value / 8,) * 3 for value in range(6)]
    np.testing.assert_array_equal(pm.SpectralTexture.from_palette(path, palette).index, index)


# --- Radiance -----------------------------------------------------------------------------


def test_radiance_headers(tmp_path):
    def read(header, rgb=COLOR, **options):
        return read_panorama(
            write_radiance(tmp_path / "a.hdr", flat(rgb), header=header, **options)
        )

    np.testing.assert_allclose(read("")[0, 0], COLOR, rtol=0.02)
    twice = "EXPOSURE=4\nEXPOSURE= 0.5\nCOLORCORR=1 2 4\n\tEXPOSURE=100\nPIXASPECT=1\n"
    np.testing.assert_allclose(read(twice)[0, 0], COLOR / 2 / [1, 2, 4], rtol=0.02)
    p3 = "PRIMARIES=0.680 0.320 0.265 0.690 0.150 0.060 0.3127 0.3290\n"
    np.testing.assert_allclose(read(p3)[0, 0], P3_TO_SRGB @ COLOR, rtol=0.02)
    own = "PRIMARIES= 0.640 0.330 0.290 0.600 0.150 0.060 0.333 0.333\n"
    np.testing.assert_allclose(read(own, (0.5, 0.5, 0.5))[0, 0], 0.5, rtol=0.01)
    xyz = read("", np.array(XYZ_OF_SRGB) @ COLOR, kind="xyze")
    np.testing.assert_allclose(xyz[0, 0], COLOR, rtol=0.03)
    np.testing.assert_allclose(read("GAMMA=2\n")[0, 0], COLOR**2, rtol=0.04)
    with pytest.warns(pm.SceneWarning, match="states pixels 2 times as wide as high; the map is"):
        read("PIXASPECT=0.5\n")
    for bad in ("EXPOSURE=0", "EXPOSURE=x", "COLORCORR=1 1", "PRIMARIES=1 0 0 1"):
        name = bad.partition("=")[0]
        with pytest.raises(pm.InputError, match=rf"a\.hdr: {name}='.+' in its header; write \d"):
            read(bad + "\n")


def test_a_sky_from_below_lights_the_floor(tmp_path):
    """A sky of 4 above 0.5, stored from its bottom line: the upper half alone lights a floor."""
    picture = np.full((4, 8, 3), 0.5, np.float32)
    picture[:2] = 4.0
    path = write_radiance(tmp_path / "a.hdr", picture, "+Y {h} +X {w}", "EXPOSURE=2\n")
    np.testing.assert_array_equal(read_panorama(path), picture / 2)


# --- spaces of colours --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("attributes", "matrix"),
    [
        ({"chromaticities": AP0}, AP0_TO_SRGB),
        ({"oiio__ColorSpace": "lin_ap0_scene"}, AP0_TO_SRGB),
        ({"oiio__ColorSpace": "lin_p3d65_scene"}, P3_TO_SRGB),
        ({"chromaticities": (1, 0, 0, 1, 0, 0, 1 / 3, 1 / 3)}, np.linalg.inv(XYZ_OF_SRGB)),
        ({"chromaticities": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)}, np.eye(3)),
        ({"oiio__ColorSpace": "lin_rec709_scene"}, np.eye(3)),
        ({}, np.eye(3)),
    ],
)
def test_primaries_of_openexr(tmp_path, attributes, matrix):
    """Textures and skies are converted, data and rays are not."""
    path = write_image(tmp_path / "a.exr", flat(), **attributes)
    np.testing.assert_allclose(texels(path)[0, 0], np.array(matrix) @ COLOR, atol=2e-4)
    np.testing.assert_allclose(read_panorama(path)[0, 0], np.array(matrix) @ COLOR, atol=2e-4)
    np.testing.assert_array_equal(texels(path, linear=True)[0, 0], COLOR.astype(np.float32))
    np.testing.assert_array_equal(read_channels(path).red().texels, np.float32(0.5))
    luminance = COLOR @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(read_mask(path), luminance, rtol=1e-5)
    white = texels(write_image(tmp_path / "w.exr", flat((1, 1, 1)), **attributes))[0, 0]
    if attributes.get("chromaticities", (0,))[0] != 1:
        np.testing.assert_allclose(white, 1.0, atol=1e-5)


@pytest.mark.parametrize(
    ("chunks", "expected"),
    [
        ({}, decode_srgb),
        ({b"sRGB": b"\0", b"gAMA": struct.pack(">I", 100000)}, decode_srgb),
        ({b"gAMA": struct.pack(">I", 45455)}, decode_srgb),
        ({b"gAMA": struct.pack(">I", 100000)}, lambda stored: stored),
        ({b"gAMA": struct.pack(">I", 55556)}, lambda stored: stored**1.8),
        (
            {b"cHRM": struct.pack(">8I", 31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000)},
            lambda stored: np.array(P3_TO_SRGB) @ decode_srgb(stored),
        ),
        ({b"cICP": bytes((12, 8, 0, 1)), b"sRGB": b"\0"}, lambda stored: P3_TO_SRGB @ stored),
    ],
)
def test_chunks_of_png(tmp_path, chunks, expected):
    for bits, kind in ((8, "uint8"), (16, "uint16")):
        pixels = coded(bits=bits)
        path = with_chunks(write_image(tmp_path / "a.png", pixels, kind), chunks)
        wanted = expected(pixels[0, 0] / (2**bits - 1.0))
        np.testing.assert_allclose(texels(path)[0, 0], wanted, rtol=2e-4)
        raw = texels(path, linear=True)[0, 0]
        np.testing.assert_allclose(raw, pixels[0, 0] / (2**bits - 1.0), rtol=1e-6)


def test_tags_of_tiff(tmp_path):
    """PrimaryChromaticities, WhitePoint and TransferFunction, which OpenImageIO leaves out."""
    pillow, tiff = pytest.importorskip("PIL.Image"), pytest.importorskip("PIL.TiffImagePlugin")
    tags = tiff.ImageFileDirectory_v2()
    corners = (0.68, 0.32, 0.265, 0.69, 0.15, 0.06)
    tags[319] = tuple(tiff.IFDRational(round(1000 * each), 1000) for each in corners)
    tags[318] = (tiff.IFDRational(3127, 10000), tiff.IFDRational(3290, 10000))
    tags[301] = tuple(round(65535 * (level / 255) ** 1.5) for level in range(256))
    tags.tagtype |= {319: 5, 318: 5, 301: 3}
    pillow.fromarray(coded()).save(tmp_path / "a.tif", tiffinfo=tags)
    wanted = P3_TO_SRGB @ (coded()[0, 0] / 255) ** 1.5
    np.testing.assert_allclose(texels(tmp_path / "a.tif")[0, 0], wanted, atol=1e-4)
    np.testing.assert_array_equal(read_texture(tmp_path / "a.tif", linear=True).texels, coded())


CURVES = {
    "line": (curve_tag(), lambda v: v),
    "power": (curve_tag(2.2), lambda v: v**2.19921875),
    "table": (curve_tag(0.0, 0.25, 1.0), lambda v: np.interp(v, [0, 0.5, 1], [0, 0.25, 1])),
    "type 0": (parametric_tag(0, 1.8), lambda v: v**1.8),
    "type 1": (parametric_tag(1, 2.0, 1.2, -0.2), lambda v: np.maximum(1.2 * v - 0.2, 0) ** 2),
    "type 2": (
        parametric_tag(2, 2.0, 0.8, -0.2, 0.1),
        lambda v: np.maximum(0.8 * v - 0.2, 0) ** 2 + 0.1,
    ),
    "type 3": (parametric_tag(3, 2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045), decode_srgb),
    "type 4": (
        parametric_tag(4, 2.0, 0.9, 0.0, 0.5, 0.2, 0.1, 0.05),
        lambda v: np.where(v >= 0.2, (0.9 * v) ** 2 + 0.1, 0.5 * v + 0.05),
    ),
}


@pytest.mark.parametrize("name", CURVES)
def test_icc_profiles(tmp_path, name):
    """Curves of each kind, with the primaries of sRGB, in each format that holds profiles."""
    tag, decode = CURVES[name]
    profile = icc_profile([tag] * 3, np.array(SRGB_UNDER_D50))
    for suffix in ("png", "tif"):
        path = write_image(tmp_path / f"a.{suffix}", coded(), "uint8", ICCProfile=profile)
        wanted = decode(coded()[0, 0] / 255)
        np.testing.assert_allclose(texels(path)[0, 0], wanted, atol=3e-4)
        np.testing.assert_array_equal(read_texture(path, linear=True).texels, coded())
    grey = icc_profile([tag], kind=b"GRAY")
    path = write_image(tmp_path / "g.tif", coded()[..., :1], "uint8", ICCProfile=grey)
    np.testing.assert_allclose(texels(path)[0, 0], wanted[0], atol=3e-4)
    assert read_texture(path).texels.shape == (2, 4, 3)


def test_icc_profiles_are_read_as_by_littlecms(tmp_path):
    """Adobe RGB of colours within sRGB, in bytes, by the perceptual and the colorimetric intent."""
    cms, pillow = pytest.importorskip("PIL.ImageCms"), pytest.importorskip("PIL.Image")
    profile = icc_profile([curve_tag(2.2)] * 3, np.array(ADOBE_UNDER_D50))
    pixels = np.random.default_rng(2).integers(90, 160, (4, 8, 3), np.uint8)
    path = write_image(tmp_path / "a.jpg", pixels, "uint8", ICCProfile=profile)
    decoded = np.asarray(pillow.open(path))
    image, srgb = pillow.fromarray(decoded), cms.createProfile("sRGB")
    there = cms.profileToProfile(image, cms.ImageCmsProfile(io.BytesIO(profile)), srgb)
    np.testing.assert_allclose(encode_srgb(texels(path)) * 255, np.asarray(there), atol=1.0)
    own = cms.ImageCmsProfile(srgb).tobytes()
    path = write_image(tmp_path / "b.png", pixels, "uint8", ICCProfile=own)
    assert read_texture(path).srgb
    np.testing.assert_array_equal(read_texture(path).texels, pixels)


def test_what_is_not_applied_is_named(tmp_path):
    def warned(path, *texts):
        with pytest.warns(pm.SceneWarning) as issued:
            read_texture(path)
        assert [all(text in str(each.message) for text in texts) for each in issued] == [True]

    tables = icc_profile([curve_tag()], kind=b"CMYK")
    path = write_image(tmp_path / "a.tif", coded(), "uint8", ICCProfile=tables)
    warned(path, "a.tif: its ICC profile of tables (CMYK) is not applied", "taken as sRGB")
    path = write_image(tmp_path / "b.tif", coded(), "uint8", ICCProfile=tables[:140])
    warned(path, "b.tif: its ICC profile is damaged; its colours are taken as sRGB")
    path = write_image(tmp_path / "c.exr", flat(), whiteLuminance=100.0)
    warned(path, "c.exr: its luminance of white, 100 cd/m² (whiteLuminance), is not used")
    path = with_chunks(
        write_image(tmp_path / "d.png", coded(), "uint8"), {b"cICP": b"\x17\x07\0\1"}
    )
    warned(path, "primaries of code 23 (CICP) are not known", "the transfer of code 7 (CICP) is")
    path = write_image(tmp_path / "g.jpg", coded(), "uint8", Exif__ColorSpace=65535)
    warned(path, "g.jpg: its space is uncalibrated (Exif), often Adobe RGB; its colours are taken")
    path = write_image(tmp_path / "e.exr", flat((0.0, 1.0, 0.5)), chromaticities=AP0)
    warned(path, "e.exr: 8 of its 8 colours lie outside sRGB; clipped")
    np.testing.assert_array_equal(texels(path, linear=True)[0, 0], [0.0, 1.0, 0.5])
    path = write_image(tmp_path / "h.exr", flat(), PixelAspectRatio=2.0)
    with pytest.warns(pm.SceneWarning, match="states pixels 2 times as wide as high; the map"):
        read_panorama(path)
    path = write_image(tmp_path / "i.exr", flat(), textureformat="LatLong Environment")
    with pytest.warns(pm.SceneWarning, match=r"lie on the poles and the seam \(envmap\)"):
        read_panorama(path)
    ink = np.full((2, 4, 4), 99, np.uint8)
    path = write_image(
        tmp_path / "f.tif", ink, "uint8", oiio__ColorSpace="CMYK", tiff__ColorSpace="CMYK"
    )
    warned(path, "its inks (CMYK) are turned into RGB without a profile")


def test_what_cannot_be_read_is_refused(tmp_path):
    path = with_chunks(
        write_image(tmp_path / "a.png", coded(), "uint8"), {b"cICP": b"\x09\x10\0\1"}
    )
    with pytest.raises(pm.InputError, match="is encoded for displays, in PQ; save it as EXR"):
        read_texture(path)
    assert read_texture(path, linear=True)
    path = write_image(tmp_path / "b.exr", flat(), chromaticities=(0.3,) * 8)
    with pytest.raises(pm.InputError, match=r"b\.exr: states primaries and a white that span no"):
        read_texture(path)
    path = write_image(tmp_path / "c.exr", flat(), textureformat="CubeFace Environment")
    with pytest.raises(pm.InputError, match="shows the faces of a cube; save it by latitude"):
        read_panorama(path)
    names = ("R", "G", "B", "AR")
    path = write_image(tmp_path / "d.exr", flat((1, 1, 1, 1)), channels=names)
    with pytest.raises(pm.InputError, match="has an alpha for each colour"):
        read_texture(path)


# --- alpha --------------------------------------------------------------------------------


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=FIXTURE)
@given(
    suffix=st.sampled_from(["png", "tif", "associated tif", "exr", "tga"]),
    alphas=st.lists(st.sampled_from([0.0, 0.2, 0.4, 0.6, 0.8, 1.0]), min_size=8, max_size=8),
)
def test_alpha_is_divided_out(tmp_path, suffix, alphas):
    """One colour under any alpha is that colour, also where alpha is 0, whatever the format."""
    alpha = np.reshape(alphas, (2, 4, 1)).astype(np.float32)
    kind, path = suffix.rpartition(" ")[2], tmp_path / f"a.{suffix.rpartition(' ')[2]}"
    is_associated = suffix in ("associated tif", "exr")
    color = flat() if kind == "exr" else encode_srgb(flat())
    pixels = np.concatenate([color * alpha if is_associated else color, alpha], axis=2)
    if kind == "exr":
        write_image(path, pixels.astype(np.float32))
    else:
        straight = {} if is_associated else {"oiio__UnassociatedAlpha": 1}
        write_image(path, np.rint(pixels * 255).astype(np.uint8), "uint8", **straight)
    known = np.broadcast_to(alpha > 0, (2, 4, 1)) | (alpha.max() > 0) | (not is_associated)
    near = {"rtol": 0.08 if suffix == "associated tif" else 0.02}
    np.testing.assert_allclose(texels(path) * known, COLOR * known, **near)
    if kind == "exr":
        raw = read_channels(path).green().texels * known
        np.testing.assert_allclose(raw, COLOR[1] * known, rtol=1e-6)
    readings = [read_channels(path)]  # and of glTF
    readings += [read_embedded(path.read_bytes(), path.name, as_stored=True)] * (kind == "png")
    for channels in readings:
        np.testing.assert_allclose(channels.alpha(), alpha[..., 0], atol=1e-6)
        of_usd = [_channel(channels, output, kind != "exr") for output in ("a", "rgb")]
        found, straight = (image.linear(slice(None), slice(None)) for image in of_usd)
        np.testing.assert_allclose(found, alpha, atol=1e-6)
        np.testing.assert_allclose(straight * known, COLOR * known, **near)
    if (alpha < 1).any():
        with pytest.warns(pm.SceneWarning, match="pixels of light have an alpha below 1: it dims"):
            light = read_panorama(path)
        np.testing.assert_allclose(light, COLOR * alpha, **near)


def test_light_without_cover_stays(tmp_path):
    pixels = np.concatenate([flat(), np.zeros((2, 4, 1), np.float32)], axis=2)
    path = write_image(tmp_path / "a.exr", pixels)
    np.testing.assert_array_equal(texels(path), flat())
    with pytest.warns(pm.SceneWarning, match="8 pixels of light"):
        np.testing.assert_array_equal(read_panorama(path), flat())


def test_a_channel_of_unknown_meaning_is_named(tmp_path):
    """TIFF's ExtraSamples 0, as older programs wrote alpha; and further pages."""
    path = write_image(tmp_path / "a.tif", coded((*COLOR, 0.4)), "uint8", oiio__UnassociatedAlpha=1)
    data = bytearray(path.read_bytes())
    (start,) = struct.unpack_from("<I", data, 4)
    (count,) = struct.unpack_from("<H", data, start)
    for at in range(start + 2, start + 2 + 12 * count, 12):
        if struct.unpack_from("<H", data, at) == (338,):
            struct.pack_into("<H", data, at + 8, 0)
    path.write_bytes(data)
    with pytest.warns(pm.SceneWarning, match="does not say what its last channel is"):
        np.testing.assert_array_equal(read_texture(path).texels, coded())


def test_scenes_of_other_formats_warn_too(tmp_path):
    """A warning about an image is not lost where a reader silences what libraries say."""
    names = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n"
    (tmp_path / "a.obj").write_text(names)
    (tmp_path / "a.mtl").write_text("newmtl m\nmap_Kd a.exr\n")
    write_image(tmp_path / "a.exr", flat(), whiteLuminance=100.0)
    with pytest.warns(pm.SceneWarning, match="whiteLuminance"):
        pm.load_scene(tmp_path / "a.obj")
