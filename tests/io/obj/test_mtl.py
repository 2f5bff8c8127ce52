import math

import numpy as np
import pytest

from photonmap.errors import InputError, SceneWarning
from photonmap.io.png import encode_png
from photonmap.io.readers.obj.mtl import read_mtl
from photonmap.scene.material import Material


@pytest.fixture
def read(tmp_path):
    def read(text):
        path = tmp_path / "a.mtl"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_mtl(path)

    return read


def test_colors_and_names(read):
    text = "# head\nnewmtl red wall # dark\n\tKd 0.5 .25 1e-1 # x\n Ke 3 2 1\nnewmtl b\nKd 0.3\n"
    assert read(text) == {
        "red wall": Material("red wall", (0.5, 0.25, 0.1), (3, 2, 1)),
        "b": Material("b", (0.3, 0.3, 0.3)),
    }


def test_continued_lines(read):
    wanted = {"Tür": Material("Tür", (0.1, 0.2, 0.3))}
    assert read("newmtl Tür\nKd 0.1 \\\n0.2 0.3\n".encode()) == wanted


def test_hash_inside_a_name_is_kept(read):
    assert list(read("newmtl Material_#25 # the wall #2\nnewmtl b\n")) == ["Material_#25", "b"]


def test_nothing_but_comments(read):
    assert read("# none\n") == {}


def test_neutral_statements_are_silent(read):
    text = (
        "newmtl a\nKa 1 1 1\nmap_Ka a.png\nKs 0 0 0\nNi 1\nTf 1 1 1\nd 1.0\nTr 0\nillum 2\nPm 0\n"
    )
    assert read(text) == {"a": Material("a")}


@pytest.mark.parametrize(
    "statement",
    ["Ks 0.1 0 0", "Ks spectral 0.5", "Ns 10", "Ni 1.5", "Tf 1 0 0", "illum 3"]
    + ["map_Ks -o 1 1 1 my wood.png", "disp a.png"]
    + ["refl -type sphere a.png", "sharpness 60"],
)
def test_what_is_not_simulated_is_named(read, statement):
    with pytest.warns(SceneWarning, match=rf"a.mtl: .*'{statement.split()[0]}' of 'wood'"):
        materials = read(f"newmtl wood\nKd 0.5\n{statement}\n")
    assert materials["wood"].reflectance == (0.5, 0.5, 0.5)


def test_sheen(read, tmp_path):
    text = "newmtl a\nKd 0.5\nPs 0.7\nnewmtl b\nPs 0.1 0.2 0.3\nsheen_roughness 0.4\n"
    materials = read(text + "newmtl c\nPs 0\nnewmtl d\nPr 0.5\nPs 0.3\n")
    assert materials["a"] == Material("a", (0.5,) * 3, sheen=(0.7,) * 3)
    assert materials["b"] == Material("b", sheen=(0.1, 0.2, 0.3), sheen_roughness=0.4)
    assert materials["c"] == Material("c")
    assert materials["d"].sheen == (0.3,) * 3
    assert materials["d"].is_glossy
    (tmp_path / "s.png").write_bytes(encode_png(np.full((2, 2, 3), 200, np.uint8)))
    sheen = read("newmtl a\nKd 0.5\nPs 0.5\nmap_Ps s.png\n")["a"].sheen
    assert sheen.image.srgb
    assert sheen.factor == (0.5,) * 3
    assert read("newmtl a\nKd 0.5\nmap_Ps s.png\n")["a"].sheen.factor == (1.0,) * 3


@pytest.mark.parametrize(
    ("cover", "statement"),
    [("Pc 0.5", "Ps 0.7"), ("Ni 1.5\nillum 7", "Ps 0.7"), ("Ni 1.5\nillum 7", "map_Ps s.png")]
    + [("Ks 0.5\nillum 3", "Ps 0.7")],
)
def test_sheen_that_is_left_out_is_named(read, tmp_path, cover, statement):
    (tmp_path / "s.png").write_bytes(encode_png(np.full((2, 2, 3), 200, np.uint8)))
    wanted = r" of 'a': sheen \(which brightens cloth where it is seen at grazing angles\)"
    with pytest.warns(SceneWarning, match=f"not simulated: '{statement.split()[0]}'{wanted}"):
        found = read(f"newmtl a\n{cover}\n{statement}\nsheen_roughness 0.3\n")["a"]
    assert not found.has_sheen


