"""What image files state of their pixels: which way up they are, exposure, and a space of colours.

The formats are those of Radiance's filefmts, OpenEXR's standard attributes, PNG (third edition),
TIFF 6.0, Exif 2.32, ITU-T H.273 (code points called CICP) and ICC.1:2022.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.runtime.wording import shown
from photonmap.spectra.curves import Floats
from photonmap.spectra.rgb_spaces import (
    PRIMARIES,
    SRGB,
    TRANSFERS,
    XYZ,
    Chromaticities,
    Transfer,
    decode_linear,
    decode_power,
    decode_srgb,
    encode_srgb,
)

if TYPE_CHECKING:
    import OpenImageIO

PNG, RADIANCE, TIFF = b"\x89PNG\r\n\x1a\n", b"#?", (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
"""How these files begin."""
FLOATS = ("half", "float", "double")
"""What OpenImageIO calls types of floats."""
RAMP: Floats = np.arange(256) / 255
_SCREENS, _NEAR = 0.45455, 0.01
"""gAMA of PNG files that are sRGB, and up to which difference it, or 1, is meant."""
_STEP = 1 / 255  # Up to which a curve is that of sRGB, in encoded values
_ALIASES = {
    "linear": "lin_rec709", "lin_srgb": "lin_rec709", "scene_linear": "lin_rec709",
    "srgb": "srgb_rec709", "rec709": "srgb_rec709", "acescg": "lin_ap1", "aces": "lin_ap0",
    "aces2065-1": "lin_ap0", "adobergb": "g22_adobergb", "ciexyz": "lin_ciexyzd65",
}  # fmt: skip
"""Other names of colour spaces."""
_NO_COLORS = ("", "data", "identity", "raw", "unknown")
_ON_DISPLAYS = ("pq", "hlg")  # Encodings of what displays show
_CODED_PRIMARIES = {1: "rec709", 2: "rec709", 9: "rec2020", 10: "ciexyzd65", 12: "p3d65"}
_CODED_TRANSFERS = {
    1: "rec709", 2: "srgb", 4: "g22", 5: "g28", 6: "rec709", 8: "lin", 13: "srgb", 14: "rec709",
    15: "rec709", 16: "pq", 18: "hlg",
}  # fmt: skip
"""Names of ITU-T H.273's codes; 2 means unspecified."""
_UNCALIBRATED = 0xFFFF  # Exif's ColorSpace
_D50 = (0.3457, 0.3585)
_ACES = "acesImageContainerFlag"
_LATLONG = "LatLong Environment"  # OpenEXR's envmap
_PARAMETRIC = ("g", "gab", "gabc", "gabcd", "gabcdef")
"""Parameters of an ICC profile's parametric curves, by their type."""


class ColorSpace(NamedTuple):
    """How the colours of a file become linear sRGB."""

    transfer: Transfer | None = None
    """to linear values; None for that of files that state none: of integers sRGB's, and floats are
    linear"""
    primaries: Chromaticities | str | None = None
    """chromaticities, or a name in colour-science; None for those of sRGB"""
    lost: tuple[str, ...] = ()  # what the file states that is not applied
    refused: str = ""  # why its colours cannot be read, and a remedy; "" if they can


PLAIN = ColorSpace()
"""Of a file that states none."""


class Header(NamedTuple):
    """What a file states."""

    orientation: int = 1  # as in TIFF and Exif, 1 to 8
    gain: Floats | None = None  # (3,), what its values have been multiplied by; None for 1
    space: ColorSpace = PLAIN  # of its colours
    sphere: str = ""  # what it states that is not used where its picture is a sky


def turned(pixels: NDArray[Any], orientation: int) -> NDArray[Any]:
    """Return pixels, (H, W, C), upright, as their orientation, 1 to 8, says."""
    if orientation > 4:
        pixels = pixels.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    return pixels[:, ::-1] if orientation in (2, 3, 6, 7) else pixels


def unreadable(path: Path, reason: str) -> InputError:
    """Return an error about an image that cannot be decoded."""
    reason = " ".join(reason.split())[:100]
    message = f"cannot be read as an image ({reason})"
    return InputError(f"{message}; save it again as PNG, JPEG, TIFF, EXR or HDR", path)


def read_header(
    path: Path, spec: OpenImageIO.ImageSpec, kind: str, stated: ColorSpace | None
) -> Header:
    """Return what a file states, as OpenImageIO names it.

    kind : name of its format in OpenImageIO
    stated : the space that a PNG file's chunks or a TIFF file's tags state
    """
    orientation = spec.get_int_attribute("Orientation", 1)
    if kind == "dpx" and orientation != 1:
        raise InputError("is not stored from the top left; save it as PNG, TIFF or EXR", path)
    space = stated if stated and kind == "png" else _find_space(spec, kind, stated)
    if lost := [*space.lost, *_find_lost(spec)]:
        space = space._replace(lost=tuple(lost))
    sphere = _aspect(spec.get_float_attribute("PixelAspectRatio", 1.0))
    if spec.get_string_attribute("textureformat") == _LATLONG:
        sphere = "its first and last texels lie on the poles and the seam (envmap), not beside them"
    return Header(orientation if 1 <= orientation <= 8 else 1, None, space, sphere)


