"""Textures of MTL libraries and scene files."""

import warnings

import numpy as np
import pytest

import photonmap as pm
from photonmap.commands.main import main
from photonmap.errors import InputError, SceneWarning
from photonmap.scene.textures import shared_image

BYTES = np.random.default_rng(5).integers(0, 256, (4, 5, 3), np.uint8)


def write_image(path, texels):
    import OpenImageIO

    height, width, channels = texels.shape
    output = OpenImageIO.ImageOutput.create(str(path))
    output.open(str(path), OpenImageIO.ImageSpec(width, height, channels, "uint8"))
    output.write_image(texels)
    output.close()


@pytest.fixture
def folder(tmp_path):
    write_image(tmp_path / "my wood.png", BYTES)
    (tmp_path / "maps").mkdir()
    write_image(tmp_path / "maps" / "mask.png", BYTES[..., :1])
    return tmp_path


@pytest.fixture
def read(folder):
    from photonmap.io.readers.obj.mtl import read_mtl

    def read(text, **settings):
        (folder / "a.mtl").write_text("newmtl a\n" + text)
        return read_mtl(folder / "a.mtl", **settings)["a"]

    return read


def test_maps_of_mtl(read):
    material = read(
        "Kd 0.5 1 0.25\nmap_Kd -s 2 3 1 -o 0.5 -clamp on my wood.png\n"
        "map_Ke my wood.png\nmap_d maps\\mask.png\nd 0.5\n"
    )
    color, light, alpha = material.reflectance, material.emission, material.alpha
    assert (color.scale, color.offset, color.clamp) == ((2, 3), (0.5, 0), True)
    assert color.factor == (0.5, 1, 0.25)
    assert light.factor == (1, 1, 1)
    assert light.image is color.image
    np.testing.assert_array_equal(color.image.texels, BYTES)
    assert color.image.srgb
    assert alpha.factor == (0.5, 0.5, 0.5)
    np.testing.assert_array_equal(alpha.image.texels, BYTES[..., :1])
    assert not alpha.image.srgb
    assert light.image is shared_image(str(read.__closure__[0].cell_contents / "my wood.png"))


@pytest.mark.parametrize(
    ("text", "alpha"), [("d 0.25", 0.25), ("Tr 0.25", 0.75), ("d 0.5\nTr 0.5", 0.5), ("d 1", 1.0)]
)
def test_opacity_of_mtl(read, text, alpha):
    assert read(text + "\n") == pm.Material("a", alpha=alpha)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("map_Kd -bm 2 my wood.png", "'map_Kd -bm' of 'a'"),
        ("map_Ks my wood.png", "'map_Ks' of 'a'"),
        ("d -halo 0.5", "'d -halo' of 'a'"),
        ("d 0.25\nTr 0.25", "'Tr' of 'a'"),
        ("illum 7\nNi 1.5\nd 0.3", "'d' of 'a'"),
        ("illum 7\nNi 1.5\nmap_Kd my wood.png", "'map_Kd' of 'a'"),
    ],
)
def test_what_is_left_out_is_named(read, text, named):
    with pytest.warns(SceneWarning, match=f"not simulated: {named}$"):
        read(text + "\n")


@pytest.mark.parametrize(
    ("text", "metallic", "coat"), [("Pr 0.5\nPm 0.25\n", 0.25, 0.04), ("Pr 0.5\nPm 1\n", 1.0, 0.0)]
)
def test_textured_metals_reflect_the_colour_of_each_texel(read, tmp_path, text, metallic, coat):
    material = read(text + "Kd 0.5 1 1\nmap_Kd my wood.png\n")
    texture = pm.Texture.read(tmp_path / "my wood.png", factor=(0.5, 1, 1))
    wanted = metallic * linear(texture) + (1 - metallic) * coat
    np.testing.assert_allclose(linear(material.glossy), wanted, rtol=1e-6)
    assert material.roughness == 0.5
    if metallic == 1.0:
        assert material.reflectance == 0.0
    else:
        np.testing.assert_allclose(material.reflectance.factor, [0.375, 0.75, 0.75])


def linear(texture):
    return texture.image.linear(slice(None), slice(None)) * np.array(texture.factor)


DATA = np.array([[[51] * 3, [102] * 3]], np.uint8)
SHARE = np.array([[[0.2], [0.4]]])


def test_textures_of_roughness_and_metallic_hold_linear_values(read, tmp_path):
    write_image(tmp_path / "data.png", DATA)
    material = read("Kd 0.5\nmap_Pr data.png\nPr 0.9\nmap_Pm data.png\n")
    np.testing.assert_allclose(linear(material.roughness), SHARE * np.ones(3), rtol=1e-6)
    wanted = SHARE * 0.5 + (1 - SHARE) * 0.04
    np.testing.assert_allclose(linear(material.glossy), wanted * np.ones(3), rtol=1e-6)
    wanted = (1 - SHARE) * 0.5
    np.testing.assert_allclose(linear(material.reflectance), wanted * np.ones(3), rtol=1e-6)


