"""Photometric files (IES LM-63, type C): read as tables, refused in one line, written again."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.errors import InputError
from photonmap.scene.photometric import as_table, read_ies, save_ies

REAL = """IESNA:LM-63-2002
[TEST] BALLABS TEST NO. 12345.0
[TESTLAB] BALLABS
[ISSUEDATE] 12-MAY-2011
[MANUFAC] Lumière & Söhne
[LUMCAT] DL-150, [LAMP] one 26 W compact
[MORE] round downlight, specular reflector
TILT=NONE
1 1800. 1.5 7 5 1 2 -.43 .0 .12
0.9 1.0 26.0
0 15 30 45 60
75 90
0 22.5
45 67.5 90
1000 900 700 400
   100 20 0
1000 910 720 430
   120 25 0
1000 920, 740, 460
   140 30 0
1000 930 760 490
   160 35 0
1000 940 780 520
   180 40 0
"""
FACTOR = 1.5 * 0.9
"""Of candelas: multiplier · ballast factor."""
SMALL = """IESNA91
TILT=NONE
1 1000 1 3 1 1 2 0 0 0
1 1 100
0 45 90
0
100 80 10
"""


def write(folder, text):
    path = folder / "lamp.ies"
    path.write_bytes(text.encode("latin-1"))
    return path


def make(azimuths, candelas, polar=(0, 90, 180), multiplier=1):
    """Return the text of a file, candelas (H, V)."""
    rows = (polar, azimuths, *candelas)
    head = (
        f"IESNA:LM-63-1995\nTILT=NONE\n1 -1 {multiplier} {len(polar)} {len(azimuths)} 1 2 0 0 0\n"
    )
    return head + "1 1 9\n" + "".join(" ".join(map(str, row)) + "\n" for row in rows)


def test_a_file_as_it_comes(tmp_path):
    """Keywords, commas, numbers that go on in the next line, multiplier and ballast factor."""
    table = read_ies(write(tmp_path, REAL))
    assert (table.shape, table.dtype) == ((181, 361), np.float32)
    np.testing.assert_allclose(table[0], 1000 * FACTOR, rtol=1e-6)
    along_0 = np.array([1000, 900, 700, 400, 100, 20, 0]) * FACTOR
    np.testing.assert_allclose(table[:91:15, 0], along_0, rtol=1e-6)
    np.testing.assert_allclose(table[:91:15, 90], [1350, 1269, 1053, 702, 243, 54, 0], rtol=1e-6)
    assert table[30, 45] == pytest.approx(740 * FACTOR)
    assert table[40, 0] == pytest.approx((700 / 3 + 400 * 2 / 3) * FACTOR)
    assert table[15, 10] == pytest.approx((900 + 10 * 10 / 22.5) * FACTOR)
    assert (table[91:] == 0.0).all()


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("\n", "\r"),
        lambda text: "IESNA91\n" + text.partition("\n")[2],
        lambda text: text[text.index("TILT") :],
        lambda text: text.replace("TILT=NONE", "TILT= NONE  "),
        lambda text: text.rstrip("\n"),
        lambda text: text.replace(" 1 1.5 ", " 1 1.5e0 "),
    ],
    ids=["crlf", "cr", "1991", "1986", "spaces", "no end of line", "exponent"],
)
def test_forms_of_the_same_file(tmp_path, change):
    truth = read_ies(write(tmp_path, REAL))
    np.testing.assert_array_equal(read_ies(write(tmp_path, change(REAL))), truth)


@pytest.mark.parametrize(
    ("azimuths", "level", "same_as"),
    [
        ([0], [7], lambda degrees: 0.0 * degrees),
        ([0, 30, 90], [1, 4, 2], lambda a: np.minimum(a % 180.0, -a % 180.0)),
        ([0, 90, 120, 180], [1, 4, 2, 9], lambda a: np.minimum(a, 360.0 - a)),
        ([0, 100, 200, 360], [3, 1, 5, 3], lambda a: a),
        ([90, 120, 180, 270], [3, 1, 5, 2], lambda a: np.where(a < 90, 180 - a, (180 - a) % 360)),
    ],
    ids=["0", "0-90", "0-180", "0-360", "90-270"],
)
def test_azimuths_follow_by_symmetry(tmp_path, azimuths, level, same_as):
    """`same_as` says which azimuth of the file stands for one that it may lack."""
    text = make(azimuths, [(value, value, 2 * value) for value in level])
    table = read_ies(write(tmp_path, text))
    degrees = np.arange(361.0)
    is_listed = (degrees >= azimuths[0]) & (degrees <= azimuths[-1])
    listed_as = np.where(is_listed, degrees, same_as(degrees))
    truth = np.interp(listed_as, azimuths, level)
    np.testing.assert_allclose(table[90], truth, rtol=1e-6)
    np.testing.assert_allclose(table[180], 2.0 * truth, rtol=1e-6)
    np.testing.assert_array_equal(table[:, 0], table[:, 360])


BAD = {
    "no TILT": ("TILT=NONE\n", "", "no TILT line: give an IES file"),
    "tilt": ("TILT=NONE", "TILT=INCLUDE", r":2: TILT=INCLUDE: give an IES file with TILT=NONE"),
    "tilt file": ("TILT=NONE", "TILT=a.tlt", r":2: TILT=a.tlt: give"),
    "truncated head": ("\n1 1 100\n0 45 90\n0\n100 80 10", "", "ends before its angles; export"),
    "truncated": ("80 10\n", "80\n", "has 19 numbers where 3 × 1 angles need 20; export"),
    "too many": ("80 10\n", "80 10 5\n", "has 21 numbers where 3 × 1 angles need 20"),
    "fewer angles": ("1 3 1 1", "1 2 1 1", "has 20 numbers where 2 × 1 angles need 18"),
    "more angles": ("1 3 1 1", "1 3 2 1", "has 20 numbers where 3 × 2 angles need 24"),
    "no angles": ("1 3 1 1", "1 3 0 1", "has 20 numbers where 3 × 0"),
    "less than none": ("1 3 1 1", "1 -3 1 1", "has 20 numbers where -3 × 1"),
    "far too many": ("1 3 1 1", "1 3e9 3e9 1", "has 20 numbers where 3000000000 × 3000000000"),
    "type B": ("3 1 1 2", "3 1 2 2", r"photometry of type 2: give a file of type C \(1\)"),
    "type A": ("3 1 1 2", "3 1 3 2", "photometry of type 3: give"),
    "word": ("80 10", "80 ten", "'ten' is not a number; export it again"),
    "long word": ("80 10", "80 " + "x" * 9999, r"'x{60}\.\.\.' is not a number"),
    "count is no number": ("1 3 1 1", "1 nan 1 1", "'nan' is not a number"),
    "count is infinite": ("1 3 1 1", "1 inf 1 1", "'inf' is not a number"),
    "negative": ("80 10", "-80 10", "intensities that are negative or not finite; export"),
    "negative multiplier": ("1000 1 3", "1000 -1 3", "intensities that are negative"),
    "too bright": ("100 80", "1e39 80", "negative or not finite"),
    "too bright a factor": ("1000 1 3", "1000 1e307 3", "negative or not finite"),
    "dark": ("100 80 10", "0 0 0", "has no intensity in any direction; export it again"),
    "falling": ("0 45 90", "0 90 45", "has angles that do not increase; export it again"),
    "the same twice": ("0 45 90", "0 45 45", "has angles that do not increase"),
    "polar range": ("0 45 90", "-90 0 90", "polar angles of -90 to 90; give them within 0 to 180"),
    "azimuth range": ("90\n0\n", "90\n45\n", "has azimuths of 45 to 45; give 0 alone, 0 to 90"),
}


@pytest.mark.parametrize(("old", "new", "message"), BAD.values(), ids=BAD)
def test_bad_files_are_refused_in_one_line(tmp_path, old, new, message):
    """It names the file and a remedy, and stays short."""
    assert old in SMALL
    path = write(tmp_path, SMALL.replace(old, new, 1))
    with pytest.raises(InputError, match=message) as caught:
        read_ies(path)
    place, _, problem = str(caught.value).partition("lamp.ies")
    assert place == f"{tmp_path}/"
    assert "\n" not in problem
    assert len(problem) < 200
    assert any(remedy in problem for remedy in ("export it again", "give "))


@pytest.mark.parametrize("azimuths", [(0, 45), (0, 270), (0, 359), (10, 90), (90, 180)])
def test_azimuths_that_leave_directions_untold_are_refused(tmp_path, azimuths):
    path = write(tmp_path, make(azimuths, [(1, 1, 1)] * 2))
    with pytest.raises(InputError, match=rf"lamp\.ies: has azimuths of {azimuths[0]} to "):
        read_ies(path)


@pytest.mark.parametrize("name", ["none.ies", "."])
def test_files_that_cannot_be_read(tmp_path, name):
    with pytest.raises(InputError, match=r"^[^\n]*: cannot be read \([^\n]+\)$"):
        read_ies(tmp_path / name)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (np.ones(3), r"numbers \(V, H\), 2 × 2 at least, not \(3,\)"),
        (np.ones((1, 5)), r"2 × 2 at least, not \(1, 5\)"),
        ([["bright"]], "must be numbers"),
        (None, "must be numbers"),
        (-np.ones((3, 3)), "negative or not finite"),
        (np.full((3, 3), np.nan), "negative or not finite"),
        (np.full((3, 3), 1e39), "negative or not finite"),
        (np.zeros((3, 3)), "0 in all directions"),
    ],
)
def test_bad_tables_are_refused(table, message):
    with pytest.raises(InputError, match=message):
        as_table(table)


def test_a_bad_file_of_a_scene_is_named_with_its_line(tmp_path):
    floor = pm.Mesh([[-1, 0, 1], [1, 0, 1], [1, 0, -1]], [[0, 1, 2]])
    pm.save_scene(pm.Scene([floor]), tmp_path / "room.obj")
    write(tmp_path, SMALL.replace("80", "-80"))
    toml = '[[light]]\ntype = "photometric"\nposition = [0, 1, 0]\nfile = "lamp.ies"\n'
    (tmp_path / "room.toml").write_text(toml)
    with pytest.raises(InputError, match=r"room\.toml:4: \[\[light\]\] file: .*lamp\.ies: has"):
        pm.load_scene(tmp_path / "room.obj")


@pytest.mark.parametrize("shape", [(181, 361), (7, 9), (2, 2), (19, 5)])
def test_what_is_written_is_read_again(tmp_path, shape):
    table = np.random.default_rng(3).uniform(0.0, 500.0, shape)
    table[:, -1] = table[:, 0]
    save_ies(table, tmp_path / "a.ies")
    np.testing.assert_allclose(as_table(tmp_path / "a.ies"), as_table(table), rtol=2e-6)


def test_relative_intensities_have_a_mean_of_1():
    """Over all directions, by an even grid of cosines and azimuths."""
    table = as_table(np.random.default_rng(5).uniform(0.0, 3.0, (13, 25)))
    polar = np.degrees(np.arccos((np.arange(4000) + 0.5) / 2000.0 - 1.0))
    rows = np.stack([np.interp(polar, np.arange(181), column) for column in table.T[:-1]])
    assert rows.mean() == pytest.approx(1.0, rel=2e-4)
    np.testing.assert_array_equal(as_table(np.full((4, 5), 7.0)), np.ones((181, 361), np.float32))
