"""What the bench of rooms says of errors and times, where the answer is known."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.accuracy.calibration import KINDS, calibration, pixel_kinds
from benchmarks.accuracy.room_mitsuba import DENOISED, SAMPLES, render_or_read
from benchmarks.accuracy.rooms import time_to_denoised
from photonmap.film.variance_smoothing import degrees_of_freedom
from photonmap.kernels.core.passes import Prepass

SIZE = HEIGHT, WIDTH = 60, 80


def _result(seed, spread, passes=16, stated=None):
    """A render of constant light whose noise is known."""
    rng, shape = np.random.default_rng(seed), (HEIGHT, WIDTH, 3)
    buffers = {
        name: (value + spread * rng.standard_normal(shape)).astype(np.float32)
        for name, value in (("radiance", 3.0), ("direct", 2.0), ("indirect", 1.0))
    }
    error = np.full(shape, stated or spread, np.float32)
    return SimpleNamespace(
        buffers=buffers,
        standard_error=lambda name: error,
        degrees_of_freedom=lambda name: degrees_of_freedom(name, passes),
        **buffers,
    )


def _kinds():
    """Left third flat, then a penumbra, then an edge."""
    prepass = Prepass(*(np.zeros(SIZE, np.uint8) for _ in Prepass._fields))
    prepass.flat[:, :60], prepass.penumbra[:, 31:50] = 1, 1
    return pixel_kinds(prepass, (WIDTH, HEIGHT))


def test_kinds_part_the_image():
    kinds = _kinds()
    assert [int(kinds[kind].sum()) for kind in KINDS] == [39 * HEIGHT, 21 * HEIGHT, 20 * HEIGHT]


def test_honest_errors_hold_in_all_kinds_and_halved_ones_do_not():
    valid, truth = np.ones(SIZE, bool), _result(1, 0.01, passes=4000)
    honest = calibration(_result(2, 0.1), truth, valid, _kinds())
    for cell in honest[:3]:
        # Student's t of 15 on noise whose spread is known: 95.1 to 95.5% within 2.13
        assert all(95.0 < float(share) < 98.5 for share in cell.split(" / "))
    assert honest[3] == "0 / 0 / 0"
    assert honest[4] == pytest.approx(1.0, abs=0.02)
    halved = calibration(_result(2, 0.1, stated=0.05), truth, valid, _kinds())
    assert all(60.0 < float(share) < 75.0 for share in halved[0].split(" / "))
    assert halved[4] == pytest.approx(2.0, abs=0.1)


class _Mitsuba:
    """One that takes 2 seconds, or 3, a render."""

    version, variant, renders = "3", "llvm", 0

    def __init__(self, seconds):
        self.processor = seconds

    def render(self, samples, seed, depth=-1):
        self.renders += 1
        rng = np.random.default_rng([samples, seed, depth + 1])
        return rng.random((2, 3, 3)).astype(np.float32), 0.0

    def denoise(self, image, samples):
        return image


def test_kept_images_are_read_for_the_same_scene_alone(tmp_path):
    scene = tmp_path / "scene" / "scene.json"
    scene.parent.mkdir()
    scene.write_text(f"{scene.parent}/mesh.ply")
    kept = tmp_path / "kept"
    first = render_or_read(_Mitsuba(2.0), (scene, 5.0), "box", kept)
    again = _Mitsuba(3.0)
    second = render_or_read(again, (scene, 5.0), "box", kept)
    assert again.renders < len(DENOISED)
    assert (first.seconds, second.seconds) == (2.0, 3.0)
    np.testing.assert_array_equal(first.mean, second.mean)
    np.testing.assert_allclose(second.denoised_seconds, 1.5 * first.denoised_seconds)
    scene.write_text("another")
    render_or_read(again, (scene, 5.0), "box", kept)
    assert again.renders > len(DENOISED)
    assert len(list(Path(kept).iterdir())) == 2


def test_denoised_images_are_not_extrapolated():
    points = [(1.0, 1e-2), (4.0, 1e-3), (16.0, 9e-4)]
    assert time_to_denoised(1e-2, points) == (1.0, False)
    assert time_to_denoised(2e-2, points) == (1.0, False)
    assert time_to_denoised(1e-3, points)[0] == pytest.approx(4.0)
    assert time_to_denoised(1e-4, points)[0] == np.inf
    assert SAMPLES in DENOISED
