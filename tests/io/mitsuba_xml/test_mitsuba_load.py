"""Scenes of Mitsuba as nodes: parameters, other files, references, old names, and errors."""

import numpy as np
import pytest

from photonmap.errors import InputError, SceneWarning

BALL = '<shape type="sphere"/>'


def radius_of(scene):
    return float(np.abs(scene.meshes[0].vertices).max())


def test_parameters(load):
    scene = load(
        """<default name="r" value="2"/><default name="rr" value="3"/>
<default name="r" value="5"/>
<shape type="sphere"><float name="radius" value="${}"/></shape>""".replace("{}", "rr")
    )
    assert radius_of(scene) == pytest.approx(3.0)


def test_the_first_default_counts_and_dollars_can_be_escaped(load):
    scene = load(r"""<default name="r" value="2"/><default name="r" value="5"/>
<shape type="sphere" id="\$r"><float name="radius" value="1$r"/></shape>""")
    assert radius_of(scene) == pytest.approx(12.0)
    assert scene.meshes[0].name == "$r"


def test_included_files(load):
    files = {
        "parts/scene.xml": f'<scene version="3.0.0">{BALL}<include filename="one.xml"/></scene>',
        "parts/one.xml": '<shape type="cube" version="3.0.0"/>',
        "paint.xml": '<bsdf type="diffuse" version="0.6.0"><float name="reflectance" value=".2"/>'
        "</bsdf>",
    }
    inside = '<shape type="sphere" id="ball"><include filename="paint.xml"/></shape>'
    scene = load(f'<include filename="parts/scene.xml"/>{inside}', files=files)
    assert [mesh.name for mesh in scene.meshes] == ["sphere", "cube", "ball"]
    assert scene.meshes[2].material.reflectance == 0.2


def test_messages_name_the_included_file(load):
    """The scene's own lines are named alone."""
    sky = '<emitter type="constant"/>'
    around = {"parts.xml": f'<scene version="3.0.0">\n{BALL}{sky}</scene>'}
    with pytest.raises(
        InputError, match=r"parts\.xml:2: the scene has an environment already, in line 1 of"
    ):
        load(f'{sky}<include filename="parts.xml"/>', files=around)
    part = {"parts.xml": '<scene version="3.0.0"><shape type="cube" id="a"/></scene>'}
    again = r"parts\.xml:1: the id 'a' is that of line 1 of scene\.xml"
    with pytest.raises(InputError, match=again):
        load('<shape type="sphere" id="a"/><include filename="parts.xml"/>', files=part)
    odd = '<shape type="cube"><float name="odd" value="1"/></shape>'
    part = {"parts.xml": f'<scene version="3.0.0">\n{odd}</scene>'}
    wanted = r"odd of 'cube in line 1', 'cube in line 2 of parts\.xml'$"
    with pytest.warns(SceneWarning, match=wanted):
        load(f'{odd}<include filename="parts.xml"/>', files=part)


def test_files_are_found_in_further_folders(load):
    inside = '<path value="paints"/><shape type="sphere"><include filename="paint.xml"/></shape>'
    paint = '<bsdf type="diffuse" version="3.0.0"><float name="reflectance" value=".2"/></bsdf>'
    scene = load(inside, files={"paints/paint.xml": paint})
    assert scene.meshes[0].material.reflectance == 0.2


def test_references_may_come_before_what_they_name(load):
    scene = load("""<shape type="sphere"><ref id="b"/></shape>
<shape type="cube"><ref id="a"/></shape>
<bsdf type="diffuse" id="a"><float name="reflectance" value=".2"/></bsdf><alias id="a" as="b"/>""")
    ball, cube = scene.meshes
    assert ball.material is cube.material
    assert (ball.material.name, ball.material.reflectance) == ("a", 0.2)


def test_names_of_old_versions(load):
    scene = load(
        """<default name="tall" value="4"/>
<shape type="sphere"><transform name="toWorld"><scale z="$tall"/></transform>
<bsdf type="dielectric"><float name="intIOR" value="2"/><float name="extIOR" value="1"/></bsdf>
</shape>
<camera type="perspective"><string name="fovAxis" value="y"/><float name="fov" value="30"/>
<transform name="toWorld"><lookAt origin="0 0 9" target="0 0 0"/></transform></camera>
<luminaire type="point"><blackbody name="intensity" temperature="5000K" scale="2"/></luminaire>""",
        "0.6.0",
    )
    assert radius_of(scene) == pytest.approx(4.0)
    assert scene.meshes[0].material.ior == 2.0
    assert scene.camera.fov == pytest.approx(30.0)
    assert scene.lights[0].intensity(np.array([550.0])) == pytest.approx(2.0 * 12713.0, rel=1e-4)


def test_new_versions_do_not_know_old_names(load):
    moved = '<shape type="sphere"><transform name="toWorld"><scale value="4"/></transform></shape>'
    with pytest.warns(SceneWarning, match="shape parameter toWorld of 'sphere in line 1'"):
        assert radius_of(load(moved)) == pytest.approx(1.0)


