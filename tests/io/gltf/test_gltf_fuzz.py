"""Damaged GLB files: read, or refused in one line."""

import random
import warnings

import numpy as np
import pytest
from helpers.meshes import TRIANGLE

from photonmap.errors import InputError


def damaged(data, rng):
    """Change, drop, repeat or insert some bytes; half of the time digits alone, which stay JSON."""
    data = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(12, len(data))
        match rng.randrange(5):
            case 0:
                data[at] = rng.randrange(256)
            case 1:
                del data[at : at + rng.randint(1, 8)]
            case 2:
                data[at:at] = data[at : at + rng.randint(1, 8)]
            case _:
                digits = [i for i, byte in enumerate(data) if chr(byte).isdigit()]
                data[rng.choice(digits)] = ord(rng.choice("0123456789-.e"))
    return bytes(data)


@pytest.mark.parametrize("seed", range(4))
def test_damaged_glb_files_are_read_or_refused_in_one_line(read, build, seed):
    build.primitive(
        NORMAL=np.tile([0.0, 0, 1], (3, 1)), TEXCOORD_0=TRIANGLE[:, :2], indices=[0, 1, 2]
    )
    build.tree["materials"] = [{"pbrMetallicRoughness": {"metallicFactor": 0.5}, "name": "a"}]
    build.tree["meshes"][0]["primitives"][0]["material"] = 0
    build.tree["nodes"] = [{"children": [1]}, {"mesh": 0, "translation": [1, 2, 3]}]
    whole, rng = build.glb(), random.Random(seed)
    refused = []
    for _ in range(150):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                meshes = read("a.glb", damaged(whole, rng))
        except InputError as error:
            refused.append(str(error))
        else:
            assert all(np.isfinite(mesh.vertices).all() for mesh in meshes)
    assert all("a.glb" in line and "\n" not in line for line in refused)
    assert 0 < len(refused) < 150
