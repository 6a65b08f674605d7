"""A robot that moves as planned, by what its tracks need: a plan, or a reduced model with a trajectory."""

from collections.abc import Mapping, Sequence
from typing import Protocol, cast, runtime_checkable

import pinocchio as pin

from trajopt.arrays import Floats, unless_none
from trajopt.errors import ProblemError, shown
from trajopt.model.collisions.bodies import Anchor, FixedBody
from trajopt.model.placement import Placement
from trajopt.model.trajectory import Trajectory


@runtime_checkable
class MovingRobot(Protocol):
    """What a reduced model says of its robot; see there."""

    @property
    def model(self) -> pin.Model:
        """Pinocchio's model of the free joints and of those that mimic them."""
        ...

    @property
    def mimic_matrix(self) -> Floats:
        """Matrix (model joints, n) that maps the group's positions to the model's."""
        ...

    @property
    def mimic_offset(self) -> Floats:
        """Offsets of mimicking joints, shape (model joints,)."""
        ...

    @property
    def bodies(self) -> Sequence[FixedBody]:
        """Collision bodies."""
        ...

    @property
    def anchors(self) -> Mapping[str, Anchor]:
        """Where each frame of the robot, each object and the world is fixed, by name."""
        ...

    @property
    def scene(self) -> "HasObjects":
        """Where the robot is."""
        ...

    def attachment(self, name: str) -> tuple[int, Placement]:
        """Return the joint (0: the world) that carries a frame or object, and where in it."""
        ...

    def configuration(self, positions: Floats) -> Floats:
        """Return pinocchio's configuration of the group's positions."""
        ...


class HasObjects(Protocol):
    """A scene, by its objects."""

    @property
    def objects(self) -> Mapping[str, object]:
        """Objects by id."""
        ...


class HasRobot(Protocol):
    """A problem, by its reduced model."""

    @property
    def reduced(self) -> MovingRobot:
        """The robot with only the group's joints free."""
        ...


class RobotMotion(Protocol):
    """A plan, by its problem and its motion."""

    @property
    def problem(self) -> HasRobot:
        """The problem that was planned."""
        ...

    @property
    def trajectory(self) -> Trajectory:
        """The motion."""
        ...


class PlannedRobot(Protocol):
    """A plan, or a result that may have one."""

    def require(self) -> RobotMotion:
        """Return the plan, or raise the reason why there is none."""
        ...


def robot_and_trajectory(
    caller: str, motion: PlannedRobot | MovingRobot, trajectory: Trajectory | None
) -> tuple[MovingRobot, Trajectory]:
    """Return what moves and how, of a plan or of a reduced model with a trajectory.

    Raises:
        PlanningFailed: If the result has no plan.
        ProblemError: If it is neither, or the trajectory is missing.
    """
    unless_none("trajectory", trajectory, Trajectory)
    if isinstance(motion, MovingRobot):
        if trajectory is None:
            raise ProblemError(f"{caller}: give a plan, or a trajectory with the reduced model")
        return motion, trajectory
    plan: object = motion.require() if hasattr(motion, "require") else None
    if not hasattr(plan, "problem"):
        raise ProblemError(f"{caller}: give a plan, or a result that has one; motion is {shown(motion)}")
    plan = cast(RobotMotion, plan)
    return plan.problem.reduced, plan.trajectory if trajectory is None else trajectory
