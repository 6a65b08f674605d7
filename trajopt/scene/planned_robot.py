"""Protocols of planned motions."""

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, TypeVar, cast, runtime_checkable

import pinocchio as pin

from trajopt.robot.joints import Anchor, FixedBody
from trajopt.values.arrays import Floats, unless_none
from trajopt.values.errors import ProblemError, shown
from trajopt.values.placement import Placement
from trajopt.values.trajectory import Trajectory

Model = TypeVar("Model")
Model_co = TypeVar("Model_co", covariant=True)


@runtime_checkable
class MovingRobot(Protocol):
    """The part of a reduced model that a moving robot needs; see `ReducedModel`."""

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
        """Carrying joint and placement of each frame, object and the world, by name."""
        ...

    @property
    def scene(self) -> "HasObjects":
        """The robot's scene."""
        ...

    def attachment(self, name: str) -> tuple[int, Placement]:
        """Return the joint (0: the world) that carries a frame or object, and its placement there."""
        ...

    def configuration(self, positions: Floats) -> Floats:
        """Return pinocchio's configuration of the group's positions."""
        ...


class HasObjects(Protocol):
    """A scene with objects."""

    @property
    def objects(self) -> Mapping[str, object]:
        """Objects by id."""
        ...


@runtime_checkable
class HasReduced(Protocol[Model_co]):
    """A problem with a reduced model."""

    @property
    def reduced(self) -> Model_co:
        """The robot with only the group's joints free."""
        ...


class PlannedMotion(Protocol[Model_co]):
    """A motion with its problem: a `Plan`."""

    @property
    def problem(self) -> HasReduced[Model_co]:
        """The problem that was planned."""
        ...

    @property
    def trajectory(self) -> Trajectory:
        """The motion."""
        ...


class Planned(Protocol[Model_co]):
    """A plan, or a result that may have one."""

    def require(self) -> PlannedMotion[Model_co]:
        """Return the plan, or raise the reason why there is none."""
        ...


class PlannedWhole(Protocol[Model_co]):
    """Several motions, in order: the result of a task, or of a pick and place."""

    @property
    def whole(self) -> tuple[Model_co, Trajectory]:
        """The robot with all moving joints free, and its motion; objects that it moves are on tracks."""
        ...


def model_and_trajectory(
    caller: str,
    motion: Planned[Model] | PlannedWhole[Model] | Model,
    trajectory: Trajectory | None,
    kind: type[Model],
    argument: str = "motion",
) -> tuple[Model, Trajectory]:
    """Return robot and motion of a plan, of a result, or of a reduced model with a trajectory."""
    unless_none("trajectory", trajectory, Trajectory)
    if isinstance(motion, kind):
        if trajectory is None:
            raise ProblemError(f"{caller}: give a plan, or a trajectory with the reduced model")
        return motion, trajectory
    require: Callable[[], object] = getattr(motion, "require", lambda: None)
    plan = require()
    if isinstance(plan, tuple):
        return cast(PlannedWhole[Model], motion).whole
    if not hasattr(plan, "problem"):
        given, hint = f"{argument} is {shown(motion)}", ""
        if isinstance(motion, HasReduced):
            hint = "; plan it, or draw its start: render(problem, 'start.png')"
        elif hasattr(motion, "objects"):
            hint = "; to look at a scene: trajopt.viewer.live_view(scene, group=...)"
        raise ProblemError(f"{caller}: give a plan, or a result that has one; {given}{hint}")
    plan = cast(PlannedMotion[Model], plan)
    return plan.problem.reduced, plan.trajectory if trajectory is None else trajectory
