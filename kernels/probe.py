"""Whether light from an emitter can reach what the camera sees."""

from photonmap.kernels import vec, warp
from photonmap.kernels.film import camera_ray
from photonmap.kernels.jit import jit, kernel
from photonmap.kernels.light import emit, sample_direct
from photonmap.kernels.opaque import blocked, hit
from photonmap.kernels.rng import draw, stream
from photonmap.kernels.surface import meet


@kernel
def view_points(geometry, camera, film, key, points, normals):
    """Fill points and normals, (n, 3), with random first hits; return how many were found."""
    count = 0
    for attempt in range(4 * len(points)):
        state = stream(key, 0, attempt)
        x, state = draw(state)
        y, state = draw(state)
        direction = camera_ray(camera, x * film.width, y * film.height)
        triangle, u, v, _ = hit(geometry, camera.origin, direction)
        if triangle >= 0 and count < len(points):
            point, ng, _, _ = meet(geometry, triangle, u, v, direction)
            for axis in range(3):
                points[count, axis], normals[count, axis] = point[axis], ng[axis]
            count += 1
    return count


@jit
def _sees(geometry, point, ng, points, normals, count, start):
    """Tell whether a surface point sees the front of any of `count` view points."""
    for step in range(count):
        i = (start + step) % count
        segment = vec.sub(vec.row(points, i), point)
        if vec.dot(segment, ng) <= 0.0 or vec.dot(segment, vec.row(normals, i)) >= 0.0:
            continue
        if not blocked(geometry, point, segment, 1.0):
            return True
    return False


@kernel
def reaches_view(geometry, lights, key, paths, bounces, points, normals, count):
    """Tell whether any of some paths from the only emitter in `lights` reaches a view point."""
    for index in range(paths):
        state = stream(key, 1, index)
        u, state = draw(state)
        v, state = draw(state)
        i = index % count
        point, ng = vec.row(points, i), vec.row(normals, i)
        if sample_direct(geometry, lights, point, ng, ng, u, v, 1, 0)[1] > 0.0:
            return True
        s, state = draw(state)
        t, state = draw(state)
        _, _, _, origin, direction = emit(geometry, lights, (u, v), (s, t))
        for _ in range(bounces):
            triangle, u, v, _ = hit(geometry, origin, direction)
            if triangle < 0:
                break
            origin, ng, _, _ = meet(geometry, triangle, u, v, direction)
            if _sees(geometry, origin, ng, points, normals, count, index):
                return True
            s, state = draw(state)
            t, state = draw(state)
            direction = vec.from_frame(warp.cosine_hemisphere(s, t), ng)
    return False
