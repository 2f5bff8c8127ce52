"""How metals reflect at all angles, by what they reflect at two: the dip of their lobes."""

from __future__ import annotations

from functools import cache

import numpy as np

from photonmap.kernels.core.metals import DIP_POWERS
from photonmap.scene.surfaces.fresnel import even_light, rise
from photonmap.spectra.curves import Floats
from photonmap.spectra.metals import EDGE_COSINE, conductor_reflectance

_NODES = 96  # Angles to which weights are fitted,
_CHECKED = 1025  # and at which the reflectance is kept between 0 and 1
_HALVINGS = 45
_BROAD = DIP_POWERS.index(4)  # The term by which reflectances at 82° differ that no index has
_LARGEST = 1.0 - 1e-9  # Reflectance at normal incidence that a complex index is looked for


def fit_dip(f0: Floats | float, edge: Floats | float) -> Floats:
    """Return the weights of the dip by which metals reflect less than Schlick's formula says.

    They are fitted to what Fresnel's equations say of the complex index that reflects so at two
    angles, normal incidence and `EDGE_COSINE`, and right at these. Where there is none, they are
    those of the nearest, and what differs at 82° fades towards other angles, so far as the
    reflectance stays between 0 and 1. Reflectances are (N,) or numbers; weights, (4, N) or (4,),
    are those of `kernels.core.fresnel.dip_terms`.
    """
    pair = np.broadcast_arrays(np.asarray(f0, float), np.asarray(edge, float))
    normal, wanted = (each.ravel() for each in pair)
    index, rest = _index_between(normal, wanted)
    cosines = np.append(even_light(_NODES)[0], EDGE_COSINE)[:, None]
    weights = _fitting() @ (_schlick(normal, cosines) - conductor_reflectance(*index, cosines))
    weights[_BROAD] += rest / dip_terms(EDGE_COSINE)[_BROAD]
    weights *= np.minimum(_most(normal, weights), 1.0)
    return weights.reshape(-1, *pair[0].shape)


def _most(f0: Floats, weights: Floats) -> Floats:
    """Return by what dips may be multiplied, lest metals reflect less than 0 or more than 1."""
    cosines = np.linspace(0.0, 1.0, _CHECKED)[1:-1]
    dip, schlick = dip_terms(cosines) @ weights, _schlick(f0, cosines[:, None])
    room = np.where(dip > 0.0, schlick, schlick - 1.0)
    return np.asarray((room / np.where(dip == 0.0, -1e-30, dip)).min(axis=0))


def _index_between(f0: Floats, edge: Floats) -> tuple[tuple[Floats, Floats], Floats]:
    """Return n and k of the nearest index by two reflectances; and by how much more it has at 82°.

    Of all that reflect `f0`, those of larger n reflect less at 82°. The bounds of n are those of
    O. Gulbrandsen, "Artist friendly metallic Fresnel", 2014.
    """
    f0 = np.minimum(f0, _LARGEST)
    root = np.sqrt(f0)
    least, most = (1.0 - f0) / (1.0 + f0), (1.0 + root) / (1.0 - root)

    def index(place: Floats | float) -> tuple[Floats, Floats]:
        n = least * (most / least) ** place
        squared = (f0 * (n + 1.0) ** 2 - (n - 1.0) ** 2) / (1.0 - f0)
        return n, np.sqrt(np.maximum(squared, 0.0))

    low, high = np.zeros_like(f0), np.ones_like(f0)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        is_low = conductor_reflectance(*index(middle), EDGE_COSINE) > edge
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
    found = index(high)
    return found, conductor_reflectance(*found, EDGE_COSINE) - edge


@cache
def _fitting() -> Floats:
    """Return the matrix that makes weights of a curve at cosines: `even_light`, and 82°.

    It is right at the last, and has least squares at the others, as much as each counts.
    """
    cosines, shares = even_light(_NODES)
    terms, at_edge = dip_terms(cosines), dip_terms(EDGE_COSINE)
    inverse = np.linalg.inv(terms.T @ (terms * shares[:, None]))
    free, bound = inverse @ (terms.T * shares), inverse @ at_edge
    bound /= at_edge @ bound
    return np.column_stack([free - np.outer(bound, at_edge @ free), bound])


def dip_terms(cosine: Floats | float) -> Floats:
    """Return `kernels.core.fresnel.dip_terms` of cosines of any shape, in a last axis of 4."""
    cosines = np.asarray(cosine)[..., None]
    return np.asarray(cosines * (1.0 - cosines) ** np.array(DIP_POWERS))


def _schlick(f0: Floats, cosine: Floats | float) -> Floats:
    return np.asarray(f0 + (1.0 - f0) * rise(np.asarray(cosine), 0.0))
