"""Moves and renames keep every bit: small renders against their recorded SHA-256.

A commit that changes arithmetic on purpose records them anew (`make golden`) and says so. On
another processor, or with other versions, last bits differ: there, light is compared within its
standard errors.
"""

import json
import warnings

import numpy as np
import pytest
from golden_cases import ALL, CORNELL, render
from golden_record import COMPARED, HASHES, IMAGES, hashes_of, images_of, machine

RECORDED = json.loads(HASHES.read_text())
LARGEST_SCORE = 0.25
"""Mean squared deviation in standard errors; another seed has 1 or more."""
LAST_BITS = 1e-5


def test_every_case_is_recorded():
    """By images, which hold anywhere; by hashes as well, once all are recorded anew."""
    assert {name.rpartition(" ")[0] for name in np.load(IMAGES).files} == set(ALL)
    assert set(RECORDED["cases"]) <= set(ALL)


@pytest.mark.parametrize("name", ALL)
def test_golden(name, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = ALL[name](tmp_path)
    if RECORDED["machine"] == machine() and name in RECORDED["cases"]:
        assert hashes_of(result) == RECORDED["cases"][name]
    else:
        compare(name, images_of(result))


def test_comparison_tells_another_seed():
    result = render(CORNELL(), seed=12)
    with pytest.raises(AssertionError, match="box radiance"):
        compare("box", images_of(result))


def compare(name, images):
    """Assert that light agrees within standard errors, pooled over an image.

    Most machines walk the same paths, and differ in last bits alone; some paths may part.
    """
    golden = np.load(IMAGES)
    for buffer in COMPARED:
        if buffer not in images:
            continue
        value, truth = images[buffer], golden[f"{name} {buffer}"]
        spread = LAST_BITS * (np.abs(truth) + np.abs(truth).mean())
        if f"{buffer}.error" in images:
            spread = spread + np.hypot(images[f"{buffer}.error"], golden[f"{name} {buffer}.error"])
        finite = np.isfinite(spread)
        score = ((value - truth)[finite] / np.maximum(spread[finite], 1e-30)) ** 2
        assert np.mean(score) <= LARGEST_SCORE, f"{name} {buffer}: {np.mean(score):.3g}"
