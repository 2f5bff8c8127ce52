"""Lights whose intensity is a table: direct light, photons, both methods, and files."""

import numpy as np
import pytest
from emitter_cases import PHOTONS, compiled, emit, lamp_table
from helpers.scenes import closed_box, quad
from scipy import stats

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene, describe_run
from photonmap.kernels.core.passes import Film
from photonmap.scene.photometric import as_table

METHODS = ("photon", "path")
HEIGHT, RHO = 1.5, 0.8
DOWN = pm.Camera((0.0, 3.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), height=2.4)
POLAR, AZIMUTHS = np.arange(181.0), np.arange(361.0)
SIGNIFICANCE = 1e-4


def floor():
    corners = [(-5, 0, 5), (5, 0, 5), (5, 0, -5), (-5, 0, -5)]
    return quad(*corners, pm.Material("floor", RHO), "floor")


def look_down(light, method="photon", size=12, **options):
    """Render the floor from above; return the result and points' x and z."""
    scene = pm.Scene([floor()], [light], DOWN)
    settings = {"bands": 1, "pixel": "center", "passes": 1, "photons": 10, "threads": 2}
    result = pm.render(scene, **settings | options, size=(size, size), method=method)
    z, x = (np.mgrid[:size, :size] + 0.5) / size * 2.4 - 1.2
    return result, x, z


def candelas(polar, azimuth):
    """Return smooth intensities over angles, in degrees."""
    polar, azimuth = np.radians(polar), np.radians(azimuth)
    return 100.0 * np.cos(polar / 2.0) ** 6 * (1.0 + 0.5 * np.sin(azimuth) * np.sin(polar))


