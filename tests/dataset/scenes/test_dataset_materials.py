"""Textured and glossy materials: procedures that repeat, patterns that fit, finishes, names."""

import numpy as np
import pytest
from helpers.generated import unlit
from helpers.marks import slow

from photonmap.dataset.models.materials import (
    LEVELS,
    PROCEDURES,
    Palette,
    Surface,
    paint,
    reflectance_of,
    surface_of,
)
from photonmap.dataset.models.scene_object import multi_part
from photonmap.dataset.models.shapes import box, box_mapped, cylinder
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.spectra.bands import Bands
from photonmap.spectra.munsell import munsell, shipped_set

each_procedure = pytest.mark.parametrize("name", PROCEDURES)
CHIP = "5YR 5/6"


def random(seed=0):
    return np.random.Generator(np.random.PCG64(seed))


@each_procedure
def test_procedures_use_both_colours_and_differ_by_seed(name):
    image = paint(name, random(1))
    assert image.min() >= 0
    assert image.max() <= LEVELS - 1
    low, high = np.quantile(image, (0.1, 0.97))
    assert high - low >= 0.25 * LEVELS
    assert 0.1 * LEVELS < image.mean() < 0.7 * LEVELS
    assert not np.array_equal(image, paint(name, random(2)))
    np.testing.assert_array_equal(image, paint(name, random(1)))


@each_procedure
def test_procedures_repeat_without_a_seam(name):
    """Steps across the edge of the image are no larger than those within it."""
    image = paint(name, random(3)).astype(float)
    for axis in (0, 1):
        inside = np.abs(np.diff(image, axis=axis)).mean(axis=1 - axis)
        across = np.abs(image.take(0, axis) - image.take(-1, axis)).mean()
        assert across <= inside.max() + 0.5


@each_procedure
def test_colours_are_mixtures_of_two_chips(name):
    texture = Surface(CHIP, name).material().reflectance
    assert isinstance(texture, SpectralTexture)
    first, last = texture.spectra[0], texture.spectra[-1]
    at = texture.wavelengths
    np.testing.assert_allclose(first, munsell(CHIP)(at), atol=1e-6)
    other = [n for n in shipped_set().names if np.allclose(munsell(n)(at), last, atol=1e-6)]
    assert len(other) == 1
    assert other[0] != CHIP
    np.testing.assert_allclose(texture.spectra[5], first + (last - first) / 3.0, atol=1e-6)


@pytest.mark.parametrize("finish", ["", "glazed "])
def test_cameras_that_see_beyond_a_chip_can_be_bands(finish):
    """Its last value holds there: recovered chips end at 730 nm, this camera's curves at 780 nm."""
    bands = Bands.parse("Nikon 5100 (NPL)")
    assert bands.limits[1] > munsell(CHIP).wavelengths[-1]
    seen = bands.average(Surface(CHIP, finish=finish).material().reflectance)
    within = Bands.parse("Nikon 5100 (NPL)", (400.0, 700.0)).average(munsell(CHIP))
    share = 1.0 - (0.05 if finish else 0.0)
    np.testing.assert_allclose(seen, share * within, rtol=5e-3)


@pytest.mark.parametrize("finish", ["", "glazed ", "glossy "])
@pytest.mark.parametrize("pattern", ["", "wood", "print"])
@pytest.mark.parametrize("chip", [CHIP, "N5"])
def test_names_say_what_a_material_is_made_of(finish, pattern, chip):
    surface = Surface(chip, pattern, finish)
    assert surface_of(surface.name) == surface
    assert surface.material().name == surface.name
    assert surface.material() is surface.material()
    lighter = surface.lighter(2)
    assert lighter._replace(chip=chip) == surface
    assert reflectance_of(lighter.material()) > 1.2 * reflectance_of(surface.material())
    assert surface_of("metal").lighter(1) is None


def test_finishes():
    rough = Surface(CHIP, "", "glossy ").material()
    assert rough.glossy == pytest.approx(0.04)
    assert 0.12 <= rough.roughness <= 0.45
    assert rough.reflectance is not None
    smooth = Surface(CHIP, "", "glazed ").material()
    assert smooth.mirror == 0.05
    metal = Palette(random(), "glossy").metal()
    assert metal.is_glossy
    assert metal.roughness == 0.35
    assert Palette(random(), "mixed").metal().mirror == 0.85
    assert Palette(random(), "textured").metal().name == "N6"


def test_textures_have_their_size_on_all_sides():
    """Coordinates are metres along the surface: areas in them are areas of faces."""
    shape = box(0.4, 0.9, 0.2, 0.0001)
    mapped = box_mapped(shape)
    corners = mapped.uv[mapped.faces]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    flat = 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum()
    assert flat == pytest.approx(shape.area, rel=1e-3)
    assert mapped.area == pytest.approx(shape.area)
    # The grain runs along the longest side, which is upright.
    sides = mapped.uv[np.abs(mapped.normals[:, 0]) > 0.9]
    assert np.ptp(sides[:, 0]) == pytest.approx(0.9, rel=1e-3)
    np.testing.assert_array_equal(mapped.vertices[mapped.faces], shape.vertices[shape.faces])


def test_textures_move_with_what_they_lie_on():
    obj = multi_part("leg", [cylinder(0.05, 0.7)], [Surface(CHIP, "wood").material()])
    moved = obj.turned(37.0).moved((1.0, 2.0, 3.0))
    np.testing.assert_array_equal(obj.parts[0].shape.uv, moved.parts[0].shape.uv)
    assert (
        multi_part("leg", [cylinder(0.05, 0.7)], [Surface(CHIP).material()]).parts[0].shape.uv
        is None
    )


@pytest.mark.parametrize("materials", [*slow("textured", "glossy"), "rich"])
def test_materials_change_nothing_else(materials):
    plain, made = unlit("bedroom"), unlit("bedroom", 0, materials)
    assert plain.camera == made.camera
    assert [o.name for o in plain.named_objects] == [o.name for o in made.named_objects]
    chips = set()
    for a, b in zip(plain.objects, made.objects, strict=True):
        np.testing.assert_allclose(a.boxes, b.boxes, rtol=0.0, atol=1e-12)
        for old, new in zip(a.parts, b.parts, strict=True):
            surface = surface_of(new.material.name)
            assert old.light_group or surface.chip in (old.material.name, "metal", "glass")
            chips.add((surface.pattern, surface.finish))
    patterns, finishes = map(set, zip(*chips, strict=True))
    assert ({"wood", "cloth"} <= patterns) == (materials != "glossy")
    assert ("glossy " in finishes) == (materials != "textured")
