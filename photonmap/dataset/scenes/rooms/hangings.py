"""What hangs on walls: single things, and what fills a bare stretch of a wall."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from photonmap.dataset.models import bathroom, public_rooms, wall_fixtures, workshop
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import SceneObject
from photonmap.dataset.models.shapes import Random
from photonmap.dataset.scenes.rooms import groups
from photonmap.dataset.scenes.rooms.groups import draw, side_by_side

MakeHung = Callable[[Random, Palette], Sequence[SceneObject]]


def picture(rng: Random, palette: Palette) -> list[SceneObject]:
    """Return a picture."""
    return framed(rng, palette, draw(rng, 0.6, 1.7))


def clock(rng: Random, palette: Palette) -> list[SceneObject]:
    """Return a clock."""
    return [wall_fixtures.clock(palette)]


def mirror(rng: Random, palette: Palette) -> list[SceneObject]:
    """Return a mirror."""
    return [wall_fixtures.wall_mirror(palette, draw(rng, 0.22, 0.4))]


def framed(rng: Random, palette: Palette, wide: float) -> list[SceneObject]:
    """Return a picture, perhaps in a mount."""
    width = min(draw(rng, 0.55, 0.85) * wide, 1.5)
    height = min(max(width * draw(rng, 0.6, 1.3), 0.35), 1.0)
    mount = draw(rng, 0.05, 0.14) * min(width, height) if rng.random() < 0.5 else 0.0
    return [wall_fixtures.picture(rng, palette, width, height, mount)]


def row_of_pictures(rng: Random, palette: Palette, wide: float) -> list[SceneObject]:
    """Return two to four pictures of one size beside each other."""
    count = min(int(rng.integers(2, 5)), max(2, int(wide / 0.4)))
    gap = draw(rng, 0.05, 0.12)
    width = min(0.85 * wide / count - gap, 0.6)
    size = width, min(width * draw(rng, 1.0, 1.5), 0.9)
    made = [wall_fixtures.picture(rng, palette, *size, 0.1 * width) for _ in range(count)]
    return side_by_side([(each, gap) for each in made])


def posters(rng: Random, palette: Palette, wide: float) -> list[SceneObject]:
    """Return one to three posters."""
    count, gap = max(1, min(int(rng.integers(1, 4)), int(wide / 0.55))), draw(rng, 0.04, 0.2)
    width = min(0.9 * wide / count - gap, draw(rng, 0.5, 0.75))
    made = [
        wall_fixtures.poster(rng, palette, width, width * draw(rng, 1.2, 1.45))
        for _ in range(count)
    ]
    return side_by_side([(each, gap) for each in made])


def board(rng: Random, palette: Palette, wide: float) -> list[SceneObject]:
    """Return a wall shelf with vessels or books."""
    return groups.wall_board(rng, palette, min(draw(rng, 0.6, 0.9) * wide, 2.2))


def tools(rng: Random, palette: Palette, wide: float) -> list[SceneObject]:
    """Return a board with tools."""
    return [workshop.tool_board(rng, palette, min(0.9 * wide, draw(rng, 0.9, 1.8)))]


def towels(rng: Random, palette: Palette) -> list[SceneObject]:
    """Return a rail with towels."""
    return [bathroom.towel_rail(rng, palette)]


def blackboard(rng: Random, palette: Palette) -> list[SceneObject]:
    """Return a board to write on."""
    return [public_rooms.blackboard(rng, palette, draw(rng, 1.8, 2.8))]


def tool_wall(rng: Random, palette: Palette) -> list[SceneObject]:
    """Return a board with tools."""
    return [workshop.tool_board(rng, palette, draw(rng, 0.9, 1.8))]
