"""Glossy lobes that are wider along a tangent than across it."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from bsdf_harness import FRAME, departure, evaluate, hemisphere, sample
from scipy import stats
from test_white_furnace import BRUSHED

import photonmap as pm
from photonmap.compile.scene_arrays import compile_arrays
from photonmap.compile.surfaces.glossy import azimuth_albedos, lobe_albedos
from photonmap.spectra.bands import Bands


def widths(case):
    """α along the tangent and across it."""
    across = case.parameters[0]
    return across + (1.0 - across) * case.anisotropy[0] ** 2, across


def once(case, wi, wo):
    """The BSDF of light that one facet reflects: D G / 4 cos cos, by textbook formulas."""
    along, across = widths(case)
    turn = 2.0 * np.pi * case.anisotropy[1]
    x, y, z = FRAME
    axes = np.stack([np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x, z])
    wi, wo = wi @ axes.T, wo @ axes.T
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    squares = (h / [along, across, 1.0]) ** 2
    density = 1.0 / (np.pi * along * across * squares.sum(axis=1) ** 2)

    def smith(w):
        slope = ((along * w[:, 0]) ** 2 + (across * w[:, 1]) ** 2) / w[:, 2] ** 2
        return 0.5 * (np.sqrt(1.0 + slope) - 1.0)

    return density / (4.0 * wi[:, 2] * wo[:, 2] * (1.0 + smith(wi) + smith(wo)))


@pytest.mark.parametrize("case", BRUSHED[:3])
def test_one_facet_reflects_by_the_textbook(case):
    """What is scattered several times is smooth, positive and known: the furnace closes it."""
    rng = np.random.default_rng(3)
    local = rng.normal(size=(2, 400, 3))
    local[..., 2] = np.abs(local[..., 2]) + 0.2
    wi, wo = (local / np.linalg.norm(local, axis=2, keepdims=True)) @ FRAME
    values = evaluate(case, wi, wo)[0][:, 0]
    rest = values - once(case, wi, wo)
    assert (rest > -1e-3 * values).all()
    assert rest.max() < 0.25
    np.testing.assert_allclose(values, evaluate(case, wo, wi)[0][:, 0], rtol=2e-5)


@pytest.mark.parametrize("azimuth", [0.6, 2.5])
@pytest.mark.parametrize("case", BRUSHED[:2])
def test_samples_are_distributed_by_the_density(case, azimuth):
    """χ² over boxes of the hemisphere."""
    wo = departure(0.6, azimuth)
    count = 50_000
    drawn = sample(case, wo, count=count) @ FRAME.T
    drawn = drawn[drawn[:, 2] > 0.0]
    wi, solid_angles = hemisphere(0.6, 100, 960)
    density = evaluate(case, wi, wo)[1] * solid_angles
    edges = np.linspace(0.0, 1.0, 11), np.linspace(-np.pi, np.pi, 13)

    def boxes(directions, weights=None):
        turned = np.arctan2(directions[:, 1], directions[:, 0])
        return np.histogram2d(directions[:, 2], turned, edges, weights=weights)[0]

    wanted, found = boxes(wi @ FRAME.T, density) * count, boxes(drawn)
    kept = wanted > 20.0
    statistic = ((found - wanted)[kept] ** 2 / wanted[kept]).sum()
    # boxes' edges cut the quadrature's: 0.3% of what is in them
    slack = 1e-5 * (wanted[kept]).sum()
    assert statistic < stats.chi2.isf(1e-4, kept.sum()) + slack


def test_equal_widths_are_the_isotropic_lobe():
    rows = azimuth_albedos(0.3, 0.3 + 1e-12)
    np.testing.assert_allclose(rows, np.broadcast_to(lobe_albedos(0.3), rows.shape), atol=2e-4)


def brushed(rotation=0.0, strength=0.8, uv=True):
    """A floor of brushed metal under a small lamp, seen from the other side."""
    corners = np.array([[-2, 0, -2], [2, 0, -2], [2, 0, 2], [-2, 0, 2]], float)
    look = pm.Material(
        "metal", 0.0, glossy=0.8, roughness=0.4, anisotropy=strength, anisotropy_rotation=rotation
    )
    coordinates = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float) if uv else None
    floor = pm.Mesh(corners, [[0, 2, 1], [0, 3, 2]], look, "floor", uv=coordinates)
    lamp = trimesh.creation.box((0.3, 0.02, 0.3))
    lamp.apply_translation([0, 1.5, 0])
    light = pm.Mesh(lamp.vertices, lamp.faces, pm.Material("lamp", 0.0, 20.0), "lamp")
    camera = pm.Camera((0, 3.0, 0.01), (0, 0, 0), fov=40, up=(0, 0, -1))
    return pm.Scene([floor, light], [], camera)


@pytest.mark.parametrize("rotation", [0.0, 0.25])
def test_highlights_are_long_along_the_tangent(rotation):
    settings = {"bands": "rgb", "size": (16, 16), "passes": 16, "seed": 4}
    result = pm.render(brushed(rotation), **settings)
    image = result.residual.mean(axis=2)
    x, y = np.meshgrid(np.arange(16) - 7.5, np.arange(16) - 7.5)
    along, across = (np.sqrt((image * axis**2).sum() / image.sum()) for axis in (x, y))
    wanted = along > 1.15 * across if rotation == 0.0 else across > 1.15 * along
    assert wanted


def test_no_texture_coordinates_are_needed():
    """Then the tangent goes around the y axis; on a level floor it points anywhere."""
    settings = {"bands": "rgb", "size": (8, 8), "passes": 4, "seed": 4}
    result = pm.render(brushed(uv=False), **settings)
    assert result.radiance.mean() == pytest.approx(
        pm.render(brushed(), **settings).radiance.mean(), rel=0.2
    )


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_it(tmp_path, suffix):
    scene = brushed(rotation=0.125, strength=0.6)
    pm.save_scene(scene, tmp_path / f"floor{suffix}")
    found = pm.load_scene(tmp_path / f"floor{suffix}").meshes[0].material
    assert found.anisotropy == pytest.approx(0.6)
    assert found.anisotropy_rotation == pytest.approx(0.125)
    assert found.roughness == pytest.approx(0.4)


def test_textures_of_roughness_count_with_their_mean():
    even = brushed()
    floor, lamp = even.meshes
    texture = pm.Texture.of(np.array([[0.3, 0.5]], np.float32))
    look = replace(floor.material, roughness=texture)
    varied = pm.Scene([replace(floor, material=look), lamp], [], even.camera)
    message = "anisotropic gloss has one roughness: the mean of its image is used in 'metal'$"
    with pytest.warns(pm.SceneWarning, match=message):
        found = compile_arrays(varied, Bands.rgb()).scattering
    wanted = compile_arrays(even, Bands.rgb()).scattering
    assert found.maps is None
    np.testing.assert_allclose(found.parameters, wanted.parameters, rtol=1e-6)
    np.testing.assert_allclose(found.anisotropy.stretch, wanted.anisotropy.stretch)
