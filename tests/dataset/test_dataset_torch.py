"""The torch view of a data set, in real loaders."""

import numpy as np
import pytest

from photonmap import dataset
from photonmap.commands.main import main

torch = pytest.importorskip("torch", reason="torch is not installed")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Three images of one scene."""
    folder = tmp_path_factory.mktemp("torch")
    (folder / "three.toml").write_text(
        'scenes = ["jug"]\nilluminations = ["white", "colored", "two_mixed"]'
    )
    arguments = ["--preset", str(folder / "three.toml"), "--size", "16x12", "--bands", "3"]
    assert main(["dataset", str(folder / "set"), *arguments, "--error", "0.5", "--quiet"]) == 0
    return folder / "set"


def negative(item):
    """Stand in for what a user does to each image; workers find it by its name."""
    return {**item, "radiance": -item["radiance"]}


@pytest.mark.parametrize(("workers", "start"), [(0, None), (2, "fork"), (2, "spawn")])
def test_torch_batches_what_numpy_reads(made, workers, start):
    images = dataset.open(made)
    names = ("radiance", "shading@key light", "valid", "depth", "object_id")
    view = images[:2].torch(names, transform=negative)
    assert isinstance(view, torch.utils.data.Dataset)
    loader = torch.utils.data.DataLoader(
        view, batch_size=2, num_workers=workers, multiprocessing_context=start
    )
    [batch] = loader
    assert [batch[name].dtype for name in names] == [
        *[torch.float32] * 2, torch.bool, torch.float32, torch.int64
    ]  # fmt: skip
    assert batch["radiance"].shape == (2, 3, 12, 16)
    assert batch["valid"].shape == batch["depth"].shape == (2, 1, 12, 16)
    for index, image in enumerate(images[:2]):
        radiance = np.moveaxis(image["radiance"], -1, 0)
        np.testing.assert_array_equal(batch["radiance"][index].numpy(), -radiance)
        np.testing.assert_array_equal(batch["object_id"][index, 0].numpy(), image["object_id"])


def test_torch_reads_linear_srgb(made):
    images = dataset.open(made)
    loader = torch.utils.data.DataLoader(images.torch(rgb=True), batch_size=2, shuffle=True)
    batches = list(loader)
    assert [len(batch["reflectance"]) for batch in batches] == [2, 1]
    single = images.torch(("reflectance",), rgb=True)[2]["reflectance"]
    np.testing.assert_array_equal(single.numpy(), np.moveaxis(images[2].rgb["reflectance"], -1, 0))
    with pytest.raises(IndexError):
        images.torch()[3]
