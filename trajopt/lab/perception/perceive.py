"""perceive(scene, image): a scene with the measurements as one object, which each call replaces."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from trajopt.lab.perception.depth_image import DepthImage, PointCloud
from trajopt.lab.perception.sensing import (
    DEFAULT,
    MOST_CELLS_ACROSS,
    Radius,
    Sensing,
    Taken,
    centres,
    once,
    packed,
    unpacked,
)
from trajopt.robot.bodies import CollisionBody
from trajopt.robot.robot import Robot
from trajopt.scene.camera import Singles
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Bools, Floats, Ints, Value, floats, readonly
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import ProblemError, SizeError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement
from trajopt.values.printed import in_length
from trajopt.values.shapes import shapes
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Points, Voxels
from trajopt.values.shapes.surfaces import HOLE


@dataclass(frozen=True, eq=False)
class Cloud(Value):
    """The measured part of the world.

    Attributes:
        keys: Numbers of the occupied cells, in rising order, shape (n,).
        cell: Edge of the cells [m].
        radius: Of balls about the cells' centres, whose union contains the measured points with their noise,
            and the surface between neighbouring pixels.
        counts: Numbers of measurements, occupied cells, and cells removed as robot.
    """

    keys: Ints
    cell: float
    radius: Radius
    counts: Mapping[str, int]

    @cached_property
    def points(self) -> Floats:
        """Centres of the cells, shape (n, 3) in the world [m]."""
        return readonly(centres(self.keys, self.cell))

    @property
    def shape(self) -> Points | None:
        """The balls; None for an empty cloud."""
        return Points(self.points, self.radius.whole) if len(self.keys) else None

    def __len__(self) -> int:
        return len(self.keys)

    def __repr__(self) -> str:
        told = ", ".join(f"{count} {name}" for name, count in self.counts.items())
        return f"Cloud({len(self)} points with balls of {self.radius}; {told})"


Measured = DepthImage | PointCloud
M = TypeVar("M", DepthImage, Measured)
MOST_CELLS = 1 << 24
"""Most cells of a workspace for unseen space: 256 along each side."""


@dataclass(frozen=True, eq=False)
class Perceived(Value):
    """Result of perception: the scene with the cloud as one object."""

    scene: Scene
    cloud: Cloud


@checked
def perceive(
    scene: Scene,
    measured: Measured | Sequence[Measured],
    sensing: Sensing = DEFAULT,
    *,
    name: str = "camera",
    before: Cloud | None = None,
) -> Perceived:
    """Add measurements to a scene, replacing the earlier object of that name.

    Proofs state the clearance from the measured points, each a ball of the cloud's radius. Unseen space
    counts as free (`with_unseen` makes it solid). An empty cloud becomes a frame without a shape.

    Args:
        before: The earlier cloud, which stays except for places that an image now shows to be empty; None to
            drop it.

    Raises:
        FrameNotFound: If the scene does not have a camera's frame.
        ObjectNotFound: If a known object is not in the scene.
        ProblemError: If nothing is given, or the earlier cloud has another cell size.
        ShapeError: If the positions are not one number for each joint of the robot.
    """
    each = _several(measured)
    known = _without(scene, name)
    taken = [item.taken(known, sensing) for item in each]
    found: list[Ints] = []
    robot = 0
    for one in taken:
        kept = _beside_robot(known, one.keys, one.positions, sensing)
        robot += len(one.keys) - len(kept)
        found.append(kept)
    radius, stays = _largest(taken), np.empty(0, dtype=np.int64)
    if before is not None:
        stays = _beside_robot(known, _hidden(known, before, each, sensing), each[-1].positions, sensing)
        radius = _larger(radius, before.radius) if len(stays) else radius
    keys = once(np.concatenate((*found, stays)))
    counts = {key: sum(one.counts[key] for one in taken) for key in taken[0].counts}
    counts |= {"cells taken for the robot": robot}
    counts |= {} if before is None else {"cells kept from before": len(stays)}
    cloud = Cloud(keys, sensing.cell, radius, counts)
    return Perceived(scene.with_cloud(name, cloud.shape), cloud)


@checked
def with_unseen(
    scene: Scene,
    images: DepthImage | Sequence[DepthImage],
    sensing: Sensing,
    *,
    cell: float = 0.02,
    name: str = "unseen",
) -> Scene:
    """Make all of the workspace solid that no image shows to be empty, as one object of cubes.

    A cube is empty if every pixel of an image that sees any of it measured a surface behind it, less the
    noise. The robot's place at the time of an image, with `sensing.padding`, is not solid. See
    docs/clouds.md#from-a-camera.

    Args:
        sensing: Parameters, with a workspace.
        cell: Edge of the cubes [m].

    Raises:
        ProblemError: If there is no workspace, or no image.
        SizeError: If the workspace has more than 2^24 such cubes.
        FrameNotFound: If the scene does not have a camera's frame.
    """
    each = _several(images)
    known = _without(scene, name)
    keys = _grid(sensing, cell)
    middles, radius = centres(keys, cell), cell * np.sqrt(3.0) / 2.0
    hidden = np.ones(len(keys), dtype=np.bool_)
    for image in each:
        sight = Sight.of(image, known, sensing, holes_are_clear=False)
        hidden[hidden] = ~sight.through(middles[hidden], radius)
    unseen = np.flatnonzero(hidden)
    near, inside = np.zeros((2, len(unseen)), dtype=np.bool_)
    for image in each:
        mask = RobotMask.of(known, image.positions, sensing.known)
        near |= mask.covers(middles[unseen], sensing.padding + radius)
        inside |= mask.covers(middles[unseen], 0.0)
    hidden[unseen[near]] = False
    left = unpacked(keys[hidden])
    given = _free_beside_robot(int((near & ~inside).sum()), cell, sensing)
    return scene.with_cloud(name, Voxels(left, cell) if len(left) else None, given=given)


def _free_beside_robot(count: int, cell: float, sensing: Sensing) -> tuple[str, ...]:
    if not count:
        return ()
    known = "".join(f" and {name}" for name in sensing.known)
    cubes, reach = f"{count} cubes of {in_length(cell)}", in_length(sensing.padding + cell * np.sqrt(3.0))
    return (
        f"nothing is in {cubes} that no image shows, up to {reach} from where the robot{known} was when it "
        "was measured",
    )


def _several(measured: M | Sequence[M]) -> tuple[M, ...]:
    each = tuple(measured) if isinstance(measured, Sequence) else (measured,)
    if not each:
        raise ProblemError("give at least one image or cloud")
    return each


def _without(scene: Scene, name: str) -> Scene:
    return scene.remove(name) if name in scene.objects else scene


def _beside_robot(scene: Scene, keys: Ints, positions: Floats, sensing: Sensing) -> Ints:
    mask = RobotMask.of(scene, positions, sensing.known)
    return keys[~mask.covers(centres(keys, sensing.cell), sensing.padding)]


def _hidden(scene: Scene, before: Cloud, now: Sequence[Measured], sensing: Sensing) -> Ints:
    if before.cell != sensing.cell:
        raise ProblemError(
            f"before: has cells of {before.cell:g} m, the others of {sensing.cell:g} m: use one size for both"
        )
    keys = before.keys
    for image in now:
        if isinstance(image, DepthImage):
            sight = Sight.of(image, scene, sensing, holes_are_clear=True)
            keys = keys[~sight.through(centres(keys, before.cell), before.radius.whole)]
    return keys


def _grid(sensing: Sensing, cell: float) -> Ints:
    if sensing.workspace is None:
        raise ProblemError("sensing requires a workspace, the bounds of the unseen region")
    begin = np.floor(sensing.workspace.lower / cell + 1e-9).astype(np.int64)
    end = np.ceil(sensing.workspace.upper / cell - 1e-9).astype(np.int64)
    many = float(np.prod((end - begin).astype(np.float64)))
    if many > MOST_CELLS or max(np.abs(begin).max(), np.abs(end).max()) >= MOST_CELLS_ACROSS:
        raise SizeError(
            "cell", f"of {cell:g} m makes {many:.3g} cubes of the workspace; {MOST_CELLS} are the most"
        )
    cells = np.indices((end - begin).tolist()).reshape(3, -1).T
    return packed(cells + begin)


def _largest(taken: Sequence[Taken]) -> Radius:
    radius = taken[0].radius
    for each in taken[1:]:
        radius = _larger(radius, each.radius)
    return radius


def _larger(a: Radius, b: Radius) -> Radius:
    return Radius(max(a.cell, b.cell), max(a.noise, b.noise), max(a.gap, b.gap))


ENOUGH = 0.5
"""Share of measuring pixels above which a hole is bridged, and an earlier point is dropped."""


@dataclass(frozen=True, eq=False)
class Sight:
    """The space that one image shows to be empty.

    Each pixel sees up to its measurement, less its noise, or to the end of its range if nothing is in range.

    Attributes:
        where: Of the camera's optical frame in the world.
        least: The smallest seen depth in squares of 1, 2, 4, ... pixels, by their first pixel [m].
        holes: Cumulative number of pixels without a measurement, shape (height + 1, width + 1).
    """

    image: DepthImage
    where: Placement
    least: tuple[Singles, ...]
    holes: Ints

    @staticmethod
    def of(image: DepthImage, scene: Scene, sensing: Sensing, *, holes_are_clear: bool) -> "Sight":
        """Process an image; `holes_are_clear` if a pixel without a measurement hides nothing."""
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
        """Return the balls (n, 3) in the world [m] of which all pixels measured a surface behind."""
        lens = self.image.camera.intrinsics
        local = self.where.inverse() * points
        depth = local[:, 2]
        found = np.zeros(len(points), dtype=np.bool_)
        front = np.flatnonzero(depth > 1.5 * radius)
        local, depth = local[front], depth[front]
        middle = lens.pixels_of(local)
        slope = np.sqrt(1.0 + (local[:, 0] ** 2 + local[:, 1] ** 2) / depth**2)
        # How far the slope of a ray to a point of the ball is from that of the ray to its middle, at most.
        apart = radius * slope / (depth - radius)
        reach = apart * lens.stretch
        with np.errstate(invalid="ignore"):
            first = np.floor(middle - reach[:, None] * (lens.fx, lens.fy))
            last = np.ceil(middle + reach[:, None] * (lens.fx, lens.fy))
            inside = (first >= 0.0).all(axis=1) & (last <= (lens.width - 1, lens.height - 1)).all(axis=1)
            inside &= np.hypot(*(local[:, :2] / depth[:, None]).T) + apart <= lens.widest
        some = np.flatnonzero(inside)
        if len(some):
            begin, end = first[some].astype(np.int64), last[some].astype(np.int64)
            clear = self._least(begin, end) > depth[some] + radius
            clear &= self._holes(begin, end) <= 1.0 - ENOUGH
            found[front[some[clear]]] = True
        return found

    def _least(self, begin: Ints, end: Ints) -> Floats:
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
        table, (left, top), (right, bottom) = self.holes, begin.T, end.T + 1
        many = table[bottom, right] - table[top, right] - table[bottom, left] + table[top, left]
        return many / ((right - left) * (bottom - top))


def _bridged(seen: Singles, pixels: int) -> Singles:
    from scipy.ndimage import minimum_filter, uniform_filter  # slow to import

    side = 2 * pixels + 1
    measured = seen > 0.0
    least = minimum_filter(np.where(measured, seen, np.float32(np.inf)), side, mode="nearest")
    share = uniform_filter(measured.astype(np.float32), side, mode="constant")
    return np.where(measured | (share <= ENOUGH), seen, least).astype(np.float32)


@dataclass(frozen=True, eq=False)
class _Solid:
    shape: shapes.Shape
    lower: Floats
    upper: Floats
    faces: Floats

    def near(self, points: Floats, padding: float) -> Bools:
        """Return the points in it or within the padding, shape (n, 3) in its frame [m].

        Complete; beyond edges and corners of flat faces some slightly farther points are included.
        """
        inside = (points >= self.lower - padding) & (points <= self.upper + padding)
        near: Bools = np.asarray(inside.all(axis=1))
        some = np.flatnonzero(near)
        if len(some):
            near[some] = self._nearer(points[some], padding)
        return near

    def _nearer(self, points: Floats, padding: float) -> Bools:
        if len(self.faces):
            farthest: Floats = (points @ self.faces[:, :3].T + self.faces[:, 3]).max(axis=1)
            return farthest <= padding
        across, height = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
        match self.shape:
            case shapes.Sphere(radius):
                return np.linalg.norm(points, axis=1) <= radius + padding
            case shapes.Cylinder(radius, _):
                return across <= radius + padding
            case shapes.Capsule(radius, length):
                return np.hypot(across, np.maximum(np.abs(height) - length / 2, 0.0)) <= radius + padding
            case shapes.Cone(radius, length):
                slant = float(np.hypot(radius, length))
                return (across - radius * (0.5 - height / length)) * length / slant <= padding
            case shapes.Points(centres, radius):
                return _within(points, centres, radius + padding)
            case shapes.Voxels():
                return _within(points, self.shape.centres, self.shape.size * np.sqrt(0.75) + padding)
            case Mesh():
                # What lies in a bin is no part of it, though it is within the bin's hull.
                near = self.shape.distance(points) <= padding
                near[~near] = self.shape.contains(points[~near], opening=HOLE)
                return near
            case _:
                return np.ones(len(points), dtype=np.bool_)


@dataclass(frozen=True, eq=False)
class RobotMask:
    """The robot with its attached objects, and known objects, placed in the world."""

    solids: Sequence[_Solid]
    placements: Sequence[Placement]

    @staticmethod
    def of(scene: Scene, positions: Floats, known: Iterable[str] = ()) -> "RobotMask":
        """Place the robot in a configuration of all joints [rad | m]."""
        at = floats("positions", positions, (len(scene.robot.joint_names),))
        named = {scene.object(name).name for name in known}
        solids, placements = list[_Solid](), list[Placement]()
        frames: dict[str, Placement] = {WORLD: Placement()}
        own = _solids_of(scene.robot)
        added = [body for body in scene.object_bodies() if body.frame != WORLD or body.owner in named]
        for body, solid in (*own, *((body, _solid(body.shape)) for body in added)):
            if body.frame not in frames:
                frames[body.frame] = scene.placement_of(body.frame, at)
            solids.append(solid)
            placements.append(frames[body.frame] * body.placement)
        return RobotMask(tuple(solids), tuple(placements))

    def covers(self, points: Floats, padding: float) -> Bools:
        """Return the points (n, 3) in it or within the padding [m], in the world.

        Complete; beyond edges and corners of its bodies it may extend slightly farther.
        """
        covered = np.zeros(len(points), dtype=np.bool_)
        boxes = [
            _world_box(solid, where, padding)
            for solid, where in zip(self.solids, self.placements, strict=True)
        ]
        if not len(points) or not boxes:
            return covered
        # All of the robot first: most of what a camera sees is far from it.
        near = _in_box(
            points, np.min([low for low, _ in boxes], axis=0), np.max([up for _, up in boxes], axis=0)
        )
        close = points[near]
        for solid, where, (lower, upper) in zip(self.solids, self.placements, boxes, strict=True):
            some = _in_box(close, lower, upper)
            if len(some):
                covered[near[some]] |= solid.near(where.inverse() * close[some], padding)
        return covered


def _world_box(solid: _Solid, where: Placement, padding: float) -> tuple[Floats, Floats]:
    if not np.isfinite((solid.lower, solid.upper)).all():
        return np.full(3, -np.inf), np.full(3, np.inf)
    middle = where * ((solid.lower + solid.upper) / 2)
    half = np.abs(where.rotation) @ ((solid.upper - solid.lower) / 2 + padding)
    return middle - half, middle + half


def _in_box(points: Floats, lower: Floats, upper: Floats) -> Ints:
    some = np.arange(len(points))
    for axis in range(3):
        column = points[some, axis]
        some = some[(column >= lower[axis]) & (column <= upper[axis])]
    return some


@cached_per_value
def _solids_of(robot: Robot) -> tuple[tuple[CollisionBody, _Solid], ...]:
    return tuple((body, _solid(body.shape)) for body in robot.bodies)


def _solid(shape: shapes.Shape) -> _Solid:
    lower, upper = shapes.bounding_box(shape)
    faces = np.empty((0, 4))
    match shape:
        case shapes.Box():
            return _Solid(shape, lower, upper, faces)
        case shapes.Plane():
            return _Solid(shape, lower, upper, np.array(((0.0, 0.0, 1.0, 0.0),)))
        case shapes.Convex():
            corners = shape.vertices[shape.faces]
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            lengths = np.linalg.norm(normals, axis=1)
            flat = lengths > 0.0
            normals = normals[flat] / lengths[flat, None]
            # Farthest over all corners: the planes of slivers are known badly, and must not cut the hull.
            faces = np.column_stack((normals, -(shape.vertices @ normals.T).max(axis=0)))
        case _:
            pass
    return _Solid(shape, lower, upper, faces)


def _within(points: Floats, centres: Floats, reach: float) -> Bools:
    from scipy.spatial import cKDTree  # slow to import

    distances, _ = cKDTree(centres).query(points, distance_upper_bound=reach * (1.0 + 1e-9))
    return np.isfinite(distances)
