"""Cells that reach under what stands on them know which part of them lies open."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers.passes import setup_of

import photonmap as pm
from photonmap.compile.geometry import triangle_areas
from photonmap.compile.scene_arrays import compile_scene
from photonmap.integrators.photon_mapping.cache_cells import (
    LEAST,
    POINTS,
    find_lit_sides,
    lay_cells,
    measure_exposed,
    measure_seen_afar,
)
from photonmap.kernels.cache.radiosity_cache import cell_at
from photonmap.runtime.workers import Workers
from photonmap.spectra.bands import Bands

LOW, HIGH = 0.21, 0.73
"""Where a block stands on a floor of the unit square, along either side."""


def floor(color=0.5):
    corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    return pm.Mesh(np.array(corners), np.array([[0, 1, 2], [0, 2, 3]]), pm.Material("f", color))


def block(color=0.5, outward=True):
    box = trimesh.creation.box(bounds=[[LOW, LOW, 0.0], [HIGH, HIGH, 0.4]])
    faces = box.faces if outward else box.faces[:, ::-1]
    return pm.Mesh(box.vertices, faces, pm.Material("b", color))


def room(color=0.5, outward=False):
    box = trimesh.creation.box(bounds=[[-0.5, -0.5, -0.1], [1.5, 1.5, 1.0]])
    faces = box.faces if outward else box.faces[:, ::-1]
    return pm.Mesh(box.vertices, faces, pm.Material("room", color))


def parts_open(meshes, lights, photons=300.0):
    """Return the layout over a scene, and which part of each cell lies open."""
    scene = compile_scene(pm.Scene(meshes, lights), Bands.rgb())
    areas = triangle_areas(scene.geometry)
    cells, _ = lay_cells(scene.geometry, areas, areas[0] / photons)
    with Workers(2) as workers:
        setup = setup_of(scene, workers)
        lit_sides = find_lit_sides(setup)
        return cells, measure_exposed(setup, lit_sides, areas, cells).fraction[:, 0]


def true_parts(cells, count):
    """Return which part of each cell on top of the floor is not under the block, by many points."""
    rng = np.random.default_rng(3)
    points, outside = np.zeros((2, count))
    corners = floor().vertices
    for triangle, face in enumerate(floor().faces):
        u, v = rng.random((2, 30_000))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        a, b, c = corners[face]
        places = a + u[:, None] * (b - a) + v[:, None] * (c - a)
        under = ((places[:, :2] > LOW) & (places[:, :2] < HIGH)).all(axis=1)
        found = [cell_at(cells, triangle, 0, *uv) for uv in zip(u, v, strict=True)]
        np.add.at(points, found, 1)
        np.add.at(outside, found, ~under)
    return points, outside


def cell_of(cells, x, y):
    """Return the cell on top of the floor at a point of the unit square."""
    triangle, uv = (0, (x - y, y)) if x > y else (1, (x, y - x))
    return cell_at(cells, triangle, 0, *uv)


SKY, SUN = pm.DomeLight(1.0), pm.DirectionalLight((0.3, 0.2, -1.0), 1.0)
LAMP = pm.PointLight((0.1, 0.1, 0.8), 1.0)


@pytest.mark.parametrize(
    ("around", "light", "outward"),
    [
        ([], SKY, True),
        ([], SUN, False),
        ([room()], LAMP, True),
        ([room()], LAMP, False),
        ([room(0.0)], LAMP, True),
        ([room(outward=True)], LAMP, False),
    ],
    ids=["sky", "sun", "room", "block inside out", "black room", "both inside out"],
)
def test_what_is_under_a_block_is_not_open(around, light, outward):
    cells, part = parts_open([floor(), block(outward=outward), *around], [light])
    points, outside = true_parts(cells, len(part))
    top = points > 0
    true = outside[top] / points[top]
    partly = (true > LEAST) & (true < 1.0)
    assert partly.sum() > 30
    # Of `POINTS` looks at a cell, spread evenly over the triangle.
    looks = 1.0 / POINTS + 1.0 / points[top]  # here, too
    spread = np.sqrt(true * (1.0 - true) * looks)
    assert (np.abs(part[top] - true)[partly] < 4.0 * spread[partly] + 1e-6).all()
    assert part[top][partly].mean() == pytest.approx(true[partly].mean(), abs=0.05)
    assert (part[top][true == 1.0] == 1.0).all()
    # Cells of which nothing is open get no light; none of it is made brighter.
    assert (part[top][true == 0.0] == 1.0).all()


def test_crowded_cells_are_exposed_as_far_as_they_are_seen_from_afar():
    """Beside a block and under it, by rays that a formula intersects with it."""
    scene = compile_scene(pm.Scene([floor(), block(), room()], [LAMP]), Bands.rgb())
    areas = triangle_areas(scene.geometry)
    cells, _ = lay_cells(scene.geometry, areas, areas[0] / 50.0)
    with Workers(2) as workers:
        setup = setup_of(scene, workers)
        known = find_lit_sides(setup), areas, cells
        near = measure_exposed(setup, *known).crowded
        inverse = np.mean([measure_seen_afar(setup, i, *known, near)[0] for i in range(40)], axis=0)
    size, rng = 2 * int(cells.divisions[0]) ** 2, np.random.default_rng(3)
    assert 10 < near[:size].sum() < size - 10
    width = np.sqrt(0.5) / cells.divisions[0]
    points, r, turn = rng.random((100_000, 2)), *rng.random((2, 100_000))
    turn *= 2.0 * np.pi
    ray = np.sqrt(r)[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    with np.errstate(divide="ignore"):
        sides = np.sort((np.array([[LOW], [HIGH]]) - points[:, None]) / ray[:, None], axis=1)
    enter, leave = sides[:, 0].max(axis=1), sides[:, 1].min(axis=1)
    far = (enter > leave) | (leave < 0.0) | (enter > width) | (enter * np.sqrt(1 - r) > 0.4)
    cell = np.array([cell_of(cells, *point) for point in points])
    count, share = np.bincount(cell), np.bincount(cell, far) / np.bincount(cell)
    chosen = near[: len(count)] & (share > 0.1)
    product = (share * inverse[: len(count), 0])[chosen]
    # 1 on average; what is lit is brought to its share, whether one ray in ten goes far or all.
    assert product.mean() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("light", [SKY, LAMP], ids=["sky", "lamp"])
def test_where_nothing_stands_all_is_open(light):
    _, part = parts_open([floor(), room()], [light])
    assert (part == 1.0).all()


def test_a_dim_lamp_reaches_its_room():
    """Beside a lamp a million times as bright, in a room of its own, with materials of its own."""
    meshes = [floor(), block(), room()]
    far = [
        pm.Mesh(mesh.vertices + [9.0, 0.0, 0.0], mesh.faces, pm.Material(f"far {i}", 0.5))
        for i, mesh in enumerate(meshes)
    ]
    dim = pm.PointLight((9.1, 0.1, 0.8), 1e-6)
    cells, part = parts_open([*meshes, *far], [LAMP, dim])
    alone_cells, alone = parts_open(meshes, [LAMP])
    first = cells.first[len(cells.first) // 2, 0]
    assert alone_cells.first[0, 0] == 0
    size = 2 * int(cells.divisions[0]) ** 2
    assert part[first : first + size].sum() == pytest.approx(alone[:size].sum(), rel=0.01)


def above(*meshes):
    """Return a scene whose camera sees a ceiling over meshes."""
    up = np.array([[0.0, 0.0, 1.2], [0.0, 1.0, 1.2], [1.0, 1.0, 1.2], [1.0, 0.0, 1.2]])
    ceiling = pm.Mesh(up, np.array([[0, 1, 2], [0, 2, 3]]), pm.Material("c", 0.5))
    camera = pm.Camera((0.5, 0.5, 0.6), (0.5, 0.5, 1.2), up=(0.0, 1.0, 0.0), fov=60.0)
    return pm.Scene([*meshes, ceiling], [LAMP], camera)


def test_what_lies_under_glass_is_seen():
    """A sheet that does not refract, closely above a floor, changes nothing.

    The light of a floor on a ceiling was lost where glass stood nearer than a cell is wide.
    """
    sheet = trimesh.creation.box(bounds=[[-0.1, -0.1, 0.01], [1.1, 1.1, 0.05]])
    air = pm.Mesh(sheet.vertices, sheet.faces, pm.Material.glass("air", 1.0))
    settings = {"bands": "rgb", "size": (32, 32), "threads": 2, "photons": 4096, "passes": 8}
    bare, covered = (
        pm.render(above(*meshes), **settings).indirect.mean()
        for meshes in ([floor()], [floor(), air])
    )
    assert covered == pytest.approx(bare, rel=0.01)


@pytest.mark.slow
def test_light_beside_a_block_is_whole():
    """Light of a floor on a ceiling, of which cells under a block's edges would lose 1.6%.

    Against the path tracer, in means over the image.
    """
    scene = above(floor(0.9), block(0.0))
    settings = {"bands": "rgb", "size": (64, 64), "threads": 2}
    path = pm.render(scene, **settings, method="path", passes=500, seed=1).indirect
    means = [
        pm.render(scene, **settings, photons=4096, passes=8, seed=seed).indirect.mean()
        for seed in range(24)
    ]
    assert np.mean(means) == pytest.approx(path.mean(), rel=0.01)


def test_no_light_leaks_under_a_wall():
    """Of a room into another, by cells that reach under the wall between them.

    Cells that are not divided there let a thousandth or more through.
    """
    house = trimesh.creation.box(bounds=[[-0.5, -0.5, 0.0], [1.5, 1.5, 1.0]])
    wall = trimesh.creation.box(bounds=[[0.53, -0.5, 0.0], [0.59, 1.5, 1.0]])
    meshes = [
        pm.Mesh(house.vertices, house.faces[:, ::-1], pm.Material("house", 0.5)),
        pm.Mesh(wall.vertices, wall.faces, pm.Material("wall", 0.5)),
    ]
    lit = pm.Camera((-0.4, 0.5, 0.5), (0.4, 0.5, 0.3), fov=90.0)
    dark = pm.Camera((1.4, 0.5, 0.5), (0.6, 0.5, 0.3), fov=90.0)
    lamp = pm.PointLight((0.0, 0.5, 0.7), 1.0)
    settings = {"bands": "rgb", "size": (32, 32), "passes": 8, "photons": 4096, "threads": 2}
    bright = pm.render(pm.Scene(meshes, [lamp], lit), **settings)
    with pytest.warns(pm.SceneWarning, match="sends nothing into the view"):
        leaked = pm.render(pm.Scene(meshes, [lamp], dark), **settings)
    assert leaked.indirect.mean() < 3e-4 * bright.indirect.mean()


def test_one_paint_is_enough():
    """What is inside of a block stays dark though light comes to that side of other things."""
    paint = pm.Material("paint", 0.5)
    meshes = [floor(), block(), room()]
    apart = parts_open(meshes, [LAMP])[1]
    painted = [replace(m, material=paint, name=m.material.name) for m in meshes]
    alike = parts_open(painted, [LAMP])[1]
    inverted = [replace(mesh, faces=mesh.faces[:, ::-1]) for mesh in painted[2:]]
    assert (apart < 1.0).sum() > 30
    np.testing.assert_array_equal(alike, apart)
    both = parts_open([*painted[:2], *inverted], [LAMP])[1]
    np.testing.assert_array_equal(both[: len(apart) // 2] < 1.0, apart[: len(apart) // 2] < 1.0)
