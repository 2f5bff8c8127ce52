"""Fluorescence: its energy, its files, and its reduction to bands by their dual basis."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.spectra.fluorescence import (
    RANGE,
    donaldson,
    quanta_out,
    reradiation,
    reradiation_residual,
)

GRID = np.arange(300.0, 781.0)


def bump(center, sigma, height=1.0):
    return pm.Spectrum(GRID, height * np.exp(-0.5 * ((GRID - center) / sigma) ** 2))


DYE = pm.Fluorescence(bump(450.0, 30.0, 0.8), bump(540.0, 25.0), 0.9)


def test_photons_out_are_those_taken_up_times_the_efficiency():
    at = np.array([380.0, 420.0, 450.0])
    assert np.allclose(quanta_out(DYE, at), 0.9 * DYE.excitation(at), rtol=2e-3)
    energy = DYE.matrix(RANGE, at).sum(axis=0)
    assert (energy < quanta_out(DYE, at)).all()  # the rest is heat


def test_all_that_is_taken_up_may_be_sent_out():
    ramp = pm.Fluorescence(pm.Spectrum([300, 301], [1, 1]), pm.Spectrum([400, 500], [0, 1]))
    assert quanta_out(ramp, np.array([300.0])) == pytest.approx(1.0, abs=0.01)


def test_light_gets_no_shorter_unless_allowed():
    blue = np.array([530.0])
    assert not DYE.matrix(np.arange(300.0, 531.0), blue).any()
    free = pm.Fluorescence(DYE.excitation, DYE.emission, 0.9, anti_stokes=True)
    assert free.matrix(np.arange(300.0, 531.0), blue).any()


@pytest.mark.parametrize("text", ["box:6", "6", "best:6", "31", "Nikon 5100 (NPL)"])
def test_a_smooth_light_is_reduced_exactly(text):
    """Under a constant spectrum, radiance by band is the integral over the matrix."""
    bands = pm.Bands.parse(text)
    low, high = bands.limits
    inside = RANGE[(low <= RANGE) & (high >= RANGE)]
    out = pm.Spectrum(RANGE, DYE.matrix(RANGE, inside).sum(axis=1))
    found = reradiation(DYE, bands) @ np.ones(bands.count)
    assert np.allclose(found, bands.average(out), rtol=1e-3, atol=1e-5)


def test_the_bands_own_curves_would_add_energy():
    """Camera channels overlap: their curves as a basis send out 1.4 times too much."""
    bands = pm.Bands.parse("Nikon 5100 (NPL)")
    curves = np.array([np.interp(GRID, c.wavelengths, c.values) for c in bands.sensitivities])
    naive = curves / (curves @ curves.T).diagonal()[:, None]
    excess = curves @ DYE.matrix(GRID, GRID) @ naive.T @ np.ones(3)
    exact = reradiation(DYE, bands) @ np.ones(3)
    assert excess.sum() > 1.3 * exact.sum()


def test_several_add_up_and_bands_that_see_no_excitation_miss_it():
    bands = pm.Bands.gaussian(9)
    assert np.allclose(reradiation((DYE, DYE), bands), 2.0 * reradiation(DYE, bands))
    assert not reradiation(None, bands).any()
    whitener = pm.Fluorescence(bump(360.0, 10.0, 0.8), bump(440.0, 20.0), 0.9)
    assert reradiation_residual(whitener, bands, pm.emission("D65")) > 0.99
    assert reradiation_residual(DYE, pm.Bands.gaussian(31), pm.emission("A")) < 0.02


def test_a_matrix_of_samples_is_its_curves(tmp_path):
    matrix = pm.DonaldsonMatrix(GRID, GRID, DYE.matrix(GRID, GRID))
    assert np.allclose(donaldson(matrix, GRID, GRID), DYE.matrix(GRID, GRID))
    np.savez(tmp_path / "a.npz", excitation=GRID, emission=GRID, matrix=matrix.values)
    assert pm.DonaldsonMatrix.read(tmp_path / "a.npz") == matrix
    rows = [f"{nm}," + ",".join(map(repr, row)) for nm, row in zip(GRID, matrix.values.tolist())]  # noqa: B905
    header = "nm," + ",".join(f"{nm:g}" for nm in GRID)
    (tmp_path / "a.csv").write_text("\n".join([header, *rows]))
    assert pm.DonaldsonMatrix.read(tmp_path / "a.csv") == matrix


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pm.Fluorescence(bump(450, 30, 1.2), DYE.emission), "excitation is 1.00.* at 4"),
        (lambda: pm.Fluorescence(DYE.excitation, DYE.emission, 1.5), "quantum_efficiency is 1.5"),
        (lambda: pm.Fluorescence(DYE.excitation, bump(5, 1)), "emission is 0 at 300 nm"),
        (lambda: pm.Fluorescence(0.5, DYE.emission), "excitation 0.5 is not a curve"),
        (lambda: pm.DonaldsonMatrix([400, 420], [400, 500], [[0, 1e-3], [0, 0]]), "from 420 to"),
        (
            lambda: pm.DonaldsonMatrix([400, 420], [500, 600], np.ones((2, 2))),
            "138 photons .* arrives at 400",
        ),
        (lambda: pm.DonaldsonMatrix([400, 420], [500, 600], np.ones(2)), r"\(2,\), \(2,\) and"),
        (lambda: pm.DonaldsonMatrix([400, 420], [500, 600], [[0, -1], [0, 0]]), "has -1 from 420"),
    ],
)
def test_what_no_surface_does_is_refused_with_the_wavelength(make, message):
    with pytest.raises(pm.InputError, match=message):
        make()


BLUE, RED = pm.Spectrum([400.0, 440.0], [0.5, 0.5]), pm.Spectrum([600.0, 650.0], [1.0, 1.0])


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (
            lambda: pm.Fluorescence(RED, BLUE),
            "from 400 to 440 nm is at shorter .* from 600 to 650 nm, .* anti_stokes",
        ),
        (lambda: pm.Fluorescence(BLUE, RED, "0.5"), "^quantum_efficiency is '0.5'; give photons"),
        (lambda: pm.Fluorescence(RED, BLUE, anti_stokes=True), r"sends out 1.\d+ watts .* 650 nm"),
        (
            lambda: pm.DonaldsonMatrix([400, 440], [600, 650], np.full((2, 2), 0.02)),
            "sends out 1.56 photons for each that arrives at 400 nm",
        ),
    ],
)
def test_what_no_fluorophore_can_be_is_refused(make, problem):
    with pytest.raises(pm.InputError, match=problem):
        make()


def test_sharp_edges_count_as_their_integral():
    """Steps of 1 nm count 51 of the 50 nm of a rectangle."""
    rows = np.full((2, 2), 0.02 * 400.0 / 625.0)
    assert quanta_out(pm.DonaldsonMatrix([400, 401], [600, 650], rows), np.array([400.0])) == (
        pytest.approx(1.0, rel=1e-9)
    )
    half = pm.Fluorescence(RED * 0.6, BLUE, anti_stokes=True)
    at = np.array([620.0])
    assert quanta_out(half, at) == pytest.approx(0.6 * 620.0 / 420.0, rel=1e-9)


def test_black_light_is_suggested():
    with pytest.raises(pm.InputError, match=r"there is no light 'Blacklight'; .*'black light'"):
        pm.emission("Blacklight")
