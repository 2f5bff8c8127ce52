"""Damage scene files at random, render them by the command line, and print what went wrong.

Run by `test_damaged_files`, with little memory: `damage.py FOLDER SEED COUNT KIND...`.
"""

import contextlib
import io
import json
import resource
import signal
import sys
import warnings
from pathlib import Path

import numpy as np
import trimesh
from mitsuba_files import serialized
from opens import opening_only_in

from photonmap.commands import main as cli

MEMORY = 6 << 30
"""Bytes of addresses; kernels, Embree and OpenImageIO reserve most of them."""
SECONDS = 60
"""Of processors' time for one file; the first one compiles kernels."""
TOKENS = [
    b"1e999", b"-1", b"nan", b"inf", b"99999999999999999999", b"0", b"1e-320", b"-0.0", b"1e300",
    b"\x00", b"\xff\xfe", b"\n", b" ", b"\\\n", b'"', b"[", b"]", b"=", b"{", b"}", b"../",
    b"/dev/zero",
    b"4294967295", b"1" * 400, b"\xff\xff\xff\x7f", b"#", b"newmtl", b"usemtl", b"map_Kd", b"Kd",
]  # fmt: skip
WORDS = [
    bytes.fromhex(word)
    for word in ("0000807f", "0000c07f", "ffff7f7f", "ffffffff", "ffffff7f", "00000000", "01000000")
]
"""Little-endian: infinity, no number, the largest float32, -1, the largest int32, 0, 1."""
DIGITS = b"0123456789012345678901234567890123456789 .-+e/[],xyz"
OBJ = """mtllib scene.mtl
o quad
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
vt 0 0
vn 0 0 1
usemtl red
f 1/1/1 2/1/1 3/1/1 4/1/1
usemtl lamp
f -1 -2 -3
"""
MTL = """newmtl red
Kd 0.8 0.1 0.1
illum 2
Ks 0.1 0.1 0.1
newmtl lamp
Ke 3 3 3
Kd spectral 0.5
Ni 1.5
d 1
"""
TOML = """mesh = "scene.obj"
[camera]
origin = [0, 0, 4]
target = [0, 0, 0]
fov = 40
[material.red]
reflectance = "munsell:5R 5/10"
[[light]]
type = "spot"
position = [0, 0, 3]
target = [0, 0, 0]
intensity = "planck:3200 2"
"""
XML = """<scene version="3.0.0">
<default name="r" value="2"/>
<sensor type="perspective"><float name="fov" value="40"/><string name="fov_axis" value="y"/>
<transform name="to_world">
<rotate y="1" angle="20"/><lookat origin="0 0 4" target="0 0 0" up="0 1 0"/></transform></sensor>
<bsdf type="twosided" id="red"><bsdf type="diffuse"><rgb name="reflectance" value=".8 .1 .1"/>
</bsdf></bsdf>
<shape type="obj"><string name="filename" value="scene.obj"/><ref id="red"/>
<transform name="to_world"><matrix value="1 0 0 0  0 2 0 0  0 0 1 0  0 0 0 1"/></transform></shape>
<shape type="rectangle"><emitter type="area"><spectrum name="radiance" value="400:1, 700:3"/>
</emitter><transform name="to_world"><scale value="$r"/><translate z="-1"/></transform></shape>
<emitter type="point"><float name="intensity" value="3"/>
<point name="position" x="0" y="0" z="3"/></emitter>
</scene>
"""
SERIALIZED = """<scene version="3.0.0"><shape type="serialized">
<string name="filename" value="body.serialized"/></shape></scene>
"""


def write_whole(folder, kind):
    """Write sound files; return the one to damage and the one to render."""
    (folder / "scene.obj").write_text(OBJ)
    (folder / "scene.mtl").write_text(MTL)
    if kind in ("obj", "mtl"):
        return folder / f"scene.{kind}", folder / "scene.obj"
    if kind == "toml":
        (folder / "scene.toml").write_text(TOML)
        return folder / "scene.toml", folder / "scene.toml"
    if kind == "xml":
        (folder / "scene.xml").write_text(XML)
        return folder / "scene.xml", folder / "scene.xml"
    if kind == "serialized":
        (folder / "scene.xml").write_text(SERIALIZED)
        (folder / "body.serialized").write_bytes(serialized([(trimesh.creation.box(), None)]))
        return folder / "body.serialized", folder / "scene.xml"
    file = folder / f"body.{kind.removeprefix('ascii ')}"
    body = trimesh.creation.box((1, 1, 1))
    options = {"file_type": "stl_ascii"} if kind == "ascii stl" else {}
    options |= {"encoding": "ascii"} if kind == "ascii ply" else {}
    body.export(file, **options)
    return file, file


