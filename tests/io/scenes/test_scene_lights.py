"""Lights in scene files."""

import numpy as np
import OpenImageIO
import pytest

from photonmap.errors import InputError
from photonmap.scene.lights import DirectionalLight, DomeLight, PointLight, SpotLight
from photonmap.spectra.names import light as named_light

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
CAMERA = "[camera]\norigin = [0, 1, 5]\ntarget = [0.5, 0, 0]\n"

LIGHTS = """
[[light]]
type = "point"          # type = "spot"
position = [0, 1, 2]
intensity = "D65 3"
group = "warm"
[[light]]
type = "spot"
position = [0, 1, 2]
target = [0, 0, 0]
intensity = [1, 2, 3]
inner = 10
outer = 12.5
name = "stage"
[[light]]
type = "directional"
direction = [0, -1, 0]
irradiance = 4
"""


@pytest.fixture
def lit(load, tmp_path):
    def lit(toml):
        file = OpenImageIO.ImageOutput.create("exr")
        for name, value in (("sky", 2.0), ("dark", -2.0)):
            path = str(tmp_path / f"{name}.exr")
            assert file.open(path, OpenImageIO.ImageSpec(8, 4, 3, "float"))
            assert file.write_image(np.full((4, 8, 3), value, np.float32))
            file.close()
        return load(toml).lights

    return lit


def test_a_toml_adds_lights(lit):
    point, spot, sun = lit(LIGHTS)
    assert point == PointLight((0, 1, 2), 3 * named_light("D65"), group="warm")
    assert spot == SpotLight((0, 1, 2), (0, 0, 0), (1, 2, 3), 10, 12.5, "stage")
    assert sun == DirectionalLight((0, -1, 0), 4.0)


def test_a_toml_adds_a_sky(lit):
    assert lit('light = [{type = "dome", radiance = 2, name = "sky"}]') == [DomeLight(2.0, "sky")]
    file = '[[light]]\ntype = "environment"\nfile = "sky.exr"\nscale = 0.5\nrotation = 90\n'
    (sky,) = lit(file)
    np.testing.assert_array_equal(sky.image, np.full((4, 8, 3), 2.0))
    assert (sky.scale, sky.rotation, sky.name, sky.color) == (0.5, 90.0, "", (1.0, 1.0, 1.0))


SKY = '[[light]]\ntype = "environment"\nfile = '


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        (LIGHTS.replace('"directional"', '"directed"'), r":16: .*type 'directed' .*'directional'"),
        (LIGHTS.replace('"directional"', "3"), r":16: \[\[light\]\] type 3 is not known"),
        (LIGHTS.replace('type = "directional"\n', ""), r":15: .* lacks type; add one of \"point\""),
        (LIGHTS.replace("inner", "iner"), r":12: spot light key 'iner' .*did you mean 'inner'\?"),
        (LIGHTS.replace("irradiance", "radiance"), r":18: directional light key 'radiance' "),
        (LIGHTS.replace("target = [0, 0, 0]\n", ""), r":7: the spot light lacks target; add targ"),
        (LIGHTS.replace("[0, -1, 0]", "[0, 0, 0]"), r":17: .*\]\] direction: .* no length"),
        (LIGHTS.replace("[0, -1, 0]", "[0, nan, 0]"), r":17: .*direction: .* is not a direction"),
        (LIGHTS.replace("[0, -1, 0]", "true"), r":17: .*direction: True is not a direction"),
        (
            LIGHTS.replace("target = [0, 0, 0]", "target = [0, 1, 2]"),
            r":10: .*'stage': target .*mo",
        ),
        (
            LIGHTS.replace("inner = 10", "inner = 20"),
            r":12: .*inner 20.0 exceeds the outer half-angle, 12.5",
        ),
        (LIGHTS.replace("12.5", "inf"), r":13: \[\[light\]\] outer: inf is not a half-angle"),
        (
            LIGHTS.replace("12.5", '"wide"'),
            r":13: .* outer: 'wide' is not a half-angle; give degrees from 0.001 to below 180",
        ),
        (
            LIGHTS.replace("irradiance = 4", "irradiance = -4"),
            r":18: .*irradiance: '-4' is not a li",
        ),
        (LIGHTS.replace("D65 3", "D56 3"), r":5: \[\[light\]\] intensity: .*'D56 3'"),
        (LIGHTS.replace('"stage"', "3"), r":14: .*name: 3 is not a text"),
        (LIGHTS + 'name = "stage"\n', r":19: two lights are named 'stage'; give each its own name"),
        ("[light]\n", r":1: light is not a section; write \[\[light\]\] above"),
        ("\nlight = 3\n", r":2: light is not a section"),
        ('\nlight = [{type = "dom"}]\n', r":2: .*type 'dom' is not known; did you mean 'dome'\?"),
        (SKY + '"none.exr"\n', r":3: \[\[light\]\] file: .*none\.exr: cannot be read \(no such"),
        (SKY + '"dark.exr"\n', r":3: .*dark\.exr: pixel \(row 0, column 0\) is -2"),
        (SKY + "3\n", r":3: .*3 is not a file name; write file = "),
        (SKY + '"sky.exr"\nscale = -1\n', r":4: .*scale: -1 is not a factor; give a number from 0"),
        (
            SKY + '"sky.exr"\nrotation = nan\n',
            r":4: .*rotation: nan is not an angle; give a finite number of degrees",
        ),
        ('[[light]]\ntype = "environment"\n', r':1: .* lacks file; add file = "FILE.exr"'),
    ],
)
def test_errors_in_lights_name_their_line(lit, toml, message):
    with pytest.raises(InputError, match=r"room\.toml" + message):
        lit(toml)
