"""Lean files: half precision, nothing that follows from something else, read part by part."""

import dataclasses
import json

import numpy as np
import pytest
from helpers.marks import slow

from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.files import lean as lean_module
from photonmap.dataset.files.image_files import BANDS_EXR
from photonmap.dataset.files.lean import ERRORS, Arrays, fits_half
from photonmap.dataset.jobs.plan import CommonSettings, plan_jobs
from photonmap.dataset.jobs.presets import Preset
from photonmap.dataset.jobs.render_image import Task, render_image
from photonmap.dataset.jobs.verify import check_digests
from photonmap.io import exr

COMMON = CommonSettings((48, 36), "6", "0.5", inputs="0")
HALF = 2.0**-11
"""Largest relative error of rounding to half precision."""


@pytest.fixture(scope="module", params=[*slow("colored"), "two_mixed"])
def pair(tmp_path_factory, request):
    """One image in lean files, rendered by one thread, and in full ones, by two."""
    preset = Preset("one", ("jug",), illuminations=(request.param,))
    [job] = plan_jobs(preset, [], COMMON)
    images = []
    for full, threads in ((False, 1), (True, 2)):
        folder = tmp_path_factory.mktemp("full" if full else "lean")
        entry = render_image(Task(job, str(folder), ("exr",), threads=threads, full=full))
        images.append(dataset.Image(folder, entry))
    return images


def test_lean_files_are_small_and_say_the_same(pair):
    lean, full = pair
    sizes = [sum(p.stat().st_size for p in image.folder.glob("*.exr")) for image in pair]
    assert sizes[0] < sizes[1] / 2  # a tenth where images are larger than headers
    left_out = set(full) - set(lean)
    dropped = ("covariance", "direct_unfiltered", "indirect_unfiltered")
    assert all(
        name.endswith((".error", ".error8")) or name.startswith(dropped) for name in left_out
    )
    for name, image in lean.items():
        truth = full[name]
        assert image.dtype == truth.dtype
        if name in ("depth", "distance") or image.dtype != np.float32:
            np.testing.assert_array_equal(image, truth)
        else:
            factor = 2.1 if name == "illuminant" else 1.001
            np.testing.assert_allclose(image, truth, rtol=factor * HALF, atol=1e-7)
    for name in ("radiance", "reflectance", "shading"):
        np.testing.assert_allclose(lean.rgb[name], full.rgb[name], rtol=1.001 * HALF, atol=1e-7)


def test_rounding_is_below_the_noise(pair):
    lean, full = pair
    for name in ERRORS:
        noisy = full[f"{name}.error"] > 0.0
        change = (lean[name] - full[name])[noisy]
        noise = full[f"{name}.error"][noisy]
        assert np.sqrt((change**2).mean()) < 0.05 * np.sqrt((noise**2).mean()), name


def test_equal_images_are_equal_files(pair, tmp_path):
    lean, _ = pair
    [job] = plan_jobs(
        Preset("one", ("jug",), illuminations=(lean.entry["job"]["illumination"],)), [], COMMON
    )
    again = render_image(Task(job, str(tmp_path), ("exr",), threads=2))
    assert again["files"] == lean.entry["files"]
    assert again["arrays"] == lean.entry["arrays"]


def test_only_what_is_asked_for_is_read(pair, monkeypatch):
    lean = dataset.Image(pair[0].folder.parent, pair[0].entry)
    read = []
    read_part = exr._read_part

    def counting(file, index, bands):
        part = read_part(file, index, bands)
        read.append(part[0])
        return part

    monkeypatch.setattr(exr, "_read_part", counting)
    assert "illuminant" in lean
    assert len(list(lean)) > 20
    assert not read
    for _ in range(2):
        lean["scalar_shading"], lean["depth"], lean["illuminant"]
    assert read == ["shading", "depth"]
    assert set(lean.rgb["reflectance"].shape) == {36, 48, 3}
    assert read[2:] == ["reflectance"]


