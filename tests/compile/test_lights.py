"""What describes lights: names, groups and environment maps, and what is refused."""

import numpy as np
import pytest
from helpers.scenes import closed_box, quad, sky

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.scene.images import check_panorama, read_panorama
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()
BLOCK = closed_box(pm.Material("block", 0.5), -0.5, 0.5)


def test_names_and_groups():
    lamp = pm.Material("spot", 0.5, 1.0)
    lights = [
        pm.PointLight((0, 0, 2)),
        pm.PointLight((0, 0, 3), name="point 2"),
        pm.PointLight((0, 0, 4), group="warm"),
        pm.SpotLight((0, 0, 2), (0, 0, 0)),
        pm.DirectionalLight((0, -1, 0), 0.0, "off"),
        pm.DirectionalLight((0, -1, 0), name="sun", group="warm"),
        pm.EnvironmentLight(np.ones((1, 2, 3))),
    ]
    compiled = compile_scene(
        pm.Scene([quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), lamp)], lights), RGB
    )
    assert compiled.light_names == [
        "spot", "spot", "point", "point 2", "point 3", "spot 2", "sun", "environment",
    ]  # fmt: skip
    assert compiled.light_groups == [
        "spot", "spot", "point", "point 2", "warm", "spot 2", "warm", "environment",
    ]  # fmt: skip
    assert compiled.counts["lights"] == 7
    assert compiled.counts["spectra"] is False


@pytest.mark.parametrize(
    "lights",
    [
        [pm.PointLight((0, 0, 2), name="sun"), pm.DirectionalLight((0, -1, 0), name="sun")],
        [pm.DirectionalLight((0, -1, 0), name="lamp")],
    ],
)
def test_two_lights_of_one_name(lights):
    block = closed_box(pm.Material("lamp", 0.5, 1.0))
    name = lights[0].name
    with pytest.raises(pm.InputError, match=f"^two lights are named '{name}'; give each its own"):
        compile_scene(pm.Scene([block], lights), RGB)


def test_lights_that_are_all_off_are_not_replaced():
    dark = pm.EnvironmentLight(np.zeros((2, 4, 3)), name="night")
    with pytest.raises(
        pm.InputError, match=r"all lights are off, .*: 'night', 'bulb'; turn one on"
    ):
        compile_scene(pm.Scene([BLOCK], [dark, pm.PointLight((0, 0, 2), 0.0, "bulb")]), RGB)
    with pytest.warns(pm.SceneWarning, match="the scene has no light"):
        assert compile_scene(pm.Scene([BLOCK]), RGB).light_names == ["default"]


@pytest.mark.parametrize(
    ("light", "message"),
    [
        (
            pm.SpotLight((0, 0, 2), (0, 0, 2)),
            r"'spot': target \(0, 0, 2\) is at the light's position",
        ),
        (pm.SpotLight((0, 0, 2), (0, np.nan, 2)), r"target .* is not a point"),
        (
            pm.SpotLight((0, 0, 2), (0, 0, 0), inner=40),
            "inner 40 exceeds the outer half-angle, 30 deg",
        ),
        (pm.SpotLight((0, 0, 2), (0, 0, 0), inner=-1), "inner -1 is not a half-angle"),
        (pm.SpotLight((0, 0, 2), (0, 0, 0), inner=0, outer=0), "outer 0 is not a half-angle"),
        (pm.SpotLight((0, 0, 2), (0, 0, 0), outer=180), "outer 180 is not a half-angle"),
        (pm.SpotLight((0, 0, 2), (0, 0, 0), outer=np.inf), "outer inf is not a half-angle"),
        (pm.SpotLight((0, 0, 2), (0, 0, 0), -1.0), "'spot' emits -1"),
        (pm.DirectionalLight((0, 0, 0)), r"direction \(0, 0, 0\) has no length"),
        (pm.DirectionalLight((0, 0)), r"direction \(0, 0\) is not a direction"),
        (pm.DirectionalLight((0, 0, 1), -2.0, "sun"), "'sun' emits -2"),
        (pm.DomeLight(1.0, 3), "name 3 is not a text"),
        (pm.EnvironmentLight(np.ones((4, 8, 3)), -1.0), "scale -1.0 is not a factor; give"),
        (pm.EnvironmentLight(np.ones((4, 8, 3)), np.nan), "scale nan is not a factor"),
        (pm.EnvironmentLight(np.ones((4, 8, 3)), 1.0, "x"), "rotation 'x' is not an angle"),
        (pm.EnvironmentLight(np.ones((4, 7, 3))), "is 7x4; give a map twice as wide"),
        (pm.EnvironmentLight(np.ones((4, 8))), "is not a radiance map"),
        (pm.EnvironmentLight("nowhere.exr"), "'environment': nowhere.exr: cannot be read"),
    ],
)
def test_bad_lights(light, message):
    with pytest.raises(pm.InputError, match=message):
        compile_scene(pm.Scene([BLOCK], [light]), RGB)


