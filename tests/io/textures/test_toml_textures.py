"""Images in TOML scenes: textures of materials, and relief."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.errors import InputError
from photonmap.io.png import encode_png

TEXELS = np.array([[[51, 102, 153], [204, 102, 0]]], np.uint8)


@pytest.fixture
def read(tmp_path):
    """Return a function that reads the material of a TOML scene from the keys of its section."""
    (tmp_path / "a.png").write_bytes(encode_png(TEXELS))
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl wall\nf 1/1 2/2 3/3\n"
    )
    (tmp_path / "a.mtl").write_text("newmtl wall\nKd 0.5 0.5 0.5\n")

    def read(keys):
        (tmp_path / "a.toml").write_text(f"[material.wall]\n{keys}\n")
        return pm.load_scene(tmp_path / "a.obj").meshes[0].material

    (tmp_path / "a.obj").write_text("mtllib a.mtl\n" + (tmp_path / "a.obj").read_text())
    return read


def test_textures(read):
    """Colours are in sRGB unless they are said to be linear; roughness always is linear."""
    material = read(
        'reflectance = { file = "a.png", scale = 2, offset = [0.5, 0], clamp = true }\n'
        'glossy = { file = "a.png", linear = true, factor = [1, 0.5, 0.25] }\n'
        'roughness = { file = "a.png", factor = 0.5 }'
    )
    reflectance, glossy, roughness = material.reflectance, material.glossy, material.roughness
    assert (reflectance.scale, reflectance.offset) == ((2.0, 2.0), (0.5, 0.0))
    assert (reflectance.clamp, glossy.clamp) == (True, False)
    assert [t.image.srgb for t in (reflectance, glossy, roughness)] == [True, False, False]
    assert glossy.factor == (1.0, 0.5, 0.25)
    assert roughness.factor == (0.5, 0.5, 0.5)
    np.testing.assert_array_equal(reflectance.image.texels, TEXELS)


def test_metallic_is_that_of_mtl_and_gltf(read, tmp_path):
    """A share of metal of the surface's colour; the rest is a base of it, below a coat."""
    half = read("reflectance = [0.8, 0.4, 0.2]\nroughness = 0.3\nmetallic = 0.5")
    assert half.reflectance == (0.4, 0.2, 0.1)
    np.testing.assert_allclose(half.glossy, np.array((0.4, 0.2, 0.1)) + 0.5 * 0.04, rtol=1e-12)
    whole = read("reflectance = [0.8, 0.4, 0.2]\nroughness = 0.3\nmetallic = 1\nglossy = 0.1")
    assert (whole.reflectance, whole.glossy) == ((0.0,) * 3, (0.8, 0.4, 0.2))
    plastic = read("roughness = 0.3\nmetallic = 0")
    assert (plastic.reflectance, plastic.roughness) == ((0.5,) * 3, 0.3)
    assert plastic.glossy == pytest.approx(0.04)
    image = 'file = "a.png"'
    found = read(f"reflectance = {{ {image} }}\nroughness = 0.3\nmetallic = {{ {image} }}")
    mtl = tmp_path / "a.mtl"
    mtl.write_text("newmtl wall\nmap_Kd a.png\nPr 0.3\nmap_Pm a.png\n")
    wanted = read("")
    assert found.roughness == wanted.roughness == 0.3
    for name in ("reflectance", "glossy"):
        ours, theirs = (getattr(look, name).image.texels for look in (found, wanted))
        np.testing.assert_array_equal(ours, theirs)


def test_what_has_a_spectrum_in_every_texel_is_no_metal_in_part(read, tmp_path):
    (tmp_path / "index.png").write_bytes(encode_png(np.zeros((1, 2, 1), np.uint8)))
    with pytest.raises(InputError, match=r"a\.toml:2: .* metallic: a reflectance of many spectra"):
        read('metallic = 1\nreflectance = { file = "index.png", palette = [0.1, 0.2] }')


def test_opacity_is_a_mask(read):
    assert read('alpha = { file = "a.png", linear = true }').alpha.image.texels.shape == (1, 2, 1)


def test_relief(read):
    bumps = read('relief = { type = "bump", file = "a.png", height = 0.01 }').relief
    assert (type(bumps), bumps.height) == (pm.BumpMap, 0.01)
    assert not bumps.texture.image.srgb
    normals = read('relief = { type = "normal", file = "a.png" }').relief
    assert (type(normals), normals.strength) == (pm.NormalMap, 1.0)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("glossy = { scale = 2 }", r'names no file; write { file = "IMAGE" }'),
        ('glossy = { file = "b.png" }', r"glossy: .*b.png: cannot be read"),
        ('glossy = { file = "a.png", size = 2 }', r"key 'size' is not known; did you mean"),
        ('glossy = { file = "a.png", scale = [1, 2, 3] }', r"scale .*; write 2 numbers, or one"),
        ('glossy = { file = "a.png", clamp = 1 }', r"clamp 1; write true or false"),
        ('glossy = { file = "a.png", factor = 3 }', r"the texture reaches 1.8"),
        ('mirror = { file = "a.png" }', r"is not a colour"),
        ('relief = { file = "a.png" }', r"relief: has no type; add one of"),
        ('relief = { type = "bumps", file = "a.png" }', r"'bumps' is not known; did you mean"),
        ('relief = { type = "bump" }', r"lacks file; add file = "),
    ],
)
def test_errors_name_the_line_and_a_remedy(read, keys, message):
    with pytest.raises(InputError, match=rf"a\.toml:2: \[material\.wall\] .*{message}"):
        read(keys)
