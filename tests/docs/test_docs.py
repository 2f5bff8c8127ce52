"""What the docs say is true: their Python runs, their quotations and links exist, and so do the
flags that they name."""

import re
from importlib.util import find_spec

import numpy as np
import pytest
from helpers.layered_sets import write_set
from helpers.source import ROOT

import photonmap as pm
from photonmap.commands import main
from photonmap.evaluate import intervals
from photonmap.evaluate.bench.measure import METRICS
from photonmap.evaluate.methods.method import BUILT_IN

PAGES = sorted(
    path for folder in (ROOT, ROOT / "docs", ROOT / "kernels") for path in folder.glob("*.md")
)
BLOCK = re.compile(
    r"^(?:<!-- from (?P<source>\S+) -->\n)?```(?P<language>\w*)\n(?P<text>.*?)^```", re.M | re.S
)
ELSEWHERE = {"--background", "--bounces", "--frame", "--from", "--python", "--repository", "--rm"}
"""Flags of examples that do not exist, and of other programs"""

each_page = pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)


def blocks(page, language="python", quoted=False):
    """Yield (first line, text, source) of a page's blocks of code."""
    text = page.read_text(encoding="utf-8")
    for found in BLOCK.finditer(text):
        if found["language"] == language and bool(found["source"]) == quoted:
            yield text.count("\n", 0, found.start("text")), found["text"], found["source"]


def run_page(page, namespace=None):
    """Run the Python of a page from top to bottom, in the current folder; return its names."""
    names = {} if namespace is None else dict(namespace)
    for line, text, _ in blocks(page):
        exec(compile("\n" * line + text, page, "exec"), names)
    return names


def docs(name):
    return ROOT / "docs" / name


@each_page
def test_quoted_code_is_in_its_file(page):
    for line, text, source in blocks(page, quoted=True):
        rest = (ROOT / source).read_text(encoding="utf-8")
        for part in re.split(r"^\.\.\.\n", text, flags=re.M):
            _, found, rest = rest.partition(part)
            assert found, f"{page.name}:{line + 1}: {source} does not say, in this order:\n{part}"


@each_page
def test_python_compiles(page):
    for line, text, _ in blocks(page):
        compile("\n" * line + text, page, "exec")


