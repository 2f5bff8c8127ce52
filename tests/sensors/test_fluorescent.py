"""What bands cost for chips with a dye: nothing for many, more where bands miss what excites."""

import numpy as np
import pytest
from helpers.scenes import quad

import photonmap as pm
from photonmap.commands.main import main
from photonmap.sensors.fluorescent import fluorescent_errors
from photonmap.spectra.fluorescence import reradiation_residual
from photonmap.spectra.fluorophores import named
from photonmap.spectra.munsell import munsell_set


def errors(text, dye):
    bands, light = pm.Bands.parse(text), pm.emission("D65")
    return [row.mean for row in fluorescent_errors(munsell_set(), light, bands, named(dye), 2)]


def test_more_bands_err_less_and_ultraviolet_is_needed_for_brighteners():
    dyed = [errors(text, "fluorescein") for text in ("3", "9", "400:700:10")]
    assert dyed[0][0] > dyed[1][0] > dyed[2][0]
    assert dyed[2][0] < 0.03
    missed, seen = (errors(t, "optical brightener") for t in ("400:700:20", "300:780:20"))
    assert missed[0] > 3.0 * seen[0]
    assert missed[1] > 3.0 * seen[1]


def test_renders_come_nearer_to_the_spectrum_as_their_bands_state():
    """Radiance by 6, 31 and 81 bands, against ∫ Φ E in steps of 1 nm."""
    nm, dye, lamp = np.arange(300.0, 801.0), named("fluorescein"), pm.emission("D65")
    sent = pm.Spectrum(nm, dye.matrix(nm, nm) @ lamp(nm) / np.pi)
    sheet = pm.Material("sheet", 0.05, fluorescence=dye)
    square = quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), sheet)
    scene = pm.Scene(
        [square], [pm.DirectionalLight((0, 0, -1), lamp)], pm.Camera((0, 0, 1), (0, 0, 0), fov=20)
    )
    found, stated = [], []
    for bands in (pm.Bands.gaussian(count, 380.0, 720.0) for count in (6, 31, 81)):
        truth = bands.average(sent)
        glow = pm.render(scene, bands=bands, size=2, passes=1, threads=1).fluorescence[0, 0]
        found.append(np.linalg.norm(glow - truth) / np.linalg.norm(truth))
        stated.append(reradiation_residual(dye, bands, lamp))
    assert found == pytest.approx(stated, abs=3e-5)
    assert found[0] > 5.0 * found[1] > 5.0 * found[2]


def test_chips_hold_their_outer_values_in_ultraviolet_bands_with_a_dye_alone(capsys):
    study = ["sensors", "--bands", "310:730:60", "--bounces", "1"]
    assert main(study) != 0
    assert "reflectances: the curve covers 380-730 nm, but 300-" in capsys.readouterr().err
    assert main([*study, "--fluorescence", "optical brightener"]) in (0, None)


def test_the_command_prints_them(capsys):
    main(["sensors", "--bands", "3", "--bounces", "2", "--fluorescence", "fluorescein"])
    assert "Error within the bands of chips with fluorescein" in capsys.readouterr().out
    assert main(["sensors", "--bands", "3", "--fluorescence", "fluorescine"]) != 0
    assert "did you mean 'fluorescein'?" in capsys.readouterr().err
