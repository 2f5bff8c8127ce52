"""Random numbers: no two uses share a key, and indices above 2³² are not cut to 32 bits."""

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from photonmap.integrators.base import stream_key
from photonmap.kernels.core import rng, streams
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.core.passes import SampleBudget
from photonmap.kernels.integrators import specular_view
from photonmap.kernels.integrators.final_gather import fill_directions

SEEDS = (0, 1, 2, 11, 2**31, 2**63 - 1)
PASSES = (0, 1, 2, 10, 11, 1000)
KEY = np.uint64(0x123456789ABCDEF)
USES = [name for name, value in vars(streams).items() if name.isupper() and isinstance(value, int)]


@kernel
def _fill_points(key, indices, out):
    for i in range(len(indices)):
        out[i, 0], out[i, 1] = rng.sobol_2d(indices[i], key)


@kernel
def _fill_block(key, first, out):
    rng.sobol_block(first, key, out)


@kernel
def _fill_directions(key, first, out):
    fill_directions((0.0, 0.0, 1.0), first, key, out)


@kernel
def _fill_keys(key, uses, out):
    for i in range(len(uses)):
        out[i] = streams.split(key, uses[i])


def points_at(indices, key=KEY):
    """Return points of the unit square, (n, 2), by 64-bit indices."""
    out = np.empty((len(indices), 2))
    _fill_points(np.uint64(key), np.array(indices, np.uint64), out)
    return out


def lanes_at(first, fill, rows):
    out = np.empty((rows, 8))
    fill(KEY, np.uint64(first), out)
    return out


def count_distinct(rows):
    return len(np.unique(np.asarray(rows), axis=0))


def test_every_domain_has_its_own_key():
    """For all seeds and passes: no two keys of 64 bits are the same."""
    cases = list(product(SEEDS, PASSES, streams.Domain))
    keys = {int(stream_key(*case)) for case in cases}
    assert len(streams.Domain) == len(streams.Domain.__members__)
    assert len(keys) == len(cases)


def test_every_use_within_a_kernel_has_its_own_key():
    assert len(USES) >= 20
    values = np.array([getattr(streams, name) for name in USES])
    assert len(set(values.tolist())) == len(USES)
    keys = []
    for case in product(SEEDS, PASSES, streams.Domain):
        out = np.empty(len(values), np.uint64)
        _fill_keys(stream_key(*case), values, out)
        keys += [int(stream_key(*case)), *map(int, out)]
    assert len(set(keys)) == len(keys)


@pytest.mark.parametrize("index", [0, 1, 12345, 2**32 - 1])
@pytest.mark.parametrize("block", [1, 2, 2**8, 2**20, 2**31])
def test_an_index_above_32_bits_has_a_point_of_its_own(index, block):
    low, high = points_at([index, index + block * 2**32])
    assert (low != high).all()
    assert ((high >= 0.0) & (high < 1.0)).all()


@pytest.mark.parametrize("fill", [_fill_block, _fill_directions], ids=["points", "directions"])
def test_a_block_above_32_bits_has_points_of_its_own(fill):
    rows = 2 if fill is _fill_block else 3
    blocks = [lanes_at(8 + block * 2**32, fill, rows) for block in (0, 1, 2, 2**8, 2**31)]
    assert count_distinct(np.concatenate([block.T for block in blocks])) == 8 * len(blocks)


@pytest.mark.parametrize("first", [2**32, 2**40 + 16, 2**48 + 2**33 + 8])
def test_a_block_above_32_bits_holds_the_points_one_by_one(first):
    block = lanes_at(first, _fill_block, 2)
    np.testing.assert_array_equal(block.T, points_at([first + lane for lane in range(8)]))


def test_points_above_32_bits_are_stratified_too():
    """256 points of an aligned block lie one in each of 16 × 16 boxes."""
    points = points_at([3 * 2**40 + 512 + i for i in range(256)])
    boxes = (points * 16.0).astype(int)
    assert count_distinct(boxes) == 256


@pytest.fixture
def places(monkeypatch):
    """Follow a camera ray along a chain of coated mirrors; return the number of each surface."""
    monkeypatch.setattr(specular_view, "_light_of", specular_view._light_of.py_func)

    def follow(index, steps):
        seen = []

        def step_on(scene, met, numbers, step, before, state, flux, throughput):
            return step + 1 < steps + 1, *met, state

        def add_light(scene, photon_maps, surface, place, budget, keys, shifts, scratch):
            seen.append(place)

        nothing = lambda *_: None  # noqa: E731
        monkeypatch.setattr(specular_view, "specular_step", step_on)
        monkeypatch.setattr(specular_view, "estimate_irradiance", add_light)
        monkeypatch.setattr(specular_view, "is_rough", lambda *given: False)
        monkeypatch.setattr(specular_view, "stream", lambda *given: KEY)
        for name in (
            "absorb",
            "add_disks",
            "_add_radiance",
            "_add_emission",
            "_scattering_numbers",
        ):
            monkeypatch.setattr(specular_view, name, nothing)
        for name in ("light_keys", "surface_interaction"):
            monkeypatch.setattr(specular_view, name, nothing)
        specular = SimpleNamespace(kind=[1], probability=[0.5], alpha=())
        geometry = SimpleNamespace(material=[0])
        scene = SimpleNamespace(geometry=geometry, scattering=None, specular=specular)
        photon_maps = SimpleNamespace(caustics=())
        job = SimpleNamespace(scene=scene, photon_maps=photon_maps, key=KEY)
        pixels = SimpleNamespace(emission=None, lookups=np.zeros(1, np.uint8))
        estimate = SimpleNamespace(pixels=pixels, via_specular=None)
        own = SimpleNamespace(chain=np.empty(1, np.float32), rays=np.zeros(5, np.int64))
        scratches = SimpleNamespace(own=own)
        sight = (SimpleNamespace(triangle=0), (0.0, 0.0, 1.0))
        one, lobes = SampleBudget(1, 1), specular_view.ALL_LOBES
        chain = specular_view.Chain(KEY, np.uint64(index), 0, 1.0, one, lobes)
        specular_view._view_along.py_func(job, sight, chain, estimate, scratches)
        return seen

    return follow


@pytest.mark.parametrize("rays", [1, 4, 255])
def test_surfaces_along_a_specular_chain_have_points_of_their_own(places, rays):
    """Once, the number of a surface overflowed 32 bits: all along a chain had the same points."""
    indices = (0, 1, 2**20, 2**24, 2**32 - 1, 2**32, 2**39)
    numbers = [place for index in indices for place in (index, *places(index, 256))]
    assert len(numbers) == len(indices) * 257
    assert len(set(map(int, numbers))) == len(numbers)
    first = [int(number) * rays for number in numbers]
    assert max(first) + rays < 2**64
    assert count_distinct(points_at(first)) == len(numbers)
