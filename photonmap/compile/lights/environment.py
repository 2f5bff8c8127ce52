"""Turn a sky into what kernels draw directions from: a map, a model, or that of unlit scenes.

Texels are drawn by what they send to surfaces of any normal. A map is divided into blocks. For each
cell of normals, blocks are weighed by their light times the cosine that they have on average, to
whichever normal at the cell's corners and centre sees them best. A block that any normal of the
cell may see gets a chance at least.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache
from os import PathLike
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.lights.probabilities import make_cdf
from photonmap.errors import naming
from photonmap.kernels.core.records import Environment
from photonmap.kernels.lights.environment import ALL_AROUND, BLOCK_COLUMNS, BLOCK_ROWS, STEPS
from photonmap.scene.camera import Camera, frame_of
from photonmap.scene.daylight import OvercastLight, SkyLight
from photonmap.scene.images import check_panorama, read_panorama
from photonmap.scene.lights import EnvironmentLight
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Floats, integrate_products
from photonmap.spectra.daylight import daylight_basis
from photonmap.spectra.observer import observer

AMBIENT = 0.2
"""Radiance of the dome of an unlit scene, W·m⁻²·sr⁻¹: what faces the camera is brighter, what turns
away darker."""
_KEY = 1.1
"""What the key light adds, about as much as a dome of this radiance where it falls straight."""
_CONCENTRATION = 12.0  # Of the key light, exp(κ (cos θ − 1)): it falls to a half at 20 degrees
_FROM = (-0.5, 0.65, -0.6)  # Where the key light comes from, along the camera's right, up and view
_ROWS = 64
MappedLight = EnvironmentLight | SkyLight | OvercastLight
"""Lights that differ by direction all around."""
MIDDLE = (0.5, 0.5)
WITHIN_CELL = (MIDDLE, *itertools.product((0.0, 1.0), repeat=2))
WITHIN_BLOCK = tuple(itertools.product((0.25, 0.75), repeat=2))
"""Places where cosines are taken, as fractions of the way across."""
LEAST_COSINE = 0.02  # Of blocks that are seen at all
REACH = 1.01  # Factor on the angles from the middle of a block or cell to its corners, for rounding


@dataclass(frozen=True)
class Sky:
    """A map, and its colours in bands."""

    texels: NDArray[np.float32]  # (H, W, 3), linear RGB, or how much of each spectrum of daylight
    basis: Floats  # (3, N), bands of each, the light's scale included
    rotation: float = 0.0  # about +y, 1 for a full turn

    @property
    def mean(self) -> Floats:
        """The mean radiance over all directions, (N,)."""
        rows = self.texels.mean(axis=1, dtype=np.float64)
        return -0.5 * np.diff(_row_cosines(self.texels)) @ rows @ self.basis

    def record(self, power: float, row: int) -> Environment:
        """Return what kernels take; radiances are divided by `power`, `row` has their mean."""
        texels = fine_enough(self.texels)
        basis = (self.basis / power).astype(np.float32, order="C")
        light, cosines = texels @ (self.basis.mean(axis=1) / self.basis.max()), _row_cosines(texels)
        cdfs = sky_cdfs(light, cosines, self.rotation)
        return Environment(texels, basis, *cdfs, cosines, self.rotation, row)


def compile_sky(light: MappedLight, bands: Bands) -> Sky:
    """Read a checked light's map, or compute that of a sky."""
    if isinstance(light, SkyLight):
        return _clear_sky(light, bands)
    if isinstance(light, OvercastLight):
        return _overcast(light, bands)
    label = f"light {light.name or light.kind!r}"
    if isinstance(light.image, str | PathLike):
        with naming(label):
            texels = read_panorama(light.image)
    else:
        texels = check_panorama(light.image, label)
    basis = bands.emission_basis * light.scale
    return Sky(texels, basis, light.rotation / 360.0 % 1.0)


def _clear_sky(light: SkyLight, bands: Bands) -> Sky:
    """Return a sky as sums of the three spectra of daylight; in RGB, colours within the gamut."""
    texels, (wavelengths, curves) = light.weights(), daylight_basis()
    if not bands.is_rgb:
        basis = bands.average_all(wavelengths, curves)
    else:
        eye = observer()
        rgb = integrate_products(eye.wavelengths, eye.matching, wavelengths, curves).T
        texels, basis = np.maximum(texels @ rgb, 0.0).astype(np.float32), np.eye(3)
    return Sky(texels, basis * light.scale)


def _overcast(light: OvercastLight, bands: Bands) -> Sky:
    """Return a sky whose map counts one colour, the zenith's."""
    amounts = light.amounts()
    texels = np.stack([amounts, *[np.zeros_like(amounts)] * 2], axis=-1)
    basis = np.zeros((3, bands.count))
    basis[0] = bands.emission(light.radiance)
    return Sky(texels, basis)


def default_sky(camera: Camera, bands: Bands) -> Sky:
    """Return the light of scenes without any: a dome, and a soft key light that shows shapes.

    Its radiance is the same in every band, brightest above and to the left of the camera.
    """
    view, right, up = frame_of(camera)
    x, y, z = _FROM
    key = x * right + y * up + z * view
    key /= np.linalg.norm(key)
    polar = (np.arange(_ROWS) + 0.5) * (np.pi / _ROWS)
    azimuth = (np.arange(2 * _ROWS) + 0.5) * (np.pi / _ROWS) - np.pi  # of −z at the centre
    across = key[0] * np.sin(azimuth) - key[2] * np.cos(azimuth)
    cosine = np.sin(polar)[:, None] * across + key[1] * np.cos(polar)[:, None]
    peak = _KEY * _CONCENTRATION / 2.0
    radiance = AMBIENT + peak * np.exp(_CONCENTRATION * (cosine - 1.0))
    texels = np.repeat(radiance[..., None], 3, axis=2).astype(np.float32)
    return Sky(texels, np.full((3, bands.count), 1.0 / 3.0))


