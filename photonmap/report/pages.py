"""Pages of one look, rendered from templates, with their pictures in them.

Templates extend `base.html`, whose style is `page.css`; text in them is escaped.
"""

from __future__ import annotations

import base64
import io
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from photonmap.io.png import encode_png

if TYPE_CHECKING:
    from jinja2 import Environment

_TEMPLATES = Path(__file__).parent / "templates"
_QUALITY = 88  # of WebP, percent


def has_jinja() -> bool:
    """Return whether Jinja, which `render_page` needs, is installed."""
    return find_spec("jinja2") is not None


def render_page(package: str, template: str, **values: Any) -> str:
    """Return a page as HTML: values in a template of a package, which has a folder of them."""
    return _templates_of(package).get_template(template).render(values)


@cache
def _templates_of(package: str) -> Environment:
    """Return the templates of a package, each compiled when it is first rendered."""
    from jinja2 import ChoiceLoader, Environment, PackageLoader

    loader = ChoiceLoader([PackageLoader(package), PackageLoader(__package__)])
    return Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)


def stylesheet() -> str:
    """Return the style that all pages have in common."""
    return (_TEMPLATES / "page.css").read_text(encoding="utf-8")


def png_uri(image: NDArray[np.uint8]) -> str:
    """Return an (H, W, 3) uint8 sRGB image as PNG in a data URI."""
    return _data_uri("png", encode_png(image))


def webp_uri(image: NDArray[np.uint8]) -> str:
    """Return an (H, W, 3) uint8 sRGB image as WebP, small and with losses, in a data URI."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(image).save(file, "WEBP", quality=_QUALITY, method=6)
    return _data_uri("webp", file.getvalue())


def _data_uri(kind: str, data: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"
