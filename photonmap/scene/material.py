"""Materials: how a surface reflects, transmits and emits.

Each attribute is declared once, in its annotation; one that asks for a lobe has it there, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property, partial
from types import NoneType
from typing import Annotated, Literal, Self

import numpy as np

from photonmap.errors import naming
from photonmap.scene.parameters import (
    Emission,
    Flag,
    Fluorescent,
    Number,
    Part,
    Reflectance,
    declared,
    finite,
    parameters_of,
    vector,
)
from photonmap.scene.surfaces.dispersion import LINES, Cauchy, NamedGlass, Sellmeier, abbe_number
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.metallic import FRACTION, metallic_gloss
from photonmap.scene.surfaces.relief import AnisotropyMap, BumpMap, NoRelief, NormalMap
from photonmap.scene.textures import Paint, Texture, is_black, mean_number
from photonmap.spectra.curves import Color, Spectrum
from photonmap.spectra.fluorescence import Fluorophore
from photonmap.spectra.metals import Metal

LEAST_ALPHA = 1e-3  # Smallest α of GGX; smoother surfaces are mirrors
NARROW_ALPHA = 0.1
"""α below which specular chains follow bare metal, as they follow mirrors: light samples and gather
rays seldom meet its lobe. Variance times processor time were as 1 to 4.1 at α 0.01, to 2.2 at 0.05,
to 1.2 at 0.1, and to 0.95 at 0.15 (Cornell box with a ball of metal)."""
_COLOR = Reflectance("reflectance")
_Layer = partial(Reflectance, "reflectance", only="opaque")
_Paint = partial(_Layer, textured=True)
_Fraction = partial(Number, at_least=0.0, at_most=1.0)
_Textured = partial(_Fraction, textured=True)


@dataclass(frozen=True)
class Lobe:
    """A way in which surfaces scatter beside Lambert's law, declared with what asks for it."""

    level: Literal[0, 1, 2]
    """0 for glass and a diffuse base, 1 for what reflects over that, 2 for a cover of both"""
    over: str = "{}"  # its name over what `{}` stands for
    alone: str = ""  # its name over black
    parameters: tuple[str, ...] = ()  # attributes that have no effect without it
    without: str = ""  # what a material lacks that has these alone, and what to do
    clashes: Mapping[str, str] = field(default_factory=dict)
    """attributes of lobes that it cannot have below or beside it, with what to do"""
    model: str = ""
    """the BSDF's name in `kernels.bsdf.models`; none for glass, mirrors and covers. Covers lie over
    those of `photonmap.compile.surfaces.white_bases`"""
    numbers: tuple[str, ...] = ()
    """attributes of the material that are the BSDF's parameters; the lobe's by default"""
    is_beside_glass: bool = False  # whether a surface may have it that is glass in part


_LAMBERT = "only a Lambertian base lies below; set diffuse_roughness to 0, or leave out"
_METAL = "for metal below it give glossy in place of mirror"
_GLASS = "glass has none; leave out ior, or"
_GLOSSY = Lobe(
    1,
    "gloss over {}",
    "metal",
    ("roughness", "anisotropy", "glossy_edge"),
    "what is not glossy; add glossy = 0.04 for plastic, or glossy = 'metal:Au'",
    {
        "mirror": "set mirror to 0; a glossy of roughness 0 over reflectance 0 is a mirror",
        "diffuse_roughness": f"{_LAMBERT} glossy",
    },
    model="glossy",
    numbers=("lobe_alpha",),
    is_beside_glass=True,
)
_COAT = Lobe(
    2,
    "coated {}",
    "coated black",
    ("coat_roughness", "coat_ior", "coat_relief"),
    "what has no coat; add coat = 1",
    {"ior": f"{_GLASS} coat", "mirror": _METAL, "diffuse_roughness": f"{_LAMBERT} coat"},
)
_SHEEN = Lobe(
    2,
    "sheen over {}",
    "sheen over black",
    ("sheen_roughness",),
    "what has no sheen; add sheen = 0.5",
    {
        "ior": f"{_GLASS} sheen",
        "mirror": _METAL,
        "coat": "one of them lies on top; for a shine below a sheen give glossy, not coat",
    },
)