def _row_cosines(texels: NDArray[np.float32]) -> Floats:
    """Return the cosines of the zenith angles between the rows of a map, (H + 1,)."""
    return np.cos(np.linspace(0.0, np.pi, len(texels) + 1))


class SkyCdfs(NamedTuple):
    """Fields of `kernels.core.records.Environment`."""

    block_rows: Floats
    block_columns: Floats
    rows: Floats
    columns: Floats


def sky_cdfs(light: Floats, cosines: Floats, rotation: float) -> SkyCdfs:
    """Return the CDFs of a map, (H, W) radiances of texels, at least 16 × 32.

    `cosines`, (H + 1,), are those of the zenith angles between rows; `rotation` is that of the map
    about +y, 1 for a full turn.
    """
    height, width = light.shape
    row_edges, column_edges = _edges(height, BLOCK_ROWS), _edges(width, BLOCK_COLUMNS)
    light = light * -np.diff(cosines)[:, None]
    in_columns = np.add.reduceat(light, column_edges[:-1], axis=1)
    blocks = np.add.reduceat(in_columns, row_edges[:-1], axis=0)
    seen = np.append(blocks * _mean_cosines(height, width, rotation), blocks[None], axis=0)
    return SkyCdfs(
        make_cdf(seen.sum(axis=2)),
        make_cdf(seen),
        _cdf_by_part(np.ascontiguousarray(in_columns.T), row_edges),
        _cdf_by_part(light, column_edges),
    )


def fine_enough(texels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a map, (H, W, 3), whose texels are divided until each block has one at least."""
    height, width = texels.shape[:2]
    texels = np.repeat(texels, -(-BLOCK_ROWS // height), axis=0)
    return np.repeat(texels, -(-BLOCK_COLUMNS // width), axis=1)


def _edges(count: int, blocks: int) -> NDArray[np.int64]:
    """Return where blocks of rows or columns begin and end, as kernels say, (blocks + 1,)."""
    return -(-np.arange(blocks + 1) * count // blocks)


def _cdf_by_part(weights: Floats, edges: NDArray[np.int64]) -> Floats:
    """Return weights, (…, n), as CDFs that rise to 1 between any two edges."""
    return np.concatenate(
        [make_cdf(weights[..., a:b]) for a, b in itertools.pairwise(edges)], axis=-1
    )


@cache
def _mean_cosines(height: int, width: int, rotation: float) -> NDArray[np.float32]:
    """Return by which cosine blocks count for the cells of normals, (K, 16, 32)."""
    down, turn = _edges(height, BLOCK_ROWS) / height, _edges(width, BLOCK_COLUMNS) / width
    turn -= rotation
    middles, *across = (_directions(down, turn, *place) for place in (MIDDLE, *WITHIN_BLOCK))
    means = np.zeros((ALL_AROUND, BLOCK_ROWS * BLOCK_COLUMNS), np.float32)
    for place in WITHIN_CELL:
        normals = _normals(*place)
        cosines = [np.maximum(normals @ directions, 0.0) for directions in across]
        means = np.maximum(means, np.mean(cosines, axis=0))
    half = np.hypot(np.pi * np.diff(down).max(), 2.0 * np.pi * np.diff(turn).max()) / 2.0
    reach = REACH * (half + np.arctan(np.sqrt(2.0) / STEPS))
    seen = _normals(*MIDDLE) @ middles > -np.sin(reach)
    means = np.where(seen, np.maximum(means, LEAST_COSINE), 0.0)
    return means.reshape(-1, BLOCK_ROWS, BLOCK_COLUMNS)


def _directions(down: Floats, turn: Floats, s: float, t: float) -> NDArray[np.float32]:
    """Return directions at a place within each block, (3, 16 · 32).

    `down` and `turn` are edges of rows and columns, as fractions of the map.
    """
    theta = np.pi * (down[:-1] + s * np.diff(down))[:, None]
    phi = 2.0 * np.pi * (turn[:-1] + t * np.diff(turn) - 0.5)
    x, z = np.sin(theta) * np.sin(phi), -np.sin(theta) * np.cos(phi)
    y = np.broadcast_to(np.cos(theta), x.shape)
    return np.stack([x, y, z]).reshape(3, -1).astype(np.float32)


def _normals(s: float, t: float) -> NDArray[np.float32]:
    """Return the normal at a place within each cell of `cell_of_normal`, (K, 3)."""
    faces, rows, columns = np.unravel_index(np.arange(ALL_AROUND), (6, STEPS, STEPS))
    normals, each = np.empty((ALL_AROUND, 3), np.float32), np.arange(ALL_AROUND)
    axes = faces // 2
    normals[each, axes] = 1.0 - 2.0 * (faces % 2)
    normals[each, (axes + 1) % 3] = 2.0 * (rows + s) / STEPS - 1.0
    normals[each, (axes + 2) % 3] = 2.0 * (columns + t) / STEPS - 1.0
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)
