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
    from photonmap.render import render
    from photonmap.results.merge import merge
    from photonmap.results.result import Result, load_result
    from photonmap.scene.area_light import AreaLight
    from photonmap.scene.camera import Camera, Lens
    from photonmap.scene.daylight import OvercastLight, SkyLight, SunLight
    from photonmap.scene.lights import (
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
    from photonmap.scene.textures import Texture
    from photonmap.spectra.bands import Bands
    from photonmap.spectra.color_text import emission, reflectance
    from photonmap.spectra.curves import Spectrum, SpectrumSet
    from photonmap.viewer.live import preview

__all__ = [
    "AnisotropyMap",
    "AreaLight",
    "Bands",
    "BumpMap",
    "Camera",
    "Cauchy",
    "DirectionalLight",
    "DomeLight",
    "EnvironmentLight",
    "Fisheye",
    "FisheyeIntrinsics",
    "InputError",
    "Intrinsics",
    "Lens",
    "Light",
    "Material",
    "Mesh",
    "NamedGlass",
    "NoRelief",
    "NormalMap",
    "OvercastLight",
    "Panorama",
    "Photo",
    "PhotometricLight",
    "PointLight",
    "RayMap",
    "Result",
    "Scene",
    "SceneWarning",
    "Sellmeier",
    "Sensor",
    "SkyLight",
    "SpectralTexture",
    "Spectrum",
    "SpectrumSet",
    "SpotLight",
    "SunLight",
    "Texture",
    "__version__",
    "camera_rays",
    "dataset",
    "emission",
    "evaluate",
    "expose",
    "load_photo",
    "load_result",
    "load_scene",
    "load_sensor",
    "merge",
    "preview",
    "reflectance",
    "render",
    "save_photo",
    "save_scene",
    "scenes",
]

_HOMES = {
    "expose": "capture.expose",
    "load_photo": "capture.photo",
    "save_photo": "capture.photo",
    "Photo": "capture.photo",
    "Sensor": "capture.sensor",
    "load_sensor": "capture.sensor",
    "Bands": "spectra.bands",
    "InputError": "errors",
    "SceneWarning": "errors",
    "merge": "results.merge",
    "preview": "viewer.live",
    "render": "render",
    "Result": "results.result",
    "load_result": "results.result",
    "Camera": "scene.camera",
    "Fisheye": "scene.projections",
    "FisheyeIntrinsics": "scene.projections",
    "Intrinsics": "scene.projections",
    "Lens": "scene.camera",
    "Panorama": "scene.projections",
    "RayMap": "scene.projections",
    "camera_rays": "compile.camera",
    "Material": "scene.material",
    "Mesh": "scene.mesh",
    "Scene": "scene.scene",
    "AreaLight": "scene.area_light",
    "OvercastLight": "scene.daylight",
    "SkyLight": "scene.daylight",
    "SunLight": "scene.daylight",
    "DirectionalLight": "scene.lights",
    "DomeLight": "scene.lights",
    "EnvironmentLight": "scene.lights",
    "Light": "scene.lights",
    "PhotometricLight": "scene.lights",
    "PointLight": "scene.lights",
    "SpotLight": "scene.lights",
    "load_scene": "io.readers.scene_file",
    "Spectrum": "spectra.curves",
    "SpectrumSet": "spectra.curves",
    "Cauchy": "scene.surfaces.dispersion",
    "NamedGlass": "scene.surfaces.dispersion",
    "Sellmeier": "scene.surfaces.dispersion",
    "BumpMap": "scene.surfaces.relief",
    "NoRelief": "scene.surfaces.relief",
    "NormalMap": "scene.surfaces.relief",
    "AnisotropyMap": "scene.surfaces.relief",
    "SpectralTexture": "scene.surfaces.spectral_texture",
    "Texture": "scene.textures",
    "save_scene": "io.writers.scene_file",
    "emission": "spectra.color_text",
    "reflectance": "spectra.color_text",
}
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
