"""The scene as kernels see it. T triangles, V vertices, M materials, K emitters, N bands.

Lengths are in units of the scene's size, power in units of the lights' total: `compile_scene`
scales there, `render` scales back. What a scene lacks is None, or absent: see `record_types`.
"""

from typing import NamedTuple

from numba.types import boolean, float32, float64, int32, int64, uint8

from photonmap.kernels.core.image_records import LobeMaps, Maps, Relief
from photonmap.kernels.core.lobe_records import Anisotropy, Coats, Sheens
from photonmap.kernels.core.record_types import by_reference

MIRROR, GLASS, METAL, THIN = 1, 2, 3, 4
"""Kinds of specular surfaces; 0 is none."""


@by_reference
class Panes(NamedTuple):
    """Thin glass; a scene that has none has None in its place. See `geometry.pane`."""

    ior: float64[::1]
    """(M,) float64, index of refraction of the glass, 0 for other materials"""
    clear: float64[::1]
    """(M,) float64, what the glass transmits in every band: the least of its tint"""
    image: int32[::1]
    """(M,) int32, row of `maps` with the same where the tint is textured, -1 for none"""
    maps: Maps | None
    """None where no tint is textured"""


@by_reference
class Alpha(NamedTuple):
    """How much of a surface is there; a scene whose surfaces are all whole has None instead."""

    value: float64[::1]
    """(M,) float64, opacity where there is no texture"""
    image: int32[::1]
    """(M,) int32, row of `maps`, -1 for none"""
    maps: Maps
    panes: Panes | None
    """None where there is no thin glass"""


@by_reference
class Palettes(NamedTuple):
    """Images whose texels are spectra; a scene without any has None in its place."""

    address: int64[::1]
    """(R,) int64, of the first index of a row of `Maps`, int32; 0 where texels are colours"""
    spectra: float32[:, ::1]
    """(S, N) float32, reflectances that indices count"""


@by_reference
class Textures(NamedTuple):
    """Reflectances that vary over surfaces; a scene without any has None in its place."""

    maps: Maps
    reflectance: int32[::1]
    """(M,) int32, row of `maps`, -1 for none"""
    basis: float32[:, ::1]
    """(3, N) float32, which makes reflectances of linear RGB"""
    palettes: Palettes | None
    """None where all texels are colours"""


@by_reference
class EmissionTextures(NamedTuple):
    """Area lights whose radiance varies over them."""

    maps: Maps
    slot: int32[::1]
    """(R,) int32, which of E textures a row of `Lights.spectra` stands for, -1 for none"""
    image: int32[::1]
    """(E,) int32, row of `maps`"""
    basis: float32[:, ::1]
    """(3 E, N) float32, three rows for each, which make radiances of linear RGB"""
    uv: float32[:, ::1]
    """(V, 2) float32"""
    triangles: int32[:, ::1]
    """(T, 3) int32"""


@by_reference
class Geometry(NamedTuple):
    """All triangles of the scene, and Embree's scene over them."""

    scene: int
    """address of the committed Embree scene"""
    vertices: float32[:, ::1]
    """(V, 3) float32"""
    triangles: int32[:, ::1]
    """(T, 3) int32"""
    normals: float32[:, ::1]
    """(T, 3) float32, unit geometric normal of the winding"""
    shading_normals: float32[:, ::1]
    """(V, 3) float32, zero rows are flat; (0, 3) in a scene without any"""
    material: int32[::1]
    """(T,) int32"""
    emitter: int32[::1]
    """(T,) int32, -1 for a triangle that does not emit"""
    uv: float32[:, ::1]
    """(V, 2) float32, (0, 2) in a scene without textures"""
    alpha: Alpha | None
    """None where all surfaces are opaque"""
    relief: Relief | None
    """None where nothing turns shading normals"""


@by_reference
class Materials(NamedTuple):
    """What surfaces do with light."""

    reflectance: float32[:, ::1]
    """(M, N) float32, of textures the mean"""


@by_reference
class Dispersion(NamedTuple):
    """Glass whose index depends on wavelength; a scene without any has None in its place."""

    ior: float64[:, ::1]
    """(R, N) float64, index of refraction in each band, in this pass: one of `steps`"""
    steps: float64[:, :, ::1]
    """(K, R, N) float64, the same at K wavelengths of each band, of which passes take one"""
    wave: int32[::1]
    """(N,) int32, equal for bands with the same indices"""
    disperses: uint8[::1]
    """(R,) uint8, 1 for media whose index differs between bands"""


@by_reference
class Media(NamedTuple):
    """What lies beside surfaces: of R media the first M are the insides of materials.

    None in a scene whose glass is clear, and lies in air.
    """

    of_side: int32[:, ::1]
    """(T, 2) int32, the medium at the front and at the back of a triangle, -1 for air"""
    ior: float64[::1]
    """(R,) float64, index of refraction"""
    absorption: float32[:, ::1]
    """(R, N) float32, coefficient in the inverse unit of length; (0, N) where nothing absorbs"""
    dispersion: Dispersion | None
    """None where nothing disperses"""


