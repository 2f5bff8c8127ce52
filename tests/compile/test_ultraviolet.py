"""Warnings where fluorescence is excited by what bands do not see, or nobody defined."""

from dataclasses import replace

import numpy as np
import pytest

import photonmap as pm
from photonmap.compile.effects import called_for
from photonmap.compile.scene_arrays import compile_arrays, compile_scene
from photonmap.spectra.fluorophores import named

from helpers.scenes import quad  # isort: skip

PAPER = pm.Material(
    "paper",
    pm.Spectrum([300, 380, 440, 780], [0.1, 0.1, 0.8, 0.8]),
    fluorescence=named("quinine sulfate"),
)


def scene(material, light):
    square = quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
    return pm.Scene([pm.Mesh(square.vertices, square.faces, material, "sheet")], [light])


def test_bands_that_miss_the_excitation_are_said():
    lit = scene(PAPER, pm.DomeLight(pm.emission("D65")))
    with pytest.warns(pm.SceneWarning, match=r"'paper': \d+% of what excites .* 400 to 700 nm"):
        compile_arrays(lit, pm.Bands.gaussian(6))


def test_colours_that_are_not_defined_where_it_is_excited_are_said():
    bands = pm.Bands.parse("300:780:20")
    compile_arrays(scene(PAPER, pm.DomeLight(pm.emission("D65"))), bands)  # warnings are errors
    lamp = pm.emission("extrapolate:LED-B1")
    with pytest.warns(pm.SceneWarning, match=r"from 3\d\d to 3\d\d nm, .* 'light bulb'; give"):
        compile_arrays(scene(PAPER, pm.DomeLight(lamp, name="bulb")), bands)
    rgb = replace(PAPER, reflectance=(0.1, 0.1, 0.2))
    with pytest.warns(pm.SceneWarning, match="'reflectance of paper'"):
        compile_arrays(scene(rgb, pm.DomeLight(pm.emission("D65"))), bands)


def test_scenes_without_fluorescence_have_no_such_warnings():
    plain = replace(PAPER, fluorescence=None, reflectance=(0.1, 0.1, 0.2))
    compile_arrays(scene(plain, pm.DomeLight()), pm.Bands.parse("300:780:20"))
    assert np.isfinite(compile_arrays(scene(plain, pm.DomeLight()), pm.Bands.rgb()).power)


def test_lines_that_bands_do_not_resolve_are_said():
    paper = replace(PAPER, fluorescence=named("optical brightener"), fluorescence_concentration=0.2)
    lit = scene(paper, pm.DomeLight(pm.emission("led:370,5"), name="lamp"))
    with pytest.warns(pm.SceneWarning, match=r"resolve 1 of .* 'light lamp' on .*'paper', by 31%"):
        compile_arrays(lit, pm.Bands.parse("300:780:20"))
    compile_arrays(lit, pm.Bands.parse("300:780:5"))  # warnings are errors


def test_the_plan_says_that_no_band_excites():
    taken, sent = (pm.Spectrum([low, low + 50.0], [0.9, 0.9]) for low in (310.0, 500.0))
    sheet = replace(PAPER, reflectance=0.05, fluorescence=pm.Fluorescence(taken, sent))
    lit = scene(sheet, pm.DomeLight(pm.emission("black light")))
    with pytest.warns(
        pm.SceneWarning, match=r"100% .* \(310 to 360 nm\) lies beyond .* 300:780:20"
    ):
        why = called_for(compile_scene(lit, pm.Bands.gaussian(6)), 6, 6)["fluorescence"].why
    assert why == "no band excites it, or none sees what it sends out"
