"""Materials as kernels take them: diffuse albedos, mirrors and glass, band by band."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.surfaces.fluorescence import compile_fluorescence
from photonmap.compile.surfaces.glossy import NODES, TERMS, lobe_albedos
from photonmap.compile.surfaces.white_bases import WHITE_BASES
from photonmap.errors import InputError, naming, warn
from photonmap.kernels.bsdf.models import GLOSSY, MODELS
from photonmap.kernels.core import records
from photonmap.kernels.core.metals import DIP_POWERS
from photonmap.runtime.wording import listed
from photonmap.scene.material import Material
from photonmap.scene.surfaces.conductors import fit_dip
from photonmap.scene.surfaces.fresnel import lobe_index, mean_rise
from photonmap.scene.surfaces.layers import check_layers, check_material
from photonmap.scene.textures import Paint, Texture, mean_color, mean_number, rescaling
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import LARGEST_REFLECTANCE, Floats, Spectrum

LEAST_COLOR = 1e-3  # Share by which bands of colourless reflectances may differ


class CompiledMaterials(NamedTuple):
    """What M materials do with light."""

    diffuse: records.Materials
    specular: records.Specular | None  # None where no surface is a mirror or glass
    scattering: records.Scattering | None  # None where all surfaces are Lambertian or specular
    panes: records.Panes | None  # None where there is no thin glass
    divisors: Floats  # (M,) by which reflectances were divided
    fluorescence: records.Fluorescence | None  # None where no surface fluoresces


def compile_materials(materials: list[Material], bands: Bands) -> CompiledMaterials:
    """Check materials, and turn them into what kernels take; textures count with their mean.

    Where diffuse and mirror reflectance add up to more than 1, anywhere on a texture, both are
    scaled, with a warning. An `InputError` says that a number or colour is out of range.
    """
    materials = [check_material(material) for material in materials]
    reflectance, mirror, glossy, tint = (
        _reflectances(materials, name, bands)
        for name in ("reflectance", "mirror", "glossy", "tint")
    )
    ior = np.array([material.ior or 0.0 for material in materials])
    is_even = [m.ior is not None and not isinstance(m.transmission, Texture) for m in materials]
    transmitted = np.array([mean_number(m.transmission) for m in materials]) * is_even
    for index, material in enumerate(materials):
        _check_glass(material, reflectance[index].any(), mirror[index].any())
        check_layers(material)
        if material.edge is not None and isinstance(material.glossy, Texture):
            raise InputError(
                f"material {material.name!r} has a glossy_edge; give it one glossy, not a texture"
            )
    dip = _compile_dips(materials, np.maximum(glossy, mirror), bands)
    reflectance *= (1.0 - transmitted)[:, None]
    narrow = np.array([material.is_narrow_metal for material in materials])
    mirror[narrow], glossy[narrow] = glossy[narrow], 0.0
    polished = np.array([material.is_polished_metal for material in materials])
    walks, lobes = (_dips_of(dip, kept) for kept in (narrow | polished, ~(narrow | polished)))
    grazing = _rows_of(1.0 - mirror, polished)
    grazing = grazing if grazing.any() else grazing[:0]
    divisors = _bound(materials, reflectance, mirror)
    panes = _compile_panes(materials, mirror, tint)
    fluorescence = compile_fluorescence(materials, 1.0 - transmitted, bands)
    diffuse = np.minimum(reflectance + _mean_taken(fluorescence, materials), 1.0)
    return CompiledMaterials(
        records.Materials(reflectance.astype(np.float32)),
        _compile_specular(materials, diffuse, mirror, tint, ior, (walks, grazing)),
        _compile_scattering(materials, diffuse, glossy, lobes),
        panes,
        divisors / np.maximum(1.0 - transmitted, 1e-300),
        fluorescence,
    )


def _mean_taken(
    fluorescence: records.Fluorescence | None, materials: list[Material]
) -> Floats | float:
    """Return about which part of light becomes fluorescence, (M, N): by this lobes are chosen."""
    if fluorescence is None:
        return 0.0
    means = np.array([mean_number(m.fluorescence_concentration) for m in materials])
    taken = np.maximum(fluorescence.taken[fluorescence.row].astype(np.float64), 0.0)
    return np.where(fluorescence.row >= 0, means, 0.0)[:, None] * taken


def _check_glass(material: Material, is_diffuse: bool, is_mirror: bool) -> None:
    """Refuse glass that is also a mirror, and what reflects diffusely though all of it is glass."""
    if material.ior is None:
        return
    if is_mirror:
        raise InputError(f"material {material.name!r} is glass; set its mirror to 0")
    if material.is_all_glass and (is_diffuse or material.is_glossy):
        name = "reflectance" if is_diffuse else "glossy"
        raise InputError(
            f"material {material.name!r} is glass; set its {name} to 0, or its transmission below 1"
        )


def _compile_panes(materials: list[Material], mirror: Floats, tint: Floats) -> records.Panes | None:
    """Return smooth panes, None where there are none; they stop what does not pass in all bands.

    What they stop is reflected as by a mirror, or takes the rest of the tint: both change in place.
    What is glass in part, or of a textured tint (see `Panes.image`), stops all here.
    """
    for material in materials:
        if material.thin and material.ior is None:
            raise InputError(f"material {material.name!r} is thin but no glass; give it an ior")
    thin = np.array([material.is_pane for material in materials])
    if not thin.any():
        return None
    part = np.array([not m.is_all_glass or isinstance(m.tint, Texture) for m in materials])
    clear = np.where(thin, np.where(part, 0.0, tint.min(axis=1)), 1.0)
    rest = np.maximum(1.0 - clear, 1e-300)[:, None]
    tint[thin] = ((tint - clear[:, None]) / rest)[thin]
    mirror[thin] = 1.0
    ior = np.array([(material.ior or 0.0) * material.is_pane for material in materials])
    return records.Panes(ior, clear, np.full(len(materials), -1, np.int32), None)


def _compile_dips(materials: list[Material], glossy: Floats, bands: Bands) -> Floats:
    """Return the dips of glossy surfaces, (M, 4, N)."""
    dip = np.zeros((len(materials), len(DIP_POWERS), bands.count))
    for row, material in enumerate(materials):
        edge = material.edge if material.is_glossy or material.is_polished_metal else None
        if edge is not None:
            dip[row] = fit_dip(glossy[row], reflectance_of(material, "glossy_edge", edge, bands))
    return dip


def _rows_of(table: Floats, kept: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return the rows of some materials, 0 of others."""
    chosen = np.zeros(table.shape, np.float32)
    chosen[kept] = table[kept]
    return chosen


