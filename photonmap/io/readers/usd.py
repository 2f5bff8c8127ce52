"""Read USD stages: text, binary and packages. Needs pxr, `pip install 'photonmap[usd]'`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers import decoding, meshes
from photonmap.io.readers.decoding import Ints, plain
from photonmap.io.readers.environment_maps import turned_map
from photonmap.io.readers.registry import GREY, OR_WITHOUT, ReadOptions, extended
from photonmap.runtime.files import named_file, named_image
from photonmap.runtime.wording import shown
from photonmap.scene.camera import Camera, Lens, check_camera
from photonmap.scene.images import Channels, Image, read_channels
from photonmap.scene.lights import DirectionalLight, DomeLight, Light, PointLight, SpotLight
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.projections import Intrinsics
from photonmap.scene.scene import Scene
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.layers import check_material
from photonmap.scene.surfaces.metallic import USUAL_INDEX, metallic_gloss
from photonmap.scene.surfaces.relief import NormalMap
from photonmap.scene.textures import Texture, Triple, is_black, mean_number
from photonmap.spectra.curves import Floats

if find_spec("pxr") is not None:
    from pxr import Ar, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdShade, UsdUtils

SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")

_SILENT = (
    "", "Xform", "Scope", "Material", "Shader", "GeomSubset", "NodeGraph", "Skeleton", "SkelRoot",
)  # fmt: skip
"""Types of prims that show nothing by themselves."""


def read(path: Path, options: ReadOptions) -> Scene:
    """Read the meshes, preview surfaces, lights and cameras of a stage, as it begins.

    Units of length are those of the stage; y is up.
    """
    if find_spec("pxr") is None:
        raise InputError("needs usd-core: pip install 'photonmap[usd]'", path)
    return decoding.decode_file(path, partial(_decode, options))


def _decode(options: ReadOptions, path: Path, data: bytes, losses: decoding.Losses) -> Scene:
    quiet = UsdUtils.CoalescingDiagnosticDelegate()  # what pxr would print
    stage = Stage(path, open_stage(path), options, losses)
    cameras, surfaces, lights = list[Camera](), list[Mesh](), list[Light]()
    for prim in Usd.PrimRange.Stage(stage.stage, Usd.TraverseInstanceProxies()):
        kind = prim.GetTypeName()
        try:
            if prim.IsA(UsdGeom.Camera):
                cameras.append(read_camera(stage, prim))
            elif kind in SHAPES and is_shown(prim):
                surfaces += read_meshes(stage, prim)
            elif is_light(prim) and is_shown(prim):
                found = read_light(stage, prim)
                surfaces += [found] if isinstance(found, Mesh) else []
                lights += [found] if isinstance(found, Light) else []
            elif kind not in (*_SILENT, *SHAPES) and not is_light(prim):
                decoding.note_loss(losses, kind, prim.GetName())
        except InputError as error:
            if str(path) in str(error):
                raise
            raise InputError(f"{prim.GetName()}: {error}", path) from None
    quiet.TakeUncoalescedDiagnostics()
    return Scene(surfaces, name=path.stem, cameras=cameras, lights=lights)


WHITE = 6500.0  # Temperature, K, of lights whose colour is as given
MOST_LAYERS = 1000  # Files that a stage may be composed of
_UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""From z up to y up."""


