"""Images in TOML scenes: textures of materials, and relief."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.errors import InputError
from photonmap.io.png import encode_png
from photonmap.kernels.core.color import LUMINANCE
from photonmap.spectra.rgb_spaces import decode_srgb


def test_textures(wall):
    """Colours are in sRGB unless they are said to be linear; roughness always is linear."""
    material = wall(
        'reflectance = { file = "a.png", scale = 2, offset = [0.5, 0], clamp = true }\n'
        'glossy = { file = "a.png", linear = true, factor = [1, 0.5, 0.25] }\n'
        'roughness = { file = "a.png", factor = 0.5 }'
    )
    reflectance, glossy, roughness = material.reflectance, material.glossy, material.roughness
    assert (reflectance.scale, reflectance.offset) == ((2.0, 2.0), (0.5, 0.0))
    assert (reflectance.clamp, glossy.clamp, glossy.nearest) == (True, False, False)
    assert [t.image.srgb for t in (reflectance, glossy, roughness)] == [True, False, False]
    assert glossy.factor == (1.0, 0.5, 0.25)
    assert roughness.factor == (0.5, 0.5, 0.5)
    np.testing.assert_array_equal(reflectance.image.texels, [[[51, 102, 153], [204, 102, 0]]])


def test_a_clamp_for_each_direction_and_no_interpolation(wall):
    texture = wall('reflectance = { file = "a.png", clamp = [true, false], nearest = true }')
    assert (texture.reflectance.clamp, texture.reflectance.nearest) == ((True, False), True)


def test_what_has_a_spectrum_in_every_texel_is_no_metal_in_part(wall, tmp_path):
    (tmp_path / "index.png").write_bytes(encode_png(np.zeros((1, 2, 1), np.uint8)))
    with pytest.raises(InputError, match=r"a\.toml:2: .* metallic: a reflectance of many spectra"):
        wall('metallic = 1\nreflectance = { file = "index.png", palette = [0.1, 0.2] }')


def test_opacity_is_a_mask(wall):
    """Its numbers count as they are stored; as colours only if that is asked for."""
    stored = np.array([[[51, 102, 153], [204, 102, 0]]]) / 255.0
    for more, values in (("", stored), (", linear = false", decode_srgb(stored))):
        mask = wall(f'alpha = {{ file = "a.png"{more} }}').alpha.image.texels
        np.testing.assert_allclose(mask[..., 0], values @ LUMINANCE, rtol=1e-5)
    for key, given in (
        ("coat", ""),
        ("coat_roughness", "coat = 1\n"),
        ("transmission", "ior = 1.5\n"),
    ):
        image = getattr(wall(f'{given}{key} = {{ file = "a.png" }}'), key).image
        assert not image.srgb, key


def test_relief(wall):
    bumps = wall('relief = { type = "bump", file = "a.png", height = 0.01 }').relief
    assert (type(bumps), bumps.height) == (pm.BumpMap, 0.01)
    assert not bumps.texture.image.srgb
    normals = wall('relief = { type = "normal", file = "a.png" }').relief
    assert (type(normals), normals.strength) == (pm.NormalMap, 1.0)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("glossy = { scale = 2 }", r'names no file; write { file = "IMAGE" }'),
        ('glossy = { file = "b.png" }', r"glossy: .*b.png: cannot be read"),
        ('glossy = { file = "a.png", size = 2 }', r"key 'size' is not known; did you mean"),
        ('glossy = { file = "a.png", scale = [1, 2, 3] }', r"scale .*; write 2 numbers, or one"),
        ('glossy = { file = "a.png", clamp = 1 }', r"clamp 1; write true or false, or a list of"),
        ('glossy = { file = "a.png", clamp = [true] }', r"clamp \[True\]; write true or false"),
        ('glossy = { file = "a.png", factor = 3 }', r"the texture reaches 1.8"),
        ('mirror = { file = "a.png" }', r"is not a colour"),
        ('relief = { file = "a.png" }', r"relief: has no type; add one of"),
        ('relief = { type = "bumps", file = "a.png" }', r"'bumps' is not known; did you mean"),
        ('relief = { type = "bump" }', r"lacks file; add file = "),
    ],
)
def test_errors_name_the_line_and_a_remedy(wall, keys, message):
    with pytest.raises(InputError, match=rf"a\.toml:2: \[material\.wall\] .*{message}"):
        wall(keys)
