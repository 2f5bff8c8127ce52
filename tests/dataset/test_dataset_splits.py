"""Splits that stay as they are when a set grows, and spaces of RGB by name."""

import numpy as np
import pytest

import photonmap as pm
from photonmap import dataset
from photonmap.dataset.files.derived_buffers import (
    as_rgb,
    negative_share,
    rgb_residual,
    with_derived,
)
from photonmap.dataset.files.splits import PARTS, part_of
from photonmap.spectra.projection import SPACES, check_space, from_srgb, projection_onto


def made_of(names, seeds, root="none"):
    """Return a data set of images that were never rendered."""
    entries = [
        {"name": f"{name}-{seed}-{light}", "geometry": f"{name}-{seed}"}
        for name in names
        for seed in seeds
        for light in ("white", "colored")
    ]
    return dataset.Dataset(root, {}, entries)


def test_a_scene_stays_in_its_part_for_ever():
    small, large = (made_of(("study", "jug"), range(count)) for count in (50, 400))
    pairs = zip(small.splits(), large.splits(), strict=True)
    for before, after in pairs:
        assert {e["name"] for e in before.entries} <= {e["name"] for e in after.entries}


def test_parts_share_no_scene_and_are_as_large_as_asked():
    images = made_of(("study", "jug", "kitchen"), range(1000))
    parts = images.splits(0.7, 0.2, 0.1)
    scenes = [set(part.geometries) for part in parts]
    assert sum(map(len, scenes)) == len(set.union(*scenes)) == 3000
    shares = [len(each) / 3000 for each in scenes]
    np.testing.assert_allclose(shares, (0.7, 0.2, 0.1), atol=4 * np.sqrt(0.25 / 3000))
    other = images.splits(0.7, 0.2, 0.1, seed=1)
    assert set(other[0].geometries) != scenes[0]
    assert sum(map(len, images.splits(1.0, 0.0, 0.0))) == len(images)


def test_parts_by_type_share_no_kind_of_room():
    images = made_of([f"room_{n}" for n in range(40)], range(3))
    kinds = [{g.rpartition("-")[0] for g in p.geometries} for p in images.splits(by="type")]
    assert sum(map(len, kinds)) == len(set.union(*kinds)) == 40
    with pytest.raises(pm.InputError, match=r"not split by 'types', but .*; did you mean 'type'"):
        images.splits(by="types")


def test_an_empty_part_is_an_error():
    two = made_of(("study",), range(2))
    message = r"would be empty: .* none of the set's 2 scenes \(names with seeds, such as study-3\)"
    with pytest.raises(pm.InputError, match=message):
        two.splits(0.4, 0.3, 0.3)
    with pytest.raises(pm.InputError, match=r"none of the set's 1 types of scenes \(names alone"):
        two.splits(0.4, 0.3, 0.3, by="type")
    for wrong in ((0.5, 0.1, 0.1), (1.5, -0.5, 0.0), (np.nan, 0.5, 0.5)):
        with pytest.raises(pm.InputError, match="must not be negative and must add up to 1"):
            made_of(("study",), range(2)).splits(*wrong)


def test_the_parts_of_names_do_not_change():
    """They are in manifests that others hold."""
    found = {part: [s for s in range(16) if part_of(f"jug-{s}") == part] for part in PARTS}
    assert found["val"] == [1, 10]
    assert found["test"] == [8]


def test_spaces_agree_with_colour_science():
    colour = pytest.importorskip("colour")
    names = {
        "rec2020": "ITU-R BT.2020",
        "aces-ap0": "ACES2065-1",
        "aces-ap1": "ACEScg",
    }
    to_xyz = from_srgb("xyz")
    for name, known in names.items():
        space = colour.RGB_COLOURSPACES[known]
        expected = np.linalg.inv(
            colour.models.normalised_primary_matrix(space.primaries, space.whitepoint)
        )
        np.testing.assert_allclose(from_srgb(name) @ np.linalg.inv(to_xyz), expected, atol=1e-3)
    white = from_srgb("rec2020") @ np.ones(3)
    np.testing.assert_allclose(white, 1.0, rtol=1e-12)


def test_spaces_that_do_not_exist():
    for name in SPACES:
        assert check_space(name) == name
    with pytest.raises(
        pm.InputError, match="there is no RGB space 'rec2002'; did you mean 'rec2020'"
    ):
        check_space("rec2002")
    with pytest.raises(pm.InputError, match="or give the name of a camera, or a FILE"):
        check_space("Nikkon")


def test_files_in_another_rgb_are_not_taken_for_srgb(tmp_path):
    result = with_derived(pm.render(pm.scenes.cornell_box(), size=(8, 8), passes=2))
    as_rgb(result, "rec2020").save_exr(tmp_path / "rgb.exr")
    again = pm.load_result(tmp_path / "rgb.exr")
    for show in (again.rgb, again.preview, lambda: pm.expose(again)):
        with pytest.raises(pm.InputError, match="green and blue of rec2020, not of"):
            show()
    as_rgb(result).save_exr(tmp_path / "srgb.exr")
    np.testing.assert_array_equal(
        pm.load_result(tmp_path / "srgb.exr").rgb(), as_rgb(result).radiance
    )


def test_bands_of_a_camera_are_its_rgb(tmp_path):
    rows = "\n".join(f"{nm},{nm - 390},1,{710 - nm}" for nm in range(400, 701, 10))
    (tmp_path / "camera.csv").write_text(f"nm,r,g,b\n{rows}\n")
    name = str(tmp_path / "camera.csv")
    assert check_space(name) == name
    bands = pm.Bands.parse(name)
    np.testing.assert_array_equal(projection_onto(bands, name, "regression"), np.eye(3))
    result = with_derived(pm.render(pm.scenes.cornell_box(), bands=bands, size=(8, 8), passes=2))
    rgb = as_rgb(result, name)
    np.testing.assert_array_equal(rgb.radiance, result.radiance)
    assert rgb_residual(rgb) < 1e-6, "I = R·S holds in the bands that were rendered"


def test_reflectance_stays_within_bounds_and_wide_spaces_are_less_negative():
    scene = pm.scenes.cornell_box()
    result = with_derived(pm.render(scene, bands=6, size=(12, 12), passes=2))
    wild = result.buffers["reflectance"].copy()
    wild[0] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    wild[1] = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    result.buffers["reflectance"] = wild
    result.buffers["radiance"] = wild * result.shading + result.emission
    below = {}
    for name in SPACES:
        rgb = as_rgb(result, name)
        assert rgb.reflectance.min() >= 0.0
        assert rgb.reflectance.max() <= 1.0
        product = rgb.reflectance * rgb.shading + rgb.emission + rgb.residual
        np.testing.assert_allclose(product, rgb.radiance, atol=1e-5 * np.abs(rgb.radiance).max())
        below[name] = -rgb.radiance.clip(max=0.0).sum() / np.abs(rgb.radiance).sum()
    assert below["srgb"] > 2 * below["rec2020"]
    assert negative_share(rgb, np.zeros((12, 12), bool)) is None
