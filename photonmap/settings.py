"""The options of a render: one list, from which all else that takes options follows.

A field of `Options` is an option. From it follow the keyword of `photonmap.render` and its
documentation, the flag of every command that takes the option, its checks, the run record, the
fingerprint of the run, and the table in docs/guide.md (`python tools/make_options.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from numbers import Integral
from operator import attrgetter
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from photonmap.buffers import DEFAULT, check_buffers
from photonmap.errors import InputError
from photonmap.film.budget import (
    CEILING,
    DEFAULT_ERROR,
    ENOUGH_PHOTONS,
    LEAST_PHOTONS,
    Budget,
    Goal,
    check_pass_samples,
    usual_photons,
)
from photonmap.integrators.choice import METHODS, choose_integrator
from photonmap.runtime.options import (
    Option,
    check_bytes,
    check_size,
    list_options,
    option,
    read_list,
    read_memory,
    read_size,
)
from photonmap.runtime.progress import CompileNotice, Progress, check_progress, check_watch

if TYPE_CHECKING:
    from photonmap.kernels.core.passes import Film
    from photonmap.results.result import Result
    from photonmap.scene.camera import Camera
    from photonmap.spectra.bands import Bands

MOST_PHOTONS = 1 << 32
"""Largest number of photons emitted per pass."""
MOST_THREADS = 1024

Pixel = Literal["box", "center"]

RENDER, STUDY, DATASET, INFO = "render", "study", "dataset", "info"
"""Commands that take options of a render; `split` takes those of `render`."""

GROUPS = {
    "image": None,
    "budget": f"what comes first of those given ends a render; --error {DEFAULT_ERROR} if none is",
    "sampling": None,
    "resources": None,
    "files": None,
}
"""Headings under which the command line lists the options, and what is said below them."""


def _check_by(module: str, function: str) -> Callable[[Any], Any]:
    """Return a check whose module is imported when it is first needed."""
    return lambda value: attrgetter(function)(import_module(f"photonmap.{module}"))(value)


def _check_error(error: float | str) -> float | str:
    Goal.parse(error)
    return error


def _check_buffers(names: str | Iterable[str]) -> frozenset[str]:
    chosen = read_list(names)
    check_buffers(chosen)
    return frozenset(chosen)


@dataclass(frozen=True, kw_only=True)
class Options:
    """The options of `photonmap.render`, as a user gives them: the one list of them."""

    bands: Bands | int | str = option(
        6,
        "spectral bands: N Gaussians, best:N, box:N, 400:700:10 for Gaussians at 400, 410 … "
        "700 nm, FILE.csv of sensitivities, or the name of a camera or observer; rgb takes the "
        "scene's RGB values as they are",
        group="image", metavar="BANDS", read=str, check=_check_by("spectra.bands", "Bands.parse"),
        commands=(RENDER, STUDY, DATASET, INFO),
    )  # fmt: skip
    size: tuple[int, int] | int = option(
        (512, 512), "width and height of the image, pixels; one number for a square",
        group="image", metavar="WxH", read=read_size, check=check_size,
        commands=(RENDER, STUDY, DATASET),
    )  # fmt: skip
    pixel: Pixel = option(
        "box", "box: samples cover the pixel; center: all pass through its centre",
        group="image", choices=("box", "center"), decides=True, commands=(RENDER, DATASET),
    )  # fmt: skip
    passes: int | None = option(
        None, "stop after this many passes",
        group="budget", metavar="N", read=int,
    )  # fmt: skip
    seconds: float | None = option(
        None, "stop after so many seconds, at any error",
        group="budget", metavar="S", read=float,
    )  # fmt: skip
    error: float | str | None = option(
        None,
        "stop at this relative error of radiance, bias included, as in 0.02; at this relative "
        "standard error, without bias, of another buffer, as in indirect:0.02; or at a "
        "percentile of that over pixels and bands, as in indirect:p95:0.02; "
        f"gives up after {CEILING / 3600:g} hour, or the passes or seconds given",
        group="budget", metavar="E", read=str, check=_check_error, commands=(RENDER, DATASET),
    )  # fmt: skip
    photons: int | None = option(
        None, "photons emitted per pass",
        default_text=f"4 per pixel from {LEAST_PHOTONS} to {ENOUGH_PHOTONS}; larger images: 1",
        group="sampling", metavar="N", read=int, whole=(1, MOST_PHOTONS), decides=True,
    )  # fmt: skip
    seed: int = option(
        0,
        "seed of the random numbers; the same seed and number of passes give the same image, "
        "bit for bit, with any number of threads",
        group="sampling", metavar="N", read=int, whole=(0, 2**63 - 1), decides=True,
        commands=(RENDER, STUDY),
    )  # fmt: skip
    threads: int | None = option(
        None, "number of threads",
        default_text="one per processor", group="resources", metavar="N", read=int,
        whole=(1, MOST_THREADS), commands=(RENDER, STUDY),
    )  # fmt: skip
    method: str = option(
        "photon",
        "; ".join(f"{name}: {method.meaning}" for name, method in METHODS.items()),
        group="sampling", choices=tuple(METHODS), decides=True,
    )  # fmt: skip
    effects: str | Iterable[str] = option(
        "auto",
        "auto: simulate the effects that the scene calls for; all: every effect; or only those "
        "listed, separated by commas",
        group="sampling", metavar="LIST", read=str, decides=True,
        check=_check_by("compile.effects", "parse_effects"),
    )  # fmt: skip
    unbiased: bool = option(
        False,
        "photon mapping without any bias, for scenes without mirrors and glass: paths correct "
        "the cache, and pixels share indirect light by its differences",
        group="sampling", decides=True,
    )  # fmt: skip
    per_light: bool = option(
        False, "also split direct, indirect, caustics and shading by light group",
        group="image", decides=True,
    )  # fmt: skip
    adaptive: bool = option(
        True,
        "adaptive sampling: after 4 passes, more samples where the image is noisy and fewer "
        "elsewhere",
        group="sampling", decides=True,
    )  # fmt: skip
    filter_light: bool = option(
        True,
        "filtered light: direct and indirect light averaged over pixels of a surface where passes "
        "show it to be the same, which errors allow for; never with unbiased or method path",
        group="sampling", decides=True,
    )  # fmt: skip
    pass_samples: float | None = option(
        None, "samples of a pass, as a fraction of the usual: 1, 0.5, 0.25 or 0.125",
        default_text="1; less where a loose error is the goal, if that meets it sooner",
        group="sampling", metavar="F", read=float, check=check_pass_samples,
    )  # fmt: skip
    buffers: str | Iterable[str] | None = option(
        None, "keep only these buffers and their standard errors, which takes less memory",
        written="their names, separated by commas",
        default_text="all; those of gloss only if the scene has some", group="files",
        metavar="LIST", read=read_list, check=_check_buffers,
    )  # fmt: skip
    memory: float | str | None = option(
        None,
        "bytes of RAM to use, as in 512M or 4G, powers of 1024; a render that needs more keeps "
        "its large arrays, including the result's, in scratch files in the temporary folder "
        "(TMPDIR), and gives the same image",
        default_text="no limit", group="resources", metavar="SIZE", read=read_memory,
        check=check_bytes,
    )  # fmt: skip
    checkpoint: str | PathLike[str] | None = option(
        None, "save the state of the render to this file every minute and at the end",
        written="without FILE, to the output's name with the suffix .checkpoint", group="files",
        metavar="FILE", read=str, bare="",
        check=_check_by("runtime.checkpoint", "check_checkpoint"),
    )  # fmt: skip
    resume: bool = option(
        False,
        "continue from the checkpoint as if never interrupted: the budget counts earlier "
        "passes and seconds; start from scratch, with a warning, if there is none yet",
        group="files",
    )  # fmt: skip
    progress: Progress | bool | None = option(
        None,
        "True shows it on stderr: a bar on a terminal, lines elsewhere; None says there only "
        "that kernels are compiled, False nothing; or an object that is notified of every "
        "stage and pass",
        check=check_progress,
    )  # fmt: skip
    watch: Callable[[Result], None] | None = option(
        None,
        "called with the image so far, a `Result` without standard errors, now and then "
        "between passes",
        check=check_watch,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Views(Options):
    """The options of `photonmap.render_views`: those of a render, for each of its cameras."""

    cameras: Sequence[Camera | str] | None = field(
        default=None,
        kw_only=False,
        metadata={
            "option": Option(
                help="that the scene is rendered by, or names of the scene's own",
                default_text="every camera of the scene",
            )
        },
    )


OPTIONS = list_options(Options)
"""All options by name, in the order in which `photonmap.render` lists them."""


def taken_by(command: str) -> list[str]:
    """Return the names of the options that a command takes."""
    return [name for name, each in OPTIONS.items() if each.group and command in each.commands]


@dataclass(frozen=True, kw_only=True)
class Settings(Options):
    """Options that were checked, in the form in which a render uses them.

    Parameters
    ----------
    film : the image: its size, and where samples lie within a pixel
    budget : what ends the render: passes, seconds or an error
    integrator : the name of that of the method
    """

    bands: Bands
    photons: int
    effects: str | frozenset[str]
    buffers: frozenset[str] | None
    memory: float | None
    checkpoint: Path | None
    progress: Progress
    film: Film
    budget: Budget
    integrator: str

    @classmethod
    def of(cls, options: Options) -> Settings:
        """Check all options, and fill in what follows from the others.

        Raises
        ------
        InputError : an option is not permitted, or two of them exclude each other
        """
        from photonmap.kernels.core.passes import Film

        budget = Budget.choose(options.passes, options.seconds, options.error)
        values = {name: each.checked(getattr(options, name)) for name, each in OPTIONS.items()}
        if values["resume"] and values["checkpoint"] is None:
            raise InputError("resume needs the checkpoint to continue from: name its file")
        integrator = choose_integrator(values["method"], values["unbiased"])
        film = Film(*values["size"], values["pixel"] == "box")
        defaults = {
            "photons": usual_photons(film.width * film.height),
            "progress": CompileNotice(),
        }
        values |= {name: value for name, value in defaults.items() if values[name] is None}
        return cls(**values, film=film, budget=budget, integrator=integrator)

    @property
    def pixels(self) -> int:
        """Number of pixels, P."""
        return self.film.width * self.film.height

    @property
    def deciding(self) -> dict[str, Any]:
        """What decides the arrays beside scene, bands and size, JSON-able."""
        return {name: _jsonable(getattr(self, name)) for name, o in OPTIONS.items() if o.decides}

    def describe(self, threads: int) -> dict[str, Any]:
        """Return the arguments for the run record, JSON-able; `threads` is how many there were."""
        kept = {} if self.buffers in (None, {*DEFAULT}) else {"buffers": sorted(self.buffers or ())}
        return {
            "size": [self.film.width, self.film.height],
            "budget": self.budget.describe(),
            "threads": threads,
            **self.deciding,
            **kept,
            "effects": self.effects if isinstance(self.effects, str) else sorted(self.effects),
        }


def _jsonable(value: Any) -> Any:
    """Return what JSON can hold: names as one text, NumPy's whole numbers as Python's."""
    if isinstance(value, frozenset):
        return ",".join(sorted(value))
    return int(value) if isinstance(value, Integral) and not isinstance(value, bool) else value
