"""The mean reflectance of scenes, and the size of rooms, that are asked for."""

import numpy as np
import pytest

from photonmap.dataset.models.materials.surfaces import reflectance_of
from photonmap.dataset.scenes.build import build_unlit_scene
from photonmap.errors import InputError
from photonmap.spectra.munsell import shipped_set


def mean_reflectance(unlit):
    parts = [p for obj in unlit.objects for p in obj.parts if not p.light_group]
    areas = np.array([p.shape.area for p in parts])
    return areas @ [reflectance_of(p.material) for p in parts] / areas.sum()


@pytest.mark.parametrize("materials", ["lambertian", "mixed"])
@pytest.mark.parametrize(("name", "near"), [("study", 0.02), ("kitchen", 0.02), ("cushion", 0.07)])
@pytest.mark.parametrize("wanted", [0.2, 0.45])
def test_scenes_have_the_lightness_that_is_asked_for(name, near, wanted, materials):
    plain = build_unlit_scene(name, 0, materials)
    made = build_unlit_scene(name, 0, materials, lightness=wanted)
    assert mean_reflectance(made) == pytest.approx(wanted, abs=near)
    assert made.camera == plain.camera
    known = set(shipped_set().names)
    for a, b in zip(plain.objects, made.objects, strict=True):
        np.testing.assert_array_equal(a.boxes, b.boxes)
        names = {p.material.name.removeprefix("glazed ") for p in b.parts}
        assert names <= known | {"metal", "glass"}
        for old, new in zip(a.parts, b.parts, strict=True):
            assert old.material.mirror == new.material.mirror


def test_a_lightness_that_no_chips_have():
    with pytest.raises(InputError, match=r"lightness 0.95 is out of reach: .* reflects 0.0\d to 0"):
        build_unlit_scene("vase", 0, lightness=0.95)
    for wrong in (0.0, 1.0):
        with pytest.raises(InputError, match="must be between 0 and 1"):
            build_unlit_scene("vase", 0, lightness=wrong)


def test_rooms_have_the_scale_that_is_asked_for():
    sizes, counts = [], []
    for scale in (1.0, 2.0):
        made = [build_unlit_scene("library", seed, scale=scale) for seed in range(3)]
        walls = [next(o for o in each.objects if o.name == "walls") for each in made]
        sizes.append(np.mean([np.ptp(wall.bounds, axis=0) for wall in walls], axis=0))
        counts.append(np.mean([len(each.objects) for each in made]))
    assert (sizes[1] > 1.6 * sizes[0]).all()
    assert counts[1] > 1.3 * counts[0]
    with pytest.raises(InputError, match=r"scale 5 must be from 0\.8 to 3"):
        build_unlit_scene("library", 0, scale=5.0)
