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