@dataclass
class Stage:
    """An opened stage, and its materials."""

    path: Path  # its file
    stage: Any  # of pxr
    options: ReadOptions  # a user's choices
    losses: decoding.Losses  # takes what is not simulated
    _names: set[str] = field(default_factory=set)
    _materials: dict[str, Material] = field(default_factory=dict)

    def lose(self, what: str, prim: Any) -> None:
        """Note what is not simulated."""
        decoding.note_loss(self.losses, what, prim.GetName())

    def matrix(self, prim: Any) -> Floats:
        """Return the matrix of a prim, 4×4, from its coordinates to those of the scene."""
        time = self.stage.GetStartTimeCode()
        moved = UsdGeom.Imageable(prim).ComputeLocalToWorldTransform(time)
        is_z_up = UsdGeom.GetStageUpAxis(self.stage) == UsdGeom.Tokens.z
        matrix = np.array(moved, np.float64).T
        return _UPRIGHT @ matrix if is_z_up else matrix

    def value(self, attribute: Any, default: Any = None) -> Any:
        """Return what an attribute holds when the stage begins."""
        found = attribute.Get(self.stage.GetStartTimeCode()) if attribute else None
        return default if found is None else found

    def name(self, prim: Any) -> str:
        """Return the name of a prim, with a number where another has it."""
        name, count = prim.GetName(), 1
        while name in self._names:
            count += 1
            name = f"{prim.GetName()}_{count}"
        self._names.add(name)
        return str(name)

    def material(self, bound: Any) -> Material:
        """Return the material of a binding, the same one each time; grey without one."""
        material = bound.ComputeBoundMaterial()[0]
        path = str(material.GetPath()) if material else ""
        if path not in self._materials:
            self._materials[path] = self._read(material) if material else Material("default")
        return self._materials[path]

    def _read(self, material: Any) -> Material:
        prim, name = material.GetPrim(), str(material.GetPrim().GetName())
        shader = material.ComputeSurfaceSource()[0]
        if not shader or shader.GetShaderId() != _PREVIEW:
            self.lose("shaders other than UsdPreviewSurface", prim)
            return Material(name)
        try:
            return check_material(_Surface(self, shader, prim).material(name))
        except InputError as error:
            raise InputError(f"material {name}: {error}", self.path) from None


def open_stage(path: Path) -> Any:
    """Return a stage all of whose layers lie where files may be opened."""
    try:
        root = Sdf.Layer.FindOrOpen(str(path))
    except Tf.ErrorException:
        root = None
    if root is None:
        raise InputError("is not a USD stage, or is damaged; export it again", path)
    seen, waiting = {root.realPath}, [root]
    while waiting:
        layer = waiting.pop()
        folder = Path(layer.realPath.split("[")[0]).parent
        for name in layer.GetCompositionAssetDependencies():
            if ".usdz[" in layer.realPath or path.suffix.lower() == ".usdz":
                break  # packages hold all of their layers
            below = Sdf.Layer.FindOrOpen(str(named_file(folder, name)))
            if below is not None and below.realPath not in seen:
                seen.add(below.realPath)
                waiting.append(below)
            if len(seen) > MOST_LAYERS:
                raise InputError(f"is composed of more than {MOST_LAYERS} files; merge them", path)
    return Usd.Stage.Open(root)


def read_image(stage: Stage, asset: Any) -> Channels:
    """Return the image of an asset, which may lie in a package."""
    name = getattr(asset, "resolvedPath", "") or getattr(asset, "path", "")
    if ".usdz[" not in name:
        return read_channels(named_image(stage.path.parent, name))
    inside = Path(name.partition("[")[2].rstrip("]"))
    data = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(name))
    if data is None:
        raise InputError(f"{shown(str(inside))} is not in the package; export it again")
    return decoding.read_embedded(data.GetBuffer(), f"image{inside.suffix}")


def is_shown(prim: Any) -> bool:
    """Return whether a prim is visible when rendered."""
    item = UsdGeom.Imageable(prim)
    if not item or item.ComputeVisibility() == UsdGeom.Tokens.invisible:
        return False
    return item.ComputePurpose() in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


def is_light(prim: Any) -> bool:
    """Return whether a prim is a light."""
    return bool(prim.HasAPI(UsdLux.LightAPI))


def radiance_of(stage: Stage, light: Any) -> Floats:
    """Return intensity · 2^exposure · colour of a light, (3,), before any normalisation."""
    color = np.array(stage.value(light.GetColorAttr(), (1.0, 1.0, 1.0)), np.float64)
    if stage.value(light.GetEnableColorTemperatureAttr(), False):
        kelvin = stage.value(light.GetColorTemperatureAttr(), 6500.0)
        warmth = [UsdLux.BlackbodyTemperatureAsRgb(each) for each in (kelvin, WHITE)]
        color = color * np.array(warmth[0], np.float64) / warmth[1]
    exposure = stage.value(light.GetExposureAttr(), 0.0)
    factor = stage.value(light.GetIntensityAttr(), 1.0) * 2.0**exposure
    amount: Floats = factor * color * stage.value(light.GetDiffuseAttr(), 1.0)
    if not (np.isfinite(amount).all() and (amount >= 0.0).all() and math.isfinite(factor)):
        raise InputError(f"light {light.GetPrim().GetName()} is negative or not finite; correct it")
    return amount


