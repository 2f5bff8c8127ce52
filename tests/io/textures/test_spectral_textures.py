"""Textures whose texels are spectra: band values, pictures, files, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest

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
