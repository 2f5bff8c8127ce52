"""Glass that touches, overlaps or contains other glass: Fresnel between both, not against air."""

import numpy as np
import pytest
import trimesh
from helpers.marks import slow
from helpers.scenes import quad

import photonmap as pm
from photonmap.compile.scene_arrays import compile_arrays

GLASS = pm.Material.glass("glass", 1.5)
WATER = pm.Material.glass("water", 1.33)
AIR = pm.Material.glass("air", 1.0)
SMALL = {"bands": "rgb", "size": (16, 16), "photons": 300, "seed": 2}
"""Lamps are seen through glass: photons have no part in it."""


def box(low, high, material, name="box"):
    mesh = trimesh.creation.box(bounds=[low, high])
    return pm.Mesh(mesh.vertices, mesh.faces, material, name)


def slab(low, high, material, half=4.0):
    return box((-half, -half, low), (half, half, high), material, f"slab {low}")


def lamp(z, half=4.0):
    corners = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])
    return pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], pm.Material("lamp", 0.0, 1.0), "lamp")


def transmitted(*indices):
    """What layers at normal incidence transmit, all reflections between them included."""
    through, back = 1.0, 0.0
    for here, there in zip((1.0, *indices), (*indices, 1.0), strict=True):
        once = ((here - there) / (here + there)) ** 2
        series = 1.0 - back * once
        through, back = through * (1.0 - once) / series, once + (1.0 - once) ** 2 * back / series
    return through


def areas(*meshes):
    """Areas of triangles by the indices at their fronts and backs, and all of them together."""
    scene = pm.Scene(meshes, [pm.PointLight((0, 0, 9))], pm.Camera((0, 0, 10), (0, 0, 0)))
    compiled = compile_arrays(scene, pm.Bands.rgb())
    media, geometry = compiled.specular.media, compiled.geometry
    corners = compiled.size * geometry.vertices[geometry.triangles]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    found = {}
    for pair, side in zip(media.of_side, sides, strict=True):
        key = tuple(1.0 if row < 0 else float(media.ior[row]) for row in pair)
        found[key] = found.get(key, 0.0) + 0.5 * float(np.linalg.norm(side))
    return found


STACKS = {
    "touching": [slab(0.5, 1, GLASS), slab(0, 0.5, WATER), slab(-0.5, 0, GLASS)],
    "contained": [slab(-0.5, 1, GLASS), slab(0, 0.5, WATER, 3.0)],
    "overlapping": [slab(0.4, 1, GLASS), slab(0, 0.5, WATER), slab(-0.5, 0.1, GLASS)],
}


@pytest.mark.parametrize("method", ["photon", "path"])
@pytest.mark.parametrize("stack", STACKS)
def test_stacks_before_a_lamp(stack, method):
    camera = pm.Camera((0.1, 0.2, 5), (0.1, 0.2, 0), fov=0.5)
    scene = pm.Scene([*STACKS[stack], lamp(-1.0)], [], camera)
    result = pm.render(scene, **SMALL, passes=24, method=method)
    found = result.emission.mean()
    assert found == pytest.approx(transmitted(1.5, 1.33, 1.5), abs=3e-3)
    assert result.record["effects"]["media"]["on"]


@pytest.mark.parametrize("roughness", [0.0, 0.5])
def test_equal_indices_let_light_pass(roughness):
    """A rough body in one of its index, which alone absorbs: exactly, and from lights as well."""
    rough = pm.Material.glass("rough", 1.0, roughness=roughness)
    look = {"attenuation_color": 0.5, "attenuation_distance": 1.0}
    fog = pm.Material("fog", 0.0, ior=1.0, **look)
    camera = pm.Camera((0.1, 0.2, 5), (0.1, 0.2, 0), fov=0.5)
    scene = pm.Scene([slab(-0.5, 1, fog), slab(0, 0.5, rough, 3.0), lamp(-1.0)], [], camera)
    result = pm.render(scene, **SMALL, passes=4)
    np.testing.assert_allclose(result.radiance, 0.5, rtol=1e-3)


