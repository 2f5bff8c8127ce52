"""Files that are wrong in what they say, not in their bytes: read, or refused in one line.

A sound file of each reader is taken apart into its tree, its lines or its tokens; some of these are
left out, repeated, exchanged, or replaced by odd ones; then it is put together again.
`make fuzz-gltf` and so on do that COUNT times.
"""

import copy
import json
import os
import re
import resource
import signal
import tempfile
import tomllib
import warnings
import zlib
from xml.etree import ElementTree
from xml.sax.saxutils import escape, quoteattr

import hostile
import numpy as np
import pytest
from helpers.marks import slow
from helpers.opens import opening_only_in

import photonmap as pm

EXAMPLES = os.environ.get("PHOTONMAP_EXAMPLES")
COUNTS = [10 * int(EXAMPLES)] if EXAMPLES else [30, *slow(600)]
SEED = int(os.environ.get("PHOTONMAP_SEED", "0"))
SECONDS = 10
"""Of processors' time for one file"""
MEMORY = 256 << 20
"""Bytes for one file, as small as these are"""
ODD = [-1, 0, 1, 3, 255, 65536, 2**31, 2**40, 10**19, 1e-40, 1e38, 1e300, 0.5, None, True, "", "a"]
ODD += ["\x1b[2J", "../a.obj", "../a.png", "\ud800", [], {}, [[]], [1e9] * 3, {"a": 0}]
WORDS = [
    "-1",
    "0",
    "1e999",
    "nan",
    "4294967296",
    "1" * 50,
    "",
    "-0.0",
    "a",
    "[",
    "]",
    "{",
    '"',
    "#",
    "../a.obj",
    "../a.mtl",
    "../a.png",
]
XML = """<scene version="3.0.0"><default name="r" value="2"/>
<bsdf type="twosided" id="red"><bsdf type="diffuse"><rgb name="reflectance" value=".8 .1 .1"/>
</bsdf></bsdf><shape type="shapegroup" id="group"><shape type="cube"><ref id="red"/></shape></shape>
<shape type="instance"><ref id="group"/><transform name="to_world"><scale value="$r"/></transform>
</shape><shape type="sphere"><float name="radius" value="0.5"/><ref id="red"/></shape>
<emitter type="point"><float name="intensity" value="3"/></emitter></scene>
"""
TOML = """mesh = "a.obj"
[camera]
origin = [0, 0, 4]
target = [0, 0, 0]
[material.red]
reflectance = "munsell:5R 5/10"
roughness = 0.5
[[light]]
type = "spot"
position = [0, 0, 3]
target = [0, 0, 0]
intensity = 2.0
"""
MTL = "newmtl red\nKd 0.8 0.1 0.1\nillum 2\nKs 0.1 0.1 0.1\nNs 10\nd 1\nmap_Kd -s 1 1 1 a.png\n"
OBJ = (
    "mtllib a.mtl\no a\ns 1\n"
    + hostile.SQUARE
    + "vt 0 0\nvn 0 0 1\nusemtl red\nf 1/1/1 2/1/1 3//1\nf -1 -2 -3\n"
)
USD = """#usda 1.0
( defaultPrim = "a"
 metersPerUnit = 0.01
 upAxis = "Z" )
def Xform "a" {
 double3 xformOp:translate = (0, 0, 1)
 uniform token[] xformOpOrder = ["xformOp:translate"]
 def Mesh "m" {
  point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
  int[] faceVertexCounts = [3]
  int[] faceVertexIndices = [0, 1, 2]
  rel material:binding = </a/red>
 }
 def Material "red" {
  token outputs:surface.connect = </a/red/shader.outputs:surface>
  def Shader "shader" {
   uniform token info:id = "UsdPreviewSurface"
   color3f inputs:diffuseColor = (1, 0, 0)
   token outputs:surface
  }
 }
 def SphereLight "l" {
  float inputs:radius = 0.5
 }
}
"""