def mean_over_directions(table):
    """Return the mean of a function of angles, by Gauss-Legendre and even azimuths."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    azimuth = np.arange(360.0) + 0.5
    values = table(np.degrees(np.arccos(nodes))[:, None], azimuth)
    return float(weights @ np.broadcast_to(values, (64, 360)).mean(axis=1)) / 2.0


def write_ies(path):
    """Write the intensities as a file in whole degrees."""
    rows = candelas(POLAR, AZIMUTHS[:, None])
    head = "IESNA:LM-63-2002\n[LUMCAT] test\nTILT=NONE\n1 -1 1 181 361 1 2 0 0 0\n1 1 0\n"
    numbers = [POLAR, AZIMUTHS, *rows]
    path.write_text(head + "\n".join(" ".join(f"{v:.9g}" for v in row) for row in numbers))
    return path


@pytest.mark.parametrize("method", METHODS)
def test_direct_light_of_a_file(tmp_path, method):
    """E = I(θ, φ) cos³θ / h² on the floor below, I relative to its mean over directions."""
    file, intensity = write_ies(tmp_path / "a.ies"), 3.0
    light = pm.PhotometricLight((0.0, HEIGHT, 0.0), file, intensity)
    result, x, z = look_down(light, method)
    polar = np.degrees(np.arctan2(np.hypot(x, z), HEIGHT))
    azimuth = np.degrees(np.arctan2(-z, x))  # counterclockwise from above, as LM-63 has it
    level = candelas(polar, azimuth) / mean_over_directions(candelas) * intensity
    truth = RHO / np.pi * level * np.cos(np.radians(polar)) ** 3 / HEIGHT**2
    np.testing.assert_allclose(result.direct[..., 0], truth, rtol=5e-4)
    assert (result.indirect == 0.0).all()
    assert result.direct[0].mean() > 1.2 * result.direct[-1].mean()


def test_the_axes_turn_the_table():
    """A lamp that is turned about lights the floor as the table turned about."""
    direction, azimuth = np.array([0.3, -1.0, 0.2]), np.array([0.5, 0.1, -1.0])
    place = (0.1, HEIGHT, -0.2)
    light = pm.PhotometricLight(
        place, candelas(POLAR[:, None], AZIMUTHS), 2.0, tuple(direction), tuple(azimuth)
    )
    result, x, z = look_down(light)
    axis = direction / np.linalg.norm(direction)
    first = azimuth - (azimuth @ axis) * axis
    first /= np.linalg.norm(first)
    way = np.stack([x, np.zeros_like(x), z], axis=-1) - place
    distance = np.linalg.norm(way, axis=-1)
    polar = np.degrees(np.arccos(way @ axis / distance))
    turn = np.degrees(np.arctan2(way @ np.cross(first, axis), way @ first))
    level = candelas(polar, turn) / mean_over_directions(candelas) * 2.0
    truth = RHO / np.pi * level * HEIGHT / distance**3
    np.testing.assert_allclose(result.direct[..., 0], truth, rtol=1e-3)


@pytest.mark.parametrize("method", METHODS)
def test_an_even_table_is_a_point_light(method):
    """The same photons and light samples, to rounding."""
    walls = [closed_box(pm.Material("walls", 0.6))]
    camera = pm.Camera((0.2, 0.3, 0.9), (0.0, -0.2, -1.0), fov=70.0)
    settings = {"bands": 1, "size": (8, 8), "passes": 4, "photons": 2000, "threads": 2}
    place, intensity = (0.1, 0.4, -0.2), 2.0
    even = pm.PhotometricLight(place, np.full((4, 5), 30.0), intensity)
    first, second = (
        pm.render(pm.Scene(walls, [light], camera), **settings, method=method)
        for light in (even, pm.PointLight(place, intensity))
    )
    np.testing.assert_allclose(first.direct, second.direct, rtol=1e-5)
    np.testing.assert_allclose(first.indirect, second.indirect, rtol=2e-3)
    assert second.indirect.min() > 0.0


def table_in_bins(heights, turns, finer=12):
    """Return the part of all flux that the table sends into bins of cosine and azimuth."""
    z = 1.0 - (np.arange(heights * finer) + 0.5) / (heights * finer) * 2.0
    turn = (np.arange(turns * finer) + 0.5) / (turns * finer) * 360.0
    table = as_table(lamp_table()).astype(float)
    rows = np.stack([np.interp(np.degrees(np.arccos(z)), POLAR, column) for column in table.T])
    grid = np.stack([np.interp(turn, AZIMUTHS, row) for row in rows.T])
    return grid.reshape(heights, finer, turns, finer).mean(axis=(1, 3)) / (heights * turns)


def test_photons_leave_as_the_table_says():
    """χ² of the flux in bins over all directions, by its own variance: p > 1e-4."""
    heights, turns = 8, 12
    scene, _, _ = compiled("photometric")
    light = next(light for light in scene.lights if light.kind == "photometric")
    _, directions, flux = emit("photometric", key=31)
    axis, azimuth = (np.array(v) / np.linalg.norm(v) for v in (light.direction, light.azimuth))
    first = azimuth - (azimuth @ axis) * axis
    first /= np.linalg.norm(first)
    turn = np.arctan2(directions @ np.cross(first, axis), directions @ first) % (2.0 * np.pi)
    place = np.minimum(((1.0 - directions @ axis) / 2.0 * heights).astype(int), heights - 1)
    place = place * turns + np.minimum((turn / (2.0 * np.pi) * turns).astype(int), turns - 1)
    sums, squares = (np.bincount(place, flux**power, heights * turns) for power in (1, 2))
    expected = table_in_bins(heights, turns).ravel() * flux.sum()
    assert expected.max() > 5.0 * expected.min()
    variance = squares - sums**2 / PHOTONS
    score = ((sums - expected) ** 2 / variance).sum()
    assert stats.chi2.sf(score, heights * turns - 1) > SIGNIFICANCE


def test_photons_and_paths_agree():
    """Direct light of pixels' centres to rounding; the mean of indirect by Welch's t."""
    walls = [closed_box(pm.Material("walls", 0.6))]
    light = pm.PhotometricLight((0.1, 0.3, -0.2), lamp_table(), 2.0, direction=(0.5, -1.0, 0.2))
    camera = pm.Camera((0.2, 0.3, 0.9), (0.0, -0.2, -1.0), fov=70.0)
    scene = pm.Scene(walls, [light], camera)
    settings = {"bands": 1, "size": (8, 8), "pixel": "center", "threads": 2}
    cost = {"photon": {"passes": 4, "photons": 4000}, "path": {"passes": 64}}
    found = {
        method: [
            pm.render(scene, **settings, **cost[method], method=method, seed=seed)
            for seed in range(6)
        ]
        for method in METHODS
    }
    photon, path = ([r.indirect.mean(dtype=float) for r in found[m]] for m in METHODS)
    np.testing.assert_allclose(found["photon"][0].direct, found["path"][0].direct, rtol=1e-5)
    assert stats.ttest_ind(photon, path, equal_var=False).pvalue > SIGNIFICANCE
    assert np.mean(photon) == pytest.approx(np.mean(path), rel=0.05)


@pytest.mark.parametrize("from_file", [False, True], ids=["table", "file"])
def test_what_is_saved_is_loaded(tmp_path, from_file):
    """Attributes are the same; the table is, to the digits of the file."""
    table = write_ies(tmp_path / "lamp.ies") if from_file else lamp_table()
    light = pm.PhotometricLight(
        (0.1, 1.0, 2.0), table, (3.0, 2.0, 1.0), (0.0, -1.0, 0.5), (1.0, 0.25, 0.0), "lamp", "hall"
    )
    pm.save_scene(pm.Scene([floor()], [light]), tmp_path / "room.obj")
    text = (tmp_path / "room.toml").read_text()
    assert 'type = "photometric"' in text
    assert 'file = "room_files/lamp.ies"' in text
    (again,) = pm.load_scene(tmp_path / "room.obj").lights
    for name in ("position", "intensity", "direction", "azimuth", "name", "group"):
        assert getattr(again, name) == getattr(light, name), name
    np.testing.assert_allclose(as_table(again.table), as_table(table), rtol=2e-6)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("direction = [0, 0, 0]", r":5: .* direction: \[0, 0, 0\] has no length"),
        ("azimuth = [0, 2, 0]", r":5: .*azimuth \(0.0, 2.0, 0.0\) is parallel to the direction"),
        ("intensity = -1", r":5: \[\[light\]\] intensity"),
        ("tilt = 3", r":5: photometric light key 'tilt' is not known"),
    ],
)
def test_bad_attributes_are_refused_with_their_line(tmp_path, line, message):
    pm.save_scene(pm.Scene([floor()]), tmp_path / "room.obj")
    write_ies(tmp_path / "lamp.ies")
    head = '[[light]]\ntype = "photometric"\nposition = [0, 1, 0]\nfile = "lamp.ies"\n'
    (tmp_path / "room.toml").write_text(head + line + "\n")
    with pytest.raises(pm.InputError, match=rf"room\.toml{message}"):
        pm.load_scene(tmp_path / "room.obj")


def test_a_file_is_needed(tmp_path):
    pm.save_scene(pm.Scene([floor()]), tmp_path / "room.obj")
    text = '[[light]]\ntype = "photometric"\nposition = [0, 1, 0]\n'
    (tmp_path / "room.toml").write_text(text)
    message = r'room\.toml:1: the photometric light lacks file; add file = "FILE\.ies"'
    with pytest.raises(pm.InputError, match=message):
        pm.load_scene(tmp_path / "room.obj")


def test_the_table_decides_which_runs_may_be_joined():
    bands, film, prints = pm.Bands.parse("1"), Film(8, 8, True), []
    for table in (lamp_table(), lamp_table(), lamp_table() ** 2):
        scene = pm.Scene([floor()], [pm.PhotometricLight((0.0, 1.0, 0.0), table)], DOWN)
        prints.append(describe_run(compile_scene(scene, bands), bands, film, {})["lights"])
    assert prints[0] == prints[1] != prints[2]
