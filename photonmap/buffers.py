"""The one list of buffers: what they hold, in which unit and shape, and how runs pool them.

All that has to know which buffers there are reads it here: results, OpenEXR files, merging, the
estimate of memory, the goals of `--error`, moments, light groups, data sets and docs/guide.md.
A new buffer is a row of `TABLE`, and what computes it: see docs/extending.md.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

from photonmap.errors import InputError
from photonmap.runtime.options import read_list
from photonmap.runtime.wording import shown, suggest

Quantity = Literal[
    "radiance", "reflectance", "ratio", "fraction", "length", "direction", "mask", "count", "id"
]
"""What values are: spectral radiance; reflectance, which is projected under equal-energy white; a
ratio of radiances; and what has no bands."""
Source = Literal["passes", "counts", "first hit", "data set"]
"""Where values come from: moments over passes; how often and what passes met; the surface at the
pixel's centre; or, in data sets alone, other buffers."""
Pooling = Literal["mean", "sum of parts", "ratio", "covariance", "same", "sum", "all", "none"]
"""How runs are merged: by their means over passes; as the sum of buffers merged before; as a ratio
of means; as a covariance of means; not at all, as they must agree; by their sum; by whether all
say so; or dropped."""
Omission = Literal[
    "never",
    "without mirrors, glass or rough surfaces",
    "without fluorescent surfaces",
    "where it is 0 everywhere",
    "where light of this kind is not filtered",
]
"""When a buffer that was asked for is not written: reading it gives zeros, or what is filtered."""
Scenes = Literal["all", "with gloss", "with gloss, mirrors or glass", "none"]
"""Of which scenes a render keeps a buffer unless others are asked for."""

UNITS = {"radiance": "W·m⁻²·sr⁻¹", "length": "scene units"}
"""Units of the quantities that have one."""
ERROR_ENDINGS = ".error", ".error8"
"""What standard errors are called after their buffer, and those of means over 8×8 pixels."""
_INTEGERS = ("count", "id")
Image = TypeVar("Image")


@dataclass(frozen=True)
class Buffer:
    """One row of the list.

    Parameters
    ----------
    name : as in `Result.buffers` and in files
    meaning : one line of Markdown for help and docs
    quantity, source, pooling : see these types
    channels : names of the channels in files; None for one channel a band
    has_error : it has a standard error of the mean
    has_block_error : so have its means over blocks of pixels, because pixels share light
    is_goal : a render may aim at its error; in the order of the kernels' `GOAL_BUFFERS`
    per_light : it may be split by light group
    omitted : when it is not written
    kept : of which scenes a render keeps it unless others are asked for
    """

    name: str
    meaning: str
    quantity: Quantity
    source: Source
    pooling: Pooling
    channels: tuple[str, ...] | None = None
    has_error: bool = False
    has_block_error: bool = False
    is_goal: bool = False
    per_light: bool = False
    omitted: Omission = "never"
    kept: Scenes = "all"

    @property
    def is_banded(self) -> bool:
        """Whether it has a channel a band: (H, W, N)."""
        return self.channels is None

    @property
    def is_mask(self) -> bool:
        """Whether its values are true or false."""
        return self.quantity == "mask"

    @property
    def is_integer(self) -> bool:
        """Whether its values are whole numbers in files, uint32."""
        return self.is_mask or self.quantity in _INTEGERS

    @property
    def unit(self) -> str:
        """The unit of its values; "" for none."""
        return UNITS.get(self.quantity, "")

    @property
    def dtype(self) -> str:
        """The type of its arrays: float32, uint32 or bool."""
        return "bool" if self.is_mask else "uint32" if self.is_integer else "float32"

    @property
    def shape(self) -> str:
        """The shape of its arrays, as in "(H, W, N)"."""
        if self.channels is None:
            return "(H, W, N)"
        return f"(H, W, {len(self.channels)})" if len(self.channels) > 1 else "(H, W)"

    @property
    def summary(self) -> str:
        """Shape, type, unit and meaning, for help."""
        unit = f", {self.unit}" if self.unit else ""
        text = f"{self.shape} {self.dtype}{unit}: {self.meaning}."
        if self.omitted != "never":
            text += f" Not written {self.omitted}, and then exactly {self.then}."
        return text

    @property
    def then(self) -> str:
        """What its values are where it is not written: those of a buffer, or "0"."""
        return (
            self.name.removesuffix("_unfiltered")
            if self.omitted == "where light of this kind is not filtered"
            else "0"
        )

    def values_per_pixel(self, bands: int) -> int:
        """Return the number of its 4-byte values in a pixel, those of its error included."""
        channels = bands if self.channels is None else len(self.channels)
        return channels * (1 + self.has_error)