def _aspect(ratio: float) -> str:
    return "" if ratio == 1.0 else f"states pixels {ratio:g} times as wide as high"


# --- Radiance -----------------------------------------------------------------------------

_XYZE, _RGBE = b"32-bit_rle_xyze", b"32-bit_rle_rgbe"


def radiance_header(path: Path, data: bytes) -> Header:
    """Return what a Radiance file states; what may be stated several times is multiplied."""
    end = max(data.find(b"\n\n"), 0)
    head, size = data[:end].decode("latin-1"), data[end + 2 : end + 102].decode("latin-1")

    def numbers(name: str, count: int) -> list[Floats]:
        texts = re.findall(rf"^{name}=(.*)$", head, re.MULTILINE)
        return [_parse_numbers(path, name, text, count) for text in texts]

    gain: Floats = np.ones(3)
    for factor in numbers("EXPOSURE", 1) + numbers("COLORCORR", 3):
        gain = gain * factor
    aspect = float(np.prod(numbers("PIXASPECT", 1)))
    transfers = [decode_power(power) for (power,) in numbers("GAMMA", 1) if power != 1.0]
    primaries = [XYZ] if _XYZE in data[:end] else numbers("PRIMARIES", 8)
    space = ColorSpace(
        transfers[-1] if transfers else None,
        tuple(float(each) for each in primaries[-1]) if primaries else None,
    )
    found = re.match(r"([+-][XY]) +\d+ +([+-][XY]) +\d+", size)
    axes = found.groups() if found else ("-Y", "+X")
    flips = 2 * ("+Y" in axes) + ("-X" in axes)
    orientation = (1, 2, 4, 3)[flips] + 4 * (axes[0][1] == "X")
    return Header(orientation, gain if (gain != 1.0).any() else None, space, _aspect(1.0 / aspect))


def _parse_numbers(path: Path, name: str, text: str, count: int) -> Floats:
    try:
        found = np.array(text.split(), np.float64)
    except ValueError:
        found = np.empty(0)
    is_color = name == "PRIMARIES"
    if found.shape != (count,) or not (np.isfinite(found) & (is_color | (found > 0.0))).all():
        wanted = f"{count} finite numbers" + ("" if is_color else " above 0")
        raise InputError(f"{name}={shown(text.strip())} in its header; write {wanted}", path)
    return found


def as_rgbe(data: bytes) -> bytes | None:
    """Return a Radiance file of XYZ as one of RGB with these numbers; None for other files."""
    return data.replace(_XYZE, _RGBE, 1) if _XYZE in data[: data.find(b"\n\n")] else None


# --- PNG ----------------------------------------------------------------------------------

_COLORS = (b"cICP", b"iCCP", b"sRGB", b"gAMA", b"cHRM")
_MOST = 1 << 24  # Bytes of a profile


def png_space(path: Path, data: bytes) -> ColorSpace:
    """Return the space that a PNG file states.

    cICP goes before iCCP, that before sRGB, and that before gAMA and cHRM. A damaged file, about
    which libpng would print to the standard error, is an `InputError`.
    """
    found = {kind: data[start:end] for kind, start, end in _chunks(path, data) if kind in _COLORS}
    if len(found.get(b"cICP", b"")) == 4:
        return _coded_space(*found[b"cICP"])
    if b"iCCP" in found:
        try:
            packed = found[b"iCCP"].partition(b"\0")[2][1:]
            return read_profile(zlib.decompressobj().decompress(packed, _MOST))
        except zlib.error:
            return read_profile(b"")
    if b"sRGB" in found:
        return PLAIN
    transfer: Transfer | None = None
    primaries: Chromaticities | None = None
    if len(found.get(b"gAMA", b"")) == 4:
        gamma = int.from_bytes(found[b"gAMA"], "big") / 1e5
        if abs(gamma - 1.0) < _NEAR:
            transfer = decode_linear
        elif gamma > 0.0 and abs(gamma - _SCREENS) > _NEAR:
            transfer = decode_power(1.0 / gamma)
    if len(found.get(b"cHRM", b"")) == 32:
        white_x, white_y, *colors = (n / 1e5 for n in struct.unpack(">8I", found[b"cHRM"]))
        primaries = (*colors, white_x, white_y)
    return ColorSpace(transfer, primaries)


