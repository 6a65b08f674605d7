"""Grasps, places and options of picking and placing, and grasp proposals."""

from collections.abc import Iterator, Sequence
from dataclasses import InitVar, dataclass, field
from itertools import cycle
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from trajopt.optimise.methods import Knots, Method
from trajopt.problem.requirements import POSITION_TOLERANCE, FramePlacement, frame_placement
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.tasks.grasping.antipodal import AROUND, DIRECTIONS, SIDES, places_of_pads
from trajopt.tasks.grasping.gripper import Gripper
from trajopt.values.arrays import Floats, Value, direction_of, floats, number, one_of, positive, readonly
from trajopt.values.errors import ModelError, ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement, PlacementLike, as_placement
from trajopt.values.shapes.clouds import Points, Voxels
from trajopt.values.shapes.shapes import Box, Cylinder, Plane, Sphere, placed_box

FORCE = 30.0
"""Default force of each finger [N]."""


@dataclass(frozen=True, eq=False)
class Straight(Value):
    """A straight motion of the gripper without rotation.

    Attributes:
        distance: Its length [m].
        direction: In `frame`, shape (3,), a unit vector. None for the default: an approach goes along the
            gripper's approach axis and a retreat against it, a lift against gravity and a lowering along it.
        frame: "world", a link, a tool frame or an object, at the time of contact with the object.
    """

    distance: float = 0.1
    direction: ArrayLike | None = None
    frame: str = WORLD

    def __post_init__(self) -> None:
        positive("distance", self.distance)
        one_of("frame", self.frame, str)
        if self.direction is not None:
            object.__setattr__(self, "direction", direction_of("direction", self.direction))

    @property
    def unit(self) -> Floats | None:
        """The direction as an array, shape (3,); None for the default one."""
        return None if self.direction is None else np.asarray(self.direction, dtype=np.float64)


@dataclass(frozen=True, eq=False, kw_only=True)
class Grasp:
    """A grasp of an object with a parallel gripper.

    Attributes:
        placement: Of the gripper's tool frame in the object's frame.
        width: Of the object between the pads [m].
        opening: Between the pads during the approach [m].
        force: Of each finger [N].
        approach: Straight motion to the object with open fingers, ending in the grasp.
        lift: Straight motion off the support.
    """

    placement: Placement
    width: float
    opening: float
    force: float = FORCE
    approach: Straight = field(default_factory=Straight)
    lift: Straight = field(default_factory=Straight)
    name: str = "grasp"

    def __post_init__(self) -> None:
        object.__setattr__(self, "placement", as_placement("placement", self.placement))
        for way in ("approach", "lift"):
            one_of(way, getattr(self, way), Straight)
        one_of("name", self.name, str)
        positive("force", self.force)
        if number("width", self.width) < 0.0:
            raise ShapeError("width", f"is negative: {self.width:g} m")
        if number("opening", self.opening) < self.width:
            raise ShapeError(
                "opening",
                f"of grasp {shown(self.name)} is {self.opening:g} m, less than the object is wide: "
                f"{self.width:g} m",
            )