def test_clear_coats(read, tmp_path):
    materials = read("newmtl a\nKd 0.5\nPc 0.7\nPcr 0.2\nnewmtl b\nKd 0.5\nPc 0\nPcr 0.1\n")
    assert materials["a"] == Material("a", (0.5,) * 3, coat=0.7, coat_roughness=0.2)
    assert not materials["b"].is_coated
    (tmp_path / "r.png").write_bytes(encode_png(np.zeros((2, 2, 3), np.uint8)))
    rough = read("newmtl a\nKd 0.5\nPc 0.7\nmap_Pcr r.png\n")["a"].coat_roughness
    assert not rough.image.srgb
    with pytest.warns(SceneWarning, match="'map_Pc' of 'a'; 'map_Pcr' of 'a'"):
        glass = read("newmtl a\nNi 1.5\nillum 7\nmap_Pc r.png\nmap_Pcr r.png\n")["a"]
    assert glass == Material("a", 0.0, ior=1.5)
    with pytest.warns(SceneWarning, match="'Pc' of 'a'; 'Pcr' of 'a'"):
        glass = read("newmtl a\nNi 1.5\nillum 7\nPc 0.7\nPcr 0.2\n")["a"]
    assert glass == Material("a", 0.0, ior=1.5)


BLENDER = """# Blender {}MTL File: 'None'
newmtl a
Ns {}
Ka {} {} {}
Kd 0.8 0.4 0.2
Ks 0.5 0.5 0.5
Ni 1.45
illum {}
"""


@pytest.mark.parametrize(
    ("header", "exponent", "ambient", "model", "expected"),
    [
        ("4.2.0 ", 250, 1, 2, Material("a", (0.8, 0.4, 0.2), glossy=0.04, roughness=0.5)),
        ("", 225, 1, 2, Material("a", (0.8, 0.4, 0.2), glossy=0.04, roughness=0.5)),
        ("4.2.0 ", 250, 1, 3, Material("a", (0.0,) * 3, glossy=(0.8, 0.4, 0.2), roughness=0.5)),
        ("4.2.0 ", 250, 1, 1, Material("a", (0.8, 0.4, 0.2))),
    ],
)
def test_what_blender_writes(read, header, exponent, ambient, model, expected):
    """Its roughness stands in Ns, its specular in Ks, and under illum 3 its metallic in Ka."""
    text = BLENDER.format(header, exponent, ambient, ambient, ambient, model)
    if model > 1:
        assert read(text) == {"a": expected}
        return
    with pytest.warns(SceneWarning, match="'Ns' of 'a'; 'Ks' of 'a'"):
        assert read(text) == {"a": expected}


PBR = "Pr 0.1\nPm {}\nPs 0\nPc 0\nPcr 0.03\naniso 0\nanisor 0\nTf {} {} {}\n"


def test_blender_glass_is_what_transmits(read):
    """With PBR extensions, its transmission stands in Tf, and each crossing has the root of Kd."""
    text = BLENDER.format("4.2.0 ", 810, 1, 1, 1, 2).replace("0.8 0.4 0.2", "0.81 0.64 0.25")
    glass = Material("a", 0.0, ior=1.45, tint=(0.9, 0.8, 0.5), roughness=0.1)
    assert read(text + PBR.format(0, 1, 1, 1)) == {"a": glass}
    part = read(text + PBR.format(0.5, 0.5, 0.5, 0.5))["a"]
    assert (part.transmission, part.reflectance) == (0.25, (0.81, 0.64, 0.25))
    assert part.glossy == pytest.approx((0.45 / 2.45) ** 2)
    assert read(text + PBR.format(1, 1, 1, 1))["a"].ior is None


def test_blender_metal_with_an_opacity_is_no_glass(read):
    metal = read(BLENDER.format("4.2.0 ", 250, 1, 1, 1, 6) + "d 0.5\n")["a"]
    assert metal == Material("a", (0.0,) * 3, glossy=(0.8, 0.4, 0.2), roughness=0.5, alpha=0.5)
    assert read(BLENDER.format("4.2.0 ", 250, 1, 1, 1, 9) + "d 0.5\n")["a"].alpha == 0.5


