"""Glass that absorbs: the Beer–Lambert law through slabs, things inside, and the path tracer."""

import numpy as np
import pytest
import trimesh

import photonmap as pm

COLOR = (0.8, 0.5, 0.1)
BOX = pm.scenes.cornell_box()


def jelly(ior=1.5, color=COLOR, distance=0.5, **more):
    look = {"ior": ior, "attenuation_color": color, "attenuation_distance": distance}
    return pm.Material("jelly", 0.0, **look, **more)


def body(mesh, material, name="body"):
    return pm.Mesh(mesh.vertices, mesh.faces, material, name)


def slab(thickness, material):
    return body(trimesh.creation.box((4, 4, thickness)), material)


def lamp(z):
    corners = np.array([[-4, -4, z], [4, -4, z], [4, 4, z], [-4, 4, z]], float)
    return pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], pm.Material("lamp", 0.0, 1.0), "lamp")


@pytest.mark.parametrize("method", ["photon", "path"])
@pytest.mark.parametrize("thickness", [0.1, 1.0])
def test_a_slab_before_a_lamp(thickness, method):
    """T² a / (1 - R² a²), by the geometric series of reflections, with a = c^(thickness / d)."""
    camera = pm.Camera((0, 0, 5), (0, 0, 0), fov=0.5)
    scene = pm.Scene([slab(thickness, jelly()), lamp(-1.0)], [], camera)
    settings = {"bands": "rgb", "size": (16, 16), "photons": 100, "seed": 2}
    result = pm.render(scene, **settings, passes=64, method=method)
    inside = np.array(COLOR) ** (thickness / 0.5)
    wanted = 0.96**2 * inside / (1.0 - 0.04**2 * inside**2)
    np.testing.assert_allclose(result.emission.mean(axis=(0, 1)), wanted, rtol=0.01)
    assert result.record["effects"]["media"]["on"]


def test_what_has_the_index_of_air_absorbs_alone():
    """Exactly: a chain is never reflected, along slanting rays either."""
    camera = pm.Camera((3, 0, 4), (0, 0, 0), fov=0.5)
    scene = pm.Scene([slab(0.5, jelly(1.0)), lamp(-1.0)], [], camera)
    result = pm.render(scene, bands="rgb", size=(4, 4), passes=2, pixel="center")
    wanted = np.array(COLOR) ** (5.0 / 4.0)
    np.testing.assert_allclose(result.emission.mean(axis=(0, 1)), wanted, rtol=2e-3)


@pytest.mark.parametrize("method", ["photon", "path"])
def test_a_camera_inside(method):
    camera = pm.Camera((0, 0, 0.3), (0, 0, -1), fov=0.5)
    scene = pm.Scene([slab(1.0, jelly(1.0)), lamp(-1.0)], [], camera)
    result = pm.render(scene, bands="rgb", size=(4, 4), passes=2, method=method)
    wanted = np.array(COLOR) ** (0.8 / 0.5)
    np.testing.assert_allclose(result.emission.mean(axis=(0, 1)), wanted, rtol=1e-3)


def test_a_wall_inside():
    """Lit through a medium of index 1, and seen through it: c^(2 t / d) of what it is in air."""
    wall = trimesh.creation.box((1, 1, 0.2))
    sun = pm.DirectionalLight((0, 0, -1), 1.0)
    camera = pm.Camera((0, 0, 5), (0, 0, 0), fov=5)
    around = trimesh.creation.box((2, 2, 1.2))
    meshes = [body(wall, pm.Material("wall", 0.5), "wall"), body(around, jelly(1.0))]
    scene = pm.Scene(meshes, [sun], camera)
    settings = {"bands": "rgb", "size": (16, 16), "passes": 16, "seed": 3}
    result = pm.render(scene, **settings)
    inside = np.array(COLOR) ** (2.0 * 0.5 / 0.5)
    found = result.radiance.mean(axis=(0, 1)) * np.pi
    np.testing.assert_allclose(found, 0.5 * inside, rtol=0.03)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0)])
def test_bodies_in_bodies(order):
    """A wall in a body of index 1 in a larger one of another colour; in any order of the file."""
    boxes = [(1, 1, 0.2), (2, 2, 1.2), (3, 3, 2.2)]
    looks = [pm.Material("wall", 0.5), jelly(1.0), jelly(1.0, (0.3, 0.9, 0.7))]
    meshes = [
        body(trimesh.creation.box(size), look, f"body {index}")
        for index, (size, look) in enumerate(zip(boxes, looks, strict=True))
    ]
    camera = pm.Camera((0, 0, 5), (0, 0, 0), fov=5)
    scene = pm.Scene([meshes[i] for i in order], [pm.DirectionalLight((0, 0, -1), 1.0)], camera)
    result = pm.render(scene, bands="rgb", size=(16, 16), passes=16, seed=3)
    inside = np.array(COLOR) ** 2.0 * np.array((0.3, 0.9, 0.7)) ** 2.0
    found = result.radiance.mean(axis=(0, 1)) * np.pi
    np.testing.assert_allclose(found, 0.5 * inside, rtol=0.03)


def test_without_media_glass_is_clear():
    camera = pm.Camera((0, 0, 5), (0, 0, 0), fov=0.5)
    scene = pm.Scene([slab(1.0, jelly(1.0)), lamp(-1.0)], [], camera)
    wanted = ["emission", "direct", "specular", "transmission"]
    result = pm.render(scene, bands="rgb", size=(4, 4), passes=2, effects=wanted)
    np.testing.assert_allclose(result.emission, 1.0, rtol=1e-5)


@pytest.mark.parametrize(
    ("look", "message"),
    [
        ({"reflectance": 0.5, "attenuation_color": 0.5}, "only solid glass absorbs"),
        ({"ior": 1.5, "thin": True, "attenuation_color": 0.5}, "only solid glass absorbs"),
        ({"ior": 1.5, "attenuation_color": 0.5}, "needs an attenuation_distance"),
        ({"ior": 1.5, "attenuation_color": -0.5, "attenuation_distance": 1}, "outside of"),
        ({"ior": 1.5, "attenuation_distance": -1.0}, "give scene units above 0"),
    ],
)
def test_bad_media(look, message):
    material = pm.Material("m", **{"reflectance": 0.0, **look})
    scene = pm.Scene([slab(1.0, material), lamp(-1.0)], [], pm.Camera((0, 0, 5), (0, 0, 0)))
    with pytest.raises(pm.InputError, match=f"'m'.*{message}"):
        pm.render(scene, bands="rgb", size=(4, 4), passes=1)


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_media(tmp_path, suffix):
    scene = pm.Scene([slab(1.0, jelly(1.4))], [], pm.Camera((0, 0, 5), (0, 0, 0)))
    pm.save_scene(scene, tmp_path / f"scene{suffix}")
    material = pm.load_scene(tmp_path / f"scene{suffix}").meshes[0].material
    assert material.attenuation_distance == 0.5
    found = pm.Bands.rgb().reflectance(material.attenuation_color)
    np.testing.assert_allclose(found, COLOR, rtol=1e-6)
