"""Portals against holes that they close, closed forms, and area lights of the same radiance."""

import re

import numpy as np
import pytest
from helpers.marks import slow
from helpers.scenes import quad

import photonmap as pm

BLACK = pm.Material("black", 0.0)
PANE = pm.Material("pane", 0.0, portal=True)
LOW, HIGH, SIDE = 0.8, 1.6, 0.5
"""The opening in the wall at x = 1: its lower and upper edge, and half its width."""


def room(lights, pane=None, wall=0.6):
    """Return a box of 2 with an opening, closed by a pane if there is one."""
    look = pm.Material("wall", wall)
    walls = [
        ((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)),
        ((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)),
        ((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)),
        ((-1, 0, 1), (-1, 2, 1), (1, 2, 1), (1, 0, 1)),
        ((-1, 0, -1), (-1, 2, -1), (-1, 2, 1), (-1, 0, 1)),
        ((1, 0, -1), (1, 0, 1), (1, LOW, 1), (1, LOW, -1)),
        ((1, HIGH, -1), (1, HIGH, 1), (1, 2, 1), (1, 2, -1)),
        ((1, LOW, -1), (1, LOW, -SIDE), (1, HIGH, -SIDE), (1, HIGH, -1)),
        ((1, LOW, SIDE), (1, LOW, 1), (1, HIGH, 1), (1, HIGH, SIDE)),
    ]
    meshes = [quad(*corners, look, f"wall {k}") for k, corners in enumerate(walls)]
    if pane:
        opening = ((1, LOW, -SIDE), (1, LOW, SIDE), (1, HIGH, SIDE), (1, HIGH, -SIDE))
        meshes.append(quad(*opening, pane, "window"))
    return pm.Scene(meshes, lights, pm.Camera((-0.9, 1.0, 0.3), (1.0, 0.9, 0.0), fov=70.0))


def means(result, name):
    """Return the mean of a buffer by band, and its standard error from passes."""
    values, error = getattr(result, name).astype(np.float64), result.standard_error(name)
    return values.mean(axis=(0, 1)), np.sqrt((error.astype(np.float64) ** 2).sum(axis=(0, 1))) / (
        error[..., 0].size
    )


def test_a_portal_lets_in_what_a_hole_lets_in():
    """Paths find the hole at random: this shares no code with portals but the map's look-up."""
    sky = pm.SkyLight(3.0, 35.0, 70.0, ground=0.3)
    settings = {"bands": "rgb", "size": (24, 18)}
    hole = pm.render(room([sky]), method="path", passes=192, seed=1, **settings)
    for method in ("path", "photon"):
        portal = pm.render(room([sky], PANE), method=method, passes=24, seed=2, **settings)
        assert_as_bright(portal, hole, method)


def assert_as_bright(portal, hole, method):
    """Compare means of all light within 4 standard errors, and 2% of photons."""
    for name in ("direct", "indirect", "emission"):
        (wanted, spread), (found, error) = means(hole, name), means(portal, name)
        limit = 4.0 * np.hypot(spread, error) + 0.02 * wanted * (method == "photon")
        assert (np.abs(found - wanted) < limit).all(), (method, name)


def test_a_pane_that_shows_a_dome_is_an_area_light():
    colors = (0.9, 0.5, 0.2)
    lit = pm.Material("lamp", 0.0, emission=colors)
    settings = {"bands": "rgb", "size": (16, 12), "passes": 2, "seed": 3}
    portal = pm.render(room([pm.DomeLight(colors)], PANE), **settings)
    lamp = pm.render(room([], lit), **settings)
    for name in ("direct", "indirect", "emission"):
        np.testing.assert_array_equal(getattr(portal, name), getattr(lamp, name))