TABLE = (
    Buffer(
        "radiance",
        "what the camera sees: (emission + direct) + indirect, bit for bit",
        "radiance", "passes", "sum of parts",
        has_error=True, is_goal=True,
    ),
    Buffer(
        "emission",
        "light sources and the background, seen directly or via specular surfaces",
        "radiance", "passes", "mean",
        has_error=True,
    ),
    Buffer(
        "direct",
        "light reflected once, straight from a light source",
        "radiance", "passes", "mean",
        has_error=True, has_block_error=True, is_goal=True, per_light=True,
    ),
    Buffer(
        "direct_unfiltered",
        "the mean of direct over passes, before it is averaged over pixels of a surface: merging "
        "takes it",
        "radiance", "passes", "mean",
        has_error=True, per_light=True, omitted="where light of this kind is not filtered",
    ),
    Buffer(
        "indirect",
        "light reflected by other surfaces before the one seen",
        "radiance", "passes", "mean",
        has_error=True, has_block_error=True, is_goal=True, per_light=True,
    ),
    Buffer(
        "indirect_unfiltered",
        "the mean of indirect over passes, as direct_unfiltered",
        "radiance", "passes", "mean",
        has_error=True, per_light=True, omitted="where light of this kind is not filtered",
    ),
    Buffer(
        "caustics",
        "the part of indirect that reached a diffuse surface via specular surfaces alone",
        "radiance", "passes", "mean",
        has_error=True, has_block_error=True, is_goal=True, per_light=True,
        omitted="without mirrors, glass or rough surfaces",
    ),
    Buffer(
        "residual",
        "radiance − emission − reflectance × shading − fluorescence: what is seen in mirrors and "
        "through glass, and what rough surfaces reflect beyond Lambert's law",
        "radiance", "passes", "mean",
        has_error=True, is_goal=True, omitted="without mirrors, glass or rough surfaces",
    ),
    Buffer(
        "fluorescence",
        "light that changed its band at the surface seen, a part of direct and of indirect",
        "radiance", "passes", "mean",
        has_error=True, has_block_error=True, is_goal=True, per_light=True,
        omitted="without fluorescent surfaces",
    ),
    Buffer(
        "fluorescence_direct",
        "the part of fluorescence, and of direct, that light straight from a source excites",
        "radiance", "passes", "mean",
        has_error=True, per_light=True, omitted="without fluorescent surfaces", kept="none",
    ),
    Buffer(
        "fluorescence_indirect",
        "the part of fluorescence, and of indirect, that light from other surfaces excites",
        "radiance", "passes", "mean",
        has_error=True, per_light=True, omitted="without fluorescent surfaces", kept="none",
    ),
    Buffer(
        "excitation",
        "the part of irradiance / π that turns into fluorescence at the surface seen, by the band "
        "in which it arrives: its sum over bands is that of fluorescence",
        "radiance", "passes", "mean",
        has_error=True, omitted="without fluorescent surfaces", kept="none",
    ),
    Buffer(
        "reflectance",
        "diffuse albedo of the surface seen, in [0, 1], without what it re-emits in other bands",
        "reflectance", "passes", "mean",
        has_error=True,
    ),
    Buffer(
        "shading",
        "irradiance / π at the surface seen, also where its reflectance is 0",
        "radiance", "passes", "ratio",
        has_error=True, is_goal=True, per_light=True,
    ),
    Buffer(
        "covariance",
        "of the means of reflectance × shading and of reflectance; merging runs needs it for the "
        "error of shading where a pixel shows several reflectances",
        "radiance", "passes", "covariance",
        per_light=True, omitted="where it is 0 everywhere",
    ),
    Buffer(
        "coverage",
        "the fraction of the pixel that shows a surface",
        "fraction", "passes", "mean", ("Y",),
    ),
    Buffer(
        "unresolved",
        "no photon was found for the pixel's indirect light, although some were stored",
        "mask", "counts", "all", ("Y",),
    ),
    Buffer(
        "passes",
        "the number of passes that the pixel's means are over",
        "count", "counts", "sum", ("count",),
    ),
    Buffer(
        "depth",
        "depth of the surface at the pixel's centre, along the view; of fisheyes, panoramas and "
        "ray maps, its distance; 0 for the background",
        "length", "first hit", "same", ("Z",),
    ),
    Buffer(
        "distance",
        "distance to the surface at the pixel's centre, along the camera's ray; 0 for the "
        "background",
        "length", "first hit", "same", ("Z",),
    ),
    Buffer(
        "normal",
        "unit normal, in world space, towards the camera at the pixel's centre; 0 for the "
        "background",
        "direction", "first hit", "same", ("X", "Y", "Z"),
    ),
    Buffer(
        "object_id",
        "the object at the pixel's centre, from 1 in order of appearance; 0 for the background",
        "id", "first hit", "same", ("id",),
    ),
    Buffer(
        "material_id",
        "the material at the pixel's centre, from 1 in order of appearance; 0 for the background",
        "id", "first hit", "same", ("id",),
    ),
    Buffer(
        "specular_reflectance",
        "specular reflectance at normal incidence of the material at the pixel's centre: of a "
        "mirror, a glossy surface, a coat or glass; 0 for diffuse surfaces and the background",
        "reflectance", "first hit", "same", kept="with gloss",
    ),
    Buffer(
        "roughness",
        "roughness of what the material at the pixel's centre reflects: of a glossy surface, "
        "rough glass or a clear coat over a diffuse surface its own, at least 0.0316; 0 for "
        "mirrors, mirror coats and smooth glass, 1 for diffuse surfaces; 0 for the background",
        "fraction", "first hit", "same", ("Y",), kept="with gloss",
    ),
    Buffer(
        "metallic",
        "metallic fraction, as in glTF, of the material at the pixel's centre: 1 for bare metal "
        "and mirrors, 0 for diffuse surfaces below a coat or none, glass and the background",
        "fraction", "first hit", "same", ("Y",), kept="with gloss",
    ),
    Buffer(
        "diffuse_fraction",
        "how much of the light from all around that the material at the pixel's centre reflects "
        "or transmits leaves its diffuse base; 0 for mirrors, glass and the background",
        "ratio", "first hit", "same", kept="with gloss, mirrors or glass",
    ),
    Buffer(
        "scalar_shading",
        "the mean of shading over the bands",
        "radiance", "data set", "none", ("Y",),
    ),
    Buffer(
        "illuminant",
        "the colour of the light: shading / scalar_shading; 0 where no light arrives",
        "ratio", "data set", "none",
    ),
    Buffer(
        "illuminant_direct",
        "the colour of the direct light, of band mean 1, mixed from the colours that the lights "
        "emit; 0 where none is seen",
        "ratio", "data set", "none",
    ),
    Buffer(
        "valid",
        "surfaces cover the pixel, nothing in it emits, it is not unresolved, and it shows no "
        "mirror, glass or bare metal, however rough",
        "mask", "data set", "none", ("Y",),
    ),
    Buffer(
        "light_source",
        "something emits in the pixel, and a surface is at its centre",
        "mask", "data set", "none", ("Y",),
    ),
    Buffer(
        "background",
        "no surface is at the pixel's centre",
        "mask", "data set", "none", ("Y",),
    ),
    Buffer(
        "pure",
        "one reflectance and one piece of surface are in the pixel, so that shading is the "
        "irradiance / π there",
        "mask", "data set", "none", ("Y",),
    ),
)  # fmt: skip
"""All buffers: those that renders have, in the order of files, then those that data sets add."""

