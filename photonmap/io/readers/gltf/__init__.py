"""Read glTF 2.0 files, as text and as GLB."""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers import decoding, meshes
from photonmap.io.readers.gltf import document, materials
from photonmap.io.readers.gltf.materials import Textures, Tint, find_placement, read_material
from photonmap.io.readers.registry import ReadOptions
from photonmap.runtime.bounds import OF_TRIANGLE
from photonmap.runtime.wording import listed, shown
from photonmap.scene import lights
from photonmap.scene.camera import ALL, NOT_IN_FILES, Camera, check_camera
from photonmap.scene.lights import Light
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Vector
from photonmap.scene.scene import Scene
from photonmap.scene.surfaces.layers import without_images
from photonmap.scene.textures import Texture, is_black, mean_color
from photonmap.spectra.curves import Floats

SUFFIXES = (".glb", ".gltf")

_WIDEST = math.pi / 4.0  # Default outer half-angle of a spot, radians
_ROUNDING = 1.0 + 1e-6  # Of angles in float32: a spot of a hard edge has two equal ones
_BRIGHT = 200.0
"""W·sr⁻¹ or W·m⁻² that hardly any light of Blender has: a point of 2.5 kW, a sun of strength 200;
in candela and lux those of 3.7 W and 0.3 have them."""
_LIGHTS = "KHR_lights_punctual"
_BLENDER = "Khronos glTF Blender I/O"  # How the generator's name begins
_DIM = (
    "the brightness of emission beside lights in candela and lux, which Blender multiplies by 683,"
)
_VISIBILITY, _VARIANTS = "KHR_node_visibility", "KHR_materials_variants"
_HARMLESS = re.compile(
    "KHR_materials_|KHR_texture_|EXT_texture_|MSFT_texture_|KHR_lights_punctual$"
    f"|KHR_mesh_quantization$|KHR_xmp|{document.COPIES}$|{_VISIBILITY}$"
)
"""glTF extensions that a file may require: they are read, or geometry is the same without them."""
_NAMED = re.compile(".*_compression$|KHR_animation_pointer$")
"""Further ones that need no warning: animations are named, and the file has data for others too"""
_IMAGES_OF_DIRECTIONS = {
    "relief": "normalTexture",
    "coat_relief": "clearcoatNormalTexture",
    "anisotropy_map": "anisotropyTexture",
}
"""Keys of glTF, by the attributes of `Material` that they give"""
_Primitive = tuple[meshes.Part, dict[str, Any]]  # Triangles, and the JSON that describes them


