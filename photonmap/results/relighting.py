"""Light groups of a result: at other strengths and in other spectra, and their shares of light."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import group_name, row_of, split_name
from photonmap.errors import InputError, warn
from photonmap.film.light_groups import OF_GROUPS
from photonmap.results.labels import Arrays, Labels
from photonmap.results.plots import Plots
from photonmap.runtime.wording import shown, suggest

Gains = dict[str, NDArray[np.float64]]
"""(N,) by light group"""
Array = NDArray[Any]
Lit = TypeVar("Lit", bound=Labels)


def relit(result: Lit, gains: Mapping[str, Any]) -> Lit:
    """Return a result with its light groups times gains; see `photonmap.Result.relit`."""
    factors = _factors(result, gains)
    _refuse_spectra(result, factors)
    if all((factor == 1.0).all() for factor in factors.values()):
        return replace(result)  # type: ignore[type-var]
    emission = result.buffers.get("emission")
    if emission is not None and emission.any():
        warn(
            "emission is not split by light group: lamps and skies in view keep their brightness "
            "and colour"
        )
    parts, errors = _scaled(result.buffers, factors), _scaled(result.errors, factors)
    buffers = {name: image for name, image in result.buffers.items() if not _follows(name)}
    buffers |= _sums(result, buffers, parts, list(factors)) | parts
    errors |= {name: error for name, error in result.errors.items() if not _follows(name)}
    errors |= _known_errors(result, factors)
    return replace(  # type: ignore[type-var]
        result,
        buffers={name: buffers[name] for name in result.buffers if name in buffers},
        errors={name: errors[name] for name in result.errors if name in errors},
        block_errors={},
        record=_record(result, factors),
    )


def _factors(result: Labels, gains: Mapping[str, Any]) -> Gains:
    """Return the gain of every group, in the order of the file; 1 where none is given."""
    names = [name for name in result.buffers if split_name(name)[0] in OF_GROUPS]
    groups = [group for group in dict.fromkeys(split_name(name)[1] for name in names) if group]
    if not groups:
        raise InputError("there are no light groups to relight; render with per_light=True")
    if not isinstance(gains, Mapping):
        raise InputError(f"gains {shown(gains)} go by no light groups, as in {{{groups[0]!r}: 2}}")
    for group in gains:
        if group not in groups:
            raise InputError(f"there is no light group {group!r}; {suggest(group, groups)}")
    return {group: _gain(group, gains.get(group, 1.0), result.bands.count) for group in groups}


def _glows(result: Labels) -> bool:
    """Return whether surfaces fluoresce."""
    effect = result.record.get("effects", {}).get("fluorescence", {})
    return effect.get("on") or "fluorescence" in result.buffers


def _refuse_spectra(result: Labels, factors: Gains) -> None:
    """Refuse gains that differ between bands where surfaces fluoresce: bands of light mix there."""
    for group, factor in factors.items():
        if _glows(result) and np.ptp(factor) > 0.0:
            raise InputError(
                f"surfaces fluoresce, which mixes the bands of light group {group!r}: give it one "
                "gain for all bands, or render its other spectrum as a light of its own"
            )


def _gain(group: str, gain: Any, bands: int) -> NDArray[np.float64]:
    try:
        values = np.broadcast_to(np.asarray(gain, np.float64), (bands,))
    except (TypeError, ValueError):
        values = np.full(bands, np.nan)
    if not (np.isfinite(values).all() and (values >= 0.0).all()):
        raise InputError(
            f"gain {shown(gain)} of light group {group!r} must be a number of at least 0, or "
            f"{bands} of them, one for each band"
        )
    return values


def _scaled(images: Arrays, factors: Gains) -> Arrays:
    """Return the images of light groups, each times the gain of its group."""
    return {
        name: (image * factors[group]).astype(np.float32)
        for name, image in images.items()
        if (group := split_name(name)[1]) in factors
    }


def _follows(name: str) -> bool:
    """Return whether a buffer follows from the light that is split, or may do so."""
    row = row_of(name)
    if row is None or split_name(name)[1]:
        return True
    is_color = row.source == "data set" and row.quantity == "ratio"
    return is_color or (row.quantity == "radiance" and name != "emission")


def _sums(result: Labels, rest: Arrays, parts: Arrays, groups: list[str]) -> Arrays:
    """Return the sums of parts, and what follows from them and from the rest."""
    whole: Arrays = {}
    for name in OF_GROUPS:
        found = [parts[each] for group in groups if (each := group_name(name, group)) in parts]
        if found:
            whole[name] = sum_images(found)
    if not {"direct", "indirect"} <= whole.keys():
        return whole
    if "emission" in rest:
        whole["radiance"] = (rest["emission"] + whole["direct"]) + whole["indirect"]
    if _glows(result) and "fluorescence" not in whole:
        return whole
    if "residual" in result.buffers and "reflectance" in rest and "shading" in whole:
        light = whole["direct"].astype(np.float64) + whole["indirect"]
        light -= whole.get("fluorescence", 0.0)
        residual = light - rest["reflectance"] * whole["shading"].astype(np.float64)
        none = result.buffers["residual"] == 0.0
        whole["residual"] = np.where(none, 0.0, residual).astype(np.float32)
    return whole


def sum_images(images: Sequence[NDArray[np.float32]]) -> NDArray[np.float32]:
    """Return the sum of images, in their order."""
    total = images[0].copy()
    for image in images[1:]:
        total += image
    return total


def _known_errors(result: Labels, factors: Gains) -> Arrays:
    """Return the errors of whole buffers where one group is lit, or where there are two.

    Groups share samples. The covariance of two follows from the error of their sum.
    """
    lit = [group for group, factor in factors.items() if factor.any()]
    if len(lit) == len(factors) == 2:
        names = {name: [name, *(group_name(name, group) for group in lit)] for name in OF_GROUPS}
        return {
            name: _error_of_two(*(result.errors[each] for each in needed), factors=factors)
            for name, needed in names.items()
            if {*needed} <= result.errors.keys()
        }
    if len(lit) != 1:
        return {}
    return {
        name: (result.errors[own] * factors[lit[0]]).astype(np.float32)
        for name in OF_GROUPS
        if (own := group_name(name, lit[0])) in result.errors
    }


def _error_of_two(whole: Array, one: Array, other: Array, *, factors: Gains) -> Array:
    """Return the error of a sum of two groups times gains, by those of the groups and their sum."""
    whole, one, other = (error.astype(np.float64) for error in (whole, one, other))
    first, second = factors.values()
    with np.errstate(invalid="ignore"):  # errors that are infinite
        covariance = np.clip(whole**2 - one**2 - other**2, -2.0 * one * other, 2.0 * one * other)
        variance = (first * one) ** 2 + (second * other) ** 2 + first * second * covariance
    known = np.isfinite(variance)
    return np.where(known, np.sqrt(np.maximum(variance, 0.0)), np.inf).astype(np.float32)


def _keeps_colors(factors: Gains) -> bool:
    """Return whether every group keeps its spectrum, up to a number."""
    return all(np.ptp(factor) == 0.0 for factor in factors.values())


def _record(result: Labels, factors: Gains) -> dict[str, Any]:
    """Return the record without what it says of the errors of other light, and of merging."""
    record = result.record
    parts = record.get("group_whites", {})
    white, own = None, {}
    if record.get("white") is not None and parts.keys() == factors.keys():
        own = {group: factor * parts[group] for group, factor in factors.items()}
        mean = float(np.sum([*own.values()], axis=0).mean())
        own = {group: part / mean for group, part in own.items()} if mean > 0.0 else {}
        white = np.sum([*own.values()], axis=0).tolist() if own else None
    earlier = record.get("relit", {})
    unknown = dict.fromkeys(("error", "standard_error", "goal", "bias_blocks"))
    return {
        **{name: value for name, value in record.items() if name != "fingerprint"},
        **unknown,
        "bias": 0.0 if record.get("bias") == 0.0 else None,
        "white": white,
        "light_luminance": record.get("light_luminance") if _keeps_colors(factors) else None,
        "group_whites": {group: part.tolist() for group, part in own.items()},
        "relit": {
            group: (factor * earlier.get(group, 1.0)).tolist() for group, factor in factors.items()
        },
    }


def shares_of(shadings: Mapping[str, Array]) -> dict[str, Array]:
    """Return the shares of lights, (H, W) float32, of the means over bands of shadings (H, W, N).

    They add up to 1, and are 0 where no light arrives.
    """
    parts = {light: image.mean(axis=-1, dtype=np.float64) for light, image in shadings.items()}
    whole = np.sum([*parts.values()], axis=0)
    return {light: _ratio(part, whole).astype(np.float32) for light, part in parts.items()}


def share_errors(result: Plots, lights: Sequence[str]) -> dict[str, Array]:
    """Return the standard errors of shares, (H, W) float32 each; 0 where no light arrives.

    By the delta method, the variance of a share s is that of S − sT over T², where S is a light's
    shading and T that of all. It has the covariance of S and T: lights of a pixel share camera
    samples, and choose light samples among each other. It follows from the errors of the lights and
    of their sum, with one correlation for all pairs of lights in a pixel; this is exact for two
    lights. Errors of bands add up as if they were fully correlated, which is the most they can do.
    A result without errors of light groups, as in lean files, is an `InputError`.
    """
    names = {light: group_name("shading", light) for light in lights}
    if missing := [name for name in names.values() if name not in result.errors]:
        raise InputError(f"holds no standard error of {missing[0]}; make the set with --full")
    values = np.array([result.buffers[name] for name in names.values()], np.float64)
    errors = np.array([result.standard_error(name) for name in names.values()], np.float64)
    whole, of_whole = values.sum(axis=0), result.standard_error("shading").astype(np.float64)
    with_whole = _covariances(errors, of_whole)
    bands = whole.sum(axis=-1)
    found = {}
    for light, value, error, covariance in zip(lights, values, errors, with_whole, strict=True):
        share = _ratio(value.sum(axis=-1), bands)[..., None]
        variance = error**2 - 2.0 * share * covariance + share**2 * of_whole**2
        spread = np.sqrt(np.maximum(variance, 0.0)).sum(axis=-1)
        found[light] = _ratio(spread, bands).astype(np.float32)
    return found


def _covariances(errors: Array, of_whole: Array) -> Array:
    """Return the covariances (lights, H, W, N) of lights with their sum, by all standard errors."""
    others = errors.sum(axis=0) - errors
    pairs = (errors * others).sum(axis=0)
    correlation = np.clip(_ratio(of_whole**2 - (errors**2).sum(axis=0), pairs), -1.0, 1.0)
    return errors**2 + correlation * errors * others


def _ratio(part: Array, whole: Array) -> Array:
    """Return a ratio, 0 where there is nothing to divide by."""
    return np.divide(part, whole, where=whole > 0.0, out=np.zeros(part.shape))
