"""What rays, passes and pixels are made of. P pixels, N bands, T triangles.

In kernels, `hit`, `surface`, `film`, `plan`, `cache`, `scratch` are these records.
"""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.core.record_types import by_reference
from photonmap.kernels.core.records import SceneArrays

DIRECT, INDIRECT, CAUSTIC = 0, 1, 2
"""Rows of a sample's irradiance, (2, N), or (3, N) where the scene has specular surfaces."""
EMPTY, FOUND, TRUNCATED = 1, 2, 4
"""Lookup flags of a pixel: a gather ray met a surface without light in its cell, or one with light;
a specular chain was truncated."""
FIRST_CAUSTIC, CAUSTIC_IRRADIANCE, VIA_DIRECT, VIA_INDIRECT, VIA_CAUSTIC = 0, 1, 2, 3, 4
"""Rows of `Estimate.via_specular`, (5, P, N)."""
RAY_KINDS = ("camera", "specular", "shadow", "gather", "walk")
"""Rays of a camera pass: to first hits, on along specular chains, to light samples and from caustic
photons to the camera, from first hits for indirect light, and on from where these end."""
CAMERA, SPECULAR, SHADOW, GATHER, WALK = range(len(RAY_KINDS))
MAX_BOUNCES = 1000
"""Bounces after which photons and paths are truncated."""
LANES = 8
"""Low-discrepancy points and directions that are made at once, by vector instructions."""


class Ray(NamedTuple):
    """A ray; its direction need not be of unit length."""

    origin: tuple
    direction: tuple


class FilmPoint(NamedTuple):
    """Where a camera sees a point in space: see `camera.cameras`."""

    x: float
    """pixels from the upper left corner of the image; it may lie beyond its edges"""
    y: float
    density: float
    """pixels of film per unit of area across the ray at the point; 0 where the camera cannot see
    it"""


class Hit(NamedTuple):
    """Where a ray meets a surface."""

    triangle: int
    """-1 where it meets none"""
    u: float
    v: float
    """barycentrics of the second and third corner"""
    distance: float
    """in lengths of the ray's direction"""


class SurfaceInteraction(NamedTuple):
    """A surface point, seen from where a ray arrived; made by `geometry.interaction`."""

    point: tuple
    """offset to the side of the arrival, ready to be a ray's origin"""
    ng: tuple
    """geometric normal on that side"""
    ns: tuple
    """shading normal; it may lean beyond the horizon of ng"""
    side: int
    """0 at the front of the triangle, 1 at its back"""
    hit: Hit
    arrival: tuple
    """direction of the ray, of any length"""
    model: int
    """of `bsdf.models`, by which directions are drawn; Lambertian until said otherwise"""


@by_reference
class Lens(NamedTuple):
    """A thin lens in front of a camera: see `camera.lens`."""

    is_open: bool
    """False for a point, through which all rays pass; the rest is then without meaning"""
    right: tuple
    """from its centre to its rim, in the kernels' unit of length"""
    up: tuple
    nearness: float
    """1 / distance along the axis at which it is focused"""
    blades: int
    """sides of its opening; 0 for a disk"""


@by_reference
class Projection(NamedTuple):
    """From pixels to directions that are no linear function of them: see `camera.projections`."""

    focal: tuple
    """pixels in a unit of the image, across and down"""
    center: tuple
    """the film point that lies on the axis"""
    distortion: tuple
    """five coefficients, of what depends on the kind"""
    reach: tuple
    """of a fisheye: the largest radius in the image, and the angle there; of a distorted image: its
    width and height, pixels"""
    table: np.ndarray
    """(rows, columns, values) float64: rays at the pixels' centres, or where to begin to look"""


@by_reference
class Optics(NamedTuple):
    """What only some cameras have: a lens, or a projection that bends straight lines."""

    lens: Lens
    projection: Projection


@by_reference
class Camera(NamedTuple):
    """A camera over an image, in pixels: see `camera.cameras`."""

    kind: int
    """of `camera.cameras`"""
    origin: tuple
    corner: tuple
    """of the image: a direction or a point, by kind"""
    across: tuple
    """one pixel to the right, likewise"""
    down: tuple
    axis: tuple
    """unit vector along which depth is measured; (0, 0, 0) where depth is distance"""
    optics: Optics | None
    """None where all rays are those of a pinhole or parallel: then none of its code is compiled"""