def test_comments_may_hold_dashes(load):
    with pytest.raises(InputError, match=r"scene.xml:4: <thing>"):
        load(f"<!-- one -- two ---\n\n<!-- -->{BALL}<!-- <a> -->\n<thing/>")
    load(f"<!-- one -- two -->{BALL}")


def test_render_settings_are_ignored(load):
    load(
        BALL
        + """<integrator type="path"/><sensor type="perspective"><sampler type="independent">
<integer name="sample_count" value="9"/></sampler><film type="hdrfilm"><rfilter type="box"/></film>
</sensor>"""
    )


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ("\n<shape>", r"scene.xml:2: is not XML \(mismatched tag\)"),
        ("\n\n<thing/>", "scene.xml:3: <thing> is not known; known are scene, shape"),
        ('\n<shape type="sphre"/>', "scene.xml:2: a shape of type 'sphre' .* 'sphere'"),
        ('<include filename="scene.xml"/>', "scene.xml:1: files include each other without end"),
        ('<include filename="none.xml"/>', "scene.xml:1: file 'none.xml' does not exist"),
        ('<include filename="../a.xml"/>', "'../a.xml' lies outside of the folder"),
        ('<include filename="/etc/passwd"/>', "'/etc/passwd' lies outside of the folder"),
        (r'<include filename="..\a.xml"/>', "lies outside of the folder"),
        ('<path value="/"/>', "'/' lies outside of the folder"),
        ('<shape type="$kind"/>', r"\$kind has no value; add <default name=\"kind\""),
        (
            '<default name="alpha" value="1"/><default name="b" value="2"/>\n<shape type="$alfa"/>',
            r"xml:2: \$alfa has no value; did you mean 'alpha'\? Defined are 'alpha', 'b'; or add",
        ),
        ('<default name="a"/>', "<default> lacks value"),
        ('<shape type="sphere"><ref id="b"/></shape>', "nothing has the id 'b'"),
        ('<alias id="b" as="c"/>', "nothing has the id 'b'"),
        (2 * '\n<shape type="sphere" id="a"/>', "xml:3: the id 'a' is that of line 2 too"),
        ('<shape type="cube" id="a"><ref id="a"/></shape>', "refers to itself"),
        ('<shape type="cube"><float name="x" value="1"/></shape>' * 2 + "<a>" * 200, "are nested"),
    ],
)  # fmt: skip
def test_errors(load, inside, message):
    with pytest.raises(InputError, match=message) as caught:
        load(inside)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("<html/>", ":1: <html> is not a scene of Mitsuba"),
        ("<scene/>", ":1: its version is missing"),
        ('<scene version="new"/>', ":1: 'new' is not a version of Mitsuba"),
        ('<scene version="3.0.0"/>', "has no triangles"),
        (
            '\n<!DOCTYPE s [<!ENTITY a "b">]>\n<scene version="3.0.0"/>',
            ":2: <!DOCTYPE> is not read",
        ),
        ('<!DOCTYPE s SYSTEM "file:///etc/passwd"><scene version="3.0.0"/>', "<!DOCTYPE> is not"),
        ('<?xml version="1.0" encoding="klingon"?><scene version="3.0.0"/>', "encoding"),
    ],
)
def test_files_that_are_not_scenes(tmp_path, text, message):
    from photonmap.io.readers.registry import read_file

    (tmp_path / "a.xml").write_text(text)
    with pytest.raises(InputError, match=message):
        read_file(tmp_path / "a.xml")


def test_parameters_and_files_do_not_grow_without_bounds(load):
    doubling = "".join(f'<default name="a{i + 1}" value="$a{i}$a{i}"/>' for i in range(60))
    with pytest.raises(InputError, match="longer than 4096"):
        load(f'<default name="a0" value="ha"/>{doubling}')
    names = [f"part{i}.xml" for i in range(30)]
    files = {}
    for name, after in zip(names, [*names[1:], "last.xml"], strict=True):
        include = f'<include filename="{after}"/>'
        files[name] = f'<scene version="3.0.0">{include}{include}</scene>'
    files["last.xml"] = '<scene version="3.0.0"/>'
    with pytest.raises(InputError, match="include each other without end"):
        load('<include filename="part0.xml"/>', files=files)


def test_shared_nodes_are_read_once(load):
    blends = "".join(
        f'<bsdf type="blendbsdf" id="b{i + 1}"><ref id="b{i}"/><ref id="b{i}"/></bsdf>'
        for i in range(60)
    )
    scene = load(
        f'<bsdf type="diffuse" id="b0"/>{blends}<shape type="sphere"><ref id="b60"/></shape>'
    )
    assert scene.meshes[0].material.reflectance == pytest.approx(0.5)
    both = '<bsdf type="twosided" id="b0"><bsdf type="diffuse"/></bsdf>'
    load(f'{both}{blends}<shape type="rectangle"><ref id="b60"/></shape>')