_PREVIEW, _TEXTURE, _PLACE = "UsdPreviewSurface", "UsdUVTexture", "UsdTransform2d"
_GRAY = (0.18, 0.18, 0.18)  # diffuseColor where none is given
_CHANNELS: dict[str, Callable[[Channels], Image]] = {"g": Channels.green, "b": Channels.blue}


@dataclass
class _Surface:
    """A preview surface: its shader, and the prim of its material."""

    stage: Stage
    shader: Any
    prim: Any

    def material(self, name: str) -> Material:
        """Return what it looks like."""
        if self._value("displacement", 0.0) != 0.0:
            self.stage.lose("displacement", self.prim)
        base, roughness = self.color("diffuseColor", _GRAY), self.data("roughness", 0.5)
        look: dict[str, Any]
        if self._value("useSpecularWorkflow", 0):
            glossy = self.color("specularColor", (0.0, 0.0, 0.0))
            look = {"reflectance": base, "glossy": glossy, "roughness": roughness}
        else:
            lobe = normal_reflectance(max(float(self._value("ior", USUAL_INDEX)), 1.0))
            look = metallic_gloss(base, self.data("metallic", 0.0), lobe, roughness)._asdict()
        coat = self.data("clearcoat", 0.0)
        if not is_black(coat):
            look |= {"coat": coat, "coat_roughness": self.data("clearcoatRoughness", 0.01)}
        if normal := self._texture("normal", Channels.data):
            look["relief"] = NormalMap(normal)
        emission = self.color("emissiveColor", (0.0, 0.0, 0.0))
        if not is_black(emission):
            look["emission"] = emission
        return Material(name, alpha=self.opacity(), **look)

    def color(self, name: str, default: Triple) -> Triple | Texture:
        """Return a colour, or a texture of colours."""
        if self._node(name):
            return self._texture(name, Channels.image) or (GREY, GREY, GREY)
        return plain(self._value(name, default))

    def data(self, name: str, default: float) -> float | Texture:
        """Return a number, or a texture of numbers."""
        if found := self._node(name):
            texture = self._texture(name, _CHANNELS.get(found[1], Channels.data))
            return default if texture is None else texture
        return float(self._value(name, default))

    def opacity(self) -> float:
        """Return the opacity, of a texture its mean, cut off where there is a threshold."""
        threshold = float(self._value("opacityThreshold", 0.0))
        paint = self.data("opacity", 1.0)
        opacity = mean_number(paint)
        if isinstance(paint, Texture):
            self.stage.lose("variation of opacity", self.prim)
        return float(opacity >= threshold) if threshold > 0.0 else opacity

    def _attribute(self, name: str) -> Any:
        """Return the attribute that gives an input its value; None if there is none."""
        given = self.shader.GetInput(name)
        found = UsdShade.Utils.GetValueProducingAttributes(given) if given else ()
        return found[0] if found else None

    def _value(self, name: str, default: Any) -> Any:
        """Return the value of an input that no texture feeds."""
        attribute = self._attribute(name)
        is_fed = attribute is None or self._node(name)
        return default if is_fed else self.stage.value(attribute, default)

    def _node(self, name: str) -> tuple[Any, str] | None:
        attribute = self._attribute(name)
        node = UsdShade.Shader(attribute.GetPrim()) if attribute is not None else None
        if not node or node.GetShaderId() != _TEXTURE:
            return None
        return node, attribute.GetName().rpartition(":")[2]

    def _texture(self, name: str, channel: Callable[[Channels], Image]) -> Texture | None:
        """Return the texture of an input; None if it cannot be read, which is noted."""
        found = self._node(name)
        if found is None:
            return None
        value = self.stage.value
        file = found[0].GetInput("file")
        try:
            image = channel(read_image(self.stage, value(file.GetAttr()) if file else None))
        except InputError as error:
            if self.stage.options.missing_textures == "error":
                raise extended(error, OR_WITHOUT) from None
            self.stage.lose("unreadable textures, with grey in their place,", self.prim)
            return None
        scale, offset = self._placement(found[0])
        factor = (1.0, 1.0, 1.0)
        if channel is Channels.image and found[0].GetInput("scale"):
            red, green, blue, _ = value(found[0].GetInput("scale").GetAttr(), (1, 1, 1, 1))
            factor = float(red), float(green), float(blue)
        wrap = found[0].GetInput("wrapS")
        clamp = bool(wrap) and value(wrap.GetAttr()) == "clamp"
        return Texture(image, scale, offset, clamp, factor)

    def _placement(self, node: Any) -> tuple[tuple[float, float], tuple[float, float]]:
        given = node.GetInput("st")
        found = UsdShade.Utils.GetValueProducingAttributes(given) if given else ()
        place = UsdShade.Shader(found[0].GetPrim()) if found else None
        if not place or place.GetShaderId() != _PLACE:
            return (1.0, 1.0), (0.0, 0.0)

        def of(name: str, default: Any) -> Any:
            attribute = place.GetInput(name)
            return self.stage.value(attribute.GetAttr(), default) if attribute else default

        if of("rotation", 0.0):
            self.stage.lose("rotation of textures", self.prim)
        (s, t), (u, v) = of("scale", (1.0, 1.0)), of("translation", (0.0, 0.0))
        return (float(s), float(t)), (float(u), float(v))


