"""Fluorescent surfaces: closed forms, all methods, and what the buffers say of each other."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers.marks import slow
from helpers.scenes import GREY, ball, closed_box, quad
from scipy import stats

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.compile.surfaces import fluorescence
from photonmap.integrators.photon_mapping.cache_cells import one_cell
from photonmap.kernels.core.passes import RadiosityCache, Span
from photonmap.kernels.integrators.photon import trace_photons
from photonmap.scene.surfaces.layers import check_layers

# Of bands that see a part of what excites: the matrix of the bands is what counts here.
pytestmark = pytest.mark.filterwarnings("ignore:.*excites its fluorescence")

GRID = np.arange(300.0, 781.0)
BANDS = pm.Bands.parse("box:5")
FIVE = np.array([
    [0.02, 0.00, 0.00, 0.00, 0.00],
    [0.30, 0.01, 0.00, 0.00, 0.00],
    [0.20, 0.35, 0.02, 0.00, 0.00],
    [0.05, 0.10, 0.25, 0.00, 0.00],
    [0.00, 0.05, 0.30, 0.10, 0.00],
])  # fmt: skip
"""Entry [i, j]: from band j to band i."""
METHODS = {"photon": {}, "path": {"method": "path"}, "unbiased": {"unbiased": True}}
ALL = ["photon", *slow("path", "unbiased")]
"""The others compile passes of their own."""


def bump(center, sigma, height=1.0):
    return pm.Spectrum(GRID, height * np.exp(-0.5 * ((GRID - center) / sigma) ** 2))


def ramp(first, last):
    return pm.Spectrum(GRID, np.interp(GRID, [400.0, 700.0], [first, last]))


def in_band(number):
    """Return a light of one of the five bands."""
    start = 400.0 + 60.0 * number
    edges = [300.0, start + 1.0, start + 2.0, start + 58.0, start + 59.0, 780.0]
    return pm.Spectrum(edges, [0.0, 0.0, 1.0, 1.0, 0.0, 0.0])


@pytest.fixture
def glowing(monkeypatch):
    """Return a function that makes materials of a matrix over bands."""
    known, reduce = {}, fluorescence.reradiation

    def reradiation(chosen, bands):
        return known[chosen] if chosen in known else reduce(chosen, bands)

    def make(matrix, **attributes):
        dye = pm.Fluorescence(bump(400.0 + len(known), 10.0, 0.1), bump(600.0, 10.0))
        known[dye] = np.asarray(matrix, float)
        return pm.Material("glow", fluorescence=dye, **attributes)

    monkeypatch.setattr(fluorescence, "reradiation", reradiation)
    return make


def render(scene, **options):
    few = {"bands": BANDS, "size": 8, "threads": 1, "photons": 2048}
    return pm.render(scene, **{**few, **options})


def view_of(material):
    return pm.Scene([closed_box(material)], camera=pm.Camera((0, 0, 0.5), (0, 0, -1)))


@pytest.mark.parametrize("method", ALL)
def test_closed_furnace_is_the_geometric_series_of_the_matrix(glowing, method):
    """Walls that emit ε, reflect ρ and re-emit F have the radiance (1 − ρ − F)⁻¹ ε all over."""
    albedo, light = ramp(0.6, 0.2), ramp(2.0, 0.1)
    scene = view_of(glowing(0.6 * FIVE, reflectance=albedo, emission=light))
    # The noise of photon mapping is that of photons, not of pixels.
    small = {"size": 8, "photons": 8192} if method == "photon" else {}
    result = render(scene, passes=64, **{"size": 16, "photons": None, **small}, **METHODS[method])
    whole = np.diag(BANDS.reflectance(albedo)) + 0.6 * FIVE
    truth = np.linalg.solve(np.eye(5) - whole, BANDS.emission(light))
    assert result.radiance.mean((0, 1)) == pytest.approx(truth, rel=3e-3)
    glow = result.fluorescence.mean((0, 1))
    assert glow == pytest.approx(0.6 * FIVE @ truth, rel=3e-3, abs=1e-6)


COVERS = {
    "coat": {"coat": 1.0},
    "rough coat": {"coat": 0.6, "coat_roughness": 0.5},
    "gloss": {"glossy": 0.04, "roughness": 0.4},
    "clay": {"diffuse_roughness": 0.8},
    "sheen": {"sheen": 0.5, "sheen_roughness": 0.6},
    "mirror": {"mirror": 0.3},
}


@pytest.mark.parametrize("method", ALL[:2])
@pytest.mark.parametrize("cover", ["clay", *slow(*sorted(COVERS.keys() - {"clay"}))])
def test_covers_let_re_emitted_light_pass_as_the_light_that_excites(glowing, cover, method):
    """Where ρ + S is the same in all bands, their sum is that of a base with this reflectance."""
    part = 0.5 * FIVE / FIVE.sum(axis=0).max()
    matrix = part + np.diag(0.5 - part.sum(axis=0))
    matrix[4, :4] += np.diag(matrix)[:4]
    matrix[np.arange(4), np.arange(4)] = 0.0
    assert matrix.sum(axis=0) == pytest.approx(0.5)
    scenes = [
        view_of(glowing(matrix, reflectance=0.1, emission=1.0, **COVERS[cover])),
        view_of(pm.Material("plain", 0.6, emission=1.0, **COVERS[cover])),
    ]
    seeds, settings = (0, 1), {"passes": 48}
    if method == "photon":  # one seed for both: most of their noise is alike, and 0.1% is left
        more = {
            "clay": {"passes": 32, "size": 24},
            "sheen": {"passes": 64},
            "mirror": {"size": 24},
        }
        seeds, settings = (0, 0), {"passes": 40, "size": 32, "photons": 8192, **more.get(cover, {})}
    results = [  # whose paths never end in the cache
        render(scene, seed=seed, **settings, **METHODS[method])
        for seed, scene in zip(seeds, scenes, strict=True)
    ]
    means = [result.radiance.mean((0, 1), dtype=float) for result in results]
    # Pixels of paths are independent, those of photon mapping are not.
    errors = [np.linalg.norm(result.errors["radiance"].sum(axis=-1)) / 64.0 for result in results]
    noise = 3.0 * math.hypot(*errors) if method == "path" else 4e-3 * means[1].sum()
    assert abs(means[0].sum() - means[1].sum()) < noise
    assert noise < 0.025 * means[1].sum()
    assert means[0][4] > 1.2 * means[1][4]


def test_photons_reflect_the_series_of_their_power(glowing):
    """In a closed box, all that photons store adds up to (1 − M)⁻¹ M Φ, with M = ρ + F."""
    lamp, albedo = ramp(1.0, 0.3), ramp(0.5, 0.3)
    walls = closed_box(glowing(0.6 * FIVE, reflectance=albedo))
    compiled = compile_scene(pm.Scene([walls], [pm.PointLight((0.2, 0.1, 0.0), lamp)]), BANDS)
    cache = RadiosityCache(one_cell(12), np.empty((1, 5), np.float32))
    number = 100_000
    scratch = np.empty((3, 5), np.float32)
    span = Span(0, number)
    trace_photons(compiled.arrays, cache, np.uint64(7), span, number, 1000, scratch)
    whole = np.diag(BANDS.reflectance(albedo)) + 0.6 * FIVE
    truth = np.linalg.solve(np.eye(5) - whole, whole @ compiled.white)
    assert cache.radiosity[0] == pytest.approx(truth, rel=0.01)


def test_one_plate_lights_another_by_what_it_re_emits(glowing):
    """A plate under a sun has the radiance (ρ + F) E / π; the other sees it by a form factor."""
    plate = quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), glowing(FIVE, reflectance=0.2))
    small = quad(
        (-0.01, -0.01, 1),
        (-0.01, 0.01, 1),
        (0.01, 0.01, 1),
        (0.01, -0.01, 1),
        pm.Material("b", 0.0),
    )
    sun = pm.DirectionalLight((-math.sqrt(3.0), 0.0, -1.0), 2.0 * math.pi)
    camera = pm.Camera((0.0, 0.0, 0.9), (0.0, 0.0, 1.0), up=(0, 1, 0), fov=4.0)
    result = render(pm.Scene([plate, small], [sun], camera), passes=64)
    corner = math.atan(1.0 / math.sqrt(2.0)) / math.sqrt(2.0)
    factor = 4.0 / (2.0 * math.pi) * 2.0 * corner
    truth = factor * (0.2 + FIVE.sum(axis=1))
    assert result.shading.mean((0, 1)) == pytest.approx(truth, rel=3e-3)


@pytest.mark.parametrize("method", ALL[:2])
def test_lamp_and_sensor_change_places_with_the_transpose(glowing, method):
    """Irradiance at Q in band 3 by P in band 0 is that at P in band 0 by Q in band 3 and Fᵀ."""
    left = [(-0.95, y, z) for y, z in ((-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2))]
    floor = [(x, -0.95, z) for x, z in ((0.1, -0.2), (0.1, 0.2), (0.5, 0.2), (0.5, -0.2))]
    seen = []
    for lamp, sensor, view, matrix, sent, read in (
        (left, floor, ((0.3, -0.6, 0.0), (0.3, -0.95, 0.0), (1, 0, 0)), FIVE, 0, 3),
        (floor, left, ((-0.6, 0.0, 0.0), (-0.95, 0.0, 0.0), (0, 1, 0)), FIVE.T, 3, 0),
    ):
        walls = closed_box(glowing(matrix, reflectance=0.2))
        glow, black = pm.Material("lamp", 0.0, in_band(sent)), pm.Material("black", 0.0)
        meshes = [walls, quad(*lamp, glow, "lamp"), quad(*sensor, black, "sensor")]
        camera = pm.Camera(view[0], view[1], view[2], height=0.4)
        result = render(pm.Scene(meshes, camera=camera), passes=96, **METHODS[method])
        seen.append(float(result.shading[..., read].mean(dtype=float)))
    assert seen[0] > 0.0
    assert seen[0] == pytest.approx(seen[1], rel=0.02)


def room(glowing, shiny=True):
    """Return a closed room with fluorescent surfaces of many kinds."""
    rng = np.random.default_rng(1)
    spots = pm.Texture.of(rng.uniform(0.0, 1.0, (8, 8)))
    kinds = [
        glowing(FIVE, reflectance=0.2, fluorescence_concentration=spots),
        glowing(0.8 * FIVE, reflectance=0.1, coat=1.0),
        glowing(0.8 * FIVE, reflectance=0.1, glossy=0.04, roughness=0.3),
        pm.Material.polished("mirror", 0.9) if shiny else GREY,
    ]
    glow = pm.Material("lamp", 0.0, ramp(6.0, 1.0))
    lamp = quad(
        (-0.6, 0.9, -0.6), (0.6, 0.9, -0.6), (0.6, 0.9, 0.6), (-0.6, 0.9, 0.6), glow, "lamp"
    )
    balls = [
        ball(kind, (x, y, -0.3), 0.35, name=f"ball {number}")
        for number, (kind, x, y) in enumerate(
            zip(kinds, (-0.4, 0.4, -0.4, 0.4), (-0.4, -0.4, 0.4, 0.4), strict=True)
        )
    ]
    camera = pm.Camera((0.0, 0.0, 0.95), (0.0, 0.0, -1.0), fov=75.0)
    box = closed_box(glowing(0.5 * FIVE, reflectance=0.4))
    return pm.Scene([box, lamp, *balls], camera=camera)


@pytest.mark.parametrize("method", slow("photon", "unbiased"))
def test_all_methods_agree_on_every_buffer(glowing, method):
    """Of textures, coats and gloss, and in a mirror; means over quarters of the image."""
    scene = room(glowing, shiny=method == "photon")
    names = (
        "radiance", "direct", "indirect", "shading", "fluorescence", "fluorescence_direct",
        "fluorescence_indirect", "excitation",
    )  # fmt: skip
    means = []
    for number, (passes, options) in enumerate([(192, METHODS["path"]), (24, METHODS[method])]):
        runs = [
            render(scene, size=16, passes=passes, photons=None, seed=seed, buffers=names, **options)
            for seed in range(100 * number, 100 * number + 6)
        ]
        means.append([
            [run[name].reshape(2, 8, 2, 8, 5).mean((1, 3), dtype=float) for name in names]
            for run in runs
        ])  # fmt: skip
    truth, found = np.array(means)
    step = found.mean(axis=0) - truth.mean(axis=0)
    error = np.sqrt((found.var(axis=0, ddof=1) + truth.var(axis=0, ddof=1)) / 6.0)
    scale = np.abs(truth.mean(axis=0)).mean(axis=(1, 2), keepdims=True)
    bias = 0.01 if method == "photon" else 0.0
    assert (np.abs(step) <= 6.0 * error + bias * scale + 1e-7).all()
    assert (error < 0.05 * scale + 1e-7).all()


def test_buffers_add_up(glowing):
    lights = [pm.PointLight((0.3, 0.5, 0.3), ramp(1.0, 0.2), name="white", group="day")]
    scene = replace(room(glowing), lights=lights)
    extra = ("fluorescence_direct", "fluorescence_indirect", "excitation")
    wanted = (*pm.render(scene, bands=BANDS, size=4, passes=2).buffers, *extra)
    result = render(scene, passes=6, per_light=True, buffers=wanted, effects="auto")
    assert (result.radiance == (result.emission + result.direct) + result.indirect).all()
    light = result.direct.astype(float) + result.indirect
    parts = result.reflectance.astype(float) * result.shading + result.fluorescence
    scale = 1e-6 * np.abs(light).max()
    assert light == pytest.approx(parts + result.residual, rel=2e-6, abs=scale)
    direct, indirect = result.fluorescence_direct, result.fluorescence_indirect
    assert result.fluorescence == pytest.approx(direct + indirect, rel=1e-5, abs=scale)
    assert (direct <= result.direct * 1.00001 + scale).all()
    whole = result.fluorescence.sum(axis=-1, dtype=float)
    assert result.excitation.sum(axis=-1, dtype=float) == pytest.approx(whole, rel=1e-4, abs=scale)
    total = sum(part["fluorescence"] for part in result.per_light.values())
    assert (result.fluorescence == total).all()
    assert set(result.errors) >= {"fluorescence", "excitation", "fluorescence_direct@day"}
    assert "fluorescence" in result.block_errors
    assert result.reflectance.max() <= 0.4 + 1e-6  # without what is re-emitted


def test_black_surfaces_that_fluoresce_have_no_residual(glowing):
    """Nor its error, though their light is that of no shading."""
    plate = quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), glowing(FIVE, reflectance=0.0))
    mirror = ball(pm.Material.polished("mirror", 0.9), (1.5, 0.0, 0.6), 0.3)
    lamp = pm.PointLight((-1.0, 0.0, 1.0), ramp(1.0, 0.5))
    scene = pm.Scene([plate, mirror], [lamp], pm.Camera((0, 0, 3), (0, 0, 0), fov=30.0))
    result = render(scene, passes=8)
    assert result.fluorescence[..., 1:].min() > 0.0
    light = result.direct.astype(float) + result.indirect
    assert result.fluorescence == pytest.approx(light, rel=1e-5, abs=1e-9)
    assert not result.residual.any()
    assert not result.errors["residual"].any()


def test_bands_that_a_matrix_tells_apart_are_not_merged(glowing):
    """White light on grey paint is one column; a matrix whose rows differ, as many as these."""
    merged = FIVE.copy()
    merged[4], merged[:, 4] = merged[3], merged[:, 3]
    for matrix, columns in ((FIVE, 5), (merged, 4)):
        material = glowing(0.6 * matrix, reflectance=0.3, emission=1.0)
        results = [
            render(view_of(material), passes=16, effects=effects) for effects in ("auto", "all")
        ]
        why = results[0].record["effects"]["band_merging"]["why"]
        assert why == (
            "all bands differ" if columns == 5 else f"5 bands have {columns} different spectra"
        )
        truth = np.linalg.solve(np.eye(5) - 0.3 * np.eye(5) - 0.6 * matrix, np.ones(5))
        for result in results:
            assert result.radiance.mean((0, 1)) == pytest.approx(truth, rel=0.01)


def test_groups_are_relit_at_other_strengths_but_not_in_other_spectra(glowing):
    sky = pm.DomeLight(ramp(0.1, 1.0), name="sky")
    lamp = pm.PointLight((0.3, 0.5, 0.3), ramp(1.0, 0.0), name="lamp")
    plate = quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), glowing(FIVE, reflectance=0.3))
    scene = pm.Scene([plate, ball(GREY)], [sky, lamp], pm.Camera((0, 0, 3), (0, 0, 0), fov=30.0))
    result = render(scene, passes=4, per_light=True)
    assert result.per_light["lamp"]["fluorescence"].any()
    relit = result.relit({"lamp": 3.0, "sky": 0.0})
    expected = 3.0 * result.per_light["lamp"]["fluorescence"]
    assert relit.fluorescence == pytest.approx(expected, rel=1e-6)
    assert relit.fluorescence == pytest.approx(
        relit.direct.astype(float) + relit.indirect - relit.reflectance * relit.shading, abs=1e-5
    )
    with pytest.raises(
        pm.InputError, match="fluoresce, which mixes the bands of light group 'lamp'"
    ):
        result.relit({"lamp": [1.0, 2.0, 1.0, 1.0, 1.0]})


def test_a_run_is_resumed_with_the_same_bits(glowing, tmp_path):
    scene, file = room(glowing), tmp_path / "state.checkpoint"
    render(scene, passes=2, checkpoint=file)
    resumed, whole = render(scene, passes=3, checkpoint=file, resume=True), render(scene, passes=3)
    assert (resumed.fluorescence == whole.fluorescence).all()
    assert (resumed.errors["fluorescence"] == whole.errors["fluorescence"]).all()


@pytest.mark.slow
def test_intervals_hold_what_they_state():
    """95% intervals of 24 seeds of 16 passes, of the mean of the other seeds, in 93 to 97%."""
    box = pm.scenes.cornell_box()
    dye = pm.Fluorescence(bump(450.0, 30.0, 0.6), bump(540.0, 25.0), 0.9)
    paint = pm.Material("paint", 0.3, fluorescence=dye)
    named = ("left", "large_box")
    meshes = [replace(m, material=paint) if m.name in named else m for m in box.meshes]
    runs = [
        render(replace(box, meshes=meshes), size=24, passes=16, photons=None, seed=seed)
        for seed in range(24)
    ]
    limit = stats.t.ppf(0.975, 15) * math.sqrt(1.0 + 1.0 / 23.0)
    for name in ("radiance", "indirect", "shading", "fluorescence"):
        values = np.array([run[name] for run in runs], float)
        errors = np.array([run.standard_error(name) for run in runs], float)
        others = (values.sum(axis=0) - values) / 23.0
        varies = (errors > 0.0) & (values.std(axis=0) > 1e-5 * values.mean())
        held = (np.abs(values - others) <= limit * errors)[varies].mean()
        assert 0.93 < held < 0.97, name


def test_runs_merge_as_one(glowing):
    scene = room(glowing)
    merged = pm.merge([render(scene, passes=passes, seed=passes) for passes in (2, 3)])
    light = merged.direct.astype(float) + merged.indirect
    parts = merged.reflectance.astype(float) * merged.shading + merged.fluorescence
    assert light == pytest.approx(parts + merged.residual, rel=1e-5, abs=1e-5)


def test_the_plan_says_why(glowing):
    plain = render(view_of(pm.Material("plain", 0.5, 1.0)), size=2, passes=1)
    assert plain.record["effects"]["fluorescence"]["why"] == "no surface fluoresces"
    assert "fluorescence" not in plain.buffers
    assert not plain.fluorescence.any()
    scene = view_of(glowing(0.5 * FIVE, reflectance=0.3, emission=1.0))
    dull = render(scene, size=4, passes=8, effects="emission,direct,indirect")
    assert dull.record["effects"]["fluorescence"]["why"] == "left out on request"
    assert dull.radiance.mean((0, 1)) == pytest.approx(1.0 / 0.7, rel=0.02)
    assert compile_scene(scene, BANDS).fluorescence.taken[0] == pytest.approx(
        0.5 * FIVE.sum(axis=0)
    )


def test_glass_does_not_fluoresce(glowing):
    with pytest.raises(pm.InputError, match="fluorescence"):
        render(view_of(glowing(FIVE, ior=1.5, reflectance=0.0)))


WAVES = np.arange(300.0, 781.0)
GREEDY = pm.Fluorescence(
    pm.Spectrum(WAVES, np.where(WAVES <= 400.0, 0.9, 0.0)),
    pm.Spectrum(WAVES, np.exp(-0.5 * ((WAVES - 520.0) / 15.0) ** 2)),
)
"""Takes up nine tenths of the ultraviolet."""


def test_a_part_that_is_glass_does_not_fluoresce():
    """Under a dome the rest sends out a tenth of what an opaque plate does."""
    dark = pm.Spectrum(WAVES, np.where(WAVES <= 400.0, 1.0, 0.0))
    glow = []
    for part in ({}, {"ior": 1.5, "thin": True, "transmission": 0.9}):
        plate = pm.Material("plate", 0.1, fluorescence=GREEDY, **part)
        square = quad((-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0))
        meshes = [pm.Mesh(square.vertices, square.faces, plate)]
        scene = pm.Scene(
            meshes, [pm.DomeLight(dark)], pm.Camera((0, 0, 1), (0, 0, 0), up=(0, 1, 0))
        )
        options = {"bands": "300:780:20", "size": 4, "passes": 4, "threads": 1}
        glow.append(pm.render(scene, **options).fluorescence.mean((0, 1)).sum())
    assert glow[0] > 1.0
    assert glow[1] == pytest.approx(0.1 * glow[0], rel=1e-3)


@pytest.mark.parametrize(
    ("attributes", "problem"),
    [
        ({"reflectance": 0.0, "mirror": 1.0}, "with mirror: .* at 3.. nm they send out 0.9 and 1;"),
        ({"reflectance": 0.05, "mirror": 0.95}, "with mirror: .* they send out 0.9 and 1;"),
        ({"reflectance": 0.2}, "with reflectance: .* they send out 0.9 and 0.2;"),
        ({"transmission": pm.Texture.of(np.ones((2, 2, 1)) / 2), "ior": 1.5}, "with transmission"),
    ],
)
def test_no_more_leaves_than_arrives(attributes, problem):
    material = pm.Material("plate", **{"reflectance": 0.1, "fluorescence": GREEDY, **attributes})
    with pytest.raises(pm.InputError, match=problem):
        check_layers(material)