@dataclass
class Gltf(document.Document):
    """A glTF file, and what is read from it."""

    options: ReadOptions = field(kw_only=True)  # a user's choices
    losses: decoding.Losses = field(kw_only=True)  # what is not simulated
    _materials: dict[tuple[int | None, Tint | None], Material] = field(default_factory=dict)
    even: dict[int, Material] = field(default_factory=dict)  # without images, by what has them
    _shared: dict[int, list[_Primitive]] = field(default_factory=dict)

    def node_item(self, index: int, item: dict[str, Any]) -> NodeItem:
        """Return a camera or a light where a node puts it."""
        wanted = self.item("nodes", index).get("name") or item.get("name") or f"node_{index}"
        plain = re.sub(f"[{re.escape(NOT_IN_FILES)}]", "_", str(wanted))
        name = decoding.unused_name(plain, index, self.names)
        return NodeItem(self.path, name, item, self.losses, self.placed[index])

    @cached_property
    def placed(self) -> dict[int, Floats]:
        """The nodes that belong to the scene in ascending order, and their matrices."""
        return dict(sorted(document.place_nodes(self, _roots(self)).items()))

    @cached_property
    def _all_placed(self) -> dict[int, Floats]:
        """All nodes and their matrices: bones may stand beside the scene."""
        return document.place_nodes(self, _tops(self))

    @cached_property
    def hidden(self) -> set[int]:
        """The nodes that show nothing, by themselves or by one above them; cameras they may be."""
        hidden: set[int] = set()
        below = [index for index in self.placed if not self._is_visible(index)]
        while below:
            index = below.pop()
            if index not in hidden:
                hidden.add(index)
                below += self.item("nodes", index).get("children", ())
        return hidden

    def _is_visible(self, index: int) -> bool:
        """Return what KHR_node_visibility says of a node itself."""
        content = self.item("nodes", index).get("extensions", {}).get(_VISIBILITY) or {}
        visible = content.get("visible", True)
        if type(visible) is not bool or {*content} - {"visible", "extras"}:
            problem = f"node {index}: {_VISIBILITY} {shown(content)}"
            raise self.error(f'{problem} is not understood; write {{"visible": false}} or true')
        return visible

    def matrix(self, index: int) -> Floats:
        """Return the matrix of any node, from its coordinates to the scene's."""
        self.item("nodes", index)
        return self._all_placed[index]

    @cached_property
    def names(self) -> set[str]:
        """Names that cameras and lights may not have: those of each other and of materials."""
        return {ALL, *(str(material.get("name")) for material in self.tree.get("materials", []))}

    @cached_property
    def textures(self) -> Textures:
        """Its textures."""
        return Textures(self.path, self.item, self.view, self.options.missing_textures)

    def material(self, index: int | None, tint: Tint | None = None) -> Material:
        """Return the material of an index, the same one each time, in a tint or in none."""
        key = index, tint
        if key not in self._materials:
            material = Material("default", tint[:3] if tint else Material.reflectance)
            if index is not None:
                item = self.item("materials", index)
                material = read_material(index, item, self.textures, self.losses, tint)
            self._materials[key] = material
        return self._materials[key]

    @cached_property
    def _uses(self) -> Counter[int]:
        return Counter(node["mesh"] for _, node in self._nodes() if "mesh" in node)

    def parts(self, index: int) -> Iterable[_Primitive]:
        """Return the primitives of a mesh; several nodes share one copy."""
        mesh = self.item("meshes", index)
        if self._uses[index] < 2:
            return _parts(self, mesh)
        if index not in self._shared:
            self._shared[index] = list(_parts(self, mesh))
        return self._shared[index]

    def cameras(self, shown: list[Mesh]) -> list[Camera]:
        """Return the cameras at its nodes, which see these meshes."""
        nodes = [
            self.node_item(index, self.item("cameras", node["camera"]))
            for index, node in self._nodes()
            if "camera" in node
        ]
        cameras = [read_camera(node) for node in nodes]
        for node in nodes:
            _note_clipped(node, shown)
        return cameras

    def lights(self) -> list[Light]:
        """Return the lights at its nodes."""
        known = (self.tree.get("extensions", {}).get(_LIGHTS) or {}).get("lights", [])
        lights = []
        for index, node in self._nodes():
            light = (node.get("extensions", {}).get(_LIGHTS) or {}).get("light")
            if light is None or index in self.hidden:
                continue
            if type(light) is not int or not 0 <= light < len(known):
                problem = f"names light {shown(light)}, but has {len(known)}; export it again"
                raise self.error(problem)
            lights.append(read_light(self.node_item(index, known[light])))
        return lights

    def _nodes(self) -> Iterator[tuple[int, dict[str, Any]]]:
        return ((index, self.item("nodes", index)) for index in self.placed)


def read(path: Path, options: ReadOptions) -> Scene:
    """Read the meshes, cameras and lights at the nodes of a glTF or GLB file.

    Each node that shows a mesh becomes one or more meshes of the node's name. Buffers and images
    that a file names are looked up beside it.
    """
    return decoding.decode_file(path, partial(_decode, options))