TENTH = 0.1  # Apertures and focal lengths are in tenths of scene units
_PIXELS = 1000.0
_SIZED = ("RectLight", "DiskLight", "SphereLight")
_SUN, _SKY = "DistantLight", "DomeLight"
_EVERYWHERE = 90.0  # Half-angle of a cone, degrees, from which on a light shines as without one
_FLIP = np.diag([1.0, -1.0, -1.0, 1.0])  # From shapes that face +z to lights that face -z


def read_camera(stage: Stage, prim: Any) -> Camera:
    """Return a camera; the shape of its picture is that of the render."""
    camera, matrix = UsdGeom.Camera(prim), stage.matrix(prim)
    value = stage.value
    origin, ahead = matrix[:3, 3], -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    high = float(value(camera.GetVerticalApertureAttr(), 15.2908))
    wide = float(value(camera.GetHorizontalApertureAttr(), 20.955))
    shifts = (camera.GetHorizontalApertureOffsetAttr(), camera.GetVerticalApertureOffsetAttr())
    across, up = (float(value(attribute, 0.0)) for attribute in shifts)
    focal = float(value(camera.GetFocalLengthAttr(), 50.0))
    look: dict[str, Any] = {"fov": math.degrees(2.0 * math.atan(0.5 * high / focal))}
    if value(camera.GetProjectionAttr()) == UsdGeom.Tokens.orthographic:
        look = {"height": TENTH * high}
        origin = origin + TENTH * (across * matrix[:3, 0] + up * matrix[:3, 1])
    elif across or up:
        size = (round(_PIXELS * wide), round(_PIXELS * high))
        fx, cx, cy = _PIXELS * focal, 0.5 * wide - across, 0.5 * high + up
        look = {"projection": Intrinsics(fx, size, fx, _PIXELS * cx, _PIXELS * cy)}
    number = float(value(camera.GetFStopAttr(), 0.0))
    if number > 0.0:
        focus = float(value(camera.GetFocusDistanceAttr(), 0.0))
        look["lens"] = Lens(focus, f_number=number, focal_length=TENTH * focal)
    target, top = decoding.point_ahead(origin, ahead), plain(matrix[:3, 1])
    seen = Camera(plain(origin), target, top, name=stage.name(prim), **look)
    return check_camera(seen, stage.path)


def read_light(stage: Stage, prim: Any) -> Light | Mesh | None:
    """Return a light, or the mesh that it becomes; None, and noted, for other types."""
    kind, name = prim.GetTypeName(), stage.name(prim)
    light = (
        UsdLux.BoundableLightBase(prim) if kind in _SIZED else UsdLux.NonboundableLightBase(prim)
    )
    if kind not in (*_SIZED, _SUN, _SKY, "DomeLight_1"):
        stage.lose(f"lights of type {kind}", prim)
        return None
    amount, is_whole = radiance_of(stage, light), stage.value(light.GetNormalizeAttr(), False)
    if kind == _SUN:
        return _sun(stage, prim, name, (amount, is_whole))
    if kind in _SIZED:
        return _shape(stage, prim, name, (amount, is_whole))
    file = getattr(stage.value(UsdLux.DomeLight(prim).GetTextureFileAttr()), "path", "")
    if not file:
        return DomeLight(plain(amount), name=name)
    if np.ptp(amount) > 0.0:
        stage.lose("colour of a sky with an image", prim)
    path: Path = named_image(stage.path.parent, file)
    return turned_map(path, stage.matrix(prim)[:3, :3], float(amount.mean()), name)