@by_reference
class GlassMaps(NamedTuple):
    """Glass that varies over its surface; a scene without any has None in its place."""

    maps: Maps
    tint: int32[::1]
    """(M,) int32, row of `maps`, -1 for none"""
    roughness: int32[::1]
    """(M,) int32, likewise"""
    anisotropy: int32[::1]
    """(M,) int32, likewise, of direction and strength along the surface"""
    basis: float32[:, ::1]
    """(3, N) float32, which makes transmittances of linear RGB"""
    least: float
    """smallest α"""


@by_reference
class GlassShare(NamedTuple):
    """Which fraction of a surface is glass, where some are so in part; else None."""

    value: float64[::1]
    """(M,) float64, 1 for what is all glass, and for mirrors and metals"""
    image: int32[::1]
    """(M,) int32, row of `maps`, -1 for none"""
    maps: Maps | None
    """None where no fraction is textured"""


@by_reference
class Specular(NamedTuple):
    """Mirrors, mirror coats, glass, and metals that are nearly mirrors."""

    kind: uint8[::1]
    """(M,) uint8: 0, MIRROR, GLASS, METAL, or THIN, a rough pane"""
    mirror: float32[:, ::1]
    """(M, N) float32, reflectance of the mirror, of a METAL at normal incidence"""
    ior: float64[::1]
    """(M,) float64, index of refraction of the inside"""
    tint: float32[:, ::1]
    """(M, N) float32, what glass transmits at a crossing; of a pane, of light that it stopped"""
    probability: float64[::1]
    """(M,) float64, with which a path takes the specular lobe rather than the diffuse one: 1 for
    mirrors, metals and what is all glass, 0 where there is no specular lobe"""
    alpha: float64[::1]
    """(M,) float64, GGX's α of rough glass, THIN and METAL, 0 for what is smooth: see
    `bsdf.microsurface`; (0,) where all are smooth"""
    media: Media | None
    """None where glass is clear, and lies in air"""
    dip: float32[:, :, ::1]
    """(M, 4, N) float32, of metals, as `Scattering.dip`"""
    maps: GlassMaps | None
    """None where glass is the same all over"""
    share: GlassShare | None
    """None where no surface is glass in part"""
    grazing: float32[:, ::1]
    """(M, N) float32, by how many times (1 - cos)⁵ polished metals reflect more than `mirror`, and
    with a `dip` less; 0 for mirrors that reflect alike at all angles, (0, N) where all do"""
    anisotropy: Anisotropy | None
    """of rough glass, whose `alpha` is that across the tangent; None where none differs along the
    surface"""


@by_reference
class Scattering(NamedTuple):
    """Surfaces that scatter neither like Lambert's law nor specularly: see `bsdf.models`."""

    model: uint8[::1]
    """(M,) uint8, which BSDF, of `bsdf.models`; 0 is Lambertian"""
    parameters: float64[:, ::1]
    """(M, 5) float64, of the model"""
    specular: float32[:, ::1]
    """(M, N) float32, reflectances of glossy surfaces at normal incidence"""
    albedos: float64[:, :, ::1]
    """(R, 6, K) float64, what glossy lobes of Fresnel terms 1, `rise` and the four `dip_terms` of
    `core.fresnel` reflect of light from K - 1 angles, and the cosine-weighted mean over all: of
    each material, 0 for other models; then, where lobes are textured, of lobes of even steps of
    roughness; then of those that differ along a surface, by azimuth"""
    maps: LobeMaps | None
    """None where no lobe is textured"""
    anisotropy: Anisotropy | None
    """None where no lobe differs along a surface"""
    coats: Coats | None
    """None where no surface has a clear coat"""
    dip: float32[:, :, ::1]
    """(M, 4, N) float32, weights of the `dip_terms` by which metals reflect less than Schlick's
    formula says, see `core.fresnel`; (M, 0, 0) where none does"""
    share: GlassShare | None
    """None where no surface is glass in part: the rest of it scatters so"""
    below: uint8[::1]
    """(M,) uint8, `model` of what lies below a coat or sheen, or of what has none"""
    sheens: Sheens | None
    """None where no surface has a sheen"""


