"""The plan of a data set: a list of jobs, each of which describes one image completely."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.dataset.files.inside import fault_of, inside
from photonmap.dataset.files.manifest import CURVES, kept_as, role_of_light, seen_from, with_table
from photonmap.dataset.files.splits import part_of
from photonmap.dataset.jobs.presets import Preset
from photonmap.dataset.models.materials import MATERIALS
from photonmap.dataset.scenes.build import LARGEST_SEED, check_looks, draw_illumination
from photonmap.dataset.scenes.illumination import digest_of_light, light_spectrum
from photonmap.dataset.scenes.views import View
from photonmap.errors import InputError, naming, warn
from photonmap.report.tables import aligned
from photonmap.runtime.wording import shown
from photonmap.spectra.bands import Bands
from photonmap.spectra.projection import REC2020

MAX_IMAGES = 1_000_000
"""Largest number of images in a data set."""
CONTENT, TEXT = "content", "text"
"""What identifies files of bands and RGB: what is in them; in old sets, how they were written."""
_USUAL = {"lightness": None, "scale": 1.0, "own_noise": True}
"""Values at which settings leave the names and the noise of images as they were before there were
such settings."""
_DIGITS = 10  # digits of a job's hash in the name of its folder


@dataclass(frozen=True)
class CommonSettings:
    """Settings that all images of a data set share.

    Parameters
    ----------
    size : (width, height), pixels
    bands : as `photonmap.Bands.parse` takes them
    error : at which a render stops, as `photonmap.render` takes it
    rgb : space of images in RGB, see `photonmap.spectra.projection`
    pixel : where samples lie in a pixel, as `photonmap.render` takes it
    materials : of procedural scenes, one of `photonmap.dataset.models.materials.MATERIALS`
    lightness, scale : of procedural scenes, see `photonmap.dataset.scenes.build.build_scene`
    recolor : give the surfaces of the user's scenes random Munsell chips
    munsell, illuminants : paths of measured sets, or None
    inputs : digest of the band curves and of the files of measured sets
    identity : what identifies files of bands and RGB, `CONTENT` or `TEXT`
    own_noise : render each image by itself; otherwise those of one view that differ in their light
        alone are rendered together, and share their noise
    """

    size: tuple[int, int]
    bands: str
    error: str
    pixel: str = "box"
    rgb: str = REC2020
    materials: str = MATERIALS[0]
    lightness: float | None = None
    scale: float = 1.0
    recolor: bool = False
    munsell: str | None = None
    illuminants: str | None = None
    inputs: str = ""
    identity: str = CONTENT
    own_noise: bool = True

    @property
    def is_by_content(self) -> bool:
        """Whether the name and the place of a file do not matter."""
        return self.identity == CONTENT

    def without_files(self) -> dict[str, Any]:
        """Return what decides the arrays, but for the names of files; `inputs` stands for them."""
        described = asdict(self) | {"munsell": None, "illuminants": None}
        del described["identity"]
        for name, usual in _USUAL.items():
            if described[name] == usual:
                del described[name]
        if self.is_by_content:
            described |= {name: with_table(described[name], lambda _: "") for name in CURVES}
        return described

    def with_curves(self, rename: Callable[[str, Path], str]) -> CommonSettings:
        """Return the settings with their files of sensitivities renamed, by what they are for."""
        if not self.is_by_content:
            return self
        bands, rgb = (
            with_table(getattr(self, role), lambda path, role=role: rename(role, path))  # type: ignore[misc]
            for role in CURVES
        )
        return replace(self, bands=bands, rgb=rgb)

    def __post_init__(self) -> None:
        """Check the lightness and the scale before anything is rendered."""
        check_looks(self.lightness, self.scale)


@dataclass(frozen=True)
class Job:
    """One image; with equal versions, equal jobs give equal arrays."""

    scene: str  # one of `photonmap.dataset.scenes.build.SCENES`, or a user's scene file
    seed: int  # of the scene
    illumination: str  # name of the illumination
    colors: tuple[str, ...]  # its lights, see `photonmap.dataset.scenes.illumination.Illumination`
    view: View  # position of the camera
    common: CommonSettings  # settings that all images share
    content: str = ""  # digest of the user's scene; "" for procedural scenes
    shares: tuple[float, ...] = ()  # of the lights; () for the usual ones
    # digests of the lights that are files, "" for others; () if none is a file
    spectra: tuple[str, ...] = ()

    @property
    def is_procedural(self) -> bool:
        """Whether the scene is procedural."""
        return not self.content

    @property
    def digest(self) -> str:
        """Hash of everything that decides the arrays, independent of where files are."""
        description = self.describe()
        description["scene"] = self.stem
        description["common"] = self.common.without_files()
        description["colors"] = self._with_lights(lambda digest, _: digest).colors
        del description["spectra"]
        if not self.shares:
            del description["shares"]
        return hashlib.sha256(json.dumps(description, sort_keys=True).encode()).hexdigest()

    @property
    def stem(self) -> str:
        """Name of the scene; of the user's scene, that of its file without folder and suffix."""
        return self.scene if self.is_procedural else Path(self.scene).stem

    @property
    def name(self) -> str:
        """Name of the image, and of its folder."""
        view = f"-{self.view.name}" if self.view.name else ""
        head = f"{self.stem}-{self.seed}-{self.illumination}{view}".replace(" ", "_")
        return f"{head}-{self.digest[:_DIGITS]}"

    @property
    def geometry(self) -> str:
        """Name of the scene as images share it, whatever the illumination, colours and view."""
        return f"{self.stem}-{self.seed}" if self.is_procedural else f"{self.stem}-{self.content}"

    @property
    def own_seed(self) -> int:
        """A seed that no other image has."""
        return int(self.digest[:12], 16)

    @property
    def in_any_light(self) -> Job:
        """What the job has in common with those of the same view in other light."""
        return replace(self, illumination="", colors=(), shares=(), spectra=())

    @property
    def render_seed(self) -> int:
        """Seed of the render; images of a view in different light have one in common.

        With noise of their own, every image has its own.
        """
        return self.own_seed if self.common.own_noise else self.in_any_light.own_seed

    @property
    def described_light(self) -> dict[str, Any]:
        """What `describe` says of the light: where jobs of one view differ."""
        described = self.describe()
        return {name: described[name] for name in ("illumination", "colors", "shares", "spectra")}

    def relative_to(self, folder: Path) -> Job:
        """Return the job with files named as seen from a data set's folder, as its manifest does.

        Curves are the copies in the folder; of files far from it the names are left.
        """
        job = self._with_files(lambda path: seen_from(folder, path))
        job = job._with_lights(lambda digest, path: kept_as(role_of_light(digest), path))
        return replace(job, common=job.common.with_curves(kept_as))

    def located(self, folder: Path) -> Job:
        """Return the job whose files are named as `relative_to` does, with the places they have."""

        def beside(path: str) -> str:
            below = path.removeprefix("../")  # as `seen_from` names it; others are named alone
            near = path if fault_of(below) == "" else Path(path).name
            return os.path.normpath(folder.resolve() / near)

        def kept(path: Path) -> str:
            return os.path.normpath(inside(folder.resolve(), path.as_posix()))

        job = self._with_files(beside)._with_lights(lambda _, path: kept(path))
        return replace(job, common=job.common.with_curves(lambda _, path: kept(path)))

    def light_files(self) -> list[tuple[str, str]]:
        """Return the lights that are files, each with its digest."""
        pairs = zip(self.colors, self.spectra or [""] * len(self.colors), strict=True)
        return [(color, digest) for color, digest in pairs if digest]

    def _with_lights(self, rename: Callable[[str, Path], str]) -> Job:
        """Return the job with the files of its lights renamed, by their digests."""
        renamed = {
            color: with_table(color, lambda path, digest=digest: rename(digest, path))  # type: ignore[misc]
            for color, digest in self.light_files()
        }
        return replace(self, colors=tuple(renamed.get(color, color) for color in self.colors))

    def _with_files(self, rename: Callable[[str], str]) -> Job:
        """Return the job with its scene file and its measured sets renamed."""
        sets = self.common.munsell, self.common.illuminants
        munsell, illuminants = (path and rename(path) for path in sets)
        scene = self.scene if self.is_procedural else rename(self.scene)
        common = replace(self.common, munsell=munsell, illuminants=illuminants)
        return replace(self, scene=scene, common=common)

    def describe(self) -> dict[str, Any]:
        """Return the job as a JSON-able dict."""
        return json.loads(json.dumps(asdict(self) | {"view": self.view.describe()}))

    @classmethod
    def from_description(cls, description: dict[str, Any]) -> Job:
        """Return the job that `describe` described; raise `InputError` if that is damaged."""
        lists = ("colors", "shares", "spectra")
        try:
            given = description["common"]
            common = {"identity": TEXT, **given, "size": tuple(given["size"])}
            parts: dict[str, Any] = {name: tuple(description.get(name, ())) for name in lists}
            parts |= {"view": View(**description["view"]), "common": CommonSettings(**common)}
            return cls(**{**description, **parts})
        except (KeyError, TypeError) as error:
            raise InputError(f"does not describe a job ({error}); see `dataset verify`") from None


