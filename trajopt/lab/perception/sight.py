"""What a depth image sees through: the space between the camera and what it measured."""

from dataclasses import dataclass

import numpy as np

from trajopt.lab.perception.depth_image import DepthImage
from trajopt.lab.perception.sensing import Sensing
from trajopt.scene.camera import Singles
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.values.placement import Placement

ENOUGH = 0.5
"""Of pixels that measured nothing among others that did, this share decides: a hole is bridged, and what was
seen before is forgotten, where more of the pixels around, or on it, measured something."""


@dataclass(frozen=True, eq=False)
class Sight:
    """What one image sees through.

    Each pixel sees up to what it measured, less its noise; up to the end of its range where it says that
    nothing is in range; and nothing where it measured nothing.

    Attributes:
        image: The image.
        where: Of the camera's optical frame in the world.
        least: The smallest depth that is seen in squares of 1, 2, 4, ... pixels, by their first pixel [m].
        holes: How many pixels above and left of each measured nothing, shape (height + 1, width + 1).
    """

    image: DepthImage
    where: Placement
    least: tuple[Singles, ...]
    holes: Ints

    @staticmethod
    def of(image: DepthImage, scene: Scene, sensing: Sensing, *, holes_are_clear: bool) -> "Sight":
        """Look at an image.

        Args:
            image: The image.
            scene: The robot that has the camera.
            sensing: Says how much noise there may be.
            holes_are_clear: Whether a pixel that measured nothing hides nothing by itself.
        """
        camera, depth = image.camera, image.metres
        with np.errstate(invalid="ignore"):
            hole = ~(depth > 0.0)
            far = np.minimum(depth, np.float32(camera.farthest))
            seen = far - camera.noise.sigmas(far) * np.float32(sensing.sigmas) - np.float32(image.rounding)
        seen = np.where(hole, np.float32(np.inf if holes_are_clear else 0.0), seen).astype(np.float32)
        if sensing.bridged and not holes_are_clear:
            seen = _bridged(seen, sensing.bridged)
        levels = [seen]
        while min(levels[-1].shape) > (step := 1 << (len(levels) - 1)):
            last = levels[-1]
            down = np.minimum(last[:-step], last[step:])
            levels.append(np.minimum(down[:, :-step], down[:, step:]))
        table = np.zeros((hole.shape[0] + 1, hole.shape[1] + 1), dtype=np.int64)
        np.cumsum(np.cumsum(hole, axis=0), axis=1, out=table[1:, 1:])
        return Sight(image, image.where(scene), tuple(levels), table)

    def through(self, points: Floats, radius: float) -> Bools:
        """Say which balls it sees through: all pixels that look at one measured something behind it.

        Args:
            points: Centres, shape (n, 3) in the world [m].
            radius: Of the balls [m].
        """
        lens = self.image.camera.intrinsics
        local = self.where.inverse() * points
        depth = local[:, 2]
        found = np.zeros(len(points), dtype=np.bool_)
        front = np.flatnonzero(depth > 1.5 * radius)
        local, depth = local[front], depth[front]
        middle = lens.pixels_of(local)
        slope = np.sqrt(1.0 + (local[:, 0] ** 2 + local[:, 1] ** 2) / depth**2)
        # How far the slope of a ray to a point of the ball is from that of the ray to its middle, at most.
        reach = radius * slope / (depth - radius) * lens.stretch
        with np.errstate(invalid="ignore"):
            first = np.floor(middle - reach[:, None] * (lens.fx, lens.fy))
            last = np.ceil(middle + reach[:, None] * (lens.fx, lens.fy))
            inside = (first >= 0.0).all(axis=1) & (last <= (lens.width - 1, lens.height - 1)).all(axis=1)
        some = np.flatnonzero(inside)
        if len(some):
            begin, end = first[some].astype(np.int64), last[some].astype(np.int64)
            clear = self._least(begin, end) > depth[some] + radius
            clear &= self._holes(begin, end) <= 1.0 - ENOUGH
            found[front[some[clear]]] = True
        return found

    def _least(self, begin: Ints, end: Ints) -> Floats:
        """Return the smallest depth in rectangles of pixels, from their first to their last (n, 2)."""
        sides = end - begin + 1
        found = np.full(len(begin), np.inf)
        level = np.minimum(np.log2(sides.min(axis=1)).astype(np.int64), len(self.least) - 1)
        for each, table in enumerate(self.least):
            some = np.flatnonzero(level == each)
            if not len(some):
                continue
            step = 1 << each
            most = sides[some].max(axis=0)
            lowest = np.full(len(some), np.inf, dtype=np.float32)
            for down in (*range(0, int(most[1]) - step, step), int(most[1]) - step):
                for across in (*range(0, int(most[0]) - step, step), int(most[0]) - step):
                    column = np.minimum(begin[some, 0] + across, end[some, 0] - step + 1)
                    row = np.minimum(begin[some, 1] + down, end[some, 1] - step + 1)
                    lowest = np.minimum(lowest, table[row, column])
            found[some] = lowest
        return found

    def _holes(self, begin: Ints, end: Ints) -> Floats:
        """Return the share of pixels that measured nothing in rectangles, from their first to their last."""
        table, (left, top), (right, bottom) = self.holes, begin.T, end.T + 1
        many = table[bottom, right] - table[top, right] - table[bottom, left] + table[top, left]
        return many / ((right - left) * (bottom - top))


def _bridged(seen: Singles, pixels: int) -> Singles:
    """Let a pixel that measured nothing see as far as the nearest around it, if most of those measured."""
    from scipy.ndimage import minimum_filter, uniform_filter  # slow to import

    side = 2 * pixels + 1
    measured = seen > 0.0
    least = minimum_filter(np.where(measured, seen, np.float32(np.inf)), side, mode="nearest")
    share = uniform_filter(measured.astype(np.float32), side, mode="constant")
    return np.where(measured | (share <= ENOUGH), seen, least).astype(np.float32)
