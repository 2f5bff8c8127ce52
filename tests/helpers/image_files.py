"""Image files with headers and profiles as the formats have them."""

import struct
import zlib

import numpy as np

STORED = {
    1: lambda picture: picture,
    2: np.fliplr,
    3: lambda picture: np.rot90(picture, 2),
    4: np.flipud,
    5: lambda picture: picture.swapaxes(0, 1),
    6: np.rot90,
    7: lambda picture: np.rot90(picture, 2).swapaxes(0, 1),
    8: lambda picture: np.rot90(picture, -1),
}
"""From a picture to the pixels of a file of an orientation of TIFF and Exif: that of 6 has its
first row on the right of the picture, and its first column at the top."""
RESOLUTIONS = [f"{y} {x}" for y in ("-Y {h}", "+Y {h}") for x in ("+X {w}", "-X {w}")]
RESOLUTIONS += [" ".join(line.split(" ")[i] for i in (2, 3, 0, 1)) for line in RESOLUTIONS]
"""Lines of Radiance files: the order of scan lines, then that of pixels in them."""


def write_radiance(path, picture, resolution=RESOLUTIONS[0], header="", kind="rgbe"):
    """Write (H, W, 3) as Radiance's RGBE, with more lines in the header."""
    largest = picture.max(axis=2)
    exponent = np.where(largest > 0.0, np.floor(np.log2(np.maximum(largest, 1e-30))) + 1.0, -128)
    mantissa = np.rint(picture / 2.0 ** exponent[..., None] * 256.0).clip(0, 255)
    texels = np.concatenate([mantissa, exponent[..., None] + 128], axis=2).astype(np.uint8)
    height, width = picture.shape[:2]
    if "+Y" in resolution:  # from the bottom upwards
        texels = texels[::-1]
    if "-X" in resolution:  # from the right to the left
        texels = texels[:, ::-1]
    if resolution[1] == "X":  # by columns
        texels = texels.swapaxes(0, 1)
    size = resolution.format(h=height, w=width)
    text = f"#?RADIANCE\n{header}FORMAT=32-bit_rle_{kind}\n\n{size}\n"
    path.write_bytes(text.encode() + np.ascontiguousarray(texels).tobytes())
    return path


def write_image(path, picture, kind="float", channels=None, **attributes):
    """Write by OpenImageIO; attributes are named with __ in place of a colon."""
    import OpenImageIO

    height, width, count = picture.shape
    spec = OpenImageIO.ImageSpec(width, height, count, kind)
    spec.channelnames = channels or spec.channelnames
    for name, value in attributes.items():
        if isinstance(value, tuple | bytes):
            is_raw = isinstance(value, bytes)
            given = np.frombuffer(value, np.uint8) if is_raw else tuple(map(float, value))
            spec.attribute(name, f"{'uint8' if is_raw else 'float'}[{len(value)}]", given)
        else:
            spec.attribute(name.replace("__", ":"), value)
    file = OpenImageIO.ImageOutput.create(str(path))
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(np.ascontiguousarray(picture)), file.geterror()
    file.close()
    return path


def with_chunks(path, chunks):
    """Give a PNG file chunks, {name: bytes}, behind its header, and none others of colours."""
    data = path.read_bytes()
    at, kept = 8, []
    while at < len(data):
        (size,) = struct.unpack_from(">I", data, at)
        if data[at + 4 : at + 8] not in (b"sRGB", b"gAMA", b"cHRM", b"iCCP", b"cICP"):
            kept.append(data[at : at + 12 + size])
        at += 12 + size
    added = [
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
        for name, body in chunks.items()
    ]
    path.write_bytes(data[:8] + b"".join([kept[0], *added, *kept[1:]]))
    return path


D50 = (0.9642, 1.0, 0.8249)
"""The white of ICC profiles."""


def icc_profile(curves, colorants=None, kind=b"RGB "):
    """Bytes of an ICC profile of curves, ready-made tags, and of colorants (3, 3), in columns."""
    names = (b"rTRC", b"gTRC", b"bTRC") if colorants is not None else (b"kTRC",)
    tags = dict(zip(names, curves, strict=True))
    for index, xyz in enumerate(() if colorants is None else colorants.T):
        name = (b"rXYZ", b"gXYZ", b"bXYZ")[index]
        tags[name] = b"XYZ \0\0\0\0" + np.rint(xyz * 65536).astype(">i4").tobytes()
    tags[b"wtpt"] = b"XYZ \0\0\0\0" + np.rint(np.array(D50) * 65536).astype(">i4").tobytes()
    for name in (b"desc", b"cprt"):
        text = "test".encode("utf-16-be")
        tags[name] = b"mluc\0\0\0\0" + struct.pack(">II2s2sII", 1, 12, b"en", b"US", 8, 28) + text
    index, body, start = b"", b"", 132 + 12 * len(tags)
    for name, tag in tags.items():
        index += struct.pack(">4sII", name, start + len(body), len(tag))
        body += tag + bytes(-len(tag) % 4)
    head = bytearray(128)
    struct.pack_into(">I", head, 0, start + len(body))
    head[8:12], head[12:16], head[16:20], head[20:24] = b"\4\x40\0\0", b"mntr", kind, b"XYZ "
    head[24:36] = struct.pack(">6H", 2020, 1, 1, 0, 0, 0)
    head[36:40] = b"acsp"
    head[68:80] = np.rint(np.array(D50) * 65536).astype(">i4").tobytes()
    return bytes(head) + struct.pack(">I", len(tags)) + index + body


def curve_tag(*values):
    """An ICC curve: nothing for a line, one number for a power, or a table in [0, 1]."""
    stated = [round(values[0] * 256)] if len(values) == 1 else [round(v * 65535) for v in values]
    return b"curv\0\0\0\0" + struct.pack(f">I{len(stated)}H", len(stated), *stated)


def parametric_tag(kind, *values):
    """An ICC parametric curve of a type."""
    numbers = np.rint(np.array(values) * 65536).astype(">i4").tobytes()
    return b"para\0\0\0\0" + struct.pack(">HH", kind, 0) + numbers