def test_one_sky_at_most():
    lights = [pm.DomeLight(), pm.EnvironmentLight(np.ones((2, 4, 3)), name="sky")]
    with pytest.raises(pm.InputError, match=r"one dome or environment at most.*'dome' and 'sky'"):
        compile_scene(pm.Scene([BLOCK], lights), RGB)


def write_image(path, pixels, kind="float"):
    import OpenImageIO

    file = OpenImageIO.ImageOutput.create(str(path))
    spec = OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    assert file.open(str(path), spec)
    assert file.write_image(pixels)
    file.close()
    return path


def test_images_of_many_kinds(tmp_path):
    texels = sky(4).astype(np.float32)
    np.testing.assert_array_equal(read_panorama(write_image(tmp_path / "a.exr", texels)), texels)
    hdr = read_panorama(write_image(tmp_path / "a.hdr", texels))
    np.testing.assert_allclose(hdr, texels, rtol=0.02, atol=0.02 * texels.max(axis=2).max())
    coded = np.full((2, 4, 3), 188, np.uint8)
    coded[0, 0] = [0, 10, 255]
    linear = read_panorama(write_image(tmp_path / "a.png", coded, "uint8"))
    np.testing.assert_allclose(linear[1, 1], ((188 / 255 + 0.055) / 1.055) ** 2.4, rtol=1e-6)
    np.testing.assert_allclose(linear[0, 0], [0.0, 10 / 255 / 12.92, 1.0], rtol=1e-6)
    with_alpha = np.concatenate([texels, np.ones((4, 8, 1), np.float32)], axis=2)
    np.testing.assert_array_equal(
        read_panorama(write_image(tmp_path / "b.exr", with_alpha)), texels
    )


def test_bytes_are_srgb_as_in_files_and_textures(tmp_path):
    coded = np.arange(4 * 8 * 3, dtype=np.uint8).reshape(4, 8, 3)
    linear = read_panorama(write_image(tmp_path / "a.png", coded, "uint8"))
    np.testing.assert_allclose(check_panorama(coded, "sky"), linear, rtol=1e-6)
    everywhere = slice(None), slice(None)
    np.testing.assert_allclose(pm.Texture.of(coded).image.linear(*everywhere), linear, rtol=1e-6)
    np.testing.assert_array_equal(check_panorama(coded.astype(int), "sky"), coded)
    with pytest.raises(pm.InputError, match="sky: texels must not be uint16; divide by 65535"):
        check_panorama(coded.astype(np.uint16), "sky")


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
def test_bad_pixels_are_named(tmp_path, value):
    texels = sky(4).astype(np.float32)
    texels[2, 5, 1] = value
    path = write_image(tmp_path / "bad.exr", texels)
    message = rf"bad\.exr: pixel \(row 2, column 5\) is {value:g}; give finite values"
    with pytest.raises(pm.InputError, match=message):
        read_panorama(path)
    with pytest.raises(pm.InputError, match=r"'environment': pixel \(row 2, column 5\)"):
        compile_scene(pm.Scene([BLOCK], [pm.EnvironmentLight(texels)]), RGB)


def test_bad_images(tmp_path):
    with pytest.raises(pm.InputError, match=r"a\.exr: is 6x4; .*twice"):
        read_panorama(write_image(tmp_path / "a.exr", np.ones((4, 6, 3), np.float32)))
    with pytest.raises(pm.InputError, match=r"b\.exr: has no channel R"):
        read_panorama(write_image(tmp_path / "b.exr", np.ones((4, 8, 1), np.float32)))
    (tmp_path / "c.exr").write_text("no image")
    with pytest.raises(pm.InputError, match=r"c\.exr: cannot be read as an image \("):
        read_panorama(tmp_path / "c.exr")
