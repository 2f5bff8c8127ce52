"""Ground truth for intrinsic images by photon mapping in N spectral bands.

>>> import photonmap as pm
>>> result = pm.render(pm.scenes.cornell_box(), bands=6, size=(256, 256), error=0.02)
>>> result.shading, result.standard_error("shading")
"""

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

# In a checkout, kernels/ and scenes/ stand beside the package.
if not (Path(__file__).parent / "kernels").is_dir():
    __path__.append(str(Path(__file__).parent.parent))

if TYPE_CHECKING:
    import photonmap.dataset as dataset
    import photonmap.scenes as scenes
    from photonmap.bands import Bands
    from photonmap.errors import InputError, SceneWarning
    from photonmap.lights import (
        DirectionalLight,
        DomeLight,
        EnvironmentLight,
        Light,
        PointLight,
        SpotLight,
    )
    from photonmap.merge import merge
    from photonmap.readers.scene_file import load_scene
    from photonmap.render import render
    from photonmap.result import Result, load_result
    from photonmap.scene import Camera, Material, Mesh, Scene
    from photonmap.spectra.curves import Spectrum, SpectrumSet
    from photonmap.spectra.text import emission, reflectance
    from photonmap.textures import Texture
    from photonmap.writers.scene_file import save_scene

__version__ = "0.1.0"

_HOMES = {
    "Bands": "bands",
    "InputError": "errors",
    "SceneWarning": "errors",
    "merge": "merge",
    "render": "render",
    "Result": "result",
    "load_result": "result",
    "Camera": "scene",
    "Material": "scene",
    "Mesh": "scene",
    "Scene": "scene",
    "DirectionalLight": "lights",
    "DomeLight": "lights",
    "EnvironmentLight": "lights",
    "Light": "lights",
    "PointLight": "lights",
    "SpotLight": "lights",
    "load_scene": "readers.scene_file",
    "Spectrum": "spectra.curves",
    "SpectrumSet": "spectra.curves",
    "Texture": "textures",
    "save_scene": "writers.scene_file",
    "emission": "spectra.text",
    "reflectance": "spectra.text",
}
_PARTS = ("dataset", "scenes")
__all__ = [*_HOMES, *_PARTS]


class _Package(ModuleType):
    """Keeps a function from being hidden by the module of its name, once that is imported."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _HOMES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: Numba alone takes half a second."""
    if name in _PARTS:
        return import_module(f"photonmap.{name}")
    if name in _HOMES:
        value = getattr(import_module(f"photonmap.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'photonmap' has no attribute {name!r}")


def __dir__() -> list[str]:
    """List the public names."""
    return [*globals(), *__all__]
