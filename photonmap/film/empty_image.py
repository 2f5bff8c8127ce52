"""Warnings of images in which there is nothing, or no light."""

from photonmap.errors import warn
from photonmap.film.moments import Accumulator


def warn_of_empty_image(moments: Accumulator, expects_light: bool) -> None:
    """Warn where the camera sees nothing, or only surfaces to which no light comes.

    Parameters
    ----------
    moments : of a whole render
    expects_light : whether direct light is simulated, and a light seems to reach the view
    """
    if moments.shows_nothing():
        warn("the camera sees nothing; check its origin and target, or give no camera")
    elif expects_light and moments.is_unlit():
        warn(
            "no light reaches what the camera sees: direct and indirect light are 0 everywhere; "
            "check the winding of area lights, where other lights shine, and that the camera is "
            "not inside an object"
        )
