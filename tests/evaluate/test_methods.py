"""Each method on a synthetic image whose decomposition or light it finds exactly."""

import numpy as np
import pytest
from helpers.marks import slow
from helpers.mondrians import ALL, SIZE, run, stripes

from photonmap import InputError, evaluate
from photonmap.evaluate.methods.method import BUILT_IN, FLOOR, find_method, method_names
from photonmap.evaluate.methods.poisson import differences, integrate

LIGHT = np.array([1.0, 0.8, 0.5, 0.9])


def assert_proportional(found, truth, mask=ALL):
    ratio = (found / truth)[mask]
    np.testing.assert_allclose(ratio, ratio.flat[0], rtol=1e-9)


SMOOTH = np.linspace(0.5, 1.0, SIZE[0])[:, None] * np.ones(SIZE)
"""Shading that changes slowly from top to bottom, by at most 4.3% from one line to the next"""


def test_differences_of_an_image_integrate_to_it():
    """Up to the mean of each of two parts that do not touch."""
    image = np.random.default_rng(0).normal(size=SIZE)
    mask = ALL.copy()
    mask[:, 11] = mask[3, 4] = False
    found = integrate(*differences(image), mask)
    for part in (mask & (np.arange(SIZE[1]) < 11), mask & (np.arange(SIZE[1]) > 11)):
        np.testing.assert_allclose(found[part], image[part] - image[part].mean(), atol=1e-12)
    assert not found[~mask].any()


def test_contradictory_differences_have_their_least_squares_solution():
    rng = np.random.default_rng(1)
    height, width = 5, 6
    mask = rng.uniform(size=(height, width)) < 0.9
    down, right = rng.normal(size=(height - 1, width)), rng.normal(size=(height, width - 1))
    rows, wanted = [], []
    for i in range(height):
        for j in range(width):
            for k, m, t in ((i + 1, j, down), (i, j + 1, right)):
                if k < height and m < width and mask[i, j] and mask[k, m]:
                    row = np.zeros((height, width))
                    row[i, j], row[k, m] = -1.0, 1.0
                    rows.append(row[mask])
                    wanted.append(t[i, j])
    expected = np.linalg.lstsq(np.array(rows), np.array(wanted))[0]  # of least norm: mean 0
    np.testing.assert_allclose(integrate(down, right, mask)[mask], expected, atol=1e-12)


def test_baselines():
    image = np.random.default_rng(0).uniform(size=(*SIZE, 3))
    reflectance, shading = run("constant-reflectance", image), run("constant-shading", image)
    assert (reflectance.reflectance == 1.0).all()
    assert (reflectance.shading == image).all()
    assert (shading.reflectance == image).all()
    assert (shading.shading == 1.0).all()


@pytest.mark.parametrize("bands", [1, 3, 6])
def test_retinex_separates_stripes_from_smooth_shading(bands):
    reflectance = stripes([[value] * bands for value in (0.2, 0.8, 0.5)])
    image = reflectance * SMOOTH[..., None]
    found = run("retinex", image)
    assert_proportional(found.shading, SMOOTH)
    assert_proportional(found.reflectance, reflectance)
    blind = run("retinex", image, threshold=5.0)
    assert_proportional(blind.shading, image[..., 0])
    keen = run("retinex", image, threshold=1e-6)
    assert_proportional(keen.reflectance, image)


def test_color_retinex_sees_edges_of_colour():
    """Both stripes have nearly the same grey value, so that Retinex takes them for shading."""
    reflectance = stripes([(0.6, 0.3, 0.3), (0.3, 0.32, 0.62)])
    image = reflectance * SMOOTH[..., None]
    found = run("color-retinex", image)
    assert_proportional(found.shading, SMOOTH)
    assert_proportional(found.reflectance, reflectance)
    grey = run("retinex", image)
    assert evaluate.lmse(SMOOTH, found.shading) < 1e-3 * evaluate.lmse(SMOOTH, grey.shading)
    blind = run("color-retinex", image, grey=0.1, color=9.0)
    np.testing.assert_allclose(blind.shading, grey.shading)


def test_weiss_finds_what_does_not_move():
    """Shadows with edges in different places; at each edge, two of three images have none."""
    rng = np.random.default_rng(0)
    reflectance = rng.uniform(0.2, 0.9, (*SIZE, 3))
    shadings = []
    for column, row in ((5, 20), (12, 10), (22, 4)):
        shading = np.ones(SIZE)
        shading[:row, :column] = 0.3
        shadings.append(shading)
    relit = tuple(reflectance * shading[..., None] for shading in shadings)
    for image, shading in zip(relit, shadings, strict=True):
        found = run("weiss", image, relit=relit)
        assert_proportional(found.shading, shading)
        assert_proportional(found.reflectance, reflectance)
    with pytest.raises(InputError, match="in two or more lights; there is one"):
        run("weiss", relit[0], relit=relit[:1])


def test_weiss_uses_pixels_where_they_are_valid():
    reflectance = np.random.default_rng(0).uniform(0.2, 0.9, (*SIZE, 3))
    spoilt = 0.5 * reflectance
    spoilt[4:6, 7:9] = np.nan
    found = run("weiss", reflectance, relit=(reflectance, spoilt))
    assert_proportional(found.reflectance, reflectance)