def gltf():
    """A skinned, morphed triangle with a texture, a camera and a light, shown three times."""
    described = json.loads(hostile.nodes(3)["a.gltf"])
    described["nodes"][0] |= {"matrix": [1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}
    described["nodes"][1] |= {"rotation": [0, 0, 0, 1], "children": [], "skin": 0}
    described["nodes"][2] |= {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}
    described["skins"] = [{"joints": [0, 2]}]
    described["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]
    light = {"type": "spot", "intensity": 1.0, "spot": {"outerConeAngle": 0.5}}
    described["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
    color = {"baseColorFactor": [1, 1, 1, 1], "baseColorTexture": {"index": 0}}
    described["materials"] = [{"name": "red", "pbrMetallicRoughness": color}]
    described["textures"] = [{"source": 0, "sampler": 0}]
    described["samplers"] = [{"wrapS": 10497}]
    described["images"] = [{"uri": hostile.data_uri(hostile.png(1, 1, PIXEL))}]
    accessor = described["accessors"][0]
    accessor["sparse"] = {
        "count": 1, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 0}
    }  # fmt: skip
    (primitive,) = described["meshes"][0]["primitives"]
    primitive |= {"material": 0, "mode": 4, "targets": [{"POSITION": 0}]}
    primitive["attributes"] |= {"NORMAL": 0}
    described["meshes"][0]["weights"] = [0.5]
    return described


PIXEL = zlib.compress(b"\0\x80\x80\x80")


def places(tree, found):
    """Enter every place of a tree: a list or an object, and a key in it."""
    for key in range(len(tree)) if isinstance(tree, list) else tree:
        found.append((tree, key))
        if isinstance(tree[key], list | dict):
            places(tree[key], found)
    return found


def in_tree(make, write):
    """Return a function that changes a tree that is made, and writes it as text."""

    def changed(rng):
        described = make()
        for _ in range(rng.integers(1, 4)):
            found = places(described, [])
            (tree, key), (other, at) = (found[rng.integers(len(found))] for _ in range(2))
            match rng.integers(5):
                case 0:
                    del tree[key]
                case 1:
                    tree[key] = json.loads(json.dumps(other[at]))
                case 2 if isinstance(tree, list):
                    tree.insert(key, json.loads(json.dumps(tree[key])))
                case _:
                    tree[key] = copy.deepcopy(ODD[rng.integers(len(ODD))])
        return write(described)

    return changed


def elements(element):
    """Return an element of XML as a tree: tag, attributes, children."""
    return [element.tag, dict(element.attrib), [elements(child) for child in element]]


def as_xml(tree):
    """Return a tree as XML; what is no element becomes an attribute or text."""
    match tree:
        case [str(tag), dict(attributes), list(children)] if tag:
            words = "".join(f" {k}={quoteattr(str(v))}" for k, v in attributes.items() if k)
            return f"<{tag}{words}>{''.join(map(as_xml, children))}</{tag}>"
    return escape(str(tree)).replace("\x1b", "").replace("\ud800", "")


def as_toml(value):
    """Return a value of a tree in TOML."""
    if isinstance(value, dict):
        pairs = (f"{json.dumps(key)} = {as_toml(each)}" for key, each in value.items())
        return f"{{ {', '.join(pairs)} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(as_toml, value))}]"
    return json.dumps(value).replace("null", "1979-05-27").replace("\\ud800", "")


def as_sections(tree):
    """Return a tree as a file in TOML."""
    return "".join(f"{key} = {as_toml(value)}\n" for key, value in tree.items())


def in_words(text, pattern):
    """Return a function that changes the lines of a text, and its tokens by a pattern."""

    def changed(rng):
        lines = [re.findall(pattern, line) for line in text.splitlines()]
        for _ in range(rng.integers(1, 4)):
            row, other = rng.integers(len(lines), size=2)
            line = lines[row]
            at, to = rng.integers(max(len(line), 1), size=2)
            match rng.integers(7):
                case 0:
                    del lines[row][at : at + 1]
                case 1:
                    lines[row], lines[other] = lines[other], lines[row]
                case 2:
                    lines.insert(other, list(line) * int(rng.integers(1, 4)))
                case 3 if len(lines) > 1:
                    del lines[row]
                case 4 if line:
                    line[at], line[to] = line[to], line[at]
                case 5 if line and lines[other]:
                    line[at] = lines[other][rng.integers(len(lines[other]))]
                case _ if line:
                    line[at] = WORDS[rng.integers(len(WORDS))]
            lines = lines or [[""]]
        return "\n".join(map("".join, lines)) + "\n"

    return changed


SPACED = r"\s+|\S+"
READERS = {
    "gltf": ("a.gltf", in_tree(gltf, json.dumps)),
    "obj": ("a.obj", in_words(OBJ, SPACED)),
    "mtl": ("a.mtl", in_words(MTL, SPACED)),
    "toml": ("a.toml", in_tree(lambda: tomllib.loads(TOML), as_sections)),
    "xml": ("a.xml", in_tree(lambda: elements(ElementTree.fromstring(XML)), as_xml)),
    "usd": ("a.usda", in_words(USD, r"\s+|\w+|.")),
    "ply": ("a.ply", in_words(hostile.ply("ascii", 1)["a.ply"].decode(), SPACED)),
    "off": ("a.off", in_words(hostile.GROWING["OFF: faces"](2)["a.off"], SPACED)),
    "stl": ("a.stl", in_words("solid a\n" + hostile.FACET * 2 + "endsolid a\n", SPACED)),
}


def stop(*_):
    raise TimeoutError(f"took more than {SECONDS} s of processors' time")


def load(path):
    """Load a scene; return whether it could be read, and all that was said."""
    with warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always")
        try:
            scene = pm.load_scene(path)
        except pm.InputError as error:
            return False, [str(error)]
    said = [str(each.message) for each in issued]
    return all(np.isfinite(mesh.vertices).all() for mesh in scene.meshes), said


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("reader", READERS)
def test_what_files_say_is_read_or_refused_in_one_line(reader, count, tmp_path, monkeypatch):
    name, change = READERS[reader]
    if reader == "usd":
        pytest.importorskip("pxr")
    sound = {"a.mtl": MTL, "a.png": hostile.png(1, 1, PIXEL), "a.obj": OBJ}
    hostile.write(tmp_path, sound)  # to be found by ../
    scene, temporary = tmp_path / "scene", tmp_path / "temporary"
    scene.mkdir()
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    signal.signal(signal.SIGPROF, stop)
    rng, read = np.random.default_rng([SEED, len(reader)]), 0
    hostile.write(scene, {**sound, name: ""})
    load(scene / name)  # what is imported and made once
    least = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for number in range(count):
        text = change(rng)
        hostile.write(scene, {**sound, name: text})
        try:
            signal.setitimer(signal.ITIMER_PROF, SECONDS)
            with opening_only_in(scene):
                found, said = load(scene / ("a.obj" if reader == "mtl" else name))
            signal.setitimer(signal.ITIMER_PROF, 0)
            read += found
            assert not [each for each in hostile.HIDDEN for text in said if each in text]
            assert max(map(len, said), default=0) < (10_000 if found else 1000)
            assert not any("GB of memory" in text for text in said)
            assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - least < MEMORY >> 10
        except Exception as error:
            raise AssertionError(f"{reader} {number}: {text}") from error
    assert read or count < 100
