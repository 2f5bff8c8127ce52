"""Build a wheel that brings compiled kernels: `python tools/make_wheel.py FOLDER`, by `make wheel`.

A wheel without them is built, installed into an environment of its own, and made to compile all
usual kernels for each level of processors that this machine has; they go into the wheel, which then
is for this Python and system. Elsewhere pip takes the source, and kernels are compiled when needed.
"""

import platform
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

ROOT = Path(__file__).parents[1]
LIST = "from photonmap.kernels.core.code_cache import levels; print(*levels())"


def run(*command: object, **options: object) -> str:
    """Run a program quietly, and return what it prints; show all of it if it fails."""
    done = subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, check=False, **options
    )
    if done.returncode:
        sys.exit(f"{done.stdout}{done.stderr}")
    return done.stdout


def tag() -> str:
    """Return the platform tag: a broad one on Linux, as the code calls no certain C library."""
    machine = platform.machine()
    here = re.sub(r"[-.]", "_", sysconfig.get_platform())
    return f"manylinux_2_17_{machine}" if sys.platform == "linux" else here


def main(folder: Path) -> None:
    """Build the wheel into a folder."""
    work = folder / "wheel-build"
    shutil.rmtree(work, ignore_errors=True)
    run(sys.executable, "-m", "pip", "wheel", "--no-deps", "--wheel-dir", work, ROOT)
    run(sys.executable, "-m", "venv", work / "venv")
    python = work / "venv" / "bin" / "python"
    (plain,) = work.glob("photonmap-*.whl")
    run(python, "-m", "pip", "install", "--constraint", ROOT / "constraints.txt", plain, "wheel")
    for level in run(python, "-c", LIST, cwd=work).split():
        print(f"compiling kernels for {level}", flush=True)
        run(python, "-m", "photonmap", "compile", "--quiet", "--output", work / "cache",
            "--processor", level, cwd=work)  # fmt: skip
    run(python, "-m", "wheel", "unpack", "--dest", work / "tree", plain)
    (tree,) = (work / "tree").iterdir()
    shutil.copytree(work / "cache" / "code", tree / "photonmap" / "kernels" / "compiled")
    (work / "packed").mkdir()
    run(python, "-m", "wheel", "pack", "--dest-dir", work / "packed", tree)
    (packed,) = (work / "packed").iterdir()
    version = f"cp{sys.version_info.major}{sys.version_info.minor}"
    run(python, "-m", "wheel", "tags", "--remove", "--python-tag", version, "--abi-tag", version,
        "--platform-tag", tag(), packed)  # fmt: skip
    for old in folder.glob("photonmap-*.whl"):
        old.unlink()
    (made,) = (work / "packed").iterdir()
    shutil.move(made, folder / made.name)
    shutil.rmtree(work)
    print(f"{folder / made.name}: {(folder / made.name).stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
