"""A cloud of points that a sensor made itself, in a frame of its own."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trajopt.lab.perception.cells import Grid, leaders
from trajopt.lab.perception.sensing import Sensing, Taken, radius_for
from trajopt.scene.camera import NOISELESS, DepthNoise, Singles, placed_on
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, above_zero, at_least, floats
from trajopt.values.errors import ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import IDENTITY, WORLD, Placement


@checked
@dataclass(frozen=True, eq=False)
class PointCloud(Value):
    """A cloud of measured points: of a laser scanner, a stereo camera, or a file.

    Points with a coordinate that is not finite are skipped.

    Attributes:
        points: In the sensor's frame, shape (n, 3) [m]; may be empty.
        positions: Of all joints of the robot at its time, shape (number of joints,) [rad | m].
        frame: "world", a link, a tool frame or an object of the scene.
        placement: Of the sensor in that frame.
        nearest: Nearer points are skipped [m].
        farthest: Farther points are skipped [m].
        noise: Standard deviation of a point, by its distance from the sensor.
        spacing: Largest distance of neighbouring points on a surface [m]; 0 if unknown; gaps between points
            are then not covered.
    """

    points: ArrayLike
    positions: Floats
    frame: str = WORLD
    placement: Placement = IDENTITY
    nearest: float = 0.0
    farthest: float = 50.0
    noise: DepthNoise = NOISELESS
    spacing: float = 0.0

    def __post_init__(self) -> None:
        """Check and copy the points.

        Raises:
            ShapeError: If they are not of three coordinates each, or the range is none.
        """
        try:
            points = np.array(self.points, dtype=np.float32)
        except (TypeError, ValueError) as error:
            raise ShapeError("points", f"must be numbers, is {shown(self.points)}") from error
        if points.shape == (0,):
            points = points.reshape(0, 3)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ShapeError("points", f"needs shape (any, 3), has {points.shape}")
        points.flags.writeable = False
        at_least(self, 0.0, "nearest", "spacing")
        above_zero(self, "farthest")
        if not self.nearest < self.farthest < np.inf:
            raise ShapeError(
                "PointCloud.farthest", f"must be beyond {self.nearest:g} m, is {self.farthest:g} m"
            )
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "positions", floats("positions", self.positions, (None,)))

    def __repr__(self) -> str:
        """Return the number of points, and the sensor's frame."""
        return f"PointCloud({len(self.singles)} points, sensor on {shown(self.frame)})"

    @property
    def singles(self) -> Singles:
        """The points, shape (n, 3) [m]."""
        return np.asarray(self.points, dtype=np.float32)

    def taken(self, scene: Scene, sensing: Sensing) -> Taken:
        """Return the cells of the world in which it has points; raises as `DepthImage.taken`."""
        points = self.singles
        with np.errstate(invalid="ignore", over="ignore"):
            distances = np.sqrt(np.einsum("ij,ij->i", points, points))
        valid = (distances >= self.nearest) & (distances <= self.farthest)
        where = placed_on(scene, self.frame, self.positions) * self.placement
        measured = int(np.count_nonzero(valid))
        grid = Grid.around(where, self.farthest, sensing.cell, sensing.workspace)
        turn, shift = grid.placed(where)
        with np.errstate(invalid="ignore", over="ignore"):
            placed = turn @ points.T + shift[:, None]
        numbers = grid.numbered(list(placed), valid)
        farthest = float(np.max(distances, where=valid, initial=0.0))
        noise = self.noise.sigma(farthest) * sensing.sigmas if farthest else 0.0
        radius = radius_for(
            sensing,
            largest=max(self.farthest, grid.across),
            noise=noise,
            gap=self.spacing / np.sqrt(2.0),
        )
        counts = {
            "measured": measured,
            "in the workspace": int(np.count_nonzero(valid)),
        }
        return Taken(grid.keys(leaders(numbers)), radius, counts, self.positions)
