"""The list of buffers: what follows from a row, and a buffer that touches nothing else."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

import photonmap as pm
from photonmap.buffers import (
    ADDED,
    BUFFERS,
    BY_NAME,
    DEFAULT,
    RENDERED,
    TABLE,
    as_markdown,
    check_buffers,
    in_order,
    is_omitted,
    names_where,
    split_name,
    with_defaults,
)
from photonmap.compile.scene_arrays import compile_scene
from photonmap.dataset.files.derived_buffers import with_derived
from photonmap.dataset.files.lean import rendered_for
from photonmap.integrators import first_hits
from photonmap.integrators.memory_estimate import Work
from photonmap.kernels.film.moments import (
    GOAL_BUFFERS,
    FluorescenceMoments,
    Moments,
    SpecularMoments,
)
from photonmap.render import compile_and_plan
from photonmap.scene.surfaces.metallic import metallic_fraction, metallic_gloss
from photonmap.settings import Options, Settings
from photonmap.spectra.bands import Bands

DOCS = Path(__file__).parents[2] / "docs"
SETTINGS = {"bands": 3, "size": (16, 12), "passes": 2, "photons": 500}


def test_names_are_unique_and_rendered_ones_come_first():
    assert len(BY_NAME) == len(TABLE)
    assert [row.name for row in TABLE[: len(BUFFERS)]] == [*BUFFERS]
    assert set(DEFAULT) < set(BUFFERS)


def test_rows_agree_with_what_computes_them():
    assert names_where(is_goal=True) == GOAL_BUFFERS
    records = Moments, SpecularMoments, FluorescenceMoments
    arrays = {name for record in records for name in record._fields}
    for name in names_where(source="passes", pooling="mean", has_error=True):
        own = name.removesuffix("_unfiltered")
        assert {own, f"{own}_spread"} <= arrays
    assert set(names_where(source="first hit")) == set(first_hits._COMPUTE)
    for row in RENDERED:
        assert row.has_error or not (row.has_block_error or row.is_goal)


def test_shapes_types_and_units_are_those_of_a_render():
    result = pm.render(pm.scenes.cornell_balls(), buffers=BUFFERS, **SETTINGS)
    assert list(result.buffers) == [name for name in BUFFERS if name in result.buffers]
    for name, image in result.buffers.items():
        row = BY_NAME[name]
        channels = 3 if row.channels is None else len(row.channels)
        shape = (12, 16, channels) if row.is_banded or channels > 1 else (12, 16)
        assert (image.shape, image.dtype) == (shape, np.dtype(row.dtype))
        assert (name in result.errors) == row.has_error
        assert (name in result.block_errors) == row.has_block_error
        assert getattr(result, name) is image
        assert type(result).__dict__[name].__doc__ == row.summary


def test_data_sets_add_what_their_rows_say():
    result = with_derived(pm.render(pm.scenes.cornell_box(), **SETTINGS))
    added = [name for name in result.buffers if name not in BUFFERS]
    assert added == [row.name for row in ADDED]
    for row in ADDED:
        image = result.buffers[row.name]
        shape = (12, 16, 3) if row.is_banded else (12, 16)
        assert (image.shape, image.dtype) == (shape, np.dtype(row.dtype))


def test_order_and_groups():
    images = dict.fromkeys(("depth", "shading@sun", "radiance", "direct@sun", "direct"), 0)
    ordered = ["radiance", "direct", "depth", "direct@sun", "shading@sun"]
    assert list(in_order(images)) == ordered
    assert split_name("direct@sun") == ("direct", "sun")
    assert split_name("direct") == ("direct", "")


def test_runs_to_be_merged_keep_the_defaults():
    assert with_defaults(None) is None
    kept = with_defaults(["radiance", "specular_reflectance"])
    assert kept == [*DEFAULT, "specular_reflectance"]


def test_what_is_left_out_where_it_is_0_may_be_selected():
    result = pm.render(pm.scenes.cornell_box(), **SETTINGS)
    assert is_omitted("caustics@sun")
    assert not is_omitted("direct")
    assert not result.caustics.any()
    some = result.select(["radiance", "caustics"])
    assert list(some.buffers) == ["radiance"]
    assert not some.caustics.any()
    with pytest.raises(pm.InputError, match="'caustics' was not among the buffers"):
        result.select(["caustics"])


def test_what_was_not_selected_is_not_taken_for_0(tmp_path):
    result = pm.render(pm.scenes.cornell_box(), **SETTINGS)
    result.save(tmp_path / "some.exr", buffers="radiance,direct")
    for some in (result.select("radiance"), pm.load_result(tmp_path / "some.exr")):
        with pytest.raises(AttributeError, match="'residual' was not among the buffers"):
            _ = some.residual
    with pytest.raises(pm.InputError, match="a result of no buffers"):
        pm.Result({}, {}, result.bands, {})


def test_unknown_names_are_refused():
    with pytest.raises(pm.InputError, match="no buffer 'illuminat'"):
        check_buffers(["illuminat"])
    with pytest.raises(pm.InputError, match="no buffer was chosen"):
        check_buffers([])


@pytest.mark.parametrize(
    ("file", "marker", "rows"),
    [("guide.md", "buffers", RENDERED), ("dataset.md", "data set buffers", ADDED)],
)
def test_docs_have_the_generated_tables(file, marker, rows):
    text = (DOCS / file).read_text(encoding="utf-8")
    table = text.partition(f"<!-- {marker} -->\n")[2].partition(f"\n<!-- /{marker} -->")[0]
    assert table == as_markdown(rows), "run python tools/make_buffer_table.py"


COAT = pm.Material("coat", (0.5, 0.3, 0.2), mirror=(0.4, 0.2, 0.1))
GLASS = pm.Material.glass("glass", 1.5)


def scene_of(material):
    """A ball of some material that fills the middle of the picture, in front of a diffuse wall."""
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.5)
    wall = [[-4, -4, -1], [4, -4, -1], [4, 4, -1], [-4, 4, -1]]
    meshes = [
        pm.Mesh(ball.vertices, ball.faces, material, "ball"),
        pm.Mesh(wall, [[0, 1, 2], [0, 2, 3]], pm.Material("wall", 0.6), "wall"),
    ]
    return pm.Scene(meshes, [pm.PointLight((2.0, 2.0, 3.0), 5.0)], pm.Camera((0, 0, 3), (0, 0, 0)))


@pytest.fixture(
    scope="module", params=[COAT, GLASS, pm.Material("dull", 0.5)], ids=lambda m: m.name
)
def albedo_of(request):
    material = request.param
    result = pm.render(
        scene_of(material),
        **{**SETTINGS, "bands": "rgb"},
        buffers=[*DEFAULT, "specular_reflectance"],
    )
    return material, result


def test_specular_reflectance_is_that_of_the_material_at_the_centre(albedo_of):
    material, result = albedo_of
    expected = 0.04 if material is GLASS else np.array(material.mirror)
    on_ball = result.material_id == 1
    assert 0 < on_ball.sum() < on_ball.size
    albedo = result.specular_reflectance
    assert (albedo.shape, albedo.dtype) == ((12, 16, 3), np.float32)
    np.testing.assert_allclose(albedo[on_ball], np.broadcast_to(expected, (on_ball.sum(), 3)))
    np.testing.assert_array_equal(albedo[~on_ball], 0.0)


@pytest.mark.parametrize(
    ("material", "roughness", "fraction", "metallic"),
    [
        (pm.Material("coat", 0.2, mirror=0.61), 0.0, 0.2 / 0.81, 0.75),
        (GLASS, 0.0, 0.0, 0.0),
        (pm.Material("dull", 0.5), 1.0, 1.0, 0.0),
        (pm.Material.metal(glossy=0.9, roughness=0.4), 0.4, 0.0, 1.0),
        (pm.Material.metal(glossy=0.9, roughness=0.1), 0.1, 0.0, 1.0),
        (pm.Material.polished(), 0.0, 0.0, 1.0),
        (pm.Material.plastic(reflectance=1.0, ior=1.5, roughness=0.1), 0.1, None, 0.0),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_what_intrinsic_models_cannot_explain_is_told_apart(
    material, roughness, fraction, metallic
):
    """By roughness, metallic fraction, and by how much leaves the diffuse base.

    Of a white base all that enters leaves again, so its share is 1 - what the coat reflects: here
    of light from all around, 0.0918 for a smooth surface of index 1.5 by Fresnel's equations.
    """
    buffers = ["material_id", "roughness", "metallic", "diffuse_fraction"]
    result = pm.render(scene_of(material), **SETTINGS, buffers=buffers)
    on_ball = result.material_id == 1
    np.testing.assert_allclose(result.roughness[on_ball], roughness, atol=1e-6)
    np.testing.assert_array_equal(result.roughness[~on_ball], 1.0)
    np.testing.assert_allclose(result.metallic[on_ball], metallic, atol=1e-5)
    np.testing.assert_array_equal(result.metallic[~on_ball], 0.0)
    shares = result.diffuse_fraction[on_ball]
    if fraction is None:
        assert (np.abs(1.0 - shares - 0.0918) < 0.001).all()
    else:
        np.testing.assert_allclose(shares, fraction, atol=1e-6)


@pytest.mark.parametrize("metallic", [0.0, 0.1, 0.5, 0.95, 1.0])
@pytest.mark.parametrize("color", [(0.9, 0.6, 0.3), (0.5, 0.5, 0.5), (0.05, 0.04, 0.06)])
def test_metallic_fractions_are_those_that_were_read(color, metallic):
    gloss = metallic_gloss(color, metallic, 0.04, 0.3)
    base, lobe = (np.mean(np.broadcast_to(part, 3)) for part in (gloss.reflectance, gloss.glossy))
    found = metallic_fraction(np.array([base]), np.array([lobe]))
    assert found == pytest.approx([metallic], abs=1e-6)


def test_what_is_black_or_only_coated_is_no_metal():
    base, lobe = np.array([0.0, 0.0, 0.7, 1.0]), np.array([0.0, 0.04, 0.04, 0.02])
    np.testing.assert_array_equal(metallic_fraction(base, lobe), 0.0)


def test_specular_reflectance_is_kept_by_files(albedo_of, tmp_path):
    _, result = albedo_of
    result.save(tmp_path / "image.exr", ["radiance", "specular_reflectance"])
    loaded = pm.load_result(tmp_path / "image.exr")
    np.testing.assert_array_equal(loaded.specular_reflectance, result.specular_reflectance)
    assert "specular_reflectance" not in loaded.errors


def test_specular_reflectance_has_channels_without_unit(tmp_path):
    import OpenImageIO

    result = pm.render(scene_of(COAT), **SETTINGS, buffers=["specular_reflectance"])
    result.save(tmp_path / "image.exr")
    spec = OpenImageIO.ImageInput.open(str(tmp_path / "image.exr")).spec()
    assert spec.get_string_attribute("oiio:subimagename") == "specular_reflectance"
    assert all(name.startswith("T.") for name in spec.channelnames)
    assert "emissiveUnits" not in spec


def test_specular_reflectance_is_merged_and_estimated():
    buffers = [*DEFAULT, "specular_reflectance"]
    runs = [pm.render(scene_of(COAT), **SETTINGS, seed=s, buffers=buffers) for s in (1, 2)]
    merged = pm.merge(runs)
    np.testing.assert_array_equal(merged.specular_reflectance, runs[0].specular_reflectance)
    works = [Work(1000, 3, 500, 10, buffers=kept) for kept in (DEFAULT, buffers)]
    assert works[1].need.arrays - works[0].need.arrays == 1000 * 3 * 4


OF_GLOSS = ["specular_reflectance", "roughness", "metallic", "diffuse_fraction"]


@pytest.mark.parametrize(
    ("material", "kept"),
    [
        (pm.Material("dull", 0.5), []),
        (pm.Material("rough", 0.5, diffuse_roughness=0.5), []),
        (COAT, ["diffuse_fraction"]),
        (GLASS, ["diffuse_fraction"]),
        (pm.Material.pane(), ["diffuse_fraction"]),
        (pm.Material.plastic(), OF_GLOSS),
        (pm.Material.metal(roughness=0.1), OF_GLOSS),
        (pm.Material.glass(roughness=0.3), OF_GLOSS),
        (pm.Material("varnish", 0.5, coat=1.0), OF_GLOSS),
        (pm.Material("velvet", 0.5, sheen=0.8), OF_GLOSS),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_buffers_of_gloss_are_there_where_the_scene_calls_for_them(material, kept):
    plan = compile_and_plan(scene_of(material), Settings.of(Options(**SETTINGS)))
    assert plan.kept == {*DEFAULT, *kept}
    plan = compile_and_plan(
        scene_of(material), Settings.of(Options(**SETTINGS, buffers=["radiance"]))
    )
    assert plan.kept == {"radiance"}


def test_what_is_left_out_calls_for_nothing():
    options = Options(**SETTINGS, effects="emission,direct,indirect,specular")
    plastic = compile_and_plan(scene_of(pm.Material.plastic()), Settings.of(options))
    assert plastic.kept == {*DEFAULT}
    everything = Options(**SETTINGS, effects="all")
    dull = compile_and_plan(scene_of(pm.Material("dull", 0.5)), Settings.of(everything))
    assert dull.kept == {*DEFAULT}


def test_renders_of_gloss_have_them_and_are_merged(tmp_path):
    runs = [pm.render(scene_of(pm.Material.plastic()), **SETTINGS, seed=s) for s in (1, 2)]
    assert "buffers" not in runs[0].record["arguments"]
    asked = pm.render(scene_of(pm.Material.plastic()), **SETTINGS, seed=1, buffers=BUFFERS)
    merged = pm.merge(runs)
    merged.save_exr(tmp_path / "image.exr")
    for result in (merged, pm.load_result(tmp_path / "image.exr")):
        for name in OF_GLOSS:
            np.testing.assert_array_equal(result[name], asked[name])


def test_data_sets_hold_them_on_request():
    assert rendered_for(None) == [*DEFAULT]
    assert rendered_for(["radiance", "roughness"]) == [*DEFAULT, "roughness"]


def test_specular_reflectance_is_absent_without_gloss():
    result = pm.render(scene_of(COAT), **SETTINGS)
    assert "specular_reflectance" not in result.buffers
    with pytest.raises(AttributeError, match="was not among the buffers written"):
        _ = result.specular_reflectance


def test_textured_gloss_beside_glass_that_absorbs():
    """Both are looked up at once: the roughness of a texel, and that of glass with a medium."""
    texture = pm.Texture.of(np.full((2, 2, 3), 0.4, np.float32))
    metal = pm.Material.metal("metal", 0.9, texture)
    wine = pm.Material("wine", 0.0, ior=1.4, attenuation_color=0.5, attenuation_distance=1.0)
    corners, body = np.eye(3) + 3.0, trimesh.creation.box((1.0, 1.0, 1.0))
    plate = pm.Mesh(corners, [[0, 1, 2]], metal, uv=corners[:, :2])
    scene = pm.Scene([plate, pm.Mesh(body.vertices, body.faces, wine)], [pm.DomeLight(1.0)])
    compiled = compile_scene(scene, Bands.rgb())
    assert compiled.specular.media is not None
    seen = compiled.geometry.material.argsort()[[0, -1]]
    blank = np.zeros((3, 3), np.float32)
    places = np.append(seen, -1).astype(np.int32), np.full((3, 2), 0.3, np.float32)
    hits = first_hits.FirstHits(*places, blank, blank[0], blank[0], blank)
    found = first_hits._COMPUTE["roughness"](compiled, hits)
    np.testing.assert_allclose(found, [0.4, 0.0, 0.0], atol=1e-6)
