"""What attributes of lights and materials may be, declared once, in their annotations.

    outer: Annotated[float, Number("half-angle", "degrees", at_least=1e-3, below=180.0)] = 30.0

Checks, readers and writers follow from the declaration: an attribute is named there alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cache
from numbers import Real
from pathlib import Path
from typing import Any, ClassVar, Literal, Self, TypeVar, get_args, get_type_hints

import numpy as np

from photonmap.errors import InputError
from photonmap.runtime.wording import shown
from photonmap.scene.textures import Texture
from photonmap.spectra.curves import Color
from photonmap.spectra.fluorescence import Fluorophore, Fluorophores

T = TypeVar("T")
Vector = tuple[float, float, float]


def finite(value: object) -> float | None:
    """Return a finite number as a float, None for anything else."""
    if type(value) is not float and (not isinstance(value, Real) or isinstance(value, bool)):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def vector(value: object) -> Vector | None:
    """Return three finite numbers as floats, None for anything else."""
    if not isinstance(value, tuple | list | np.ndarray) or len(value) != 3:
        return None
    x, y, z = map(finite, value)
    return None if x is None or y is None or z is None else (x, y, z)


def unit(vector: np.ndarray) -> np.ndarray:
    """Return a vector scaled to length 1; 0 if it is zero."""
    largest = np.abs(vector).max()
    return vector / largest / np.linalg.norm(vector / largest) if largest > 0 else np.zeros(3)


@dataclass(frozen=True)
class Parameter:
    """What an attribute may be."""

    noun: str  # what a value is, for messages: "half-angle"
    unit: str = ""  # of its numbers
    key: str = ""  # its name in TOML files; the attribute's name by default
    mtl: str = ""  # its statement in MTL files; none by default
    textured: bool = False  # whether it may be a `Texture`
    only: Literal["", "glass", "opaque"] = ""
    """the kind of material that has it; all kinds by default"""
    example: ClassVar[str] = "..."  # A value in a TOML file, for messages

    def check(self, value: Any) -> Any:
        """Return the value in plain Python types, or raise `InputError`.

        Colours and files are checked on reading.
        """
        return value

    def error(self, value: object, remedy: str) -> InputError:
        """Return the error that a value is not what the parameter describes."""
        article = "an" if self.noun[0].lower() in "aeiou" else "a"
        return InputError(f"{shown(value)} is not {article} {self.noun}; {remedy}")


@dataclass(frozen=True)
class Text(Parameter):
    """A name."""

    noun: str = "text"
    example = '"NAME"'

    def check(self, value: Any) -> str:
        """Return a text."""
        if not isinstance(value, str):
            raise self.error(value, "write it in quotes")
        return value


@dataclass(frozen=True)
class Point(Parameter):
    """A position, scene units."""

    noun: str = "point"
    unit: str = "scene units"
    example = "[x, y, z]"

    def check(self, value: Any) -> Vector:
        """Return three finite numbers."""
        numbers = vector(value)
        if numbers is None:
            raise self.error(value, "give three finite numbers")
        return numbers


@dataclass(frozen=True)
class Direction(Point):
    """A direction, of any length but 0."""

    noun: str = "direction"
    unit: str = ""

    def check(self, value: Any) -> Vector:
        """Return three finite numbers that are not all 0."""
        numbers = super().check(value)
        if not any(numbers):
            raise InputError(f"{shown(value)} has no length; give a vector other than zero")
        return numbers


@dataclass(frozen=True)
class Number(Parameter):
    """A finite number: `at_least` and `at_most` belong to its range, `above` and `below` do not."""

    at_least: float = -math.inf
    at_most: float = math.inf
    above: float = -math.inf
    below: float = math.inf
    such_as: str = ""

    def check(self, value: Any) -> float:
        """Return a float within the range."""
        number = finite(value)
        if number is None or not (
            self.at_least <= number <= self.at_most and self.above < number < self.below
        ):
            raise self.error(value, f"give {self.range}")
        return number

    @property
    def range(self) -> str:
        """The range in words."""
        joined = "to " * math.isfinite(self.at_least) + "and " * math.isfinite(self.above)
        limits = [
            f"{word} {limit:g}"
            for word, limit in (
                ("above", self.above),
                ("from", self.at_least),
                ("to", self.at_most),
                (f"{joined}below", self.below),
            )
            if math.isfinite(limit)
        ]
        such_as = f", such as {self.such_as}" if self.such_as else ""
        if not limits:
            return f"a finite number{f' of {self.unit}' if self.unit else ''}{such_as}"
        return f"{self.unit or 'a number'} {' '.join(limits)}{such_as}"


@dataclass(frozen=True)
class Flag(Number):
    """Whether something is so: true or false, in MTL files 1 or 0."""

    noun: str = "flag"
    example = "true"

    def check(self, value: Any) -> bool:
        """Return a bool."""
        if not isinstance(value, bool | int | float) or value not in (0, 1):
            raise self.error(value, "give true or false")
        return bool(value)


@dataclass(frozen=True)
class Whole(Parameter):
    """A whole number from `at_least` to `at_most`; or also 0, if `or_none`."""

    noun: str = "whole number"
    at_least: int = 0
    at_most: int = 1 << 20
    or_none: bool = False
    example = "1"

    def check(self, value: Any) -> int:
        """Return an int within the range."""
        number = finite(value)
        none = self.or_none and number == 0
        if number is None or number % 1 or not (none or self.at_least <= number <= self.at_most):
            start = "0, or " if self.or_none else ""
            remedy = f"give {start}a whole number from {self.at_least} to {self.at_most}"
            raise self.error(value, remedy)
        return int(number)


@dataclass(frozen=True)
class Numbers(Parameter):
    """Several numbers: as many as one of `counts` says, each of which is checked by itself."""

    counts: tuple[int, ...] = ()
    each: Number | Whole = field(default_factory=lambda: Number("number"))
    example = "[...]"

    def check(self, value: Any) -> tuple[float, ...]:
        """Return a tuple."""
        is_list = isinstance(value, list | tuple | np.ndarray)
        if not is_list or len(value) not in self.counts:
            counts = " or ".join(str(count) for count in self.counts if count)
            raise self.error(value, f"give {counts} numbers")
        return tuple(self.each.check(number) for number in value)


@dataclass(frozen=True)
class Part(Parameter):
    """An object with parameters of its own: in TOML a table, whose `type` names its class.

    `kinds` are its classes by type; a table needs no type if there is one class.
    """

    kinds: Mapping[str, type] = field(default_factory=dict)
    example = "{ ... }"

    @classmethod
    def of(cls, noun: str, *kinds: Any) -> Self:
        """Return the parameter of an object of one of some classes."""
        return cls(noun, kinds={kind.kind: kind for kind in kinds})

    def check(self, value: Any) -> Any:
        """Return the object with its attributes in plain Python types."""
        if type(value) not in self.kinds.values():
            names = ", ".join(kind.__name__ for kind in self.kinds.values())
            raise self.error(value, f"give {'one of ' * (len(self.kinds) > 1)}{names}")
        checked = replace(value, **check_parameters(value))
        if problem := checked.find_conflict():
            raise InputError(problem)
        return checked


@dataclass(frozen=True)
class Colored(Parameter):
    """A colour; subclasses say between which values it lies."""

    largest: ClassVar[float]
    remedy: ClassVar[str]
    reader: ClassVar[str]

    def parse(self, text: str, folder: Path) -> Color:
        """Return the colour that a text describes, see `photonmap.spectra.color_text`."""
        from photonmap.spectra import color_text

        return getattr(color_text, self.reader)(text, folder)


@dataclass(frozen=True)
class Emission(Colored):
    """An amount of light in every band: finite and not negative."""

    largest = math.inf
    remedy = "write finite numbers of 0 or more"
    reader = "emission"


@dataclass(frozen=True)
class Reflectance(Colored):
    """A part of the light in every band, within [0, 1]."""

    largest = 1.0
    remedy = "keep it within [0, 1]"
    reader = "reflectance"


@dataclass(frozen=True)
class Fluorescent(Parameter):
    """What a surface takes up and sends out at other wavelengths: one fluorophore or several."""

    noun: str = "fluorescence"
    example = "{ ... }"

    def check(self, value: Any) -> Fluorophores:
        """Return it; several as a tuple, and none as None."""
        several = tuple(value) if isinstance(value, list | tuple) else (value,)
        if not all(isinstance(each, Fluorophore) for each in several):
            raise self.error(value, "give Fluorescence, DonaldsonMatrix, or several of these")
        return several if len(several) > 1 else next(iter(several), None)


@dataclass(frozen=True, kw_only=True)
class File(Parameter):
    """What a file of a `suffix` holds, which `read` returns and `save` writes; or the file."""

    read: Callable[[Path], Any]
    save: Callable[[Any, Path], None]
    suffix: str

    @property
    def example(self) -> str:  # type: ignore[override]
        """A file name in a TOML file."""
        return f'"FILE{self.suffix}"'


def check_parameters(
    described: Any, error: Callable[[str, str], InputError] | None = None
) -> dict[str, Any]:
    """Return the checked values of an object's declared parameters, by attribute.

    None stays where it is the default, and textures are not looked at. An `InputError` begins with
    the attribute that is not valid; or it is that which `error` makes of attribute and problem.
    """
    plain: dict[str, Any] = {}
    kind: Any = type(described)
    defaults = _defaults_of(kind)
    for attribute, parameter in parameters_of(kind).items():
        value = getattr(described, attribute)
        is_none = value is None and defaults[attribute] is None
        if is_none or (parameter.textured and isinstance(value, Texture)):
            continue
        try:
            plain[attribute] = parameter.check(value)
        except InputError as invalid:
            made = error(attribute, str(invalid)) if error else InputError(f"{attribute} {invalid}")
            raise made from None
    return plain


@cache
def _defaults_of(described: Any) -> dict[str, Any]:
    return {each.name: each.default for each in fields(described)}


def parameters_of(described: Any) -> dict[str, Parameter]:
    """Return the declared parameters of a dataclass by attribute, in the order of its fields."""
    return declared(described, Parameter)


@cache
def declared(described: Any, kind: type[T]) -> dict[str, T]:
    """Return what annotations of a dataclass hold of one kind, by attribute."""
    hints = get_type_hints(described, include_extras=True)
    return {
        each.name: found
        for each in fields(described)
        for found in get_args(hints[each.name])
        if isinstance(found, kind)
    }