BY_NAME = {row.name: row for row in TABLE}
RENDERED = tuple(row for row in TABLE if row.source != "data set")
"""The rows of all buffers that a render may have."""
ADDED = tuple(row for row in TABLE if row.source == "data set")
"""The rows of the buffers that data sets add."""
BUFFERS = tuple(row.name for row in RENDERED)
"""Names of all buffers that a render may have."""
DEFAULT = tuple(row.name for row in RENDERED if row.kept == "all")
"""Names of those that a render of any scene keeps unless others are asked for."""


def names_where(**wanted: Any) -> tuple[str, ...]:
    """Return the names of the buffers of a render that have these values, in order.

    Examples
    --------
    >>> names_where(has_block_error=True)
    ('direct', 'indirect', 'caustics', 'fluorescence')
    """
    return tuple(
        row.name for row in RENDERED if all(getattr(row, key) == wanted[key] for key in wanted)
    )


def split_name(name: str) -> tuple[str, str]:
    """Return the buffer and the light group of a name: "direct", "sun" of "direct@sun".

    The group is "" for a whole buffer.
    """
    buffer, _, group = name.partition("@")
    return buffer, group


def group_name(buffer: str, group: str) -> str:
    """Return what a buffer of a light group is called: "direct@sun"; "direct" for group ""."""
    return f"{buffer}@{group}" if group else buffer


