"""Glass that varies over its surface, and surfaces that are glass in part."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers.scenes import GREY, closed_box, quad

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.kernels.geometry.pane import pane_reflectance
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()
COLOR = (0.75, 0.5, 0.25)
"""Which float32 represents: another last digit would be another path."""
SMALL = {"bands": 3, "size": (12, 12), "threads": 2}
SEEDS = 6
WHITE = {"reflectance": 1.0, "glossy": 0.04}
GLASS, PANE = pm.Material.glass("glass"), pm.Material.pane("glass")


def even(value):
    """Return a texture of one value all over."""
    values = np.broadcast_to(np.asarray(value, np.float32), (2, 2, np.size(value)))
    return pm.Texture.of(values)


def random(seed, channels=1, low=0.0):
    return pm.Texture.of(np.random.default_rng(seed).uniform(low, 1.0, (8, 8, channels)))


def ball(material, x=0.0):
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=0.25)
    uv = 2.0 * sphere.vertices[:, :2] + 0.5
    return pm.Mesh(sphere.vertices + [x, -0.4, -0.2], sphere.faces, material, f"ball {x}", uv=uv)


def balls(*materials):
    """Return balls beside each other: one scene, since each set of materials is compiled anew."""
    return [ball(m, -0.6 + 0.6 * place) for place, m in enumerate(materials)]


def room(*materials):
    corners = (-0.4, 0.9, -0.4), (0.4, 0.9, -0.4), (0.4, 0.9, 0.4), (-0.4, 0.9, 0.4)
    lamp = quad(*corners, pm.Material("lamp", 0.0, 20.0), "lamp")
    camera = pm.Camera((0.0, 0.1, 0.95), (0.0, -0.2, -1.0), fov=80.0)
    return pm.Scene([closed_box(GREY), lamp, *balls(*materials)], camera=camera)


def test_even_textures_are_their_numbers():
    numbers = (
        replace(GLASS, tint=COLOR, roughness=0.5),
        replace(PANE, tint=COLOR),
        replace(GLASS, transmission=0.25, reflectance=COLOR, glossy=0.04),
    )
    textures = (
        replace(GLASS, tint=even(COLOR), roughness=even(0.5)),
        replace(PANE, tint=even(COLOR)),
        replace(GLASS, transmission=even(0.25), reflectance=COLOR, glossy=0.04),
    )
    settings = SMALL | {"passes": 2, "photons": 1000, "bands": "rgb"}
    wanted, found = (pm.render(room(*materials), **settings) for materials in (numbers, textures))
    for name, image in wanted.buffers.items():
        np.testing.assert_allclose(found[name], image, rtol=1e-4, atol=1e-5, err_msg=name)


@pytest.mark.slow
def test_the_sun_through_a_stained_window():
    """Each side of the floor has the colour of the pane above it."""
    colors = np.array([[[0.8, 0.4, 0.2], [0.2, 0.6, 0.9]]])
    texels = np.repeat(np.repeat(colors, 2, axis=0), 256, axis=1)
    pane = replace(PANE, tint=pm.Texture.of(texels, clamp=True))
    uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    corners = [[-2, 1, 2], [2, 1, 2], [2, 1, -2], [-2, 1, -2]]
    window = pm.Mesh(np.array(corners, float), [[0, 1, 2], [0, 2, 3]], pane, "window", uv=uv)
    floor = quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1), pm.Material("floor", 0.5), "floor")
    camera = pm.Camera((0, 0.5, 0), (0, 0, 0), up=(0, 0, -1), fov=40)
    scene = pm.Scene([floor, window], [pm.DirectionalLight((0.0, -1.0, 0.0), 2.0)], camera)
    result = pm.render(scene, bands="rgb", size=(32, 32), passes=128, seed=4)
    passed = 2.0 * 0.5 / np.pi * (1.0 - pane_reflectance(1.5, 1.0))
    for half, color in zip((slice(0, 9), slice(23, 32)), colors[0], strict=True):
        light = result.radiance[:, half].mean(axis=(0, 1))
        np.testing.assert_allclose(light, passed * color, rtol=0.03)  # four standard deviations
        direct = result.direct[:, half].mean(axis=(0, 1))
        np.testing.assert_allclose(direct, passed * color.min(), rtol=0.03)


def test_buffers_of_what_is_glass_in_part():
    quarter = replace(GLASS, transmission=even(0.25), reflectance=0.8, roughness=even(0.3))
    scene = replace(room(quarter), camera=pm.Camera((-0.6, -0.4, 0.9), (-0.6, -0.4, 0), fov=5.0))
    names = ("radiance", "reflectance", "diffuse_fraction", "roughness")
    result = pm.render(scene, bands="rgb", size=(4, 4), passes=1, buffers=names)
    np.testing.assert_allclose(result.reflectance, 0.75 * 0.8, rtol=1e-5)
    np.testing.assert_allclose(result["diffuse_fraction"], 0.6 / (0.6 + 0.25), rtol=1e-5)
    np.testing.assert_allclose(result["roughness"], 0.3, rtol=1e-5)


def test_only_what_varies_is_compiled():
    specular = compile_scene(room(GLASS), RGB).specular
    assert specular.maps is None
    assert specular.glass is None
    specular = compile_scene(room(replace(GLASS, tint=even(COLOR))), RGB).specular
    assert specular.maps is not None
    assert specular.glass is None
    part = replace(GLASS, transmission=0.5, **WHITE)
    compiled = compile_scene(room(part), RGB)
    assert compiled.specular.maps is None
    assert compiled.specular.glass.maps is None
    assert compiled.scattering.glass is not None


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"transmission": 1.5}, "'glass': transmission 1.5 is not a fraction; give a number from"),
        ({"reflectance": 0.5}, "set its reflectance to 0, or its transmission below 1"),
        ({"glossy": 0.04}, "set its glossy to 0, or its transmission below 1"),
        ({"mirror": 0.5, "transmission": 0.5}, "'glass' is glass; set its mirror to 0"),
        (
            {
                "transmission": even(0.5),
                "reflectance": replace(even(COLOR), scale=(2.0, 1.0)),
            },
            "textures of transmission and reflectance must both be Textures of one scale",
        ),
    ],
)
def test_bad_glass(values, message):
    with pytest.raises(pm.InputError) as error:
        pm.render(room(replace(GLASS, **values)), bands="rgb", size=(4, 4), passes=1)
    assert message in str(error.value).replace("transmission: ", "transmission ")


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_it(tmp_path, suffix):
    texels = np.random.default_rng(8).integers(0, 256, (4, 4, 3), dtype=np.uint8)
    color = pm.Texture.of(texels)
    share = pm.Texture.of(texels[..., :1], srgb=False)
    rough = pm.Texture.of(texels[..., 1:2], srgb=False)
    stained = pm.Material("stained", 0.0, ior=1.4, tint=color, roughness=rough)
    part = pm.Material("part", color, ior=1.5, tint=color, transmission=share, glossy=0.04)
    path = tmp_path / f"scene{suffix}"
    pm.save_scene(pm.Scene([ball(stained), replace(ball(part), name="other")]), path)
    found = {mesh.material.name: mesh.material for mesh in pm.load_scene(path).meshes}
    assert found["stained"].ior == pytest.approx(1.4)
    for name, wanted in (("tint", color), ("roughness", rough)):
        same(getattr(found["stained"], name), wanted)
    for name, wanted in (("tint", color), ("reflectance", color), ("transmission", share)):
        same(getattr(found["part"], name), wanted)
    assert found["part"].glossy == pytest.approx(0.04)


def same(found, wanted):
    values = [
        t.image.linear(slice(None), slice(None)) * np.float32(t.factor) for t in (found, wanted)
    ]
    np.testing.assert_allclose(*values, atol=1e-4)


def test_glass_in_part_by_toml(tmp_path):
    pm.save_scene(room(pm.Material("ball", 0.8)), tmp_path / "scene.obj")
    glass = by_toml(tmp_path, "ior = 1.5\ntransmission = 0.25\nglossy = 0.04\n")
    assert (glass.transmission, glass.glossy, glass.reflectance) == (0.25, 0.04, 0.8)


def by_toml(folder, section):
    """Return the material of a ball that a TOML file changes."""
    (folder / "scene.toml").write_text(f"mesh = 'scene.obj'\n[material.ball]\n{section}")
    meshes = pm.load_scene(folder / "scene.toml").meshes
    return next(mesh.material for mesh in meshes if mesh.name.startswith("ball"))


@pytest.mark.parametrize("metal", ["'metal:Cu'", "0.9\nglossy_edge = [0.5, 0.6, 0.7]"])
def test_metal_beside_glass_keeps_its_edge(tmp_path, metal):
    """As metal by itself, in files of its own and others', and in kernels."""
    pm.save_scene(room(pm.Material("ball", 0.8)), tmp_path / "scene.obj")
    section = f"reflectance = 0.0\nroughness = 0.5\nglossy = {metal}\n"
    alone = by_toml(tmp_path, section)
    beside = by_toml(tmp_path, section + "ior = 1.5\ntransmission = 0.5\n")
    wanted = compile_scene(room(alone), RGB).scattering.dip
    assert wanted.any()
    np.testing.assert_array_equal(compile_scene(room(beside), RGB).scattering.dip, wanted)
    pm.save_scene(room(beside), tmp_path / "written.obj")
    found = {mesh.material.name: mesh for mesh in pm.load_scene(tmp_path / "written.obj").meshes}
    kept = compile_scene(room(found["ball"].material), RGB).scattering.dip
    np.testing.assert_allclose(kept, wanted, atol=1e-4)


