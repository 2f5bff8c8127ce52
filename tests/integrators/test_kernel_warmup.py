"""The scene of one triangle by which kernels are compiled ahead needs what the scene needs."""

import pytest

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.integrators.kernel_warmup import _setup, _smallest
from photonmap.integrators.photon_mapping.integrator import PhotonIntegrator
from photonmap.runtime.workers import Workers
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()
SCENES = {
    "box": pm.scenes.cornell_box,
    "balls": pm.scenes.cornell_balls,
}


@pytest.mark.parametrize("name", SCENES)
def test_photons_hit_the_triangle(name):
    """Else paths would take their place, and the cache's kernels be compiled in the first pass."""
    small = _smallest(compile_scene(SCENES[name](), RGB))
    with Workers(1) as workers:
        assert not PhotonIntegrator(_setup(small, RGB, workers)).traces_paths_instead


@pytest.mark.parametrize("name", SCENES)
def test_the_same_records_are_there(name):
    wanted = compile_scene(SCENES[name](), RGB)
    stand_in = compile_scene(_smallest(wanted), RGB)
    for record in ("specular", "scattering", "textures"):
        assert (getattr(wanted, record) is None) == (getattr(stand_in, record) is None)