def _decode(options: ReadOptions, path: Path, data: bytes, losses: decoding.Losses) -> Scene:
    is_glb = path.suffix.lower() == ".glb"
    tree, binary = document.split_glb(path, data) if is_glb else (data, None)
    text = _whole(bytes(tree).decode("utf-8-sig"))
    gltf = Gltf(path, json.loads(text), binary, options=options, losses=losses)
    _check_gltf(gltf)
    _note_gltf(gltf)
    meshes = list(_instances(gltf))
    for name in gltf.textures.lost:
        decoding.note_loss(losses, "unreadable textures, with grey in their place,", name)
    cameras, lights = gltf.cameras(meshes), gltf.lights()
    amounts = (getattr(each, "intensity", getattr(each, "irradiance", 0.0)) for each in lights)
    are_photometric = max(map(np.max, amounts), default=0.0) >= _BRIGHT
    if str(gltf.tree["asset"].get("generator")).startswith(_BLENDER) and are_photometric:
        for mesh in meshes:
            if not is_black(mesh.material.emission):
                decoding.note_loss(losses, _DIM, mesh.material.name)
    return Scene(meshes, name=path.stem, cameras=cameras, lights=lights)


def _whole(text: str) -> str:
    """Return JSON with U+FFFD for halves of characters, which no file could be named by."""
    escapes = re.compile(r"\\\\|(?:\\u[dD][89abAB]..\\u[dD][c-fC-F]..)|(\\u[dD][89a-fA-F]..)")
    return escapes.sub(lambda found: r"\ufffd" if found[1] else found[0], text)


def _check_gltf(gltf: Gltf) -> None:
    """Refuse other versions, unsupported requirements, and nodes that do not form a forest."""
    asset = gltf.tree.get("asset", {})
    version, least = str(asset.get("version", "")), str(asset.get("minVersion", "2.0"))
    if not version.startswith("2.") or least != "2.0":
        needed = version if least == "2.0" else least
        raise gltf.error(f"is glTF {shown(needed)}; export it as glTF 2.0")
    required = gltf.tree.get("extensionsRequired", [])
    if unknown := [name for name in required if not _HARMLESS.match(name)]:
        raise gltf.error(f"needs {listed(unknown)}, which is not supported; export it without")
    seen = set()
    for index in [*_children(gltf), *_roots(gltf)]:
        gltf.item("nodes", index)
        if index in seen:
            raise gltf.error(f"node {index} has two parents; export it again")
        seen.add(index)


def _children(gltf: Gltf) -> list[int]:
    return [index for node in gltf.tree.get("nodes", []) for index in node.get("children", [])]


def _roots(gltf: Gltf) -> list[int]:
    """Return the nodes at the top of the scene; without a scene, all that have no parent."""
    if gltf.tree.get("scenes"):
        roots: list[int] = gltf.item("scenes", gltf.tree.get("scene", 0)).get("nodes", [])
        return roots
    return _tops(gltf)


def _tops(gltf: Gltf) -> list[int]:
    """Return the nodes that have no parent."""
    children = set(_children(gltf))
    return [index for index in range(len(gltf.tree.get("nodes", []))) if index not in children]


def _parts(gltf: Gltf, mesh: dict[str, Any]) -> Iterator[_Primitive]:
    for primitive in mesh["primitives"]:
        if primitive.get("mode", document.TRIANGLES) in document.MODES:
            material = primitive.get("material")
            item = {} if material is None else gltf.item("materials", material)
            lose = partial(decoding.note_loss, gltf.losses)
            part = document.read_primitive(gltf, primitive, find_placement(item), lose)
            if len(part.faces):
                yield part, primitive


def _instances(gltf: Gltf) -> Iterator[Mesh]:
    names: set[str] = set()
    for index, matrix in gltf.placed.items():
        node = gltf.item("nodes", index)
        if "mesh" not in node or index in gltf.hidden:
            continue
        mesh = gltf.item("meshes", node["mesh"])
        wanted = node.get("name") or mesh.get("name") or "node"
        name = decoding.unused_name(str(wanted), index, names)
        places = document.find_copies(gltf, node)
        pose = document.find_pose(gltf, node, gltf.matrix)
        if places is not None and pose.bones is not None:
            decoding.note_loss(gltf.losses, f"{document.COPIES} beside a skin", name)
            places = None
        for part, primitive in gltf.parts(node["mesh"]):
            shown_times = 1 if places is None else len(places)
            gltf.budget.spend(OF_TRIANGLE * len(part.faces) * shown_times)
            lose = partial(decoding.note_loss, gltf.losses, owner=name)
            part, is_placed = document.strike_pose(gltf, part, primitive, pose, lose)
            part, material = _paint(gltf, part, primitive.get("material"))
            _note_backs(gltf, part, primitive.get("material"), material)
            if places is None:
                placed = part if is_placed else meshes.move(part, matrix)
                yield meshes.build_mesh(gltf.path, placed, material, name)
            for number, place in enumerate(places or ()):
                placed = meshes.move(part, matrix @ place)
                yield meshes.build_mesh(gltf.path, placed, material, f"{name}_{number}")


