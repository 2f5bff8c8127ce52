"""Munsell chips: notations, the renotation, and measured sets."""

from pathlib import Path

import numpy as np
import pytest

from photonmap.errors import InputError, SceneWarning
from photonmap.spectra import munsell as chips
from photonmap.spectra.munsell import canonical, munsell, munsell_set, recover, shipped_set
from photonmap.spectra.names import colour_science

MEASURED = Path(__file__).parents[3] / "shared" / "data" / "munsell_matt_1269.npz"


@pytest.fixture(autouse=True)
def without_measured_chips(monkeypatch):
    monkeypatch.delenv(chips.VARIABLE, raising=False)


@pytest.mark.parametrize(
    ("notation", "name"),
    [
        ("5R 5/10", "5R 5/10"),
        (" 2.50yr4.0 / 6 ", "2.5YR 4/6"),
        ("10BG 8.5/.5", None),
        ("N 5", "N5"),
        ("N5/", "N5"),
        ("5R 5/0", "N5"),
        ("5X 5/10", None),
        ("red", None),
    ],
)
def test_notations(notation, name):
    if name is None:
        with pytest.raises(InputError, match="is not a Munsell notation"):
            canonical(notation)
    else:
        assert canonical(notation) == name


@pytest.mark.parametrize("name", ["5R 5/10", "10PB 3/8", "2.5G 8/4", "3.2R 4.7/6.3"])
def test_a_recovered_chip_has_the_colour_of_the_renotation(name):
    chip = recover(name)
    assert 0.0 <= chip.values.min() <= chip.values.max() <= 1.0
    with colour_science() as colour:
        wanted = colour.xyY_to_XYZ(colour.munsell_colour_to_xyY(name))
        curve = colour.SpectralDistribution(chip.values, chip.wavelengths)
        observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
        seen = colour.sd_to_XYZ(curve, observer, colour.SDS_ILLUMINANTS["C"]) / 100.0
    np.testing.assert_allclose(seen, wanted, atol=0.01)


def test_greys_are_flat():
    grey = munsell("N 5")
    assert np.ptp(grey.values) == 0.0
    assert grey.values[0] == pytest.approx(0.1927, abs=2e-4)  # ASTM D1535: Y of value 5, /0.975
    assert munsell("N 10").values[0] == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize(
    ("notation", "message"),
    [
        ("5R 5/40", "munsell:5R 5/40 is outside the renotation data; lower its chroma"),
        ("10RP 5/26", "outside the gamut of reflectances"),
        ("5R 11/2", "outside the renotation data"),
        ("N 12", "values lie between 0 and 10"),
    ],
)
def test_chips_that_there_cannot_be(notation, message):
    with pytest.raises(InputError, match=message):
        munsell(notation)


def test_the_shipped_set_is_what_recovery_gives():
    shipped = shipped_set()
    assert len(shipped) > 1200
    assert len(set(shipped.names)) == len(shipped)
    assert 0.0 <= shipped.values.min() <= shipped.values.max() <= 1.0
    for name in ("N5", "5R 5/10", "7.5GY 8/6", shipped.names[-1]):
        np.testing.assert_allclose(shipped[name].values, recover(name).values, atol=1e-5)


def test_measured_chips_come_first(tmp_path, monkeypatch):
    path = tmp_path / "chips.npz"
    np.savez(path, R=[[0.1, 0.2]], wavelength=[380.0, 780.0], label=["5R 5/10"])
    assert munsell("5r 5/10").values[0] != 0.1
    monkeypatch.setenv(chips.VARIABLE, str(path))
    assert munsell_set().names == ("5R 5/10",)
    np.testing.assert_array_equal(munsell("5r 5/10").values, [0.1, 0.2])
    with pytest.warns(SceneWarning, match="5R 4/10 is not a measured chip; .* recovered"):
        assert munsell("5R 4/10") == shipped_set()["5R 4/10"]


@pytest.mark.skipif(not MEASURED.is_file(), reason="the measured Munsell chips are not here")
def test_recovered_chips_are_near_measured_ones():
    """The renotation's chips are lighter than the measured ones; their shapes agree."""
    measured = munsell_set(str(MEASURED))
    wavelengths = np.arange(400.0, 701.0, 5.0)
    truth = measured.at(wavelengths)[::10]
    ours = np.array([munsell(name, "")(wavelengths) for name in measured.names[::10]])
    assert np.sqrt(np.mean((ours - truth) ** 2)) < 0.055
    scale = (ours * truth).sum(axis=1) / (ours**2).sum(axis=1)
    assert np.sqrt(np.mean((ours * scale[:, None] - truth) ** 2)) < 0.022