def damage(whole, rng):
    """Return bytes with one to three changes, most of which leave all else in its place."""
    data = bytearray(whole)
    for _ in range(rng.integers(1, 4)):
        place, length = int(rng.integers(len(data) + 1)), int(rng.integers(1, 9))
        match rng.integers(8):
            case 0 | 1 | 2:
                plain = data[place : place + 1].isascii() and rng.random() < 0.9
                choice = DIGITS if plain else bytes(range(256))
                data[place : place + 1] = rng.choice(list(choice), 1).astype(np.uint8).tobytes()
            case 3:
                place -= place % 4
                value = WORDS[rng.integers(len(WORDS))][: len(data) - place]
                data[place : place + len(value)] = value
            case 4:
                del data[place : place + length]
            case 5:
                data[place:place] = data[place : place + 8 * length]
            case 6:
                data[place : place + length % 4] = TOKENS[rng.integers(len(TOKENS))]
            case 7 if rng.random() < 0.1:
                del data[place:]
    return bytes(data)


def judge(code, messages, before, after):
    """Return what is wrong with the outcome of a run, or None."""
    lines = [line for line in messages.splitlines() if "warning: " not in line]
    if code == 0:
        return "prints errors, but ends well" if lines else None
    if code != 2:
        return f"ends with {code}"
    if len(lines) != 1 or not lines[0].startswith("photonmap: error: "):
        return "tells no error in one line"
    if len(lines[0]) > 600:
        return "tells an error of many words"
    if "GB of memory" in messages or "memory than is free" in messages:
        return "asks for far too much memory"
    return "writes files" if before != after else None


def render(scene, output):
    """Run the command line; return its exit code and what it printed."""
    messages = io.StringIO()
    arguments = [str(scene), "--size", "4x4", "--passes", "1", "--photons", "20", "--threads", "1",
                 "--quiet", "--output", str(output)]  # fmt: skip
    with contextlib.redirect_stderr(messages), contextlib.redirect_stdout(messages):
        return cli.main(arguments), messages.getvalue()


def stop(number, frame):
    raise SystemExit(f"took more than {SECONDS} s of processors' time")


def main(folder, seed, count, *kinds):
    """Print a JSON list of findings: kind and number, what is wrong, what was printed, the file."""
    warnings.simplefilter("default")
    signal.signal(signal.SIGPROF, stop)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    findings = []
    for kind in kinds:
        place = Path(folder) / kind
        place.mkdir()
        findings += damaged_files(place, kind, np.random.default_rng(int(seed)), int(count))
    print(json.dumps(findings))


def damaged_files(folder, kind, rng, count):
    """Damage a file so many times; return what was found."""
    findings = []
    target, scene = write_whole(folder, kind)
    whole = target.read_bytes()
    for number in range(count):
        data = damage(whole, rng)
        target.write_bytes(data)
        before = sorted(folder.iterdir())
        messages = ""
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        try:
            with opening_only_in(folder):
                code, messages = render(scene, folder / "out.exr")
            wrong = judge(code, messages, before, sorted(folder.iterdir()))
        except BaseException as error:  # a finding, whatever it is
            wrong = f"raises {type(error).__name__}: {error}"
        signal.setitimer(signal.ITIMER_PROF, 0)
        if wrong:
            findings.append(
                [f"{kind} {number}", wrong, messages[-300:], data.decode("latin-1")[:2000]]
            )
        for suffix in ("exr", "png", "json"):
            (folder / f"out.{suffix}").unlink(missing_ok=True)
    return findings


if __name__ == "__main__":
    main(*sys.argv[1:])
