"""The scene as kernels see it. T triangles, V vertices, M materials, K emitters, N bands.

Lengths are in units of the scene's size, power in units of the lights' total: `compile_scene`
scales there, `render` scales back. What a scene lacks is None, or absent: see `record_types`.
"""

from typing import NamedTuple

from numba.types import boolean, float32, float64, int32, int64, uint8

from photonmap.kernels.core.record_types import by_reference

BYTES, SRGB, FLOATS = 0, 1, 2
"""Kinds of texels: linear bytes, sRGB bytes, linear float32; the first two are rows of a table"""
CLAMP_U, CLAMP_V, NEAREST = 1, 2, 4
"""How an image is looked up: edges go on along u, along v; without interpolation"""


@by_reference
class Maps(NamedTuple):
    """Images as surfaces use them, one row for each of R uses: see `geometry.texture`."""

    address: int64[::1]  # (R,), of the first texel
    shape: int32[:, ::1]  # (R, 3), rows, columns, and channels (1 or 3)
    kind: uint8[::1]  # (R,): BYTES, SRGB or FLOATS
    flags: uint8[::1]  # (R,), the sum of CLAMP_U, CLAMP_V, where it does not repeat, and NEAREST
    placement: float64[:, ::1]  # (R, 4), scale of u and v, then their offset
    factor: float64[:, ::1]  # (R, 3), of red, green and blue
    tables: float32[:, ::1]  # (2, 256), linear values of bytes


@by_reference
class LobeMaps(NamedTuple):
    """Glossy lobes that vary over surfaces; a scene without any has None in its place."""

    maps: Maps
    roughness: int32[::1]  # (M,), row of `maps`, -1 for none
    glossy: int32[::1]  # (M,), likewise, of the reflectance at normal incidence
    base: int32[::1]  # (M,), likewise, of the diffuse base
    anisotropy: int32[::1]  # (M,), likewise, of direction and strength along the surface
    coat: int32[::1]  # (M,), likewise, of the weight of a clear coat
    coat_roughness: int32[::1]  # (M,), likewise, of its roughness
    basis: float32[:, ::1]  # (3, N), which makes reflectances of linear RGB
    first: int32[::1]  # (M,), first row of `Scattering.albedos` of even steps of roughness
    steps: int  # number of these rows
    least: float  # smallest α


@by_reference
class Relief(NamedTuple):
    """What turns shading normals; a scene where nothing does has None in its place."""

    maps: Maps
    image: int32[::1]  # (M,), row of `maps`, -1 for none
    is_height: uint8[::1]  # (M,), 1 for derivatives of heights by u and v, 0 for directions
    strength: float64[::1]  # (M,), height of 1, or factor of directions along the surface
    tangents: float32[:, ::1]
    """(V, 4), in which u rises, for directions, 0 where the surface is flat; and the sign of
    tangents that the mesh has, 0 of those that follow from texture coordinates"""


@by_reference
class Anisotropy(NamedTuple):
    """Facets that are rougher along a tangent than across; a scene without has None instead."""

    stretch: float64[::1]
    """(M,), how far α along the tangent is on the way from what it is across to 1; 0 where it is
    the same"""
    turn: float64[:, ::1]  # (M, 2), cosine and sine of the angle from where u rises to the tangent
    first: int32[::1]
    """(M,), row of `Scattering.albedos` where those of a lobe's azimuths begin, evenly in the
    square of the sine from the tangent; before them stand, where an image gives the strength, those
    of lesser strengths, and before all the means over azimuths of each"""
    azimuths: int  # number of the rows of one strength
    strengths: int  # number of strengths of an image, evenly from 0 to that of `stretch`
    tangents: float32[:, ::1]
    """(V, 4), in which u rises, 0 where the surface is flat; and the sign of tangents that the mesh
    has, 0 of others"""


