"""The arrays that kernels work on. T triangles, M materials, K emitters, N bands, P pixels.

Lengths are in units of the scene's size, power in units of the lights' total: `prepare` scales
there, `render` scales back.
"""

from typing import NamedTuple

import numpy as np

TRIANGLE, POINT, DOME, SPOT, DIRECTIONAL = 0, 1, 2, 3, 4
"""Kinds of emitters; the dome is the sky, of one radiance or that of the environment."""
DIRECT, INDIRECT, CAUSTIC = 0, 1, 2
"""Rows of a sample's irradiance, (2, N), or (3, N) where the scene has smooth surfaces."""
MIRROR, GLASS = 1, 2
"""Kinds of smooth surfaces; 0 is none."""
BYTES, SRGB, FLOATS = 0, 1, 2
"""Kinds of texels: linear bytes, sRGB bytes, linear float32; the first two are rows of a table."""
FIRST_CAUSTIC, LIT_BY_CAUSTIC, SEEN_DIRECT, SEEN_INDIRECT, SEEN_CAUSTIC = 0, 1, 2, 3, 4
"""Rows of `seen`, (5, P, N) float32, what a pass estimates beside `Pixels` where there are smooth
surfaces: caustics reflected by first hits, and their irradiance there; and what is seen in smooth
surfaces of direct, indirect and caustic light."""


class Maps(NamedTuple):
    """Images as surfaces use them, one row for each of R uses: see `texels`."""

    address: np.ndarray
    """(R,) int64, of the first texel"""
    shape: np.ndarray
    """(R, 3) int32, rows, columns, and channels (1 or 3)"""
    kind: np.ndarray
    """(R,) uint8: BYTES, SRGB or FLOATS"""
    clamp: np.ndarray
    """(R,) uint8, 1 where edges go on outside the unit square; otherwise the image repeats"""
    place: np.ndarray
    """(R, 4) float64, scale of u and v, then their offset"""
    factor: np.ndarray
    """(R, 3) float64, of red, green and blue"""
    tables: np.ndarray
    """(2, 256) float32, linear values of bytes"""


class Alpha(NamedTuple):
    """How much of a surface is there; a scene whose surfaces are all whole has None instead."""

    value: np.ndarray
    """(M,) float64, opacity where there is no texture"""
    image: np.ndarray
    """(M,) int32, row of `maps`, -1 for none"""
    maps: Maps


class Textures(NamedTuple):
    """Reflectances that vary over surfaces; a scene without any has None in its place."""

    maps: Maps
    reflectance: np.ndarray
    """(M,) int32, row of `maps`, -1 for none"""
    basis: np.ndarray
    """(3, N) float32, which makes reflectances of linear RGB"""


class Glow(NamedTuple):
    """Lamps whose radiance varies over them."""

    maps: Maps
    slot: np.ndarray
    """(R,) int32, which of E textures a row of `Lights.spectra` stands for, -1 for none"""
    image: np.ndarray
    """(E,) int32, row of `maps`"""
    basis: np.ndarray
    """(3 E, N) float32, three rows for each, which make radiances of linear RGB"""
    uv: np.ndarray
    """(V, 2) float32"""
    triangles: np.ndarray
    """(T, 3) int32"""


class Geometry(NamedTuple):
    """All triangles of the scene, and Embree's scene over them."""

    scene: int
    """address of the committed Embree scene"""
    vertices: np.ndarray
    """(V, 3) float32"""
    triangles: np.ndarray
    """(T, 3) int32"""
    normals: np.ndarray
    """(T, 3) float32, unit geometric normal of the winding"""
    shading_normals: np.ndarray
    """(V, 3) float32, zero rows are flat; (0, 3) in a scene without any"""
    material: np.ndarray
    """(T,) int32"""
    emitter: np.ndarray
    """(T,) int32, -1 for a triangle that does not emit"""
    uv: np.ndarray
    """(V, 2) float32, (0, 2) in a scene without textures"""
    alpha: Alpha | None
    """None where all surfaces are opaque"""


class Materials(NamedTuple):
    """What surfaces do with light."""

    reflectance: np.ndarray
    """(M, N) float32, of textures the mean"""


