"""Textures: look-up, reflectance and emission that vary over surfaces, and MTL maps."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers.comparisons import assert_within
from helpers.scenes import closed_tetrahedron, quad
from scipy import stats

import photonmap as pm
from photonmap.compile.effects import leave_out, plan_effects
from photonmap.compile.scene_arrays import compile_scene
from photonmap.compile.spectral_columns import carry, choose_columns
from photonmap.compile.textures import compile_textures
from photonmap.errors import InputError, SceneWarning
from photonmap.kernels.geometry.texture import look_up
from photonmap.scene.images import decode_srgb
from photonmap.spectra.bands import Bands

RNG = np.random.default_rng(5)
BYTES = RNG.integers(0, 256, (4, 5, 3), np.uint8)
SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)


def bilinear(texels, s, t, clamp, nearest=False):
    """The same by hand: row 0 is the top, t rises; `clamp` along both or along each of s and t."""
    size = texels.shape[:2]
    clamps = np.broadcast_to(clamp, 2)[::-1]
    t, s = (
        min(max(at, 0.0), 1.0) if clamped else at
        for at, clamped in zip((t, s), clamps, strict=True)
    )
    places = (1.0 - t) * size[0] - 0.5, s * size[1] - 0.5
    if nearest:
        places = [np.floor(place + 0.5) for place in places]
    total = np.zeros(3)
    for corner in np.ndindex(2, 2):
        weight, inside = 1.0, []
        for place, step, count, clamped in zip(places, corner, size, clamps, strict=True):
            index = int(np.floor(place)) + step
            weight *= 1.0 - abs(place - index)
            inside.append(min(max(index, 0), count - 1) if clamped else index % count)
        total += weight * texels[tuple(inside)]
    return total


def maps_of(*textures):
    materials = [pm.Material("m", texture) for texture in textures]
    texture_table = compile_textures(materials, np.ones(len(materials)))
    return texture_table.maps, texture_table


@pytest.mark.parametrize("nearest", [False, True])
@pytest.mark.parametrize("clamp", [False, True, (True, False), (False, True)])
@pytest.mark.parametrize("kind", ["srgb", "linear", "float", "grey"])
def test_look_up(kind, clamp, nearest):
    texels = {
        "srgb": BYTES,
        "linear": BYTES,
        "float": RNG.random((3, 7, 3)).astype(np.float32),
        "grey": BYTES[..., 0],
    }[kind]
    place = {"scale": (1.5, -0.75), "offset": (0.25, 0.5), "factor": (1, 0.5, 0.25)}
    place |= {"clamp": clamp, "nearest": nearest}
    texture = pm.Texture.of(texels, kind != "linear", **place)
    maps, _pictures = maps_of(pm.Texture.of(BYTES), texture)
    linear = texels if kind == "float" else texels / 255
    linear = decode_srgb(linear) if kind in ("srgb", "grey") else linear
    linear = linear[..., None].repeat(3, 2) if linear.ndim == 2 else linear
    for u, v in RNG.uniform(-2.0, 3.0, (100, 2)):
        s, t = 1.5 * u + 0.25, -0.75 * v + 0.5
        wanted = bilinear(linear, s, t, clamp, nearest) * [1, 0.5, 0.25]
        np.testing.assert_allclose(look_up(maps, 1, u, v), wanted, atol=1e-6)


def test_corners_and_centres():
    texels = np.array([[[1, 0, 0], [0, 1, 0]], [[0, 0, 1], [1, 1, 1]]], np.float32)
    maps, _pictures = maps_of(pm.Texture.of(texels))
    assert look_up(maps, 0, 0.25, 0.75) == (1, 0, 0)
    assert look_up(maps, 0, 0.75, 0.75) == (0, 1, 0)
    assert look_up(maps, 0, 0.25, 0.25) == (0, 0, 1)
    assert look_up(maps, 0, -0.25, -0.75) == (1, 1, 1)
    assert look_up(maps, 0, 0.0, 0.0) == (0.5, 0.5, 0.5)


@pytest.mark.parametrize("across", [False, True])
@pytest.mark.parametrize("up", [False, True])
def test_mirrored(across, up):
    """Every other copy is mirrored: the texture at |x| within one period, and so on."""
    linear = BYTES / 255
    place = {"scale": (1.5, -0.75), "offset": (0.25, 0.5)}
    maps, _pictures = maps_of(pm.Texture.of(BYTES, False, **place).mirrored(across, up))

    def fold(x):
        return 1.0 - abs(x % 2.0 - 1.0)

    for u, v in RNG.uniform(-2.0, 3.0, (100, 2)):
        s, t = 1.5 * u + 0.25, -0.75 * v + 0.5
        if across and up:  # there the edge is the neighbour of itself
            wanted = bilinear(linear, fold(s), fold(t), True)
        else:
            row = np.hstack([linear, linear[:, ::-1] if across else linear])
            copies = np.vstack([row[::-1] if up else row, row])
            wanted = bilinear(copies, s / 2, t / 2, False)
        np.testing.assert_allclose(look_up(maps, 0, u, v), wanted, atol=1e-6)


def test_mirrored_one_way_and_clamped_the_other():
    linear = BYTES / 255
    texture = pm.Texture.of(BYTES, False, clamp=(True, True)).mirrored(True, False)
    assert texture.clamp == (False, True)
    maps, _pictures = maps_of(texture)
    copies = np.hstack([linear, linear[:, ::-1]])
    for u, v in RNG.uniform(-2.0, 3.0, (100, 2)):
        wanted = bilinear(copies, u / 2, v, (False, True))
        np.testing.assert_allclose(look_up(maps, 0, u, v), wanted, atol=1e-6)


def test_clamps_that_are_none():
    with pytest.raises(InputError, match=r"a texture's clamp is \(True,\); give True or False, or"):
        pm.Texture.of(BYTES, clamp=(True,))


def test_mean_and_largest():
    texture = pm.Texture.of(BYTES, factor=(0.5, 1.0, 1.0))
    linear = decode_srgb(BYTES / 255) * [0.5, 1, 1]
    np.testing.assert_allclose(texture.mean, linear.mean(axis=(0, 1)), rtol=1e-6)
    assert texture.largest == pytest.approx(linear.max(), rel=1e-6)


def wall(reflectance, emission=0.0, alpha=1.0, z=0.0, size=1.0, uv=SQUARE, name="wall"):
    """A square that faces +z."""
    corners = (SQUARE * 2.0 - 1.0) * size
    vertices = np.column_stack([corners, np.full(4, z)])
    material = pm.Material(name, reflectance, emission, alpha=alpha)
    return pm.Mesh(vertices, [[0, 1, 2], [0, 2, 3]], material, name, uv=uv)


def full_view(side, distance=10.0):
    """A camera whose pixels tile the square from -1 to 1."""
    return pm.Camera((0, 0, distance), (0, 0, 0), fov=2.0 * np.degrees(np.arctan(1.0 / distance)))


@pytest.mark.parametrize("bands", [3, 6, "rgb"])
def test_reflectance_is_the_texture_that_is_seen(bands):
    texture = pm.Texture.of(RNG.integers(0, 256, (8, 8, 3), np.uint8))
    scene = pm.Scene([wall(texture)], [pm.DomeLight(2.0)], full_view(8))
    result = pm.render(scene, bands=bands, size=(8, 8), pixel="center", passes=4, photons=100)
    linear = texture.image.linear(slice(None), slice(None)).astype(float)
    wanted = linear @ result.bands.reflectance_basis
    np.testing.assert_allclose(result.reflectance, wanted, atol=2e-6)
    np.testing.assert_allclose(
        result.radiance, result.reflectance * result.shading, rtol=1e-5, atol=1e-7
    )
    white = Bands.parse(bands).emission(2.0)
    assert_within(result.shading, white, result.standard_error("shading"), slack=1e-4)


@pytest.mark.parametrize("bands", [6, "rgb"])
def test_a_constant_texture_is_a_constant_colour(bands):
    """In a furnace, photons, gather rays and walks meet it too."""
    color = (0.2, 0.5, 0.8)
    texture = pm.Texture.of(np.broadcast_to(np.array(color, np.float32), (2, 3, 3)))
    images = []
    for reflectance in (color, texture):
        walls = closed_tetrahedron(pm.Material("wall", reflectance, 1.0))
        walls = replace(walls, uv=RNG.random((len(walls.vertices), 2)))
        camera = pm.Camera((0.3, 0.2, 0.8), (-0.2, -0.1, -1.0), fov=70.0)
        scene = pm.Scene([walls], camera=camera)
        images.append(pm.render(scene, bands=bands, size=(12, 12), passes=3, photons=3000))
    for name in ("radiance", "indirect", "reflectance", "shading"):
        plain, textured = (image.buffers[name] for image in images)
        np.testing.assert_allclose(textured, plain, rtol=1e-5)


def textured_box():
    """An open box with a checkered floor, a striped wall, and a lamp above."""
    checks = np.kron([[1, 0] * 2, [0, 1] * 2] * 2, np.ones((4, 4)))
    floor = pm.Texture.of((checks[..., None] * [0.8, 0.6, 0.2] + 0.05).astype(np.float32))
    stripes = pm.Texture.of(BYTES, scale=(2.0, 1.0))
    lamp = quad(
        (-0.4, 0.99, -0.4), (0.4, 0.99, -0.4), (0.4, 0.99, 0.4), (-0.4, 0.99, 0.4),
        pm.Material("lamp", 0.0, 5.0), "lamp",
    )  # fmt: skip

    def side(a, b, c, d, paint, name):
        mesh = quad(a, b, c, d, pm.Material(name, paint), name)
        return pm.Mesh(mesh.vertices, mesh.faces, mesh.material, name, uv=SQUARE)

    return pm.Scene(
        [
            side((-1, -1, 1), (1, -1, 1), (1, -1, -1), (-1, -1, -1), floor, "floor"),
            side((-1, 1, 1), (-1, 1, -1), (1, 1, -1), (1, 1, 1), 0.6, "ceiling"),
            side((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), stripes, "back"),
            side((-1, -1, 1), (-1, -1, -1), (-1, 1, -1), (-1, 1, 1), (0.7, 0.1, 0.1), "left"),
            lamp,
        ],
        camera=pm.Camera((0, 0, 3.9), (0, 0, 0), fov=39.0),
    )


def assert_methods_agree(
    scene, passes, paths, names, side=24, allowance=0.01, rel=0.005, **settings
):
    """z-scores of the means of 6 × 6 blocks; the whole mean to `rel` beyond its standard error."""
    photon = pm.render(scene, size=(side, side), passes=passes, seed=3, **settings)
    path = pm.render(scene, size=(side, side), passes=paths, seed=4, method="path", **settings)
    count = side // 6
    for name in names:
        blocks = []
        for result in (photon, path):
            shape = (count, 6, count, 6, -1)
            image = result.buffers[name].astype(float).reshape(shape)
            spread = result.standard_error(name).astype(float).reshape(shape)
            blocks.append((image.mean(axis=(1, 3)), np.sqrt((spread**2).sum(axis=(1, 3))) / 36))
        (ours, our_error), (truth, error) = blocks
        scale = allowance * truth.mean()
        z = (ours - truth) / np.sqrt(our_error**2 + error**2 + scale**2 + 1e-12)
        assert np.abs(z).max() < stats.norm.isf(1e-3 / z.size), name
        spread = np.sqrt((our_error**2 + error**2).sum(axis=(0, 1))).mean() / count**2
        allowed = stats.norm.isf(5e-4) * spread + rel * truth.mean()
        assert abs(ours.mean() - truth.mean()) < allowed, name


def test_photons_agree_with_paths():
    names = ("radiance", "direct", "indirect", "reflectance")
    assert_methods_agree(textured_box(), 12, 120, names, bands="rgb")


@pytest.mark.parametrize("method", ["photon", "path"])
@pytest.mark.parametrize("bands", [3, "rgb"])
def test_half_of_a_lamp_is_black(method, bands):
    """Irradiance on the axis of a facing square, closed form; half of it comes from either half."""
    texels = np.zeros((8, 8, 3), np.float32)
    texels[:, 4:] = (6.0, 4.0, 2.0)
    # Two columns of blended texels cancel: a ramp about the middle, and one round the edge, which
    # repeats unless it is clamped.
    lamp = wall(0.0, pm.Texture.of(texels, clamp=True), name="lamp", z=0.0)
    ground = pm.Mesh(
        np.array([[-0.01, -0.01, 1], [-0.01, 0.01, 1], [0.01, 0.01, 1], [0.01, -0.01, 1.0]]),
        [[0, 1, 2], [0, 2, 3]], pm.Material("ground", 0.5), "ground",
    )  # fmt: skip
    camera = pm.Camera((0.3, 0.0, 0.5), (0, 0, 1), fov=1.0)
    result = pm.render(
        pm.Scene([lamp, ground], [], camera), bands=bands, size=(4, 4), passes=300,
        photons=64, method=method, effects="direct",
    )  # fmt: skip
    half = 4.0 / np.sqrt(2.0) * np.arctan(1.0 / np.sqrt(2.0))  # E/L of the whole square, h = 1
    truth = 0.5 * half * result.bands.emission((6.0, 4.0, 2.0)) / np.pi
    values = result.shading.reshape(16, -1).mean(axis=0)
    error = np.sqrt((result.standard_error("shading").astype(float) ** 2).reshape(16, -1).sum(0))
    assert_within(values, truth, error / 16, slack=2e-3)


def test_a_textured_lamp_is_seen_and_lights_alike():
    lamps = pm.Texture.of(RNG.random((3, 3, 3)).astype(np.float32), factor=(4.0, 4.0, 4.0))
    scene = textured_box()
    lamp = scene.meshes[-1]
    material = pm.Material("lamp", 0.0, lamps)
    scene.meshes[-1] = pm.Mesh(lamp.vertices, lamp.faces, material, "lamp", uv=SQUARE)
    names = ("emission", "direct", "indirect")
    assert_methods_agree(scene, 12, 120, names, bands="rgb")


def ball_in_the_box(material):
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.45)
    vertices = ball.vertices + [0.2, -0.5, 0.3]
    scene = textured_box()
    scene.meshes.append(pm.Mesh(vertices, ball.faces, material, "ball", ball.vertices))
    return scene


@pytest.mark.slow
def test_textures_in_mirrors():
    scene = ball_in_the_box(pm.Material.polished("ball", 0.9))
    lamp, holes = scene.meshes[-2], pm.Texture.of(np.array([[1.0, 0.0], [0.0, 1.0]]))
    glow = pm.Texture.of(BYTES, factor=(6.0, 5.0, 4.0))
    scene.meshes[-2] = pm.Mesh(
        lamp.vertices,
        lamp.faces,
        pm.Material("lamp", 0.0, glow, alpha=holes),
        "lamp",
        uv=SQUARE,
    )
    settings = {"allowance": 0.03, "rel": 0.04, "bands": "rgb"}
    assert_methods_agree(scene, 24, 400, ("direct", "residual"), **settings)


def two_lamps():
    lamps = [
        wall(0.0, pm.Texture.of(BYTES, factor=(k, k, k)), z=float(k), name=f"lamp {k}")
        for k in (1, 2)
    ]
    return compile_scene(pm.Scene([*lamps, wall(pm.Texture.of(BYTES))]), Bands.gaussian(4))


def test_columns_of_textured_lamps():
    """With groups of lights apart, each lamp shines in its own columns alone."""
    compiled = two_lamps()
    columns = choose_columns(compiled, merge=True, split=True)
    carried = carry(compiled, columns)
    assert columns.groups == ("lamp 1", "lamp 2")
    basis, plain = carried.lights.emission_textures.basis, compiled.lights.emission_textures.basis
    assert basis.shape == (6, 8)
    np.testing.assert_array_equal(basis[:3, :4], plain[:3])
    np.testing.assert_array_equal(basis[3:, 4:], plain[3:])
    assert not basis[:3, 4:].any()
    assert not basis[3:, :4].any()
    np.testing.assert_array_equal(carried.textures.basis, np.tile(compiled.textures.basis, 2))


def test_textures_are_an_effect():
    compiled = two_lamps()
    plan = plan_effects(compiled, "auto", 4, 4)
    assert plan.on("textures")
    assert not plan.on("alpha")
    left = leave_out(compiled, plan_effects(compiled, frozenset({"direct"}), 4, 4))
    assert left.textures is None
    assert left.lights.emission_textures is None


def test_coats_and_textures():
    """Where texels and mirror are more than 1 together, both are scaled."""
    texture = pm.Texture.of(np.array([[[0.2], [0.9]]], np.float32))
    mesh = wall(texture)
    material = pm.Material("coat", texture, mirror=0.6)
    mesh = pm.Mesh(mesh.vertices, mesh.faces, material, "coat", uv=SQUARE)
    with pytest.warns(SceneWarning, match="add up to more than 1 and are scaled down in 'coat'"):
        compiled = compile_scene(pm.Scene([mesh], [pm.DomeLight()]), Bands.rgb())
    np.testing.assert_allclose(compiled.textures.maps.factor, 1 / 1.5, rtol=1e-6)
    np.testing.assert_allclose(compiled.specular.mirror, 0.4, rtol=1e-6)
    np.testing.assert_allclose(compiled.materials.reflectance, 0.55 / 1.5, rtol=1e-6)


def test_meshes_without_coordinates_take_the_mean():
    texture = pm.Texture.of(BYTES)
    scene = pm.Scene([wall(texture, uv=None)], [pm.DomeLight()])
    with pytest.warns(
        SceneWarning, match=r"no texture coordinates in 'wall' of material 'wall': the mean"
    ):
        compiled = compile_scene(scene, Bands.rgb())
    assert compiled.textures is None
    np.testing.assert_allclose(compiled.materials.reflectance[0], texture.mean, rtol=1e-6)


def test_scenes_without_textures_have_none(cornell):
    compiled = compile_scene(cornell, Bands.rgb())
    assert compiled.textures is None
    assert compiled.lights.emission_textures is None
    assert compiled.geometry.alpha is None
    assert compiled.geometry.uv.shape == (0, 2)


BAD = {"reaches 1.5": 1.5, "negative or not finite": np.nan, "values that are negative": -0.5}


@pytest.mark.parametrize("message", BAD)
def test_bad_textures(message):
    texture = pm.Texture.of(np.full((1, 1, 3), BAD[message]))
    with pytest.raises(InputError, match=rf"material 'wall': reflectance: .*{message}"):
        compile_scene(pm.Scene([wall(texture)]), Bands.rgb())


def test_bad_coordinates():
    for uv, message in ((SQUARE[:3], r"uv must be \(4, 2\)"), (SQUARE * np.nan, "give finite")):
        with pytest.raises(InputError, match=message):
            compile_scene(pm.Scene([wall(pm.Texture.of(BYTES), uv=uv)]), Bands.rgb())
