"""Record what the golden cases give: `python tests/golden/golden_record.py`, as `make golden` does.

Writes golden.json, the SHA-256 of every array and the machine that they hold for, and golden.npz,
the light of every case with its standard errors, which other machines compare with.
"""

import hashlib
import json
import platform
import sys
import tempfile
import warnings
from importlib.metadata import version
from pathlib import Path

import numpy as np
from llvmlite.binding import get_host_cpu_name

sys.path.insert(0, str(Path(__file__).parent))
from golden_cases import ALL

FOLDER = Path(__file__).parent
HASHES, IMAGES = FOLDER / "golden.json", FOLDER / "golden.npz"
COMPARED = ("radiance", "direct", "indirect", "reflectance", "shading", "fluorescence")
PACKAGES = ("numpy", "numba", "llvmlite", "embreex")


def machine():
    """What arrays may differ by in their last bits: processor and code generators."""
    return {
        "processor": get_host_cpu_name(),
        "system": f"{platform.system()} {platform.machine()}",
        **{name: version(name) for name in PACKAGES},
    }


def arrays_of(result):
    """All arrays of a result by the names that they have in files."""
    return {
        **result.buffers,
        **{f"{name}.error": image for name, image in result.errors.items()},
        **{f"{name}.error8": image for name, image in result.block_errors.items()},
    }


def hashes_of(result):
    """SHA-256 of every array, shapes and types included."""
    hashes = {}
    for name, image in sorted(arrays_of(result).items()):
        digest = hashlib.sha256(f"{image.dtype.str}{image.shape}".encode())
        digest.update(np.ascontiguousarray(image).tobytes())
        hashes[name] = digest.hexdigest()
    return hashes


def images_of(result):
    """What other machines compare with: light, with its standard errors."""
    arrays = arrays_of(result)
    kept = (*COMPARED, *(f"{name}.error" for name in COMPARED))
    return {name: arrays[name] for name in kept if name in arrays}


def main(names):
    """Record the named cases, or all; of new cases, on another machine than that of the hashes,
    the images alone.
    """
    recorded = json.loads(HASHES.read_text())
    is_away = bool(names) and recorded["machine"] != machine()
    if is_away and (known := set(names) & set(recorded["cases"])):
        where = f"{sorted(known)} hold for {recorded['machine']}"
        sys.exit(f"{where}; record all of them (make golden)")
    hashes = recorded["cases"] if names else {}
    images = dict(np.load(IMAGES)) if names else {}
    warnings.simplefilter("ignore")
    for name in names or ALL:
        with tempfile.TemporaryDirectory() as folder:
            result = ALL[name](Path(folder))
        if not is_away:
            hashes[name] = hashes_of(result)
        images |= {f"{name} {part}": image for part, image in images_of(result).items()}
        print(name, flush=True)
    if not is_away:
        HASHES.write_text(json.dumps({"machine": machine(), "cases": hashes}, indent=1) + "\n")
    np.savez_compressed(IMAGES, **images)


if __name__ == "__main__":
    main(sys.argv[1:])