@pytest.mark.parametrize("name", ["retinex", "color-retinex", "weiss"])
def test_dark_pixels_are_raised_to_the_floor(name):
    image = stripes([(0.5, 0.5, 0.5), (0.0, 0.0, 0.0)]).copy()
    image[0, 0] = -0.1  # as projection to RGB may leave
    found = run(name, image, relit=(image, image))
    assert np.isfinite(found.reflectance).all()
    assert np.isfinite(found.shading).all()
    assert found.shading.min() > 0.0
    assert pytest.approx(0.0117, abs=1e-4) == FLOOR


@pytest.mark.parametrize("name", ["grey-world", "white-patch", "shades-of-grey", "grey-edge"])
def test_achromatic_scenes_show_the_light(name):
    """In any number of bands, whatever is in pixels that are not valid."""
    grey = np.random.default_rng(0).uniform(0.1, 1.0, SIZE)
    image = grey[..., None] * LIGHT
    assert evaluate.angular_error(LIGHT, run(name, image).illuminant) < 1e-5
    mask = ALL.copy()
    mask[3:6, 20:] = False
    image[~mask] = (9.0, 0.0, 0.0, 3.0)
    assert evaluate.angular_error(LIGHT, run(name, image, mask).illuminant) < 1e-5


def test_norms_by_hand():
    """Values 1, 2, 2 in one band and 1, 1, 2 in the other; negative ones count as 0."""
    image = np.array([[[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]])
    mask = np.ones((1, 3), bool)
    np.testing.assert_allclose(run("grey-world", image, mask).illuminant, [5 / 3, 4 / 3])
    np.testing.assert_allclose(run("white-patch", image, mask).illuminant, [2.0, 2.0])
    sixth = [(129 / 3) ** (1 / 6), (66 / 3) ** (1 / 6)]
    np.testing.assert_allclose(run("shades-of-grey", image, mask).illuminant, sixth)
    image[0, 0] = -1.0
    np.testing.assert_allclose(run("grey-world", image, mask).illuminant, [4 / 3, 1.0])


def test_grey_edge_ignores_flat_colour():
    """A field of red, however large, has no edges."""
    grey = np.random.default_rng(0).uniform(0.1, 1.0, (24, 60))
    image = grey[..., None] * LIGHT[:3]
    image[:, 30:] = image[:, 29:30] * (1.0, 0.1, 0.1)
    image[:, 25:31] = image[:, 25:26]
    edge, world = (
        evaluate.angular_error(LIGHT[:3], run(name, image, np.ones((24, 60), bool)).illuminant)
        for name in ("grey-edge", "grey-world")
    )
    assert edge < 0.5 * world


@pytest.mark.parametrize("name", [*(name for name in BUILT_IN if name != "sirfs"), *slow("sirfs")])
def test_methods_are_deterministic_and_unbothered_by_scale(name):
    image = np.random.default_rng(3).uniform(0.3, 1.0, (*SIZE, 3))
    relit = (image, image**1.2)
    first, second = run(name, image, relit=relit), run(name, image, relit=relit)
    twice = run(name, 2.0 * image, relit=tuple(2.0 * other for other in relit))
    for layer in ("reflectance", "shading", "illuminant"):
        found = getattr(first, layer)
        if found is not None:
            np.testing.assert_array_equal(found, getattr(second, layer))
            if found.any():
                assert_proportional(getattr(twice, layer), found, np.ones_like(found, bool))


PLUGIN = """
import numpy as np
from photonmap.evaluate.methods.method import Estimate, Method

METHOD = Method("half", lambda view: Estimate(shading=np.full(view.mask.shape, 0.5)))
OTHER = "half"
"""


@pytest.fixture
def plugin(tmp_path, monkeypatch):
    """Install a package that adds methods; call it with its entry points."""
    (tmp_path / "halves.py").write_text(PLUGIN)
    info = tmp_path / "halves-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: halves\nVersion: 1.0\n")
    monkeypatch.syspath_prepend(tmp_path)

    def install(*points):
        (info / "entry_points.txt").write_text("\n".join(["[photonmap.methods]", *points]))

    return install


def test_packages_add_methods(plugin):
    plugin("half = halves:METHOD")
    assert method_names() == (*BUILT_IN, "half")
    assert (run("half", np.ones((*SIZE, 3))).shading == 0.5).all()


def test_wrong_methods_are_named(plugin):
    with pytest.raises(InputError, match="no method 'retinx'; did you mean 'retinex'"):
        find_method("retinx")
    plugin("half = halves:OTHER", "third = halves:THIRD", "retinex = halves:METHOD")
    with pytest.raises(InputError, match="halves:OTHER, method 'half', is not a Method"):
        find_method("half")
    with pytest.raises(InputError, match="'third' cannot be imported from halves:THIRD"):
        find_method("third")
    with pytest.raises(InputError, match="adds a method 'retinex', which exists; rename it"):
        find_method("retinex")