@by_reference
class Environment(NamedTuple):
    """The sky as a map of H rows and W columns, in 16 × 32 blocks: see `environment`."""

    texels: float32[:, :, ::1]
    """(H, W, 3) float32: linear RGB, or how much of each of three spectra"""
    basis: float32[:, ::1]
    """(3, N) float32, which makes radiances of RGB"""
    block_rows: float64[:, ::1]
    """(K + 1, 16) float64, CDFs of the rows of blocks, by the light that they send to surfaces of
    each of K cells of normals; the last by all their light"""
    block_columns: float64[:, :, ::1]
    """(K + 1, 16, 32) float64, CDFs of the blocks in each row"""
    rows: float64[:, ::1]
    """(32, H) float64, CDFs of the rows of texels in each block, by their light"""
    columns: float64[:, ::1]
    """(H, W) float64, CDFs of the texels in each row of each block"""
    cosines: float64[::1]
    """(H + 1,) float64, y at the edges of the rows, from 1 to -1"""
    rotation: float
    """of the map about +y, counter-clockwise seen from above, 1 for a full turn"""
    row: int
    """of `Lights.spectra`, that of the dome, or of the portals that show the map in its place"""


NODE_CENTER, NODE_AXIS, NODE_RADIUS, NODE_STRENGTH = 0, 3, 6, 7
NODE_CONE, NODE_CONE_SINE, NODE_REACH = 8, 9, 10
"""Rows of a light tree's blocks, of each node: center (3) and radius of a sphere around its
emitters; axis (3) of a cone of their normals; the sum of their intensities; cosine and sine of the
cone's half angle; and the cosine of the angle to which an emitter shines from its normal."""


@by_reference
class LightTree(NamedTuple):
    """Emitters by place and direction, to choose among for a point: see `light_tree`."""

    nodes: float64[:, :, ::1]
    """(B, 11, 16) float64, rows NODE_…: the nodes that each of B blocks chooses among"""
    emitter: int32[::1]
    """(15 B + 1,) int32, of each leaf; any where its strength is 0"""
    leaf: int32[::1]
    """(K,) int32, of each emitter, -1 if it is infinitely far"""
    near: float
    """probability of those in the tree, by power"""
    far: float64[::1]
    """(K,) float64, rises to 1 in proportion to the power of the others"""


@by_reference
class Profiles(NamedTuple):
    """How the intensity of emitters depends on direction, as tables over angles."""

    row: int32[::1]
    """(K,) int32, the table of each emitter, -1 for none"""
    frame: float64[:, :, ::1]
    """(R, 3, 3) float64, rows are the axes x, y, z of each table in the world"""
    intensity: float32[:, :, ::1]
    """(R, V, H) float32, relative to the mean over all directions; V polar angles from +z to -z,
    H azimuths from +x towards +y, the last one that of the first again"""


@by_reference
class SunPortals(NamedTuple):
    """Portals that let suns in: S suns, P triangles. See `lights.portal`."""

    is_portal: boolean[::1]
    """(M,) bool"""
    triangle: int32[::1]
    """(P,) int32"""
    area: float64[::1]
    """(P,) float64 of the triangles"""
    row: int32[::1]
    """(K,) int32, of `cdf` and `extent`, -1 for emitters that are no suns"""
    cdf: float64[:, ::1]
    """(S, P) float64, each row rises to 1 in proportion to areas as the sun sees them, about"""
    extent: float64[::1]
    """(S,) float64, these areas together"""


@by_reference
class Lights(NamedTuple):
    """Emitters of all kinds, chosen by power, and for direct light by importance."""

    kind: uint8[::1]
    """(K,) uint8, of `lights.kinds`"""
    triangle: int32[::1]
    """(K,) int32, -1 where the emitter is none"""
    position: float64[:, ::1]
    """(K, 3) float64 of lights at a point"""
    axis: float64[:, ::1]
    """(K, 3) float64, unit vector in which spot and directional lights shine"""
    parameters: float64[:, ::1]
    """(K, P) float64 that its kind has beside: a row of `Parameters` of its module"""
    area: float64[::1]
    """(K,) float64 of triangles"""
    spectrum: int32[::1]
    """(K,) int32, row of `spectra`"""
    spectra: float32[:, ::1]
    """(R, N) float32: radiance, intensity (POINT …) or irradiance (DIRECTIONAL); of maps, means"""
    cdf: float64[::1]
    """(K,) float64, CDF of the emitters, in proportion to power for the most part"""
    dome: int
    """index of the dome's emitter, -1 without a dome"""
    radius: float
    """of a sphere around the origin that holds the scene"""
    environment: Environment | None
    """what the dome looks like; None where it is the same all around, or where there is none"""
    profiles: Profiles | None
    """None where no emitter's intensity is given by a table"""
    emission_textures: EmissionTextures | None
    """None where no emission is textured"""
    tree: LightTree | None
    """None where emitters are few"""
    portals: SunPortals | None
    """None where there are no portals, or no suns"""


@by_reference
class SceneArrays(NamedTuple):
    """The scene as kernels take it."""

    geometry: Geometry
    materials: Materials
    lights: Lights
    specular: Specular | None
    """None where no surface is a mirror or glass"""
    textures: Textures | None
    """None where no reflectance is textured"""
    scattering: Scattering | None
    """None where all surfaces are Lambertian or specular"""
