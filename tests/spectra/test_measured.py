from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from photonmap.errors import InputError
from photonmap.spectra.measured import read_illuminants, read_munsell

DATA = Path(__file__).parents[3] / "shared" / "data"
GRID = np.arange(400.0, 701.0, 10.0)
CHIPS = 0.5 + 0.1 * np.arange(4)[:, None] * np.sin(GRID / 80)
LABELS = ["2.5R9/2", "10PB 6/10", "N 9/", "10bV50C01.NM5"]
NAMES = ("2.5R 9/2", "10PB 6/10", "N 9/", "10bV50C01.NM5")
LIGHTS = np.linspace(0.0, 3.0, 303).reshape(3, 101)


def needs(name):
    return pytest.mark.skipif(not (DATA / name).exists(), reason=f"{name} is not at hand")


@pytest.fixture
def mat(tmp_path):
    def mat(arrays, name="munsell400_700_10.mat"):
        savemat(tmp_path / name, arrays)
        return read_munsell(tmp_path / name)

    return mat


@pytest.fixture
def npz(tmp_path):
    def npz(read, **arrays):
        np.savez(tmp_path / "a.npz", **arrays)
        return read(tmp_path / "a.npz")

    return npz


@pytest.fixture
def text(tmp_path):
    def text(read, content, name):
        (tmp_path / name).write_text(content)
        return read(tmp_path / name)

    return text


def rows(array, between="\n"):
    """Write an array one number a line, or one row a line with its numbers apart."""
    return "\n".join(between.join(map(repr, row)) for row in np.asarray(array).tolist()) + "\n"


def assert_chips(curves, names=("1", "2", "3", "4")):
    assert curves.names == names
    np.testing.assert_array_equal(curves.wavelengths, GRID)
    np.testing.assert_array_equal(curves.values, CHIPS)


@needs("munsell_matt_1269.npz")
def test_all_matt_chips():
    curves = read_munsell(DATA / "munsell_matt_1269.npz")
    assert curves.values.shape == (1269, 421)
    assert (curves.wavelengths[0], curves.wavelengths[-1]) == (380, 800)
    assert curves.names[0] == "2.5R 9/2"
    assert curves.values[0, 0] == 0.1333
    assert curves.values[-1, -1] == 0.7029
    assert curves["2.5R 5/2"](np.array([380.0, 381.0])).tolist() == [0.1056, 0.1141]


@needs("sfu_illuminants.npz")
def test_all_illuminants():
    curves = read_illuminants(DATA / "sfu_illuminants.npz")
    assert curves.values.shape == (200, 101)
    assert (curves.wavelengths[0], curves.wavelengths[-1]) == (380, 780)
    assert curves.names[101:104] == ("measured/102", "test11/1", "test11/2")
    assert curves.values[0, 0] == np.float32(0.0003936)


def test_munsell_npz(npz):
    assert_chips(npz(read_munsell, R=CHIPS, wavelength=GRID, label=LABELS), NAMES)
    assert_chips(npz(read_munsell, R=CHIPS, wavelength=GRID.astype(int)))


@pytest.mark.parametrize(
    "labels", [LABELS, np.array(LABELS, object), np.array(LABELS, object)[:, None]]
)
def test_munsell_mat(mat, labels):
    assert_chips(mat({"munsell": CHIPS.T, "S": labels}), NAMES)


@pytest.mark.parametrize(
    ("name", "count", "first", "step"),
    [
        ("munsell380_800_1.mat", 421, 380, 1),
        ("munsell400_700_5.MAT", 61, 400, 5),
        ("munsell380_780_1_glossy.mat", 401, 380, 1),
        ("chips_420_500_20_x.mat", 5, 420, 20),
        ("old.mat", 421, 380, 1),
        ("old.mat", 61, 400, 5),
        ("old.mat", 31, 400, 10),
        ("old.mat", 401, 380, 1),
    ],
)
@pytest.mark.parametrize("transposed", [False, True])
def test_munsell_grids(mat, name, count, first, step, transposed):
    chips = np.linspace(0, 1, 3 * count).reshape(3, count)
    curves = mat({"X": chips if transposed else chips.T}, name)
    np.testing.assert_array_equal(curves.wavelengths, first + step * np.arange(count))
    np.testing.assert_array_equal(curves.values, chips)
    assert curves.names == ("1", "2", "3")


