"""The nearest pairs in the page: a line between the nearest points of each, with their distance."""

from typing import TYPE_CHECKING

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.viewer import palette
from trajopt.viewer.clearance import ClearanceQuery, Nearest

if TYPE_CHECKING:
    from viser import LabelHandle, LineSegmentsHandle, ViserServer

PAIRS = 3
"""Number of marked pairs: more would hide the robot."""


class NearestDrawing:
    """Lines and labels."""

    def __init__(self, server: "ViserServer") -> None:
        """Prepare them; nothing is shown yet."""
        self._server = server
        self._lines: list[LineSegmentsHandle] = []
        self._labels: list[LabelHandle] = []
        for count in range(PAIRS):
            line = server.scene.add_line_segments(
                f"/nearest/line_{count}",
                np.zeros((1, 2, 3), dtype=np.float32),
                palette.SAFE,
                thickness=3.0,
                thickness_units="screen",
                visible=False,
            )
            label = server.scene.add_label(
                f"/nearest/label_{count}", "", anchor="bottom-center", font_screen_scale=0.8, visible=False
            )
            self._lines.append(line)
            self._labels.append(label)

    def show(self, pairs: tuple[Nearest, ...]) -> None:
        """Point out these pairs, `PAIRS` of them at most."""
        with self._server.atomic():
            for place, (line, label) in enumerate(zip(self._lines, self._labels, strict=True)):
                line.visible = label.visible = place < len(pairs)
                if place >= len(pairs):
                    continue
                near = pairs[place]
                line.points = near.points[None].astype(np.float32)
                line.colors = np.array(colour_of(near), dtype=np.uint8)
                label.position = near.points.mean(axis=0)
                label.text = f"{1000.0 * near.distance:.3g} mm" if near.distance > 0.0 else "contact"


def colour_of(near: Nearest) -> palette.Rgb:
    """Return the colour of a clearance: below the required one, below the margin, or sufficient."""
    if near.distance <= max(near.required, 0.0):
        return palette.TOUCHING
    return palette.NARROW if near.distance < near.margin else palette.SAFE


MEASURED = 24
"""Pairs that are measured to find those with something around the robot among them."""
CLOSE = 0.03
"""Pairs of links farther apart are not marked: some links are always near each other [m]."""


def telling_pairs(clearance: ClearanceQuery, positions: Floats, count: int) -> tuple[Nearest, ...]:
    """Return the nearest pairs at a posture, the nearest first.

    Args:
        clearance: Measures them.
        positions: Of the group, shape (n,) [rad | m].
        count: Largest number of pairs.
    """
    found = clearance.nearest_pairs(0.0, positions, MEASURED)
    objects = clearance.reduced.scene.objects.keys()
    apart = [each for each in found if each.distance < CLOSE or not objects.isdisjoint(each.owners)]
    return tuple((apart or found)[:count])
