"""Damaged and hostile scenes of Mitsuba are read or refused in one line, in little memory."""

import random
import tracemalloc
import warnings

import numpy as np
import pytest

import photonmap as pm

SCENE = b"""<?xml version="1.0"?>
<scene version="3.0.0">
  <default name="spp" value="16"/>
  <!-- a room -->
  <sensor type="perspective" id="view">
    <float name="fov" value="45.5"/>
    <transform name="to_world"><lookat origin="0, 1, 5" target="0, 1, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="64"/></film>
  </sensor>
  <bsdf type="twosided" id="wall"><bsdf type="diffuse">
    <rgb name="reflectance" value="0.2, 0.25, 0.7"/>
  </bsdf></bsdf>
  <bsdf type="roughconductor" id="gold"><string name="material" value="Au"/>
    <float name="alpha" value="0.1"/></bsdf>
  <shape type="cube"><transform name="to_world"><scale x="2" y="1.5"/><rotate y="1" angle="30"/>
    </transform><ref id="wall"/></shape>
  <shape type="rectangle" id="lamp"><emitter type="area">
    <spectrum name="radiance" value="400:1, 700:2.5"/></emitter></shape>
  <shape type="disk"><point name="center" x="1" y="0" z="2"/><ref id="gold"/></shape>
  <emitter type="point"><point name="position" x="0" y="3" z="0"/></emitter>
</scene>
"""


def damaged(data, rng):
    """Change, drop, repeat or insert some bytes; half of the time digits alone."""
    data = bytearray(data)
    for _ in range(rng.randint(1, 3)):
        at = rng.randrange(40, len(data))
        match rng.randrange(6):
            case 0:
                data[at] = rng.randrange(256)
            case 1:
                del data[at : at + rng.randint(1, 12)]
            case 2:
                data[at:at] = data[at : at + rng.randint(1, 40)]
            case _:
                digits = [i for i, byte in enumerate(data) if i > 40 and chr(byte).isdigit()]
                data[rng.choice(digits)] = ord(rng.choice("0123456789-.e, $"))
    return bytes(data)


def read(path, data):
    path.write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pm.load_scene(path)


def refusal(path, data):
    """Return the line that refuses a scene, read within 20 MB."""
    tracemalloc.start()
    try:
        with pytest.raises(pm.InputError) as refused:
            read(path, data)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()
    assert "\n" not in str(refused.value)
    return str(refused.value)


def test_the_whole_scene_is_read(tmp_path):
    assert len(read(tmp_path / "a.xml", SCENE).meshes) == 3


@pytest.mark.parametrize("seed", range(4))
def test_damaged_scenes_are_read_or_refused_in_one_line(tmp_path, seed):
    rng, refused = random.Random(seed), []
    for _ in range(150):
        try:
            scene = read(tmp_path / "a.xml", damaged(SCENE, rng))
        except pm.InputError as error:
            refused.append(str(error))
        else:
            assert all(np.isfinite(mesh.vertices).all() for mesh in scene.meshes)
    assert all("a.xml" in line and "\n" not in line for line in refused)
    assert 0 < len(refused) < 150


def test_bombs_of_entities_are_refused(tmp_path):
    levels = "".join(f'<!ENTITY e{i + 1} "{f"&e{i};" * 10}">' for i in range(9))
    doctype = f'<!DOCTYPE bomb [<!ENTITY e0 "boom">{levels}]>'
    text = f'<?xml version="1.0"?>{doctype}<scene version="3.0.0"><string value="&e9;"/></scene>'
    assert "<!DOCTYPE> is not read" in refusal(tmp_path / "bomb.xml", text.encode())


def test_external_entities_are_refused(tmp_path):
    (tmp_path / "secret.txt").write_text("<shape/>")
    doctype = '<!DOCTYPE scene [<!ENTITY x SYSTEM "secret.txt">]>'
    text = f'<?xml version="1.0"?>{doctype}<scene version="3.0.0">&x;</scene>'
    assert "<!DOCTYPE> is not read" in refusal(tmp_path / "scene.xml", text.encode())


def test_parameters_that_multiply_are_refused(tmp_path):
    steps = '<default name="a" value="boomboom"/>'
    for name, before in zip("bcdefghij", "abcdefghi", strict=True):
        steps += f'<default name="{name}" value="{f"${before} " * 10}"/>'
    text = f'<scene version="3.0.0">{steps}</scene>'
    assert "longer than 4096 letters" in refusal(tmp_path / "bomb.xml", text.encode())


def test_references_that_multiply_are_read_once(tmp_path):
    """Each blend holds the one before twice: 2⁶⁰ surfaces in 8 kB."""
    blends = '<bsdf type="diffuse" id="b0"/>'
    for level in range(60):
        blends += f'<bsdf type="blendbsdf" id="b{level + 1}"><float name="weight" value="0.5"/>'
        blends += f'<ref id="b{level}"/><ref id="b{level}"/></bsdf>'
    text = f'<scene version="3.0.0">{blends}<shape type="cube"><ref id="b60"/></shape></scene>'
    (mesh,) = read(tmp_path / "bomb.xml", text.encode()).meshes
    assert mesh.material.reflectance == 0.5


def test_instances_that_multiply_are_refused(tmp_path):
    """Each group holds ten instances of the one before: 10⁹ cubes in 5 kB."""
    groups = '<shape type="shapegroup" id="g0"><shape type="cube"/></shape>'
    for level in range(9):
        inside = f'<shape type="instance"><ref id="g{level}"/></shape>' * 10
        groups += f'<shape type="shapegroup" id="g{level + 1}">{inside}</shape>'
    text = f'<scene version="3.0.0">{groups}<shape type="instance"><ref id="g9"/></shape></scene>'
    assert "instance" in refusal(tmp_path / "bomb.xml", text.encode())
