"""Textures whose texels are spectra: band values, pictures, files, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import photonmap as pm
from photonmap.errors import InputError
from photonmap.inspection.describe import describe_color
from photonmap.io.envi import write_envi
from photonmap.io.png import encode_png
from photonmap.scene.images import write_image
from photonmap.scene.surfaces.spectral_texture import read_indices, read_spectral_image

AT = np.arange(400.0, 701.0, 10.0)
CHIPS = [pm.reflectance("munsell:5R 4/14"), pm.reflectance("munsell:5G 5/10")]
SMALL = {"size": 16, "passes": 2, "seed": 3, "adaptive": False}
CAMERA = pm.Camera((0.5, 0.5, 1.0), (0.5, 0.5, 0.0), fov=53.13)
LIGHTS = [pm.DomeLight(1.0)]


def cube():
    """A ramp in wavelength whose slope varies over two rows of three texels."""
    slopes = np.array([[0.0, 0.5, 1.0], [1.0, 0.2, 0.7]])
    return 0.1 + 0.8 * slopes[..., None] * (AT - 400.0) / 300.0


def grey(values, kind=np.uint8):
    """Return the bytes of a grey PNG."""
    return encode_png(np.repeat(np.array(values, kind)[..., None], 3, axis=2))


def square(paint):
    """A unit square that fills the image."""
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    uv = np.array(corners)[:, :2]
    mesh = pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], pm.Material("wall", paint), uv=uv)
    return pm.Scene([mesh], LIGHTS, CAMERA)


@pytest.mark.parametrize("bands", ["6", "box:3", "rgb"])
def test_texels_have_the_band_values_of_their_spectra(bands):
    bands = pm.Bands.parse(bands)
    palette = pm.SpectralTexture.from_palette([[1, 0]], CHIPS)
    expected = [bands.reflectance(chip) for chip in CHIPS]
    np.testing.assert_allclose(palette.averages(bands), expected, atol=2e-7)

    values = cube()
    texture = pm.SpectralTexture.from_cube(AT, values)
    curves = values.reshape(-1, len(AT))
    expected = [bands.reflectance(pm.Spectrum(AT, curve)) for curve in curves]
    np.testing.assert_allclose(texture.averages(bands)[texture.index].reshape(6, -1), expected,
                               atol=2e-7)  # fmt: skip


def test_palettes_mix_all_kinds_of_colors():
    bands = pm.Bands.gaussian(6)
    colors = [0.25, (0.8, 0.3, 0.1), CHIPS[0]]
    texture = pm.SpectralTexture.from_palette([[0, 1, 2]], colors)
    expected = [bands.reflectance(color) for color in colors]
    np.testing.assert_allclose(texture.averages(bands), expected, atol=2e-7)


def test_a_palette_of_one_color_is_that_color():
    """A picture by spectra on the surface is that of the same spectrum as a reflectance."""
    texture = pm.SpectralTexture.from_palette(np.zeros((2, 3), int), CHIPS[:1])
    one, other = (pm.render(square(paint), **SMALL) for paint in (texture, CHIPS[0]))
    for name in ("reflectance", "direct", "indirect"):
        np.testing.assert_allclose(one[name], other[name], rtol=2e-6, atol=1e-7)


def test_rows_lie_from_top_to_bottom_and_mix_between():
    """At the centres of texels they are themselves, half way between two the mean."""
    index = np.repeat(np.repeat([[0, 1], [1, 0]], 4, axis=0), 4, axis=1)
    texture = pm.SpectralTexture.from_palette(index, CHIPS, clamp=True)
    result = pm.render(square(texture), pixel="center", **SMALL)
    left, right = (result.bands.reflectance(chip) for chip in CHIPS)
    seen = result.reflectance
    np.testing.assert_allclose(seen[1, 1], left, atol=1e-6)
    np.testing.assert_allclose(seen[1, -2], right, atol=1e-6)
    np.testing.assert_allclose(seen[-2, 1], right, atol=1e-6)
    near = seen[1, 7] + seen[1, 8]
    np.testing.assert_allclose(near, left + right, atol=1e-5)


def test_colors_and_spectra_in_one_scene():
    """Beside textures of colours, and in bands of RGB, spectra stay what they are."""
    index = np.zeros((1, 1), int)
    scene = square(pm.SpectralTexture.from_palette(index, CHIPS[:1]))
    beside = square(pm.Texture.of(np.full((1, 1, 3), [0.2, 0.4, 0.6]))).meshes[0]
    moved = pm.Mesh(beside.vertices + [1, 0, 0], beside.faces, beside.material, uv=beside.uv)
    wide = pm.Camera((1.0, 0.5, 1.0), (1.0, 0.5, 0.0), fov=53.13)
    both = pm.Scene([*scene.meshes, moved], LIGHTS, wide)
    seen = pm.render(both, bands="rgb", **(SMALL | {"size": (32, 16)})).reflectance
    np.testing.assert_allclose(seen[8, 4], pm.Bands.rgb().reflectance(CHIPS[0]), atol=1e-6)
    np.testing.assert_allclose(seen[8, 28], [0.2, 0.4, 0.6], atol=1e-6)


def test_without_texture_coordinates_the_mean_counts():
    texture = pm.SpectralTexture.from_palette([[0, 1, 1, 1]], CHIPS)
    mesh = square(texture).meshes[0]
    bare = pm.Mesh(mesh.vertices, mesh.faces, mesh.material)
    with pytest.warns(pm.SceneWarning, match="mean of their textures"):
        result = pm.render(pm.Scene([bare], LIGHTS, CAMERA), **SMALL)
    left, right = (result.bands.reflectance(chip) for chip in CHIPS)
    np.testing.assert_allclose(result.reflectance[8, 8], 0.25 * left + 0.75 * right, atol=1e-6)


def test_info_and_writers_say_what_becomes_of_spectra(tmp_path):
    scene = square(pm.SpectralTexture.from_cube(AT, cube()))
    texture = describe_color(scene.meshes[0].material.reflectance)["texture"]
    assert (texture["width"], texture["height"], texture["spectra"], texture["samples"]) == (
        3,
        2,
        6,
        31,
    )
    json.dumps(texture)
    for name in ("a.obj", "a.glb"):
        with pytest.warns(pm.SceneWarning) as noted:
            pm.save_scene(scene, tmp_path / name)
        assert any("their colours under D65" in str(warning.message) for warning in noted)


@pytest.fixture
def read(tmp_path):
    """Return a function that reads the reflectance of a TOML scene."""
    (tmp_path / "a.obj").write_text(
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
        "usemtl wall\nf 1/1 2/2 3/3\n"
    )
    (tmp_path / "a.mtl").write_text("newmtl wall\nKd 0.5 0.5 0.5\n")

    def read(keys, attribute="reflectance"):
        (tmp_path / "a.toml").write_text(f"[material.wall]\n{attribute} = {keys}\n")
        return getattr(pm.load_scene(tmp_path / "a.obj").meshes[0].material, attribute)

    return read


def test_toml_reads_palettes(read, tmp_path):
    (tmp_path / "index.png").write_bytes(grey([[0, 1, 1]]))
    texture = read('{ file = "index.png", palette = ["munsell:5R 4/14", 0.3], clamp = true }')
    assert texture.clamp
    np.testing.assert_array_equal(texture.index, [[0, 1, 1]])
    bands = pm.Bands.gaussian(6)
    expected = [bands.reflectance(CHIPS[0]), np.full(6, 0.3)]
    np.testing.assert_allclose(texture.averages(bands), expected, atol=2e-7)


@pytest.mark.parametrize("falling", [False, True])
def test_toml_reads_archives(read, tmp_path, falling):
    order = slice(None, None, -1 if falling else 1)
    np.savez(tmp_path / "wall.npz", wavelengths=AT[order], reflectance=50.0 * cube()[..., order])
    texture = read('{ file = "wall.npz", factor = 0.02, offset = [0.5, 0] }')
    assert texture.offset == (0.5, 0.0)
    np.testing.assert_allclose(texture.spectra.reshape(2, 3, -1), cube(), rtol=1e-6)


@pytest.mark.parametrize("interleave", ["bsq", "bil", "bip"])
def test_toml_reads_envi(read, tmp_path, interleave):
    spectral = pytest.importorskip("spectral")
    spectral.envi.save_image(
        str(tmp_path / "wall.hdr"),
        np.rint(10000 * cube()).astype(np.uint16),
        metadata={
            "wavelength": [at / 1000 for at in AT],
            "wavelength units": "Micrometers",
            "reflectance scale factor": 10000,
        },
        interleave=interleave,
        byteorder=1,
    )
    texture = read('{ file = "wall.hdr" }')
    np.testing.assert_allclose(texture.wavelengths, AT)
    np.testing.assert_allclose(texture.spectra.reshape(2, 3, -1), cube(), atol=6e-5)


UNITS = {
    "Nanometers": 1.0, "nanometre": 1.0, "": 1.0, "Unknown": 1.0, None: 1.0, "Micrometers": 1e3,
    "microns": 1e3, " um": 1e3, "unknown": 1e3, "Angstroms": 0.1, "Meters": 1e9,
}  # fmt: skip
AXES = {"bsq": (2, 0, 1), "bil": (0, 2, 1), "bip": (0, 1, 2)}


def write_header(folder, data=b"", **fields):
    """Write wall.hdr, of 2 × 3 texels by default, and wall.img; None leaves a field out."""
    known = {"samples": 3, "lines": 2, "bands": 4, "data type": 4, "interleave": "bip"}
    known |= {"byte order": 0, "wavelength units": "Nanometers"}
    known |= {"wavelength": "{400, 500, 600, 700}"}
    known |= {key.replace("_", " "): value for key, value in fields.items()}
    rows = [f"{key} = {value}" for key, value in known.items() if value is not None]
    (folder / "wall.hdr").write_text("\n".join(["ENVI", *rows]) + "\n", encoding="utf-8")
    (folder / "wall.img").write_bytes(data)
    return folder / "wall.hdr"


@settings(
    max_examples=80, deadline=None, derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(st.data())
def test_what_envi_headers_may_say(tmp_path, data):
    """Reflectances at wavelengths in nm, whatever the layout, type, unit, gains and bad bands."""
    draw = data.draw
    layout, order = draw(st.sampled_from(list(AXES))), draw(st.sampled_from("<>"))
    kind, offset = (
        draw(st.sampled_from([("u2", 12), ("i4", 3), ("f4", 4), ("f8", 5)])),
        draw(st.integers(0, 40)),
    )
    (unit, nm), is_falling = draw(st.sampled_from(list(UNITS.items()))), draw(st.booleans())
    is_bad = np.array(draw(st.lists(st.booleans(), min_size=6, max_size=6)))
    is_bad[[0, 5]] = False
    at = np.linspace(380.0, 780.0, 6)[:: -1 if is_falling else 1]
    stored = np.random.default_rng(draw(st.integers(0, 99))).integers(1, 9000, (2, 3, 6))
    stored[..., is_bad] = 0
    fields = {"wavelength_units": unit, "bands": 6, "data_type": kind[1], "interleave": layout}
    fields |= {"byte_order": "<>".index(order), "header_offset": offset}
    fields |= {"wavelength": "{ " + ",\n".join(f"{each / nm!r}" for each in at.tolist()) + " }"}
    if is_bad.any():
        fields["bbl"] = "{" + ", ".join(str(int(not bad)) for bad in is_bad) + "}"
        fields["data_ignore_value"] = 0
    if scaled := draw(st.booleans()):
        fields["Reflectance_Scale_factor"] = 10000
    else:
        gains = np.linspace(1e-5, 9e-5, 6)
        fields["data_reflectance_gain_values"] = "{" + ",".join(map(repr, gains.tolist())) + "}"
        fields["data_gain_values"] = "{3,3,3,3,3,3}"
    values = stored.transpose(AXES[layout]).astype(f"{order}{kind[0]}")
    image = read_spectral_image(
        write_header(tmp_path, bytes(offset) + np.ascontiguousarray(values).tobytes(), **fields)
    )
    back = slice(None, None, -1 if is_falling else 1)
    wanted = stored / 10000 if scaled else stored * gains
    np.testing.assert_allclose(image.wavelengths, at[~is_bad][back], rtol=1e-12)
    np.testing.assert_allclose(image.values, wanted[..., ~is_bad][..., back], rtol=1e-6)


@pytest.mark.parametrize(("unit", "factor"), [("Wavenumber", 1e7), ("GHz", 299792458.0)])
def test_wavenumbers_and_frequencies(tmp_path, unit, factor):
    at = np.array([400.0, 500.0, 600.0, 700.0])
    listed = "{" + ",".join(map(repr, (factor / at).tolist())) + "}"
    header = write_header(tmp_path, bytes(96), wavelength_units=unit, wavelength=listed)
    np.testing.assert_allclose(read_spectral_image(header).wavelengths, at)


def test_a_bad_band_is_made_of_its_neighbours(tmp_path):
    values = np.full((2, 3, 4), 0.45, "<f4")
    values[..., 2] = 0.0
    texture = pm.SpectralTexture.read(write_header(tmp_path, values.tobytes(), bbl="{1,1,0,1}"))
    np.testing.assert_allclose(texture.averages(pm.Bands.parse("box:9")), 0.45, rtol=1e-6)


HOLE = np.full((2, 3, 4), 0.5, "<f4")
HOLE[1, 2, 0] = -1.23e34
NANS = np.where(HOLE < 0.0, np.nan, HOLE).astype("<f4")
BEHIND = "1 of 6 texels have no data .*, the first in row 1, column 2; crop or fill them"


@pytest.mark.parametrize(
    ("fields", "data", "message"),
    [
        ({"data_ignore_value": "-1.23e+34"}, HOLE, BEHIND),
        ({"data_ignore_value": "NaN"}, NANS, BEHIND),
        ({"data_ignore_value": "none"}, HOLE, "data ignore value 'none' is not a number"),
        ({"bbl": "{0,1,0,0}"}, HOLE, "bbl leaves 1 good bands; a spectrum needs 2 or more"),
        ({"bbl": "{1,1,1}"}, HOLE, "bbl has 3 numbers for 4 bands; write one for each band"),
        ({"samples": "1e30"}, HOLE, "samples '1e30' is not a whole number from 1"),
        ({"samples": 10**30}, HOLE, "samples '1000.*' is not a whole number from 1"),
        ({"lines": 10**11}, HOLE, "wall.img holds 24 of 1200000000000 values; copy it again"),
        ({"bands": 0}, HOLE, "bands '0' is not a whole number from 1"),
        ({"header_offset": "1e20"}, HOLE, "header offset '1e20' is not a whole number from 0"),
        ({"header_offset": 10**11}, HOLE, "holds 0 of 24 values"),
        ({"header_offset": -4}, HOLE, "header offset '-4' is not a whole number from 0"),
        ({"byte_order": 2}, HOLE, "byte order 2 is neither 0 nor 1"),
        ({"data_type": 6}, HOLE, "data type 6 with interleave bip is not known"),
        ({"file_compression": 1}, HOLE, "file compression 1 is not read; write plain values"),
        ({"major_frame_offsets": "{0, 8}"}, HOLE, "major frame offsets .* is not read"),
        ({"wavelength_units": "Index"}, HOLE, "'Index' are not known; write the unit of its"),
        ({"wavelength_units": "Micrometers"}, HOLE, "no band is near light.*400000 to 700000 nm"),
        ({"wavelength": "{1, 2, 3, 4}", "wavelength_units": None}, HOLE, "1000 to 4000 nm"),
        ({"wavelength": "{400, 700}"}, HOLE, "wavelength has 2 numbers for 4 bands"),
        ({"wavelength": "{400, 500, 600, 7_0}"}, HOLE, "wavelength '7_0' is not a number"),
        ({"wavelength": "{400, 500, 600, 700"}, HOLE, "has braces that are not closed"),
        ({"reflectance_scale_factor": 0}, HOLE, "reflectance scale factor 0 is not above 0"),
        ({"data_gain_values": "{2,2,2,2}"}, HOLE, "make radiances of its values; convert them"),
    ],
)
def test_envi_headers_that_are_refused(tmp_path, fields, data, message):
    with pytest.raises(InputError, match=message) as refused:
        read_spectral_image(write_header(tmp_path, data.tobytes(), **fields))
    assert len(str(refused.value).splitlines()) == 1


def test_envi_files_of_our_own_are_read(tmp_path):
    values = cube().astype(np.float32)
    header, _ = write_envi(values, tmp_path / "a.hdr", [f"{at:g}" for at in AT], AT)
    image = read_spectral_image(header)
    np.testing.assert_array_equal(image.wavelengths, AT)
    np.testing.assert_array_equal(image.values, values)


def test_radiance_images_end_in_hdr_too(read, tmp_path):
    write_image(np.full((2, 2, 3), 0.25, np.float32), tmp_path / "lit.hdr")
    for attribute in ("reflectance", "emission"):
        texture = read('{ file = "lit.hdr" }', attribute)
        assert not isinstance(texture, pm.SpectralTexture)
        assert texture.mean == pytest.approx((0.25, 0.25, 0.25), rel=0.01)
    with pytest.raises(InputError, match="no ENVI header"):
        read_spectral_image(tmp_path / "lit.hdr")


def test_indices_of_16_bits(tmp_path):
    (tmp_path / "a.png").write_bytes(grey([[0, 40000], [7, 1]], np.uint16))
    np.testing.assert_array_equal(read_indices(tmp_path / "a.png"), [[0, 40000], [7, 1]])


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ('{ file = "no.npz" }', "no such file"),
        ('{ file = "bare.npz" }', "needs 'wavelengths'"),
        ('{ file = "torn.npz" }', "cannot be read"),
        ('{ file = "percent.npz" }', "divide percent by 100"),
        ('{ file = "narrow.npz" }', "400-450 nm is missing|400-450 and 650-700 nm is missing"),
        ('{ file = "nan.npz" }', "reflectance is nan"),
        ('{ file = "index.png", palette = [] }', "palette is empty"),
        ('{ file = "index.png", palette = 0.5 }', "write a list"),
        ('{ file = "index.png", palette = [0.5] }', "index 1 in row 0, column 1"),
        ('{ file = "index.png", palette = [0.5, "munsel:N5"] }', "munsel"),
        ('{ file = "index.png", palette = [0.5, 1.5] }', "1.5"),
        ('{ file = "color.png", palette = [0.5, 0.2] }', "is coloured"),
        ('{ file = "index.png", palette = [0.5, 0.2], linear = true }', "linear.* is not known"),
        ('{ file = "bad.hdr" }', "lacks 'wavelength'"),
        ('{ file = "lone.hdr" }', "no lone.img beside"),
    ],
)
def test_what_is_refused(read, tmp_path, keys, message):
    (tmp_path / "index.png").write_bytes(grey([[0, 1]]))
    (tmp_path / "color.png").write_bytes(encode_png(np.array([[[0, 1, 0]]], np.uint8)))
    np.savez(tmp_path / "bare.npz", values=cube())
    np.savez(tmp_path / "percent.npz", wavelengths=AT, values=100 * cube())
    np.savez(tmp_path / "nan.npz", wavelengths=AT, values=np.nan * cube())
    np.savez(tmp_path / "narrow.npz", wavelengths=AT[5:-5], values=cube()[..., 5:-5])
    (tmp_path / "torn.npz").write_bytes(b"PK\3\4 no more")
    head = "ENVI\nsamples = 1\nlines = 1\nbands = 2\ndata type = 4\ninterleave = bip\n"
    (tmp_path / "bad.hdr").write_text(head)
    (tmp_path / "lone.hdr").write_text(head + "wavelength = { 400,\n 700 }\n")
    with pytest.raises(InputError, match=message) as refused:
        read(keys)
    assert len(str(refused.value).splitlines()) == 1


def test_only_reflectances_are_spectra_on_surfaces(read, tmp_path):
    np.savez(tmp_path / "wall.npz", wavelengths=AT, values=cube())
    with pytest.raises(InputError, match="for its reflectance"):
        read('{ file = "wall.npz" }', "emission")
    scene = square(0.5)
    glowing = pm.Material("lamp", 0.5, pm.SpectralTexture.from_cube(AT, cube()))
    with pytest.raises(InputError, match="only reflectance"):
        pm.render(pm.Scene([replace(scene.meshes[0], material=glowing)], [], CAMERA), **SMALL)
