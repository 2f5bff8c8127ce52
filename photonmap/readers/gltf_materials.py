"""Read the materials of glTF files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from photonmap.errors import InputError
from photonmap.messages import shown
from photonmap.readers.meshes import Losses, note
from photonmap.scene import Material
from photonmap.spectra.curves import LARGEST_REFLECTANCE, Color


def read_material(path: Path, index: int, item: dict[str, Any], losses: Losses) -> Material:
    """Read a material; its reflectance is the base colour where there is no texture.

    Parameters
    ----------
    path : the file, for messages
    index : of the material in the file; it names what has no name
    item : its JSON
    losses : takes what is not simulated
    """
    name = str(item.get("name") or f"material_{index}")
    surface = item.get("pbrMetallicRoughness")
    _note_material(losses, name, item, surface)
    if surface is None or "baseColorTexture" in surface:
        return Material(name)
    color = surface.get("baseColorFactor", [1, 1, 1, 1])[:3]
    if len(color) < 3 or not all(
        type(value) in (int, float) and 0 <= value <= LARGEST_REFLECTANCE for value in color
    ):
        message = f"material {shown(name)}: baseColorFactor {shown(color)} is no reflectance"
        raise InputError(f"{message}; keep it within [0, 1]", path)
    red, green, blue = (min(float(value), 1.0) for value in color)
    reflectance: Color = (red, green, blue)
    return Material(name, reflectance)


def _note_material(
    losses: Losses, name: str, item: dict[str, Any], surface: dict[str, Any] | None
) -> None:
    if any(key.endswith("Texture") for key in (*item, *(surface or ()))):
        note(losses, "textures", name)
    if surface is not None:
        if surface.get("metallicFactor", 1) != 0:
            note(losses, "metallicFactor", name)
        if surface.get("roughnessFactor", 1) != 1:
            note(losses, "roughnessFactor", name)
        if surface.get("baseColorFactor", [1])[-1] != 1:
            note(losses, "alpha", name)
    if any(item.get("emissiveFactor", ())):
        note(losses, "emissiveFactor", name)
    if item.get("alphaMode", "OPAQUE") != "OPAQUE":
        note(losses, "alphaMode", name)
    for extension in item.get("extensions", ()):
        note(losses, extension, name)