def test_one_warning_a_file(read):
    with pytest.warns(SceneWarning) as record:
        read("newmtl a\nillum 1\nNs 1\nKs 1 1 1\nNs 2\nnewmtl b\nNs 1\n")
    assert len(record) == 1
    assert "'Ns' of 'a', 'b'; 'Ks' of 'a'" in str(record[0].message)


def test_last_of_two_wins(read):
    with pytest.warns(SceneWarning, match=r"repeated.*'a'"):
        materials = read("newmtl a\nKd 0.1\nNs 3\nnewmtl b\nnewmtl a\nKd 0.2\n")
    assert materials["a"].reflectance == (0.2, 0.2, 0.2)


@pytest.mark.parametrize("value", [1.0005, 1.001])
def test_just_above_one_is_clamped(read, value):
    with pytest.warns(SceneWarning, match=r"Kd above 1.*'a'"):
        materials = read(f"newmtl a\nKd {value} 1 0.5\n")
    assert materials["a"].reflectance == (1.0, 1.0, 0.5)


@pytest.mark.parametrize("value", ["1.002", "-0.1", "nan", "inf", "1e999"])
def test_reflectance_outside(read, value):
    with pytest.raises(InputError, match=rf"a\.mtl:3: Kd '0 {value} 0'.* \[0, 1\]"):
        read(f"newmtl a\n# white\nKd 0 {value} 0\n")


@pytest.mark.parametrize("value", ["-1", "nan", "inf", "-inf"])
def test_emission_outside(read, value):
    with pytest.raises(InputError, match=rf"a\.mtl:2: Ke '{value} 0 0'.*finite"):
        read(f"newmtl a\nKe {value} 0 0\n")


def test_emission_has_no_upper_limit(read):
    assert math.isclose(read("newmtl a\nKe 1e6\n")["a"].emission[2], 1e6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("newmtl a\nKd 0.1 0.2\n", r":2: Kd '0.1 0.2' has 2 numbers; write one or three"),
        ("newmtl a\nKd\n", r":2: Kd '' has 0 numbers"),
        ("newmtl a\nKd 0,5\n", r":2: Kd '0,5' is not a number; .*decimal point"),
        ("newmtl a\nKd 1_0 0 0\n", r":2: Kd '1_0 0 0' is not a number"),
        ("newmtl a\n\nKd spectral red.rfl\n", r":3: Kd: .*red.rfl: cannot be read"),
        ("newmtl a\nKd spectral dark skim\n", r":2: Kd: .*did you mean 'dark skin'"),
        ("newmtl a\nKe spectral -1\n", r":2: Ke: '-1' is not a light"),
        ("newmtl a\nKd spectral\n", r":2: Kd: '' is not a colour"),
        ("newmtl a\nKd xyz 1 1\n", r":2: Kd 'xyz 1 1' has 2 numbers"),
        ("newmtl a\nKd xyz 20 30 10\n", r":2: Kd: no reflectance .* divide values .* by 100"),
        ("newmtl a\nd x\n", r":2: d 'x' is not a number"),
        ("newmtl a\nillum\n", r":2: illum ''; write a finite"),
        ("newmtl a\nNi inf\n", r":2: Ni 'inf'; write a finite"),
        ("Kd 1 1 1\n", r":1: 'Kd' before any newmtl"),
        ("", r": is empty"),
        (b"newmtl a\nKd \x001\n", r":2: is not a text file \(byte 0x00\).*UTF-8"),
        ("newmtl a\nKd 1 1 \\\n1\nKd x\n", r":4: Kd 'x'"),
    ],
)
def test_errors_name_line_value_and_remedy(read, text, message):
    with pytest.raises(InputError, match=r"a\.mtl" + message):
        read(text)