def _dips_of(table: Floats, kept: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return the dips of some materials, as `Scattering.dip`."""
    chosen = _rows_of(table, kept)
    return chosen if chosen.any() else np.zeros((len(table), 0, 0), np.float32)


def _compile_specular(
    materials: list[Material],
    reflectance: Floats,
    mirror: Floats,
    tint: Floats,
    ior: Floats,
    of_metals: tuple[NDArray[np.float32], NDArray[np.float32]],
) -> records.Specular | None:
    """Return the specular lobes; None where there is none.

    The last argument is dip and `grazing` of metals.
    """
    alpha = np.array([material.chain_alpha for material in materials])
    solid = np.array([not material.thin for material in materials])
    rough, mirrors = alpha > 0.0, mirror.any(axis=1)
    kind = np.select(
        [(ior > 0.0) & solid, (ior > 0.0) & rough, rough & mirrors, mirrors],
        [records.GLASS, records.THIN, records.METAL, records.MIRROR],
        default=0,
    ).astype(np.uint8)
    if not kind.any():
        return None
    specular, diffuse = mirror.mean(axis=1), reflectance.mean(axis=1)
    chance = specular / np.maximum(specular + diffuse, 1e-300)
    probability = np.select([kind == records.MIRROR, kind > 0], [chance, 1.0], default=0.0)
    for index, material in enumerate(materials):
        if material.ior is not None and not material.is_all_glass:
            probability[index] = mean_number(material.transmission)
    alpha[kind == 0] = 0.0
    alpha = alpha if alpha.any() else np.zeros(0)
    lobes = kind, mirror.astype(np.float32), ior, tint.astype(np.float32), probability, alpha
    dip, grazing = of_metals
    return records.Specular(*lobes, None, dip, None, None, grazing, None)


def _compile_scattering(
    materials: list[Material], reflectance: Floats, glossy: Floats, dip: NDArray[np.float32]
) -> records.Scattering | None:
    """Return which BSDFs are not Lambertian; None where there is none."""
    described = [material.scattering for material in materials]
    covered = [material.is_covered for material in materials]
    if not any(covered) and all(scattering is None for scattering in described):
        return None
    model, parameters = np.zeros(len(materials), np.uint8), np.zeros((len(materials), 6))
    parameters[:, 5] = [-1.0 if each.covering is None else each.covering for each in materials]
    for index, scattering in enumerate(described):
        if scattering is not None:
            name, values = scattering
            if covered[index] and name not in WHITE_BASES:
                raise InputError(
                    f"material {materials[index].name!r}: coat and sheen do not go over a "
                    f"{name} surface; set both to 0"
                )
            model[index] = MODELS[name]
            parameters[index, : len(values)] = values
    albedos = np.zeros((len(materials), TERMS, NODES + 1))
    for index in range(len(materials)):
        if model[index] == GLOSSY:
            refraction = _lobe_index(materials[index], glossy[index])
            albedos[index] = lobe_albedos(parameters[index, 0], refraction)
            parameters[index, 3:5] = refraction, mean_rise(refraction)
        if model[index] == GLOSSY or covered[index]:
            parameters[index, 1:3] = glossy[index].mean(), reflectance[index].mean()
    specular = glossy.astype(np.float32)
    nothing = (None, None, None, dip, None)
    return records.Scattering(model, parameters, specular, albedos, *nothing, model, None)


def _lobe_index(material: Material, f0: Floats) -> float:
    """Return the index of refraction of a glossy lobe; 0 where Schlick's formula has to do."""
    is_colored = isinstance(material.glossy, Texture) or np.ptp(f0) > LEAST_COLOR * f0.max()
    return 0.0 if is_colored or material.edge is not None else lobe_index(f0.mean())


def _reflectances(materials: list[Material], name: str, bands: Bands) -> Floats:
    """Return the bands of a reflectance of materials, (M, N); most have 0 or 1 in common."""
    rows: dict[object, Floats] = {}
    colors = [getattr(material, name) for material in materials]
    keys = [color if isinstance(color, float) else id(color) for color in colors]
    for material, key, color in zip(materials, keys, colors, strict=True):
        if key not in rows:
            rows[key] = reflectance_of(material, name, color, bands)
    return np.stack([rows[key] for key in keys])


def reflectance_of(material: Material, name: str, color: Paint, bands: Bands) -> Floats:
    """Return the bands of a material's reflectance, (N,), cut to 1; refuse more or less."""
    with naming(f"material {material.name!r}: {name}"):
        values = bands.reflectance(mean_color(color))
    bad = ~((values >= 0.0) & (values <= LARGEST_REFLECTANCE))
    if bad.any():
        band = bands.names[int(np.argmax(bad))]
        is_plain = not isinstance(color, Texture | Spectrum)
        advice = rescaling(float(np.max(color))) if is_plain else ""  # type: ignore[arg-type]
        raise InputError(
            f"material {material.name!r}: {name} is {values[bad][0]:.6g} in band {band}; "
            f"it must lie between 0 and 1{advice}"
        )
    return np.minimum(values, 1.0)


def _bound(materials: list[Material], reflectance: Floats, mirror: Floats) -> Floats:
    """Scale rows that reflect more than they receive, in place, and say so: return divisors."""
    most = (reflectance + mirror).max(axis=1)
    for index, material in enumerate(materials):
        if isinstance(material.reflectance, Texture):
            largest = min(material.reflectance.largest, 1.0)
            most[index] = largest + mirror[index].max()
    excess = most > LARGEST_REFLECTANCE
    if excess.any():
        names = [material.name for material, much in zip(materials, excess, strict=True) if much]
        warn(f"reflectance and mirror add up to more than 1 and are scaled down in {listed(names)}")
    factor = np.maximum(most, 1.0)[:, None]
    reflectance /= factor
    mirror /= factor
    return factor[:, 0]