def test_a_metallic_texture_beside_a_colour_of_another_size(read, tmp_path):
    """Texels of the larger one, between whose centres the smaller one is interpolated."""
    write_image(tmp_path / "data.png", DATA)
    write_image(tmp_path / "fine.png", np.full((1, 4, 3), 255, np.uint8))
    material = read("Pr 0.5\nmap_Pm -clamp on data.png\nmap_Kd -clamp on fine.png\n")
    share = np.array([0.2, 0.25, 0.35, 0.4])
    np.testing.assert_allclose(linear(material.reflectance)[0, :, 0], 1.0 - share, rtol=1e-6)
    np.testing.assert_allclose(
        linear(material.glossy)[0, :, 0], share + 0.04 * (1 - share), rtol=1e-6
    )


def test_a_metallic_texture_that_lies_otherwise_than_the_colour_has_its_mean(read, tmp_path):
    write_image(tmp_path / "data.png", DATA)
    with pytest.warns(SceneWarning, match="the mean of map_Pm stands for it in 'a'$"):
        material = read("Pr 0.5\nmap_Pm -s 2 2 data.png\nmap_Kd my wood.png\n")
    np.testing.assert_allclose(material.reflectance.factor, 0.7)


@pytest.mark.parametrize("keyword", ["bump", "map_Bump"])
@pytest.mark.parametrize("is_first", [True, False])
def test_a_normal_map_replaces_heights_in_either_order(read, tmp_path, keyword, is_first):
    write_image(tmp_path / "normals.png", np.full((2, 2, 3), [128, 128, 255], np.uint8))
    write_image(tmp_path / "heights.png", np.full((2, 2, 3), 60, np.uint8))
    lines = ["norm normals.png\n", f"{keyword} heights.png\n"]
    with pytest.warns(SceneWarning, match=f"not simulated: '{keyword}' of 'a'$"):
        material = read("Kd 0.5\n" + "".join(lines if is_first else lines[::-1]))
    assert isinstance(material.relief, pm.NormalMap)


def test_textures_of_exponents_and_of_glossy_colours(read, tmp_path):
    write_image(tmp_path / "data.png", DATA)
    text = "illum 2\nNs 100\nKs 0.5 0.5 1\nmap_Ns data.png\nmap_Ks my wood.png\n"
    material = read("Kd 0.5\n" + text)
    exponents = 100.0 * SHARE[..., 0]
    np.testing.assert_allclose(
        material.roughness.image.texels[..., 0], (2 / (exponents + 2)) ** 0.25, rtol=1e-6
    )
    wood = pm.Texture.read(tmp_path / "my wood.png")
    np.testing.assert_allclose(linear(material.glossy), linear(wood) * [0.5, 0.5, 1.0], rtol=1e-6)
    assert material.reflectance == (0.5, 0.5, 0.5)


HEIGHTS = np.array([[[0] * 3, [255] * 3]], np.uint8)
FACING = np.full((1, 2, 3), (128, 128, 255), np.uint8)


@pytest.mark.parametrize("keyword", ["bump", "map_bump", "map_Bump"])
def test_bump_maps_hold_heights(read, tmp_path, keyword):
    write_image(tmp_path / "a.png", HEIGHTS)
    relief = read(f"Kd 0.5\n{keyword} -bm 0.25 -s 2 1 1 a.png\n").relief
    assert (type(relief), relief.height) == (pm.BumpMap, 0.25)
    assert (relief.texture.scale, relief.texture.image.srgb) == ((2.0, 1.0), False)


def test_normal_maps(read, tmp_path):
    """By their keyword; and by their looks, as Blender writes them as bump maps."""
    write_image(tmp_path / "a.png", HEIGHTS)
    write_image(tmp_path / "b.png", FACING)
    for text in ("norm -bm 0.5 b.png\n", "map_Bump -bm 0.5 b.png\n", "norm b.png\nbump b.png\n"):
        relief = read("Kd 0.5\n" + text).relief
        assert isinstance(relief, pm.NormalMap)
        assert relief.strength == (0.5 if "0.5" in text else 1.0)
        np.testing.assert_array_equal(relief.texture.image.texels, FACING)
    with pytest.warns(SceneWarning, match="not simulated: 'bump' of 'a'"):
        assert isinstance(read("norm b.png\nbump a.png\n").relief, pm.NormalMap)
    assert read("bump -bm 0 a.png\n").relief is None


def test_images_of_relief_that_are_missing(read):
    lost = r"^2 images of relief were not readable and left out: \S*a.mtl:2 'c.png', \S*:3 'd.png'$"
    with pytest.warns(SceneWarning, match=lost):
        assert read("norm c.png\nmap_Bump -bm 2 d.png\n").relief is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("bump -bm x a.png", "bump: -bm is followed by 'x'; write 1 number after it"),
        ("bump -bm 1e9 data.png", "bump: height .* is not a height; give scene units"),
    ],
)
def test_bad_relief(read, tmp_path, text, message):
    write_image(tmp_path / "data.png", HEIGHTS)
    with pytest.raises(InputError, match=message):
        read(text + "\n")