@pytest.mark.parametrize(
    ("statements", "material"),
    [
        ("illum 3\nKs 0.9\nKd 0 0 0\n", Material("a", (0, 0, 0), mirror=(0.9, 0.9, 0.9))),
        ("illum 5\nKs 0.9 0.8 0.7\n", Material("a", 0.0, mirror=(0.9, 0.8, 0.7))),
        ("Ks spectral 0.25\nillum 3\nKd 0.5\n", Material("a", (0.5, 0.5, 0.5), mirror=0.25)),
        ("illum 7\nNi 1.5\n", Material("a", 0.0, ior=1.5)),
        ("illum 4\nNi 1.33\nTf 0.9 1 1\n", Material("a", 0.0, ior=1.33, tint=(0.9, 1, 1))),
        ("illum 6\nNi 1.5\nKd 0\nKe 2\n", Material("a", 0.0, (2, 2, 2), ior=1.5)),
        ("illum 2\nKs 0\n", Material("a")),
        ("illum 2\nKs 0.5\nNs 30\n", Material("a", glossy=(0.5,) * 3, roughness=0.5)),
        ("Ks 0.5\nNs 30\nKd 0.2\n", Material("a", (0.2,) * 3, glossy=(0.5,) * 3, roughness=0.5)),
        ("Ks 0\nNs 30\n", Material("a")),
        ("Pr 0.3\nKs 0.5\nNs 30\nillum 3\n", Material("a", glossy=(0.5 / 2.5) ** 2, roughness=0.3)),
        ("Pr 0.3\nNi 1.8\n", Material("a", glossy=(0.8 / 2.8) ** 2, roughness=0.3)),
        (
            "Pm 1\nKd 0.9 0.6 0.3\n",
            Material("a", (0.0,) * 3, glossy=(0.9, 0.6, 0.3), roughness=0.5),
        ),
        (
            "illum 3\nPm 1\nKs 0.5\nKd 0.9 0.6 0.3\n",
            Material("a", (0.0,) * 3, glossy=(0.9, 0.6, 0.3), roughness=0.5),
        ),
        ("illum 7\nNi 1.5\nPm 0\n", Material("a", 0.0, ior=1.5)),
        ("Pr 0\nPm 1\nKd 0.9 0.6 0.3\n", Material("a", (0.0,) * 3, glossy=(0.9, 0.6, 0.3))),
        (
            "Pr 0.5\nPm 0.5\nKd spectral 0.8\n",
            Material("a", 0.4, glossy=0.4 + 0.5 * (0.5 / 2.5) ** 2, covering=0.2**2, roughness=0.5),
        ),
    ],
)
def test_illumination_models(read, statements, material):
    assert read("newmtl a\n" + statements) == {"a": material}


@pytest.mark.parametrize(
    ("statements", "named"),
    [
        ("illum 3\nNi 1.5\nKs 0.5\n", "'Ni' of 'a'"),
        ("illum 3\n", "'illum' of 'a'"),
        ("illum 7\n", "'illum' of 'a'"),
        *((f"illum {model}\n", "'illum' of 'a'") for model in (-1, 8, 9, 10, 11)),
        ("illum 7\nNi 1.5\nKd 0.5\nKs 0.1\n", "'Kd' of 'a'; 'Ks' of 'a'"),
        ("illum 1\nKs 0.5\nNs 30\n", "'Ns' of 'a'; 'Ks' of 'a'"),
        ("illum 3\nKs 0.5\nNs 30\nPm 0\n", "'Ns' of 'a'"),
        ("illum 3\nKs 0.5\naniso 0.5\nanisor 0.1\n", "'aniso' of 'a'"),
        ("aniso 0.5\nanisor 0.1\n", "'aniso' of 'a'"),
        ("Pr 0.3\nNi 0.5\n", "'Ni' of 'a'"),
    ],
)
def test_what_an_illumination_model_leaves_out_is_named(read, statements, named):
    with pytest.warns(SceneWarning, match=f"not simulated: {named}$"):
        read("newmtl a\n" + statements)


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("Ni 1 2", r":2: Ni '1 2'; write a finite number"),
        ("Ks 1.5", r":2: Ks '1.5' is not a reflectance; keep it within \[0, 1\]"),
        ("Tf -1", r":2: Tf '-1' is not a transmittance"),
    ],
)
def test_optics_out_of_bounds(read, statement, message):
    with pytest.raises(InputError, match=message):
        read(f"newmtl a\n{statement}\n")


@pytest.mark.parametrize("statement", ["Ni 0", "Ni -1.0", "Ns -1.96"])
def test_what_exporters_write_for_want_of_a_value(read, statement):
    with pytest.warns(SceneWarning, match=f"not simulated: '{statement}' of 'a'$"):
        assert read(f"newmtl a\nKd 0.25\n{statement}\n")["a"] == Material("a", (0.25,) * 3)


def test_a_material_without_a_name_is_left_out(read):
    with pytest.warns(SceneWarning, match=r"a\.mtl: a newmtl without a name is left out$"):
        assert list(read("newmtl a\nnewmtl\nKd 1 1 1\nnewmtl b\n")) == ["a", "b"]