def test_a_rough_boundary_of_one_index():
    """Frosted water in clear water that absorbs: what lies between them scatters nothing."""
    look = {"ior": 1.33, "attenuation_color": 0.5, "attenuation_distance": 1.0}
    clear, frosted = pm.Material("clear", 0.0, **look), pm.Material.glass("frosted", 1.33)
    meshes = [slab(-0.5, 1, clear), slab(0, 0.5, frosted, 3.0), lamp(-1.0)]
    camera = pm.Camera((0.1, 0.2, 5), (0.1, 0.2, 0), fov=0.5)
    settings = SMALL | {"passes": 16}
    smooth = pm.render(pm.Scene(meshes, [], camera), **settings)
    look = pm.Material.glass("frosted", 1.33, roughness=0.5)
    meshes[1] = slab(0, 0.5, look, 3.0)
    rough = pm.render(pm.Scene(meshes, [], camera), **settings)
    assert rough.radiance.mean() == pytest.approx(smooth.radiance.mean(), abs=2e-3)


@pytest.mark.parametrize("roughness", [0.0, 0.1])
def test_a_lamp_in_glass(roughness):
    """Its radiance is divided by n² where light leaves the glass, whose facets are nearly level.

    Within 4 standard errors of 512 rays, of which 96% are transmitted.
    """
    look = pm.Material.glass("glass", 1.5, roughness=roughness)
    camera = pm.Camera((0.1, 0.2, 5), (0.1, 0.2, 0), fov=0.5)
    result = pm.render(pm.Scene([slab(0, 1, look), lamp(0.5, 3.0)], [], camera), **SMALL, passes=2)
    assert result.radiance.mean() == pytest.approx(0.96 / 1.5**2, abs=0.016)


def test_areas_of_bodies_that_touch_in_part():
    """Surfaces are cut along the outlines of others, and of two that coincide one is left."""
    found = areas(
        box((-3, -3, 0), (3, 3, 0.5), GLASS, "a"),
        box((-2, -2, 0.5), (2, 2, 1), WATER, "b"),
        box((-1.5, -1.5, 1), (2.5, 1.5, 2), pm.Material.glass("c", 1.7), "c"),
    )
    wanted = {(1.0, 1.5): 68, (1.0, 1.33): 13.5, (1.0, 1.7): 27.5, (1.5, 1.33): 16}
    assert found == pytest.approx({**wanted, (1.7, 1.33): 10.5}, rel=1e-5)


@pytest.mark.parametrize("priority", [0.0, 1.0])
def test_areas_of_bodies_that_overlap(priority):
    """The smaller body claims what they share, unless the other has a higher priority."""
    glass = pm.Material("glass", 0.0, ior=1.5, priority=priority)
    found = areas(box((-2, -2, -2), (2, 2, 2), glass), box((-1, -1, 1), (1, 1, 3), WATER))
    shared = {(1.33, 1.5): 4.0} if priority else {(1.5, 1.33): 12.0}
    wanted = {(1.0, 1.5): 92, (1.0, 1.33): 12, **shared}
    assert found == pytest.approx(wanted, rel=1e-5)


def test_one_glass_in_two_bodies():
    """No surface is left between them."""
    other = pm.Material.glass("other", 1.5)
    glass = box((-2, -2, -2), (2, 2, 2), GLASS)
    water = box((5, 5, 5), (6, 6, 6), WATER), box((5, 5, 6), (6, 6, 7), AIR)
    found = areas(glass, box((-1, -1, 1), (1, 1, 3), other), *water)
    assert found[1.0, 1.5] == pytest.approx(92 + 12, rel=1e-5)


def test_a_floor_is_cut_where_a_body_that_absorbs_stands_on_it():
    """Its walls reach the floor from above, and do not cross it."""
    jelly = pm.Material("jelly", 0.0, ior=1.5, attenuation_color=0.5, attenuation_distance=1.0)
    floor = quad((-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0))
    found = areas(floor, box((-1, -1, 0), (1, 1, 2), jelly))
    assert found == pytest.approx({(1.0, 1.0): 32, (1.5, 1.0): 4, (1.0, 1.5): 24}, rel=1e-5)