class Film(NamedTuple):
    """The image, and how camera samples lie in a pixel."""

    width: int
    height: int
    jitter: bool
    """samples cover the pixel (box); otherwise all pass through its centre"""


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

    lights: int
    """light samples"""
    scattered: int
    """rays scattered by the surface: gather rays, or paths that leave by its own BSDF"""


@by_reference
class Prepass(NamedTuple):
    """What the sampling pre-pass knows of each pixel, apart from all estimates."""

    flat: np.ndarray
    """(P,) uint8, 1 where all samples hit one smooth piece of surface of one material"""
    even: np.ndarray
    """(P,) uint8, 1 where it is flat, hardly curved, and without textures"""
    nearness: np.ndarray
    """(P,) float32, mean of 1 / distance to the surfaces around"""
    penumbra: np.ndarray
    """(P,) uint8, 1 where some light samples are blocked and some are not"""
    specular: np.ndarray
    """(P,) uint8, 1 where a sample hit a mirror or glass"""


class Scratch(NamedTuple):
    """What a kernel needs for one sample of a pixel."""

    throughput: np.ndarray
    """(N,) float32, of a path"""
    chain: np.ndarray
    """(N,) float32, throughput of the specular chain that the camera sees by"""
    irradiance: np.ndarray
    """(2, N) float32, or (3, N) where the scene has specular surfaces"""
    points: np.ndarray
    """(2, LANES) float64, of the unit square, made at once"""
    directions: np.ndarray
    """(3, LANES) float64, of gather rays"""
    incident: np.ndarray
    """as `irradiance`, of one direction, where BSDFs are not Lambertian"""
    scattered: np.ndarray
    """as `irradiance`: radiance that leaves a surface beyond what Lambert's law says"""
    response: np.ndarray
    """(N,) float32, values of a BSDF"""
    walk: np.ndarray
    """(N,) float32, throughput of a walk among facets"""
    emitters: np.ndarray
    """(SCRATCH,) float64, CDF of a few emitters at a surface: see `lights.selection`"""
    rays: np.ndarray
    """(len(RAY_KINDS),) int64, rays cast so far; one through holes counts once"""
    shifted: np.ndarray
    """(4, 11) float64, what a camera sample would see in the neighbours of its pixel: see
    `integrators.irradiance_differences`"""


@by_reference
class SamplingPlan(NamedTuple):
    """How many samples each pixel gets, and how far its indirect light is shared."""

    samples: np.ndarray
    """(P,) uint8, camera samples in a pass"""
    lights: np.ndarray
    """(P,) uint8, light samples of each camera sample"""
    gathers: np.ndarray
    """(P,) uint8, gather rays of each camera sample"""
    sharing_radius: np.ndarray
    """(P,) float32, distance over which indirect irradiance hardly changes"""
    links: np.ndarray | None = None
    """(P,) uint8, bits of the neighbours that show the same flat surface: see `film.linked_pixels`;
    None where pixels share with footprints"""


@by_reference
class CacheCells(NamedTuple):
    """Surface cells of the radiosity cache: see `cache.radiosity_cache`."""

    first: np.ndarray
    """(T, 2) int32, first cell of each side"""
    divisions: np.ndarray
    """(T,) int32, n: the triangle's side is divided into n² cells"""
    inverse_area: np.ndarray
    """(T, 2) float32, 1 / area of one cell"""
    parts: np.ndarray
    """(cells,) int32, the first of the finer² cells that a cell of one triangle is divided into,
    or -1; none are where all triangles share cells"""
    cluttered: np.ndarray
    """(cells,) bool, whether gather rays that end here go on as paths"""
    finer: int


@by_reference
class RadiosityCache(NamedTuple):
    """Light that leaves surfaces diffusely, by cells; one without cells never answers."""

    cells: CacheCells
    radiosity: np.ndarray
    """(cells, N) float32"""
    followed: float | None = None
    """probability with which paths go on past a look-up, to correct it: see `cache.two_level`; None
    where they never do, and gather rays look up too"""