@pytest.mark.parametrize("name", ["munsell400_700_10.asc", "old.asc"])
@pytest.mark.parametrize(
    "content",
    [
        rows(CHIPS),
        rows(CHIPS.T),
        rows(CHIPS, "\t"),
        rows(CHIPS.T, "  "),
        "# measured\n\n" + rows(CHIPS.reshape(-1, 2), " "),
        " ".join(map(repr, CHIPS.ravel().tolist())),
    ],
    ids=["numbers", "numbers across", "rows", "columns", "wrapped", "one line"],
)
def test_munsell_asc(text, name, content):
    assert_chips(text(read_munsell, content, name))


@pytest.mark.parametrize("turn", [np.asarray, np.transpose])
def test_lines_tell_rough_chips(text, turn):
    chips = np.random.default_rng(1).random((9, 31)) * np.linspace(0, 1, 31)
    np.testing.assert_array_equal(text(read_munsell, rows(turn(chips), " "), "a.asc").values, chips)


@pytest.mark.parametrize("turn", [np.asarray, np.transpose])
def test_as_many_chips_as_wavelengths(mat, turn):
    chips = np.tile(CHIPS, (8, 1))[:31] * np.linspace(1, 0.1, 31)[::-1][[0, 30] * 15 + [15], None]
    np.testing.assert_array_equal(mat({"munsell": turn(chips)}).values, chips)


def test_munsell_table(text):
    curves = text(read_munsell, "nm;5YR8/4;x\n400;0,1;0,2\n500;0,3;0,4\n", "chips.csv")
    assert curves.names == ("5YR 8/4", "x")
    with pytest.raises(InputError, match=r"chips\.csv:2: reflectance is 12 .*divide percent"):
        text(read_munsell, "400 0.5\n500 12\n510 13\n", "chips.csv")


def test_munsell_folder(mat, tmp_path):
    (tmp_path / "README.txt").write_text("x")
    with pytest.raises(InputError, match=r"holds no munsell\*\.mat"):
        read_munsell(tmp_path)
    mat({"munsell": CHIPS.T})
    assert_chips(read_munsell(tmp_path))
    mat({"munsell": CHIPS.T}, "Munsell400_700_10.MAT")
    with pytest.raises(InputError, match=r"'munsell400_700_10\.mat'; name one file"):
        read_munsell(tmp_path)


def changed(row, column, value):
    chips = CHIPS.copy()
    chips[row, column] = value
    return chips


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"R": changed(1, 3, 1.2)}, r"'2': reflectance is 1\.2 at 430 nm; .* 0 and 1$"),
        ({"R": changed(1, 3, -0.1)}, r"'2': reflectance is -0\.1 at 430 nm"),
        ({"R": changed(3, 0, np.nan)}, r"'4': reflectance is nan at 400 nm"),
        ({"R": 100 * CHIPS}, r"'1': reflectance is 50 at 400 nm; .*divide percent by 100"),
        ({"wavelength": GRID[::-1]}, r"wavelengths must increase, but 690 follows 700; sort"),
        ({"wavelength": np.full(31, np.nan)}, r"must be finite"),
        ({"wavelength": GRID / 1000}, r"look like micrometres: multiply by 1000"),
        ({"wavelength": GRID[:-1]}, r"'R' is 4 x 31, not one row of 30 values"),
        ({"wavelength": GRID[:0], "R": CHIPS[:, :0]}, r"at least 2 samples"),
        ({"wavelength": np.array(["x"])}, r"'wavelength' is not a 1-dimensional array of numbers"),
        ({"R": CHIPS[0]}, r"'R' is not a 2-dimensional array of numbers"),
        ({"R": CHIPS[:0]}, r"at least one curve"),
        ({"label": LABELS[:3]}, r"has 3 labels for 4 chips"),
    ],
)
def test_malformed_munsell_npz(npz, arrays, message):
    with pytest.raises(InputError, match=rf"a\.npz: .*{message}") as caught:
        npz(read_munsell, **{"R": CHIPS, "wavelength": GRID} | arrays)
    assert "\n" not in str(caught.value)


