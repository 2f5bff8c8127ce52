"""Projections that bend straight lines: lens distortion, fisheyes, panoramas, and ray maps.

The camera's frame is `across`, to the right, `down`, and `corner`, along the axis: unit vectors.
"""

import math

from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.passes import FilmPoint, Ray

NOWHERE = (0.0, 0.0, 0.0)  # Direction of the ray through a film point that no light reaches
UNSEEN = FilmPoint(0.0, 0.0, 0.0)  # Film point of what a camera cannot see
ON_RAY = 1e-6  # Angle by which a ray may miss a point that it leads to, radians
MOST_STEPS = 64
CLOSE = 1e-15  # Error of a root, in units of the image, relative to its size if above 1


@jit
def _in_image(projection, x, y):
    """Return a film point in units of the image, from where the axis meets it."""
    return (
        (x - projection.center[0]) / projection.focal[0],
        (y - projection.center[1]) / projection.focal[1],
    )


@jit
def _in_frame(camera, right, down, ahead):
    """Return a direction from its components in the camera's frame."""
    sideways = vec.add(vec.scale(camera.across, right), vec.scale(camera.down, down))
    return vec.add(vec.scale(camera.corner, ahead), sideways)


@jit
def _into_frame(camera, point):
    """Return the components (right, down, ahead) of where a point lies, seen from the camera."""
    step = vec.sub(point, camera.origin)
    return vec.dot(step, camera.across), vec.dot(step, camera.down), vec.dot(step, camera.corner)


@jit
def _on_film(projection, a, b, density):
    """Return the `FilmPoint` of a point in units of the image, where its density is 1 per these."""
    focal, center = projection.focal, projection.center
    density *= abs(focal[0] * focal[1])
    return FilmPoint(center[0] + focal[0] * a, center[1] + focal[1] * b, density)


@jit
def panorama_ray(camera, x, y):
    """Return the ray of an equirectangular panorama: longitude across, latitude down."""
    longitude, latitude = _in_image(camera.optics.projection, x, y)
    level, down = math.cos(latitude), math.sin(latitude)
    right, ahead = level * math.sin(longitude), level * math.cos(longitude)
    return Ray(camera.origin, _in_frame(camera, right, down, ahead))


@jit
def panorama_point(camera, point):
    """Return the `FilmPoint` of a point: a panorama stretches circles of latitude alike."""
    right, down, ahead = _into_frame(camera, point)
    level, squared = math.hypot(right, ahead), right * right + down * down + ahead * ahead
    if level == 0.0:
        return UNSEEN
    longitude, latitude = math.atan2(right, ahead), math.atan2(down, level)
    density = 1.0 / (level * math.sqrt(squared))
    return _on_film(camera.optics.projection, longitude, latitude, density)


@jit
def _fisheye_radius(k, angle):
    """Return θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸) of the angle θ from the axis, and its slope."""
    z = angle * angle
    radius = angle * (1.0 + z * (k[0] + z * (k[1] + z * (k[2] + z * k[3]))))
    slope = 1.0 + z * (3 * k[0] + z * (5 * k[1] + z * (7 * k[2] + z * 9 * k[3])))
    return radius, slope


@jit
def _fisheye_angle(projection, radius):
    """Return the angle from the axis of a radius."""
    # By Newton's method between bounds: up to the largest angle the radius increases with it.
    k, low, high = projection.distortion, 0.0, projection.reach[1]
    angle = min(radius, high)
    for _ in range(MOST_STEPS):
        reached, slope = _fisheye_radius(k, angle)
        error = reached - radius
        if abs(error) <= CLOSE * max(radius, 1.0):
            break
        if error > 0.0:
            high = angle
        else:
            low = angle
        angle -= error / slope
        if not low < angle < high:
            angle = 0.5 * (low + high)
    return angle


@jit
def fisheye_ray(camera, x, y):
    """Return the ray of a fisheye; none leads beyond its largest angle."""
    projection = camera.optics.projection
    a, b = _in_image(projection, x, y)
    radius = math.hypot(a, b)
    if radius > projection.reach[0]:
        return Ray(camera.origin, NOWHERE)
    if radius == 0.0:
        return Ray(camera.origin, camera.corner)
    angle = _fisheye_angle(projection, radius)
    sine = math.sin(angle) / radius
    return Ray(camera.origin, _in_frame(camera, sine * a, sine * b, math.cos(angle)))


@jit
def fisheye_point(camera, point):
    """Return the `FilmPoint` of a point."""
    projection = camera.optics.projection
    right, down, ahead = _into_frame(camera, point)
    level, squared = math.hypot(right, down), right * right + down * down + ahead * ahead
    angle = math.atan2(level, ahead)
    if angle > projection.reach[1] or level == 0.0:
        return UNSEEN
    radius, slope = _fisheye_radius(projection.distortion, angle)
    a, b = radius * right / level, radius * down / level
    density = radius * slope / (level * math.sqrt(squared))
    return _on_film(projection, a, b, density)