def test_an_index_below_1_is_relative_to_what_is_around():
    bubble = pm.Material.glass("bubble", 0.95)
    found = areas(box((-2, -2, -2), (2, 2, 2), WATER), box((-1, -1, -1), (1, 1, 1), bubble))
    assert found == pytest.approx({(1.0, 1.33): 96.0, (1.33, 0.95 * 1.33): 24.0}, rel=1e-5)


@pytest.mark.parametrize("sections", [32, 48])
@pytest.mark.parametrize("radius", [1.0, 1.05])
def test_water_in_a_cup(radius, sections):
    """As large as the cup inside, or larger, as it is often modelled; of other facets too."""
    cup = trimesh.creation.annulus(1.0, 1.2, 2.0, sections=32)
    water = trimesh.creation.cylinder(radius, 1.0, sections=sections)
    found = areas(
        pm.Mesh(cup.vertices, cup.faces, GLASS, "cup"),
        pm.Mesh(water.vertices, water.faces, WATER, "water"),
    )
    assert set(found) == {(1.0, 1.5), (1.0, 1.33), (1.5, 1.33)}
    assert found[1.0, 1.33] == pytest.approx(2 * np.pi, rel=0.12)
    assert found[1.5, 1.33] == pytest.approx(2 * np.pi * radius, rel=0.12)


def test_a_hole_wound_inwards_is_air():
    """As a mesh of its own in the glass, with a drop of water inside."""
    hole = box((-1, -1, -1), (1, 1, 1), GLASS, "hole")
    hole = pm.Mesh(hole.vertices, hole.faces[:, ::-1], GLASS, "hole")
    glass, water = box((-2, -2, -2), (2, 2, 2), GLASS), box((0, 0, 0), (0.5, 0.5, 0.5), WATER)
    found = areas(glass, hole, water)
    assert found == pytest.approx({(1.0, 1.5): 96 + 24, (1.0, 1.33): 1.5}, rel=1e-5)


def test_glass_apart_is_as_before():
    scene = pm.Scene(
        [box((-2, -2, -2), (2, 2, 2), GLASS), box((2.1, -1, 1), (3, 1, 3), WATER)],
        [pm.PointLight((0, 0, 9))],
        pm.Camera((0, 0, 10), (0, 0, 0)),
    )
    assert compile_arrays(scene, pm.Bands.rgb()).specular.media is None


def test_an_open_mesh_refracts_against_its_outside():
    """As surfaces between two media are modelled one by one; glass open below is an interface."""
    look = {"ior": 1.5, "outside": 1.33}
    sheet = pm.Mesh(lamp(0.0).vertices, lamp(0.0).faces, pm.Material("sheet", 0.0, **look), "sheet")
    camera = pm.Camera((0.1, 0.2, 5), (0.1, 0.2, 0), fov=0.5)
    scene = pm.Scene([sheet, lamp(-1.0)], [], camera)
    result = pm.render(scene, **SMALL, passes=24)
    passed = (1.0 - ((1.5 - 1.33) / (1.5 + 1.33)) ** 2) * (1.33 / 1.5) ** 2
    assert result.emission.mean() == pytest.approx(passed, abs=3e-3)


def test_open_meshes_beside_glass_are_named():
    sheet = pm.Mesh(lamp(-0.2).vertices, lamp(0.0).faces, WATER, "sheet")
    scene = pm.Scene(
        [sheet, slab(-0.5, 0.0, GLASS), lamp(-1.0)], [], pm.Camera((0, 0, 5), (0, 0, 0))
    )
    with pytest.warns(pm.SceneWarning, match="no closed mesh in 'sheet'"):
        compile_arrays(scene, pm.Bands.rgb())