@by_reference
class CausticMap(NamedTuple):
    """Photons that reached diffuse surfaces via specular ones alone, sorted by boxes of space."""

    positions: np.ndarray
    """(n, 6) float32: position, and geometric normal on the side of the arrival"""
    arrivals: np.ndarray
    """(n, 3) float32, unit directions of arrival; (0, 3) where all BSDFs are Lambertian"""
    flux: np.ndarray
    """(n, N) float32"""
    starts: np.ndarray
    """(H + 1,) int32, first photon of each bucket"""
    radius: float
    """of the disk over which photons are counted"""
    triangles: np.ndarray
    """(n,) int32, where photons lie; (0,) where none is connected to the camera"""
    barycentrics: np.ndarray
    """(n, 2) float32, of the second and third corner"""
    connected: float
    """pixels per unit of area up to which first hits get their caustics from photons connected to
    the camera, not from disks"""


@by_reference
class CausticPhotons(NamedTuple):
    """Photons on their way into a `CausticMap`, one row each."""

    origins: np.ndarray
    """(n, 5) float32: points of the unit squares of `EmissionGuide`, and number of the sphere"""
    emitted: np.ndarray
    """(n,) float32, flux as they left, summed over bands"""
    arrived: np.ndarray
    """(n,) bool, whether they came to a diffuse surface: only then is what follows defined"""
    positions: np.ndarray
    arrivals: np.ndarray
    flux: np.ndarray
    triangles: np.ndarray
    barycentrics: np.ndarray


@by_reference
class Connections(NamedTuple):
    """Caustic photons that the camera sees, sorted by pixel."""

    starts: np.ndarray
    """(P + 2,) int32, first photon of each pixel, in `order`"""
    order: np.ndarray
    """(n,) int32, rows of `CausticMap`"""
    weights: np.ndarray
    """(n,) float32, of each row: what turns its flux into the irradiance of its pixel"""


@by_reference
class PhotonMaps(NamedTuple):
    """What photons of a pass leave behind for its camera rays."""

    cache: RadiosityCache
    caustics: CausticMap | None
    """None where the scene has no specular surfaces; and for the path tracer"""


@by_reference
class EmissionGuide(NamedTuple):
    """Where, in two unit squares, caustic photons leave emitters, and what they are aimed at.

    The first square stands for emitters and the positions on them (directions, where they are
    infinitely far), the second for spheres and where they are passed. Each is divided into B × B
    boxes; the density is constant in a box.
    """

    position_rows: np.ndarray
    """(B,) float64, CDF of rows of boxes"""
    position_columns: np.ndarray
    """(B, B) float64, and of boxes within each row"""
    aim_rows: np.ndarray
    """(B,) float64"""
    aim_columns: np.ndarray
    """(B, B) float64"""
    spheres: np.ndarray
    """(K, 4) float64, centre and radius; together they hold all specular surfaces"""
    importance: np.ndarray
    """(K,) float64, relative density of photons aimed at a sphere"""


@by_reference
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
    lookups: np.ndarray
    """(P,) uint8, lookup flags: EMPTY, FOUND, TRUNCATED"""
    plane: np.ndarray
    """(P, 7) float32, point, shading normal and flatness (0 or 1) of a pixel's samples"""


@by_reference
class Estimate(NamedTuple):
    """What one pass estimates of every pixel."""

    pixels: Pixels
    via_specular: np.ndarray | None
    """(5, P, N) float32, light beside that of `Pixels`: caustics that first hits reflect, and their
    irradiance there; and direct, indirect and caustic light that is not the Lambertian reflection
    of first hits: all that is seen via specular surfaces, and what other BSDFs add. None where a
    scene has neither."""
    differences: np.ndarray | None = None
    """(5, P, N) float32, indirect irradiance that linked pixels share, and what a pixel's samples
    say of that of each neighbour minus its own: see `integrators.irradiance_differences`. None
    where pixels share with footprints, or not at all."""


@by_reference
class CameraPass(NamedTuple):
    """What a camera pass renders from."""

    scene: SceneArrays
    maps: PhotonMaps
    eye: View
    """Numba takes `.view` for NumPy's"""
    plan: SamplingPlan
    key: int
    """of its random numbers, 64 bits"""
