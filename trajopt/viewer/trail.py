"""Trail: the line that a tool draws along a motion."""

from typing import TYPE_CHECKING

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.viewer.palette import Rgb

if TYPE_CHECKING:
    from viser import ViserServer

POINTS = 41
"""Of the line: two metres of it are drawn in pieces of 5 cm, which look round."""


class Trail:
    """A line in the page, as thick on the screen from near as from afar."""

    def __init__(self, server: "ViserServer", node: str, colour: Rgb, thickness: float) -> None:
        """Prepare it, so thick on the screen [px]; nothing is shown yet."""
        self._line = server.scene.add_line_segments(
            node,
            np.zeros((POINTS - 1, 2, 3), dtype=np.float32),
            colour,
            thickness=thickness,
            thickness_units="screen",
            visible=False,
        )

    def show(self, points: Floats | None) -> None:
        """Show the line through points of shape (k, 3) [m], or none."""
        self._line.visible = points is not None
        if points is not None:
            self._line.points = np.stack((points[:-1], points[1:]), axis=1).astype(np.float32)
