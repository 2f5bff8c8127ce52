"""Separate what posters reflect from what they fluoresce, by images under two lights; score it.

One light is daylight, the other a violet LED. Beyond the bands of the LED, all that its image p₂
shows is fluorescence, which has the same spectrum under daylight, where the image is

    p₁ = ρ l + a p₂,

with the light l, known from a white card, and a number a for each poster. Well beyond the peak of
its fluorescence a pigment takes up nothing, and ρ is smooth: a leaves the least second differences.
"""

import numpy as np

import photonmap as pm
from photonmap.spectra.fluorophores import named

CARD, DYES = "white card", ("coumarin 6", "fluorescein", "rhodamine 6g", "lumogen red 305")
nm = np.arange(380.0, 741.0)


def poster(number, name):
    """Return a leaf that takes up light of shorter wavelengths, or the white card."""
    x = 0.5 * number - 1.25
    corners = [[x, -1, 0], [x + 0.5, -1, 0], [x + 0.5, 1, 0], [x, 1, 0]]
    material = pm.Material(name, 0.9)
    if name != CARD:
        color = named(name).emission
        taken = 0.7 / (1.0 + np.exp((nm - nm[np.argmax(color(nm))]) / 8.0 + 2.0))
        pigment = pm.Fluorescence(pm.Spectrum(nm, taken), color, 0.9)
        material = pm.Material(name, pm.Spectrum(nm, 0.85 - taken), fluorescence=pigment)
    return pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], material, name)


def photograph(light):
    """Render the posters under a light, without blur."""
    lamp = pm.PointLight((0.0, 0.5, 3.0), pm.emission(light))
    scene = pm.Scene(meshes, [lamp], pm.Camera((0, 0, 5), (0, 0, 0), fov=22))
    return pm.render(scene, bands="390:730:10", size=(96, 72), passes=2, pixel="center")


meshes = [poster(number, name) for number, name in enumerate((CARD, *DYES))]
day, led = photograph("D65"), photograph("led:405,15")
numbers = {name: 1 + day.record["materials"].index(name) for name in (CARD, *DYES)}
card = day.material_id == numbers[CARD]
light, violet = (result.radiance[card].mean(axis=0, dtype=float) for result in (day, led))
is_dark = violet < 1e-6 * violet.max()
for name in DYES:
    seen = day.material_id == numbers[name]
    first, glow = (result.radiance[seen].astype(float) * is_dark for result in (day, led))
    tail = slice(2 + int(np.argmax(glow.mean(axis=0))), None)
    both, alone = (np.diff((image.mean(axis=0) / light)[tail], 2) for image in (first, glow))
    factor = (both @ alone) / (alone @ alone)
    truth = day.fluorescence[seen] * is_dark
    wrong = np.linalg.norm(factor * glow - truth)
    print(
        f"{name:16} fluorescence to {wrong / np.linalg.norm(truth):.1%}, reflected light to "
        f"{wrong / np.linalg.norm(first - truth):.1%}, in {np.count_nonzero(is_dark)} bands"
    )
