"""Textures of glTF files: where images lie, how they lie on a surface, and what is made of them."""

import base64

import numpy as np
import pytest

import photonmap as pm
from photonmap.errors import InputError, SceneWarning
from photonmap.io.png import encode_png
from photonmap.scene.images import read_channels

UV = [[0.25, 0.0], [1, 0.75], [0, 1]]
TEXELS = np.arange(2 * 3 * 4, dtype=np.uint8).reshape(2, 3, 4) * 10
COAT = (0.5 / 2.5) ** 2


@pytest.fixture
def png(tmp_path):
    """The bytes of an image of two rows of three RGBA texels."""
    import OpenImageIO

    path = tmp_path / "made.png"
    output = OpenImageIO.ImageOutput.create(str(path))
    spec = OpenImageIO.ImageSpec(3, 2, 4, OpenImageIO.UINT8)
    spec.attribute("oiio:UnassociatedAlpha", 1)
    assert output.open(str(path), spec)
    assert output.write_image(TEXELS)
    output.close()
    return path.read_bytes()


def textured(build, image, surface=(), **item):
    """Make a triangle whose base colour is texture 0, with an image as glTF names it."""
    build.primitive(TEXCOORD_0=UV, more={"material": 0})
    surface = {"baseColorTexture": {"index": 0}, "metallicFactor": 0} | dict(surface)
    build.tree |= {
        "images": [image],
        "textures": [{"source": 0}],
        "materials": [{"name": "a", "pbrMetallicRoughness": surface, **item}],
    }


def embed(build, png):
    """Append an image to the buffer as the first one of the file."""
    view = {"buffer": 0, "byteOffset": len(build.blob), "byteLength": len(png)}
    build.blob += png + b"\0" * (-len(png) % 4)
    build.tree["bufferViews"].append(view)
    index = len(build.tree["bufferViews"]) - 1
    build.tree["images"] = [{"bufferView": index, "mimeType": "image/png"}]


@pytest.mark.parametrize("place", ["buffer", "data", "file"])
def test_images_anywhere(read, build, png, tmp_path, place):
    image = {"uri": "data:image/png;base64," + base64.b64encode(png).decode()}
    if place == "file":
        (tmp_path / "my wood.png").write_bytes(png)
        image = {"uri": "my%20wood.png"}
    textured(build, image, {"baseColorFactor": [0.5, 1, 1, 1], "roughnessFactor": 0.3})
    if place == "buffer":
        embed(build, png)
    (mesh,) = read("a.glb", build.glb())
    material = mesh.material
    np.testing.assert_array_equal(material.reflectance.image.texels, TEXELS[..., :3])
    assert material.reflectance.factor == (0.5, 1.0, 1.0)
    assert (material.glossy, material.roughness, material.alpha) == (COAT, 0.3, 1.0)


def test_where_a_texture_lies(read, build, png):
    """(u, v) of glTF, v downwards, becomes scale · (u, v) + offset."""
    move = {"offset": [0.25, 0.5], "scale": [2, 3]}
    use = {"index": 0, "extensions": {"KHR_texture_transform": move}}
    textured(build, {}, {"baseColorTexture": use})
    embed(build, png)
    build.tree["textures"][0]["sampler"] = 0
    build.tree["samplers"] = [{"wrapS": 33071, "wrapT": 33071}]
    (mesh,) = read("a.glb", build.glb())
    texture = mesh.material.reflectance
    assert texture.clamp
    found = mesh.uv * texture.scale + texture.offset
    u, v = np.array(UV).T
    np.testing.assert_allclose(found, np.c_[2 * u + 0.25, 1.0 - (3 * v + 0.5)])


def test_a_texture_may_be_turned(read, build, png):
    """By T · R · S, where R turns u towards -v: counter-clockwise in the image."""
    move = {"offset": [0.25, 0.5], "scale": [2, 3], "rotation": 0.3}
    use = {"index": 0, "extensions": {"KHR_texture_transform": move}}
    textured(build, {}, {"baseColorTexture": use}, emissiveTexture=use, emissiveFactor=[1, 1, 1])
    embed(build, png)
    (mesh,) = read("a.glb", build.glb())
    c, s = np.cos(0.3), np.sin(0.3)
    u, v = (np.array(UV) * [2, 3]).T
    wanted = np.c_[c * u + s * v + 0.25, 1.0 - (-s * u + c * v + 0.5)]
    for texture in (mesh.material.reflectance, mesh.material.emission):
        np.testing.assert_allclose(mesh.uv * texture.scale + texture.offset, wanted)