def _note_backs(gltf: Gltf, part: meshes.Part, index: int | None, material: Material) -> None:
    """Note an open surface that should emit from both of its sides."""
    item = {} if index is None else gltf.item("materials", index)
    if item.get("doubleSided") and not is_black(material.emission) and not meshes.is_closed(part):
        decoding.note_loss(gltf.losses, "emission from the back (doubleSided)", material.name)


def _paint(gltf: Gltf, part: meshes.Part, index: int | None) -> tuple[meshes.Part, Material]:
    """Multiply the base colour of a material by the colours of vertices.

    Where it has textures, is glass, or for its gloss, they count with their mean.
    """
    plain = replace(part, colors=None)
    if part.colors is None or (part.colors[part.faces] == 1.0).all():
        return plain, gltf.material(index)
    colors = part.colors[part.faces]
    red, green, blue, alpha = colors.mean(axis=(0, 1)).tolist()
    material = gltf.material(index, (red, green, blue, alpha))
    varies = (colors != colors[0, 0]).any(axis=(0, 1))
    if varies[3] and material.alpha != 1.0:
        decoding.note_loss(gltf.losses, "variation of opacity of vertices", material.name)
    if not varies[:3].any():
        return plain, material
    white = gltf.material(index, materials.WHITE)
    if not isinstance(material.reflectance, Texture):
        if material.has_textured_lobe:
            decoding.note_loss(gltf.losses, materials.LOBES, material.name)
        for image, lost in _IMAGES_OF_DIRECTIONS.items():
            if getattr(getattr(material, image), "texture", None) is not None:
                decoding.note_loss(gltf.losses, lost, material.name)
        material = gltf.even.setdefault(id(material), without_images(material))
    if mean_color(white.glossy) != mean_color(material.glossy):
        decoding.note_loss(gltf.losses, materials.METAL_COLORS, material.name)
    if material.is_textured or material.ior is not None:
        decoding.note_loss(gltf.losses, "variation of colours of vertices", material.name)
        return plain, material
    factor = np.asarray(white.reflectance, np.float64)
    return replace(part, colors=part.colors[:, :3] * factor), material


def _note_gltf(gltf: Gltf) -> None:
    if gltf.tree.get("animations"):
        decoding.note_loss(gltf.losses, "animations")
    for node in gltf.tree.get("nodes", []):
        for name in node.get("extensions", ()):
            if name not in (_LIGHTS, document.COPIES, _VISIBILITY):
                decoding.note_loss(gltf.losses, name)
    holders = [gltf.tree, *gltf.tree.get("scenes", [])]
    others = {name: None for each in holders for name in each.get("extensions", ())}
    for name in [*others, *gltf.tree.get("extensionsUsed", [])]:
        if name == _VARIANTS or not (_HARMLESS.match(name) or _NAMED.match(name)):
            decoding.note_loss(gltf.losses, name)
    for mesh in gltf.tree.get("meshes", []):
        for primitive in mesh["primitives"]:
            if primitive.get("mode", document.TRIANGLES) not in document.MODES:
                decoding.note_loss(gltf.losses, "points and lines")


