"""Build test scenes in Blender, render them with Cycles, and export them.

    python blender_scenes.py room FOLDER 1024 128   # room_cycles.exr, room.glb and room.toml

The numbers are samples and the width of the picture.
"""

import math
import sys
from pathlib import Path

import bpy
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).parents[3] / "tools"))
from blender_export import export


def material(name, **inputs):
    """Return a principled material; names of inputs have underscores for blanks."""
    made = bpy.data.materials.new(name)
    shader = made.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return made


def plain(name, kind, **inputs):
    """Return a material of one simple shader."""
    made = bpy.data.materials.new(name)
    tree = made.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    shader = tree.nodes.new(kind)
    for key, value in inputs.items():
        shader.inputs[key].default_value = value
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def mesh(name, corners, faces, look):
    """Add a mesh."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], faces)
    data.materials.append(look)
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    return item


def box(name, low, high, look, *, inwards=False, without=()):
    """Add a box; `without` leaves out faces: -z, +z, -y, +x, +y, -x."""
    (a, b, c), (d, e, f) = low, high
    corners = [
        (a, b, c),
        (d, b, c),
        (d, e, c),
        (a, e, c),
        (a, b, f),
        (d, b, f),
        (d, e, f),
        (a, e, f),
    ]
    faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    kept = [face for index, face in enumerate(faces) if index not in without]
    return mesh(name, corners, [face[::-1] for face in kept] if inwards else kept, look)


def ball(name, center, radius, look):
    """Add a smooth ball."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=radius, location=center)
    item = bpy.context.object
    item.name = name
    item.data.materials.append(look)
    bpy.ops.object.shade_smooth()
    return item


def light(name, kind, energy, place, target=None, **values):
    """Add a light that cameras see."""
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    for key, value in values.items():
        setattr(data, key, value)
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    item.visible_camera = True
    aim(item, place, target)
    return item


def aim(item, place, target=None):
    """Put an object somewhere, looking at a target, or down."""
    item.location = place
    if target is not None:
        towards = Vector(target) - Vector(place)
        item.rotation_euler = towards.to_track_quat("-Z", "Y").to_euler()


def camera(place, target, **values):
    """Add the camera."""
    data = bpy.data.cameras.new("camera")
    for key, value in values.items():
        setattr(data, key, value)
    item = bpy.data.objects.new("camera", data)
    scene = bpy.context.scene
    scene.collection.objects.link(item)
    aim(item, place, target)
    scene.camera = item
    return item


def world(color, strength=1.0):
    """Set an even world."""
    made = bpy.data.worlds.new("world")
    bpy.context.scene.world = made
    shader = made.node_tree.nodes["Background"]
    shader.inputs["Color"].default_value = (*color, 1.0)
    shader.inputs["Strength"].default_value = strength
    return made


