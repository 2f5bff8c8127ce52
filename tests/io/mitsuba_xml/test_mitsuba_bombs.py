"""Hostile scenes of Mitsuba are read or refused in one line, in little memory."""

import tracemalloc
import warnings

import pytest

import photonmap as pm


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
