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

from photonmap.version import __version__

# In a checkout, kernels/ and scenes/ stand beside the package.
if not (Path(__file__).parent / "kernels").is_dir():
    __path__.append(str(Path(__file__).parent.parent))

if TYPE_CHECKING:
    import photonmap.dataset as dataset
    import photonmap.evaluate as evaluate
    import photonmap.scenes as scenes
    from photonmap.capture.expose import expose
    from photonmap.capture.photo import Photo, load_photo, save_photo
    from photonmap.capture.sensor import Sensor, load_sensor
    from photonmap.compile.camera import camera_rays
    from photonmap.errors import InputError, SceneWarning
    from photonmap.io.readers.scene_file import load_scene
    from photonmap.io.writers.scene_file import save_scene
    from photonmap.render import render, render_views
    from photonmap.results.merge import merge
    from photonmap.results.result import Result, load_result
    from photonmap.scene.camera import Camera, Lens
    from photonmap.scene.daylight import OvercastLight, SkyLight, SunLight
    from photonmap.scene.lights import (
        AreaLight,
        DirectionalLight,
        DomeLight,
        EnvironmentLight,
        Light,
        PhotometricLight,
        PointLight,
        SpotLight,
    )
    from photonmap.scene.material import Material
    from photonmap.scene.mesh import Mesh
    from photonmap.scene.projections import (
        Fisheye,
        FisheyeIntrinsics,
        Intrinsics,
        Panorama,
        RayMap,
    )
    from photonmap.scene.scene import Scene
    from photonmap.scene.surfaces.dispersion import Cauchy, NamedGlass, Sellmeier
    from photonmap.scene.surfaces.relief import AnisotropyMap, BumpMap, NoRelief, NormalMap
    from photonmap.scene.surfaces.spectral_texture import SpectralTexture
    from photonmap.scene.textures import Texture
    from photonmap.spectra.bands import Bands
    from photonmap.spectra.color_text import emission, reflectance
    from photonmap.spectra.curves import Spectrum, SpectrumSet
    from photonmap.spectra.fluorescence import DonaldsonMatrix, Fluorescence
    from photonmap.viewer.live import preview

__all__ = [
    "AnisotropyMap", "AreaLight", "Bands", "BumpMap", "Camera", "Cauchy", "DirectionalLight",
    "DomeLight", "DonaldsonMatrix", "EnvironmentLight", "Fisheye", "FisheyeIntrinsics",
    "Fluorescence", "InputError", "Intrinsics", "Lens", "Light", "Material", "Mesh", "NamedGlass",
    "NoRelief", "NormalMap", "OvercastLight", "Panorama", "Photo", "PhotometricLight", "PointLight",
    "RayMap", "Result", "Scene", "SceneWarning", "Sellmeier", "Sensor", "SkyLight",
    "SpectralTexture", "Spectrum", "SpectrumSet", "SpotLight", "SunLight", "Texture", "__version__",
    "camera_rays", "dataset", "emission", "evaluate", "expose", "load_photo", "load_result",
    "load_scene", "load_sensor", "merge", "preview", "reflectance", "render", "render_views",
    "save_photo", "save_scene", "scenes",
]  # fmt: skip

_NAMES_BY_MODULE = {
    "capture.expose": "expose",
    "capture.photo": "Photo load_photo save_photo",
    "capture.sensor": "Sensor load_sensor",
    "compile.camera": "camera_rays",
    "errors": "InputError SceneWarning",
    "io.readers.scene_file": "load_scene",
    "io.writers.scene_file": "save_scene",
    "render": "render render_views",
    "results.merge": "merge",
    "results.result": "Result load_result",
    "scene.camera": "Camera Lens",
    "scene.daylight": "OvercastLight SkyLight SunLight",
    "scene.lights": "AreaLight DirectionalLight DomeLight EnvironmentLight Light PhotometricLight "
    "PointLight SpotLight",
    "scene.material": "Material",
    "scene.mesh": "Mesh",
    "scene.projections": "Fisheye FisheyeIntrinsics Intrinsics Panorama RayMap",
    "scene.scene": "Scene",
    "scene.surfaces.dispersion": "Cauchy NamedGlass Sellmeier",
    "scene.surfaces.relief": "AnisotropyMap BumpMap NoRelief NormalMap",
    "scene.surfaces.spectral_texture": "SpectralTexture",
    "scene.textures": "Texture",
    "spectra.bands": "Bands",
    "spectra.color_text": "emission reflectance",
    "spectra.curves": "Spectrum SpectrumSet",
    "spectra.fluorescence": "DonaldsonMatrix Fluorescence",
    "viewer.live": "preview",
}
_HOMES = {name: home for home, names in _NAMES_BY_MODULE.items() for name in names.split()}
_PARTS = ("dataset", "evaluate", "scenes")


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
