"""Scenes of Mitsuba, written and read."""

import numpy as np
import pytest

from photonmap.io.readers.scene_file import load_scene


@pytest.fixture
def load(tmp_path):
    """Write what a scene holds, and files beside it, and load it."""

    def load(inside="", version="3.0.0", files=None, **options):
        for name, content in (files or {}).items():
            content = content.encode() if isinstance(content, str) else content
            (tmp_path / name).parent.mkdir(exist_ok=True)
            (tmp_path / name).write_bytes(content)
        path = tmp_path / "scene.xml"
        path.write_text(f'<scene version="{version}">{inside}</scene>')
        return load_scene(path, **options)

    return load


@pytest.fixture
def look(load):
    """Return the material of a ball that has a BSDF."""

    def look(kind, inside="", **options):
        if kind in ("roughconductor", "roughplastic") and "distribution" not in inside:
            inside += '<string name="distribution" value="ggx"/>'
        scene = load(
            f'<shape type="sphere"><bsdf type="{kind}" id="paint">{inside}</bsdf></shape>',
            **options,
        )
        return scene.meshes[0].material

    return look


@pytest.fixture
def png(tmp_path):
    """Return the content of an image of 2 × 4 texels, magenta in its upper left corner."""
    import OpenImageIO

    texels = np.zeros((2, 4, 3), np.uint8)
    texels[0, 0] = 255, 0, 255
    path = tmp_path / "drawn.png"
    file = OpenImageIO.ImageOutput.create(str(path))
    file.open(str(path), OpenImageIO.ImageSpec(4, 2, 3, "uint8"))
    file.write_image(texels)
    file.close()
    return path.read_bytes()