def _chunks(path: Path, data: bytes) -> Iterator[tuple[bytes, int, int]]:
    """Yield each chunk's name, and where its content begins and ends."""
    at, kind = len(PNG), b""
    while kind != b"IEND":
        if at + 12 > len(data):
            raise unreadable(path, "the PNG file is truncated")
        size, kind = struct.unpack_from(">I4s", data, at)
        end = at + 8 + size
        if data[end : end + 4] != struct.pack(">I", zlib.crc32(memoryview(data)[at + 4 : end])):
            raise unreadable(path, f"the PNG file is damaged at byte {at}")
        yield kind, at + 8, end
        at = end + 4


# --- TIFF ---------------------------------------------------------------------------------

_TRANSFER, _WHITE, _CORNERS = 301, 318, 319  # TransferFunction, WhitePoint, PrimaryChromaticities


def tiff_space(data: bytes) -> ColorSpace | None:
    """Return the space that a TIFF file states by tags of its own, which OpenImageIO leaves out."""
    order, is_big = "<" if data[:2] == b"II" else ">", 43 in data[2:4]
    at, wide, count, entry = (8, "Q", "Q", "HHQQ") if is_big else (4, "I", "H", "HHII")
    found = {}
    try:
        (start,) = struct.unpack_from(order + wide, data, at)
        (rows,) = struct.unpack_from(order + count, data, start)
        start += struct.calcsize(order + count)
        size = rows * struct.calcsize(order + entry)
        for tag, _, number, place in struct.iter_unpack(order + entry, data[start : start + size]):
            if tag == _TRANSFER and number > 2:
                table = np.frombuffer(data, order + "u2", number, place) / 65535.0
                found[tag] = table.reshape(3 if number % 3 == 0 else 1, -1)
            elif tag in (_WHITE, _CORNERS):
                ratios = np.frombuffer(data, order + "u4", 2 * number, place).reshape(-1, 2)
                found[tag] = ratios[:, 0] / ratios[:, 1]
    except (struct.error, ValueError):
        return None  # damaged, about which OpenImageIO says more
    if not found:
        return None
    curves = [_tabulated(table) for table in found.get(_TRANSFER, ())]
    white, corners = found.get(_WHITE, np.array(SRGB[6:])), found.get(_CORNERS, np.array(SRGB[:6]))
    return ColorSpace(_join(curves) if curves else None, (*corners.tolist(), *white.tolist()))


# --- All formats --------------------------------------------------------------------------


def _find_space(spec: OpenImageIO.ImageSpec, kind: str, stated: ColorSpace | None) -> ColorSpace:
    """Return the space of a profile, of tags, or that OpenImageIO's attributes name."""
    if profile := _profile(spec):
        return read_profile(profile)
    if stated:
        return stated
    if (codes := spec.getattribute("CICP")) is not None:
        return _coded_space(*codes)
    if kind == "openexr":
        if spec.get_int_attribute(_ACES):
            return ColorSpace(primaries=PRIMARIES["ap0"])
        name = spec.get_string_attribute("colorInteropID")
        space = named_space(name or spec.get_string_attribute("oiio:ColorSpace"))
        corners = spec.getattribute("chromaticities")
        is_given = np.shape(corners) == (8,)
        return space._replace(primaries=tuple(map(float, corners))) if is_given else space
    if spec.get_int_attribute("Exif:ColorSpace") == _UNCALIBRATED:
        return ColorSpace(lost=("its space is uncalibrated (Exif), often Adobe RGB",))
    if str(spec.format) in FLOATS:
        return PLAIN
    return named_space(spec.get_string_attribute("oiio:ColorSpace"))


def named_space(name: str) -> ColorSpace:
    """Return a space by its name in OpenImageIO, such as "lin_ap1_scene" or "ACEScg"."""
    key = name.lower().removesuffix("_scene").removesuffix("_display")
    if key in _NO_COLORS:
        return PLAIN
    transfer, _, primaries = _ALIASES.get(key, key).partition("_")
    if transfer in TRANSFERS and primaries in PRIMARIES:
        return ColorSpace(TRANSFERS[transfer], PRIMARIES[primaries])
    if transfer in _ON_DISPLAYS:
        return ColorSpace(refused=_for_displays(transfer))
    return ColorSpace(lost=(f"the colour space {shown(name)} is not known",))


def _for_displays(transfer: str) -> str:
    return f"is encoded for displays, in {transfer.upper()}; save it as EXR, which is linear"


def _coded_space(primaries: int, transfer: int, matrix: int, is_full: int) -> ColorSpace:
    """Return a space by the codes of ITU-T H.273."""
    given, name = _CODED_PRIMARIES.get(primaries), _CODED_TRANSFERS.get(transfer)
    if name in _ON_DISPLAYS:
        return ColorSpace(refused=_for_displays(name))
    lost = [f"primaries of code {primaries} (CICP) are not known"] * (given is None)
    lost += [f"the transfer of code {transfer} (CICP) is not known"] * (name is None)
    lost += ["its narrow range (CICP) is not stretched"] * (not is_full)
    return ColorSpace(TRANSFERS.get(name or ""), PRIMARIES.get(given or ""), tuple(lost))


