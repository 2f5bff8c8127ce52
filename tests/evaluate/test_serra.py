"""The reading of Serra's method: names, ridges, the field, and a sharp shadow."""

import numpy as np
import pytest
from helpers.mondrians import COLORS, SIZE, mondrian, run

from photonmap import evaluate
from photonmap.evaluate.methods import serra
from photonmap.evaluate.methods.poisson import neighbours
from photonmap.evaluate.methods.serra import CHROMATIC, NAMES, _levels, memberships, ridge_numbers


def linear(srgb):
    values = np.array(srgb) / 255.0
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def test_colours_of_the_web_have_their_names():
    """CSS's own; for red its crimson, as the primaries of sRGB have hues of other names."""
    web = {
        "red": (220, 20, 60), "orange": (255, 165, 0), "brown": (139, 69, 19),
        "yellow": (255, 255, 0), "green": (0, 128, 0), "blue": (70, 130, 180),
        "purple": (128, 0, 128), "pink": (255, 192, 203), "black": (0, 0, 0),
        "grey": (128, 128, 128), "white": (255, 255, 255),
    }  # fmt: skip
    found = memberships(linear([*web.values(), (255, 0, 0), (0, 0, 255)]))
    named = [NAMES[index] for index in found.argmax(axis=1)]
    assert named == [*web, "orange", "purple"]
    assert found.max(axis=1).min() > 0.85


def test_memberships_share_one_among_all_names():
    colors = np.random.default_rng(0).uniform(-0.1, 1.2, (5000, 3))
    found = memberships(colors)
    np.testing.assert_allclose(found.sum(axis=1), 1.0)
    assert found.min() >= 0.0
    assert (found.max(axis=0) > 0.9).all()
    np.testing.assert_array_equal(found, memberships(np.clip(colors, 0.0, 1.0)))


def test_hues_between_two_names_belong_to_both():
    """On the boundary of orange and yellow, far from grey, each has a half; off it, one of them."""
    for level in _levels():
        hues = [hue for _, hue, _ in level.boundaries]
        assert hues == sorted(hues)
        assert {name for name, _, _ in level.boundaries} < set(CHROMATIC)
    level = _levels()[3]
    name, hue, _ = level.boundaries[2]
    both = [NAMES.index("orange"), NAMES.index(name)]
    for turn, shares in ((-9.0, (1.0, 0.0)), (0.0, (0.5, 0.5)), (9.0, (0.0, 1.0))):
        angle = np.radians(hue + turn)
        a, b = level.center + 50.0 * np.array([np.cos(angle), np.sin(angle)])
        found = memberships(rgb_of_lab(60.0, a, b)[None])[0, both]
        np.testing.assert_allclose(found, shares, atol=0.04)


def rgb_of_lab(lightness, a, b):
    """Return linear sRGB of CIELAB, by the formulas of CIE 15 and IEC 61966-2-1."""
    y = (lightness + 16.0) / 116.0
    curve = np.array([y + a / 500.0, y, y - b / 200.0])
    xyz = np.where(curve > 6 / 29, curve**3, 3 * (6 / 29) ** 2 * (curve - 4 / 29))
    to_rgb = [(3.2406, -1.5372, -0.4986), (-0.9689, 1.8758, 0.0415), (0.0557, -0.2040, 1.0570)]
    return np.array(to_rgb) @ (xyz * (0.9505, 1.0, 1.089))


def test_each_surface_is_a_ridge_however_it_is_shaded():
    """Also where noise widens ridges, and where two surfaces have one hue and a gap between."""
    rng = np.random.default_rng(2)
    surface = rng.integers(0, 3, 6000)
    shading = rng.uniform(0.4, 1.0, 6000)
    colors = COLORS[surface] * shading[:, None] * np.exp(rng.normal(0.0, 0.01, (6000, 3)))
    found = ridge_numbers(colors)
    for number in range(3):
        common = np.bincount(found[surface == number]).argmax()
        assert (found[surface == number] == common).mean() > 0.95
        assert (found[surface != number] == common).mean() < 0.01
    one_hue = np.concatenate([COLORS[0] * rng.uniform(low, low + 0.1, (3000, 1))
                              for low in (0.3, 0.9)])  # fmt: skip
    dark, light = ridge_numbers(one_hue).reshape(2, -1)
    assert not set(dark) & set(light)