def _sun(stage: Stage, prim: Any, name: str, shines: tuple[Floats, bool]) -> Light:
    """Return a sun; without `normalize` its radiance counts, over a disk of its angle."""
    amount, is_whole = shines
    angle = math.radians(stage.value(UsdLux.DistantLight(prim).GetAngleAttr(), 0.53))
    if not is_whole and angle > 0.0:
        amount = amount * math.pi * math.sin(0.5 * min(angle, math.pi)) ** 2
    ahead = -stage.matrix(prim)[:3, 2]
    return DirectionalLight(plain(ahead), plain(amount), name=name)


def _shape(stage: Stage, prim: Any, name: str, shines: tuple[Floats, bool]) -> Mesh | Light:
    """Return the mesh of a light that has a size; `normalize` divides by its area."""
    amount, is_whole = shines
    matrix, kind = stage.matrix(prim), prim.GetTypeName()
    if kind == "SphereLight":
        light = UsdLux.SphereLight(prim)
        radius = stage.value(light.GetRadiusAttr(), 0.5)
        if stage.value(light.GetTreatAsPointAttr(), False) or radius == 0.0:
            factor = 0.25 if is_whole else math.pi * radius**2
            return _point(stage, prim, name, amount * factor)
        part = meshes.move(meshes.sphere(np.zeros(3), radius), matrix)
    elif kind == "DiskLight":
        radius = stage.value(UsdLux.DiskLight(prim).GetRadiusAttr(), 0.5)
        part = meshes.move(meshes.disk(), matrix @ _FLIP @ np.diag([radius, radius, 1.0, 1.0]))
    else:
        light = UsdLux.RectLight(prim)
        if stage.value(light.GetTextureFileAttr()):
            stage.lose("textures of lights", prim)
        wide = 0.5 * stage.value(light.GetWidthAttr(), 1.0)
        high = 0.5 * stage.value(light.GetHeightAttr(), 1.0)
        part = meshes.move(meshes.rectangle(), matrix @ _FLIP @ np.diag([wide, high, 1.0, 1.0]))
    if _cone(stage, prim)[0] < _EVERYWHERE:
        stage.lose("cones of lights that have a size", prim)
    if is_whole:
        a, b, c = (part.vertices[part.faces[:, corner]] for corner in range(3))
        amount = amount / (0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    return meshes.build_mesh(stage.path, part, Material(name, 0.0, plain(amount)), name)


def _point(stage: Stage, prim: Any, name: str, intensity: Floats) -> Light:
    matrix, (outer, softness) = stage.matrix(prim), _cone(stage, prim)
    place = matrix[:3, 3]
    if outer >= _EVERYWHERE:
        return PointLight(plain(place), plain(intensity), name=name)
    target, inner = place - matrix[:3, 2], outer * (1.0 - min(max(softness, 0.0), 1.0))
    return SpotLight(plain(place), plain(target), plain(intensity), inner, outer, name=name)


def _cone(stage: Stage, prim: Any) -> tuple[float, float]:
    """Return the half-angle of a light's cone, degrees, and how soft its edge is."""
    if not prim.HasAPI(UsdLux.ShapingAPI):
        return 180.0, 0.0
    shaping = UsdLux.ShapingAPI(prim)
    if stage.value(shaping.GetShapingFocusAttr(), 0.0) or shaping.GetShapingIesFileAttr().Get():
        stage.lose("focus or IES file of lights", prim)
    softness = stage.value(shaping.GetShapingConeSoftnessAttr(), 0.0)
    return stage.value(shaping.GetShapingConeAngleAttr(), _EVERYWHERE), softness


def read_meshes(stage: Stage, prim: Any) -> Iterator[Mesh]:
    """Yield the meshes of a prim: one for each of its subsets of faces that has a material."""
    name, matrix = stage.name(prim), stage.matrix(prim)
    bound = UsdShade.MaterialBindingAPI(prim)
    if not prim.IsA(UsdGeom.Mesh):
        part = _SHAPES[prim.GetTypeName()](stage, prim)
        yield meshes.build_mesh(stage.path, meshes.move(part, matrix), stage.material(bound), name)
        return
    mesh = UsdGeom.Mesh(prim)
    sizes = np.array(stage.value(mesh.GetFaceVertexCountsAttr(), ()), np.int64)
    if stage.value(mesh.GetSubdivisionSchemeAttr()) != UsdGeom.Tokens.none:
        stage.lose("subdivision", prim)
    owners = np.zeros(len(sizes), np.int64)
    looks = [stage.material(bound)]
    for subset in bound.GetMaterialBindSubsets():
        faces = np.array(stage.value(subset.GetIndicesAttr(), ()), np.int64)
        meshes.check_indices(faces, len(sizes))
        owners[faces] = len(looks)
        inside = subset.GetPrim()
        looks.append(stage.material(UsdShade.MaterialBindingAPI(inside)))
    for index, look in enumerate(looks):
        if (owners == index).any():
            part = _read_part(stage, mesh, sizes, owners == index)
            yield meshes.build_mesh(stage.path, meshes.move(part, matrix), look, name)


def _read_part(stage: Stage, mesh: Any, sizes: Ints, kept: NDArray[np.bool_]) -> meshes.Part:
    points = np.array(stage.value(mesh.GetPointsAttr(), ()), np.float64).reshape(-1, 3)
    corners = np.array(stage.value(mesh.GetFaceVertexIndicesAttr(), ()), np.int64)
    if (sizes < 0).any() or sizes.sum() != len(corners):
        name = mesh.GetPrim().GetName()
        raise InputError(f"mesh {name}: its faces have {sizes.sum()} corners, but {len(corners)} "
                         "are given; export it again", stage.path)  # fmt: skip
    meshes.check_indices(corners, len(points))
    faces = np.repeat(np.arange(len(sizes)), sizes)
    places = {"vertex": corners, "varying": corners, "faceVarying": np.arange(len(corners)),
              "uniform": faces, "constant": np.zeros(len(corners), np.int64)}  # fmt: skip
    api = UsdGeom.PrimvarsAPI(mesh)
    normals = _spread(stage, api.GetPrimvar("normals"), 3, places)
    if normals is None:
        values = np.array(stage.value(mesh.GetNormalsAttr(), ()), np.float64).reshape(-1, 3)
        where = places[mesh.GetNormalsInterpolation()]
        normals = values[where] if len(values) > where.max(initial=-1) and len(values) else None
    uv = _spread(stage, api.GetPrimvar("st"), 2, places)
    uv = _spread(stage, api.GetPrimvar("UVMap"), 2, places) if uv is None else uv
    colors = _spread(stage, mesh.GetDisplayColorPrimvar(), 3, places)
    if UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0]:
        colors = None
    used = kept[faces]
    rows = [None if each is None else each[used] for each in (normals, uv, colors)]
    order = np.arange(np.count_nonzero(used))
    part = meshes.cut_polygons(points[corners][used], order, sizes[kept], stage.losses, *rows)
    if mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded:
        return meshes.Part(part.vertices, part.faces[:, ::-1], part.normals, part.uv, part.colors)
    return part