@by_reference
class Coats(NamedTuple):
    """Clear coats over other surfaces: see `bsdf.coated`. A scene without has None instead."""

    weight: float64[::1]  # (M,), fraction of the surface that is covered; 0 where there is no coat
    f0: float64[::1]  # (M,), reflectance of the coat at normal incidence
    refraction: float64[::1]  # (M,), its index of refraction
    mean_rise: float64[::1]  # (M,), cosine-weighted mean of its `core.fresnel.rise`
    alpha: float64[::1]  # (M,), its α
    row: int32[::1]  # (M,), row of `Scattering.albedos` with those of the coat
    stepped: int32[::1]  # (M,), likewise of even steps of its roughness: see `LobeMaps`
    dielectric: float64[::1]  # (M,), normal reflectance of the base's lobe, where it is no metal
    first: int32[::1]
    """(M,), row of `through` where those of the coat begin; after them, where an image gives its
    roughness, come those of coats of `LobeMaps.steps` steps of roughness"""
    steps: int32[::1]  # (M,), number of these rows, of even steps of the roughness of the base
    through: float64[:, :, ::1]
    """(R, 2, K), how a coat lets light pass from each of K - 1 angles: to what is no metal, and to
    metal; see `bsdf.coated`"""
    maps: LobeMaps | None  # None where no image gives the roughness of a coat
    own: uint8[::1]  # (M,), 1 where the normals of a coat are not those of what lies below
    relief: Relief | None  # what turns these; None where all coats lie as their bases do


@by_reference
class Sheens(NamedTuple):
    """Sheen over other surfaces: see `bsdf.sheen`. A scene without has None instead."""

    color: float32[:, ::1]  # (M, N), its reflectance; 0 where there is no sheen
    mean: float64[::1]  # (M,), the mean of that over bands
    alpha: float64[::1]  # (M,), its α
    row: int32[::1]  # (M,), row of the tables
    kept: float64[:, ::1]
    """(R, K), how much of its lobe is kept at each of K - 1 angles, lest it make light"""
    albedo: float64[:, ::1]
    """(R, K), what it reflects of light from these for a colour of 1, and the cosine-weighted mean
    over all"""
    through: float64[:, :, ::1]
    """(R, C, K), how it lets light pass to the base from each angle, for C even steps of its colour
    from 0 to 1"""
    maps: Maps | None  # None where no image gives the colour of a sheen
    image: int32[::1]  # (M,), row of `maps`, -1 for none
    basis: float32[:, ::1]  # (3, N), which makes reflectances of linear RGB


MIRROR, GLASS, METAL, THIN = 1, 2, 3, 4  # Kinds of specular surfaces; 0 is none


@by_reference
class Panes(NamedTuple):
    """Thin glass; a scene that has none has None in its place. See `geometry.pane`."""

    ior: float64[::1]  # (M,), index of refraction of the glass, 0 for other materials
    clear: float64[::1]  # (M,), what the glass transmits in every band: the least of its tint
    image: int32[::1]  # (M,), row of `maps` with the same where the tint is textured, -1 for none
    maps: Maps | None  # None where no tint is textured


@by_reference
class Alpha(NamedTuple):
    """How much of a surface is there; a scene whose surfaces are all whole has None instead."""

    value: float64[::1]  # (M,), opacity where there is no texture
    image: int32[::1]  # (M,), row of `maps`, -1 for none
    maps: Maps
    panes: Panes | None  # None where there is no thin glass


@by_reference
class Palettes(NamedTuple):
    """Images whose texels are spectra; a scene without any has None in its place."""

    address: int64[::1]  # (R,), of the first index of a row of `Maps`, int32; 0 for colours
    spectra: float32[:, ::1]  # (S, N), reflectances that indices count


@by_reference
class Textures(NamedTuple):
    """Reflectances that vary over surfaces; a scene without any has None in its place."""

    maps: Maps
    reflectance: int32[::1]  # (M,), row of `maps`, -1 for none
    basis: float32[:, ::1]  # (3, N), which makes reflectances of linear RGB
    palettes: Palettes | None  # None where all texels are colours


