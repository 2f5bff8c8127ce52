"""The images of a data set: what each of them is rendered from, as a pure list."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.dataset.build import LARGEST_SEED, SCENES, draw_illumination
from photonmap.dataset.lighting import Illumination, light
from photonmap.dataset.palette import MATERIALS
from photonmap.dataset.presets import Preset
from photonmap.dataset.views import View
from photonmap.errors import InputError

MOST = 1_000_000
"""Images of a data set."""
_DIGITS = 10


@dataclass(frozen=True)
class Common:
    """What all images of a data set share.

    Parameters
    ----------
    size : (width, height), pixels
    bands : as `photonmap.Bands.parse` takes them
    error : the budget of a render
    materials : of procedural scenes
    recolor : give the user's scenes chips at random
    munsell, illuminants : files of measured sets, or None
    inputs : digest of what the names above stand for
    """

    size: tuple[int, int]
    bands: str
    error: str
    materials: str = MATERIALS[0]
    recolor: bool = False
    munsell: str | None = None
    illuminants: str | None = None
    inputs: str = ""


@dataclass(frozen=True)
class Job:
    """One image; equal jobs give equal arrays with the same versions.

    Parameters
    ----------
    scene : one of `photonmap.dataset.build.SCENES`, or a user's scene file
    seed : of the scene
    illumination : its name
    colors : its lights
    view : where the camera stands
    common : what all images share
    content : digest of the user's scene; "" for procedural ones
    """

    scene: str
    seed: int
    illumination: str
    colors: tuple[str, ...]
    view: View
    common: Common
    content: str = ""

    @property
    def built(self) -> bool:
        """Whether the scene is built from its seed."""
        return not self.content

    @property
    def digest(self) -> str:
        """A hash of all that decides the arrays, wherever files lie."""
        told = self.describe()
        told["scene"] = self.stem
        told["common"] |= {"munsell": None, "illuminants": None}
        return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()

    @property
    def stem(self) -> str:
        """The scene's name."""
        return self.scene if self.built else Path(self.scene).stem

    @property
    def name(self) -> str:
        """The name of the image's folder."""
        view = f"-{self.view.name}" if self.view.name else ""
        head = f"{self.stem}-{self.seed}-{self.illumination}{view}".replace(" ", "_")
        return f"{head}-{self.digest[:_DIGITS]}"

    @property
    def geometry(self) -> str:
        """What images of one scene have in common, whatever its light, colours and view."""
        return f"{self.stem}-{self.seed}" if self.built else f"{self.stem}-{self.content}"

    @property
    def render_seed(self) -> int:
        """The seed of the render: images of one scene have noise of their own."""
        return int(self.digest[:12], 16)

    def describe(self) -> dict[str, Any]:
        """Return the job JSON-able."""
        return json.loads(json.dumps(asdict(self)))

    @classmethod
    def from_description(cls, told: dict[str, Any]) -> Job:
        """Return the job that `describe` described."""
        common = {**told["common"], "size": tuple(told["common"]["size"])}
        parts = {
            "colors": tuple(told["colors"]),
            "view": View(**told["view"]),
            "common": Common(**common),
        }
        return cls(**{**told, **parts})


@dataclass(frozen=True)
class UserScene:
    """A scene file of the user's, and a digest of what it holds."""

    path: str
    content: str = field(repr=False)


def plan_jobs(
    preset: Preset, files: Sequence[UserScene], common: Common, seed: int = 0, count: int = 1
) -> list[Job]:
    """List the images of a preset: seeds, then scenes, illuminations and views in their order.

    Parameters
    ----------
    files : the preset's scene files
    seed : the first one
    count : of seeds

    Raises
    ------
    InputError : a count or a seed out of range, an illumination that is none, or an image that
        comes twice
    """
    each = (len(preset.scenes) + len(files)) * len(preset.illuminations) * len(preset.views)
    if not 1 <= count <= MOST // max(each, 1):
        raise InputError(
            f"count {count} is out of range: the preset has {each} images; "
            f"choose 1 to {MOST // max(each, 1)}"
        )
    if not 0 <= seed <= LARGEST_SEED - count + 1:
        raise InputError(f"seed {seed} must be from 0 to {LARGEST_SEED - count + 1}")
    scenes = [*((name, "") for name in preset.scenes), *((f.path, f.content) for f in files)]
    jobs = [
        Job(scene, drawn, lit.name, lit.colors, view, common, content)
        for drawn in range(seed, seed + count)
        for scene, content in scenes
        for lit in _illuminations(preset, scene, content, drawn)
        for view in preset.views
    ]
    _check(jobs)
    return jobs


def _illuminations(preset: Preset, scene: str, content: str, seed: int) -> Iterator[Illumination]:
    """Draw the colours of a scene's illuminations."""
    name = scene if scene in SCENES and not content else content
    for illumination in preset.illuminations:
        yield draw_illumination(name, seed, illumination)


def _check(jobs: Sequence[Job]) -> None:
    """Refuse lights that are none, and images of one name."""
    for color in {color for job in jobs for color in job.colors}:
        light(color)
    names, counts = np.unique([job.name for job in jobs], return_counts=True)
    if (counts > 1).any():
        raise InputError(f"the image {names[counts > 1][0]} comes twice; name each scene once")
