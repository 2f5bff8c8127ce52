"""The Cornell box with other matter, or by a lens, as files that Mitsuba and photonmap read."""

from __future__ import annotations

from pathlib import Path

HEAD = """<scene version="3.0.0">
<sensor type="{sensor}">{lens}
<float name="fov" value="39.3077"/><string name="fov_axis" value="smaller"/>
<float name="near_clip" value="0.001"/><float name="far_clip" value="100"/>
<transform name="to_world"><lookat origin="0, 0, 3.9" target="0, 0, 0" up="0, 1, 0"/></transform>
<sampler type="independent"/>
<film type="hdrfilm">
<integer name="width" value="{width}"/><integer name="height" value="{height}"/>
<rfilter type="box"/></film>
</sensor>
"""
PAINT = '<bsdf type="twosided" id="{name}"><bsdf type="diffuse">{color}</bsdf></bsdf>\n'
COLOR = '<rgb name="reflectance" value="{value}"/>'
COLORS = {
    "white": "0.885809, 0.698859, 0.666422",
    "green": "0.105421, 0.37798, 0.076425",
    "red": "0.570068, 0.0430135, 0.0443706",
}
LIGHT = """<emitter type="area"><rgb name="radiance" value="18.387, 13.9873, 6.75357"/></emitter>"""
METAL = (
    '<bsdf type="roughconductor"><string name="distribution" value="ggx"/>'
    '<float name="alpha" value="{alpha}"/><rgb name="eta" value="0.21, 0.95, 1.15"/>'
    '<rgb name="k" value="3.6, 2.58, 2.45"/></bsdf>'
)
PLASTIC = (
    '<bsdf type="roughplastic"><string name="distribution" value="ggx"/>'
    '<float name="alpha" value="{alpha}"/><float name="int_ior" value="1.5"/>'
    '<rgb name="diffuse_reflectance" value="0.5, 0.4, 0.3"/></bsdf>'
)
WALLS = {
    "light": ('<scale x="0.23" y="0.19" z="0.19"/><rotate x="1" angle="90"/>', "0, 0.99, 0.01"),
    "floor": ('<rotate x="1" angle="-90"/>', "0, -1, 0"),
    "ceiling": ('<rotate x="1" angle="90"/>', "0, 1, 0"),
    "back": ("", "0, 0, -1"),
    "right": ('<rotate y="1" angle="-90"/>', "1, 0, 0"),
    "left": ('<rotate y="1" angle="90"/>', "-1, 0, 0"),
}
"""What turns each, and where it stands."""
BOXES = {
    "small box": ('<scale value="0.3"/><rotate y="1" angle="-17"/>', "0.335, -0.7, 0.38"),
    "large box": (
        '<scale x="0.3" y="0.61" z="0.3"/><rotate y="1" angle="18.25"/>',
        "-0.33, -0.4, -0.28",
    ),
}
PRINCIPLED = (
    '<bsdf type="principled"><rgb name="base_color" value="0.6, 0.3, 0.2"/>'
    '<float name="roughness" value="0.4"/><float name="metallic" value="{metallic}"/></bsdf>'
)
LENS = '<float name="aperture_radius" value="0.08"/><float name="focus_distance" value="4.1"/>'
PAINTED = {"right": "green", "left": "red"}

SCENES = {
    "metal-0.05": {"large box": METAL.format(alpha=0.05)},
    "metal-0.2": {"large box": METAL.format(alpha=0.2)},
    "metal-0.5": {"large box": METAL.format(alpha=0.5)},
    "floor-0.1": {"floor": PLASTIC.format(alpha=0.1)},
}
"""What surfaces have in place of paint, by name: what is glossy, and its α."""
MATTER = {
    "rough plastic": {"large box": PLASTIC.format(alpha=0.1)},
    "principled": {"large box": PRINCIPLED.format(metallic=0.0)},
    "principled metal": {"large box": PRINCIPLED.format(metallic=1.0)},
    "thin lens": {},
}
"""Further ones, of `benchmarks.accuracy.matter`."""


def write_scene(name: str, size: tuple[int, int], folder: Path) -> Path:
    """Write one of `SCENES` or `MATTER` as a file of Mitsuba 3."""
    surfaces = (SCENES | MATTER)[name]
    sensor, lens = ("thinlens", LENS) if name == "thin lens" else ("perspective", "")
    parts = [HEAD.format(width=size[0], height=size[1], sensor=sensor, lens=lens)]
    parts += [
        PAINT.format(name=color, color=COLOR.format(value=value)) for color, value in COLORS.items()
    ]
    for kind, shapes in (("rectangle", WALLS), ("cube", BOXES)):
        for shape, (turn, place) in shapes.items():
            matter = f'<ref id="{PAINTED.get(shape, "white")}"/>'
            if shape in surfaces:
                matter = f'<bsdf type="twosided">{surfaces[shape]}</bsdf>'
            x, y, z = place.split(", ")
            parts.append(
                f'<shape type="{kind}" id="{shape}"><transform name="to_world">{turn}'
                f'<translate x="{x}" y="{y}" z="{z}"/></transform>{matter}'
                f"{LIGHT * (shape == 'light')}</shape>\n"
            )
    file = folder / "scene.xml"
    file.write_text("".join([*parts, "</scene>\n"]), encoding="utf-8")
    return file
