"""How values of several parts are written on the command line."""

from argparse import ArgumentTypeError


def size(text: str) -> tuple[int, int]:
    """Read "640x480"."""
    width, cross, height = text.lower().partition("x")
    if not (cross and width.strip().isdecimal() and height.strip().isdecimal()):
        raise ArgumentTypeError(f"{text!r} is no size; write it as 640x480")
    return int(width), int(height)


def vector(text: str) -> tuple[float, ...]:
    """Read "1,2,3"."""
    try:
        x, y, z = map(float, text.split(","))
    except ValueError:
        raise ArgumentTypeError(
            f"{text!r} is no vector; write it as x,y,z (with = where x is negative)"
        ) from None
    return x, y, z


def limits(text: str) -> tuple[float, float]:
    """Read "400:700"."""
    try:
        low, high = map(float, text.split(":"))
    except ValueError:
        raise ArgumentTypeError(f"{text!r} is no range; write it as 400:700") from None
    return low, high


_UNITS = {unit: 1024**power for power, unit in enumerate("KMGT", 1)}


def amount(text: str) -> float:
    """Read "4G" or "512M", bytes in powers of 1024."""
    number, unit = text[:-1], _UNITS.get(text[-1:].upper())
    try:
        return float(number if unit else text) * (unit or 1)
    except ValueError:
        raise ArgumentTypeError(
            f"{text!r} is no amount of memory; write it as 4G or 512M"
        ) from None
