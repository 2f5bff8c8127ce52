"""Check a release before it is published: `python tools/check_release.py FOLDER [--compiled]`.

By `make release-check`. The version is the same everywhere; the source distribution and the wheel
that is built from it are complete and described; and each, installed into an empty environment of
every supported Python on this machine, renders a scene outside the checkout. `--compiled` adds the
wheel that brings compiled kernels for the Python that runs this script.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from email.parser import Parser
from pathlib import Path
from zipfile import ZipFile

from make_wheel import ROOT, run

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
VERSIONED = {
    "photonmap/version.py": r'^__version__ = "(.+)"$',
    "CITATION.cff": r"^version: (.+)$",
    "docs/citing.md": r"^  version = \{(.+)\},$",
    "CHANGELOG.md": r"^## ([\d.]+)",
}
"""Files that state the version, and how; in the log of changes, the first heading counts."""
TRIAL = """
import importlib.util, sys
import photonmap as pm
assert not importlib.util.find_spec("kernels"), "the checkout is importable"
assert pm.__version__ == sys.argv[1], pm.__version__
result = pm.render(pm.scenes.cornell_box(), bands=3, size=(16, 16), passes=2)
result.save("box.exr")
assert (pm.load_result("box.exr").radiance == result.radiance).all()
print(pm.scenes.FOLDER)
"""


def main(folder: Path, *, compiled: bool) -> None:
    """Run all checks, and leave the distributions in a folder."""
    version = PROJECT["version"]
    check_versions(version)
    shutil.rmtree(folder, ignore_errors=True)
    run(sys.executable, "-m", "build", "--outdir", folder, ROOT)
    for file in sorted(folder.iterdir()):
        print(f"built {file.name}: {file.stat().st_size / 1e6:.1f} MB")
    run(sys.executable, "-m", "twine", "check", "--strict", *folder.iterdir())
    (wheel,) = folder.glob("*.whl")
    check_description(wheel)
    if compiled:
        print("compiling kernels for the wheel that brings them: minutes", flush=True)
        with tempfile.TemporaryDirectory() as apart:
            run(sys.executable, ROOT / "tools" / "make_wheel.py", apart)
            made = shutil.move(next(Path(apart).glob("*.whl")), folder)
        run(sys.executable, "-m", "twine", "check", "--strict", made)
        print(f"built {Path(made).name}: for this Python only")
    missing = [python for python in supported() if not try_all(python, folder, version)]
    print(f"not found, so not tried: {', '.join(missing)}" if missing else "all Pythons were tried")


def check_versions(version: str) -> None:
    """End unless all files state the version."""
    for name, pattern in VERSIONED.items():
        stated = re.search(pattern, (ROOT / name).read_text("utf-8"), re.M)
        if stated is None or stated[1] != version:
            found = stated[1] if stated else "none"
            sys.exit(f"{name}: states version {found}, but pyproject.toml {version}; correct it")
    print(f"version {version} in pyproject.toml, {', '.join(VERSIONED)}")
    if "(unreleased)" in (ROOT / "CHANGELOG.md").read_text("utf-8"):
        print("CHANGELOG.md says (unreleased): write the date there before publishing")


def check_description(wheel: Path) -> None:
    """End unless the description can be rendered; count links that lead nowhere on PyPI."""
    from readme_renderer import markdown

    with ZipFile(wheel) as archive:
        (name,) = [each for each in archive.namelist() if each.endswith(".dist-info/METADATA")]
        metadata = Parser().parsestr(archive.read(name).decode())
    page = markdown.render(metadata.get_payload())
    if metadata["Description-Content-Type"] != "text/markdown" or not page:
        sys.exit("README.md cannot be rendered as the description; correct its Markdown")
    relative = re.findall(r'(?:href|src)="(?!\w+:|#)([^"]+)"', page)
    remedy = "put the address of the repository before them, or PyPI's page will lack them"
    print(f"the description renders; {len(relative)} links and pictures are relative: {remedy}")


def supported() -> list[str]:
    """Return the versions of Python that the classifiers name, as "3.11"."""
    found = re.findall(r"Python :: (3\.\d+)$", "\n".join(PROJECT["classifiers"]), re.M)
    wanted = PROJECT["requires-python"]
    if not found or wanted != f">={found[0]}":
        sys.exit(f"pyproject.toml: the classifiers name Python {found}, but {wanted} is required")
    return found


def try_all(python: str, folder: Path, version: str) -> bool:
    """Try every distribution for a version of Python; return whether this Python was found."""
    program = next(interpreters(python), None)
    if program is None:
        return False
    tag = f"-cp{python.replace('.', '')}-"
    with tempfile.TemporaryDirectory() as work:
        for file in sorted(folder.iterdir()):
            if file.suffix == ".gz" or "-none-any" in file.name or tag in file.name:
                try_one(program, file, Path(work), version)
                print(f"Python {python}: {file.name} installs and renders", flush=True)
    return True


def interpreters(python: str) -> Iterator[str]:
    """Yield programs that run as this version: on the path, or kept by pyenv."""
    kept = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    candidates = [shutil.which(f"python{python}"), *kept.glob(f"{python}.*/bin/python{python}")]
    for program in filter(None, candidates):
        tell = "import sys, ensurepip; print('%d.%d' % sys.version_info[:2])"
        done = subprocess.run([program, "-c", tell], capture_output=True, text=True, check=False)
        if done.returncode == 0 and done.stdout.strip() == python:
            yield str(program)


def try_one(program: str, file: Path, work: Path, version: str) -> None:
    """Install a distribution into an empty environment, and render with it there.

    Distributions that bring no kernels compile the same ones: these are shared between trials.
    """
    venv = work / "venv"
    run(program, "-m", "venv", "--clear", venv)
    python = venv / "bin" / "python"
    run(python, "-m", "pip", "install", "--constraint", ROOT / "constraints.txt", file)
    run(python, "-m", "pip", "check")
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment = clean | {"NUMBA_CACHE_DIR": str(work / "cache")}
    scenes = run(python, "-c", TRIAL, version, cwd=work, env=environment).strip()
    scene = Path(scenes) / "cornell_box.obj"
    run(venv / "bin" / "photonmap", "info", scene, cwd=work, env=environment)


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if word != "--compiled"]
    main(Path(words[0]).resolve(), compiled="--compiled" in sys.argv)
