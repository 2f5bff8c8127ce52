import numpy as np
import pytest

from photonmap.errors import InputError
from photonmap.spectra.tables import read_table


@pytest.fixture
def read(tmp_path):
    def read(text, name="red.csv", **limits):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_table(path, **limits)

    return read


TABLE = "nm,dark skin,sky\n400,0.1,0.2\n500,0.3,0.4\n"


def assert_table(curves, names=("dark skin", "sky")):
    assert curves.names == names
    np.testing.assert_array_equal(curves.wavelengths, [400, 500])
    np.testing.assert_array_equal(curves.values, [[0.1, 0.3], [0.2, 0.4]])


@pytest.mark.parametrize(
    "text",
    [
        TABLE,
        TABLE.replace(",", ", "),
        TABLE.replace(",", ";"),
        TABLE.replace(",", ";").replace(".", ","),
        TABLE.replace(",", "\t").replace(".", ","),
        TABLE.replace(",", "\t").replace("0.4", "0.4\t\t"),
        TABLE.replace("dark skin", '"dark skin"').replace(",", "  "),
        TABLE.replace("dark skin", '"dark skin"'),
        TABLE.replace("\n", ",,\n"),
        TABLE.replace("\n", "\r\n").encode("utf-8-sig"),
        TABLE.replace("\n", "\r"),
        TABLE.removesuffix("\n"),
        "# head\n% 1\n//\n\n" + TABLE.replace("0.4", "0.4 # a, b"),
        TABLE.replace("0.2", "0.2 // 1").replace("0.4", "0.4 % sky"),
        TABLE.replace("0.1", "1e-1").replace("0.4", " +.4 "),
        TABLE + ",,\n\n",
    ],
    ids=["comma", "comma space", "semicolon", "semicolon comma", "tab comma", "trailing tab"]
    + ["spaces", "quoted", "trailing commas", "crlf bom", "cr", "no newline", "comments"]
    + ["comments behind", "number forms", "blank rows"],
)  # fmt: skip
def test_text_forms(read, text):
    assert_table(read(text))


def test_first_row_with_a_comment(read):
    assert_table(read("\ufeff400 .1 .2 # a, b\n500 .3 .4\n"), ("red 1", "red 2"))


def test_names(read):
    assert read("400 1\n500 2\n").names == ("red",)
    assert read("nm,\n400,1\n500,2\n").names == ("red",)
    assert read("\tsky\n400\t1\n500\t2\n").names == ("sky",)
    assert_table(read("400 .1 .2\n500 .3 .4\n", "red.spd"), ("red 1", "red 2"))
    assert_table(read(TABLE.replace("dark skin", "")), ("red 1", "sky"))
    assert_table(read(TABLE.replace("sky", "")), ("dark skin", "red 2"))
    assert_table(read(TABLE.replace("sky", ' "a, b"')), ("dark skin", "a, b"))
    assert_table(read(TABLE.replace("sky", "R (%)")), ("dark skin", "R (%)"))
    assert_table(read(TABLE.replace("sky", "Tür").encode("latin-1")), ("dark skin", "Tür"))


def test_round_trip(tmp_path):
    random = np.random.default_rng(1)
    table = np.column_stack([np.arange(380.0, 801.0), random.random((421, 130))])
    path = tmp_path / "many.txt"
    path.write_text("\n".join("\t".join(map(repr, row)) for row in table.tolist()))
    curves = read_table(path, 0, 1)
    np.testing.assert_array_equal(curves.values, table[:, 1:].T)
    assert curves["many 130"] == curves[129]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("nm R\n400 0.1\n500 O.2\n", r":3: 'O\.2' is not a number; .*decimal point"),
        ("400 0,1\n500 0,2\n", r":2: '500 0' is not a number"),
        ("nm R\n400 0,1\n", r":2: '0,1' is not a number; .*decimal point"),
        ("400|0.1\n500|0.2\n", r":2: '500\|0\.2' is not a number; .*semicolons"),
        ("400 0.1\n500 1_0\n", r":2: '1_0' is not a number"),
        ("400,0.1,1\n500,,1\n", r":2: '' is not a number"),
        ("400 45 %\n500 46 %\n", r":1: '%' is not a number"),
        ("400 0.1\n# x\n500 nan\n", r":3: value is nan at 500 nm; write a finite"),
        ("400 0.1\n500 1e999\n", r":2: value is inf at 500 nm"),
        ("400 0.1\nnan 0.1\n", r":2: wavelength is nan; write a finite"),
        ("400 0.1\n500 0.1 0.2\n", r":2: has 3 cells, but line 1 has 2"),
        ("nm dark skin\n400 0.1\n", r":2: has 2 cells, but line 1 has 3; .*quote"),
        ("nm,a,b\n400,1,2\n500,1,\n", r":3: has 2 cells, but line 1 has 3"),
        ("400 1\n ;# x\n", r":2: ';' is not a number"),
        ("400;1\n ;# x\n", r":2: has 0 cells, but line 1 has 2"),
        ("# a\n400\n500\n", r":2: has no value; write"),
        ("400 1\n500 1\n450 1\n", r":3: .*450 follows 500; sort"),
        ("500 1\n450 1\n400 1\n", r":2: .*450 follows 500; sort"),
        ("400 1\n500 1\n500 1\n", r":3: .*500 follows 500; .*one for each"),
        ("\n4e-7 1\n5e-7 1\n", r":2: .*metres: multiply by 1e9"),
        ("0.4 1\n0.5 1\n", r":1: .*micrometres: multiply by 1000"),
        ("4000 1\n5000 1\n", r":1: .*ångströms: divide by 10"),
        ("# x\nnm R\n400 1\n", r":2: holds fewer than 2 rows"),
        ("400 1\n", r":1: holds fewer than 2 rows"),
        ("# none\n", r"red\.csv: holds fewer than 2 rows"),
        ("", r"red\.csv: is empty"),
        ("400 1\n500\0 1\n", r":2: is not a text file \(byte 0x00\)"),
        (b"\x1f\x8b\x08\x00", r":1: is not a text file \(byte 0x1f\); unpack"),
        ("400," + "x" * 200_000 + "\n", r"red\.csv:1: 'x{60}\.\.\.' is not a number"),
        (TABLE.replace("0.4", "-0.4"), r":3: value is -0\.4 .*\(column 'sky'\)$"),
    ],
)
def test_malformed(read, text, message):
    with pytest.raises(InputError, match=message) as caught:
        read(text, low=0)
    assert "\n" not in str(caught.value)
    assert "red.csv" in str(caught.value)


def test_no_file(tmp_path):
    with pytest.raises(InputError, match=r"none\.csv: cannot be read \(No such file"):
        read_table(tmp_path / "none.csv")
    with pytest.raises(InputError, match="is a directory; name a file"):
        read_table(tmp_path)


def test_limits(read):
    limits = {"low": 0, "high": 1.001, "kind": "reflectance"}
    assert read("500 0\n540 1.001\n", **limits).values.max() == 1.001
    message = r"red\.csv:2: reflectance is {} at 540 nm; it must lie between 0 and 1{}$"
    for value in (1.2, -0.1):
        with pytest.raises(InputError, match=message.format(value, "")):
            read(f"500 0.5\n540 {value}\n", **limits)
    with pytest.raises(InputError, match=message.format(45, ": divide percent by 100")):
        read("500 0.5\n540 45\n550 50\n", **limits)
    with pytest.raises(InputError, match=r":2: light is -1 at 540 nm; light cannot be negative$"):
        read("500 0\n540 -1\n", low=0, kind="light")
    assert read("500 -1\n540 1e6\n").values.min() == -1
