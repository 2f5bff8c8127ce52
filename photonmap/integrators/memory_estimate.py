"""Estimate the memory of a render before it starts."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from photonmap.buffers import DEFAULT, RENDERED
from photonmap.film.moments import BYTES_PER_VALUE
from photonmap.film.replicates import replicate_size
from photonmap.integrators.photon_mapping.cache_tracer import MOST_CELLS_PER_PHOTON, bundle_count
from photonmap.runtime.storage import Need

PASS_BUFFERS = 7
"""Arrays of a pass with a value a pixel and band: those of `Pixels`, and shared irradiance."""
SPECULAR_BYTES_PER_VALUE = 44
"""Moments and passes of caustics and of what is seen via specular surfaces."""
FLUORESCENT_BYTES_PER_VALUE = 84
"""Moments and passes of fluorescence and of what excites it."""
FILTER_BYTES = 104, 120
"""Of a value, and of a pixel, to filter light when a render is read out."""
UNBIASED_BUFFERS = 8
"""Arrays of an unbiased pass besides: differences, rounds of averages, reflectance."""
OF_REPLICATES = 6, 5, 4
"""Arrays that add up the passes of a replicate: in any scene, and as above."""
BYTES_PER_PIXEL = 146
"""Bytes of a pixel besides bands and the buffers that are kept: sampling plan, planes, counts."""
BYTES_PER_TRIANGLE = 300
"""Arrays, Embree's tree, and what its construction needs for a moment."""
BASE = 250e6
"""Bytes of the interpreter, its packages and compiled kernels."""
PASSING_BYTES_PER_PIXEL = 48
"""What stays in RAM of an image whose arrays are on disk, for moments and to adapt sampling."""
PASSING_BYTES_PER_SPLIT_VALUE = 32
"""The same of each value of a pass that is split by light group."""
PASSING_BYTES_PER_CAUSTIC = 3 * 56
"""The same of caustic photons, one a pixel, while they are sorted."""


@dataclass(frozen=True)
class Work:
    """What decides how much memory a render needs."""

    pixels: int
    bands: int  # those of the whole, and of each light group that is split off
    photons: int
    triangles: int
    passes: int | None = None  # None for any number
    specular: bool = False  # there are mirrors or glass
    per_light: bool = False  # light is split by light group
    unbiased: bool = False  # pixels share by differences
    buffers: Collection[str] = DEFAULT  # names of those that are kept
    fluorescent: bool = False  # surfaces fluoresce
    filtered: bool = False  # light is filtered

    @property
    def need(self) -> Need:
        """Bytes that are never on disk, and those of the arrays that may be."""
        passing = PASSING_BYTES_PER_PIXEL + PASSING_BYTES_PER_CAUSTIC * self.specular
        passing += PASSING_BYTES_PER_SPLIT_VALUE * self.bands * self.per_light
        always = BASE + BYTES_PER_TRIANGLE * self.triangles + passing * self.pixels
        kept_values = sum(
            row.values_per_pixel(self.bands)
            for row in RENDERED
            if row.name in self.buffers
            and (self.specular or row.omitted != "without mirrors, glass or rough surfaces")
            and (self.fluorescent or row.omitted != "without fluorescent surfaces")
        )
        buffers = PASS_BUFFERS + UNBIASED_BUFFERS * self.unbiased
        if self.passes is None or replicate_size(self.passes - 1) > 1:
            sums, specular, fluorescent = OF_REPLICATES
            buffers += sums + specular * self.specular + fluorescent * self.fluorescent
        per_value = BYTES_PER_VALUE + 4 * buffers + SPECULAR_BYTES_PER_VALUE * self.specular
        per_value += FLUORESCENT_BYTES_PER_VALUE * self.fluorescent
        per_pixel = BYTES_PER_PIXEL + self.bands * per_value + 4 * kept_values
        per_pixel += self.filtered * (FILTER_BYTES[0] * self.bands + FILTER_BYTES[1])
        cells = 2.0 * self.photons * MOST_CELLS_PER_PHOTON
        caches = cells * self.bands * 4 * (bundle_count(self.photons) + 2)
        return Need(always, self.pixels * per_pixel + caches)