@dataclass(frozen=True)
class Material:
    """A surface, the same on both sides, that may also emit from its front.

    It reflects diffusely, like a mirror, or both; with an index of refraction it is glass, smooth
    or rough, whose closed mesh, wound outwards, separates the inside from air, or a thin pane.

    Parameters
    ----------
    name : used in warnings and records
    reflectance : diffuse albedo in [0, 1]; glass has none
    emission : radiance leaving the front (counter-clockwise) side, W·m⁻²·sr⁻¹
    portal : whether its front shows the sky or dome, whose light, and that of suns, then comes
        through portals alone
    mirror : reflectance of a mirror, alone or as a coat; with `reflectance` 1 at most; alike at all
        angles, but for a bare metal by name
    ior : index of refraction of the inside relative to air; None for anything but glass. Below 1
        it is relative to what is around
    outside : index of refraction of what is around glass, where no body of glass is; 1 for air
    abbe : Abbe number of glass whose index depends on wavelength; `ior` is that at 587.6 nm
    dispersion : in place of it a `Cauchy`, a `Sellmeier` or a `NamedGlass`, which give `ior`, too
    priority : of bodies of glass that overlap, the one of the highest claims what they share; of
        equal ones the smaller body
    tint : transmittance of glass at each crossing of its surface, in [0, 1]; of thin glass, beside
        what its two surfaces reflect
    transmission : fraction of a surface with an `ior` that is glass, in [0, 1]; the rest reflects
        as `reflectance` and `glossy` say
    attenuation_color, attenuation_distance : what solid glass transmits along so many scene units
        inside, in [0, 1]; more along less, by the Beer–Lambert law
    thin : of glass, whether the mesh is a pane that light passes straight on, not the surface of a
        body: a window, a bubble, a lampshade
    alpha : opacity in [0, 1]: the probability that a ray does not pass straight through
    glossy : reflectance of a glossy surface at normal incidence: of a bare metal, where
        `reflectance` is 0, or of a coat over it; with a `roughness`
    glossy_edge : reflectance of the glossy surface at an angle of 82°, where metals reflect least
        compared with Schlick's formula; None for what the metal's index says, where `glossy` is one
        by name, and for what the formula says of others
    covering : reflectance at normal incidence of what lies over the diffuse base of a glossy
        surface that is bare metal in part; None where all of `glossy` does
    roughness : of the glossy reflection, or of glass, in [0, 1], as in glTF: GGX's α is its square,
        at least 1e-3 (see `kernels.bsdf.glossy` and `kernels.bsdf.microsurface`); even glass and
        bare metal of roughness 0 are smooth
    anisotropy, anisotropy_rotation : how much rougher a glossy surface, or glass, is along a
        tangent than across it, in [0, 1] as in glTF: there α is its square of the way from what it
        is across to 1. The tangent points to where u rises, turned counter-clockwise by so many
        turns; without texture coordinates it goes around the y axis
    anisotropy_map : an `AnisotropyMap`, whose strengths multiply `anisotropy`, and whose directions
        turn the tangent
    coat : fraction in [0, 1] of a surface that a clear coat covers: a colourless layer over what is
        diffuse or glossy, which reflects by itself and takes from its base what it reflects (see
        `kernels.bsdf.coated`)
    coat_roughness, coat_ior : of the coat, like `roughness`, and its index of refraction
    coat_relief : a `NormalMap` or a `BumpMap` of the coat, or `NoRelief` for one that is smooth
        over what has a `relief`; None where it follows that
    sheen : reflectance of the fibres of a cloth in [0, 1], which shine at grazing angles, over what
        is diffuse or glossy, which gets what they let pass (see `kernels.bsdf.sheen`)
    sheen_roughness : of the fibres, from 0 (a thin rim) to 1 (a broad glow), as in glTF: α of
        Charlie is its square, at least 0.01
    diffuse_roughness : of the diffuse reflection in [0, 1], 0 for Lambert's law (energy-preserving
        Oren–Nayar, see `kernels.bsdf.rough_diffuse`)
    fluorescence : a `Fluorescence`, a `DonaldsonMatrix` or a tuple of these: what a diffuse surface
        takes up and sends out at other wavelengths, alike in all directions, beside its reflectance
    fluorescence_concentration : in [0, 1], multiplies what the fluorescence sends out
    relief : a `NormalMap` or a `BumpMap`, which turns shading normals (see
        `kernels.geometry.relief`); None for a surface without

    A colour is a number (a constant spectrum), a linear RGB triple, or a `Spectrum`; reflectance,
    emission, alpha, glossy, roughness, coat, coat_roughness, sheen, tint, transmission and
    fluorescence_concentration may be a `Texture`. Annotations declare ranges and the keys of TOML
    and MTL files, which checks, readers and writers follow (`photonmap.scene.parameters`). Class
    methods make usual materials.
    """

    name: str = "grey"
    reflectance: Annotated[Paint, _Paint(mtl="Kd")] = 0.5
    emission: Annotated[Paint, Emission("radiance", "W·m⁻²·sr⁻¹", mtl="Ke", textured=True)] = 0.0
    mirror: Annotated[Color, _Layer(mtl="Ks"), Lobe(1, "mirror over {}", "mirror")] = 0.0
    ior: Annotated[
        float | None,
        Number("index of refraction", mtl="Ni", above=0.0, such_as="1.5"),
        Lobe(0, parameters=("roughness", "anisotropy")),
    ] = None
    tint: Annotated[Paint, Reflectance("transmittance", mtl="Tf", textured=True, only="glass")] = (
        1.0
    )
    transmission: Annotated[
        float | Texture, _Textured("fraction", mtl="transmission", only="glass")
    ] = 1.0
    attenuation_color: Annotated[
        Color, Reflectance("transmittance", mtl="attenuation_color", only="glass")
    ] = 1.0
    attenuation_distance: Annotated[
        float | None,
        Number("distance", "scene units", mtl="attenuation_distance", only="glass", above=0.0),
    ] = None
    thin: Annotated[bool, Flag(mtl="thin", only="glass")] = False
    alpha: Annotated[float | Texture, _Textured("opacity", mtl="d")] = 1.0
    diffuse_roughness: Annotated[
        float,
        Number("roughness", mtl="diffuse_roughness", only="opaque", at_least=0.0, at_most=1.0),
        Lobe(0, "rough {}", "black", model="rough diffuse"),
    ] = 0.0

    glossy: Annotated[Paint, _Paint(mtl="glossy"), _GLOSSY] = 0.0
    glossy_edge: Annotated[Color | None, _Layer(mtl="glossy_edge")] = None
    covering: Annotated[
        float | None, Number("reflectance", mtl="covering", at_least=0.0, at_most=1.0)
    ] = None
    roughness: Annotated[float | Texture, _Textured("roughness", mtl="roughness")] = 0.0

    coat: Annotated[float | Texture, _Textured("weight", mtl="Pc", only="opaque"), _COAT] = 0.0
    coat_roughness: Annotated[float | Texture, _Textured("roughness", mtl="Pcr", only="opaque")] = (
        0.0
    )
    coat_ior: Annotated[
        float,
        Number("index of refraction", mtl="coat_ior", only="opaque", at_least=1.0, such_as="1.5"),
    ] = 1.5

    sheen: Annotated[Paint, _Paint(mtl="Ps"), _SHEEN] = 0.0
    sheen_roughness: Annotated[
        float, _Fraction("roughness", mtl="sheen_roughness", only="opaque")
    ] = 0.5

    relief: Annotated[NormalMap | BumpMap | None, Part.of("relief", NormalMap, BumpMap)] = None
    coat_relief: Annotated[
        NormalMap | BumpMap | NoRelief | None, Part.of("relief", NormalMap, BumpMap, NoRelief)
    ] = None
    anisotropy: Annotated[float, _Fraction("anisotropy", mtl="aniso")] = 0.0
    anisotropy_rotation: Annotated[
        float, Number("rotation", "turns", mtl="anisor", at_least=-1.0, at_most=1.0)
    ] = 0.0
    anisotropy_map: Annotated[AnisotropyMap | None, Part.of("anisotropy map", AnisotropyMap)] = None
    outside: Annotated[
        float, Number("index of refraction", mtl="outside", only="glass", above=0.0)
    ] = 1.0
    priority: Annotated[float, Number("priority", mtl="priority", only="glass")] = 0.0
    abbe: Annotated[
        float | None, Number("Abbe number", mtl="abbe", only="glass", above=0.0, such_as="64")
    ] = None
    dispersion: Annotated[
        Cauchy | Sellmeier | NamedGlass | None, Part.of("dispersion", Cauchy, Sellmeier, NamedGlass)
    ] = None
    portal: Annotated[bool, Flag(mtl="portal")] = False
    fluorescence: Annotated[
        Fluorophore | tuple[Fluorophore, ...] | None, Fluorescent(only="opaque")
    ] = None
    fluorescence_concentration: Annotated[
        float | Texture,
        _Textured("concentration", mtl="fluorescence_concentration", only="opaque"),
    ] = 1.0

    def __post_init__(self) -> None:
        """Take the index from the dispersion where it is not given."""
        curve = self.dispersion
        if curve is not None and self.ior is None and not curve.find_conflict():
            object.__setattr__(self, "ior", float(curve.index(LINES[0])))

    def __repr__(self) -> str:
        """Return the name, and what differs from the defaults."""
        parts = []
        for each in fields(self):
            value = getattr(self, each.name)
            if not isinstance(value, float | int | str | NoneType) or value != each.default:
                parts.append(f"{each.name}={value!r}")
        return f"Material({', '.join(parts)})"

    @classmethod
    def polished(cls, name: str = "mirror", mirror: Color = 1.0) -> Self:
        """Return a perfect mirror of this reflectance."""
        return cls(name, 0.0, mirror=mirror)

    @classmethod
    def metal(
        cls, name: str = "metal", glossy: Paint = 0.9, roughness: float | Texture = 0.3
    ) -> Self:
        """Return a rough metal of this reflectance at normal incidence."""
        return cls(name, 0.0, glossy=glossy, roughness=roughness)

    @classmethod
    def plastic(
        cls,
        name: str = "plastic",
        reflectance: Paint = 0.5,
        ior: float = 1.5,
        roughness: float | Texture = 0.3,
    ) -> Self:
        """Return a diffuse base below a rough coat of this index of refraction, at least 1."""
        return cls(name, reflectance, glossy=_reflected(name, ior), roughness=roughness)

    @classmethod
    def glass(
        cls, name: str = "glass", ior: float = 1.5, tint: Color = 1.0, roughness: float = 0.0
    ) -> Self:
        """Return glass, smooth or rough."""
        return cls(name, 0.0, ior=ior, tint=tint, roughness=roughness)

    @classmethod
    def pane(
        cls, name: str = "pane", ior: float = 1.5, tint: Color = 1.0, roughness: float = 0.0
    ) -> Self:
        """Return thin glass, smooth or frosted."""
        return cls(name, 0.0, ior=ior, tint=tint, roughness=roughness, thin=True)

    @classmethod
    def metallic_roughness(
        cls,
        name: str = "metallic",
        base_color: Paint = 0.5,
        metallic: float | Texture = 0.0,
        roughness: float | Texture = 0.5,
        ior: float = 1.5,
    ) -> Self:
        """Return a metal in part, as glTF's factors and `metallic` in TOML files make it.

        Parameters
        ----------
        name : of the material
        base_color : reflectance of the metal at normal incidence, and diffuse albedo of the rest
        metallic : which fraction is metal, in [0, 1]; an image lies like that of the base colour
        roughness : of the metal, and of the coat of the rest
        ior : index of refraction of that coat, at least 1

        Raises
        ------
        InputError : a number is out of range, or the base colour is none or has a spectrum in every
            texel
        """
        coat = _reflected(name, ior)
        with naming(f"material {name!r}: base_color"):
            base = _plain(base_color)
        with naming(f"material {name!r}: metallic"):
            share = metallic if isinstance(metallic, Texture) else FRACTION.check(metallic)
            gloss = metallic_gloss(base, share, coat, roughness)
        return cls(name, **gloss._asdict())

    def takes(self, attribute: str) -> bool:
        """Return whether an attribute matters to a material of its kind."""
        only = parameters_of(Material)[attribute].only
        if only == "glass" or self.ior is None:
            return only != "glass" or self.ior is not None
        is_beside = attribute in BESIDE_GLASS and not self.is_all_glass
        return only != "opaque" or is_beside

    def has(self, lobe: str) -> bool:
        """Return whether it has a lobe, one of the attributes that `LOBES` lists."""
        asked = getattr(self, lobe)
        return asked is not None and not is_black(asked)

    @property
    def is_textured(self) -> bool:
        """Whether a texture lies on it."""
        painted = (
            name
            for name, each in parameters_of(Material).items()
            if each.textured and isinstance(getattr(self, name), Texture)
        )
        is_painted = any(name != "coat_roughness" or self.is_coated for name in painted)
        is_turned = self.relief is not None or self.own_coat_relief is not None
        return is_painted or is_turned or self.is_brushed

    @cached_property
    def uses_uv(self) -> bool:
        """Whether texture coordinates matter to it."""
        return self.is_textured or self.is_anisotropic

    @property
    def is_anisotropic(self) -> bool:
        """Whether its glossy lobe, or its glass, differs along the surface."""
        return self.anisotropy > 0.0 and (self.is_glossy or self._bends)

    @property
    def is_brushed(self) -> bool:
        """Whether an image says how it differs along the surface."""
        return self.is_anisotropic and self.anisotropy_map is not None

    @property
    def has_textured_lobe(self) -> bool:
        """Whether the reflectance or the roughness of its glossy lobe is a texture."""
        return isinstance(self.glossy, Texture) or isinstance(self.roughness, Texture)

    @property
    def is_all_glass(self) -> bool:
        """Whether all of it is glass."""
        whole = not isinstance(self.transmission, Texture) and self.transmission == 1.0
        return self.ior is not None and whole

    @property
    def nearest_abbe(self) -> float | None:
        """The Abbe number of its dispersion, of whatever kind; None where it has none."""
        return self.abbe if self.dispersion is None else abbe_number(self.dispersion.index)

    @property
    def is_glossy(self) -> bool:
        """Whether it has a glossy lobe."""
        return self.has("glossy")

    @property
    def edge(self) -> Color | None:
        """What metal reflects at 82°; None where that follows from Schlick's formula."""
        if self.glossy_edge is None and self.is_metal_mirror:
            return self.mirror.edge  # type: ignore[union-attr]
        if self.glossy_edge is None and isinstance(self.glossy, Metal):
            return self.glossy.edge
        return self.glossy_edge

    @property
    def is_coated(self) -> bool:
        """Whether it has a clear coat."""
        return self.has("coat")

    @property
    def has_sheen(self) -> bool:
        """Whether it has a sheen."""
        return self.has("sheen")

    @property
    def is_covered(self) -> bool:
        """Whether a clear coat or a sheen lies over it."""
        return any(lobe.level == 2 and self.has(name) for name, lobe in LOBES.items())

    @property
    def has_textured_coat(self) -> bool:
        """Whether an image gives the roughness of a clear coat."""
        return self.is_coated and isinstance(self.coat_roughness, Texture)

    @property
    def own_coat_relief(self) -> NormalMap | BumpMap | NoRelief | None:
        """The relief of its coat, where that is another than its own."""
        is_bare = self.relief is None and isinstance(self.coat_relief, NoRelief)
        return None if is_bare or not self.is_coated else self.coat_relief

    @property
    def chain_alpha(self) -> float:
        """GGX's α of a surface that specular chains pass; 0 where it is smooth, or for others."""
        is_glass = self._bends and (mean_number(self.roughness) > 0.0 or self.anisotropy > 0.0)
        is_metal = self.is_narrow_metal and not self.is_polished_metal
        return self.lobe_alpha if is_glass or is_metal else 0.0

    @property
    def is_pane(self) -> bool:
        """Whether it is smooth thin glass, or as good as air: light passes it straight on."""
        return self.thin and self.chain_alpha == 0.0

    @property
    def _bends(self) -> bool:
        """Whether it is glass; that of the index of air lets light pass, however rough it is."""
        return self.ior not in (None, 1.0)

    @property
    def lobe_alpha(self) -> float:
        """GGX's α of its glossy lobe, or of its glass."""
        return max(mean_number(self.roughness) ** 2, LEAST_ALPHA)

    @property
    def is_narrow_metal(self) -> bool:
        """Whether it is bare metal whose lobe is so narrow that specular chains follow it."""
        if not self.is_glossy or self.has_textured_lobe or self.is_anisotropic or self.is_covered:
            return False
        return self._is_bare and self.lobe_alpha < NARROW_ALPHA

    @property
    def is_metal_mirror(self) -> bool:
        """Whether it is a mirror of a metal by name, which reflects as the metal's index says."""
        return isinstance(self.mirror, Metal) and self._is_bare

    @property
    def is_polished_metal(self) -> bool:
        """Whether it is a mirror that reflects as metals do, more at grazing angles."""
        return self.is_metal_mirror or (self.is_narrow_metal and self.roughness == 0.0)

    @property
    def _is_bare(self) -> bool:
        """Whether it is no glass, and nothing of it is diffuse."""
        diffuse = isinstance(self.reflectance, Spectrum | Texture) or np.any(self.reflectance)
        return self.ior is None and self.fluorescence is None and not diffuse

    @property
    def scattering(self) -> tuple[str, tuple[float, ...]] | None:
        """The BSDF model of what is not specular, and its parameters; None for Lambert's law.

        Of what lies below a clear coat or a sheen, if there is one.
        """
        if self.is_narrow_metal:
            return None
        for name, lobe in reversed(LOBES.items()):
            if lobe.model and self.has(name):
                return lobe.model, tuple(getattr(self, each) for each in lobe.numbers or (name,))
        return None


LOBES: dict[str, Lobe] = dict(
    sorted(declared(Material, Lobe).items(), key=lambda each: each[1].level)
)
"""The lobes by the attributes that ask for them, from the lowest to the topmost"""
BESIDE_GLASS = frozenset(
    ["reflectance"]
    + [
        each
        for name, lobe in LOBES.items()
        if lobe.is_beside_glass
        for each in (name, *lobe.parameters)
    ]
)
"""Attributes of opaque surfaces that those have, too, which are glass in part"""


def _reflected(name: str, ior: float) -> float:
    """Return what a coat of this index of refraction reflects at normal incidence."""
    with naming(f"material {name!r}: ior"):
        return normal_reflectance(parameters_of(Material)["coat_ior"].check(ior))


def _plain(color: Paint) -> Paint:
    """Return a colour as a float or three, if it is no spectrum and no texture."""
    if isinstance(color, Spectrum | Texture):
        return color
    number = finite(color)
    plain = vector(color) if number is None else number
    if plain is None:
        raise _COLOR.error(color, "give a number, three for RGB, a Spectrum or a Texture")
    return plain
