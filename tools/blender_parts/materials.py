"""Materials: what Blender's glTF exporter does not know is put as it does, or named."""

from typing import Any

import bpy
import numpy as np

from blender_parts.draft import Draft, color_of, output_of, toml, upstream, value_of

MESHES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
OTHERS = {"EMPTY", "CAMERA", "LIGHT", "ARMATURE", "LATTICE", "LIGHT_PROBE", "SPEAKER"}
"""Kinds of objects that hold no surface."""
MAPPED = ("Base Color", "Metallic", "Roughness", "Alpha", "Normal", "Emission Color")
"""Inputs of the principled shader that glTF holds as textures."""
SIMPLE = {
    "TEX_IMAGE",
    "NORMAL_MAP",
    "UVMAP",
    "MAPPING",
    "TEX_COORD",
    "SEPARATE_COLOR",
    "VERTEX_COLOR",
    "ATTRIBUTE",
    "RGB",
    "VALUE",
    "REROUTE",
    "MIX",
    "MATH",
}
"""Nodes before such an input that the exporter understands."""
BLACK = (0.0, 0.0, 0.0, 1.0)
STANDS_FOR = {
    "BSDF_DIFFUSE": {"Specular IOR Level": 0.0, "Roughness": 1.0},
    "BSDF_GLOSSY": {"Metallic": 1.0},
    "BSDF_GLASS": {"Transmission Weight": 1.0},
    "EMISSION": {"Base Color": BLACK, "Specular IOR Level": 0.0},
}
"""Shaders for which a principled one stands, by what is not its default."""
NAMES = {
    "BSDF_DIFFUSE": {"Color": "Base Color", "Normal": "Normal"},
    "BSDF_GLOSSY": {"Color": "Base Color", "Roughness": "Roughness", "Normal": "Normal"},
    "BSDF_GLASS": {"Color": "Base Color", "Roughness": "Roughness", "IOR": "IOR"},
    "EMISSION": {"Color": "Emission Color", "Strength": "Emission Strength"},
}
"""What the principled shader calls their inputs."""


def prepare_materials(draft: Draft) -> None:
    """Change materials to what the exporter knows, for a while, and add what it drops."""
    for item in draft.scene.objects:
        if not item.hide_render and item.type not in MESHES | OTHERS:
            draft.lose(f"objects of type {item.type}", item.name)
        for system in item.particle_systems:
            draft.lose("particles", f"{item.name}: {system.name}")
    for material, is_closed in _used(draft.scene).items():
        output = output_of(material.node_tree)
        if output is None or not output.inputs["Surface"].is_linked:
            draft.lose("no surface shader", material.name)
            continue
        shader = _as_principled(draft, material, output)
        if shader is not None:
            _check(draft, material, shader, is_closed)
            if is_closed and value_of(shader, "Transmission Weight") == 1.0:
                _fill(draft, material, output, shader)


def _used(scene: Any) -> dict[Any, bool]:
    """Return the materials of surfaces, and whether all these are closed."""
    used: dict[Any, bool] = {}
    graph = bpy.context.evaluated_depsgraph_get()
    for item in scene.objects:
        if item.type not in MESHES or item.hide_render:
            continue
        whole = item.evaluated_get(graph)
        mesh = whole.to_mesh()
        edges = np.zeros(len(mesh.loops), np.int32)
        mesh.loops.foreach_get("edge_index", edges)
        is_closed = bool((np.bincount(edges, minlength=len(mesh.edges)) == 2).all())
        whole.to_mesh_clear()
        for slot in item.material_slots:
            if slot.material is not None:
                used[slot.material] = used.get(slot.material, True) and is_closed
    return used


def _as_principled(draft: Draft, material: Any, output: Any) -> Any:
    """Return the principled shader of a material, put in for a simpler one; None for others."""
    tree, socket = material.node_tree, output.inputs["Surface"]
    before = socket.links[0].from_socket
    shader, alpha = before.node, None
    if shader.type == "MIX_SHADER":
        first, second = (
            each.links[0].from_node if each.links else None for each in shader.inputs[1:]
        )
        if first is not None and first.type == "BSDF_TRANSPARENT" and second is not None:
            shader, alpha = second, shader.inputs[0]
    if shader.type == "BSDF_PRINCIPLED" and alpha is None:
        return shader
    if shader.type not in (*STANDS_FOR, "BSDF_PRINCIPLED"):
        draft.lose(f"shader {before.node.bl_idname.removeprefix('ShaderNode')}", material.name)
        return None
    new = tree.nodes.new("ShaderNodeBsdfPrincipled")
    for name, value in STANDS_FOR.get(shader.type, {}).items():
        new.inputs[name].default_value = value
    if shader.type == "BSDF_DIFFUSE" and value_of(shader, "Roughness") != 0.0:
        draft.lose("diffuse roughness", material.name)
    for old, name in NAMES.get(
        shader.type, {each.name: each.name for each in shader.inputs}
    ).items():
        _copy_input(tree, shader.inputs[old], new.inputs[name])
    if alpha is not None:
        _copy_input(tree, alpha, new.inputs["Alpha"])
    tree.links.new(new.outputs[0], socket)
    draft.undo += [lambda: tree.nodes.remove(new), lambda: tree.links.new(before, socket)]
    return new


def _copy_input(tree: Any, old: Any, new: Any) -> None:
    """Give an input the value of another, or a link to the same output."""
    if old.is_linked:
        tree.links.new(old.links[0].from_socket, new)
    elif hasattr(old, "default_value"):
        new.default_value = old.default_value


def _check(draft: Draft, material: Any, shader: Any, is_closed: bool) -> None:
    """Note what the exporter drops of a principled shader without a word."""
    for socket in shader.inputs:
        nodes = {node.type for node in upstream(socket)}
        if nodes and not (socket.name in MAPPED and nodes <= SIMPLE):
            draft.lose(f"nodes at {socket.name} (bake them into an image)", material.name)
    for name in ("Subsurface Weight", "Diffuse Roughness", "Thin Film Thickness"):
        if value_of(shader, name) not in (None, 0.0):
            draft.lose(name, material.name)
    shines = value_of(shader, "Emission Strength") != 0.0
    if shines and color_of(shader, "Emission Color").any() and not is_closed:
        draft.lose("light from the backs of faces", material.name)


def _fill(draft: Draft, material: Any, output: Any, shader: Any) -> None:
    """Mark a closed body as glass throughout: its colour is that of two crossings."""
    tree = material.node_tree
    group = bpy.data.node_groups.new("glTF Material Output", "ShaderNodeTree")
    group.interface.new_socket("Thickness", in_out="INPUT", socket_type="NodeSocketFloat")
    mark = tree.nodes.new("ShaderNodeGroup")
    mark.node_tree = group
    mark.inputs["Thickness"].default_value = 1.0
    draft.undo += [lambda: bpy.data.node_groups.remove(group), lambda: tree.nodes.remove(mark)]
    values: dict[str, Any] = {"tint": np.sqrt(color_of(shader, "Base Color"))}
    volume = output.inputs["Volume"]
    if volume.is_linked:
        inside = volume.links[0].from_node
        density = value_of(inside, "Density") if inside.type == "VOLUME_ABSORPTION" else None
        if density and not inside.inputs["Color"].is_linked:
            values["attenuation_color"] = np.exp(color_of(inside, "Color") - 1.0)
            values["attenuation_distance"] = 1.0 / density
        else:
            draft.lose("volume", material.name)
    draft.section(f"[material.{toml(material.name)}]", **values)