def test_infinite_chip(mat):
    with pytest.raises(InputError, match=r"_10\.mat: '3': reflectance is inf at 400 nm"):
        mat({"munsell": np.where(np.arange(4) == 2, np.inf, CHIPS.T)})


def test_unknown_arrays(mat, npz):
    with pytest.raises(InputError, match=r"holds no array 'R', only 'wavelength', 'x'"):
        npz(read_munsell, wavelength=GRID, x=CHIPS)
    with pytest.raises(InputError, match=r"holds no array 'munsell', 'X', only 'R'; rename it"):
        mat({"R": CHIPS})


@pytest.mark.parametrize("shape", [(31, 421), (5, 7), (0, 0)])
def test_unknown_wavelengths(mat, shape):
    with pytest.raises(
        InputError, match=r"do not determine .*; name it by .* munsell380_800_1\.mat"
    ):
        mat({"munsell": np.ones(shape)}, "chips.mat")


def test_wavelengths_do_not_fit(mat, text):
    with pytest.raises(InputError, match=r"its 31 x 4 numbers do not fit 380_800_1 in its name"):
        mat({"munsell": CHIPS.T}, "munsell380_800_1.mat")
    with pytest.raises(InputError, match=r"its 0 x 0 numbers do not fit 800_380_1"):
        mat({"munsell": np.ones((0, 0))}, "munsell800_380_1.mat")
    with pytest.raises(InputError, match=r"its 40 numbers do not fit 400_700_10"):
        text(read_munsell, rows(np.ones((40, 1))), "munsell400_700_10.asc")
    with pytest.raises(InputError, match=r"its 13051 numbers do not determine"):
        text(read_munsell, "0.5 " * 13050 + "\n0.5", "chips.asc")


@pytest.mark.parametrize("suffix", [".mat", ".npz", ".asc", ".csv"])
def test_damaged_munsell(tmp_path, suffix):
    path = tmp_path / f"munsell400_700_10{suffix}"
    with pytest.raises(InputError, match="cannot be read"):
        read_munsell(path)
    path.touch()
    with pytest.raises(InputError, match="is empty"):
        read_munsell(path)
    path.write_bytes(b"0.5\nPK\x03\x04" + bytes(200))
    with pytest.raises(InputError, match=r"cannot be read as|:2: is not a text file"):
        read_munsell(path)


def test_illuminants_npz(npz):
    grid = np.linspace(380, 780, 101).astype(int)
    curves = npz(read_illuminants, wavelength=grid, a=LIGHTS[:1], b=LIGHTS[1:], label=["x"])
    assert curves.names == ("a/1", "b/1", "b/2")
    np.testing.assert_array_equal(curves.values, LIGHTS)
    with pytest.raises(InputError, match=r"a\.npz: 'b' is 3 x 100, not one row of 101"):
        npz(read_illuminants, wavelength=grid, a=LIGHTS, b=LIGHTS[:, 1:])
    with pytest.raises(InputError, match=r"a\.npz: holds no spectra, only 'wavelength', 'n'"):
        npz(read_illuminants, wavelength=grid, n=np.ones(3))
    with pytest.raises(InputError, match=r"a\.npz: 'a/2': light is inf at 384 nm"):
        npz(read_illuminants, wavelength=grid, a=np.where(LIGHTS[1, 1] == LIGHTS, np.inf, LIGHTS))
    with pytest.raises(InputError, match=r"a\.npz: .*at least 2 samples"):
        npz(read_illuminants, wavelength=grid[:0], a=LIGHTS[:, :0])


ONE_A_LINE = [rows(light[:, None]) for light in LIGHTS]
BY_NUMBER = ("1", "2", "3")


