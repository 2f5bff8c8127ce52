"""Cells tile every surface exactly, and the energy of photons adds up."""

import numpy as np
import pytest
import trimesh
from helpers.scenes import closed_box

import photonmap as pm
from photonmap.compile.geometry import triangle_areas
from photonmap.compile.scene_arrays import compile_scene
from photonmap.integrators.photon_mapping.cache_cells import (
    FINER,
    divide_cells,
    lay_cells,
    measure_surface_fraction,
    split_shared,
)
from photonmap.kernels.cache import radiosity_cache as store
from photonmap.kernels.core.passes import RadiosityCache, Span
from photonmap.kernels.integrators.photon import trace_photons
from photonmap.spectra.bands import Bands


def prepared_mesh(mesh, reflectance=0.5, lights=()):
    scene = pm.Scene([pm.Mesh(mesh.vertices, mesh.faces, pm.Material("m", reflectance))], lights)
    return compile_scene(scene, Bands.rgb())


MESHES = {
    "box": trimesh.creation.box(),
    "sphere": trimesh.creation.icosphere(subdivisions=4),
    "torus": trimesh.creation.torus(1.0, 0.3, major_sections=8, minor_sections=200),
}


@pytest.mark.filterwarnings("ignore:the scene has no light")
@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("cells_wanted", [1, 50, 3000])
def test_cells_tile_the_surface(name, cells_wanted):
    geometry = prepared_mesh(MESHES[name]).geometry
    areas = triangle_areas(geometry)
    cells, count = lay_cells(geometry, areas, areas.sum() / cells_wanted)
    side = count // 2
    # Each cell's area, summed over all of them on one side, is the surface.
    area = np.zeros(side)
    for triangle, n in enumerate(cells.divisions):
        first = cells.first[triangle, 0]
        area[first : first + n * n] = 1.0 / cells.inverse_area[triangle, 0]
        assert cells.first[triangle, 1] == first + side
    assert area.sum() == pytest.approx(areas.sum(), rel=1e-5)
    assert (area > 0).all()
    assert count <= 2 * (cells_wanted * 4 + 6 * len(MESHES[name].faces[:64]))


def test_memory_follows_the_cells_not_the_triangles():
    with pytest.warns(pm.SceneWarning, match="no light"):
        geometry = prepared_mesh(trimesh.creation.icosphere(subdivisions=6)).geometry
    areas = triangle_areas(geometry)
    assert len(areas) == 81920
    _, count = lay_cells(geometry, areas, areas.sum() / 1000)
    assert count < 2 * 5000


def test_every_cell_of_a_triangle_is_hit_evenly():
    with pytest.warns(pm.SceneWarning, match="no light"):
        geometry = prepared_mesh(trimesh.creation.box()).geometry
    areas = triangle_areas(geometry)
    cells, count = lay_cells(geometry, areas, areas[0] / 48.9)
    n = cells.divisions[3]
    assert n == 7
    rng = np.random.default_rng(1)
    u, v = rng.random((2, 40_000))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    hits = [store.cell_at(cells, 3, 1, *uv) for uv in zip(u, v, strict=True)]
    counts = np.bincount(np.array(hits) - cells.first[3, 1], minlength=n * n)
    assert len(counts) == n * n
    expected = 40_000 / (n * n)
    assert ((counts - expected) ** 2 / expected).sum() < 100
    for corner in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (1.0, 1e-9)):
        assert 0 <= store.cell_at(cells, 3, 0, *corner) - cells.first[3, 0] < n * n
    assert count == cells.first.max() + n * n


