"""Small scenes that photonmap and Mitsuba render to the same picture."""

HEAD = """<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="-1"/></integrator>
<bsdf type="twosided" id="white"><bsdf type="diffuse"><rgb name="reflectance" value=".7 .65 .6"/>
</bsdf></bsdf>
"""
SENSOR = """<sensor type="perspective"><float name="fov" value="50"/>
<transform name="to_world"><lookat origin="0.5 -5 2.5" target="0 0 0.4" up="0 0 1"/></transform>
{film}</sensor>
"""
FILM = """<film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="32"/>
<rfilter type="box"/></film>"""
FLOOR = """<shape type="rectangle"><transform name="to_world"><scale value="3"/></transform>
<ref id="white"/></shape>
"""
GOLD = '<rgb name="eta" value=".143 .375 1.442"/><rgb name="k" value="3.983 2.386 1.603"/>'
LAMP = """<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="180"/>
<translate x="1" z="4"/></transform>
<emitter type="area"><rgb name="radiance" value="6 5 4"/></emitter></shape>
"""
SKY = '<emitter type="constant"><rgb name="radiance" value=".4 .5 .6"/></emitter>\n'


def scene(*parts, sensor=SENSOR):
    """Return a scene with a floor."""
    return HEAD + sensor.format(film=FILM) + FLOOR + "".join(parts) + "</scene>\n"


def body(kind, inside="", bsdf='<ref id="white"/>'):
    """Return a shape above the floor, turned, and scaled unevenly if Mitsuba can do that."""
    scale = 'value=".7"' if kind in ("sphere", "cylinder") else 'x=".9" y=".6" z=".7"'
    return f"""<shape type="{kind}">{inside}{bsdf}<transform name="to_world">
<scale {scale}/><rotate x=".8" y=".6" angle="40"/><translate x="-.3" z="1.1"/>
</transform></shape>
"""


def ball(bsdf):
    return f"""<shape type="sphere"><point name="center" value="0 0 1"/>
<float name="radius" value=".9"/>{bsdf}</shape>
"""


def light(kind, inside):
    return scene(body("cube"), f'<emitter type="{kind}">{inside}</emitter>')


TWOSIDED = '<bsdf type="twosided"><bsdf type="{}">{}</bsdf></bsdf>'
SMALL = """<transform name="to_world"><lookat origin="{}" target="{}" up="0 1 .1"/></transform>"""
IMAGE = '<texture name="{}" type="bitmap"><string name="filename" value="{}"/>{}</texture>'
TO_UV = """<transform name="to_uv"><scale x="2" y="1.5"/><translate x=".3" y=".1"/></transform>"""

