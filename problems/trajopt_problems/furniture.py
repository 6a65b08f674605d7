"""Objects made of several boxes: hollow boxes with openings, shelves, tables."""

from collections.abc import Collection

import trajopt as to

Parts = list[tuple[to.Box, to.Placement]]
"""Boxes and their placements in the object's frame."""

WALL = 0.02
"""Thickness of walls and boards [m]."""


def hollow_box(
    size: tuple[float, float, float],
    *,
    open_sides: Collection[str] = (),
    mouth: tuple[float, float] | None = None,
) -> Parts:
    """Return the walls of a box around the origin.

    Args:
        size: Inner length, width and height, along x, y and z [m].
        open_sides: Walls to leave out, of "-x", "+x", "-y", "+y", "-z" and "+z".
        mouth: Inner length and width of a hole in the middle of the wall "+z" [m].
    """
    x, y, z = size
    lid = (0.0, 0.0, (z + WALL) / 2)
    walls = {
        "-x": (to.Box(WALL, y + 2 * WALL, z), (-(x + WALL) / 2, 0.0, 0.0)),
        "+x": (to.Box(WALL, y + 2 * WALL, z), ((x + WALL) / 2, 0.0, 0.0)),
        "-y": (to.Box(x, WALL, z), (0.0, -(y + WALL) / 2, 0.0)),
        "+y": (to.Box(x, WALL, z), (0.0, (y + WALL) / 2, 0.0)),
        "-z": (to.Box(x + 2 * WALL, y + 2 * WALL, WALL), (0.0, 0.0, -(z + WALL) / 2)),
        "+z": (to.Box(x + 2 * WALL, y + 2 * WALL, WALL), lid),
    }
    left_out = {*open_sides, *(() if mouth is None else ("+z",))}
    parts: Parts = [(box, to.placement(at)) for side, (box, at) in walls.items() if side not in left_out]
    if mouth is not None:
        parts += _rim(x + 2 * WALL, y + 2 * WALL, mouth, lid[2])
    return parts


def _rim(length: float, width: float, mouth: tuple[float, float], height: float) -> Parts:
    """Return a plate of length x width at a height with a hole in its middle [m]."""
    along, across = (length - mouth[0]) / 2, (width - mouth[1]) / 2
    return [
        (to.Box(along, width, WALL), to.placement((side * (length - along) / 2, 0.0, height)))
        for side in (-1, 1)
    ] + [
        (to.Box(mouth[0], across, WALL), to.placement((0.0, side * (width - across) / 2, height)))
        for side in (-1, 1)
    ]


def shelf(*, width: float, depth: float, levels: int, spacing: float) -> Parts:
    """Return a shelf that stands on the plane z = 0, open towards -x, its back at +x.

    Args:
        width: Inner width along y [m].
        depth: Inner depth along x, from 0 to `depth` [m].
        levels: Number of storeys.
        spacing: Clear height of a storey [m].
    """
    pitch = spacing + WALL
    height = levels * pitch + WALL
    parts: Parts = [
        (to.Box(depth, WALL, height), to.placement((depth / 2, side * (width + WALL) / 2, height / 2)))
        for side in (-1, 1)
    ]
    parts.append((to.Box(WALL, width + 2 * WALL, height), to.placement((depth + WALL / 2, 0.0, height / 2))))
    for level in range(levels + 1):
        board = to.placement((depth / 2, 0.0, level * pitch + WALL / 2))
        parts.append((to.Box(depth, width, WALL), board))
    return parts


def table(*, length: float, width: float, height: float) -> Parts:
    """Return a table with four legs on the plane z = 0, its top's upper face at `height` [m]."""
    top = (to.Box(length, width, 0.03), to.placement((0.0, 0.0, height - 0.015)))
    legs = [
        (
            to.Box(0.04, 0.04, height - 0.03),
            to.placement((x * (length / 2 - 0.04), y * (width / 2 - 0.04), (height - 0.03) / 2)),
        )
        for x in (-1, 1)
        for y in (-1, 1)
    ]
    return [top, *legs]
