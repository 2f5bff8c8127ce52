"""Fluorescence in scene files: read from TOML, and written and read back by every writer."""

import json
from dataclasses import replace

import numpy as np
import pytest

import photonmap as pm
from photonmap.errors import InputError
from photonmap.spectra.fluorescence import as_fluorophores
from photonmap.spectra.fluorophores import NAMED, named

from helpers.scenes import quad  # isort: skip

GRID = np.arange(300.0, 701.0, 5.0)
DARK = pm.Spectrum([300, 420, 440, 780], [0.05, 0.05, 0.3, 0.3], extrapolate=True)
UV = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)


def fluorophores():
    dye = replace(named("coumarin 6"), excitation=named("coumarin 6").excitation * 0.4)
    values = np.where(GRID[:, None] > GRID + 20.0, 2e-4, 0.0)
    return dye, pm.DonaldsonMatrix(GRID, GRID, values)


def scene_of(material):
    square = quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
    mesh = pm.Mesh(square.vertices, square.faces, material, "sheet", uv=UV)
    return pm.Scene([mesh], [pm.DomeLight()])


@pytest.mark.parametrize("suffix", [".obj", ".glb", ".gltf"])
@pytest.mark.parametrize("several", [False, True])
def test_what_is_written_is_read_back(tmp_path, suffix, several):
    fluorescence = fluorophores() if several else fluorophores()[1]
    material = pm.Material("dye", DARK, fluorescence=fluorescence, fluorescence_concentration=0.5)
    pm.save_scene(scene_of(material), tmp_path / f"a{suffix}")
    (mesh,) = pm.load_scene(tmp_path / f"a{suffix}").meshes
    assert mesh.material.fluorescence == fluorescence
    assert mesh.material.fluorescence_concentration == 0.5
    if suffix == ".gltf":
        (item,) = json.loads((tmp_path / "a.gltf").read_text())["materials"]
        assert len(item["extras"]["photonmap"]["fluorescence"]) == 1 + several


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_a_textured_concentration_is_written_and_read_back(tmp_path, suffix):
    amount = pm.Texture.of(np.arange(16.0).reshape(4, 4) / 15.0)
    material = pm.Material("dye", DARK, fluorescence=fluorophores()[0])
    material = replace(material, fluorescence_concentration=amount)
    pm.save_scene(scene_of(material), tmp_path / f"a{suffix}")
    (mesh,) = pm.load_scene(tmp_path / f"a{suffix}").meshes
    found = mesh.material.fluorescence_concentration
    texels = found.image.linear(slice(None), slice(None))[..., 0] * found.factor[0]
    np.testing.assert_allclose(texels, amount.values[..., 0], atol=1e-5)


def write(tmp_path, *lines, reflectance="0.05"):
    pm.save_scene(scene_of(pm.Material("paper")), tmp_path / "a.obj")
    text = [f"[material.paper]\nreflectance = {reflectance}", *lines]
    (tmp_path / "a.toml").write_text("\n".join(text))
    return pm.load_scene(tmp_path / "a.obj").meshes[0].material


def test_toml_names_fluorophores_curves_and_matrices(tmp_path):
    (tmp_path / "in.csv").write_text("300,0.5\n400,0.5\n")
    (tmp_path / "out.csv").write_text("450,1\n500,1\n")
    fluorophores()[1].save(tmp_path / "m.npz")
    curves = '{ excitation = "in.csv 0.5", emission = "out.csv", quantum_efficiency = 0.6 }'
    line = f'fluorescence = ["fluorescein 0.2", {curves}, "m.npz"]'
    dye, own, matrix = as_fluorophores(write(tmp_path, line).fluorescence)
    assert dye.excitation == named("fluorescein").excitation * 0.2
    assert own == pm.Fluorescence(
        pm.Spectrum([300, 400], [0.25, 0.25]), pm.Spectrum([450, 500], [1, 1]), 0.6
    )
    assert matrix == fluorophores()[1]


@pytest.mark.parametrize(
    ("line", "reflectance", "message"),
    [
        ('fluorescence = "fluorescine"', "0", r"a.toml:3: .*did you mean 'fluorescein'\?"),
        (
            "fluorescence = { excitation = [[300, 400], [0.1, 0.1]], "
            "emission = [[450, 500], [1, 1]], quantum_efficiency = true }",
            "0",
            "quantum_efficiency is True; give photons",
        ),
        ("fluorescence = 3", "0", "3 is no fluorophore; give a name, a file or a table"),
        ("fluorescence = { glow = 1 }", "0", "key 'glow' is not known"),
        ('fluorescence = { matrix = "m.npz", emission = "x.csv" }', "0", "matrix has no emission"),
        ("fluorescence = { excitation = 1 }", "0", "excitation 1 is no curve; write excitation ="),
        ('fluorescence = "x.npz"', "0", "cannot be read"),
        ('fluorescence = "fluorescein 1.2"', "0", r"excitation is 1.0\d+ at 4\d\d nm"),
        ('fluorescence = "fluorescein"', "0.5", "a.toml:2: .* photon at 4.. nm they send out 0.9"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path, line, reflectance, message):
    with pytest.raises(InputError, match=message):
        write(tmp_path, line, reflectance=reflectance)


def test_glass_has_none(tmp_path):
    with pytest.raises(InputError, match="glass has none; leave out fluorescence or ior"):
        write(tmp_path, 'ior = 1.5\nfluorescence = "fluorescein"', reflectance="0")


@pytest.mark.parametrize("name", NAMED)
def test_named_fluorophores_have_their_published_peaks(name):
    dye, (taken, sent, efficiency) = named(name), NAMED[name]
    for curve, peak in ((dye.excitation, taken), (dye.emission, sent)):
        assert curve.wavelengths[curve.values.argmax()] == pytest.approx(peak, abs=0.6)
    assert dye.quantum_efficiency == efficiency
