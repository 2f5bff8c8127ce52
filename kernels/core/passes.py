"""What rays, passes and pixels are made of. P pixels, N bands, T triangles.

In kernels, `hit`, `surface`, `film`, `plan`, `cache`, `scratch` are these records.
"""

from typing import NamedTuple

import numpy as np
from numba.types import UniTuple, boolean, float32, float64, int32, int64, uint8

from photonmap.kernels.core.record_types import by_reference
from photonmap.kernels.core.records import SceneArrays

DIRECT, INDIRECT, CAUSTIC = 0, 1, 2
"""Rows of a sample's irradiance, (2, N), or (3, N) where the scene has specular surfaces"""
EMPTY, FOUND, TRUNCATED = 1, 2, 4
"""Lookup flags of a pixel: a gather ray met a surface without light in its cell, or one with light;
a specular chain was truncated"""
FIRST_CAUSTIC, CAUSTIC_IRRADIANCE, VIA_DIRECT, VIA_INDIRECT, VIA_CAUSTIC = 0, 1, 2, 3, 4
"""Rows of `Estimate.via_specular`"""
FLUORESCENT_DIRECT, FLUORESCENT_INDIRECT, EXCITATION_DIRECT, EXCITATION_INDIRECT = 5, 6, 7, 8
"""Further rows where surfaces fluoresce: what first hits re-emit, and of what light arrives there,
over π, the part that makes them do so"""
RAY_KINDS = ("camera", "specular", "shadow", "gather", "walk")
"""Rays of a camera pass: to first hits, on along specular chains, to light samples and from caustic
photons to the camera, from first hits for indirect light, and on from where these end"""
CAMERA, SPECULAR, SHADOW, GATHER, WALK = range(len(RAY_KINDS))
MAX_BOUNCES = 1000  # Bounces after which photons and paths are truncated
LANES = 8  # Low-discrepancy points and directions that are made at once, by vector instructions


Vector = UniTuple(float64, 3)


class Ray(NamedTuple):
    """A ray; its direction need not be of unit length."""

    origin: tuple
    direction: tuple


class FilmPoint(NamedTuple):
    """Where a camera sees a point in space: see `camera.cameras`."""

    x: float  # pixels from the upper left corner of the image; it may lie beyond its edges
    y: float
    density: float  # pixels of film per area across the ray there; 0 where it is unseen


class Hit(NamedTuple):
    """Where a ray meets a surface."""

    triangle: int  # -1 where it meets none
    u: float
    v: float  # barycentrics of the second and third corner
    distance: float  # in lengths of the ray's direction


class SurfaceInteraction(NamedTuple):
    """A surface point, seen from where a ray arrived; made by `geometry.interaction`."""

    point: tuple  # offset to the side of the arrival, ready to be a ray's origin
    site: tuple  # the same on the surface itself, from where lights at a point are seen
    ng: tuple  # geometric normal on that side
    ns: tuple  # shading normal; it may lean beyond the horizon of ng
    side: int  # 0 at the front of the triangle, 1 at its back
    hit: Hit
    arrival: tuple  # direction of the ray, of any length
    model: int  # of `bsdf.models`, by which directions are drawn; Lambertian until said otherwise


@by_reference
class Lens(NamedTuple):
    """A thin lens in front of a camera: see `camera.cameras`."""

    is_open: bool  # False for a point, through which all rays pass; the rest then means nothing
    right: Vector  # from its centre to its rim, in the kernels' unit of length
    up: Vector
    nearness: float  # 1 / distance along the axis at which it is focused
    blades: int  # sides of its opening; 0 for a disk


@by_reference
class Projection(NamedTuple):
    """From pixels to directions that are no linear function of them: see `camera.projections`."""

    focal: UniTuple(float64, 2)  # pixels in a unit of the image, across and down
    center: UniTuple(float64, 2)  # the film point that lies on the axis
    distortion: UniTuple(float64, 5)  # five coefficients, of what depends on the kind
    reach: UniTuple(float64, 2)
    """of a fisheye: the largest radius in the image, and the angle there; of a distorted image: its
    width and height, pixels"""
    table: float64[:, :, ::1]  # (rows, columns, values): rays at pixels' centres, or first guesses


@by_reference
class Optics(NamedTuple):
    """What only some cameras have: a lens, or a projection that bends straight lines."""

    lens: Lens
    projection: Projection


@by_reference
class Camera(NamedTuple):
    """A camera over an image, in pixels: see `camera.cameras`."""

    kind: int  # of `camera.cameras`
    origin: Vector
    corner: Vector  # of the image: a direction or a point, by kind
    across: Vector  # one pixel to the right, likewise
    down: Vector
    axis: Vector  # unit vector along which depth is measured; (0, 0, 0) where depth is distance
    optics: Optics | None  # None where all rays are those of a pinhole or parallel