class Optics(NamedTuple):
    """Smooth surfaces; a scene without any has None in its place."""

    kind: np.ndarray
    """(M,) uint8: 0, MIRROR or GLASS"""
    mirror: np.ndarray
    """(M, N) float32, reflectance of the mirror"""
    ior: np.ndarray
    """(M,) float64, index of refraction of the inside"""
    tint: np.ndarray
    """(M, N) float32, what glass transmits at a crossing"""
    chance: np.ndarray
    """(M,) float64, of the smooth part where a path takes either it or the diffuse one: 1 for
    mirrors and glass, 0 where there is no smooth part"""


class Environment(NamedTuple):
    """The sky as a map of H rows and W columns: see `environment`."""

    texels: np.ndarray
    """(H, W, 3) float32, linear RGB"""
    basis: np.ndarray
    """(3, N) float32, which makes radiances of RGB"""
    rows: np.ndarray
    """(H,) float64, rises to 1 in proportion to the light of each row"""
    columns: np.ndarray
    """(H, W) float64, each row rises to 1 in proportion to the light of its texels"""
    cosines: np.ndarray
    """(H + 1,) float64, y at the edges of the rows, from 1 to -1"""
    turn: float
    """of the map about +y, counter-clockwise seen from above, 1 for a full turn"""


NODE_CENTER, NODE_AXIS, NODE_SQUARED_RADIUS, NODE_STRENGTH, NODE_TURN, NODE_REACH = 0, 3, 6, 7, 8, 9
"""Columns of a light tree's nodes: center (3) and squared radius of a sphere around its emitters;
axis (3) of a cone of their normals; the sum of their intensities; and the cosines of the cone's
half angle and of that to which an emitter shines from its normal."""


class LightTree(NamedTuple):
    """Emitters by place and direction, to choose among for a point: see `light_tree`."""

    nodes: np.ndarray
    """(2S, 10) float64, columns NODE_…; row 0 is unused, S is a power of two"""
    emitter: np.ndarray
    """(S,) int32, of each leaf"""
    leaf: np.ndarray
    """(K,) int32, of each emitter, -1 if it is infinitely far"""
    near: float
    """chance of those in the tree, by power"""
    far: np.ndarray
    """(K,) float64, rises to 1 in proportion to the power of the others"""


class Lights(NamedTuple):
    """Emitters of all kinds, chosen by power, and for direct light by importance."""

    kind: np.ndarray
    """(K,) uint8: TRIANGLE, POINT, DOME, SPOT or DIRECTIONAL"""
    triangle: np.ndarray
    """(K,) int32, -1 where the emitter is none"""
    position: np.ndarray
    """(K, 3) float64 of point and spot lights"""
    axis: np.ndarray
    """(K, 3) float64, unit vector in which spot and directional lights shine"""
    cosines: np.ndarray
    """(K, 2) float64 of the angles up to which a spot is full, and beyond which it is dark"""
    area: np.ndarray
    """(K,) float64 of triangles"""
    spectrum: np.ndarray
    """(K,) int32, row of `spectra`"""
    spectra: np.ndarray
    """(R, N) float32: radiance, intensity (POINT, SPOT) or irradiance (DIRECTIONAL); of an
    environment or a texture the mean"""
    cumulative: np.ndarray
    """(K,) float64, rises to 1 in proportion to power"""
    dome: int
    """index of the dome's emitter, -1 without a dome"""
    radius: float
    """of a sphere around the origin that holds the scene"""
    environment: Environment | None
    """what the dome looks like; None where it is the same all around, or where there is none"""
    glow: Glow | None
    """None without textured lamps"""
    tree: LightTree | None
    """None where emitters are few"""


SceneArrays = tuple[Geometry, Materials, Lights, Optics | None, Textures | None]
"""The scene as kernels take it."""


class Camera(NamedTuple):
    """A pinhole; the ray of film point (x, y) in pixels is corner + x·across + y·down."""

    origin: tuple
    corner: tuple
    across: tuple
    down: tuple