@each_page
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(\s*([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if "://" in target:
            continue
        file, _, heading = target.partition("#")
        aim = (page.parent / file).resolve() if file else page
        assert aim.exists(), f"{page.name} links to {target}"
        if heading and aim.suffix == ".md":
            assert heading in anchors(aim), f"{page.name} links to {target}"


def anchors(page):
    """Return the anchors of a page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@each_page
def test_files_that_are_named_exist(page):
    """Paths in backticks from the root of the repository, as in `photonmap/render.py`."""
    text = page.read_text(encoding="utf-8")
    for name in re.findall(r"`((?:photonmap|kernels|tests|tools|examples)/[\w/.]+)`", text):
        assert (ROOT / name).exists(), f"{page.name} names {name}"


@each_page
def test_flags_that_are_named_exist(page):
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", page.read_text(encoding="utf-8")))
    code = "\n".join(path.read_text("utf-8") for path in (ROOT / "benchmarks").rglob("*.py"))
    unknown = {flag for flag in named - known_flags() - ELSEWHERE if f'"{flag}"' not in code}
    assert not unknown


def known_flags():
    """Return the flags of all commands."""
    found = set()
    for command in ("", *main.COMMANDS):
        stack = [main.parser_of(command or main.DEFAULT)]
        while stack:
            for action in stack.pop()._actions:
                found.update(action.option_strings)
                if isinstance(action.choices, dict):
                    stack += action.choices.values()
    return found


@pytest.fixture(scope="module")
def extending(tmp_path_factory):
    """The names that the snippets of docs/extending.md leave behind."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("extending"))
        yield run_page(docs("extending.md"))


def test_rough_diffuse_surfaces(extending):
    rough = extending["rough"]
    parts = rough.emission + extending["lambertian_part"] + rough.residual
    np.testing.assert_allclose(parts, rough.radiance, atol=1e-5)
    assert rough.residual.min() < 0.0 < rough.residual.max()


def test_photometric_light(extending):
    """Its intensity falls from straight down to 0 at 90 degrees: on the back wall, too."""
    lit = extending["lit"].direct.mean(axis=2)
    assert not lit[:6, 16].any(), "the ceiling"
    assert lit[14, 16] > lit[11, 16] > lit[9, 16] > 0.0


def test_orthographic_camera(extending):
    depth = extending["parallel"].depth
    wall = depth[depth > depth.max() - 1e-3]
    assert len(wall) > 100
    assert np.ptp(wall) < 1e-5


def test_integrator(extending):
    first, second = extending["first"], extending["second"]
    np.testing.assert_array_equal(first, extending["again"])
    assert (first != second).any()
    assert extending["reference"].record["arguments"]["method"] == "path"


def test_buffer_and_reader(extending):
    albedo = extending["chosen"].specular_reflectance
    np.testing.assert_allclose(np.unique(albedo), [0.0, 0.04, 0.9], rtol=1e-6)
    shape = extending["shape"]
    assert shape.coverage.mean() > 0.1
    assert len(extending["tetrahedron"].meshes[0].faces) == 4


@pytest.mark.parametrize("page", ["guide.md", "spectra.md"])
def test_scene_files_load(extending, tmp_path, page):
    """Scenes in TOML, beside a mesh of as many triangles as there are materials in them."""
    (tmp_path / "wall.csv").write_text("400,0.2\n700,0.4\n")
    ies = extending["Path"]("downlight.ies").read_text()
    for line, text, _ in blocks(docs(page), "toml"):
        names = re.findall(r"^\[material\.(\w+)\]", text, re.M) or ["grey"]
        objects = dict(re.findall(r"^\[object\.(\w+)\].*\nmaterial = \"(\w+)\"", text, re.M))
        faces = "".join(f"usemtl {name}\nf 1 2 3\n" for name in names)
        faces += "".join(f"o {name}\nusemtl {names[0]}\nf 1 2 3\n" for name in objects)
        (tmp_path / "room.mtl").write_text("".join(f"newmtl {name}\n" for name in names))
        (tmp_path / "room.obj").write_text(f"mtllib room.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}")
        (tmp_path / "downlight.ies").write_text(ies)
        (tmp_path / "room.toml").write_text(text)
        scene = pm.load_scene(tmp_path / "room.toml")
        areas = ["area"] * text.count('type = "area"')
        wanted = sorted([*names, *objects.values(), *areas])
        assert sorted(mesh.material.name for mesh in scene.meshes) == wanted, line
        assert len(scene.lights) == text.count("[[light]]") - len(areas)


def test_snippets_of_spectra(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run_page(docs("spectra.md"), {"pm": pm})


@pytest.fixture
def data_set(tmp_path, monkeypatch):
    """A data set OUT and predictions my_network in the current folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "OUT").mkdir()
    (tmp_path / "my_network").mkdir()
    for name, layers in write_set(tmp_path / "OUT", scenes=(0,)).items():
        np.savez(tmp_path / "my_network" / f"{name}.npz", shading=layers.shading[..., :3])
    return tmp_path


def test_snippets_of_evaluation(data_set, capsys):
    names = run_page(docs("evaluation.md"))
    assert [method.name for method in names["found"].methods] == ["square-root", "constant-shading"]
    assert capsys.readouterr().out.startswith("square-root lmse reflectance mean 0.")


def test_commands_of_evaluation(data_set, monkeypatch):
    monkeypatch.setattr(intervals, "RESAMPLES", 199)
    text = docs("evaluation.md").read_text(encoding="utf-8")
    commands = re.findall(r"^    python -m photonmap (evaluate OUT --.*)$", text, re.M)
    assert len(commands) == 3
    for command in commands:
        assert main.main([*command.split(), "--draws", "1", "--quiet"]) == 0
    for folder in ("OUT-evaluation", "my_network-report"):
        for name in ("report.html", "summary.csv", "scores.csv", "table.tex"):
            assert (data_set / folder / name).is_file()
            assert f"`{name}`" in text


def test_tables_of_evaluation():
    """Every metric and method is there, under its name, and metrics of the right layers."""
    text = docs("evaluation.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([a-z-]+)` \| ([a-z, ]+) \| ", text, re.M)
    assert dict(rows) == {name: ", ".join(metric.layers) for name, metric in METRICS.items()}
    for name in BUILT_IN:
        assert f"`{name}`" in text.partition("## Methods")[2].partition("## Predictions")[0]


def test_snippet_of_the_readme(tmp_path, monkeypatch):
    """As written, but small."""
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    (line, text, _), *others = blocks(ROOT / "README.md")
    assert not others
    small = text.replace("size=(256, 256), error=0.02", "size=(24, 24), passes=2")
    assert small != text, line
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(small, names)
    assert names["result"].radiance.shape == (24, 24, 6)


def test_snippet_of_the_guide(tmp_path, monkeypatch):
    """As written, but small."""
    pytest.importorskip("xarray")
    pytest.importorskip("matplotlib").use("Agg")
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    pytest.importorskip("h5netcdf")
    text = "\n".join(text for _, text, _ in blocks(docs("guide.md")))
    for written, small in (("size=64, passes=16", "size=8, passes=2"), ("(32, 40, ", "(3, 4, ")):
        assert written in text
        text = text.replace(written, small)
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(text, names)
    assert names["data"].sizes == {
        "y": 8,
        "x": 8,
        "band": 31,
        "axis": 3,
        "block_y": 1,
        "block_x": 1,
    }
    np.testing.assert_allclose(names["result"].wavelengths, np.arange(400, 701, 10))
    room = names["room"]
    light = sum(part["direct"] + part["indirect"] for part in room.per_light.values())
    np.testing.assert_allclose(room.emission + light, room.radiance, rtol=1e-5, atol=1e-7)
    assert names["relit"].radiance.shape == room.radiance.shape
    assert (tmp_path / "evening.exr").exists()


@pytest.mark.filterwarnings("ignore:luminance by these bands")
def test_snippets_of_data_sets(tmp_path, monkeypatch):
    """As written, but small."""
    (tmp_path / "OUT").mkdir()
    write_set(tmp_path / "OUT", scenes=(0, 1, 14), error=0.01)  # of each split
    for file in (ROOT / "scenes").glob("cornell_box.*"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
        (tmp_path / f"room{file.suffix}").write_bytes(file.read_bytes())
    monkeypatch.chdir(tmp_path)
    names = {}
    for _, text, _ in blocks(docs("dataset.md")):
        if find_spec("torch") is None:
            text = re.sub(r"^tensors = .*\n", "", text, flags=re.M)
        for written in ("size=(640, 480), error=0.02", "error=0.05"):
            text = text.replace(written, "size=(8, 6), passes=2")
        exec(text, names)
    assert names["result"].per_light
    assert (tmp_path / "study.exr").exists()
    assert names["scene"].name == "room"
    if "tensors" in names:
        assert names["tensors"][0]["radiance"].shape[0] == 3
        assert names["tensors"][0]["valid"].shape[0] == 1


def test_sources_of_colours(tmp_path, monkeypatch):
    """Each spelling of the table in docs/spectra.md is read as what its columns say."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "FILE.csv").write_text("400,0.2\n700,0.4\n")
    (tmp_path / "INDEX.csv").write_text("400,0.2,3\n700,0.4,4\n")
    table = docs("spectra.md").read_text("utf-8").partition("| source |")[2].partition("\n\n")[0]
    rows = [row.split("|")[1:4] for row in table.splitlines() if row.startswith("| `")]
    assert len(rows) > 7
    for spellings, *columns in rows:
        for text in set(re.findall(r"`(.+?)`", spellings)) - {"sfu:NAME"}:
            for read, column in zip((pm.reflectance, pm.emission), columns, strict=True):
                if column.strip() != "–":
                    assert read(text) == read(f"{text} 1"), text


def test_snippet_of_photos(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = run_page(docs("sensor.md"))
    np.testing.assert_array_equal(names["again"].raw, names["photo"].raw)