@dataclass(frozen=True)
class NodeItem(materials.Described):
    """A camera or a light, where a node puts it."""

    kind = "node"
    matrix: Floats  # from the node's coordinates to the scene's, 4×4

    @property
    def origin(self) -> Vector:
        """Where the node stands, scene units."""
        return decoding.plain(self.matrix[:3, 3])

    @property
    def ahead(self) -> Vector:
        """A unit vector along the node's -z: in which cameras look and lights shine."""
        return self._axis(2, -1.0)

    @property
    def up(self) -> Vector:
        """A unit vector along the node's +y."""
        return self._axis(1, 1.0)

    @property
    def target(self) -> Vector:
        """A point ahead, so far away that rounding does not turn the view."""
        return decoding.point_ahead(self.matrix[:3, 3], np.array(self.ahead))

    def _axis(self, column: int, sign: float) -> Vector:
        axis = self.matrix[:3, column]
        length = float(np.linalg.norm(axis))
        if not 0.0 < length < math.inf:
            raise self.error("its scale is 0, so it has no direction; correct the scale")
        return decoding.plain(sign / length * axis)


def _note_clipped(node: NodeItem, shown: list[Mesh]) -> None:
    """Note what a camera cuts off near or far."""
    kind, lens = node.item["type"], node.item[node.item["type"]]
    given = {key: value for key, value in lens.items() if type(value) in (int, float) and value > 0}
    planes = given.get("znear", 0.0), given.get("zfar", math.inf)
    reach = math.hypot(given.get("xmag", 0.0), given.get("ymag", 0.0)), 0.0
    if kind == "perspective":
        reach = 0.0, math.tan(0.5 * given["yfov"]) * math.hypot(1.0, given.get("aspectRatio", 1.0))
    if meshes.are_clipped((mesh.vertices for mesh in shown), node.matrix, planes, *reach):
        node.lose("what znear and zfar cut off")


def read_camera(node: NodeItem) -> Camera:
    """Read a camera; the picture's shape is the render's, and nothing near or far is cut off."""
    kind = node.item.get("type")
    if kind not in ("perspective", "orthographic"):
        raise node.error(f"a camera of type {shown(kind)} is unknown; export it again")
    lens = node.item[kind]
    look: dict[str, Any] = {}
    if kind == "perspective":
        look["fov"] = math.degrees(node.number(lens, "yfov", None))
    else:
        scale = float(np.linalg.norm(node.matrix[:3, 1]))
        look["height"] = 2.0 * scale * node.number(lens, "ymag", None)
    if np.linalg.det(node.matrix[:3, :3]) < 0.0:
        node.lose("mirrored view")
    try:
        return check_camera(Camera(node.origin, node.target, node.up, name=node.name, **look))
    except InputError as invalid:
        raise node.error(str(invalid)) from None


def read_light(node: NodeItem) -> Light:
    """Read a light of KHR_lights_punctual: candela count as W·sr⁻¹, lux as W·m⁻²."""
    item, amount = node.item, _amount(node)
    if "range" in item:
        node.lose("range")
    light: Light
    match item.get("type"):
        case "point":
            light = lights.PointLight(node.origin, amount, name=node.name)
        case "directional":
            light = lights.DirectionalLight(node.ahead, amount, name=node.name)
        case "spot":
            inner, outer = _cone(node)
            light = lights.SpotLight(node.origin, node.target, amount, inner, outer, name=node.name)
        case unknown:
            raise node.error(f"a light of type {shown(unknown)} is unknown; export it again")
    return lights.check_light(light, node.path)


def _cone(node: NodeItem) -> tuple[float, float]:
    """Return the half-angles of a spot, degrees, the inner lowered to the outer with a warning."""
    spot = node.item.get("spot") or {}
    inner = math.degrees(node.number(spot, "innerConeAngle", 0.0))
    outer = max(math.degrees(node.number(spot, "outerConeAngle", _WIDEST)), lights.NARROWEST)
    if inner > outer * _ROUNDING:
        node.lose("innerConeAngle above outerConeAngle")
    return min(inner, outer), outer


def _amount(node: NodeItem) -> Vector:
    intensity = node.number(node.item, "intensity", 1.0)
    color = node.item.get("color", [1.0, 1.0, 1.0])
    if not isinstance(color, list) or len(color) != 3:
        raise node.wrong("color", color, "three numbers")
    red, green, blue = (node.number({"color": part}, "color", None) for part in color)
    return red * intensity, green * intensity, blue * intensity