@dataclass(frozen=True, eq=False, kw_only=True)
class Place(Value):
    """A target placement of an object.

    Attributes:
        placement: Of the object in `frame`.
        frame: "world", or a static object.
        position_tolerance: Along the axes of `placement`, one or shape (3,) [m]; inf leaves an axis free.
        rotation_tolerance: About them, one or shape (3,) [rad]; inf leaves an axis free, None is 1e-3 rad.
        lower: The straight motion down to the support.
        retreat: The straight motion of the opened gripper off the object.
    """

    placement: Placement
    frame: str = WORLD
    position_tolerance: ArrayLike = POSITION_TOLERANCE
    rotation_tolerance: ArrayLike | None = None
    lower: Straight = field(default_factory=Straight)
    retreat: Straight = field(default_factory=Straight)
    name: str = "place"
    degrees: InitVar[bool] = False

    def __post_init__(self, degrees: bool) -> None:
        object.__setattr__(self, "placement", as_placement("placement", self.placement))
        for field_name in ("frame", "name"):
            one_of(field_name, getattr(self, field_name), str)
        for way in ("lower", "retreat"):
            one_of(way, getattr(self, way), Straight)
        asked = self.requirement(WORLD, degrees=degrees)
        object.__setattr__(self, "rotation_tolerance", asked.rotation_tolerance)

    @checked
    def requirement(self, name: str, *, degrees: bool = False) -> FramePlacement:
        """Return the requirement on the object of that name."""
        return frame_placement(
            name,
            self.placement,
            reference=self.frame,
            position_tolerance=self.position_tolerance,
            rotation_tolerance=self.rotation_tolerance,
            degrees=degrees,
        )

    @checked
    def error(self, placed: Placement, frame: Placement) -> Floats:
        """Return the error of an object placed in the world: position [m], rotation vector [rad], (6,).

        In the axes of `placement`; zero along free axes.

        Args:
            frame: Placement of `frame` in the world.
        """
        from scipy.spatial.transform import Rotation

        asked = self.requirement(WORLD)
        between = (frame * self.placement).inverse() * placed
        off = np.concatenate((between.translation, Rotation.from_matrix(between.rotation).as_rotvec()))
        free = np.isinf(np.concatenate((asked.position_tolerance, asked.rotation_tolerance)))
        return floats("error", np.where(free, 0.0, off), (6,))


UPWARD = np.array((0.0, 0.0, 1.0))
"""Direction of the layers of a pallet."""


@checked
def pallet(
    corner: PlacementLike,
    counts: Sequence[int],
    steps: ArrayLike,
    *,
    staggered: bool = False,
    access: ArrayLike = (0.0, 0.0, 0.0),
) -> tuple[Placement, ...]:
    """Return the places of equal parts on a pallet or a tray.

    Their order is from below, in each layer the farthest first; parts are taken by `reversed(pallet(...))`.

    Args:
        corner: Placement of the part at a corner; columns are along its x, rows along y, layers along z.
        counts: Numbers of columns, rows and layers.
        steps: Distances between these, shape (3,) [m].
        staggered: Whether every second row is shifted by half a column, and has one part less.
        access: Point from which the arm comes, in the frame in which `corner` is given, shape (3,) [m].

    Returns:
        Placements in the frame in which `corner` is given.

    Raises:
        ShapeError: If a count is not positive, or `steps` or `access` is not a vector.
    """
    begin, numbers = as_placement("corner", corner), floats("counts", counts, (3,))
    if (numbers < 1).any():
        raise ShapeError("counts", f"must be positive, are {shown(tuple(counts))}")
    columns, rows, layers = numbers.astype(int).tolist()
    size = floats("steps", steps, (3,))
    flat = np.array(
        [
            (column + 0.5 * shift, row, 0.0)
            for row in range(rows)
            for shift in (row % 2 if staggered else 0,)
            for column in range(columns - shift)
        ]
    )
    away = begin.rotation.T @ (floats("access", access, (3,)) - begin.translation)
    far = np.linalg.norm((flat * size - away)[:, :2], axis=1)
    return tuple(
        begin * Placement(translation=size * (place + layer * UPWARD))
        for layer in range(layers)
        for place in flat[np.argsort(-far, kind="stable")]
    )