@pytest.mark.parametrize("kind", [pm.NormalMap, pm.BumpMap])
@pytest.mark.parametrize("name", ["b.obj", "b.glb"])
def test_relief_is_written_and_read_back(tmp_path, name, kind):
    """As `norm` or `map_Bump`, as `normalTexture`, or in TOML beside glTF."""
    texels = pm.Texture.of(np.array([[[100, 140, 230], [128, 20, 255]]], np.uint8), srgb=False)
    wanted = pm.Material("a", 0.3, relief=kind(texels, 0.5))
    mesh = pm.Mesh(np.eye(3), np.array([[0, 1, 2]]), wanted, uv=np.eye(3)[:, :2])
    pm.save_scene(pm.Scene([mesh]), tmp_path / name)
    relief = pm.load_scene(tmp_path / name).meshes[0].material.relief
    assert (type(relief), relief.factor) == (kind, 0.5)
    np.testing.assert_allclose(linear(relief.texture), linear(texels), atol=1e-6)


def test_textured_lobes_are_written_and_read_back(tmp_path):
    wanted = pm.Material(
        "a",
        0.3,
        glossy=pm.Texture.of(np.float32([[[0.1, 0.2, 0.3], [0.5, 0.6, 0.7]]])),
        roughness=pm.Texture.of(np.float32([[0.2], [0.9]]), clamp=True, scale=(2.0, 1.0)),
    )
    mesh = pm.Mesh(np.eye(3), np.array([[0, 1, 2]]), wanted, uv=np.eye(3)[:, :2])
    pm.save_scene(pm.Scene([mesh]), tmp_path / "b.obj")
    found = pm.load_scene(tmp_path / "b.obj").meshes[0].material
    np.testing.assert_allclose(linear(found.glossy), linear(wanted.glossy))
    rough = linear(found.roughness).mean(axis=2, keepdims=True)
    np.testing.assert_allclose(rough, linear(wanted.roughness)[..., :1], rtol=1e-6)
    assert found.roughness.clamp
    assert found.roughness.scale == (2.0, 1.0)
    assert found.reflectance == 0.3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("map_Pr wood.png", "map_Pr: .*wood.png: .*"),
        ("map_Kd -q 1 a.png", "map_Kd: option '-q' is not known"),
        ("map_Kd -s 2", "map_Kd: names no file"),
        ("map_Kd wood.png", "map_Kd: .*wood.png: .*"),
        ("map_d wood.png", "map_d: .*wood.png: .*"),
        ("map_Kd a.mtl", "map_Kd: .*a.mtl: cannot be read as an image.*--missing-textures grey"),
        ("d 1.5", r"d '1.5' is not an opacity; keep it within \[0, 1\]"),
        ("Tr -1", "Tr '-1' is not an opacity"),
        ("d", "d ''; write a finite number"),
    ],
)
def test_errors_of_mtl(read, text, message):
    with pytest.raises(InputError, match=rf"a\.mtl:2: {message}"):
        read(text + "\n")


def test_missing_textures_may_be_grey(read):
    text = "Kd 0.8\nmap_Kd no.png\nKe 2\nmap_Ke none.png\nmap_d mask.png\n"
    with pytest.warns(SceneWarning, match=r"3 textures .* grey: .*a\.mtl:3 'no.png'"):
        material = read(text, missing_textures="grey")
    assert material == pm.Material("a", (0.5, 0.5, 0.5), (1.0, 1.0, 1.0))


def test_a_scene_file_with_textures(folder):
    corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    faces = "usemtl a\nf 1/1 2/2 3/3 4/4\n"
    (folder / "a.obj").write_text(f"mtllib a.mtl\n{corners}{faces}")
    (folder / "a.mtl").write_text("newmtl a\nKd 1\nmap_Kd my wood.png\n")
    scene = pm.load_scene(folder / "a.obj")
    assert isinstance(scene.meshes[0].material.reflectance, pm.Texture)
    (folder / "a.mtl").write_text("newmtl a\nKd 1\nmap_Kd no.png\n")
    with pytest.raises(InputError, match=r"a.mtl:3: map_Kd: .*no.png"):
        pm.load_scene(folder / "a.obj")
    with pytest.warns(SceneWarning, match="grey"):
        scene = pm.load_scene(folder / "a.obj", missing_textures="grey")
    assert scene.meshes[0].material.reflectance == (0.5, 0.5, 0.5)
    command = [str(folder / "a.obj"), "--size=4x4", "--passes=1", "--quiet"]
    command += ["--output", str(folder / "a.exr")]
    assert main(command) == 2
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert main([*command, "--missing-textures", "grey"]) == 0