def test_a_divided_cell_is_hit_evenly_and_no_other():
    with pytest.warns(pm.SceneWarning, match="no light"):
        geometry = prepared_mesh(trimesh.creation.box()).geometry
    areas = triangle_areas(geometry)
    whole, count = lay_cells(geometry, areas, areas[0] / 48.9)
    chosen = np.zeros(count, bool)
    # An upright one, an inverted one beside it, and the last of a strip.
    divided = whole.first[3, 1] + np.array([4, 5, 12])
    chosen[divided] = True
    cells, both = divide_cells(whole, chosen)
    assert both == count + 3 * FINER**2
    rng = np.random.default_rng(2)
    u, v = rng.random((2, 100_000))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    before = np.array([store.cell_at(whole, 3, 1, *uv) for uv in zip(u, v, strict=True)])
    after = np.array([store.cell_at(cells, 3, 1, *uv) for uv in zip(u, v, strict=True)])
    inside = np.isin(before, divided)
    np.testing.assert_array_equal(after[~inside], before[~inside])
    owner = np.searchsorted(divided, before[inside])
    np.testing.assert_array_equal((after[inside] - count) // FINER**2, owner)
    counts = np.bincount(after[inside] - count, minlength=both - count)
    expected = 100_000 / (49 * FINER**2)
    assert ((counts - expected) ** 2 / expected).sum() < 90  # 48 cells, p = 2e-4


@pytest.mark.filterwarnings("ignore:the scene has no light")
@pytest.mark.parametrize("n", [2, 7, 40])
def test_a_place_in_a_part_is_found_there(n):
    triangle = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    geometry = prepared_mesh(triangle).geometry
    layout, _ = lay_cells(geometry, np.array([1.0]), 1.0 / (n - 0.5) ** 2)
    for part in range(n * n):
        for u, v in ((0.2, 0.3), (0.01, 0.01), (0.98, 0.01), (0.01, 0.98)):
            assert store.cell_at(layout, 0, 0, *store.place_in(n, part, u, v)) == part


@pytest.mark.filterwarnings("ignore:the scene has no light")
def test_so_many_cells_that_are_divided_are_divided_less():
    geometry = prepared_mesh(MESHES["box"]).geometry
    areas = triangle_areas(geometry)
    whole, count = lay_cells(geometry, areas, areas.sum() / 500)
    for share, finer in ((16, 4), (9, 3), (4, 2), (3, 1), (1, 1)):
        chosen = np.zeros(count, bool)
        chosen[: count // share] = True
        cells, both = divide_cells(whole, chosen)
        assert cells.finer == finer
        assert both <= 2 * count
        assert (finer == 1) == (both == count)


def test_cells_that_triangles_share_stay_whole():
    with pytest.warns(pm.SceneWarning, match="no light"):
        geometry = prepared_mesh(MESHES["sphere"]).geometry
    areas = triangle_areas(geometry)
    whole, count = lay_cells(geometry, areas, areas.sum() / 50)
    cells, both = divide_cells(whole, np.ones(count, bool))
    assert both == count
    assert (cells.parts == -1).all()


def test_shared_cells_are_split_into_smaller_ones():
    with pytest.warns(pm.SceneWarning, match="no light"):
        geometry = prepared_mesh(MESHES["sphere"]).geometry
    areas = triangle_areas(geometry)
    area = areas.sum() / 50
    whole, count = lay_cells(geometry, areas, area)
    chosen = np.arange(count) % 3 == 0
    cells, of = split_shared(geometry, areas, whole, chosen, np.sqrt(area) / 2.0)
    split = chosen[whole.first].any(axis=1)
    np.testing.assert_array_equal(cells.first[~split], whole.first[~split])
    assert len(cells.parts) == count + len(of)
    # Each is of one that was chosen, and all of them are the surface of that.
    for side in range(2):
        np.testing.assert_array_equal(
            of[cells.first[split, side] - count], whole.first[split, side]
        )
        size = np.bincount(cells.first[:, side], areas, len(cells.parts))
        held = 1.0 / cells.inverse_area[:, side]
        np.testing.assert_allclose(held, size[cells.first[:, side]], rtol=1e-5)
    assert 2 * len(np.unique(whole.first[split])) < len(of) <= 8 * split.sum()


@pytest.mark.filterwarnings("ignore:the scene has no light")
def test_surface_of_cells_that_are_divided():
    """Of which half is holes: of whole cells and of divided ones, on either side."""
    box = trimesh.creation.box()
    sheet = pm.Mesh(box.vertices, box.faces, pm.Material("net", 0.5, alpha=0.5))
    geometry = compile_scene(pm.Scene([sheet]), Bands.rgb()).geometry
    areas = triangle_areas(geometry)
    whole, count = lay_cells(geometry, areas, areas.sum() / 500)
    chosen = np.arange(count) % 17 == 0
    cells, both = divide_cells(whole, chosen)
    fill = measure_surface_fraction(geometry, areas, cells, both)[:, 0]
    assert (fill[:count][~chosen] == 0.5).all()
    assert (fill[count:] == 0.5).all()


def test_thin_walls_keep_their_sides_apart(cornell):
    """Layers that all but coincide back to back never share a cell, nor do two sides of one."""
    sheet = trimesh.creation.icosphere(subdivisions=4)
    both = trimesh.util.concatenate(
        [sheet, trimesh.Trimesh(0.999999 * sheet.vertices, sheet.faces[:, ::-1])]
    )
    with pytest.warns(pm.SceneWarning, match="no light"):
        geometry = prepared_mesh(both).geometry
    areas = triangle_areas(geometry)
    cells, _ = lay_cells(geometry, areas, areas.sum() / 200)
    half = len(areas) // 2
    assert not set(cells.first[:half].ravel()) & set(cells.first[half:].ravel())


@pytest.mark.parametrize("rho", [0.2, 0.7])
def test_energy_in_the_store(rho):
    """In a closed room of albedo ρ, light of power 1 leaves surfaces with ρ / (1 − ρ) in all."""
    box = closed_box(pm.Material("wall", (rho, rho / 2, 0.0)))
    compiled = compile_scene(
        pm.Scene([box], [pm.PointLight((0.1, 0.2, 0.3), (3.0,) * 3)]), Bands.rgb()
    )
    areas = triangle_areas(compiled.geometry)
    cells, count = lay_cells(compiled.geometry, areas, areas.sum() / 500)
    radiosity = np.full((count, 3), np.nan, np.float32)
    n, scratch = 40_000, np.empty((3, 3), np.float32)
    cache = RadiosityCache(cells, radiosity)
    stores, _, cut, _ = trace_photons(
        compiled.arrays, cache, np.uint64(5), Span(0, n), n, 1000, scratch
    )
    area = np.zeros(count)
    for triangle, divisions in enumerate(cells.divisions):
        for side in (0, 1):
            first = cells.first[triangle, side]
            area[first : first + divisions**2] = 1.0 / cells.inverse_area[triangle, side]
    left = (radiosity * area[:, None]).sum(axis=0)
    albedo = np.array([rho, rho / 2, 0.0])
    np.testing.assert_allclose(left, albedo / (1 - albedo), rtol=0.02)
    assert cut == 0
    assert stores >= n
    behind = radiosity[count // 2 :]
    assert (behind == 0).all()


def test_crowded_cells_of_a_sphere_keep_what_goes_far():
    """Of cosine-distributed rays in a sphere of radius 1, w² / 4 end nearer than w."""
    sphere = trimesh.creation.icosphere(subdivisions=4)
    wall = pm.Mesh(sphere.vertices, sphere.faces[:, ::-1], pm.Material("wall", 0.5))
    compiled = compile_scene(pm.Scene([wall], [pm.PointLight((0, 0, 0), (3.0,) * 3)]), Bands.rgb())
    areas, light = triangle_areas(compiled.geometry), []
    cells, count = lay_cells(compiled.geometry, areas, areas.sum() / 8)
    scale = np.linalg.norm(compiled.geometry.vertices, axis=1).max()
    for crowded in (np.zeros(0, bool), np.ones(count, bool)):
        cache = RadiosityCache(cells._replace(crowded=crowded), np.empty((count, 3), np.float32))
        scratch = np.empty((3, 3), np.float32)
        trace_photons(compiled.arrays, cache, np.uint64(5), Span(0, 20_000), 20_000, 99, scratch)
        light.append(cache.radiosity[cells.first, 0] * areas[:, None])
    expected = light[0] * (1.0 - 1.0 / (4.0 * scale**2 * cells.inverse_area))
    assert 0.4 < expected.sum() / light[0].sum() < 0.95
    assert light[1].sum() == pytest.approx(expected.sum(), rel=0.02)


def test_bundles_join_in_order():
    bundles = np.random.default_rng(0).random((3, 10, 2), np.float32)
    radiosity = np.full((10, 2), np.nan, np.float32)
    store.sum_bundles(bundles, 0, 6, radiosity)
    store.sum_bundles(bundles, 6, 10, radiosity)
    np.testing.assert_array_equal(radiosity, (bundles[0] + bundles[1]) + bundles[2])