@checked
@dataclass(frozen=True, kw_only=True)
class GraspingOptions:
    """Options of `pick`, `place` and `pick_and_place`.

    Attributes:
        velocity_scaling: Factor in (0, 1] on the velocity limits.
        acceleration_scaling: Factor in (0, 1] on the acceleration limits.
        tool_speed: Speed limits of tools in every motion of the arm.
        aside: Largest deviation of the tool from the line of a straight motion [m].
        turn: Largest rotation of the tool there [rad].
        contact_time: Duration of the allowed contact with the support, after the lift begins and before the
            lowering ends [s].
        grip_time: Rest after the fingers closed, for the force to build up [s].
        release_time: Rest before the fingers open, for the object to settle [s].
        configurations: Arm configurations for each grasp and each place.
    """

    velocity_scaling: float = 1.0
    acceleration_scaling: float = 1.0
    tool_speed: ToolSpeed | Sequence[ToolSpeed] = ()
    aside: float = 2e-3
    turn: float = 0.02
    contact_time: float = 0.15
    grip_time: float = 0.3
    release_time: float = 0.2
    configurations: int = 4
    method: Method = field(default_factory=Knots)

    def __post_init__(self) -> None:
        for name in ("velocity_scaling", "acceleration_scaling"):
            if not 0.0 < number(name, getattr(self, name)) <= 1.0:
                raise ShapeError(name, f"must lie in (0, 1], is {getattr(self, name)}")
        for name in ("aside", "turn", "contact_time", "configurations"):
            if number(name, getattr(self, name)) <= 0.0:
                raise ShapeError(name, f"must be positive, is {getattr(self, name):g}")
        for name in ("grip_time", "release_time"):
            if number(name, getattr(self, name)) < 0.0:
                raise ShapeError(name, f"is negative: {getattr(self, name):g} s")


SPARE = 0.01
"""Preferred distance of each pad from the object during the approach [m]."""
LEAST_SPARE = 0.003
"""The smallest such distance; an object that leaves less is too wide [m]."""
WEIGHTS = 1.5
"""Force of each finger, relative to the object's weight: pads of rubber then hold it at 1.4 times gravity."""
HALF_TURN = np.diag((-1.0, -1.0, 1.0))
"""Half a turn about the approach axis."""


def grasps_of(
    scene: Scene, name: str, gripper: Gripper, *, force: float | None = None, reach: float | None = None
) -> tuple[Grasp, ...]:
    """Return grasps of an object, those from above first, in its own frame.

    Of a box, cylinder or sphere at its middle; of other shapes, or several, where two surfaces are almost
    opposite. Each occurs twice, the second time turned by half a turn; of flat objects also by the tips of
    the fingers. Grasps wider than the gripper are left out.

    Args:
        force: Of each finger [N]; if None, 30 N, or 1.5 times the object's weight, at most the gripper's.
        reach: Largest overlap of the pads' centres with the object [m]; the gripper's if None.

    Raises:
        ObjectNotFound: If there is none of that id.
        ModelError: If it has no shape, or one of its shapes is a half-space, points or voxels.
    """
    one_of("gripper", gripper, Gripper)
    item = one_of("scene", scene, Scene).object(one_of("name", name, str))
    each_finger = usual_force(scene, name, gripper) if force is None else positive("force", force)
    deepest = gripper.reach if reach is None else positive("reach", reach)
    found: list[Grasp] = []
    for width, pads, label in grips(item, deepest, (gripper.narrowest, gripper.widest - 2.0 * LEAST_SPARE)):
        ways = (pads, label), (pads, f"{label}, turned")
        for back in _short_of_far_side(item, pads, gripper.tips):
            ways = *ways, (back, f"{label}, by the tips"), (back, f"{label}, by the tips, turned")
        for (between, way), half in zip(ways, cycle((np.eye(3), HALF_TURN))):
            found.append(
                Grasp(
                    placement=between * Placement(readonly(half)) * gripper.axes.inverse(),
                    width=width,
                    opening=min(width + 2.0 * SPARE, gripper.widest),
                    force=each_finger,
                    name=way,
                )
            )
    return tuple(found)


def _short_of_far_side(item: SceneObject, pads: Placement, tips: float) -> Iterator[Placement]:
    """Yield the pads drawn back if the tips would reach past the object."""
    boxes = [placed_box(shape, pads.inverse() * where)[:, 2] for shape, where in item.parts]
    near, far = np.min(boxes), np.max(boxes)
    if tips > far:
        back = tips - far + min(LEAST_SPARE, (far - near) / 2.0)
        yield pads * Placement(translation=-back * UPWARD)


