"""Colours of vertices of glTF files: linear, and a factor of the base colour."""

import numpy as np
import pytest
from helpers.meshes import TRIANGLE

import photonmap as pm
from photonmap.errors import SceneWarning

COLORS = np.array([[0.25, 0.5, 1], [0, 1, 0.125], [1, 0.75, 0]])
MEAN = COLORS.mean(axis=0)
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]], "<f4")


def colored(build, colors=COLORS, material=None, normalized=True, **attributes):
    """Make a triangle with colours."""
    accessor = build.add(colors, **({"normalized": True} if normalized else {}))
    more = {} if material is None else {"material": 0}
    build.primitive(COLOR_0=accessor, more=more, **attributes)
    if material is not None:
        build.tree["materials"] = [{"name": "a", **material}]


def matte(metallic=0, **more):
    return {"pbrMetallicRoughness": {"metallicFactor": metallic, **more}}


@pytest.mark.parametrize(
    "values",
    [
        COLORS.astype("<f4"),
        np.rint(COLORS * 255).astype("u1"),
        np.rint(COLORS * 65535).astype("<u2"),
        np.c_[COLORS, np.ones(3)].astype("<f4"),
    ],
)
def test_types(read, build, values):
    values = np.c_[values, np.zeros(3, values.dtype)] if values.itemsize == 1 else values
    colored(build, values, matte(baseColorFactor=[0.5, 1, 0.25, 1]))
    (mesh,) = read("a.glb", build.glb())
    steps = 255 if values.itemsize == 1 else 65535
    np.testing.assert_allclose(mesh.colors, COLORS * [0.5, 1, 0.25], atol=0.51 / steps)


def test_without_a_material(read, build):
    colored(build)
    (mesh,) = read("a.glb", build.glb())
    np.testing.assert_array_equal(mesh.colors, COLORS)
    assert mesh.material.name == "default"
    np.testing.assert_allclose(mesh.material.reflectance, MEAN)


def test_colours_of_unused_vertices_do_not_count(read, build):
    colors = [*COLORS, [0, 0, 0]]
    colored(build, np.array(colors), POSITION=SQUARE, indices=[0, 1, 2])
    (mesh,) = read("a.glb", build.glb())
    np.testing.assert_array_equal(mesh.colors, COLORS)
    np.testing.assert_allclose(mesh.material.reflectance, MEAN)


def test_constant_colours_are_factors(read, build):
    """White, which many programs write, changes nothing."""
    colored(build, np.ones((3, 3)), matte(baseColorFactor=[0.5, 1, 0.25, 1]))
    colored(build, np.tile(COLORS[:1], (3, 1)), matte(baseColorFactor=[0.5, 1, 0.25, 1]))
    plain, tinted = read("a.glb", build.glb())
    assert plain.colors is None
    assert plain.material.reflectance == (0.5, 1.0, 0.25)
    assert tinted.colors is None
    np.testing.assert_allclose(tinted.material.reflectance, COLORS[0] * [0.5, 1, 0.25])


def test_opacity(read, build):
    rgba = np.c_[np.ones((3, 3)), [0.5] * 3]
    colored(build, rgba, matte(baseColorFactor=[1, 1, 1, 0.5]) | {"alphaMode": "BLEND"})
    (mesh,) = read("a.glb", build.glb())
    assert mesh.material.alpha == 0.25
    del build.tree["materials"][0]["alphaMode"]
    assert read("a.glb", build.glb())[0].material.alpha == 1.0


def test_opacity_that_varies(read, build):
    rgba = np.c_[COLORS, [0.25, 0.5, 0.75]]
    colored(build, rgba, matte() | {"alphaMode": "BLEND"})
    message = "not simulated: variation of opacity of vertices of 'a'$"
    with pytest.warns(SceneWarning, match=message):
        (mesh,) = read("a.glb", build.glb())
    assert mesh.material.alpha == 0.5
    np.testing.assert_array_equal(mesh.colors, COLORS)


def test_metals_have_the_mean(read, build):
    colored(build, COLORS, matte(0.25))
    with pytest.warns(SceneWarning, match="not simulated: variation of a metal's colour of 'a'$"):
        (mesh,) = read("a.glb", build.glb())
    np.testing.assert_allclose(mesh.colors, 0.75 * COLORS)
    np.testing.assert_allclose(mesh.material.glossy, 0.25 * MEAN + 0.75 * 0.04)


def test_textures_and_glass_have_the_mean(read, build, tmp_path):
    volume = {"KHR_materials_volume": {"thicknessFactor": 1}}
    glass = {"KHR_materials_transmission": {"transmissionFactor": 1}} | volume
    colored(build, COLORS, matte(roughnessFactor=0) | {"extensions": glass})
    message = "not simulated: variation of colours of vertices of 'a'$"
    with pytest.warns(SceneWarning, match=message):
        (mesh,) = read("a.glb", build.glb())
    assert mesh.colors is None
    np.testing.assert_allclose(mesh.material.tint, MEAN)
    pm.scene.images.write_image(np.ones((1, 1, 3)), tmp_path / "wood.exr")
    build.tree |= {"images": [{"uri": "wood.exr"}], "textures": [{"source": 0}]}
    build.tree["materials"] = [{"name": "a", **matte(baseColorTexture={"index": 0})}]
    with pytest.warns(SceneWarning, match=message):
        (mesh,) = read("a.glb", build.glb())
    assert mesh.colors is None
    np.testing.assert_allclose(mesh.material.reflectance.factor, MEAN)


def test_colours_of_another_shape(read, build):
    build.primitive(COLOR_0=TRIANGLE[:, :2])
    with pytest.raises(pm.InputError, match="COLOR_0 has the wrong shape"):
        read("a.glb", build.glb())