@jit
def _first_guess(table, s, t):
    """Look up an undistorted point, about, in (rows, columns, 2) at fractions of the image."""
    x, y = s * (table.shape[1] - 1), t * (table.shape[0] - 1)
    column = min(max(int(x), 0), table.shape[1] - 2)
    row = min(max(int(y), 0), table.shape[0] - 2)
    x, y = x - column, y - row
    guess = (0.0, 0.0)
    for i in range(2):
        for j in range(2):
            weight = (y if i else 1.0 - y) * (x if j else 1.0 - x)
            across, down = table[row + i, column + j, 0], table[row + i, column + j, 1]
            guess = guess[0] + weight * across, guess[1] + weight * down
    return guess


@jit
def _distort(distortion, x, y):
    """Return where Brown's and Conrady's distortion moves a point, and the derivatives of that."""
    # OpenCV's k1, k2, p1, p2, k3. Derivatives are along both ways, and across, where both are
    # equal.
    k1, k2, p1, p2, k3 = distortion
    z = x * x + y * y
    radial = 1.0 + z * (k1 + z * (k2 + z * k3))
    slope = 2.0 * (k1 + z * (2.0 * k2 + z * 3.0 * k3))
    right = x * radial + 2.0 * p1 * x * y + p2 * (z + 2.0 * x * x)
    down = y * radial + p1 * (z + 2.0 * y * y) + 2.0 * p2 * x * y
    xx = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    xy = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    yy = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    return (right, down), (xx, yy, xy)


@jit
def undistort(distortion, target, guess):
    """Return the point that distortion moves to `target`, by Newton's method."""
    x, y = guess
    for _ in range(MOST_STEPS):
        moved, (xx, yy, xy) = _distort(distortion, x, y)
        right, down = moved[0] - target[0], moved[1] - target[1]
        if abs(right) + abs(down) <= CLOSE * max(abs(x) + abs(y), 1.0):
            break
        area = xx * yy - xy * xy
        x, y = x - (yy * right - xy * down) / area, y - (xx * down - xy * right) / area
    return x, y


@jit
def distorted_ray(camera, x, y):
    """Return the ray of a pinhole with lens distortion; `reach` is the image's size in pixels."""
    projection = camera.optics.projection
    size = projection.reach
    guess = _first_guess(projection.table, x / size[0], y / size[1])
    right, down = undistort(projection.distortion, _in_image(projection, x, y), guess)
    return Ray(camera.origin, _in_frame(camera, right, down, 1.0))


@jit
def distorted_point(camera, point):
    """Return the `FilmPoint` of a point in view.

    Far outside the image distortion may fold back into it: such a point is unseen, as the ray
    through that film point goes elsewhere.
    """
    projection = camera.optics.projection
    right, down, ahead = _into_frame(camera, point)
    if ahead <= 0.0:
        return UNSEEN
    x, y = right / ahead, down / ahead
    (a, b), (xx, yy, xy) = _distort(projection.distortion, x, y)
    density = (xx * yy - xy * xy) * math.sqrt(1.0 + x * x + y * y) / (ahead * ahead)
    seen = _on_film(projection, a, b, density)
    return seen if density > 0.0 and _is_on_ray(camera, seen, point) else UNSEEN


@jit
def _is_on_ray(camera, seen, point):
    """Return whether the ray through a film point of the image leads to a point."""
    size = camera.optics.projection.reach
    if not (0.0 <= seen.x < size[0] and 0.0 <= seen.y < size[1]):
        return False
    direction, step = distorted_ray(camera, seen.x, seen.y).direction, vec.sub(point, camera.origin)
    off = vec.cross(direction, step)
    lengths = vec.dot(direction, direction) * vec.dot(step, step)
    return vec.dot(off, off) <= ON_RAY * ON_RAY * lengths


@jit
def _between(table, row, column, fractions, first):
    """Return three values of a table from `first` on, interpolated between four pixels."""
    s, t = fractions
    found = (0.0, 0.0, 0.0)
    for i in range(2):
        for j in range(2):
            weight = (t if i else 1.0 - t) * (s if j else 1.0 - s)
            if weight != 0.0:
                at, beside = row + i, column + j
                x, y = table[at, beside, first], table[at, beside, first + 1]
                part = x, y, table[at, beside, first + 2]
                found = vec.add(found, vec.scale(part, weight))
    return found


@jit
def mapped_ray(camera, x, y):
    """Return a ray between those of pixels' centres; beyond the outermost, extrapolated."""
    table = camera.optics.projection.table
    rows, columns = table.shape[0], table.shape[1]
    x, y = x - 0.5, y - 0.5
    column = max(min(int(x), columns - 2), 0)
    row = max(min(int(y), rows - 2), 0)
    s = x - column if columns > 1 else 0.0
    t = y - row if rows > 1 else 0.0
    fractions = (s, t)
    return Ray(
        _between(table, row, column, fractions, 0), _between(table, row, column, fractions, 3)
    )
