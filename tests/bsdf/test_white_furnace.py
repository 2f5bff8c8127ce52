"""What is white reflects all light: each model over each base, and between the steps of tables."""

import pytest
from bsdf_harness import FRAME, Case, departure, directional_albedo, evaluate, furnace, hemisphere

VIEWS = (1.0, 0.6, 0.2, 0.05)
"""Cosines of the angles to the normal."""
BASES = {
    "white paint": Case("Lambertian", albedo=(1.0,) * 3),
    "white polished plastic": Case("glossy", (1e-3,), (1.0,) * 3, (0.04,) * 3),
    "white matt plastic": Case("glossy", (0.4,), (1.0,) * 3, (0.08,) * 3),
    "polished metal": Case("glossy", (1e-3,), (0.0,) * 3, (1.0,) * 3),
    "brushed metal": Case("glossy", (0.05,), (0.0,) * 3, (1.0,) * 3),
    "matt metal": Case("glossy", (0.5,), (0.0,) * 3, (1.0,) * 3),
}
CLAY = Case("rough diffuse", (1.0,), (1.0,) * 3)
COATS = [(1.0, 0.0, 1.5), (0.5, 0.3, 1.5), (1.0, 0.7, 2.0)]
LOBES = [(0.0, 0.0), (0.2, 0.0), (1.0, 0.0), (0.04, 1.5), (0.25, 3.0)]
"""Reflectance at normal incidence, and index of refraction."""
SAMPLED = {
    "lobe": [
        Case("glossy", (alpha,), (1.0,) * 3, (f0,) * 3, index=index)
        for alpha in (1e-3, 0.01, 0.05, 0.3, 1.0)
        for f0, index in LOBES
    ],
    "metal in part": [
        Case(
            "glossy",
            (alpha,),
            (1.0 - metal,) * 3,
            (metal + (1.0 - metal) * coat,) * 3,
            covering=coat,
        )
        for alpha in (1e-3, 0.05, 0.3, 1.0)
        for metal in (0.2, 0.6, 1.0)
        for coat in (0.0, 0.04, 0.2)
    ],
    "roughness by an image": [
        Case("glossy", (roughness**2,), (1.0,) * 3, (0.2,) * 3, is_textured=True)
        for roughness in (0.05, 0.11, 0.39, 0.98)
    ],
    "coat": [base._replace(coat=coat) for base in BASES.values() for coat in COATS],
    "coat by an image": [
        base._replace(coat=(1.0, roughness, 1.5), is_coat_textured=True)
        for base in BASES.values()
        for roughness in (0.0, 0.11, 0.82)
    ],
    "sheen": [
        base._replace(sheen=(color, roughness))
        for base in (*BASES.values(), CLAY)
        for color, roughness in ((1.0, 0.0), (0.37, 0.2), (1.0, 0.5), (0.37, 1.0))
    ],
}


@pytest.mark.parametrize("name", SAMPLED)
def test_by_samples(name):
    for case in SAMPLED[name]:
        for cosine in VIEWS:
            mean, error = furnace(case, cosine)
            assert abs(mean - 1.0) < 0.005 + 4.0 * error, (case, cosine)


@pytest.mark.parametrize("base", ["white paint", "white matt plastic", "matt metal", "white clay"])
def test_sheen_by_quadrature(base):
    """Wide lobes to within 0.1%, at any colour between those for which there are tables."""
    for roughness in (0.1, 0.6, 1.0):
        for color in (0.03, 0.37, 1.0):
            case = (BASES | {"white clay": CLAY})[base]._replace(sheen=(color, roughness))
            for cosine in (1.0, 0.1, 0.03):
                assert directional_albedo(case, cosine)[0] == pytest.approx(1.0, abs=1e-3)


METAL = {"albedo": (0.0,) * 3, "specular": (1.0, 1.0, 1.0)}
"""That loses nothing."""
BRUSHED = [
    Case("glossy", (0.1,), anisotropy=(0.5, 0.0), **METAL),
    Case("glossy", (0.3,), anisotropy=(0.7, 0.15), **METAL),
    Case("glossy", (0.05,), anisotropy=(1.0, 0.25), **METAL),
    Case("glossy", (0.1,), anisotropy=(0.9, 0.15), is_brushed=True, **METAL),
]
"""The last at a strength between those of the tables."""


@pytest.mark.parametrize("case", BRUSHED)
def test_brushed_metal_from_every_azimuth(case):
    """By a quadrature fine enough for the lobe."""
    for cosine in (1.0, 0.3):
        wi, solid_angles = hemisphere(cosine, 80, 480)
        for azimuth in (0.0, 0.6, 1.3, 2.5):
            values, _ = evaluate(case, wi, departure(cosine, azimuth))
            total = (values[:, 0] * (wi @ FRAME[2]) * solid_angles).sum()
            assert total == pytest.approx(1.0, abs=0.005), (cosine, azimuth)
