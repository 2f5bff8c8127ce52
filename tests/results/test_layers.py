import numpy as np
import OpenImageIO
import pytest

import photonmap as pm
from photonmap.results.result import Result


@pytest.fixture(scope="module")
def result(cornell):
    return pm.render(cornell, bands=4, size=(20, 12), passes=2, per_light=True)


def channels(path):
    image = OpenImageIO.ImageInput.open(str(path))
    assert image.spec().get_int_attribute("oiio:subimages", 1) == 1
    return dict(zip(image.spec().channelnames, np.moveaxis(image.read_image(), -1, 0), strict=True))


def test_buffers_are_passes_in_linear_srgb(result, tmp_path):
    result.save_layers(tmp_path / "new" / "box.exr")
    read = channels(tmp_path / "new" / "box.exr")
    for name, called in {"radiance": "Combined", "direct": "direct", "shading": "shading"}.items():
        image = np.stack([read[f"photonmap.{called}.{letter}"] for letter in "RGB"], axis=-1)
        np.testing.assert_array_equal(image, result.rgb(name))
    np.testing.assert_array_equal(read["photonmap.Combined.A"], result.coverage)
    np.testing.assert_array_equal(read["photonmap.Depth.Z"], result.depth)
    np.testing.assert_array_equal(read["photonmap.normal.Y"], result.normal[..., 1])
    np.testing.assert_array_equal(read["photonmap.object_id.Z"], result.object_id)


def test_layers_are_named_by_three_words(result, tmp_path):
    result.save_layers(tmp_path / "box.exr")
    names = channels(tmp_path / "box.exr")
    assert {len(name.split(".")) for name in names} == {3}
    groups = [f"direct@{group}" for group in result.per_light]
    assert all(f"photonmap.{group.replace('.', '_')}.R" in names for group in groups)


def test_the_parts_add_up(result, tmp_path):
    result.save_layers(tmp_path / "box.exr", white="D65")
    read = channels(tmp_path / "box.exr")
    parts = [read[f"photonmap.{name}.G"] for name in ("emission", "direct", "indirect")]
    np.testing.assert_allclose(read["photonmap.Combined.G"], sum(parts), atol=1e-5)


def test_names_that_would_be_alike_are_refused(result, tmp_path):
    buffers = {"direct@a.b": result.direct, "direct@a_b": result.direct, **result.buffers}
    alike = Result(buffers, {}, result.bands, result.record)
    with pytest.raises(pm.InputError, match=r"'direct@a\.b' and 'direct@a_b' would both be called"):
        alike.save_layers(tmp_path / "box.exr")
    assert not [*tmp_path.iterdir()]


def test_another_suffix_is_refused(result, tmp_path):
    with pytest.raises(pm.InputError, match=r"layers are written as OpenEXR; write FILE\.exr"):
        result.save_layers(tmp_path / "box.png")
    assert not [*tmp_path.iterdir()]