@pytest.mark.parametrize("towards", [(0.0, 1.0), (0.6, 0.8), (0.8, -0.6)])
def test_a_small_portal_sends_what_lies_beyond_it(towards):
    """Of a small pane, E = L cos θ cos θ' A / r²; L is that of the overcast sky in closed form."""
    ground, zenith, far, half = 0.4, 2.0, 5.0, 0.05
    way = np.array([towards[0], towards[1], 0.0])
    across, up = np.array([0.0, 0.0, 1.0]), np.array([-way[1], way[0], 0.0])
    corners = [far * way + half * (a * across + b * up) for a, b in
               ((-1, -1), (-1, 1), (1, 1), (1, -1))]  # fmt: skip
    if np.cross(corners[1] - corners[0], corners[2] - corners[0]) @ way > 0:
        corners.reverse()
    floor = [0.01 * (a * across + b * up) for a, b in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
    meshes = [quad(*corners, PANE, "pane"), quad(*floor, pm.Material("floor", 0.5), "floor")]
    camera = pm.Camera(tuple(0.2 * way), (0.0, 0.0, 0.0), up=(0.0, 0.0, 1.0), fov=2.0)
    scene = pm.Scene(meshes, [pm.OvercastLight(zenith, ground)], camera)
    found = pm.render(scene, bands=1, size=(4, 4), passes=4, method="path").shading.mean() * np.pi
    rise = towards[1]
    seen = zenith * (1.0 + 2.0 * rise) / 3.0 if rise > 0 else zenith * ground * 7.0 / 9.0
    assert found == pytest.approx(seen * (2.0 * half) ** 2 / far**2, rel=0.01)


def test_an_overcast_sky_lights_level_ground_and_that_what_is_above():
    """∫ (1 + 2 cos θ) / 3 cos θ dω = 7 π / 9."""
    light, ground = pm.OvercastLight((1.0, 2.0, 3.0), 0.5), pm.Material("floor", 1e-3)
    big = [(-9, 0, 9), (9, 0, 9), (9, 0, -9), (-9, 0, -9)]
    camera = pm.Camera((0.0, 1.0, 0.001), (0.0, 0.0, 0.0), fov=10.0)
    scene = pm.Scene([quad(*big, ground, "floor")], [light], camera)
    settings = {"bands": "rgb", "size": (8, 8), "passes": 16}
    for side, factor in ((1.0, 1.0), (-1.0, 0.5)):
        scene.camera = pm.Camera((0.0, side, 0.001), (0.0, 0.0, 0.0), fov=10.0)
        result = pm.render(scene, **settings)
        found, error = means(result, "shading")
        wanted = factor * 7.0 / 9.0 * np.array([1.0, 2.0, 3.0])
        assert (np.abs(found - wanted) < 5.0 * error + 2e-3 * wanted).all()


def test_light_through_portals_is_of_the_group_of_the_sky():
    lamp = pm.PointLight((-0.5, 1.8, 0.0), 0.3, "lamp")
    scene = room([pm.OvercastLight(group="window"), lamp], PANE)
    result = pm.render(scene, bands=2, size=(12, 9), passes=2, per_light=True)
    assert set(result.per_light) == {"window", "lamp"}
    whole = sum(buffers["direct"] for buffers in result.per_light.values())
    np.testing.assert_allclose(whole, result.direct, rtol=1e-5, atol=1e-7)
    assert all(buffers["direct"].any() for buffers in result.per_light.values())


def test_caustics_of_portals_carry_the_light_of_their_direction():
    """Photons are aimed at the mirror: what the path tracer finds at random agrees."""
    mirror = quad((-0.9, 0.05, -0.5), (-0.9, 0.05, 0.5), (0.4, 0.05, 0.5), (0.4, 0.05, -0.5),
                  pm.Material.polished(), "mirror")  # fmt: skip
    scene = room([pm.SkyLight(4.0, 20.0, 60.0)], PANE)
    scene.meshes.append(mirror)
    settings = {"bands": "rgb", "size": (16, 12)}
    wanted, spread = means(pm.render(scene, method="path", passes=192, **settings), "radiance")
    found, error = means(pm.render(scene, passes=24, **settings), "radiance")
    assert (np.abs(found - wanted) < 4.0 * np.hypot(spread, error) + 0.02 * wanted).all()


def test_portals_need_a_sky_and_nothing_of_their_own():
    lamp = pm.PointLight((0.0, 1.8, 0.0))
    with pytest.warns(pm.SceneWarning, match=r"portals \('pane'\) are black: there is no sky"):
        dark = pm.render(room([lamp], PANE), bands=1, size=(8, 6), passes=1)
    assert not dark.emission.any()
    both = pm.Material("pane", 0.0, emission=1.0, portal=True)
    with pytest.raises(pm.InputError, match="'pane' is a portal, and has an emission; remove one"):
        pm.render(room([pm.DomeLight()], both), bands=1, size=(8, 6), passes=1)


def test_files_have_portals_and_overcast_skies(tmp_path):
    pm.save_scene(room([pm.OvercastLight(pm.emission("D65 2"), 0.2)], PANE), tmp_path / "room.obj")
    scene = pm.load_scene(tmp_path / "room.obj")
    assert [mesh.name for mesh in scene.meshes if mesh.material.portal] == ["window"]
    assert isinstance(scene.lights[0], pm.OvercastLight)
    assert scene.lights[0].ground == 0.2
    text = (tmp_path / "room.toml").read_text()
    (tmp_path / "room.toml").write_text(re.sub(r"ground = 0\.2", "ground = 2", text))
    with pytest.raises(pm.InputError, match=r"room\.toml:\d+: .*ground"):
        pm.load_scene(tmp_path / "room.obj")


SUN = pm.DirectionalLight((-1.0, -0.35, 0.2), (3.0, 2.0, 1.0), name="sun", angle=5.0)


def compare(found, wanted, names=("direct", "indirect"), slack=0.0):
    """Compare the means of two renders by the spread of both, and a fraction of the second."""
    for name in names:
        (value, error), (true, spread) = means(found, name), means(wanted, name)
        assert true.any(), name
        limit = 4.0 * np.hypot(spread, error) + slack * true
        assert (np.abs(value - true) < limit).all(), name


def facing_in(scene):
    """Have the camera look at where the sun shines in."""
    scene.camera = pm.Camera((0.9, 1.9, -0.9), (-1.0, 0.4, 0.3), fov=70.0)
    return scene


@pytest.mark.parametrize("angle", [0.0, 20.0])
def test_a_portal_lets_in_the_sun_as_a_hole_does(angle):
    sun = pm.DirectionalLight((-1.0, -0.35, 0.2), (3.0, 2.0, 1.0), angle=angle)
    settings = {"bands": "rgb", "size": (24, 18)}
    hole = pm.render(facing_in(room([sun])), method="path", passes=64, seed=1, **settings)
    for method, slack in (("path", 0.0), ("photon", 0.01)):
        scene = facing_in(room([sun], PANE))
        found = pm.render(scene, method=method, passes=24, seed=2, **settings)
        compare(found, hole, slack=slack)
        assert not found.record["warnings"]


def test_sun_and_sky_add_up_through_a_portal():
    sky, settings = (
        pm.OvercastLight(0.5),
        {"bands": "rgb", "size": (16, 12), "passes": 24, "photons": 8192},
    )
    alone = [pm.render(facing_in(room([light], PANE)), **settings) for light in (sky, SUN)]
    both = pm.render(facing_in(room([sky, SUN], PANE)), seed=3, per_light=True, **settings)
    for name, single in zip(("overcast", "sun"), alone, strict=True):
        for buffer in ("direct", "indirect"):
            (wanted, spread) = means(single, buffer)
            found = both.per_light[name][buffer].mean(axis=(0, 1))
            np.testing.assert_allclose(found, wanted, atol=6.0 * spread.max(), rtol=0.01)


@pytest.mark.parametrize("method", ["path", "photon"])
def test_a_sun_passes_panes_that_are_boxes_and_the_edges_between_triangles(method):
    """Both faces of a box are portals; light passes both, and counts once."""
    scene = facing_in(room([SUN], PANE))
    outer = ((1.1, LOW, -SIDE), (1.1, HIGH, -SIDE), (1.1, HIGH, SIDE), (1.1, LOW, SIDE))
    boxed = facing_in(room([SUN], PANE))
    boxed.meshes.append(quad(*outer, PANE, "outer face"))
    ring = pm.Material("frame", 0.0)
    for y, up in ((LOW, (1.0, 1.1)), (HIGH, (1.0, 1.1))):
        corners = [(up[0], y, -SIDE), (up[1], y, -SIDE), (up[1], y, SIDE), (up[0], y, SIDE)]
        for each in (scene, boxed):
            each.meshes.append(quad(*corners, ring, f"frame {y}"))
    for z in (-SIDE, SIDE):
        corners = [(1.0, LOW, z), (1.1, LOW, z), (1.1, HIGH, z), (1.0, HIGH, z)]
        for each in (scene, boxed):
            each.meshes.append(quad(*corners, ring, f"frame {z}"))
    settings = {"bands": "rgb", "size": (16, 12), "passes": 24, "photons": 8192, "method": method}
    compare(pm.render(boxed, seed=5, **settings), pm.render(scene, **settings), slack=0.002)


def test_what_stands_before_a_portal_keeps_the_sun_out():
    """A shutter before the upper half of the window: the hole has the same."""
    middle, far = 0.5 * (LOW + HIGH), 1.02
    shutter = ((far, middle, -3.0), (far, 3.0, -3.0), (far, 3.0, 3.0), (far, middle, 3.0))
    scenes = [facing_in(room([SUN])), facing_in(room([SUN], PANE))]
    for scene in scenes:
        scene.meshes.append(quad(*shutter, BLACK, "shutter"))
    settings = {"bands": "rgb", "size": (24, 18)}
    hole = pm.render(scenes[0], method="path", passes=64, seed=1, **settings)
    for method, slack in (("path", 0.0), ("photon", 0.01)):
        found = pm.render(scenes[1], method=method, passes=24, seed=2, **settings)
        compare(found, hole, slack=slack)


@pytest.mark.parametrize("look", ["polished", *slow("clear")])
def test_caustics_of_a_sun_through_a_portal(look):
    """Photons that are aimed at a mirror and a ball start outside; paths see the sun directly."""
    scene = facing_in(room([SUN], PANE))
    hole = facing_in(room([SUN]))
    for each in (scene, hole):
        if look == "polished":
            corners = [(-0.9, 0.3, -0.5), (-0.9, 0.3, 0.9), (0.4, 0.3, 0.9), (0.4, 0.3, -0.5)]
            each.meshes.append(quad(*corners, pm.Material.polished(), "mirror"))
        else:
            glass = pm.Material("glass", 0.0, ior=1.5, thin=True, tint=0.5)
            corners = [(0.0, 0.0, -0.9), (0.0, 1.9, -0.9), (0.0, 1.9, 0.9), (0.0, 0.0, 0.9)]
            each.meshes.append(quad(*corners, glass, "glass"))
    settings = {"bands": "rgb", "size": (16, 12), "passes": 24, "photons": 8192}
    wanted, found = pm.render(hole, seed=3, **settings), pm.render(scene, **settings)
    compare(found, wanted, ("radiance", "direct"), slack=0.01)


def test_a_sun_alone_needs_no_sky_and_one_that_misses_the_portals_is_named():
    settings = {"bands": 1, "size": 8, "passes": 1}
    lit = pm.render(facing_in(room([SUN], PANE)), **settings)
    assert lit.radiance.any()
    assert not lit.record["warnings"]
    away = pm.DirectionalLight((0.2, -0.3, 1.0), name="sun")
    with pytest.warns(pm.SceneWarning, match="'sun' sends nothing .* leads through a portal: suns"):
        pm.render(facing_in(room([pm.DomeLight(1.0), away], PANE)), **settings)


def test_a_lamp_behind_a_portal_is_named_with_what_hides_it():
    lamp = pm.PointLight((3.0, 1.2, 0.0), 5.0, name="street lamp")
    with pytest.warns(pm.SceneWarning, match=r"'street lamp' sends nothing .* not behind one"):
        pm.render(room([pm.DomeLight(1.0), lamp], PANE), bands="rgb", size=8, passes=1)