def _find_lost(spec: OpenImageIO.ImageSpec) -> list[str]:
    """Return what is stated of colours and not applied."""
    lost = []
    if white := spec.get_float_attribute("whiteLuminance"):
        lost.append(f"its luminance of white, {white:g} cd/m² (whiteLuminance), is not used")
    if spec.getattribute("adoptedNeutral") is not None:
        lost.append("its adoptedNeutral is not used")
    if "CMYK" in [spec.get_string_attribute(f"{kind}:ColorSpace") for kind in ("tiff", "jpeg")]:
        lost.append("its inks (CMYK) are turned into RGB without a profile")
    return lost


# --- ICC profiles -------------------------------------------------------------------------


def _profile(spec: OpenImageIO.ImageSpec) -> bytes:
    """Return an ICC profile; empty if there is none."""
    stated = spec.getattribute("ICCProfile")
    return b"" if stated is None else np.asarray(stated, np.uint8).tobytes()


def read_profile(profile: bytes) -> ColorSpace:
    """Return the space of an ICC profile of curves and a matrix; others are lost.

    White becomes white, as by the media-relative intent.
    """
    kind = profile[16:24]  # of colours, and of those that they are connected to
    try:
        tags = _tags(profile)
        if kind == b"GRAYXYZ " and b"kTRC" in tags:
            return ColorSpace(_join([_curve(tags[b"kTRC"])]))
        if kind == b"RGB XYZ " and b"rXYZ" in tags:
            curves = [_curve(tags[name]) for name in (b"rTRC", b"gTRC", b"bTRC")]
            colorants = [_fixed(tags[name][8:20]) for name in (b"rXYZ", b"gXYZ", b"bXYZ")]
            corners = [xyz[:2] / xyz.sum() for xyz in colorants]
            return ColorSpace(_join(curves), (*np.ravel(corners).tolist(), *_D50))
    except (KeyError, IndexError, ValueError, struct.error):
        return ColorSpace(lost=("its ICC profile is damaged",))
    name = kind[:4].decode("latin-1").strip()
    return ColorSpace(lost=(f"its ICC profile of tables ({name}) is not applied",))


def _tags(profile: bytes) -> dict[bytes, bytes]:
    (count,) = struct.unpack_from(">I", profile, 128)
    listed = struct.iter_unpack(">4sII", profile[132 : 132 + 12 * count])
    return {name: profile[start : start + size] for name, start, size in listed}


def _fixed(data: bytes) -> Floats:
    """Return numbers of 16 bits before and after the point."""
    return np.frombuffer(data, ">i4") / 65536.0


def _curve(tag: bytes) -> Transfer:
    """Return a curve: a power, a table, or a power above a line."""
    if tag[:4] == b"curv":
        (count,) = struct.unpack_from(">I", tag, 8)
        table = np.frombuffer(tag, ">u2", count, 12) / 65535.0
        if count > 1:
            return _tabulated(table)
        return decode_power(table[0] * 65535.0 / 256.0) if count else decode_linear
    names = _PARAMETRIC[struct.unpack_from(">H", tag, 8)[0]]
    given = dict(zip(names, _fixed(tag[12 : 12 + 4 * len(names)]), strict=True))
    g, a, b = given["g"], given.get("a", 1.0), given.get("b", 0.0)
    if "d" in given:
        slope, start, above, below = (given.get(name, 0.0) for name in "cdef")
    else:  # constant up to where the power begins
        slope, start, above = 0.0, -b / a, given.get("c", 0.0)
        below = above

    def decode(values: NDArray[Any]) -> NDArray[Any]:
        power = np.maximum(a * values + b, 0.0) ** g + above
        return np.where(values >= start, power, slope * values + below)

    return decode


def _tabulated(table: Floats) -> Transfer:
    """Return a curve through values at equal steps from 0 to 1."""
    return lambda values: np.interp(values, np.linspace(0.0, 1.0, len(table)), table)


def _join(curves: list[Transfer]) -> Transfer:
    """Return the transfer by a curve for each channel; that of sRGB, or none, if they are near."""
    tables = np.array([curve(RAMP) for curve in curves])
    if np.abs(encode_srgb(np.maximum(tables, 0.0)) - RAMP).max() < _STEP:
        return decode_srgb
    if np.abs(tables - RAMP).max() < _STEP / 2:
        return decode_linear

    def decode(values: NDArray[Any]) -> NDArray[Any]:
        channels = range(values.shape[-1])
        return np.stack([curves[i % len(curves)](values[..., i]) for i in channels], axis=-1)

    return decode
