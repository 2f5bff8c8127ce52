"""Colour errors of few bands, and methods that turn RGB into spectra."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import photonmap as pm
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table
from photonmap.spectra.color_difference import delta_e_2000
from photonmap.spectra.names import colour_science
from photonmap.spectra.observer import observer

Floats = NDArray[np.float64]

BANDS, TRUTH = (3, "best:3", 6, "best:6", 9, "best:9", 31), 81
SIZE, PASSES = (128, 128), 64
GRID = 9
RECOVERED = 20
"""Colours for methods that take long."""


def run(options: Options) -> list[Table]:
    """Compare bands on two scenes of measured spectra, and upsamplings on the sRGB cube."""
    scenes = {"measured Cornell box": pm.scenes.cornell_box_measured(), "facing plates": plates()}
    return [*(_bands(options, name, scene) for name, scene in scenes.items()), _upsampling()]


def plates() -> pm.Scene:
    """Return two saturated Munsell chips that face each other, and a lamp between them."""

    def plate(x: float, chip: str) -> pm.Mesh:
        corners = [(x, y, z) for y, z in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
        return pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], pm.Material(chip, pm.reflectance(chip)))

    lamp = pm.PointLight((0.0, 0.8, 0.6), pm.emission("D65"))
    facing = [plate(-0.5, "munsell:5R 4/14"), plate(0.5, "munsell:5G 5/10")]
    return pm.Scene(facing, [lamp], pm.Camera((0.0, 0.0, 3.2), (0.0, 0.0, 0.0)))


def _bands(options: Options, title: str, scene: pm.Scene) -> Table:
    """Compare sRGB images from few bands with one from many."""

    def render(bands: int | str, seed: int = 0) -> pm.Result:
        return pm.render(
            scene, bands=bands, size=SIZE, passes=PASSES, seed=seed, threads=options.threads
        )

    truth = render(TRUTH)
    table = Table(
        f"bands: ΔE2000 in sRGB relative to {TRUTH} bands, {title}",
        ["bands", "method", "mean", "95%", "indirect, mean", "95%"],
    )
    runs = [(str(bands), render(bands)) for bands in BANDS]
    for name, result in [*runs, (f"{TRUTH}, other seed: noise", render(TRUTH, seed=1))]:
        for method in ("direct", "primaries", "regression"):
            row: list[object] = [name, method]
            for buffer in ("radiance", "indirect"):
                off = delta_e_2000(
                    result.rgb(buffer, method, "D65"), truth.rgb(buffer, method, "D65")
                )
                row += [off.mean(), np.percentile(off, 95)]
            table.rows.append(row)
    return table


def _upsampling() -> Table:
    """Time methods from RGB to reflectance, and measure their round trip under D65."""
    axis = np.linspace(0.0, 1.0, GRID)
    cube = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    table = Table(
        f"upsampling: RGB to reflectance, {GRID}³ colours of the sRGB cube",
        ["method", "µs per colour", "mean ΔE2000", "max", "lowest", "highest", "roughness"],
    )
    few = cube[:: len(cube) // RECOVERED]
    ways: list[tuple[str, Callable[[Floats], Floats], Floats]] = [
        ("linear basis (ours)", lambda rgb: rgb @ observer().basis, cube),
        ("Smits 1999", _by_colour("Smits 1999"), few),
        ("Jakob 2019", _by_colour("Jakob 2019"), few),
        ("Meng 2015", _by_colour("Meng 2015"), few),
        ("Otsu 2018", _by_colour("Otsu 2018"), few),
    ]
    eye = observer()
    for name, upsample, colors in ways:
        start = time.perf_counter()
        curves = upsample(colors)
        spent = (time.perf_counter() - start) / len(colors)
        back = (curves * eye.d65) @ eye.matching.T
        off = delta_e_2000(back, colors, white=1.0)
        rough = np.sqrt(np.mean(np.diff(curves[:, ::5], 2, axis=1) ** 2))
        table.rows.append(
            [name, 1e6 * spent, off.mean(), off.max(), curves.min(), curves.max(), rough]
        )
    return table


def _by_colour(method: str) -> Callable[[Floats], Floats]:
    """Return a method of colour-science as a function from (C, 3) RGB to (C, M) curves."""

    def upsample(colors: Floats) -> Floats:
        eye = observer()
        curves = []
        with colour_science() as colour:
            for rgb in colors:
                curve = colour.XYZ_to_sd(eye.rgb_to_xyz @ rgb, method=method)
                curves.append(np.interp(eye.wavelengths, curve.wavelengths, curve.values))
        return np.array(curves)

    return upsample
