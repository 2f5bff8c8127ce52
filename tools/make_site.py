"""Put the pages of the documentation's site together, for mkdocs.

    python tools/make_site.py [FOLDER]

The pages keep their places in the repository, so that their links hold: README.md, CHANGELOG.md,
CONTRIBUTING.md, SECURITY.md, docs/ and what they link to, source files included. A folder that is
linked to gets a page that lists its files. docs/api.md is made from the public names.
"""

from __future__ import annotations

import re
import shutil
import sys
from functools import partial
from pathlib import Path

import photonmap

ROOT = Path(__file__).parents[1]
PAGES = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "kernels/README.md")
LINK = re.compile(r"(\]\()([^)#\s:]+)((?:#[^)\s]*)?\))")
GROUPS = {
    "Rendering": (
        "render", "render_views", "settings.Options", "preview", "merge", "load_scene",
        "save_scene", "load_result", "camera_rays",
    ),
    "Results": ("Result",),
    "Scenes": (
        "Scene", "Mesh", "Material", "Texture", "SpectralTexture", "NormalMap", "BumpMap",
        "NoRelief", "AnisotropyMap", "Cauchy", "Sellmeier", "NamedGlass", "Fluorescence",
        "DonaldsonMatrix",
    ),
    "Cameras": (
        "Camera", "Lens", "Intrinsics", "Fisheye", "FisheyeIntrinsics", "Panorama", "RayMap",
    ),
    "Lights": (
        "PointLight", "SpotLight", "PhotometricLight", "DirectionalLight", "DomeLight",
        "SunLight", "SkyLight", "OvercastLight",
        "EnvironmentLight", "AreaLight",
    ),
    "Photos": ("expose", "Sensor", "Photo", "load_sensor", "save_photo", "load_photo"),
    "Spectra and bands": ("Bands", "Spectrum", "SpectrumSet", "reflectance", "emission"),
    "Errors and warnings": ("InputError", "SceneWarning"),
}  # fmt: skip
"""The public names on docs/api.md; and what holds the keywords of `render`."""


def make_site(folder: Path) -> None:
    """Put the pages into a folder, which is emptied first."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT / "docs", folder / "docs")
    for name in PAGES:
        _copy(name, folder)
    for page in sorted(folder.rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        follow = partial(_follow, page.parent.relative_to(folder), folder)
        page.write_text(LINK.sub(follow, text), encoding="utf-8")
    (folder / "docs" / "api.md").write_text(api_page(), encoding="utf-8")


def api_page() -> str:
    """Return the page of the public names, for mkdocstrings."""
    lines = [
        "# API",
        "",
        "`import photonmap as pm` gives all of these names. N is the number of bands.",
    ]
    for title, names in GROUPS.items():
        lines += ["", f"## {title}"]
        for name in names:
            home = photonmap._HOMES.get(name)
            lines += ["", f"::: photonmap.{home}.{name}" if home else f"::: photonmap.{name}"]
    return "\n".join(lines) + "\n"


def _copy(name: str, folder: Path) -> None:
    target = folder / name
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(ROOT / name, target)


def _follow(place: Path, folder: Path, link: re.Match[str]) -> str:
    """Bring what a link leads to, and return the link, to its page if it leads to a folder."""
    target = (ROOT / place / link[2]).resolve()
    name = target.relative_to(ROOT).as_posix()
    if target.is_file() and not (folder / name).exists():
        _copy(name, folder)
    if not target.is_dir():
        return link[0]
    files = sorted(file.name for file in target.iterdir() if file.is_file())
    for file in files:
        _copy(f"{name}/{file}", folder)
    listed = "\n".join(f"- [{file}]({file})" for file in files)
    (folder / name / "index.md").write_text(f"# {name}\n\n{listed}\n", encoding="utf-8")
    return f"{link[1]}{link[2].rstrip('/')}/index.md{link[3]}"


if __name__ == "__main__":
    make_site(Path(sys.argv[1] if sys.argv[1:] else ROOT / "out" / "site-source"))