MIRROR = 'x="-.4" y=".4" z=".4"'
INSIDE_OUT = '<boolean name="flip_normals" value="true"/>'
SHAPES = {
    "sphere": scene(body("sphere"), LAMP, SKY),
    "cube": scene(body("cube"), LAMP, SKY),
    "disk": scene(body("disk"), LAMP, SKY),
    "cylinder": scene(
        body("cylinder", '<point name="p0" value="-1 0 0"/><point name="p1" value="1 .3 .2"/>'),
        LAMP,
        SKY,
    ),
    "obj": scene(body("obj", '<string name="filename" value="body.obj"/>'), LAMP, SKY),
    "ply": scene(body("ply", '<string name="filename" value="body.ply"/>'), LAMP, SKY),
    "serialized": scene(
        body(
            "serialized",
            '<string name="filename" value="body.serialized"/>'
            '<integer name="shape_index" value="1"/>',
        ),
        LAMP,
        SKY,
    ),
    "lamps": scene(
        """<shape type="sphere"><float name="radius" value=".4"/><transform name="to_world">
<translate x="1.3" z=".6"/></transform><ref id="white"/>
<emitter type="area"><rgb name="radiance" value="3 2 1"/></emitter></shape>
<shape type="disk"><transform name="to_world"><rotate x="1" angle="150"/><translate z="2"/>
</transform><ref id="white"/><emitter type="area"><float name="radiance" value="2"/></emitter>
</shape>
<shape type="cylinder"><boolean name="flip_normals" value="true"/><float name="radius" value=".5"/>
<transform name="to_world"><translate x="-1.2"/></transform><ref id="white"/>
<emitter type="area"><rgb name="radiance" value="1 2 3"/></emitter></shape>
""",
    ),
    "mirrored lamps": scene(
        *(
            f"""<shape type="{kind}">{inside}<transform name="to_world"><scale {scale}/>
<rotate x="1" angle="{angle}"/><translate x="{x}" y="{y}" z="1.5"/></transform>
<emitter type="area"><rgb name="radiance" value="{light}"/></emitter></shape>"""
            for kind, inside, scale, angle, x, y, light in (
                ("obj", '<string name="filename" value="plate.obj"/>', MIRROR, 30, -1, 1, "4 0 0"),
                ("ply", '<string name="filename" value="body.ply"/>', MIRROR, 60, 0.3, 1, "0 1 2"),
                ("sphere", INSIDE_OUT, 'value="-.3"', 0, 1, 0, "0 2 0"),
                ("rectangle", "", 'x=".4" y=".3" z="-1"', 0, 0.3, -1, "1 0 3"),
                ("cube", "", 'x="-.3" y=".2" z=".1"', 20, -1, -1, "2 2 0"),
            )
        )
    ),
}
EMITTERS = {
    "point": light(
        "point",
        '<point name="position" value="1 -1 2.5"/><rgb name="intensity" value="9 8 7"/>',
    ),
    "spot": light(
        "spot",
        SMALL.format("1 -1 3", "0 0 0.5") + '<float name="intensity" value="30"/>'
        '<float name="cutoff_angle" value="30"/>',
    ),
    "narrow spot": light(
        "spot",
        SMALL.format("1 -1 3", "0 0 0.5") + '<float name="intensity" value="30"/>'
        '<float name="cutoff_angle" value="25"/><float name="beam_width" value="24.9"/>',
    ),
    "directional": light(
        "directional",
        '<vector name="direction" value="-1 .5 -2"/><rgb name="irradiance" value="2 3 4"/>',
    ),
    "constant": light("constant", ""),
    "envmap": light("envmap", '<string name="filename" value="sky.exr"/>'),
    "turned envmap": light(
        "envmap",
        """<string name="filename" value="sky.exr"/><float name="scale" value="1.5"/>
<transform name="to_world"><rotate x="1" angle="90"/><rotate z="1" angle="50"/></transform>""",
    ),
    "envmap about y": light(
        "envmap",
        """<string name="filename" value="sky.exr"/>
<transform name="to_world"><rotate y="1" angle="70"/></transform>""",
    ),
    "mirrored envmap": light(
        "envmap",
        """<string name="filename" value="sky.exr"/><transform name="to_world">
<rotate x="1" angle="90"/><scale x="-1"/><rotate z="1" angle="20"/></transform>""",
    ),
    "spectra": light(
        "constant", '<spectrum name="radiance" value="360:1, 500:2, 600:1.5, 830:1"/>'
    ),
}
BSDFS = {
    "diffuse": scene(
        ball(TWOSIDED.format("diffuse", '<spectrum name="reflectance" value=".3"/>')), LAMP, SKY
    ),
    "plastic": scene(
        ball('<bsdf type="plastic"><rgb name="diffuse_reflectance" value=".2 .5 .8"/></bsdf>'),
        LAMP,
        SKY,
    ),
    "nonlinear plastic": scene(
        ball(
            '<bsdf type="plastic"><rgb name="diffuse_reflectance" value=".2 .5 .8"/>'
            '<boolean name="nonlinear" value="true"/><float name="int_ior" value="1.9"/></bsdf>'
        ),
        LAMP,
        SKY,
    ),
    "rough plastic": scene(
        ball(
            '<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value=".2 .5 .8"/>'
            '<string name="distribution" value="ggx"/><float name="alpha" value=".2"/>'
            '<float name="specular_reflectance" value=".6"/></bsdf>'
        ),
        LAMP,
        SKY,
    ),
    "conductor": scene(
        ball('<bsdf type="conductor"><rgb name="specular_reflectance" value=".9 .8 .7"/></bsdf>'),
        LAMP,
        SKY,
    ),
    "gold": scene(ball(f'<bsdf type="conductor">{GOLD}</bsdf>'), LAMP, SKY),
    "rough gold": scene(
        ball(
            f'<bsdf type="roughconductor">{GOLD}'
            '<string name="distribution" value="ggx"/><float name="alpha" value=".2"/></bsdf>'
        ),
        LAMP,
        SKY,
    ),
    "rough metal": scene(
        ball(
            '<bsdf type="roughconductor"><rgb name="specular_reflectance" value=".9 .8 .7"/>'
            '<string name="distribution" value="ggx"/><float name="alpha" value=".1"/></bsdf>'
        ),
        LAMP,
        SKY,
    ),
    "dielectric": scene(ball('<bsdf type="dielectric"/>'), LAMP, SKY),
    "mirrored dielectric": scene(
        """<shape type="obj"><string name="filename" value="body.obj"/><transform name="to_world">
<scale x="-1"/><translate z="1"/></transform><bsdf type="dielectric"/></shape>""",
        LAMP,
        SKY,
    ),
    **{
        f"bitmap {name}": scene(
            body(
                "rectangle",
                "",
                TWOSIDED.format(
                    "diffuse", IMAGE.format("reflectance", "small.png", TO_UV + options)
                ),
            ),
            LAMP,
            SKY,
        )
        for name, options in (
            ("mirrored", '<string name="wrap_mode" value="mirror"/>'),
            ("clamped", '<string name="wrap_mode" value="clamp"/>'),
            ("nearest", '<string name="filter_type" value="nearest"/>'),
        )
    },
    # Rougher glass loses light there: 1.1% of an even image at .1, 3.7% at .25 by .03
    "rough dielectric": scene(
        ball(
            '<bsdf type="roughdielectric"><string name="distribution" value="ggx"/>'
            '<float name="alpha" value=".03"/></bsdf>'
        ),
        LAMP,
        SKY,
    ),
    "brushed dielectric": scene(
        body(
            "cube",
            bsdf='<bsdf type="roughdielectric"><string name="distribution" value="ggx"/>'
            '<float name="alpha_u" value=".04"/><float name="alpha_v" value=".01"/></bsdf>',
        ),
        LAMP,
        SKY,
    ),
    "thin dielectric": scene(ball('<bsdf type="thindielectric"/>'), LAMP, SKY),
    "mask": scene(
        ball(
            '<bsdf type="mask"><float name="opacity" value=".4"/>'
            + TWOSIDED.format("diffuse", "")
            + "</bsdf>"
        ),
        LAMP,
        SKY,
    ),
    "blend": scene(
        ball(
            TWOSIDED.format(
                "blendbsdf",
                """<float name="weight" value=".3"/><bsdf type="diffuse">
<rgb name="reflectance" value=".1 .2 .9"/></bsdf><bsdf type="diffuse">
<rgb name="reflectance" value=".9 .2 .1"/></bsdf>""",
            )
        ),
        LAMP,
        SKY,
    ),
    "principled": scene(
        ball(
            """<bsdf type="principled"><rgb name="base_color" value=".6 .3 .2"/>
<float name="roughness" value=".5"/></bsdf>"""
        ),
        LAMP,
        SKY,
    ),
    "checkerboard": scene(
        body(
            "rectangle",
            "",
            TWOSIDED.format(
                "diffuse",
                """<texture name="reflectance" type="checkerboard">
<rgb name="color0" value=".9 .1 .1"/>
<transform name="to_uv"><scale x="1.5" y="2"/></transform></texture>""",
            ),
        ),
        LAMP,
        SKY,
    ),
    **{
        f"bitmap on {kind}": scene(
            body(
                kind,
                more,
                TWOSIDED.format("diffuse", IMAGE.format("reflectance", "paint.png", to_uv)),
            ),
            LAMP,
            SKY,
        )
        for kind, more, to_uv in (
            ("rectangle", "", TO_UV),
            ("cube", "", ""),
            ("sphere", "", ""),
            ("disk", "", ""),
            ("cylinder", "", ""),
            ("obj", '<string name="filename" value="body.obj"/>', TO_UV),
            ("ply", '<string name="filename" value="body.ply"/>', ""),
            (
                "serialized",
                '<string name="filename" value="body.serialized"/>'
                '<integer name="shape_index" value="1"/>',
                "",
            ),
        )
    },
}


