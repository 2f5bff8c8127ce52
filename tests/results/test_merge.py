"""Merged runs are what one run of all their passes would have been."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest

import photonmap as pm
from photonmap.commands import main as cli
from photonmap.runtime.workers import Workers
from photonmap.settings import Options, Settings

BOX = pm.scenes.cornell_box()
MIRROR = pm.Material.polished("mirror", 0.8)
GLASS = pm.Material.glass("glass", 1.5)
LAMPS = [
    pm.PointLight((0.5, 0.2, 0.6), (0.0, 0.1, 0.9), name="blue"),
    pm.SpotLight((-0.5, 0.5, 0.5), (0, -1, 0), (0.9, 0.1, 0.0), name="red"),
]


def with_blocks(large, small):
    blocks = {"large_box": large, "small_box": small}
    meshes = [
        pm.Mesh(m.vertices, m.faces, blocks.get(m.name) or m.material, m.name) for m in BOX.meshes
    ]
    return pm.Scene(meshes, LAMPS, BOX.camera)


SCENES = {
    "box": (BOX, {"bands": 3}),
    "center": (BOX, {"bands": 2, "pixel": "center"}),
    "glass": (with_blocks(None, GLASS), {"bands": 2}),
    "light by light": (with_blocks(MIRROR, None), {"bands": 2, "per_light": True}),
}
SEEDS = {3: 3, 8: 2, 1: 8}
"""Seeds, and their numbers of passes: one filters direct light, and sampling does not adapt."""


def in_one_run(scene, options):
    """All passes of all seeds in the same moments, unfiltered: buffers and errors."""
    render = sys.modules["photonmap.render"]
    options = {"pixel": "box", "filter_light": False, **options}
    ledger = None
    with Workers(2) as workers:
        for seed, passes in SEEDS.items():
            chosen = Options(size=(24, 20), passes=1, photons=2000, seed=seed, **options)
            settings = Settings.of(chosen)
            plan = render.compile_and_plan(scene, settings)
            run = render.start_run(plan, settings, workers)
            ledger = ledger or run.moments
            for index in range(passes):
                estimate = run.integrator.estimate(index)
                ledger.add(estimate.pixels, estimate.via_specular)
        images = render.assemble_images(replace(run, moments=ledger))
    return pm.Result(images.buffers, images.errors, settings.bands, {}, images.block_errors)


@pytest.fixture(scope="module", params=SCENES)
def runs(request):
    scene, options = SCENES[request.param]
    same = {"size": (24, 20), "photons": 2000, "adaptive": False, **options}
    parts = [pm.render(scene, seed=seed, passes=passes, **same) for seed, passes in SEEDS.items()]
    return parts, pm.merge(parts), in_one_run(scene, options)


def test_means_and_errors_are_those_of_one_run(runs):
    parts, merged, one = runs
    filtered = [part for part in parts if part.record["light_filter"]["direct"]["on"]]
    assert len(filtered) == 1
    assert list(merged.buffers) == list(one.buffers)
    assert set(merged.errors) == set(one.errors)
    for name, image in one.buffers.items():
        scale = np.abs(image).max()
        assert merged.buffers[name].dtype == image.dtype
        np.testing.assert_allclose(
            merged.buffers[name], image, rtol=2e-6, atol=1e-6 * scale, err_msg=name
        )
    for name, error in one.errors.items():
        scale = np.abs(one.buffers[name]).max()
        np.testing.assert_allclose(
            merged.errors[name], error, rtol=1e-5, atol=1e-6 * scale, err_msg=name
        )
    assert set(merged.block_errors) == set(one.block_errors)
    for name, error in one.block_errors.items():
        scale = np.abs(one.buffers[name]).max()
        np.testing.assert_allclose(
            merged.block_errors[name], error, rtol=1e-5, atol=1e-6 * scale, err_msg=name
        )


def test_identities_hold(runs):
    _, merged, _ = runs
    total = (merged.emission + merged.direct) + merged.indirect
    np.testing.assert_array_equal(merged.radiance, total)
    light = merged.direct + merged.indirect
    plain = (merged.residual == 0.0) & (merged.reflectance > 0.0)
    product = merged.reflectance * merged.shading
    gap = np.abs(product - light)[plain]
    np.testing.assert_array_less(gap, 4 * np.spacing(light[plain]) + 1e-30)
    for name in ("direct", "indirect", "caustics", "shading"):
        parts = [part[name] for part in merged.per_light.values() if name in part]
        if parts:
            np.testing.assert_array_equal(merged.buffers[name], sum(parts[1:], parts[0]))
    np.testing.assert_array_equal(merged.passes, sum(SEEDS.values()))


def test_merged_results_merge_again(runs):
    parts, merged, _ = runs
    again = pm.merge([parts[0], pm.merge([parts[2], parts[1]])])
    for name, image in merged.buffers.items():
        scale = np.abs(image).max()
        np.testing.assert_allclose(
            again.buffers[name], image, rtol=2e-6, atol=1e-6 * scale, err_msg=name
        )
    for name, error in merged.errors.items():
        scale = np.abs(merged.buffers[name]).max()
        np.testing.assert_allclose(
            again.errors[name], error, rtol=1e-5, atol=1e-6 * scale, err_msg=name
        )
    assert [run["seed"] for run in again.record["merged"]] == [3, 1, 8]


def test_the_record_adds_up(runs):
    parts, merged, one = runs
    record, records = merged.record, [part.record for part in parts]
    assert record["arguments"]["seed"] == [run["seed"] for run in record["merged"]] == [*SEEDS]
    for name in ("passes", "photons", "photons_stored", "rays"):
        assert record[name] == sum(part[name] for part in records)
    assert set(record["rays_by_kind"]) == set(records[0]["rays_by_kind"])
    assert record["rays"] == sum(record["rays_by_kind"].values())
    assert record["seconds"]["render"] == sum(part["seconds"]["render"] for part in records)
    valid = (one.coverage == 1.0) & ~one.emission.any(axis=-1) & ~one.unresolved
    value = one.radiance[valid].astype(float)
    relative = (one.errors["radiance"][valid] / 1.0).astype(float) ** 2
    relative = relative / (value**2 + 0.01 * value.mean(axis=0) ** 2)
    assert record["error"] == pytest.approx(np.sqrt(relative.mean()), rel=1e-4)
    json.dumps(record)


def test_single_passes_merge():
    parts = [pm.render(BOX, bands=1, size=(8, 8), passes=1, seed=seed) for seed in range(4)]
    merged = pm.merge(parts)
    stack = np.array([part.direct for part in parts], float)
    error = stack.std(axis=0, ddof=1) / 2.0
    np.testing.assert_allclose(merged.direct, stack.mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(merged.errors["direct"], error, rtol=1e-5, atol=1e-9)


def test_pixels_count_by_their_own_passes():
    one, other = (pm.render(BOX, bands=1, size=(8, 8), passes=2, seed=seed) for seed in (0, 1))
    other.buffers["passes"] = other.passes.copy()
    other.buffers["passes"][0, 0] = 0
    other.buffers["passes"][4, 4] = 6
    merged = pm.merge([one, other])
    np.testing.assert_array_equal(merged.radiance[0, 0], one.radiance[0, 0])
    np.testing.assert_allclose(merged.errors["direct"][0, 0], one.errors["direct"][0, 0], rtol=1e-6)
    mean = 0.25 * one.direct[4, 4] + 0.75 * other.direct[4, 4]
    np.testing.assert_allclose(merged.direct[4, 4], mean, rtol=1e-6)
    assert merged.passes[4, 4] == 8


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("merge")
    plain = {"bands": 2, "size": (8, 8), "passes": 2}
    moved = pm.Scene(BOX.meshes, [], pm.Camera((0, 0, 4), (0, 0, 0)))
    pm.render(BOX, seed=0, **plain).save(folder / "a.exr")
    pm.render(BOX, seed=1, **plain).save(folder / "b.exr")
    pm.render(BOX, seed=2, **plain).save(folder / "part.exr", ["radiance", "passes"])
    pm.render(BOX, seed=2, **{**plain, "size": (8, 9)}).save(folder / "size.exr")
    pm.render(BOX, seed=2, **{**plain, "bands": 3}).save(folder / "bands.exr")
    pm.render(BOX, seed=2, **plain, effects="direct").save(folder / "effects.exr")
    pm.render(moved, seed=2, **plain).save(folder / "camera.exr")
    old = pm.load_result(folder / "a.exr")
    old.record["fingerprint"] |= {"seed": 5, "photonmap": "0.0.9"}
    old.save(folder / "old.exr")
    everything = pm.load_result(folder / "b.exr")
    names = [name for name in everything.buffers if name != "covariance"]
    everything.save(folder / "flat.exr", names)
    (folder / "text.exr").write_text("no image")
    return folder


def test_the_command(files, capsys):
    output = files / "c.exr"
    arguments = [files / "a.exr", files / "b.exr", "-o", output]
    assert cli.main(["merge", *map(str, arguments)]) == 0
    assert "4 passes of seeds 0, 1, error 0." in capsys.readouterr().out
    merged = pm.load_result(output)
    expected = pm.merge([pm.load_result(files / "a.exr"), pm.load_result(files / "b.exr")])
    for name, image in expected.buffers.items():
        np.testing.assert_array_equal(merged.buffers[name], image)
    for name, error in expected.errors.items():
        np.testing.assert_array_equal(merged.errors[name], error)
    for name, error in expected.block_errors.items():
        np.testing.assert_array_equal(merged.block_errors[name], error)
    assert json.loads((files / "c.json").read_text())["merged"] == merged.record["merged"]
    assert output.with_suffix(".png").exists()


BAD = {
    "one": (["a"], "at least two results"),
    "same": (["a", "a"], "seed 0"),
    "again": (["c", "b"], "seed 1"),
    "size": (["a", "size"], "a.exr, 8x9 in {}/size.exr; merge renders that differ in their seed"),
    "bands": (["a", "bands"], "bands 2 in {0}/a.exr, 3 in {0}/bands.exr"),
    "effects": (["a", "effects"], "effects auto in {0}/a.exr, direct in {0}/effects.exr"),
    "camera": (["a", "camera"], "other camera"),
    "version": (["a", "old"], "photonmap 0.1.0 in {0}/a.exr, 0.0.9 in {0}/old.exr"),
    "buffers": (["a", "part"], "'emission', 'direct'"),
    "covariance": (["a", "flat"], "'covariance' is missing; render all buffers to merge"),
    "text": (["a", "text"], "text.exr"),
    "nothing": (["a", "nowhere"], "nowhere.exr"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_merged(files, capsys, case):
    pm.merge([pm.load_result(files / f"{n}.exr") for n in "ab"]).save(files / "c.exr")
    names, messages = BAD[case]
    output = files / "bad.exr"
    inputs = [str(files / f"{name}.exr") for name in names]
    assert cli.main(["merge", *inputs, "-o", str(output)]) == 2
    message = capsys.readouterr().err
    assert messages.format(files) in message
    assert len(message.splitlines()) == 1
    assert not output.exists()


def test_the_output_is_asked_for_and_checked_first(files, capsys):
    assert cli.main(["merge", str(files / "a.exr"), str(files / "b.exr")]) == 2
    assert "--output" in capsys.readouterr().err
    inputs = [str(files / f"{n}.exr") for n in "ab"]
    assert cli.main(["merge", *inputs, "-o", str(files / "a.exr" / "c.exr")]) == 2
    assert "Not a directory" in capsys.readouterr().err


def test_other_bands_are_told(files):
    a, b = (pm.load_result(files / f"{n}.exr") for n in "ab")
    first, last = (b.sel(wavelength=nm) for nm in b.wavelengths)
    with pytest.raises(pm.InputError, match="result 1: bands 2 in result 1, 1 in result 2;"):
        pm.merge([a, first])
    with pytest.raises(pm.InputError, match="result 1: other bands; merge renders"):
        pm.merge([a.sel(wavelength=a.wavelengths[-1]), first])
    assert pm.merge([a.sel(wavelength=a.wavelengths[-1]), last]).bands.count == 1
