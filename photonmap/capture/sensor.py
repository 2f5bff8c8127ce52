"""The parameters of a sensor, declared once: options, keys in TOML files and their checks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from photonmap.capture.mosaic import AUTO, METHODS, check_mosaic
from photonmap.capture.optics import check_psf, check_vignetting
from photonmap.errors import InputError, naming
from photonmap.io.readers.toml import read_toml
from photonmap.runtime.options import Option, list_options, option
from photonmap.runtime.wording import shown
from photonmap.spectra.sensitivities import check_camera, table_of

EXPOSURE, ELECTRONICS, OPTICS, COLOR = "exposure", "electronics", "optics", "colour"
GROUPS = (COLOR, EXPOSURE, ELECTRONICS, OPTICS)
"""Headings under which the command line lists the options."""
_LARGEST_SEED = 2**63 - 1


def _number(low: float, high: float, unit: str = "", above: bool = False) -> Callable[[Any], Any]:
    """Return the check of a number from `low` (or above it) to `high`."""

    def check(value: Any) -> float:
        right = isinstance(value, int | float) and not isinstance(value, bool)
        if not (right and low <= value <= high and not (above and value == low)):
            least = f"above {low:g} and up to" if above else f"from {low:g} to"
            raise InputError(f"{value!r} is not a number {least} {high:g}{unit}")
        return float(value)

    return check


def _camera(value: Any) -> Any:
    """Refuse unknown names; a value that is not a text is refused by `Sensor`."""
    return check_camera(value) if isinstance(value, str) else value


def _option(default: Any, group: str, metavar: str | None, text: str, **traits: Any) -> Any:
    """Return a field with its default, and what `photonmap.runtime.options.option` takes."""
    traits = {"read": float, "group": group, "metavar": metavar, **traits}
    return option(default, text, **traits)


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """A camera's lens and sensor: the keywords are the options of `python -m photonmap sensor`.

    Noise is that of the EMVA Standard 1288: shot noise of light and of dark current, read noise,
    the pixels' own gain and offset, and rounding. docs/sensor.md has the equations.

    Raises
    ------
    InputError : a value is out of range, or two do not go together
    """

    # fmt: off
    camera: str = _option("Nikon 5100 (NPL)", COLOR, "NAME", "spectral sensitivities, relative to "
        "power: the name of a camera or observer, a FILE.csv, or bands such as 8 or 400:700:10",
        read=str, check=_camera)
    mosaic: str = _option(AUTO, COLOR, "PATTERN", "pattern of colour filters, row by row: RGGB, or "
        "numbers of bands, as in 1,2,3/4,5,6; none: every pixel has all channels; auto: RGGB, or a "
        "square of all bands", read=str)
    demosaic: str = _option("auto", COLOR, None, "how mosaics are interpolated; auto: malvar "
        "(Malvar, He and Cutler 2004) for 2×2 patterns of three colours, bilinear for others",
        read=str, choices=METHODS)
    time: float | None = _option(None, EXPOSURE, "S", "exposure time, s",
        check=_number(0.0, 1e9, " s", True), default_text="chosen by --percentile and --level")
    percentile: float = _option(97.0, EXPOSURE, "P", "percentage of the lit pixels, other than "
        "those that emit, that an automatic exposure keeps at or below --level",
        check=_number(0.0, 100.0))
    level: float = _option(0.8, EXPOSURE, "F", "fraction of saturation to which an automatic "
        "exposure brings --percentile", check=_number(0.0, 1e6, above=True))
    iso: float = _option(100.0, EXPOSURE, "N", "speed (ISO): gain relative to --base-iso",
        check=_number(1.0, 1e8))
    base_iso: float = _option(100.0, EXPOSURE, "N", "speed (ISO) at which a full well reaches the "
        "white level", check=_number(1.0, 1e8))
    aperture: float = _option(4.0, EXPOSURE, "N", "f-number of the lens", check=_number(0.5, 1e4))
    scale: float = _option(1.0, EXPOSURE, "X", "radiance of which the value in the image is 1, "
        "W·m⁻²·sr⁻¹·nm⁻¹", check=_number(0.0, 1e30, above=True))
    full_well: float = _option(40000.0, ELECTRONICS, "E", "electrons that a pixel can hold",
        check=_number(1.0, 1e9))
    read_noise: float = _option(3.0, ELECTRONICS, "E", "standard deviation of read noise, "
        "electrons", check=_number(0, 1e6))
    dark_current: float = _option(0.1, ELECTRONICS, "E", "electrons per second and pixel",
        check=_number(0, 1e9))
    prnu: float = _option(0.0, ELECTRONICS, "F", "standard deviation of the pixels' gains, as a "
        "fraction (PRNU)", check=_number(0.0, 1.0))
    dsnu: float = _option(0.0, ELECTRONICS, "E", "standard deviation of the pixels' offsets, "
        "electrons (DSNU)", check=_number(0.0, 1e6))
    specimen: int = _option(0, ELECTRONICS, "N", "number of an individual camera: decides the "
        "gains and offsets of its pixels", read=int, whole=(0, _LARGEST_SEED))
    bits: int = _option(14, ELECTRONICS, "N", "bits of the analogue-to-digital converter",
        read=int, whole=(1, 16))
    black_level: int | None = _option(None, ELECTRONICS, "N", "raw number of no light",
        default_text="a 32nd of the range", read=int, whole=(0, 65534))
    pixel_pitch: float = _option(4.8, ELECTRONICS, "UM", "side of a pixel, µm",
        check=_number(0.01, 1e6))
    quantum_efficiency: float = _option(0.5, ELECTRONICS, "F", "electrons per photon at the peak "
        "of the most sensitive channel, lens included", check=_number(0.0, 1.0, above=True))
    vignetting: str = _option("none", OPTICS, "V", "none; cos4: natural vignetting; or a,b,… for "
        "1 + a r² + b r⁴ + …, r = 1 at the farthest corner", read=str, check=check_vignetting)
    psf: str = _option("none", OPTICS, "PSF", "point spread: gaussian:S of standard deviation S, "
        "or defocus:R, a disk of radius R, in pixels; several are joined by +", read=str,
        check=check_psf)
    # fmt: on

    def __post_init__(self) -> None:
        for name, each in list_options(self).items():
            try:
                value = each.checked(getattr(self, name))
            except InputError as error:
                text = str(error)
                raise InputError(text if text.startswith(name) else f"{name} {text}") from None
            object.__setattr__(self, name, value)
        if not isinstance(self.camera, str):
            raise InputError(
                f"camera {shown(self.camera)} is not a text; write a camera's name, 'FILE.csv', or "
                f"bands, as in '6'"
            )
        check_mosaic(self.mosaic)
        if self.black >= self.white:
            raise InputError(
                f"black_level {self.black} must be below the largest number of {self.bits} bits, "
                f"{self.white}"
            )

    @property
    def black(self) -> int:
        """The raw number of no light."""
        return (1 << self.bits) // 32 if self.black_level is None else self.black_level

    @property
    def white(self) -> int:
        """The largest number of the converter."""
        return (1 << self.bits) - 1

    @property
    def saturation(self) -> float:
        """Electrons above `black` at `white`; a full well at the base ISO."""
        return self.full_well * self.base_iso / self.iso

    @property
    def gain(self) -> float:
        """Numbers per electron."""
        return (self.white - self.black) / self.saturation

    def describe(self) -> dict[str, Any]:
        """Return the keywords, JSON-able; of a file of sensitivities its name alone."""
        path = table_of(self.camera)
        return asdict(self) | ({} if path is None else {"camera": path.name})


OPTIONS: dict[str, Option] = list_options(Sensor)  # The options of a sensor by name


def load_sensor(text: str) -> Sensor:
    """Return the sensor of a FILE.toml, whose keys are those of `Sensor`; or that of a camera.

    Raises
    ------
    InputError : there is no such file or camera, or the file has a key or value not permitted
    """
    path = Path(text)
    if path.suffix.lower() != ".toml":
        return replace(Sensor(), camera=text)
    if not path.is_file():
        raise InputError("cannot be read (no such file); check the name", path)
    toml = read_toml(path)
    toml.check_known(OPTIONS, "key")
    values = dict(toml.sections)
    for name, value in values.items():
        if OPTIONS[name].read is float and isinstance(value, int) and not isinstance(value, bool):
            values[name] = float(value)
        if OPTIONS[name].read is str and not isinstance(value, str):
            raise toml.error(f'{name} {value!r} is not a text; write {name} = "…"', name)
    camera = values.get("camera", "")
    if camera and (path.parent / camera).is_file():
        values["camera"] = str(path.parent / camera)
    for name, value in values.items():
        with naming(name, path, toml.line(name)):
            OPTIONS[name].checked(value)
    with naming(str(path)):
        return Sensor(**values)