def test_values_that_half_precision_cannot_hold_keep_single():
    image = np.ones((4, 4, 3), np.float32)
    assert fits_half("radiance", image)
    assert fits_half("radiance", 0.0 * image)
    assert fits_half("radiance.error", 0.01 * image)
    assert fits_half("radiance.error", 1e-3 * image)
    assert fits_half("residual", 1e-3 * image)
    assert not fits_half("radiance.error", 1e-6 * image)
    assert not fits_half("radiance", 1e5 * image)
    assert not fits_half("radiance", 1e-3 * image)
    assert not fits_half("radiance", np.inf * image)
    assert not fits_half("depth", image[..., 0])
    assert not fits_half("object_id", image[..., 0].astype(np.uint32))


def test_images_of_an_earlier_layout_are_verified(tmp_path, monkeypatch, capsys):
    """Their errors were in single precision where they are small."""
    preset = tmp_path / "one.toml"
    preset.write_text('scenes = ["jug"]\nilluminations = ["white"]')
    size = ["--size", "16x12", "--bands", "3", "--error", "0.5", "--format", "exr", "--quiet"]
    with monkeypatch.context() as earlier:
        earlier.setattr(lean_module, "_LEAST_REST", 1.0)
        assert main(["dataset", str(tmp_path / "set"), "--preset", str(preset), *size]) == 0
    [image] = dataset.open(tmp_path / "set")
    assert "radiance.error" not in image.halves
    assert main(["dataset", "verify", str(tmp_path / "set")]) == 0
    assert "identical bit for bit" in capsys.readouterr().out


def test_digests_tell_which_array_was_changed(pair, tmp_path):
    lean, _ = pair
    assert list(check_digests(lean)) == []
    entry = json.loads(json.dumps(lean.entry))
    (tmp_path / entry["name"]).mkdir()
    changed = dataclasses.replace(lean.result, buffers=dict(lean.result.buffers))
    changed.buffers["normal"] = changed.buffers["normal"][::-1]
    changed.save_exr(tmp_path / entry["name"] / BANDS_EXR)
    faults = list(check_digests(dataset.Image(tmp_path, entry)))
    assert faults == ["arrays differ from those that were rendered: normal"]


def test_the_shares_of_lights_add_up(pair):
    lean, full = pair
    shares, truth = lean.light_shares(), full.light_shares()
    assert set(shares) == set(lean.entry["lights"])
    lit = lean["scalar_shading"] > 0.0
    np.testing.assert_allclose(sum(shares.values())[lit], 1.0, rtol=1e-6)
    for light, share in shares.items():
        part = full[f"shading@{light}"].sum(axis=-1) / np.maximum(
            full["shading"].sum(axis=-1), 1e-9
        )
        np.testing.assert_allclose(truth[light], part, atol=1e-5)
        np.testing.assert_allclose(share, truth[light], atol=3 * HALF)


def test_arrays_that_are_not_there_are_told(pair):
    lean, _ = pair
    for images, name, message in (
        (lean, "shadings", "'shadings' is not one of 'radiance'.*'background'[^;]*$"),
        (lean, "diffuse_fraction", "make the set with diffuse_fraction among --buffers"),
        (lean, "indirect.error", "make the set with --full"),
        (lean, "covariance", "make the set with --full"),
        (lean.rgb, "depth", r"'depth' is not one of 'radiance'.*: image\['depth'\]"),
        (Arrays(radiance=lean.rgb["radiance"]), "depth", r"image\['depth'\]"),
    ):
        with pytest.raises(KeyError, match=message):
            images[name]


def test_what_is_zero_everywhere_is_read_as_zeros(pair):
    """As of a result: sums and products hold whether files have such buffers or not."""
    for image in pair:
        for name in ("residual", "caustics"):
            assert name not in image
            assert image[name].shape == image["radiance"].shape
            assert image[name].dtype == np.float32
            np.testing.assert_array_equal(image[name], getattr(image.result, name))