def without_slash(name: str) -> str:
    """Return what an array is called in files whose names have no "/": "%2F", and "%25" for "%".

    Examples
    --------
    >>> without_slash("direct@desk/left"), with_slash("direct@desk%2Fleft")
    ('direct@desk%2Fleft', 'direct@desk/left')
    """
    return name.replace("%", "%25").replace("/", "%2F")


def with_slash(name: str) -> str:
    """Return the name of which `without_slash` made this one."""
    return name.replace("%2F", "/").replace("%25", "%")


def check_distinct(called: Mapping[str, str]) -> None:
    """Refuse, by an `InputError`, buffers that a file would call alike, as light groups may be."""
    owners: dict[str, str] = {}
    for name, written in called.items():
        other = owners.setdefault(written, name)
        if other != name:
            raise InputError(
                f"{shown(other)} and {shown(name)} would both be called {shown(written)} there; "
                "rename one of these lights"
            )


def row_of(name: str) -> Buffer | None:
    """Return the row of a buffer, or of one of a light group; None for an unknown name."""
    return BY_NAME.get(split_name(name)[0])


def is_banded(name: str) -> bool:
    """Return whether a buffer has a channel a band; one that is not listed is taken to."""
    row = row_of(name)
    return row is None or row.is_banded


def is_omitted(name: str) -> bool:
    """Return whether a buffer is left out of some renders that keep it, as it is 0 in them."""
    row = row_of(name)
    return row is not None and row.omitted != "never"


def in_order(images: Mapping[str, Image]) -> dict[str, Image]:
    """Return images of buffers in the order of `TABLE`, then those of each light group."""
    groups = ["", *dict.fromkeys(split_name(name)[1] for name in images)]

    def position(name: str) -> tuple[int, int]:
        buffer, group = split_name(name)
        return groups.index(group), BUFFERS.index(buffer)

    return {name: images[name] for name in sorted(images, key=position)}


def check_buffers(names: str | Iterable[str] | None) -> None:
    """Check the names of buffers to be kept, see `read_list`; None stands for the default ones.

    Raises
    ------
    InputError : there is no such buffer, or no name
    """
    if names is None:
        return
    names = read_list(names)
    for name in names:
        if name not in BUFFERS:
            raise InputError(f"there is no buffer {name!r}; {suggest(name, BUFFERS)}")
    if not names:
        raise InputError("no buffer was chosen")


def kept_in(has_gloss: bool, has_specular: bool) -> frozenset[str]:
    """Return the names of the buffers that a render keeps unless others are asked for.

    Parameters
    ----------
    has_gloss : some surfaces of the scene are glossy, or rough glass, or have a coat or a sheen
    has_specular : some are mirrors or glass
    """
    wanted = {
        "with gloss": has_gloss,
        "with gloss, mirrors or glass": has_gloss or has_specular,
        "none": False,
    }
    return frozenset(row.name for row in RENDERED if wanted.get(row.kept, True))


def with_defaults(names: Iterable[str] | None) -> list[str] | None:
    """Return the buffers to keep in runs that are merged: the default ones and these, or None."""
    return None if names is None else list(dict.fromkeys((*DEFAULT, *names)))


def as_markdown(rows: Iterable[Buffer] = RENDERED) -> str:
    """Return a table of buffers for docs/, without the last end of line."""
    lines = [
        "| buffer | shape and type | unit | standard error | meaning |",
        "|---|---|---|---|---|",
    ]
    for row in rows:
        error = "pixel, block" if row.has_block_error else "pixel" if row.has_error else ""
        notes = [row.meaning]
        if row.omitted != "never":
            notes.append(f"not written {row.omitted}")
        if row.per_light:
            notes.append("may be split by light group")
        if row.kept != "all":
            notes.append(
                "only on request" if row.kept == "none" else f"only {row.kept}, or on request"
            )
        cells = (f"`{row.name}`", f"{row.shape} {row.dtype}", row.unit, error, "; ".join(notes))
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)
