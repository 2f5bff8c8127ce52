"""Pixels for whose indirect light no photon was found."""

from dataclasses import replace

import pytest

import photonmap as pm

BOX = pm.scenes.cornell_box()
MIRRORS = ("left", "right", "back", "ceiling")


def mirrored(color):
    """Return the box in grey, most walls mirrors, in light of one colour."""
    grey, mirror = pm.Material("grey", 0.5), pm.Material.polished("mirror", 0.9)
    meshes = []
    for mesh in BOX.meshes:
        material = mirror if mesh.name in MIRRORS else grey
        if mesh.name == "light":
            material = replace(mesh.material, emission=color)
        meshes.append(replace(mesh, material=material))
    return pm.Scene(meshes, camera=BOX.camera)


@pytest.mark.parametrize("color", [[10, 0, 0], [0, 0, 10]])
def test_light_of_any_band_resolves_what_mirrors_show(color):
    result = pm.render(mirrored(color), bands=3, size=32, passes=1, photons=150, seed=3)
    assert result.record["unresolved"] == 0