def room():
    """A diffuse room with a window: sun, sky, and lights of all shapes."""
    world((0.3, 0.5, 1.0), 0.4)
    white = plain("white", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.7, 0.7, 1.0))
    red = plain("red", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.1, 0.08, 1.0))
    green = material("green", Base_Color=(0.1, 0.5, 0.15, 1.0), Specular_IOR_Level=0.0)
    box("shell", (-2, -3, 0), (2, 2, 2.6), white, inwards=True, without=(3, 5))
    mesh("left", [(-2, -3, 0), (-2, 2, 0), (-2, 2, 2.6), (-2, -3, 2.6)], [(0, 1, 2, 3)], red)
    frame = [(2, -3, 0), (2, 2, 0), (2, 2, 2.6), (2, -3, 2.6)]
    hole = [(2, -0.5, 0.9), (2, 1.2, 0.9), (2, 1.2, 2.1), (2, -0.5, 2.1)]
    rim = [(0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]
    mesh("window", frame + hole, rim, green)
    box("block", (-1.2, 0.2, 0), (-0.3, 1.1, 1.2), white)
    light("sun", "SUN", 8.0, (5, 0, 5), (-0.5, 0, 0), angle=0.0, color=(1.0, 0.9, 0.7))
    light("panel", "AREA", 40.0, (-0.5, 0.5, 2.59), shape="RECTANGLE", size=0.9, size_y=0.3)
    oval = light("oval", "AREA", 15.0, (-1.9, -1.0, 1.5), (0, 0, 0.8), shape="ELLIPSE")
    oval.data.size, oval.data.size_y, oval.scale = 0.4, 0.2, (1.5, 1.0, 1.0)
    bulb = {"shadow_soft_size": 0.12, "color": (1.0, 0.6, 0.3), "use_soft_falloff": False}
    light("bulb", "POINT", 12.0, (0.9, 1.2, 0.5), **bulb)
    cone = {"spot_size": math.radians(50), "spot_blend": 0.4, "shadow_soft_size": 0.0}
    light("spot", "SPOT", 60.0, (0.5, -2.0, 2.4), (0.3, 0.8, 0.0), **cone)
    camera((0.2, -2.8, 1.4), (0.0, 1.0, 1.0), lens=22.0, shift_x=0.05, shift_y=-0.04)


def studio():
    """Glossy things, metal and glass under a world of its own map and a sun of a size."""
    made = world((1.0, 1.0, 1.0))
    tree = made.node_tree
    sky = tree.nodes.new("ShaderNodeTexGradient")
    place = tree.nodes.new("ShaderNodeTexCoord")
    turn = tree.nodes.new("ShaderNodeMapping")
    turn.inputs["Rotation"].default_value = (0.3, 0.2, 0.7)
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].color = (0.15, 0.2, 0.3, 1.0)
    ramp.color_ramp.elements[1].color = (1.0, 0.8, 0.5, 1.0)
    tree.links.new(place.outputs["Generated"], turn.inputs["Vector"])
    tree.links.new(turn.outputs["Vector"], sky.inputs["Vector"])
    tree.links.new(sky.outputs["Fac"], ramp.inputs["Fac"])
    tree.links.new(ramp.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    floor = material("floor", Base_Color=(0.5, 0.5, 0.5, 1.0), Roughness=0.4)
    box("floor", (-4, -4, -0.1), (4, 4, 0), floor)
    gold = material("gold", Base_Color=(1.0, 0.7, 0.3, 1.0), Metallic=1.0, Roughness=0.35)
    ball("gold", (-1.1, 0.2, 0.5), 0.5, gold)
    plastic = material("plastic", Base_Color=(0.1, 0.25, 0.6, 1.0), Roughness=0.25)
    ball("plastic", (0.0, 0.6, 0.5), 0.5, plastic)
    glass = material(
        "glass", Base_Color=(0.8, 1.0, 0.9, 1.0), Roughness=0.0, Transmission_Weight=1.0, IOR=1.5
    )
    ball("glass", (1.1, 0.2, 0.5), 0.5, glass)
    chrome = plain("chrome", "ShaderNodeBsdfAnisotropic", Color=(0.8, 0.8, 0.8, 1.0), Roughness=0.2)
    box("chrome", (-0.6, -0.9, 0), (-0.2, -0.5, 0.5), chrome)
    veil = material("veil", Base_Color=(0.6, 0.1, 0.3, 1.0), Alpha=0.6, Roughness=0.5)
    box("veil", (0.3, -0.9, 0.02), (0.7, -0.5, 0.5), veil)
    lamp = material("lamp", Base_Color=(0.0, 0.0, 0.0, 1.0), Emission_Strength=6.0)
    lamp.node_tree.nodes["Principled BSDF"].inputs["Emission Color"].default_value = (0.9, 1, 1, 1)
    box("lamp", (1.6, -0.6, 0.1), (1.7, -0.5, 0.6), lamp)
    light("sun", "SUN", 2.0, (3, -2, 4), (0, 0, 0), angle=math.radians(12))
    light("disk", "AREA", 60.0, (-2.0, -1.5, 2.5), (0, 0, 0.4), shape="DISK", size=0.8)
    camera((0.3, -4.0, 1.7), (0.1, 0.0, 0.4), lens=38.0)


def render(path, samples, width):
    """Render the scene with Cycles, to linear EXR."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples, scene.cycles.use_denoising = samples, False
    scene.cycles.use_adaptive_sampling = False
    for kind in ("max", "diffuse", "glossy", "transmission"):
        setattr(scene.cycles, f"{kind}_bounces", 64)
    scene.cycles.sample_clamp_indirect = scene.cycles.blur_glossy = 0.0
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.resolution_x, scene.render.resolution_y = width, width * 3 // 4
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Raw"
    settings = scene.render.image_settings
    settings.media_type, settings.file_format, settings.color_depth = "IMAGE", "OPEN_EXR", "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main():
    """Build, render and export a scene."""
    name, folder, samples, width = sys.argv[-4:]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    {"room": room, "studio": studio}[name]()
    out = Path(folder).resolve() / name
    render(out.with_name(f"{name}_cycles.exr"), int(samples), int(width))
    print(export(out), file=sys.stderr)


if __name__ == "__main__":
    main()
