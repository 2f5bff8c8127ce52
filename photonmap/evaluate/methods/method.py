"""What a method is, from a view of a scene to an estimate of its layers, and all methods by name.

A package adds a method by an entry point of the group `photonmap.methods`, whose name is the
method's and which refers to a `photonmap.evaluate.methods.method.Method`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points

import numpy as np

from photonmap.errors import InputError
from photonmap.evaluate.metrics.arrays import Floats, Mask, to_grey
from photonmap.runtime.wording import shown, suggest

FLOOR = 3.0 / 257.0
"""Values that logarithms raise darker ones to; white is about 1. In Grosse et al.'s code, it is 3
where 16-bit images go up to 257."""
GROUP = "photonmap.methods"  # The group of entry points
_OF_MODULES = {
    "retinex": "constant-reflectance constant-shading retinex color-retinex weiss",
    **{name: name for name in ("shen", "gehler", "serra", "sirfs", "bell")},
    "illuminants": "grey-world white-patch shades-of-grey grey-edge",
}
BUILT_IN = {name: module for module, names in _OF_MODULES.items() for name in names.split()}
"""Methods of this folder, each with the module that lists it in `METHODS`."""


@dataclass(frozen=True, eq=False)
class View:
    """What a method gets.

    Parameters
    ----------
    name : of the image
    image : (H, W, C) float64, linear; its grey values have their 99th percentile at 1, and
        projection to RGB may have made some negative
    mask : (H, W) bool, of the pixels that will be compared
    relit : the same view in each light there is, this one included; nan where they are not valid
    """

    name: str
    image: Floats
    mask: Mask
    relit: tuple[Floats, ...] = ()

    @property
    def grey(self) -> Floats:
        """The mean over bands, at least `FLOOR`: (H, W)."""
        return np.maximum(to_grey(self.image), FLOOR)

    def copy(self) -> View:
        """Return a view whose arrays a method may change in place."""
        relit = tuple(image.copy() for image in self.relit)
        return View(self.name, self.image.copy(), self.mask.copy(), relit)


@dataclass(frozen=True, eq=False)
class Estimate:
    """What a method finds; None for what it does not estimate. Scales do not matter.

    Parameters
    ----------
    reflectance, shading : (H, W, C) or (H, W), linear
    illuminant : colour of the light, (C,), or of each pixel's, (H, W, C)
    """

    reflectance: Floats | None = None
    shading: Floats | None = None
    illuminant: Floats | None = None


@dataclass(frozen=True)
class Method:
    """A method by name.

    Parameters
    ----------
    name : on the command line and in tables
    estimate : from a `View`, and its settings as keywords, to an `Estimate`
    defaults : the settings, where there are no others
    grid : settings among which each scene's are chosen by the LMSE of all other scenes
    """

    name: str
    estimate: Callable[..., Estimate]
    defaults: Mapping[str, float] = field(default_factory=dict)
    grid: tuple[Mapping[str, float], ...] = ()

    def __post_init__(self) -> None:
        """Raise `InputError` unless `estimate` can be called."""
        if not callable(self.estimate):
            raise InputError(
                f"method {self.name!r} needs a function of a View; got {shown(self.estimate)}"
            )


def with_grey_shading(view: View, shading: Floats) -> Estimate:
    """Return a grey shading (H, W), and the image over it as reflectance."""
    return Estimate(view.image / shading[..., None], shading)


def method_names() -> tuple[str, ...]:
    """Return the names of all methods, those of this folder first."""
    return (*BUILT_IN, *sorted(_added()))


def find_method(name: str) -> Method:
    """Return a method by name.

    Raises
    ------
    InputError : there is none, it cannot be imported, or it has the name of another
    """
    added = _added()
    if name in BUILT_IN:
        if name in added:
            raise InputError(f"{added[name].value} adds a method {name!r}, which exists; rename it")
        module = import_module(f"{__package__}.{BUILT_IN[name]}")
        return next(method for method in module.METHODS if method.name == name)
    if name not in added:
        raise InputError(f"there is no method {name!r}; {suggest(name, method_names())}")
    try:
        method = added[name].load()
    except Exception as error:  # whatever another package's import raises
        raise InputError(
            f"method {name!r} cannot be imported from {added[name].value} ({error})"
        ) from None
    if not isinstance(method, Method):
        raise InputError(f"{added[name].value}, method {name!r}, is not a Method")
    return method


def _added() -> dict[str, EntryPoint]:
    """Return the entry points of installed packages by name."""
    return {point.name: point for point in entry_points(group=GROUP)}
