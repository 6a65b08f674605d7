"""Images of depth cameras and point clouds, converted to occupied cells."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trajopt.lab.perception.sensing import Grid, Sensing, Taken, leaders, radius_for
from trajopt.scene.camera import NOISELESS, Camera, DepthNoise, Singles, placed_on
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, above_zero, at_least, floats, one_of
from trajopt.values.errors import ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import IDENTITY, WORLD, Placement

MILLIMETRE = 1e-3
ROWS = 32
"""Rows of an image processed together: they fit into caches, and amortise calls of numpy."""
LIKELY_MILLIMETRES = 100.0
"""Beyond the range of depth cameras [m]: a measurement in which nothing is nearer is in millimetres."""
FAR = f"has nothing nearer than {LIKELY_MILLIMETRES:g} m: is it in millimetres"


@checked
@dataclass(frozen=True, eq=False)
class DepthImage(Value):
    """A depth image.

    As in ROS (REP 118), whole numbers are millimetres, 0 if not measured; other numbers are metres, NaN if
    not measured, and infinite if nothing is within range. Masked pixels are not measured.

    Attributes:
        depth: Along the camera's axis, not along the pixel's ray; shape (height, width).
        positions: Of all joints of the robot at its time, shape (number of joints,) [rad | m].
        scale: Unit of the image [m]; None for the above.
    """

    camera: Camera
    depth: NDArray[Any]
    positions: Floats
    scale: float | None = None

    def __post_init__(self) -> None:
        lens = one_of("camera", self.camera, Camera).intrinsics
        depth = np.array(np.ma.filled(self.depth, 0))
        if depth.dtype.kind not in "uif":
            raise ShapeError("depth", f"must be numbers, is of {depth.dtype}")
        if depth.shape != (lens.height, lens.width):
            raise ShapeError(
                "depth", f"needs shape ({lens.height}, {lens.width}) of its camera, has {depth.shape}"
            )
        if self.scale is not None:
            above_zero(self, "scale")
        elif depth.dtype.kind == "f" and _likely_millimetres(depth):
            raise ShapeError("depth", f"{FAR}? Give scale=0.001 then")
        depth.flags.writeable = False
        object.__setattr__(self, "depth", depth)
        object.__setattr__(self, "positions", floats("positions", self.positions, (None,)))

    def __repr__(self) -> str:
        height, width = self.depth.shape
        return f"DepthImage({width} x {height} pixels, camera on {shown(self.camera.frame)})"

    @property
    def unit(self) -> float:
        """Unit of the image [m]."""
        if self.scale is not None:
            return self.scale
        return 1.0 if self.depth.dtype.kind == "f" else MILLIMETRE

    @property
    def rounding(self) -> float:
        """Rounding error of whole-number depths [m]."""
        return 0.0 if self.depth.dtype.kind == "f" else self.unit / 2.0

    @cached_property
    def metres(self) -> Singles:
        """The depths [m], shape (height, width); 0, infinity or NaN without a measurement."""
        metres = self.depth.astype(np.float32)
        return metres if self.unit == 1.0 else metres * np.float32(self.unit)

    @checked
    def where(self, scene: Scene) -> Placement:
        """Return the placement of the camera's optical frame in the world; raises as `Camera.at`."""
        return self.camera.at(scene, self.positions)

    def taken(self, scene: Scene, sensing: Sensing) -> Taken:
        """Return the occupied cells of the world.

        Raises:
            FrameNotFound: If the scene does not have the camera's frame.
            ShapeError: If the positions are not one number for each joint.
        """
        camera, depth = self.camera, self.metres
        where = self.where(scene)
        reach = camera.farthest * camera.intrinsics.longest_ray
        grid = Grid.around(where, reach, sensing.cell, sensing.workspace)
        found: list[NDArray[np.signedinteger]] = []
        measured, inside, deepest = 0, 0, 0.0
        for begin in range(0, len(depth), ROWS):
            rows = slice(begin, begin + ROWS)
            part = depth[rows]
            valid = (part >= np.float32(camera.nearest)) & (part <= np.float32(camera.farthest))
            measured += int(np.count_nonzero(valid))
            numbers = grid.numbered(_scaled(camera, grid, where, part, rows), valid)
            inside += int(np.count_nonzero(valid))
            deepest = max(deepest, float(np.where(valid, part, np.float32(0.0)).max()))
            found.append(leaders(numbers))
        radius = radius_for(
            sensing,
            largest=max(reach, grid.across),
            noise=(camera.noise.sigma(deepest) * sensing.sigmas + self.rounding)
            * camera.intrinsics.longest_ray,
            # Half the diagonal of a pixel, on a surface that is tilted as much as asked.
            gap=deepest * camera.intrinsics.pixel / 2.0 / float(np.cos(sensing.tilt)),
        )
        counts = {"measured": measured, "in the workspace": inside}
        return Taken(grid.keys(np.concatenate(found)), radius, counts, self.positions)


def _scaled(
    camera: Camera, grid: Grid, where: Placement, depth: Singles, rows: slice
) -> tuple[Singles, Singles, Singles]:
    across, down = camera.intrinsics.slopes
    across = across if len(across) == 1 else across[rows]
    turn, shift = grid.placed(where)

    def along(axis: int) -> Singles:
        values = turn[axis, 0] * across + (turn[axis, 1] * down[rows] + turn[axis, 2])
        with np.errstate(invalid="ignore", over="ignore"):
            values *= depth
            values += shift[axis]
        return values

    return along(0), along(1), along(2)


def _distances(points: Singles) -> Singles:
    with np.errstate(invalid="ignore", over="ignore"):
        return np.sqrt(np.einsum("ij,ij->i", points, points))


def _likely_millimetres(depth: NDArray[Any]) -> bool:
    measured = depth[np.isfinite(depth) & (depth > 0.0)]
    return bool(len(measured)) and float(measured.min()) > LIKELY_MILLIMETRES


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
        nearest: Nearer points are skipped [m], as are those beyond `farthest`.
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
        try:
            points = np.array(self.points, dtype=np.float32)
        except (TypeError, ValueError) as error:
            raise ShapeError("points", f"must be numbers, is {shown(self.points)}") from error
        if points.shape == (0,):
            points = points.reshape(0, 3)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ShapeError("points", f"needs shape (any, 3), has {points.shape}")
        if _likely_millimetres(_distances(points)):
            raise ShapeError("points", f"{FAR}?")
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
        return f"PointCloud({len(self.singles)} points, sensor on {shown(self.frame)})"

    @property
    def singles(self) -> Singles:
        """The points, shape (n, 3) [m]."""
        return np.asarray(self.points, dtype=np.float32)

    def taken(self, scene: Scene, sensing: Sensing) -> Taken:
        """Return the cells of the world in which it has points; raises as `DepthImage.taken`."""
        points = self.singles
        distances = _distances(points)
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