@by_reference
class EmissionTextures(NamedTuple):
    """Area lights whose radiance varies over them."""

    maps: Maps
    slot: int32[::1]  # (R,), which of E textures a row of `Lights.spectra` stands for, -1 for none
    image: int32[::1]  # (E,), row of `maps`
    basis: float32[:, ::1]  # (3 E, N), three rows for each, which make radiances of linear RGB
    uv: float32[:, ::1]  # (V, 2)
    triangles: int32[:, ::1]  # (T, 3)


@by_reference
class Geometry(NamedTuple):
    """All triangles of the scene, and Embree's scene over them."""

    scene: int  # address of the committed Embree scene
    vertices: float32[:, ::1]  # (V, 3)
    triangles: int32[:, ::1]  # (T, 3)
    normals: float32[:, ::1]  # (T, 3), unit geometric normal of the winding
    shading_normals: float32[:, ::1]  # (V, 3), zero rows are flat; (0, 3) in a scene without any
    material: int32[::1]  # (T,)
    emitter: int32[::1]  # (T,), -1 for a triangle that does not emit
    uv: float32[:, ::1]  # (V, 2), (0, 2) in a scene without textures
    alpha: Alpha | None  # None where all surfaces are opaque
    relief: Relief | None  # None where nothing turns shading normals
    corners: float64[:, ::1]  # (V, 3), `vertices` exactly; (0, 3) where all emitters have an area
    corner_normals: float64[:, ::1]  # (V, 3), `shading_normals` exactly; (0, 3) likewise


@by_reference
class Materials(NamedTuple):
    """What surfaces do with light."""

    reflectance: float32[:, ::1]  # (M, N), of textures the mean


@by_reference
class Dispersion(NamedTuple):
    """Glass whose index depends on wavelength; a scene without any has None in its place."""

    ior: float64[:, ::1]  # (R, N), index of refraction in each band, in this pass: one of `steps`
    steps: float64[:, :, ::1]  # (K, R, N), at K wavelengths of each band, of which passes take one
    wave: int32[::1]  # (N,), equal for bands with the same indices
    disperses: uint8[::1]  # (R,), 1 for media whose index differs between bands


@by_reference
class Media(NamedTuple):
    """What lies beside surfaces: of R media the first M are the insides of materials.

    None in a scene whose glass is clear, and lies in air.
    """

    of_side: int32[:, ::1]  # (T, 2), the medium at the front and the back of a triangle, -1 for air
    ior: float64[::1]  # (R,), index of refraction
    absorption: float32[:, ::1]  # (R, N), per unit of length; (0, N) where nothing absorbs
    dispersion: Dispersion | None  # None where nothing disperses


@by_reference
class GlassMaps(NamedTuple):
    """Glass that varies over its surface; a scene without any has None in its place."""

    maps: Maps
    tint: int32[::1]  # (M,), row of `maps`, -1 for none
    roughness: int32[::1]  # (M,), likewise
    anisotropy: int32[::1]  # (M,), likewise, of direction and strength along the surface
    basis: float32[:, ::1]  # (3, N), which makes transmittances of linear RGB
    least: float  # smallest α


@by_reference
class GlassFraction(NamedTuple):
    """Which fraction of a surface is glass, where some are so in part; else None."""

    value: float64[::1]  # (M,), 1 for what is all glass, and for mirrors and metals
    image: int32[::1]  # (M,), row of `maps`, -1 for none
    maps: Maps | None  # None where no fraction is textured