def usual_force(scene: Scene, name: str, gripper: Gripper) -> float:
    """Return the force of each finger for an object [N], at most the gripper's."""
    weight = scene.object(name).mass * float(np.linalg.norm(scene.robot.model.gravity.linear))
    return min(max(FORCE, WEIGHTS * weight), gripper.force)


Grip: TypeAlias = tuple[float, Placement, str]
"""The pads' distance [m], their placement in the object (z approach, y closing), and a name."""


def grips(item: SceneObject, reach: float, widths: tuple[float, float]) -> Iterator[Grip]:
    """Yield places of the pads on an object, those from above first, with widths in a range [m].

    Args:
        reach: Largest overlap of the pads' centres with the object [m].

    Raises:
        ModelError: If it has no shape, or one without a surface to hold.
    """
    match item.parts:
        case [(Box(x, y, z), where)]:
            found = _of_box((x, y, z), reach)
        # Only pads that meet at the widest place hold a sphere.
        case [(Sphere(radius), where)] if radius <= reach:
            found = _of_box((2.0 * radius, 2.0 * radius, 2.0 * radius), reach)
        case [(Cylinder() as shape, where)]:
            found = _of_cylinder(shape, reach)
        case []:
            raise ModelError(f"object {shown(item.name)} has no shape; add one to grasp it")
        case parts:
            for shape, _ in parts:
                if isinstance(shape, Plane | Points | Voxels):
                    hull = "" if isinstance(shape, Plane) else "add its convex hull (to.convex), or "
                    raise ModelError(
                        f"no grasps are known of a {type(shape).__name__} (object {shown(item.name)}); "
                        f"{hull}define them yourself"
                    )
            for pads in places_of_pads(parts, item.inertia.lever, reach, widths):
                yield pads.width, _pads(pads.middle, -pads.outward, pads.closing), pads.name
            return
    for width, pads, name in found:
        if widths[0] <= width <= widths[1]:
            yield width, where * pads, name


def _of_cylinder(shape: Cylinder, reach: float) -> Iterator[Grip]:
    diameter = 2.0 * shape.radius
    angles = [2.0 * np.pi * k / AROUND for k in range(AROUND)]
    over = max(shape.length / 2.0 - reach, 0.0)
    for side, label in ((1.0, "+z"), (-1.0, "-z")):
        for angle in angles[: AROUND // 2]:
            closing = np.array((np.cos(angle), np.sin(angle), 0.0))
            grip = _pads(side * over * UPWARD, -side * UPWARD, closing)
            yield diameter, grip, f"from {label}, closing at {np.rad2deg(angle):.0f} degrees"
    if shape.radius > reach:
        return
    for angle in angles:
        outward = np.array((np.cos(angle), np.sin(angle), 0.0))
        grip = _pads(np.zeros(3), -outward, np.cross(UPWARD, outward))
        yield diameter, grip, f"from the side at {np.rad2deg(angle):.0f} degrees"


def _of_box(size: tuple[float, float, float], reach: float) -> Iterator[Grip]:
    for side, outward in zip(SIDES, DIRECTIONS, strict=True):
        across = int(np.argmax(np.abs(outward)))
        over = max(size[across] / 2.0 - reach, 0.0)
        for axis in (axis for axis in range(3) if axis != across):
            grip = _pads(over * outward, -outward, np.eye(3)[axis])
            yield size[axis], grip, f"from {side}, closing along {'xyz'[axis]}"


def _pads(middle: Floats, approach: Floats, closing: Floats) -> Placement:
    axes = np.stack((np.cross(closing, approach), closing, approach), axis=1)
    return Placement(floats("axes", axes, (3, 3)), floats("middle", middle, (3,)))