def refract(direction, normal, eta):
    cosine = -(direction * normal).sum(axis=1)
    squared = 1.0 - eta**2 * (1.0 - cosine**2)
    beyond = np.sqrt(np.maximum(squared, 0.0))
    parallel = (cosine - eta * beyond) / (cosine + eta * beyond)
    perpendicular = (eta * cosine - beyond) / (eta * cosine + beyond)
    reflected = np.where(squared <= 0.0, 1.0, 0.5 * (parallel**2 + perpendicular**2))
    out = eta[:, None] * direction + (eta * cosine - beyond)[:, None] * normal
    return out, direction + 2.0 * cosine[:, None] * normal, reflected


def seen_through_balls(origin, direction, radii, indices, rng):
    """Trace rays through concentric balls, outermost first; return where they end: (2,) and up."""
    layer = np.zeros(len(origin), int)  # 0: air, 1: the outer ball, …
    table = np.array([1.0, *indices])
    inside = np.arange(len(origin))
    for _ in range(200):
        here, along = origin[inside], direction[inside]
        best, hit = np.full(len(inside), np.inf), np.zeros(len(inside), int)
        b = (here * along).sum(axis=1)
        for ball, radius in enumerate(radii):
            root = b**2 - (here**2).sum(axis=1) + radius**2
            for sign in (-1.0, 1.0):
                t = -b + sign * np.sqrt(np.maximum(root, 0.0))
                closer = (root > 0.0) & (t > 1e-9) & (t < best)
                best[closer], hit[closer] = t[closer], ball + 1
        inside, best, hit = (each[np.isfinite(best)] for each in (inside, best, hit))
        if not len(inside):
            return origin, direction
        go = inside
        point = origin[go] + best[:, None] * direction[go]
        normal = point / np.linalg.norm(point, axis=1, keepdims=True)
        inward = (normal * direction[go]).sum(axis=1) < 0.0
        after = np.where(inward, hit, hit - 1)
        facing = np.where(inward[:, None], normal, -normal)
        eta = table[layer[go]] / table[after]
        out, back, reflected = refract(direction[go], facing, eta)
        bounced = rng.random(len(eta)) < reflected
        layer[go] = np.where(bounced, layer[go], after)
        direction[go] = np.where(bounced[:, None], back, out)
        origin[go] = point
    raise AssertionError("a ray never leaves")


def ball(radius, material, name):
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    return pm.Mesh(mesh.vertices, mesh.faces, material, name, normals=mesh.vertices)


@pytest.mark.filterwarnings("ignore:.*successive reflections")
@pytest.mark.parametrize("inner", [1.0, *slow(2.0)])
def test_a_ball_in_a_ball(inner):
    """Against rays through exact balls: how much of a lamp behind them is seen."""
    core = pm.Material.glass("core", inner)
    meshes = [ball(1.0, GLASS, "outer"), ball(0.7, core, "inner"), lamp(-4.0, 1.5)]
    scene = pm.Scene(meshes, [], pm.Camera((0, 0, 6), (0, 0, 0), fov=20))
    result = pm.render(scene, **SMALL | {"size": (24, 24)}, passes=48)
    rng, side = np.random.default_rng(1), 250
    x, y = (np.mgrid[:side, :side].reshape(2, -1) + rng.random((2, side * side))) / side
    x, y = ((2.0 * part - 1.0) * np.tan(np.radians(10)) for part in (x, y))
    direction = np.stack([x, y, -np.ones_like(x)], axis=1)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    origin = np.broadcast_to([0.0, 0.0, 6.0], direction.shape).copy()
    end, out = seen_through_balls(origin, direction, (1.0, 0.7), (1.5, inner), rng)
    reach = np.where(out[:, 2] < 0.0, (-4.0 - end[:, 2]) / out[:, 2], np.inf)[:, None]
    with np.errstate(invalid="ignore"):
        lit = (np.abs((end + reach * out)[:, :2]) < 1.5).all(axis=1) & (out[:, 2] < 0.0)
    assert result.radiance.mean() == pytest.approx(lit.mean(), rel=0.012)