class Film(NamedTuple):
    """The image, and how camera samples lie in a pixel."""

    width: int
    height: int
    jitter: bool
    """samples cover the pixel (box), or all pass through its centre"""


class Survey(NamedTuple):
    """What a look at the scene tells of each pixel, before and apart from all estimates."""

    flat: np.ndarray
    """(P,) uint8, 1 where all samples hit one smooth piece of surface of one material"""
    even: np.ndarray
    """(P,) uint8, 1 where it is flat, hardly curved, and without textures"""
    nearness: np.ndarray
    """(P,) float32, mean of 1 / distance to the surfaces around"""
    penumbra: np.ndarray
    """(P,) uint8, 1 where some light samples are blocked and some are not"""
    smooth: np.ndarray
    """(P,) uint8, 1 where a sample hit a mirror or glass"""


LANES = 8
"""Random points and directions that are made at once."""


class Scratch(NamedTuple):
    """What a kernel needs for one sample of a pixel."""

    throughput: np.ndarray
    """(N,) float32, of a path"""
    through: np.ndarray
    """(N,) float32, of smooth surfaces that the camera sees by"""
    irradiance: np.ndarray
    """(2, N) float32, or (3, N) where the scene has smooth surfaces"""
    points: np.ndarray
    """(2, LANES) float64, of the unit square, made at once"""
    directions: np.ndarray
    """(3, LANES) float64, of gather rays"""


class Plan(NamedTuple):
    """How much sampling each pixel gets, and how far its indirect light is shared."""

    samples: np.ndarray
    """(P,) uint8, camera samples in a pass"""
    lights: np.ndarray
    """(P,) uint8, light samples of each camera sample"""
    gathers: np.ndarray
    """(P,) uint8, gather rays of each camera sample"""
    reach: np.ndarray
    """(P,) float32, distance over which indirect irradiance hardly changes"""


class Cells(NamedTuple):
    """Surface cells of the irradiance store: see `store`."""

    first: np.ndarray
    """(T, 2) int32, first cell of each side"""
    divisions: np.ndarray
    """(T,) int32, n: the triangle's side is divided into n² cells"""
    inverse_area: np.ndarray
    """(T, 2) float32, 1 / area of one cell"""
    parts: np.ndarray
    """(cells,) int32, the first of the finer² cells that a cell of one triangle is divided into,
    or -1; none are where all triangles share cells"""
    finer: int


class Pixels(NamedTuple):
    """What one pass estimates; band values are means over a pixel's samples."""

    emission: np.ndarray
    """(P, N) float32"""
    direct: np.ndarray
    """(P, N) float32"""
    indirect: np.ndarray
    """(P, N) float32"""
    reflectance: np.ndarray
    """(P, N) float32"""
    irradiance_direct: np.ndarray
    """(P, N) float32"""
    irradiance_indirect: np.ndarray
    """(P, N) float32"""
    coverage: np.ndarray
    """(P,) float32, fraction of samples that hit something"""
    found: np.ndarray
    """(P,) uint8, flags: 1 where a gather ray met a surface without light, 2 with light"""
    plane: np.ndarray
    """(P, 7) float32, point, shading normal and flatness (0 or 1) of a pixel's samples"""


class Caustics(NamedTuple):
    """Photons that came to diffuse surfaces by smooth ones alone, sorted by boxes of space."""

    places: np.ndarray
    """(n, 6) float32, position, and geometric normal on the side where the photon arrived"""
    flux: np.ndarray
    """(n, N) float32"""
    starts: np.ndarray
    """(H + 1,) int32, first photon of each bucket"""
    radius: float
    """of the disk over which photons are counted"""


class Guide(NamedTuple):
    """Where in the unit square, twice, photons leave lights that come to smooth surfaces.

    Each square is divided into B × B boxes; the density is constant in a box.
    """

    place_rows: np.ndarray
    """(B + 1,) float64, cumulative chance of rows of boxes"""
    place_columns: np.ndarray
    """(B, B + 1) float64, and of boxes within each row"""
    aim_rows: np.ndarray
    """(B + 1,) float64"""
    aim_columns: np.ndarray
    """(B, B + 1) float64"""