@dataclass(frozen=True)
class UserScene:
    """A scene file of the user, a digest of the scene in it, and how many light groups it has."""

    path: str
    content: str = field(repr=False)
    groups: int


def plan_jobs(
    preset: Preset,
    files: Sequence[UserScene],
    common: CommonSettings,
    seed: int = 0,
    count: int = 1,
) -> list[Job]:
    """List the jobs of a preset, ordered by seed, scene, illumination and view.

    Parameters
    ----------
    files : scene files of the preset
    common : settings of all images
    seed, count : the first of the seeds, and the number of consecutive ones
    """
    each = (len(preset.scenes) + len(files)) * len(preset.illuminations) * len(preset.views)
    most = MAX_IMAGES // max(each, 1)
    if not 1 <= count <= most:
        raise InputError(
            f"count {count} is out of range: the preset has {each} images per seed; "
            f"choose 1 to {most}"
        )
    if not 0 <= seed <= LARGEST_SEED - count + 1:
        raise InputError(f"seed {seed} must be from 0 to {LARGEST_SEED - count + 1}")
    scenes = [*((name, "") for name in preset.scenes), *((f.path, f.content) for f in files)]
    bands = Bands.parse(common.bands)
    jobs = [
        Job(scene, drawn, lit.name, lit.colors, view, common, content, lit.shares)
        for drawn in range(seed, seed + count)
        for scene, content in scenes
        for given in preset.illuminations
        for lit in [draw_illumination(content or scene, drawn, given, bands)]
        for view in preset.views
    ]
    jobs = _identify_lights([_as_split(job, preset) for job in jobs])
    _check(jobs, bands)
    _warn_of_colors(files, jobs)
    _warn_of_unused(preset, jobs)
    return jobs