def test_an_image_of_one_colour_has_one_ridge():
    assert len(set(ridge_numbers(np.full((50, 3), 0.7)))) == 1
    assert len(set(ridge_numbers(np.full((1, 3), 0.7)))) == 1


def described(seed, count):
    rng = np.random.default_rng(seed)
    names = rng.uniform(0.1, 1.0, (count, 4))
    names /= names.sum(axis=1, keepdims=True)
    return rng.normal(size=count), serra.Descriptors(rng.integers(0, 3, count), names)


def test_the_field_lowers_the_energy_of_all_pairs():
    """Its minimum is that of the energy with each pair of pixels written out, solved densely."""
    mask = np.ones((4, 5), bool)
    mask[1, 2] = False
    count, tie = 19, 0.7
    log_image, descriptors = described(1, count)
    pairs = neighbours(mask)
    rows, wanted = [], []

    def ask(second, first, weight, step):
        row = np.zeros(count)
        row[second], row[first] = np.sqrt(weight), -np.sqrt(weight)
        rows.append(row)
        wanted.append(np.sqrt(weight) * step)

    ridge, names = descriptors
    for second, first in pairs.T:
        alike = 1.0 if ridge[second] == ridge[first] else np.minimum(*names[[second, first]]).sum()
        ask(second, first, 1.0, (1.0 - alike) * (log_image[second] - log_image[first]))
    for i in range(count):
        for j in range(i):
            if ridge[i] == ridge[j]:
                whole = names[ridge == ridge[i]].sum(axis=0)
                ask(i, j, tie * (names[i] * names[j] / whole).sum(), 0.0)
    best = np.linalg.lstsq(np.array(rows), np.array(wanted))[0]
    found = serra.log_reflectance(log_image, descriptors, pairs, tie)
    np.testing.assert_allclose(found - found.mean(), best - best.mean(), atol=1e-6)


def test_neighbours_of_one_ridge_or_name_are_alike():
    sure = np.eye(3)[[0, 0, 1, 1]]
    descriptors = serra.Descriptors(np.array([0, 1, 1, 2]), sure)
    pairs = np.array([[1, 2, 3, 3], [0, 1, 2, 0]])
    np.testing.assert_array_equal(serra.likeness(descriptors, pairs), [1.0, 1.0, 1.0, 0.0])


def test_a_shadow_with_a_sharp_edge_is_shading():
    """Which Retinex takes for reflectance: two thirds of the light end within a pixel."""
    reflectance, shading = mondrian(times=2)
    shading = shading * np.where(np.arange(SIZE[0]) < 12, 1.0, 0.35)[:, None]
    image = reflectance * shading[..., None]
    theirs = run("color-retinex", image)
    ours = evaluate.si_mse(shading, run("serra", image).shading)
    assert ours < 0.1 * evaluate.si_mse(shading, theirs.shading)


@pytest.mark.parametrize("bands", [1, 2, 4, 6])
def test_other_bands_than_rgb(bands):
    """Those of one hue in RGB have it in more bands, which go from blue to red."""
    reflectance, shading = mondrian(times=2)
    image = reflectance * shading[..., None]
    if bands < 3:
        image = image[..., :bands]
    else:
        image = np.repeat(image[..., ::-1], 2, axis=-1)[..., :bands]
    found = run("serra", image)
    assert found.reflectance.shape == image.shape
    if bands == 6:
        np.testing.assert_allclose(
            found.shading, run("serra", image[..., 4::-2]).shading, rtol=1e-6
        )