def _spread(stage: Stage, primvar: Any, columns: int, places: dict[str, Ints]) -> Floats | None:
    """Return a value for each corner; None where there are none."""
    if not primvar or not primvar.HasValue():
        return None
    found = primvar.ComputeFlattened(stage.stage.GetStartTimeCode())
    values = np.array(found, np.float64).reshape(-1, columns)
    where = places.get(primvar.GetInterpolation())
    if where is None or where.max(initial=-1) >= len(values):
        stage.lose(f"{primvar.GetPrimvarName()} of a wrong number", primvar.GetAttr().GetPrim())
        return None
    return np.asarray(values[where])


def _sphere(stage: Stage, prim: Any) -> meshes.Part:
    return meshes.sphere(np.zeros(3), stage.value(UsdGeom.Sphere(prim).GetRadiusAttr()))


def _cube(stage: Stage, prim: Any) -> meshes.Part:
    half = 0.5 * stage.value(UsdGeom.Cube(prim).GetSizeAttr())
    return meshes.move(meshes.cube(), np.diag([half, half, half, 1.0]))


_SHAPES: dict[str, Callable[[Stage, Any], meshes.Part]] = {"Sphere": _sphere, "Cube": _cube}
SHAPES = ("Mesh", *_SHAPES)  # Types of prims that become meshes