def _identify_lights(jobs: list[Job]) -> list[Job]:
    """Give jobs the digests of lights that are files."""
    digests = {color: digest_of_light(color) for color in {c for job in jobs for c in job.colors}}
    files = {color for color, digest in digests.items() if digest}
    for place, job in enumerate(jobs):
        if files.intersection(job.colors):
            jobs[place] = replace(job, spectra=tuple(digests[color] for color in job.colors))
    return jobs


def _as_split(job: Job, preset: Preset) -> Job:
    """Return a job with the size and the angle of view of the split that its scene belongs to."""
    look = preset.splits.get(part_of(job.geometry))
    if look is None:
        return job
    size = job.common.size if look.size is None else look.size
    fov = look.fov if job.view.fov is None else job.view.fov
    return replace(job, common=replace(job.common, size=size), view=replace(job.view, fov=fov))


def _warn_of_colors(files: Sequence[UserScene], jobs: Sequence[Job]) -> None:
    """Warn of images that will fail, as their scenes have fewer light groups than colours."""
    groups = {file.path: file.groups for file in files}
    short = [job for job in jobs if len(job.colors) > groups.get(job.scene, len(job.colors))]
    for scene, illumination in dict.fromkeys((job.scene, job.illumination) for job in short):
        warn(
            f"{scene}: has fewer light groups ({groups[scene]}) than illumination {illumination!r} "
            "has colours: those images will fail; leave this illumination out, or add lights"
        )


def _warn_of_unused(preset: Preset, jobs: Sequence[Job]) -> None:
    """Warn of the looks of splits to which no scene belongs."""
    scenes = {job.geometry for job in jobs}
    for part in sorted(set(preset.splits) - set(map(part_of, scenes))):
        warn(
            f"{preset.name}: [split.{part}] is not used, as by hash none of the set's "
            f"{len(scenes)} scenes (names with seeds) belongs to {part!r}; add scenes with "
            "--count, or remove the section"
        )


def _check(jobs: Sequence[Job], bands: Bands) -> None:
    """Reject lights not known in all bands, images of equal names, and names of no folder."""
    for job in jobs:
        if why := fault_of(job.name, is_part=True):
            problem = f"the image {shown(job.name)} cannot have a folder, as its name {why}"
            raise InputError(f"{problem}; rename the scene file")
    for name, color in sorted({(job.illumination, color) for job in jobs for color in job.colors}):
        with naming(f"illumination {name!r}, light {color!r}"):
            bands.emission(light_spectrum(color))
    names, counts = np.unique([job.name for job in jobs], return_counts=True)
    if (counts > 1).any():
        name = names[counts > 1][0]
        remedy = "name each scene and each illumination once"
        raise InputError(f"the image {name} would be rendered twice; {remedy}")


def list_jobs(jobs: Sequence[Job]) -> Iterator[str]:
    """Yield a table of the images, a line each, and what they share."""
    rows: list[Sequence[Any]] = [("image", "seed", "illumination", "lights", "view")]
    for job in jobs:
        shares = job.shares and [f" {share:.1%}" for share in job.shares]
        colors = [with_table(color, lambda path: path.name) for color in job.colors]
        lights = " + ".join(map(str.__add__, colors, shares or [""] * len(colors)))
        rows.append((job.name, job.seed, job.illumination, lights, job.view.name or "its own"))
    yield from aligned(rows)
    common = jobs[0].common
    sizes = dict.fromkeys("{}x{}".format(*job.common.size) for job in jobs)
    yield f"{len(jobs)} images of {' and '.join(sizes)}, bands {common.bands}, error {common.error}"