@pytest.mark.parametrize(
    ("content", "names"),
    [
        ("\n".join(ONE_A_LINE), BY_NUMBER),
        (rows(LIGHTS, "\t"), BY_NUMBER),
        ("# Sources\n#\n#! t=i n=101 o=380.0 s=4.0\n" + "\n#\n".join(ONE_A_LINE), BY_NUMBER),
        ("".join(f"#\n# lamp {i}\n{light}" for i, light in enumerate(ONE_A_LINE)),
         ("lamp 0", "lamp 1", "lamp 2")),
        ("".join(f"#! t=i n=101\n{light}" for light in ONE_A_LINE), BY_NUMBER),
        ("# all\n" + "".join(f"# lamp\n{light}" for light in ONE_A_LINE), BY_NUMBER),
        ("# a\n" + "".join(ONE_A_LINE) + "# b\n# c\n", BY_NUMBER),
        ("# a\n" + "".join(ONE_A_LINE).replace("\n", "\n# b\n", 2), BY_NUMBER),
    ],
    ids=["lines", "rows", "originals", "named", "directives", "head", "behind", "inside"],
)  # fmt: skip
def test_illuminants_text(text, content, names):
    curves = text(read_illuminants, content, "a.illum")
    assert curves.names == names
    np.testing.assert_array_equal(curves.wavelengths, np.arange(380, 781, 4))
    np.testing.assert_array_equal(curves.values, LIGHTS)


def test_illuminants_table(text):
    curves = text(read_illuminants, "nm,lamp\n400,1e9\n500,-999\n", "a.csv")
    assert curves.names == ("lamp",)
    assert curves.values.tolist() == [[1e9, 0]]


def test_illuminants_folder(text, tmp_path):
    with pytest.raises(InputError, match=r"holds no file with \.illum"):
        read_illuminants(tmp_path)
    text(read_illuminants, rows(LIGHTS[2:], " "), "b.dat")
    text(read_illuminants, "# lamp\n" + rows(LIGHTS[:1], " "), "a.illum")
    text(read_illuminants, rows(LIGHTS[1:2], " "), "a.TXT")
    (tmp_path / "c.gz").touch()
    curves = read_illuminants(tmp_path)
    assert curves.names == ("a/1", "a/lamp", "b/1")
    np.testing.assert_array_equal(curves.values, LIGHTS[[1, 0, 2]])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (rows(LIGHTS[:, 1:], " "), r"a\.illum: holds 300 numbers; a spectrum has 101"),
        (rows(np.ones((101, 2)), " "), r"a\.illum:1: has 2 numbers; .*name a table \.csv"),
        ("# none\n", r"a\.illum: holds no numbers"),
        ("# x\n1\nO\n", r"a\.illum:3: 'O' is not a number"),
        ("1,2\n", r"a\.illum:1: '1,2' is not a number; write numbers separated by spaces"),
        ("1\n\0\n", r"a\.illum:2: is not a text file"),
        ("", r"a\.illum: is empty"),
        (
            "#\n" + "1\n" * 100 + "-1\n",
            r"a\.illum:102: '1': light is -1 at 780 nm; give finite values",
        ),
        ("1\n" * 101 + "-1 " * 101, r"a\.illum:102: '2': light is -1 at 380 nm"),
        ("1\n" * 202 + "nan\n" + "1\n" * 100, r"a\.illum:203: '3': light is nan at 380 nm"),
    ],
)
def test_malformed_illuminants(text, content, message):
    with pytest.raises(InputError, match=message) as caught:
        text(read_illuminants, content, "a.illum")
    assert "\n" not in str(caught.value)


def test_noise_below_zero(text):
    content = "2\n" * 100 + "{}\n"
    assert text(read_illuminants, content.format(-1.9e-6), "a.txt").values[0, -1] == 0
    with pytest.raises(InputError, match=r"a\.txt:101: '1': light is -2\.1e-06 at 780 nm"):
        text(read_illuminants, content.format(-2.1e-6), "a.txt")
