"""Run the Python of docs/gallery.md, which renders its pictures into docs/gallery/."""

from __future__ import annotations

import os
import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "gallery.md"


def gallery_code() -> str:
    """Return the Python of the page."""
    text = PAGE.read_text(encoding="utf-8")
    return "\n".join(re.findall(r"^```python\n(.*?)^```", text, re.M | re.S))


def run(code: str, folder: Path) -> None:
    """Run the page's code, to write the pictures into a folder."""
    import matplotlib

    matplotlib.use("Agg")
    folder.mkdir(parents=True, exist_ok=True)
    os.chdir(folder)
    exec(code.replace('"scenes/', f'"{ROOT}/scenes/'), {})


if __name__ == "__main__":
    run(gallery_code(), PAGE.parent / "gallery")
