"""Name lights that send nothing into the view: wound the wrong way, or buried in a wall."""

import numpy as np

from photonmap.errors import warn
from photonmap.kernels.probe import reaches_view, view_points
from photonmap.kernels.records import Film, Lights
from photonmap.messages import listed
from photonmap.prepare import Prepared

POINTS = 64
PATHS, FEWEST_PATHS, MOST_PATHS = 256, 16, 1 << 14
"""From a light; where there are many, as few as this; and from all, about."""
BOUNCES = 8


def warn_of_hidden_lights(prepared: Prepared, film: Film, key: np.uint64) -> list[str]:
    """Warn of the lights none of whose probing paths reaches a point that the camera sees.

    Every light sends up to 256 paths of up to 8 bounces; each of their vertices is joined to 64
    points in view until one connection is free. A light that lights the view costs a few rays.
    Where there are smooth surfaces nothing is said: light may come by them, and be seen in them.

    Returns
    -------
    names of these lights
    """
    if prepared.optics is not None:
        return []
    points, normals = np.zeros((POINTS, 3)), np.zeros((POINTS, 3))
    camera = prepared.film_camera(film.width, film.height)
    count = view_points(prepared.geometry, camera, film, key, points, normals)
    if count == 0:
        return []
    emitters: dict[str, list[int]] = {}
    for emitter, name in enumerate(prepared.light_names):
        emitters.setdefault(name, []).append(emitter)
    paths = int(np.clip(MOST_PATHS // len(emitters), FEWEST_PATHS, PATHS))
    hidden = []
    for name, members in emitters.items():
        lights = _only(prepared.lights, np.array(members))
        if not reaches_view(prepared.geometry, lights, key, paths, BOUNCES, points, normals, count):
            hidden.append(name)
    if hidden:
        each = "it" if len(hidden) == 1 else "each"
        warn(
            f"light {listed(hidden)} sends nothing into the view: all of {paths} paths from {each} "
            f"were blocked or lost; is it wound the wrong way, or buried in a wall?"
        )
    return hidden


def _only(lights: Lights, members: np.ndarray) -> Lights:
    """Return some emitters of one light alone, chosen in proportion to power."""
    chance = np.diff(lights.cumulative, prepend=0.0)[members]
    cumulative = np.cumsum(chance) / chance.sum()
    cumulative[-1] = 1.0
    return lights._replace(
        kind=lights.kind[members],
        triangle=lights.triangle[members],
        position=lights.position[members],
        axis=lights.axis[members],
        cosines=lights.cosines[members],
        area=lights.area[members],
        spectrum=lights.spectrum[members],
        cumulative=cumulative,
        dome=int(np.argmax(members == lights.dome)) if lights.dome in members else -1,
        tree=None,
    )