class Film(NamedTuple):
    """The image, and how camera samples lie in a pixel."""

    width: int
    height: int
    jitter: bool  # samples cover the pixel (box); otherwise all pass through its centre


@by_reference
class View(NamedTuple):
    """What sees the scene, and onto what."""

    camera: Camera
    film: Film


class Span(NamedTuple):
    """Consecutive items that a kernel works on: first <= item < last."""

    first: int
    last: int


class SampleBudget(NamedTuple):
    """Samples of a camera sample's irradiance, weighed against each other."""

    lights: int  # light samples
    scattered: int  # rays scattered by the surface: gather rays, or paths by its own BSDF


@by_reference
class Prepass(NamedTuple):
    """What the sampling pre-pass knows of each pixel, apart from all estimates."""

    flat: uint8[::1]  # (P,), 1 where all samples hit one smooth piece of surface of one material
    even: uint8[::1]  # (P,), 1 where it is flat, hardly curved, and without textures
    penumbra: uint8[::1]  # (P,), 1 where some light samples are blocked and some are not
    specular: uint8[::1]  # (P,), 1 where a sample hit a mirror or glass


@by_reference
class Levels(NamedTuple):
    """What a path remembers of L fluorescent surfaces: see `integrators.fluorescent_path`."""

    state: int64[::1]  # (2,): levels that are open, and 1 where there was no room for one
    row: int64[::1]  # (L,), of `Fluorescence.matrix`
    factor: float64[::1]  # (L,), concentration over the probability that the level was opened
    values: float32[:, :, ::1]  # (L, 3, N)


@by_reference
class Scratch(NamedTuple):
    """What a kernel needs for one sample of a pixel."""

    throughput: float32[::1]  # (N,), of a path
    chain: float32[::1]  # (N,), throughput of the specular chain that the camera sees by
    irradiance: float32[:, ::1]  # (2, N), or (3, N) where the scene has specular surfaces
    points: float64[:, ::1]  # (2, LANES), of the unit square, made at once
    directions: float64[:, ::1]  # (3, LANES), of gather rays
    response: float32[::1]  # (N,), values of a BSDF
    walk: float32[::1]  # (N,), throughput of a walk among facets
    emitters: float64[::1]  # (SCRATCH,), CDF of a few emitters at a surface: see `lights.selection`
    rays: int64[::1]  # (len(RAY_KINDS),) int64, rays cast so far; one through holes counts once
    shifted: float64[:, ::1]
    """(4, 11), what a camera sample would see in the neighbours of its pixel: see
    `integrators.irradiance_differences`"""
    levels: Levels


@by_reference
class Scratches(NamedTuple):
    """The scratch of a camera sample, whose `irradiance` is one of four; the rest is shared."""

    own: Scratch  # of the surface that is seen
    incident: Scratch  # of one direction, where BSDFs are not Lambertian
    scattered: Scratch  # radiance that leaves the surface beyond what Lambert's law says
    excited: Scratch
    """what excites a fluorescent surface that is not Lambertian, over π; else `own` has it"""


@by_reference
class SamplingPlan(NamedTuple):
    """How many samples each pixel gets, and how far its indirect light is shared."""

    samples: uint8[::1]  # (P,), camera samples in a pass
    lights: uint8[::1]  # (P,), light samples of each camera sample
    gathers: uint8[::1]  # (P,), gather rays of each camera sample
    sharing_radius: float32[::1]  # (P,), distance over which indirect irradiance hardly changes
    links: np.ndarray | None = None
    """(P,) uint8, bits of the neighbours that show the same flat surface: see `film.linked_pixels`;
    None where pixels share with footprints"""


@by_reference
class CacheCells(NamedTuple):
    """Surface cells of the radiosity cache: see `cache.radiosity_cache`."""

    first: int32[:, ::1]  # (T, 2), first cell of each side
    divisions: int32[::1]  # (T,), n: the triangle's side is divided into n² cells
    inverse_area: float32[:, ::1]  # (T, 2), 1 / area of one cell
    parts: int32[::1]
    """(cells,), the first of the finer² cells that a cell of one triangle is divided into, or -1;
    none are where all triangles share cells"""
    cluttered: boolean[::1]  # (cells,), whether gather rays that end here go on as paths
    crowded: boolean[::1]
    """(cells,), whether things stand within a cell's width, so that it keeps the light of those of
    its points alone that are seen from farther away; (0,) where they are not told apart"""
    finer: int


@by_reference
class RadiosityCache(NamedTuple):
    """Light that leaves surfaces diffusely, by cells; one without cells never answers."""

    cells: CacheCells
    radiosity: float32[:, ::1]  # (cells, N)
    followed: float | None = None
    """probability with which paths go on past a look-up, to correct it, see
    `integrators.cache_answer`; None where they never do, and gather rays look up too"""


