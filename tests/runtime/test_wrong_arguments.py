"""What is wrong with an argument in code is said in one line, and what to give instead."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.settings import Options, Settings

CORNERS, FACES = np.eye(3), [[0, 1, 2]]
UV = CORNERS[:, :2]
LIT = pm.PointLight((0.0, 0.0, 3.0))
RESULT = pm.Result(
    {"radiance": np.ones((2, 3, 4), np.float32)}, {}, pm.Bands.gaussian(4), {"warnings": []}
)


def painted(paint, uv=UV):
    """Compile a triangle of a reflectance."""
    mesh = pm.Mesh(CORNERS, FACES, pm.Material("m", paint), "wall", uv=uv)
    return compile_scene(pm.Scene([mesh], [LIT]), pm.Bands.rgb())


def chosen(**options):
    return Settings.of(Options(**options))


def evaluate(methods, metrics=None):
    return pm.evaluate.evaluate_dataset("nowhere", methods, metrics)


WRONG = {
    "face": (
        lambda: pm.Mesh(CORNERS, [[0, 1, 2], [0, 1.5, 2]], name="wall"),
        r"mesh 'wall': faces: row 1 is \[0\.0, 1\.5, 2\.0\]; give whole numbers",
    ),
    "endless face": (lambda: pm.Mesh(CORNERS, [[0, 1, np.inf]]), "faces: row 0 is .* whole"),
    "vertices": (lambda: pm.Mesh("abc", FACES), "vertices: 'abc' is not an array of numbers"),
    "ragged": (lambda: pm.Mesh(CORNERS, [[0, 1], [0]]), "faces: .* is not an array of numbers"),
    "material": (
        lambda: pm.Mesh(CORNERS, FACES, "gold"),
        "mesh 'mesh': 'gold' is not a material; make one by photonmap.Material",
    ),
    "camera": (lambda: pm.camera_rays((4, 4), pm.Camera((0, 0, 1), (0, 0, 0))), "not a camera"),
    "size": (lambda: pm.camera_rays(pm.Camera((0, 0, 1), (0, 0, 0)), "4x4"), "size '4x4' is not"),
    "array": (lambda: pm.Texture(np.ones((4, 4, 3))), "use photonmap.Texture.of for an array"),
    "image file": (lambda: pm.Texture.of("wood.png"), "'wood.png' .* photonmap.Texture.read"),
    "words": (lambda: pm.Texture.of(["red"]), "is not an array of numbers"),
    "RGBA": (
        lambda: pm.Texture.of(np.ones((2, 2, 4))),
        r"must be \(H, W, 3\) or \(H, W, 1\), not \(2, 2, 4\); leave alpha out",
    ),
    "cubes": (lambda: pm.Texture.of(np.ones((2, 2, 2, 3, 3))), r"not \(2, 2, 2, 3, 3\)"),
    "no texels": (lambda: pm.Texture.of(np.ones((0, 4))), r"not \(0, 4, 1\)"),
    "16 bits": (lambda: pm.Texture.of(np.ones((2, 2), np.uint16)), "uint16; divide by 65535"),
    "scale": (lambda: pm.Texture.of(np.ones((2, 2)), scale=2), "scale is 2; give two numbers"),
    "offset": (lambda: pm.Texture.of(np.ones((2, 2)), offset=(0, np.nan)), "offset is .* give two"),
    "factor": (lambda: pm.Texture.of(np.ones((2, 2)), factor=0.5), "factor is 0.5; give three"),
    "NaN": (lambda: painted(pm.Texture.of([[np.nan]])), "'m': reflectance: .* not finite"),
    "flat NaN": (lambda: painted(pm.Texture.of([[np.nan]]), None), "reflectance: .* not finite"),
    "bytes": (lambda: painted(pm.Texture.of([[200]])), "reaches 200; .* of 8 bits by 255"),
    "words of 16": (lambda: painted(pm.Texture.of([[3e4]])), "reaches 30000; .* 16 bits by 65535"),
    "RGB": (lambda: painted((200, 10, 10)), "between 0 and 1; divide what is of 8 bits by 255"),
    "many": (lambda: painted(1.5), "it must lie between 0 and 1$"),
    "merging files": (lambda: pm.merge(["a.exr", "b.exr"]), "'a.exr' .* photonmap.load_result"),
    "merging two": (lambda: pm.merge(RESULT, RESULT), r"a list, as in merge\(\[one, other\]\)"),
    "exposing a file": (lambda: pm.expose("a.exr"), "'a.exr' .* photonmap.load_result"),
    "exposing an array": (lambda: pm.expose(RESULT.radiance), "give what photonmap.render returns"),
    "camera's name": (lambda: pm.expose(RESULT, "Nikon 5100 (NPL)"), r"give a photonmap\.Sensor"),
    "curves": (lambda: pm.Bands.sensors(np.ones((1, 5)), ["red"]), r"red: .*photonmap\.Spectrum"),
    "progress": (lambda: chosen(progress="yes"), "progress 'yes' .* give True, False, or an"),
    "watch": (lambda: chosen(watch=3), "watch 3 cannot be called; give a function"),
    "memory": (lambda: chosen(memory="4 gigs"), "'4 gigs' is not an amount of memory; write it"),
    "memories": (lambda: chosen(memory=[1]), r"memory \[1\] must be a number of bytes above 0"),
    "flag": (lambda: chosen(per_light="no"), "per_light 'no' is neither True nor False"),
    "effects": (lambda: chosen(effects=5), "5 is no list of names; give them as in"),
    "effect": (lambda: chosen(effects=[5]), "there is no effect 5; choose from "),
    "buffers": (lambda: chosen(buffers=5), "5 is no list of names; give them as in"),
    "buffer": (lambda: chosen(buffers=[5]), "there is no buffer 5; choose from 'radiance', "),
    "no bands": (lambda: chosen(bands=None), "or camera; got None$"),
    "a list of bands": (lambda: chosen(bands=[1, 2]), r"or camera; got \[1, 2\]$"),
    "true bands": (lambda: chosen(bands=True), "or camera; got True$"),
    "passes": (lambda: chosen(passes=10**30), "passes 10* must be a whole number up to 4294967295"),
    "seconds": (lambda: chosen(seconds=10**400), "seconds 10.* must be a positive and finite"),
    "endless memory": (lambda: chosen(memory=10**400), "memory 10.* must be a number of bytes"),
    "checkpoint": (lambda: chosen(checkpoint=5), "checkpoint 5 is not the name of a file"),
    "wavelength": (lambda: RESULT.sel("550"), "wavelength '550' is not a number; give one, in nm"),
    "wavelengths": (lambda: RESULT.sel([450, 550]), r"wavelength \[450, 550\] is not a number"),
    "method": (lambda: evaluate("grey-word"), "'grey-word'.* 'grey-world'"),
    "function": (lambda: evaluate(evaluate), r"give the function a name: Method\('evaluate', ev"),
    "metric": (lambda: evaluate("grey-world", "angl"), "no metric 'angl'; did you mean 'angle'"),
    "pixel": (lambda: RESULT.plot_spectrum(0.5, 0), r"no pixel \(0\.5, 0\) in an image of 3x2"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_arguments(case):
    call, message = WRONG[case]
    with pytest.raises(pm.InputError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_a_misspelt_keyword_of_render_is_suggested():
    with pytest.raises(TypeError, match=r"^render got an .* argument 'band'; did you mean 'bands'"):
        pm.render(pm.Scene(), band=3)


def test_names_may_be_a_text_as_on_the_command_line():
    assert chosen(buffers="radiance").buffers == {"radiance"}
    assert chosen(buffers="radiance, depth").buffers == {"radiance", "depth"}
    assert chosen(effects="direct, indirect").effects == {"direct", "indirect"}
    assert [*RESULT.select("radiance").buffers] == ["radiance"]


def test_memory_may_be_written_as_on_the_command_line():
    assert chosen(memory="4G").memory == 4 << 30


def test_whole_faces_may_be_floats():
    assert pm.Mesh(CORNERS, [[0.0, 1.0, 2.0]]).faces.dtype == np.int64
