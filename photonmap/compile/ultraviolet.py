"""Warnings where fluorescence is excited by light that bands do not see, or nobody defined."""

from __future__ import annotations

from photonmap.errors import warn
from photonmap.runtime.wording import listed
from photonmap.scene.scene import Scene
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Paint, is_black
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import VISIBLE, Floats, Spectrum
from photonmap.spectra.fluorescence import RANGE, quanta_out
from photonmap.spectra.observer import observer

_MISSED = 0.05  # Share of what excites a material from which on a warning says that bands miss it
_WEAK = 0.01  # of the largest excitation, below which it does not count


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
    strongest = 0.0 * RANGE
    for material in glowing:
        quanta = quanta_out(material.fluorescence, RANGE)
        missed = float(quanta[~seen].sum() / max(quanta.sum(), 1e-300))
        if missed > _MISSED:
            warn(
                f"material {material.name!r}: {missed:.0%} of what excites its fluorescence lies "
                f"beyond {low:g} to {high:g} nm, and is left out; render with bands 300:780:20"
            )
        strongest += quanta
    needed = RANGE[seen & (strongest > _WEAK * strongest.max())]
    colors: list[tuple[str, Paint]] = [
        (f"light {light.name or light.kind}", light.color) for light in scene.lights
    ]
    for name in ("emission", "reflectance"):
        colors += [(f"{name} of {each.name}", getattr(each, name)) for each in materials]
    unknown = [owner for owner, color in colors if needed.size and not _reaches(color, needed)]
    if unknown:
        warn(
            f"fluorescence is excited from {needed[0]:g} to {needed[-1]:g} nm, where some colours "
            f"are not defined and hold their outer values: {listed(unknown)}; give curves"
        )


def _reaches(color: Paint, wavelengths: Floats) -> bool:
    """Return whether a colour is defined at wavelengths; RGB is where its basis and D65 are."""
    if isinstance(color, float | int) or is_black(color):
        return True
    at = observer().wavelengths
    if isinstance(color, Spectrum | SpectralTexture):
        at = color.wavelengths
    return bool(at[0] <= max(wavelengths[0], 300.0) and at[-1] >= wavelengths[-1])