@by_reference
class CausticMap(NamedTuple):
    """Photons that reached diffuse surfaces via specular ones alone, sorted by boxes of space."""

    positions: float32[:, ::1]  # (n, 6): position, and geometric normal on the side of the arrival
    arrivals: float32[:, ::1]
    """(n, 3), unit directions of arrival; (0, 3) where all BSDFs are Lambertian"""
    flux: float32[:, ::1]  # (n, N)
    edge_correction: float32[::1]
    """(n,), 1 / the part of each disk, by weight, that is surface its photon counts for"""
    starts: int32[::1]  # (H + 1,), first photon of each bucket
    radius: float  # of the disk over which photons are counted
    triangles: int32[::1]
    """(n,), where photons lie; (0,) where none is connected to the camera, nor anything lets light
    pass that photons reach"""
    barycentrics: float32[:, ::1]  # (n, 2), of the second and third corner
    connected: float
    """pixels per unit of area up to which first hits get their caustics from photons connected to
    the camera, not from disks"""


@by_reference
class CausticPhotons(NamedTuple):
    """Photons on their way into a `CausticMap`, one row each."""

    origins: float32[:, ::1]  # (n, 5): points of `EmissionGuide`, and number of the sphere
    emitted: float32[::1]  # (n,), flux as they left, summed over bands
    arrived: boolean[::1]  # (n,), whether at a diffuse surface: only then is the rest defined
    positions: float32[:, ::1]
    arrivals: float32[:, ::1]
    flux: float32[:, ::1]
    edge_correction: float32[::1]
    triangles: int32[::1]
    barycentrics: float32[:, ::1]


@by_reference
class Connections(NamedTuple):
    """Caustic photons that the camera sees, sorted by pixel."""

    starts: int32[::1]  # (P + 2,), first photon of each pixel, in `order`
    order: int32[::1]  # (n,), rows of `CausticMap`
    weights: float32[::1]  # (n,), of each row: what turns its flux into the irradiance of its pixel


@by_reference
class PhotonMaps(NamedTuple):
    """What photons of a pass leave behind for its camera rays."""

    cache: RadiosityCache
    caustics: CausticMap | None
    """None, or absent, where the scene has no specular surfaces; None for the path tracer"""


@by_reference
class EmissionGuide(NamedTuple):
    """Where, in two unit squares, caustic photons leave emitters, and what they are aimed at.

    The first square stands for emitters and the positions on them (directions, where they are
    infinitely far), the second for spheres and where they are passed. Each is divided into B × B
    boxes; the density is constant in a box.
    """

    position_rows: float64[::1]  # (B,), CDF of rows of boxes
    position_columns: float64[:, ::1]  # (B, B), and of boxes within each row
    aim_rows: float64[::1]  # (B,)
    aim_columns: float64[:, ::1]  # (B, B)
    spheres: float64[:, ::1]  # (K, 4), centre and radius; together they hold all specular surfaces
    importance: float64[::1]  # (K,), relative density of photons aimed at a sphere


@by_reference
class Pixels(NamedTuple):
    """What one pass estimates; band values are means over a pixel's samples."""

    emission: float32[:, ::1]  # (P, N)
    direct: float32[:, ::1]  # (P, N)
    indirect: float32[:, ::1]  # (P, N)
    reflectance: float32[:, ::1]  # (P, N)
    irradiance_direct: float32[:, ::1]  # (P, N)
    irradiance_indirect: float32[:, ::1]  # (P, N)
    coverage: float32[::1]  # (P,), fraction of samples that hit something
    lookups: uint8[::1]  # (P,), lookup flags: EMPTY, FOUND, TRUNCATED
    plane: float32[:, ::1]  # (P, 7), point, shading normal and flatness (0 or 1) of its samples


@by_reference
class Estimate(NamedTuple):
    """What one pass estimates of every pixel."""

    pixels: Pixels
    via_specular: np.ndarray | None
    """(5, P, N) float32, light beside that of `Pixels`: caustics that first hits reflect, and their
    irradiance there; and direct, indirect and caustic light that is not the Lambertian reflection
    of first hits: all that is seen via specular surfaces, and what other BSDFs add. (9, P, N) where
    surfaces fluoresce. None where a scene has none of these."""
    differences: np.ndarray | None = None
    """(5, P, N) float32, indirect irradiance that linked pixels share, and what a pixel's samples
    say of that of each neighbour minus its own: see `integrators.irradiance_differences`. None
    where pixels share with footprints, or not at all."""


@by_reference
class CameraPass(NamedTuple):
    """What a camera pass renders from."""

    scene: SceneArrays
    photon_maps: PhotonMaps
    eye: View  # Numba takes `.view` for NumPy's
    plan: SamplingPlan
    key: int  # of its random numbers, 64 bits
