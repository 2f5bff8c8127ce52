"""The mean reflectance of scenes, and the size of rooms, that are asked for."""

import numpy as np
import pytest
from helpers.generated import mean_reflectance, unlit
from helpers.marks import slow

from photonmap.dataset.models.scene_object import with_lightness
from photonmap.dataset.scenes.build import build_unlit_scene
from photonmap.errors import InputError
from photonmap.spectra.munsell import shipped_set


@pytest.mark.parametrize(
    ("materials", "name", "near"),
    [
        ("lambertian", "bedroom", 0.02),
        ("mixed", "cushion", 0.07),
        ("rich", "cushion", 0.07),
        pytest.param("rich", "bathroom", 0.02, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("wanted", [0.2, 0.45])
def test_objects_get_the_lightness_that_is_asked_for(materials, name, near, wanted):
    plain = unlit(name, 0, materials).objects
    made = with_lightness(plain, wanted)
    assert mean_reflectance(made) == pytest.approx(wanted, abs=near)
    assert with_lightness(plain, None) is plain


@pytest.mark.parametrize("name", ["cushion", "bedroom", *slow("garden")])
def test_lightness_changes_reflectances_alone(name):
    plain = unlit(name, 0, "mixed")
    made = build_unlit_scene(name, 0, "mixed", lightness=0.2)
    assert mean_reflectance(made.objects) == pytest.approx(0.2, abs=0.07)
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
    made, larger = unlit("bathroom"), build_unlit_scene("bathroom", 0, scale=2.0)
    sizes = [
        np.ptp(next(o for o in each.objects if o.name == "walls").bounds, axis=0)
        for each in (made, larger)
    ]
    np.testing.assert_allclose(sizes[1], 2.0 * sizes[0], rtol=0.25)
    assert len(larger.objects) > 1.3 * len(made.objects)
    with pytest.raises(InputError, match=r"scale 5 must be from 0\.8 to 3"):
        build_unlit_scene("bathroom", 0, scale=5.0)