@by_reference
class Specular(NamedTuple):
    """Mirrors, mirror coats, glass, and metals that are nearly mirrors."""

    kind: uint8[::1]  # (M,): 0, MIRROR, GLASS, METAL, or THIN, a rough pane
    mirror: float32[:, ::1]  # (M, N), reflectance of the mirror, of a METAL at normal incidence
    ior: float64[::1]  # (M,), index of refraction of the inside
    tint: float32[:, ::1]
    """(M, N), what glass transmits at a crossing; of a pane, of light that it stopped"""
    probability: float64[::1]
    """(M,), with which a path takes the specular lobe rather than the diffuse one: 1 for mirrors,
    metals and what is all glass, 0 where there is no specular lobe"""
    alpha: float64[::1]
    """(M,), GGX's α of rough glass, THIN and METAL, 0 for what is smooth: see `bsdf.microsurface`;
    (0,) where all are smooth"""
    media: Media | None  # None where glass is clear, and lies in air
    dip: float32[:, :, ::1]  # (M, 4, N), of metals, as `Scattering.dip`
    maps: GlassMaps | None  # None where glass is the same all over
    glass: GlassFraction | None  # None where no surface is glass in part
    grazing: float32[:, ::1]
    """(M, N), by how many times (1 - cos)⁵ polished metals reflect more than `mirror`, and with a
    `dip` less; 0 for mirrors that reflect alike at all angles, (0, N) where all do"""
    anisotropy: Anisotropy | None
    """of rough glass, whose `alpha` is that across the tangent; None where none differs along the
    surface"""


@by_reference
class Scattering(NamedTuple):
    """Surfaces that scatter neither like Lambert's law nor specularly: see `bsdf.models`."""

    model: uint8[::1]  # (M,), which BSDF, of `bsdf.models`; 0 is Lambertian
    parameters: float64[:, ::1]  # (M, 6), of the model
    specular: float32[:, ::1]  # (M, N), reflectances of glossy surfaces at normal incidence
    albedos: float64[:, :, ::1]
    """(R, 6, K), what glossy lobes of Fresnel terms 1, `rise` and the four `dip_terms` of
    `core.fresnel` reflect of light from K - 1 angles, and the cosine-weighted mean over all: of
    each material, 0 for other models; then, where lobes are textured, of lobes of even steps of
    roughness; then of those that differ along a surface, by azimuth"""
    maps: LobeMaps | None  # None where no lobe is textured
    anisotropy: Anisotropy | None  # None where no lobe differs along a surface
    coats: Coats | None  # None where no surface has a clear coat
    dip: float32[:, :, ::1]
    """(M, 4, N), weights of the `dip_terms` by which metals reflect less than Schlick's formula
    says, see `core.fresnel`; (M, 0, 0) where none does"""
    glass: (
        GlassFraction | None
    )  # None where no surface is glass in part: the rest of it scatters so
    below: uint8[::1]  # (M,), `model` of what lies below a coat or sheen, or of what has none
    sheens: Sheens | None  # None where no surface has a sheen


@by_reference
class Fluorescence(NamedTuple):
    """Materials that re-emit light in other bands; a scene without any has None in its place."""

    row: int32[::1]  # (M,), of `matrix`, -1 for materials that do not fluoresce
    matrix: float32[:, :, ::1]
    """(R, U, U), of the U bands of a light group: what leaves in each, on the last axis, for a unit
    that arrives in one; see `bsdf.fluorescence`"""
    taken: float32[:, ::1]  # (R, N), its sum over the last axis
    concentration: float64[::1]  # (M,), factor of the matrix; the mean where an image gives it
    image: int32[::1]  # (M,), row of `maps`, -1 for none
    maps: Maps | None  # None where no concentration is textured


@by_reference
class Environment(NamedTuple):
    """The sky as a map of H rows and W columns, in 16 × 32 blocks: see `environment`."""

    texels: float32[:, :, ::1]  # (H, W, 3): linear RGB, or how much of each of three spectra
    basis: float32[:, ::1]  # (3, N), which makes radiances of RGB
    block_rows: float64[:, ::1]
    """(K + 1, 16), CDFs of the rows of blocks, by the light that they send to surfaces of each of K
    cells of normals; the last by all their light"""
    block_columns: float64[:, :, ::1]  # (K + 1, 16, 32), CDFs of the blocks in each row
    rows: float64[:, ::1]  # (32, H), CDFs of the rows of texels in each block, by their light
    columns: float64[:, ::1]  # (H, W), CDFs of the texels in each row of each block
    cosines: float64[::1]  # (H + 1,), y at the edges of the rows, from 1 to -1
    rotation: float  # of the map about +y, counter-clockwise seen from above, 1 for a full turn
    row: int  # of `Lights.spectra`: the dome's, or that of portals that show the map instead


