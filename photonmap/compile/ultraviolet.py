"""Warnings where fluorescence is excited by light that bands do not see, or nobody defined."""

from __future__ import annotations

import numpy as np

from photonmap.errors import warn
from photonmap.runtime.wording import listed, shown
from photonmap.scene.material import Material
from photonmap.scene.scene import Scene
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Paint, is_black, mean_color
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import VISIBLE, Floats, Spectrum
from photonmap.spectra.fluorescence import RANGE, quanta_out, reradiation_errors
from photonmap.spectra.observer import observer

_MISSED = 0.05  # Share of what excites a material from which on a warning says that bands miss it
_WEAK = 0.01  # of the largest excitation, or of a light, below which it does not count
_WRONG = 0.1  # Error of what a light excites, from which on a warning says so


def warn_of_ultraviolet(scene: Scene, bands: Bands) -> None:
    """Warn where bands, lights or reflectances end before what excites fluorescence does.

    Colours hold their outer values there.
    """
    materials = list({id(mesh.material): mesh.material for mesh in scene.meshes}.values())
    glowing = [material for material in materials if material.fluorescence is not None]
    if not glowing:
        return
    low, high = bands.limits or VISIBLE
    seen = (low <= RANGE) & (high >= RANGE)
    strongest, reached = 0.0 * RANGE, []
    for material in glowing:
        quanta = quanta_out(material.fluorescence, RANGE)
        missed = float(quanta[~seen].sum() / max(quanta.sum(), 1e-300))
        if missed > _MISSED:
            exciting = RANGE[quanta > _WEAK * quanta.max()]
            warn(
                f"material {material.name!r}: {missed:.0%} of what excites its fluorescence "
                f"({exciting[0]:g} to {exciting[-1]:g} nm) lies beyond {low:g} to {high:g} nm, and "
                "is left out; use bands 300:780:20"
            )
        else:
            reached.append(material)
        strongest += quanta
    lights: list[tuple[str, Paint]] = [(f"light {x.name or x.kind}", x.color) for x in scene.lights]
    lights += [(f"emission of {x.name}", x.emission) for x in materials if not is_black(x.emission)]
    _warn_of_lines(lights, reached, bands)
    needed = RANGE[seen & (strongest > _WEAK * strongest.max())]
    colors = lights + [(f"reflectance of {each.name}", each.reflectance) for each in materials]
    unknown = [owner for owner, color in colors if needed.size and not _reaches(color, needed)]
    if unknown:
        warn(
            f"fluorescence is excited from {needed[0]:g} to {needed[-1]:g} nm, where some colours "
            f"are not defined and hold their outer values: {listed(unknown)}; give curves"
        )


def _warn_of_lines(lights: list[tuple[str, Paint]], glowing: list[Material], bands: Bands) -> None:
    """Warn where bands are too wide to tell how strongly a light excites a material."""
    owners = {mean_color(color): owner for owner, color in reversed(lights)}
    wrong = []
    power = [float(np.linalg.norm(bands.emission(color))) for color in owners]
    for material in {each.fluorescence: each for each in glowing}.values() if owners else ():
        errors = reradiation_errors(material.fluorescence, bands, list(owners))
        for owner, whole, (missed, exact) in zip(owners.values(), power, errors, strict=True):
            if missed > max(_WRONG * exact, _WEAK * whole):
                wrong.append((missed / max(exact, 1e-300), owner, material.name))
    if wrong:
        error, owner, name = max(wrong)
        warn(
            f"bands do not resolve {len(wrong)} of the lights that excite fluorescence; at worst "
            f"{shown(owner)} on material {name!r}, by {error:.0%} of what is sent out; use bands "
            "in steps near the width of its lines, such as 300:780:5"
        )


def _reaches(color: Paint, wavelengths: Floats) -> bool:
    """Return whether a colour is defined at wavelengths; RGB is where its basis and D65 are."""
    if isinstance(color, float | int) or is_black(color):
        return True
    at = observer().wavelengths
    if isinstance(color, Spectrum | SpectralTexture):
        at = color.wavelengths
    return bool(at[0] <= max(wavelengths[0], 300.0) and at[-1] >= wavelengths[-1])