@pytest.mark.parametrize("transform", [False, True])
def test_further_coordinates(read, build, png, transform):
    use = {"index": 0, "texCoord": 1}
    if transform:
        use = {"index": 0, "extensions": {"KHR_texture_transform": {"texCoord": 1}}}
    textured(build, {}, {"baseColorTexture": use})
    second = np.array(UV)[::-1].copy()
    build.tree["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = build.add(second)
    embed(build, png)
    (mesh,) = read("a.glb", build.glb())
    np.testing.assert_allclose(mesh.uv, np.c_[second[:, 0], 1.0 - second[:, 1]])


@pytest.mark.parametrize(
    ("sampler", "clamp", "nearest"),
    [
        ({"wrapS": 33071}, (True, False), False),
        ({"wrapT": 33071, "wrapS": 10497, "minFilter": 9728}, (False, True), False),
        ({"wrapT": 33071, "wrapS": 33648, "magFilter": 9728}, (False, True), True),
        ({"magFilter": 9728, "minFilter": 9987}, False, True),
        ({"magFilter": 9729, "minFilter": 9728}, False, False),
    ],
)
def test_samplers(read, build, png, sampler, clamp, nearest):
    """A wrap mode for each direction; what is magnified is blurred or not."""
    textured(build, {})
    embed(build, png)
    build.tree["textures"][0]["sampler"] = 0
    build.tree["samplers"] = [sampler]
    (mesh,) = read("a.glb", build.glb())
    texture = mesh.material.reflectance
    assert (texture.clamp, texture.nearest) == (clamp, nearest)


@pytest.mark.parametrize("mirror", [(33648, 10497), (10497, 33648), (33648, 33648)])
def test_textures_may_be_mirrored(read, build, png, mirror):
    textured(build, {})
    embed(build, png)
    build.tree["textures"][0]["sampler"] = 0
    build.tree["samplers"] = [dict(zip(("wrapS", "wrapT"), mirror, strict=True))]
    (mesh,) = read("a.glb", build.glb())
    across, up = (wrap == 33648 for wrap in mirror)
    plain = pm.Texture.of(TEXELS[..., :3]).mirrored(across, up)
    texture = mesh.material.reflectance
    np.testing.assert_array_equal(texture.image.texels, plain.image.texels)
    assert (texture.scale, texture.offset) == (plain.scale, plain.offset)


@pytest.mark.parametrize("mode", ["OPAQUE", "BLEND", "MASK"])
def test_alpha_of_textures(read, build, png, mode):
    textured(build, {}, {"baseColorFactor": [1, 1, 1, 0.5]}, alphaMode=mode, alphaCutoff=0.25)
    embed(build, png)
    (mesh,) = read("a.glb", build.glb())
    alpha = 0.5 * TEXELS[..., 3] / 255
    if mode == "OPAQUE":
        assert mesh.material.alpha == 1.0
        return
    wanted = alpha >= 0.25 if mode == "MASK" else alpha
    np.testing.assert_allclose(mesh.material.alpha.image.texels[..., 0], wanted, rtol=1e-6)


def test_metals_and_roughness_vary(read, build, png):
    gloss = {"roughnessFactor": 0.5, "metallicFactor": 1}
    textured(build, {}, gloss | {"metallicRoughnessTexture": {"index": 0}})
    embed(build, png)
    (mesh,) = read("a.glb", build.glb())
    material, color = (
        mesh.material,
        pm.Texture.of(TEXELS[..., :3]).image.linear(slice(None), slice(None)),
    )
    np.testing.assert_array_equal(material.roughness.image.texels[..., 0], TEXELS[..., 1])
    assert material.roughness.factor == (0.5, 0.5, 0.5)
    metal = TEXELS[..., 2:3] / 255
    np.testing.assert_allclose(
        material.reflectance.image.texels, (1 - metal) * color, rtol=1e-5, atol=1e-7
    )
    np.testing.assert_allclose(
        material.glossy.image.texels, metal * color + (1 - metal) * COAT, rtol=1e-5
    )


def test_normal_maps(read, build, png):
    textured(build, {}, normalTexture={"index": 0, "scale": 0.5})
    embed(build, png)
    (mesh,) = read("a.glb", build.glb())
    relief = mesh.material.relief
    assert (type(relief), relief.strength) == (pm.NormalMap, 0.5)
    np.testing.assert_array_equal(relief.texture.image.texels, TEXELS[..., :3])
    assert not relief.texture.image.srgb


@pytest.mark.parametrize(
    ("normals", "kind"),
    [({"index": 0, "scale": 0.5}, type(None)), ({"index": 0}, pm.NormalMap), (None, pm.NoRelief)],
)
def test_clear_coats_have_their_own_images(read, build, png, normals, kind):
    """Those of roughness, and of normals where the surface does not have the same."""
    coat = {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.5}
    coat |= {"clearcoatRoughnessTexture": {"index": 0}, "clearcoatNormalTexture": normals}
    coat = {key: value for key, value in coat.items() if value is not None}
    bumps = {"index": 0, "scale": 0.5}
    textured(build, {}, normalTexture=bumps, extensions={"KHR_materials_clearcoat": coat})
    embed(build, png)
    (mesh,) = read("a.glb", build.glb())
    rough = mesh.material.coat_roughness
    np.testing.assert_array_equal(rough.image.texels, TEXELS[..., 1:2])
    assert (rough.image.srgb, rough.factor) == (False, (0.5,) * 3)
    assert type(mesh.material.coat_relief) is kind
    if kind is pm.NormalMap:
        assert mesh.material.coat_relief.strength == 1.0


@pytest.mark.parametrize("scale", ["much", 1e7])
def test_bad_scales_of_normal_maps(read, build, png, scale):
    textured(build, {}, normalTexture={"index": 0, "scale": scale})
    embed(build, png)
    with pytest.raises(InputError, match=r"scale of normalTexture .* is not a number up to 1e"):
        read("a.glb", build.glb())


def test_an_even_channel_is_a_number(read, build, tmp_path):
    """Images hold roughness and the metallic part in two channels, of which one is often even."""
    texels = np.array([[[0, 51, 255], [0, 204, 255]]], np.uint8)
    (tmp_path / "data.png").write_bytes(encode_png(texels))
    textured(build, {}, {"metallicFactor": 1, "metallicRoughnessTexture": {"index": 0}})
    del build.tree["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
    build.tree["images"] = [{"uri": "data.png"}]
    (mesh,) = read("a.glb", build.glb())
    assert (mesh.material.reflectance, mesh.material.glossy) == ((0.0,) * 3, (1.0,) * 3)
    np.testing.assert_array_equal(mesh.material.roughness.image.texels, texels[..., 1:2])


def test_emission_textures_light_the_scene(read, build, png):
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}}
    more = {"emissiveTexture": {"index": 0}, "emissiveFactor": [1, 0.5, 0]}
    textured(build, {}, **more, extensions=strength)
    embed(build, png)
    (mesh,) = read("a.glb", build.glb())
    assert mesh.material.emission.factor == (4.0, 2.0, 0.0)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"samplers": [{"wrapS": 33069}]}, "wrap mode '33069', which is read as repeat, of 'a'"),
        ({"texCoord": 1}, "texture coordinates of a further texture of 'a'"),
        ({"extensions": {"KHR_texture_transform": {"rotation": 1.0}}}, "coordinates of a further"),
    ],
)
def test_what_is_not_simulated_is_named(read, build, png, change, named):
    textured(build, {}, emissiveTexture={"index": 0, **change}, emissiveFactor=[1, 1, 1])
    embed(build, png)
    build.tree["samplers"] = change.get("samplers", [{}])
    build.tree["textures"][0]["sampler"] = 0
    with pytest.warns(SceneWarning, match=named):
        read("a.glb", build.glb())


