"""Scenes are written so that reading them gives the same arrays and the same picture."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.dataset.scenes.build import build_scene
from photonmap.dataset.scenes.recolor import recolor, relight
from photonmap.errors import InputError
from photonmap.spectra.observer import luminance, observer

from helpers.scenes import quad  # isort: skip


def saved(scene, folder, name="room.obj"):
    pm.save_scene(scene, folder / name)
    return pm.load_scene(folder / name)


def assert_same_meshes(first, second):
    for a, b in zip(first.meshes, second.meshes, strict=True):
        assert (a.name, a.material) == (b.name, b.material)
        for rows in ("vertices", "faces", "normals", "uv"):
            np.testing.assert_array_equal(getattr(a, rows), getattr(b, rows))


def assert_same_picture(first, second):
    settings = {"bands": 3, "size": (16, 12), "passes": 1, "photons": 1 << 12}
    a, b = pm.render(first, **settings), pm.render(second, **settings)
    for name in a.buffers:
        np.testing.assert_array_equal(a.buffers[name], b.buffers[name])


@pytest.mark.filterwarnings("ignore:luminance by these bands")
@pytest.mark.parametrize(
    ("name", "illumination", "materials"),
    [("bathroom", "two_mixed", "mixed"), ("jug", "two_planckian", "lambertian")],
)
def test_data_set_scenes_return(tmp_path, name, illumination, materials):
    """Without warnings, which are errors in tests."""
    scene = build_scene(name, 3, illumination, materials)
    again = saved(scene, tmp_path)
    assert_same_meshes(scene, again)
    assert again.camera == scene.camera
    assert again.name == "room"
    assert_same_picture(scene, again)


def test_the_cornell_box_returns(tmp_path, cornell):
    again = saved(cornell, tmp_path)
    assert_same_meshes(cornell, again)
    assert_same_picture(cornell, again)


def test_lights_return(tmp_path):
    sky = np.arange(24.0).reshape(2, 4, 3).astype(np.float32)
    lights = [
        pm.PointLight((1, 2, 3), pm.emission("D65 2"), "lamp"),
        pm.SpotLight((0, 1, 0), (0, 0, 0), (1.0, 0.5, 0.25), 10.0, 25.5, "stage", "theatre"),
        pm.DirectionalLight((0, -1, 0.1), 3.0),
        pm.EnvironmentLight(sky, 0.5, 90.0, 'the "sky"'),
    ]
    floor = quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1))
    camera = pm.Camera((0, 1, 3), (0, 0.1, 0), (0, 1, 0.1), 33.3)
    again = saved(pm.Scene([floor], lights, camera), tmp_path)
    assert again.lights[:3] == lights[:3]
    assert vars(again.camera) == vars(camera)
    read = again.lights[3]
    assert (read.scale, read.rotation, read.name) == (0.5, 90.0, 'the "sky"')
    np.testing.assert_array_equal(read.image, sky)


def test_materials_return(tmp_path):
    stripes = pm.Spectrum([400, 500, 700], [0.1, 0.7, 0.3], extrapolate=True)
    materials = [
        pm.Material("wall", stripes),
        pm.Material("wall", 0.25, emission=(3.0, 2.0, 1.0)),
        pm.Material("coat", (0.2, 0.3, 0.4), mirror=0.05),
        pm.Material.polished("steel", stripes),
        pm.Material.glass("green glass", 1.45, (0.5, 0.9, 0.5)),
        pm.Material("gauze", 0.5, alpha=0.25),
        pm.Material("lamp", 0.0, emission=stripes * 7.0),
    ]
    meshes = [
        quad((i, 0, 0), (i + 1, 0, 0), (i + 1, 1, 0), (i, 1, 0), material, f"part {i}")
        for i, material in enumerate(materials)
    ]
    again = [mesh.material for mesh in saved(pm.Scene(meshes), tmp_path).meshes]
    assert [material.name for material in again][:2] == ["wall", "wall 2"]
    for wanted, read in zip(materials, again, strict=True):
        for attribute in ("reflectance", "emission", "mirror", "ior", "tint", "alpha"):
            assert getattr(read, attribute) == getattr(wanted, attribute), wanted.name


def test_textures_return(tmp_path):
    rng = np.random.default_rng(0)
    bytes_ = pm.Texture.of(rng.integers(0, 256, (4, 5, 3), dtype=np.uint8), factor=(0.5, 1.0, 0.75))
    floats = pm.Texture.of(rng.random((3, 3)), scale=(2.0, 3.0), offset=(0.25, -0.5), clamp=True)
    mask = pm.Texture.of(rng.random((3, 4)))
    uv = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    panels = [
        quad((i, 0, 0), (i + 1, 0, 0), (i + 1, 1, 0), (i, 1, 0), material, material.name)
        for i, material in enumerate(
            [
                pm.Material("wall", bytes_),
                pm.Material("screen", 0.0, emission=floats),
                pm.Material("veil", 0.5, alpha=mask),
            ]
        )
    ]
    meshes = [pm.Mesh(p.vertices, p.faces, p.material, p.name, uv=uv) for p in panels]
    wall, screen, veil = saved(pm.Scene(meshes), tmp_path).meshes
    np.testing.assert_array_equal(wall.uv, uv)
    linear = bytes_.image.linear(slice(None), slice(None)) * np.array(bytes_.factor)
    np.testing.assert_allclose(wall.material.reflectance.image.texels, linear, rtol=1e-6)
    glow = screen.material.emission
    assert (glow.scale, glow.offset, glow.clamp) == ((2.0, 3.0), (0.25, -0.5), True)
    np.testing.assert_allclose(glow.image.texels[..., 0], floats.image.texels[..., 0], rtol=1e-6)
    opacity = veil.material.alpha.image
    np.testing.assert_allclose(
        opacity.linear(slice(None), slice(None)).mean(axis=2), mask.image.texels[..., 0], rtol=1e-6
    )


@pytest.mark.parametrize("looked_up", [{"clamp": (True, False)}, {"nearest": True}])
def test_what_mtl_cannot_say_of_textures_is_named(tmp_path, looked_up):
    texture = pm.Texture.of(np.eye(3), **looked_up)
    panel = quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), pm.Material("wall", texture))
    with pytest.warns(pm.SceneWarning, match="wall.* is written as a texture that is interpolated"):
        pm.save_scene(pm.Scene([panel]), tmp_path / "a.obj")


def test_what_no_face_uses_is_left_out(tmp_path):
    vertices = np.array([(9, 9, 9), (0, 0, 0), (1, 0, 0), (0, 1, 0)], float)
    normals = np.array([(0, 0, 1)] * 4, float)
    scene = pm.Scene(
        [
            pm.Mesh(vertices, [[1, 2, 3]], pm.Material("a"), "first", normals),
            pm.Mesh(vertices, np.empty((0, 3)), pm.Material("b"), "none"),
            pm.Mesh(vertices, [[3, 2, 1]], pm.Material("a", 0.2), "second"),
        ]
    )
    first, second = saved(scene, tmp_path).meshes
    np.testing.assert_array_equal(first.vertices, vertices[1:])
    np.testing.assert_array_equal(first.normals, normals[1:])
    assert second.normals is None
    assert (second.material.name, second.material.reflectance) == ("a 2", 0.2)


def test_saving_again_replaces(tmp_path, cornell):
    saved(build_scene("castle", 0), tmp_path)
    again = saved(cornell, tmp_path)
    assert_same_meshes(cornell, again)


@pytest.mark.parametrize(
    ("mesh", "material", "file", "message"),
    [
        ("a\nb", "m", "x.obj", "mesh: the name 'a\\nb' cannot be written"),
        ("two  spaces", "m", "x.obj", "mesh: the name 'two spaces' cannot be written"),
        ("a #1", "m", "x.obj", "mesh: the name 'a #1' cannot be written"),
        ("a", "back\\slash", "x.obj", "material: the name"),
        ("a", "m", "x.ply", "x.ply: does not end in one of .obj, .glb, .gltf"),
        ("a", "m", "a #b.obj", "the name 'a #b' cannot be written"),
    ],
)
def test_what_cannot_be_written(tmp_path, mesh, material, file, message):
    panel = quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), pm.Material(material), mesh)
    with pytest.raises(InputError, match=r"^[^\n]+$") as caught:
        pm.save_scene(pm.Scene([panel]), tmp_path / file)
    assert message in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_a_missing_folder_is_made(tmp_path):
    panel = quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
    pm.save_scene(pm.Scene([panel]), tmp_path / "some" / "where" / "x.obj")
    assert len(pm.load_scene(tmp_path / "some" / "where" / "x.obj").meshes) == 1


def test_an_empty_scene_is_not_written(tmp_path):
    with pytest.raises(InputError, match="has no faces: there is nothing to write"):
        pm.save_scene(pm.Scene(name="void"), tmp_path / "x.obj")
    assert not list(tmp_path.iterdir())


def test_relit_lamps_keep_their_luminance(cornell):
    lamp = next(m.material for m in cornell.meshes if m.name == "light")
    relit = relight(cornell, "colored", 1)
    after = next(m.material for m in relit.meshes if m.name == "light")
    assert luminance(after.emission) == pytest.approx(luminance(lamp.emission))
    assert after.reflectance == lamp.reflectance
    for a, b in zip(cornell.meshes, relit.meshes, strict=True):
        assert b.vertices is a.vertices
        if a.name != "light":
            assert b.material is a.material
    again = relight(cornell, "colored", 1)
    assert [m.material for m in again.meshes] == [m.material for m in relit.meshes]


def test_two_colours_go_to_two_groups():
    floor = quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1))
    lights = [
        pm.PointLight((0, 1, 0), 2.0, "a", "left"),
        pm.PointLight((1, 1, 0), (1.0, 0.5, 0.2), "b", "left"),
        pm.SpotLight((0, 1, 0), (0, 0, 0), 3.0, name="c"),
    ]
    relit = relight(pm.Scene([floor], lights), "two_planckian", 0).lights
    assert [luminance(light.color) for light in relit] == pytest.approx(
        [luminance(light.color) for light in lights]
    )
    shapes = [light.color.values / luminance(light.color) for light in relit]
    np.testing.assert_allclose(shapes[0], shapes[1])
    assert np.abs(shapes[0] - shapes[2]).max() > 0.1


def test_maps_take_the_colour_of_light():
    sky = np.random.default_rng(0).random((4, 8, 3)) * (0.2, 0.5, 1.0)
    screen = pm.Texture.of(np.random.default_rng(1).random((4, 4, 3)))
    uv = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    panel = quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
    material = pm.Material("screen", 0.0, emission=screen)
    mesh = pm.Mesh(panel.vertices, panel.faces, material, "screen", uv=uv)
    relit = relight(pm.Scene([mesh], [pm.EnvironmentLight(sky)]), "colored", 3)
    weights = observer().rgb_to_xyz[1]
    np.testing.assert_allclose(relit.lights[0].image @ weights, sky @ weights, rtol=1e-5)
    glow = relit.meshes[0].material.emission
    assert np.dot(weights, glow.mean) == pytest.approx(np.dot(weights, screen.mean), rel=1e-5)
    assert np.ptp(np.array(glow.mean)) > 0.1


def test_a_scene_without_light_gets_a_dome():
    scene = pm.Scene([quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))])
    (dome,) = relight(scene, "white").lights
    assert luminance(dome.radiance) == pytest.approx(1.0)


def test_one_lamp_takes_one_colour(cornell):
    with pytest.raises(
        InputError, match=r"box': has fewer light groups \(light\) than the 2 colours of .*; choose"
    ):
        relight(cornell, "two_mixed")


def test_recolored_surfaces_are_chips(cornell):
    plain = recolor(cornell, 1)
    by_name = {m.material.name: m.material for m in plain.meshes}
    before = {m.material.name: m.material for m in cornell.meshes}
    assert by_name["light"] is before["light"]
    assert isinstance(by_name["red"].reflectance, pm.Spectrum)
    assert by_name["red"].reflectance != by_name["green"].reflectance
    assert [m.material for m in recolor(cornell, 1).meshes] == [m.material for m in plain.meshes]
    some = {m.material.name: m.material for m in recolor(cornell, 1, ["red"]).meshes}
    assert some["green"] is before["green"]
    assert some["red"] != before["red"]


def test_glass_and_mirrors_stay():
    panel = quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
    kept = [pm.Material.glass(), pm.Material.polished(), pm.Material("black", 0.0)]
    coated = pm.Material("coated", 0.5, mirror=0.1)
    meshes = [pm.Mesh(panel.vertices, panel.faces, m, m.name) for m in [*kept, coated]]
    after = [mesh.material for mesh in recolor(pm.Scene(meshes), 0).meshes]
    assert after[:3] == kept
    assert (after[3].mirror, isinstance(after[3].reflectance, pm.Spectrum)) == (0.1, True)
