"""Whether light from an emitter can reach what the camera sees."""

from typing import NamedTuple

from photonmap.kernels.camera.cameras import first_hit, generate_ray, is_dark
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.rng import draw, stream
from photonmap.kernels.core.streams import VIEW_PATH, VIEW_POINT, split
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.geometry.opacity import intersect, occluded
from photonmap.kernels.lights.direct import prepare_direct, sample_direct
from photonmap.kernels.lights.emission import visible_emitter
from photonmap.kernels.lights.kinds import emit


class ViewPoint(NamedTuple):
    """What a light sample needs to know of a surface that the camera sees."""

    point: tuple
    site: tuple
    ng: tuple
    ns: tuple


@kernel
def find_view_points(geometry, lights, view, key, points, normals, seen):
    """Fill points and normals, (n, 3), with random first hits; return how many were found.

    Sets `seen`, (K,) bool, of the emitters that the camera itself sees there.
    """
    count, key, film = 0, split(key, VIEW_POINT), view.film
    for attempt in range(4 * len(points)):
        state = stream(key, attempt, 0)
        x, state = draw(state)
        y, state = draw(state)
        ray = generate_ray(view.camera, x * film.width, y * film.height)
        if is_dark(ray):
            continue
        hit = first_hit(geometry, ray)
        emitter, _ = visible_emitter(geometry, lights, hit, ray.direction)
        if emitter >= 0:
            seen[emitter] = True
        if hit.triangle >= 0 and count < len(points):
            surface = surface_interaction(geometry, hit, ray.direction)
            for axis in range(3):
                points[count, axis] = surface.point[axis]
                normals[count, axis] = surface.ng[axis]
            count += 1
    return count


@jit
def _sees(geometry, surface, points, normals, start):
    """Return whether a surface point sees the front of any of the view points."""
    for step in range(len(points)):
        i = (start + step) % len(points)
        segment = vec.sub(vec.row(points, i), surface.point)
        if vec.dot(segment, surface.ng) <= 0.0 or vec.dot(segment, vec.row(normals, i)) >= 0.0:
            continue
        if not occluded(geometry, surface.point, segment, 1.0):
            return True
    return False


@kernel
def reaches_view(scene, key, paths, bounces, cdf, points, normals):
    """Return whether a path from the only emitter reaches the view; cdf, (SCRATCH,), is scratch."""
    geometry, key = scene.geometry, split(key, VIEW_PATH)
    for index in range(paths):
        state = stream(key, index, 0)
        u, state = draw(state)
        v, state = draw(state)
        ng = vec.row(normals, index % len(points))
        point = vec.row(points, index % len(points))
        viewed = ViewPoint(point, point, ng, ng)
        prepare_direct(scene, viewed, cdf)
        if sample_direct(scene, viewed, cdf, u, v).weight > 0.0:
            return True
        s, state = draw(state)
        t, state = draw(state)
        start = emit(geometry, scene.lights, 0, (u, v), (s, t))
        if start.weight == 0.0:
            continue
        origin, direction = start.origin, start.direction
        for _ in range(bounces):
            hit = intersect(geometry, origin, direction)
            if hit.triangle < 0:
                break
            surface = surface_interaction(geometry, hit, direction)
            if _sees(geometry, surface, points, normals, index):
                return True
            s, state = draw(state)
            t, state = draw(state)
            origin = surface.point
            direction = vec.from_frame(warp.cosine_hemisphere(s, t), surface.ng)
    return False