def test_missing_images(read, build, tmp_path):
    textured(build, {"uri": "none.png"}, {"baseColorFactor": [0.5, 1, 1, 1]})
    with pytest.raises(
        InputError, match=r"none\.png: cannot be read.*grey \(missing_textures='grey'\)$"
    ):
        read("a.glb", build.glb())
    with pytest.warns(SceneWarning, match=r"grey in their place, of 'none\.png'"):
        (mesh,) = pm.load_scene(tmp_path / "a.glb", missing_textures="grey").meshes
    assert mesh.material.reflectance == (0.25, 0.5, 0.5)


def test_damaged_images_are_named(read, build, png):
    textured(build, {})
    embed(build, png[:60])
    with pytest.raises(InputError, match=r"a\.glb: image 0 cannot be read as an image"):
        read("a.glb", build.glb())


def test_images_of_another_format(read, build):
    textured(build, {})
    del build.tree["textures"][0]["source"]
    with pytest.raises(InputError, match=r"a\.glb: texture 0 is neither PNG nor JPEG; .*grey'\)$"):
        read("a.glb", build.glb())


def test_an_image_is_decoded_once(read, build, png, monkeypatch):
    """For colour and opacity, and for all materials that show it."""
    textured(build, {}, alphaMode="BLEND")
    embed(build, png)
    build.tree["materials"] *= 2
    build.primitive(TEXCOORD_0=UV, more={"material": 1})
    decoded = []

    def count(path, as_stored):
        decoded.append(path)
        return read_channels(path, as_stored)

    monkeypatch.setattr("photonmap.io.readers.decoding.read_channels", count)
    first, second = (mesh.material for mesh in read("a.glb", build.glb()))
    assert len(decoded) == 1
    assert first.reflectance.image is second.reflectance.image
    np.testing.assert_array_equal(first.alpha.image.texels[..., 0] * 255, TEXELS[..., 3])


def test_an_embedded_image_of_odd_channels_is_named(read, build, tmp_path):
    import OpenImageIO

    path = tmp_path / "odd.tiff"
    spec = OpenImageIO.ImageSpec(2, 2, 2, OpenImageIO.UINT8)
    output = OpenImageIO.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(np.zeros((2, 2, 2), np.uint8))
    output.close()
    data = base64.b64encode(path.read_bytes()).decode()
    textured(build, {"uri": "data:image/tiff;base64," + data, "mimeType": "image/tiff"})
    with pytest.raises(InputError, match=r"a\.glb: image 0 has the channels"):
        read("a.glb", build.glb())