NODE_CENTER, NODE_AXIS, NODE_RADIUS, NODE_STRENGTH = 0, 3, 6, 7
NODE_CONE, NODE_CONE_SINE, NODE_REACH = 8, 9, 10
"""Rows of a light tree's blocks, of each node: center (3) and radius of a sphere around its
emitters; axis (3) of a cone of their normals; the sum of their intensities; cosine and sine of the
cone's half angle; and the cosine of the angle to which an emitter shines from its normal"""


@by_reference
class LightTree(NamedTuple):
    """Emitters by place and direction, to choose among for a point: see `lights.selection`."""

    nodes: float64[:, :, ::1]  # (B, 11, 16), rows NODE_…: the nodes that each of B blocks has
    emitter: int32[::1]  # (15 B + 1,), of each leaf; any where its strength is 0
    leaf: int32[::1]  # (K,), of each emitter, -1 if it is infinitely far
    near: float  # probability of those in the tree, by power
    far: float64[::1]  # (K,), rises to 1 in proportion to the power of the others


@by_reference
class Profiles(NamedTuple):
    """How the intensity of emitters depends on direction, as tables over angles."""

    row: int32[::1]  # (K,), the table of each emitter, -1 for none
    frame: float64[:, :, ::1]  # (R, 3, 3), rows are the axes x, y, z of each table in the world
    intensity: float32[:, :, ::1]
    """(R, V, H), relative to the mean over all directions; V polar angles from +z to -z, H azimuths
    from +x towards +y, the last one that of the first again"""


@by_reference
class SunPortals(NamedTuple):
    """Portals that let suns in: S suns, P triangles. See `lights.portal`."""

    is_portal: boolean[::1]  # (M,)
    triangle: int32[::1]  # (P,)
    area: float64[::1]  # (P,) of the triangles
    row: int32[::1]  # (K,), of `cdf` and `extent`, -1 for emitters that are no suns
    cdf: float64[:, ::1]  # (S, P), rows rise to 1 by areas as the sun sees them, about
    extent: float64[::1]  # (S,), these areas together


@by_reference
class Lights(NamedTuple):
    """Emitters of all kinds, chosen by power, and for direct light by importance."""

    kind: uint8[::1]  # (K,), of `lights.kinds`
    triangle: int32[::1]  # (K,), -1 where the emitter is none
    position: float64[:, ::1]  # (K, 3) of lights at a point
    axis: float64[:, ::1]  # (K, 3), unit vector in which spot and directional lights shine
    parameters: float64[:, ::1]  # (K, P), a row of `Parameters` of the module of its kind
    area: float64[::1]  # (K,) of triangles
    spectrum: int32[::1]  # (K,), row of `spectra`
    spectra: float32[:, ::1]
    """(R, N): radiance, intensity (POINT …) or irradiance (DIRECTIONAL); of maps, means"""
    cdf: float64[::1]  # (K,), CDF of the emitters, in proportion to power for the most part
    in_turn: bool  # whether each is taken for direct light in a pixel: few, and none has an area
    dome: int  # index of the dome's emitter, -1 without a dome
    radius: float  # of a sphere around the origin that holds the scene
    environment: Environment | None
    """what the dome looks like; None where it is the same all around, or where there is none"""
    profiles: Profiles | None  # None where no emitter's intensity is given by a table
    emission_textures: EmissionTextures | None  # None where no emission is textured
    tree: LightTree | None  # None where emitters are few
    portals: SunPortals | None  # None where there are no portals, or no suns


@by_reference
class SceneArrays(NamedTuple):
    """The scene as kernels take it."""

    geometry: Geometry
    materials: Materials
    lights: Lights
    specular: Specular | None  # None where no surface is a mirror or glass
    textures: Textures | None  # None where no reflectance is textured
    scattering: Scattering | None  # None where all surfaces are Lambertian or specular
    fluorescence: Fluorescence | None = None  # None where no surface fluoresces