def seen(kind, inside, origin="0.5 -5 2.5", before=""):
    to_world = (
        f'<transform name="to_world">{before}'
        f'<lookat origin="{origin}" target="0 0 0.8" up="0 0 1"/></transform>'
    )
    sensor = f'<sensor type="{kind}">{inside}{to_world}{{film}}</sensor>'
    return scene(body("cube"), LAMP, SKY, sensor=sensor)


SENSORS = {
    "vertical": seen(
        "perspective",
        '<float name="fov" value="40"/><string name="fov_axis" value="y"/>',
    ),
    "diagonal": seen(
        "perspective",
        '<float name="fov" value="60"/><string name="fov_axis" value="diagonal"/>',
    ),
    "focal length": seen("perspective", '<string name="focal_length" value="35mm"/>'),
    "off centre": seen(
        "perspective",
        """<float name="fov" value="50"/><float name="principal_point_offset_x" value=".2"/>
<float name="principal_point_offset_y" value="-.1"/>""",
    ),
    "thin lens": seen(
        "thinlens",
        """<float name="fov" value="50"/><float name="aperture_radius" value=".3"/>
<float name="focus_distance" value="3"/>""",
    ),
    "orthographic": seen("orthographic", "", before='<scale x="2" y="2"/>'),
}
CASES = {**SHAPES, **EMITTERS, **BSDFS, **SENSORS}