def test_white_glass_in_part_vanishes_in_even_light():
    """Photons linger in it and lose nothing: none grows, or a few would bring all of the light."""
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=0.6)
    white = pm.Material("white", 1.0, ior=1.7, transmission=0.5)
    ball = pm.Mesh(sphere.vertices, sphere.faces, white, "ball")
    camera = pm.Camera((0.3, 0.5, 2.5), (0.0, 0.0, 0.0), fov=24.0)
    scene = pm.Scene([ball], [pm.DomeLight(1.0)], camera)
    result = pm.render(scene, bands=1, size=(16, 16), passes=10, photons=20_000)
    means = result.radiance.mean()
    assert result.standard_error("radiance").max() < 0.1
    assert means == pytest.approx(1.0, abs=0.006)


@pytest.mark.parametrize(
    "layer",
    [
        pm.Material("layer", 0.6, ior=1.0, transmission=0.5),
        pm.Material("layer", 0.6, alpha=0.5),
    ],
    ids=["glass in part", "alpha"],
)
def test_layers_do_not_share_caustics(layer):
    """What light passes, and a floor in its light, however near: each has the photons of its own.

    Those of the floor counted for a layer of glass and white 5 mm above it, whose caustics doubled.
    Nothing here refracts, so that the gap does not matter; the least is that of things that touch.
    """
    sun, sides = pm.DirectionalLight((0.0, -1.0, 0.0), 1.0), ((-2.0, 2.0), (-2.0, 2.0))
    camera = pm.Camera((0.0, 1.0, 0.5), (0.0, 0.0, 0.0), fov=20.0)

    def sheet(low, high, material):
        (left, right), (back, front) = sides
        box = trimesh.creation.box(bounds=[[left, low, back], [right, high, front]])
        return pm.Mesh(box.vertices, box.faces, material, material.name)

    def mean(gap):
        floor = quad((-3, -gap, -3), (-3, -gap, 3), (3, -gap, 3), (3, -gap, -3), GREY, "floor")
        cover = sheet(0.5, 0.52, pm.Material.glass("air", 1.0))
        scene = pm.Scene([floor, sheet(0.0, 0.02, layer), cover], [sun], camera)
        return pm.render(scene, **SMALL, passes=8).caustics.mean()

    assert [mean(0.0002), mean(0.005)] == pytest.approx([mean(0.2)] * 2, rel=0.02)
