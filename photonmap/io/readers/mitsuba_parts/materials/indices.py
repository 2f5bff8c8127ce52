"""Indices of refraction: of glasses and liquids by name, and of metals."""

from __future__ import annotations

from functools import partial

from photonmap.errors import naming
from photonmap.io.readers.mitsuba_parts.colors import combined
from photonmap.io.readers.mitsuba_parts.context import Context
from photonmap.io.readers.mitsuba_parts.nodes import Node
from photonmap.io.readers.mitsuba_parts.textures import read_plain
from photonmap.runtime.wording import shown, suggest
from photonmap.spectra.curves import Color
from photonmap.spectra.metals import EDGE_COSINE, conductor_reflectance, metal

_NAMED = {
    "vacuum": 1.0,
    "helium": 1.000036,
    "hydrogen": 1.000132,
    "air": 1.000277,
    "carbon dioxide": 1.00045,
    "water": 1.333,
    "acetone": 1.36,
    "ethanol": 1.361,
    "carbon tetrachloride": 1.461,
    "glycerol": 1.4729,
    "benzene": 1.501,
    "silicone oil": 1.52045,
    "bromine": 1.661,
    "water ice": 1.31,
    "fused quartz": 1.458,
    "pyrex": 1.47,
    "acrylic glass": 1.49,
    "polypropylene": 1.49,
    "bk7": 1.5046,
    "sodium chloride": 1.544,
    "amber": 1.55,
    "pet": 1.575,
    "diamond": 2.419,
}
"""Indices of refraction that Mitsuba knows by name"""
_PERFECT = "none"


def index_of(node: Node, name: str, default: str) -> float:
    """Return an index of refraction, given as a number or by name.

    Raises
    ------
    InputError : the name is not known, or the number is not above 0
    """
    found = node.find(name)
    if found is None:
        return _NAMED[default]
    if found.tag != "string":
        value = node.number(name, 1.0)
        if value <= 0.0:
            raise found.error(f"{name} {value:g} is not above 0; correct it")
        return value
    wanted = node.text(name).lower()
    if wanted not in _NAMED:
        raise found.error(f"{name} {shown(wanted)} is not known; {suggest(wanted, _NAMED)}")
    return _NAMED[wanted]


def metal_reflectances(context: Context, node: Node) -> tuple[Color, Color]:
    """Return what a metal reflects at normal incidence, and at 82°: 1 if none is named.

    Raises
    ------
    InputError : its name is not known, or an index is negative
    """
    if node.find("eta") or node.find("k"):
        eta = read_plain(context, node, "eta", 0.0, "index")
        k = read_plain(context, node, "k", 1.0, "index")
        normal, edge = (
            combined(partial(conductor_reflectance, cosine=cosine), eta, k)
            for cosine in (1.0, EDGE_COSINE)
        )
        return normal, edge
    name = node.text("material", _PERFECT)
    if name.lower() == _PERFECT:
        return 1.0, 1.0
    element = node.element
    with naming(f"material {shown(name)}", element.path, element.line):
        found = metal(name)
    assert found.edge is not None
    return found, found.edge
